//! The solutions of a system over one free parameter: a branch of orbits, or over two a curve of an event.
//!
//! With x the unknowns of the equations F and λ the parameter, they are F(z) = 0 in z = (x, λ), each coordinate in its natural unit. From a point z₀
//! with unit tangent τ the others are described by the length σ along it,
//!
//! ```text
//! F(z) = 0,     τ·(z − z₀) = σ ,
//! ```
//!
//! which stays regular where the curve turns back in λ (a fold: ∂F/∂x is singular, the bordered matrix is not).

use crate::branch_error::BranchError;
use crate::equations::linear::{Matrix, Vector, dot, unit};
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

/// A solution, and how others lie about it.
#[derive(Debug, Clone, PartialEq)]
pub struct SolutionPoint<O> {
    pub(crate) orbit: O,
    /// The free unknowns, then the parameter.
    pub(crate) coordinates: Vector,
    /// Of unit length, in units of the coordinates.
    pub(crate) tangent: Vector,
    pub(crate) determinant: f64,
    pub(crate) fold_determinant: f64,
    /// Sign of the determinant of ∂F/∂z bordered by the tangent: constant along a curve without branch points, and different
    /// on branches that are neighbours at one value of the parameter.
    pub(crate) orientation: f64,
}

impl<O> SolutionPoint<O> {
    /// The orbit.
    pub fn orbit(&self) -> &O {
        &self.orbit
    }

    /// The unknowns, then the parameter.
    pub fn coordinates(&self) -> &[f64] {
        &self.coordinates
    }

    /// Along the curve, of unit length, in units of the coordinates.
    pub fn tangent(&self) -> &Vector {
        &self.tangent
    }

    /// Value of the free parameter.
    pub fn value(&self) -> f64 {
        self.coordinates[self.coordinates.len() - 1]
    }

    /// Component of the unit tangent along the parameter; it changes sign at a fold.
    pub fn heading(&self) -> f64 {
        self.tangent[self.tangent.len() - 1]
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

impl<O: Clone> SolutionPoint<O> {
    /// The same point, with the curve to be followed the other way.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let tangent = self.tangent.iter().map(|x| -x).collect();
        Self { tangent, orientation: -self.orientation, ..self.clone() }
    }
}

/// The solutions of one system over one parameter, to be followed step by step: a [`Branch`](crate::Branch),
/// or the curve of an event.
#[derive(Debug, Clone)]
pub struct SolutionCurve<S> {
    pub(crate) equations: S,
}

type Point<S> = SolutionPoint<<S as System>::Orbit>;

impl<S: System> SolutionCurve<S> {
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

    /// The orbit that the curve was started from, heading towards larger parameters.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn start(&mut self) -> Result<Point<S>, BranchError> {
        let z = self.equations.origin()?;
        self.correct(&z, &unit(z.len(), z.len() - 1), NEAR, true)
    }

    /// The point `length` along the tangent at `from`; negative lengths go back. No branch point lies between the two, as far as they can tell.
    ///
    /// # Errors
    /// [`BranchError`]; a shorter step may succeed.
    pub fn step(&mut self, from: &Point<S>, length: f64) -> Result<Point<S>, BranchError> {
        let next = self.leap(from, length)?;
        self.continued(from, next)
    }

    /// The same, be there a branch point between or not.
    pub(crate) fn leap(&mut self, from: &Point<S>, length: f64) -> Result<Point<S>, BranchError> {
        let reach = BEND * length.abs() + ROUNDING;
        let next = self.correct(&self.ahead(from, length), &from.tangent, reach, false)?;
        self.fitting(from, next)
    }

