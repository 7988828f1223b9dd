//! A surface: what one orbit draws when two parameters are varied.
//!
//! With x the unknowns of the orbit's equations F and λ₁, λ₂ the parameters, the surface is F(z) = 0 in z = (x, λ₁, λ₂), each
//! coordinate in its natural unit. From a point z₀ with two orthogonal unit tangents τ₁, τ₂ its points are described by
//!
//! ```text
//! F(z) = 0,     τ₁·(z − z₀) = σ₁,     τ₂·(z − z₀) = σ₂ ,
//! ```
//!
//! which stays regular where the surface folds over the plane of the parameters, and where two folds meet in a cusp.

use vibrochain_lattice::{Parameter, Stop};

use crate::branch::CHORD;
use crate::equations::linear::{Vector, dot, unit, zeros};
use crate::equations::unknowns::Unknowns;
use crate::error::BranchError;
use crate::orbit::Orbit;
use crate::tracer::corrector::Continuation;
use crate::tracer::reduction::Reduction;

/// A point may be this part of the step away from the tangents' plane; farther is another sheet or too long a step.
const BEND: f64 = 0.35;

/// How far from where it was left the orbit of a start may be found, in units.
const NEAR: f64 = 1e-2;

/// A point of a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfacePoint {
    orbit: Orbit,
    /// The free unknowns, then both parameters.
    coordinates: Vector,
    /// Orthogonal, of unit length, in units of the coordinates.
    tangents: [Vector; 2],
    full_determinant: f64,
    fold_determinant: f64,
}

impl SurfacePoint {
    /// The orbit.
    pub fn orbit(&self) -> &Orbit {
        &self.orbit
    }

    /// Values of both parameters.
    pub fn values(&self) -> [f64; 2] {
        let m = self.coordinates.len();
        [self.coordinates[m - 2], self.coordinates[m - 1]]
    }

    /// Determinant of the Jacobian of the orbit's equations, columns in units and rows of length 1: 0 where an orbit under a force has a
    /// multiplier +1.
    pub fn determinant(&self) -> f64 {
        self.full_determinant
    }

    /// The same among orbits of the symmetry that the surface keeps to: 0 where the surface folds over the parameters.
    pub fn fold_determinant(&self) -> f64 {
        self.fold_determinant
    }

    /// How both parameters change along a direction of the tangents' plane, in their units.
    pub fn heading(&self, [one, other]: [f64; 2]) -> [f64; 2] {
        let m = self.coordinates.len();
        let [a, b] = &self.tangents;
        [m - 2, m - 1].map(|i| one * a[i] + other * b[i])
    }
}

/// The surface of orbits in two parameters, to be walked on step by step.
///
/// ```
/// use vibrochain_breather::{Family, Surface, breathers};
/// use vibrochain_lattice::{Chain, Model, Parameter};
/// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.07, 0.8, 0.165, 0.25)?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let mut surface = Surface::through(orbit, [(Parameter::Omega, 1.0), (Parameter::Amplitude, 0.1)])?;
/// let start = surface.start()?;
/// let there = surface.step(&start, [0.01, 0.0])?;
/// // As far as it was sent, and an orbit.
/// assert!((surface.between(&start, &there)[0] - 0.01).abs() < 1e-12 && there.orbit().residual() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Surface {
    equations: Continuation,
}

impl Surface {
    /// The surface of two parameters through an orbit of any word. With each stands its unit, the length along it that counts like a
    /// change of order 1 of the orbit.
    ///
    /// # Errors
    /// [`BranchError::Breather`] at a resonance, which an orbit that exists has already passed.
    pub fn through(orbit: &Orbit, free: [(Parameter, f64); 2]) -> Result<Self, BranchError> {
        let unknowns = Unknowns::of(orbit);
        let reduction = Reduction::of(orbit, &free.map(|(parameter, _)| parameter), &unknowns);
        Ok(Self { equations: Continuation::new(orbit, &free, unknowns, reduction)? })
    }

    /// The same surface, on which no step is made once `stop` is raised.
    #[must_use]
    pub fn until(mut self, stop: &Stop) -> Self {
        self.equations.finder = self.equations.finder.until(stop);
        self
    }

    /// Orbits assembled so far: the cost.
    pub fn evaluations(&self) -> usize {
        self.equations.evaluations
    }

    /// The free parameters.
    pub fn free(&self) -> [Parameter; 2] {
        [self.equations.free[0], self.equations.free[1]]
    }

