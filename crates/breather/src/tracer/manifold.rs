//! Orbits over N free parameters: a curve of one.
//!
//! With x the unknowns of the orbit's equations F and λ the parameters, they are F(z) = 0 in z = (x, λ), each coordinate in its natural
//! unit. From a point z₀ with N orthogonal unit tangents τ the others are described by the lengths σ along them,
//!
//! ```text
//! F(z) = 0,     τ_k·(z − z₀) = σ_k ,
//! ```
//!
//! which stays regular where the orbits fold over the parameters, and where two folds meet in a cusp.

use std::array::from_fn;

use crate::equations::linear::{Matrix, Vector, dot, unit};
use crate::error::BranchError;
use crate::tracer::system::System;

/// A chord may depart from the mean of the tangents at its ends by this part of its length: that of an arc of a fifth of a radian. One
/// that leads to other orbits does not fit the tangents.
const CHORD: f64 = 0.01;

/// A point may be this part of the step away from where the tangents pointed; farther is another orbit or too long a step.
const BEND: f64 = 0.35;

/// Lengths as short as this are rounding.
const ROUNDING: f64 = 1e-9;

/// How far an orbit may be found from where it is expected without a step, in units.
pub(crate) const NEAR: f64 = 1e-2;

/// An orbit, and how others lie about it.
#[derive(Debug, Clone, PartialEq)]
pub struct ManifoldPoint<O, const N: usize> {
    pub(crate) orbit: O,
    /// The free unknowns, then the parameters.
    pub(crate) coordinates: Vector,
    /// Orthogonal, of unit length, in units of the coordinates.
    pub(crate) tangents: [Vector; N],
    pub(crate) determinant: f64,
    pub(crate) fold_determinant: f64,
    /// Sign of the determinant of ∂F/∂z bordered by the tangents: constant along a curve without branch points, and different
    /// on branches that are neighbours at one value of the parameter.
    pub(crate) orientation: f64,
}

impl<O, const N: usize> ManifoldPoint<O, N> {
    /// The orbit.
    pub fn orbit(&self) -> &O {
        &self.orbit
    }

    /// The unknowns, then the parameters.
    pub fn coordinates(&self) -> &[f64] {
        &self.coordinates
    }

    /// Along the curve or surface, orthogonal and of unit length, in units of the coordinates.
    pub fn tangents(&self) -> &[Vector; N] {
        &self.tangents
    }

    /// Values of the free parameters.
    pub fn values(&self) -> [f64; N] {
        let size = self.coordinates.len();
        from_fn(|i| self.coordinates[size - N + i])
    }

    /// Determinant of the Jacobian of the orbit's equations, columns in units and rows of length 1: 0 where an orbit under a force has a
    /// multiplier +1.
    pub fn determinant(&self) -> f64 {
        self.determinant
    }

    /// The same among orbits of the symmetry that is kept to: 0 where the orbits fold over the parameters.
    pub fn fold_determinant(&self) -> f64 {
        self.fold_determinant
    }
}

/// The solutions of one system over N parameters, to be followed step by step: a [`Branch`](crate::Branch)
/// or a [`StructureBranch`](crate::StructureBranch).
#[derive(Debug, Clone)]
pub struct Manifold<S, const N: usize> {
    pub(crate) equations: S,
}

type Point<S, const N: usize> = ManifoldPoint<<S as System>::Orbit, N>;

impl<S: System, const N: usize> Manifold<S, N> {
    /// The solutions of a system.
    pub fn of(equations: S) -> Self {
        Self { equations }
    }

    /// The system.
    pub fn system(&mut self) -> &mut S {
        &mut self.equations
    }

    /// Orbits assembled so far: the cost.
    pub fn evaluations(&self) -> usize {
        self.equations.evaluations()
    }

    /// How far apart two points are, in units of the coordinates.
    pub fn distance(&self, from: &Point<S, N>, to: &Point<S, N>) -> f64 {
        norm(&self.equations.chord(&from.coordinates, &to.coordinates))
    }