    /// The point of the curve with the given parameter, near `from`, heading on as there.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn at(&mut self, from: &Point<S>, value: f64) -> Result<Point<S>, BranchError> {
        let (heading, last) = (from.heading(), from.coordinates.len() - 1);
        if heading == 0.0 {
            return Err(BranchError::NoConvergence);
        }
        // Along the tangent to the parameter asked for, and from there at that parameter.
        let mut z = self.ahead(from, (value - from.value()) / self.equations.units()[last] / heading);
        z[last] = value;
        let mut direction = unit(z.len(), last);
        direction[last] = heading.signum();
        let next = self.correct(&z, &direction, NEAR, false)?;
        let next = self.fitting(from, next)?;
        self.continued(from, next)
    }

    /// The point near `predicted`, across this direction. `known` says that this is a solution itself.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn correct(
        &mut self,
        predicted: &[f64],
        direction: &Vector,
        reach: f64,
        known: bool,
    ) -> Result<Point<S>, BranchError> {
        let z = self.equations.newton(predicted, Some(direction), reach, known)?;
        let here = self.equations.evaluate(&z)?;
        let mut bordered = self.equations.bordered(&z, &here, Some(direction))?;
        let last = z.len() - 1;
        let tangent = normed(bordered.solve(&unit(z.len(), last)).ok_or(BranchError::NoConvergence)?);
        bordered.row_mut(last).copy_from_slice(&tangent);
        let fold_determinant = here.matrix.determinant();
        Ok(SolutionPoint {
            determinant: here.full.as_ref().map_or(fold_determinant, Matrix::determinant),
            fold_determinant,
            orbit: here.orbit,
            coordinates: z,
            tangent,
            orientation: bordered.determinant().signum(),
        })
    }

    /// `next` if the chord that leads there lies along the mean of the tangents at both ends.
    fn fitting(&self, from: &Point<S>, next: Point<S>) -> Result<Point<S>, BranchError> {
        let chord = self.chord_to(from, &next.coordinates);
        let mut apart = chord.clone();
        for tangent in [&from.tangent, &next.tangent] {
            let along = 0.5 * dot(tangent, &chord);
            apart.iter_mut().zip(tangent).for_each(|(apart, tangent)| *apart -= along * tangent);
        }
        let most = CHORD * norm(&chord) + ROUNDING;
        if apart.iter().all(|x| x.abs() <= most) { Ok(next) } else { Err(BranchError::NoConvergence) }
    }

    /// `next` if no branch point lies between it and `from`, as far as the two can tell.
    fn continued(&self, from: &Point<S>, next: Point<S>) -> Result<Point<S>, BranchError> {
        let turned = from.orientation * next.orientation < 0.0;
        let places = ((&from.orbit, from.value()), (&next.orbit, next.value()));
        if !turned || self.equations.may_turn(places.0, places.1) { Ok(next) } else { Err(BranchError::NoConvergence) }
    }

    /// This length along the tangent at a point.
    pub fn ahead(&self, from: &Point<S>, length: f64) -> Vector {
        let along = from.tangent.iter().zip(self.equations.units()).map(|(x, unit)| length * x * unit);
        from.coordinates.iter().zip(along).map(|(z, along)| z + along).collect()
    }

    /// From a point to other coordinates, in units.
    pub fn chord_to(&self, from: &Point<S>, to: &[f64]) -> Vector {
        self.equations.chord(&from.coordinates, to)
    }

    /// How far apart two points are, in units of the coordinates.
    pub fn distance(&self, from: &Point<S>, to: &Point<S>) -> f64 {
        norm(&self.chord_to(from, &to.coordinates))
    }

    /// The length at which `to` lies from `from`, along the tangent there.
    pub fn length_between(&self, from: &Point<S>, to: &Point<S>) -> f64 {
        self.length_to(from, &to.coordinates)
    }

    /// The same of other coordinates.
    pub fn length_to(&self, from: &Point<S>, to: &[f64]) -> f64 {
        dot(&from.tangent, &self.chord_to(from, to))
    }
}

fn norm(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}

pub(crate) fn normed(mut vector: Vector) -> Vector {
    let norm = norm(&vector);
    vector.iter_mut().for_each(|x| *x /= norm);
    vector
}