    /// The orbit that the surface was laid through.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn start(&mut self) -> Result<SurfacePoint, BranchError> {
        let origin = self.equations.origin.clone();
        let z = self.equations.coordinates(&origin)?;
        // Rows along no axis: at a fold, too, the tangents have components along both.
        let row = |ratio: f64| -> Vector { (0..z.len()).map(|i| 0.5 + (ratio * (i + 1) as f64).fract()).collect() };
        let rows = [row(0.618), row(0.414)];
        let tangents = self.tangents(&z, &rows)?;
        self.correct(&z, &tangents, NEAR, true)
    }

    /// The point at these lengths along both tangents.
    ///
    /// # Errors
    /// [`BranchError`]; a shorter step may succeed.
    pub fn step(&mut self, from: &SurfacePoint, along: [f64; 2]) -> Result<SurfacePoint, BranchError> {
        let predicted = self.ahead(from, along);
        let next = self.correct(&predicted, &from.tangents, reach(along), false)?;
        self.fitting(from, next)
    }

    /// The point near those lengths at which one parameter (the first, 0, or the second, 1) has a given value, as far along a direction
    /// `across` as they are.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn step_to(
        &mut self,
        from: &SurfacePoint,
        along: [f64; 2],
        (which, value): (usize, f64),
        across: [f64; 2],
    ) -> Result<SurfacePoint, BranchError> {
        let mut predicted = self.ahead(from, along);
        let (size, place) = (predicted.len(), predicted.len() - 2 + which.min(1));
        predicted[place] = value;
        let rows = [unit(size, place), combined(&from.tangents, across)];
        let rows = [rows[0].as_slice(), rows[1].as_slice()];
        let z = self.equations.newton(&predicted, &rows, reach(along).max(NEAR), false)?;
        let next = self.finish(z, &from.tangents)?;
        self.fitting(from, next)
    }

    /// Where `to` lies from `from`: lengths along both tangents there.
    pub fn between(&self, from: &SurfacePoint, to: &SurfacePoint) -> [f64; 2] {
        let chord = self.equations.chord(&from.coordinates, &to.coordinates);
        [dot(&from.tangents[0], &chord), dot(&from.tangents[1], &chord)]
    }

    /// How far apart two points are, in units of the coordinates.
    pub fn distance(&self, from: &SurfacePoint, to: &SurfacePoint) -> f64 {
        let chord = self.equations.chord(&from.coordinates, &to.coordinates);
        dot(&chord, &chord).sqrt()
    }

    fn ahead(&self, from: &SurfacePoint, along: [f64; 2]) -> Vector {
        let moved = combined(&from.tangents, along);
        let moved = moved.iter().zip(&self.equations.units).zip(&from.coordinates);
        moved.map(|((moved, unit), z)| z + moved * unit).collect()
    }

    fn correct(
        &mut self,
        predicted: &[f64],
        tangents: &[Vector; 2],
        reach: f64,
        known: bool,
    ) -> Result<SurfacePoint, BranchError> {
        let rows = [tangents[0].as_slice(), tangents[1].as_slice()];
        let z = self.equations.newton(predicted, &rows, reach, known)?;
        self.finish(z, tangents)
    }

    /// The point at `z`, with tangents as near to others as can be.
    fn finish(&mut self, z: Vector, near: &[Vector; 2]) -> Result<SurfacePoint, BranchError> {
        let tangents = self.tangents(&z, near)?;
        let here = self.equations.evaluate(&z)?;
        let (full_determinant, fold_determinant) = (here.full_determinant, here.matrix.determinant());
        Ok(SurfacePoint { orbit: here.orbit, coordinates: z, tangents, full_determinant, fold_determinant })
    }

    /// Orthogonal unit vectors along which F stays as it is, by two rows that are not orthogonal to them.
    fn tangents(&mut self, z: &[f64], rows: &[Vector; 2]) -> Result<[Vector; 2], BranchError> {
        let here = self.equations.evaluate(z)?;
        let bordered = self.equations.bordered(z, &here, &[&rows[0], &rows[1]])?;
        let size = z.len();
        let solved = |place: usize| bordered.solve(&unit(size, place)).ok_or(BranchError::NoConvergence);
        let (first, second) = (normed(solved(size - 2)?), solved(size - 1)?);
        let share = dot(&first, &second);
        let second = second.iter().zip(&first).map(|(second, first)| second - share * first).collect();
        Ok([first, normed(second)])
    }

    /// `next` if it is on the sheet of `from`, as far as the two points can tell: the chord lies in the mean of both tangent planes.
    fn fitting(&self, from: &SurfacePoint, next: SurfacePoint) -> Result<SurfacePoint, BranchError> {
        let chord = self.equations.chord(&from.coordinates, &next.coordinates);
        let mut apart = chord.clone();
        for tangent in from.tangents.iter().chain(&next.tangents) {
            let along = 0.5 * dot(tangent, &chord);
            apart.iter_mut().zip(tangent).for_each(|(apart, tangent)| *apart -= along * tangent);
        }
        let norm = dot(&chord, &chord).sqrt();
        let fits = apart.iter().all(|x| x.abs() <= CHORD * norm + 1e-9);
        if fits { Ok(next) } else { Err(BranchError::NoConvergence) }
    }
}

/// How far from the tangents' plane a step may end.
fn reach([one, other]: [f64; 2]) -> f64 {
    BEND * one.hypot(other) + 1e-9
}

fn combined([one, other]: &[Vector; 2], [a, b]: [f64; 2]) -> Vector {
    let mut sum = zeros(one.len());
    sum.iter_mut().zip(one.iter().zip(other)).for_each(|(sum, (one, other))| *sum = a * one + b * other);
    sum
}

fn normed(vector: Vector) -> Vector {
    let norm = dot(&vector, &vector).sqrt();
    vector.iter().map(|x| x / norm).collect()
}