    /// Where `to` lies from `from`: lengths along the tangents there.
    pub fn between(&self, from: &Point<S, N>, to: &Point<S, N>) -> [f64; N] {
        let chord = self.equations.chord(&from.coordinates, &to.coordinates);
        from_fn(|k| dot(&from.tangents[k], &chord))
    }

    /// From a point to other coordinates, in units.
    pub fn chord_to(&self, from: &Point<S, N>, to: &[f64]) -> Vector {
        self.equations.chord(&from.coordinates, to)
    }

    /// These lengths along the tangents at a point.
    pub fn ahead(&self, from: &Point<S, N>, along: [f64; N]) -> Vector {
        let mut z = from.coordinates.clone();
        for (tangent, length) in from.tangents.iter().zip(along) {
            z.iter_mut().zip(tangent).zip(self.equations.units()).for_each(|((z, x), unit)| *z += length * x * unit);
        }
        z
    }

    /// The point at these lengths along the tangents. It is on the sheet of `from` as far as the two can tell.
    pub(crate) fn step_along(&mut self, from: &Point<S, N>, along: [f64; N]) -> Result<Point<S, N>, BranchError> {
        let next = self.correct(&self.ahead(from, along), &from.tangents, reach(along), false)?;
        self.fitting(from, next)
    }

    /// The point near `predicted`, across these directions. `known` says that this is an orbit itself.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn correct(
        &mut self,
        predicted: &[f64],
        directions: &[Vector; N],
        reach: f64,
        known: bool,
    ) -> Result<Point<S, N>, BranchError> {
        let z = self.equations.newton(predicted, directions, reach, known)?;
        self.finish(z, directions)
    }

    /// The point at `z`, with tangents that go the way these directions do.
    pub(crate) fn finish(&mut self, z: Vector, directions: &[Vector; N]) -> Result<Point<S, N>, BranchError> {
        let here = self.equations.evaluate(&z)?;
        let mut bordered = self.equations.bordered(&z, &here, directions)?;
        let mut tangents: [Vector; N] = from_fn(|_| Vector::new());
        let first = z.len() - N;
        for k in 0..N {
            let mut tangent = bordered.solve(&unit(z.len(), first + k)).ok_or(BranchError::NoConvergence)?;
            for before in &tangents[..k] {
                let share = dot(before, &tangent);
                tangent.iter_mut().zip(before).for_each(|(x, before)| *x -= share * before);
            }
            tangents[k] = normed(tangent);
        }
        for (k, tangent) in tangents.iter().enumerate() {
            bordered.row_mut(first + k).copy_from_slice(tangent);
        }
        let fold_determinant = here.matrix.determinant();
        Ok(ManifoldPoint {
            determinant: here.full.as_ref().map_or(fold_determinant, Matrix::determinant),
            fold_determinant,
            orbit: here.orbit,
            coordinates: z,
            tangents,
            orientation: bordered.determinant().signum(),
        })
    }

    /// `next` if the chord that leads there lies in the mean of the tangents' planes at both ends.
    pub(crate) fn fitting(&self, from: &Point<S, N>, next: Point<S, N>) -> Result<Point<S, N>, BranchError> {
        let chord = self.equations.chord(&from.coordinates, &next.coordinates);
        let mut apart = chord.clone();
        for tangent in from.tangents.iter().chain(&next.tangents) {
            let along = 0.5 * dot(tangent, &chord);
            apart.iter_mut().zip(tangent).for_each(|(apart, tangent)| *apart -= along * tangent);
        }
        let most = CHORD * norm(&chord) + ROUNDING;
        if apart.iter().all(|x| x.abs() <= most) { Ok(next) } else { Err(BranchError::NoConvergence) }
    }
}

/// How far from where the tangents pointed a step may end.
pub(crate) fn reach<const N: usize>(along: [f64; N]) -> f64 {
    BEND * norm(&along) + ROUNDING
}

fn norm(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}

pub(crate) fn normed(mut vector: Vector) -> Vector {
    let norm = norm(&vector);
    vector.iter_mut().for_each(|x| *x /= norm);
    vector
}
