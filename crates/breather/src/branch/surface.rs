//! A surface: what one orbit draws when two parameters are varied.

use vibrochain_lattice::Parameter;

use crate::equations::linear::{Vector, unit, zeros};
use crate::error::BranchError;
use crate::orbit::Orbit;
use crate::tracer::corrector::Continuation;
use crate::tracer::manifold::{Manifold, ManifoldPoint, NEAR, reach};
use crate::tracer::system::System;

/// A point of a surface.
pub type SurfacePoint = ManifoldPoint<Orbit, 2>;

impl SurfacePoint {
    /// How both parameters change along a direction of the tangents' plane, in their units.
    pub fn heading(&self, direction: [f64; 2]) -> [f64; 2] {
        let combined = combined(&self.tangents, direction);
        let m = combined.len();
        [combined[m - 2], combined[m - 1]]
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
pub type Surface = Manifold<Continuation, 2>;

impl Surface {
    /// The surface of two parameters through an orbit of any word. With each stands its unit, the length along it that counts like a
    /// change of order 1 of the orbit.
    ///
    /// # Errors
    /// [`BranchError::Breather`] at a resonance, which an orbit that exists has already passed.
    pub fn through(orbit: &Orbit, free: [(Parameter, f64); 2]) -> Result<Self, BranchError> {
        Self::of_free(orbit, free)
    }

    /// The orbit that the surface was laid through.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn start(&mut self) -> Result<SurfacePoint, BranchError> {
        let z = self.equations.origin()?;
        // Rows along no axis: at a fold, too, the tangents have components along both.
        let row = |ratio: f64| -> Vector { (0..z.len()).map(|i| 0.5 + (ratio * (i + 1) as f64).fract()).collect() };
        let tangents = self.finish(z.clone(), &[row(0.618), row(0.414)])?.tangents;
        self.correct(&z, &tangents, NEAR, true)
    }

    /// The point at these lengths along both tangents.
    ///
    /// # Errors
    /// [`BranchError`]; a shorter step may succeed.
    pub fn step(&mut self, from: &SurfacePoint, along: [f64; 2]) -> Result<SurfacePoint, BranchError> {
        self.step_along(from, along)
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
        let z = self.equations.newton(&predicted, &rows, reach(along).max(NEAR), false)?;
        let next = self.finish(z, &from.tangents)?;
        self.fitting(from, next)
    }
}

fn combined([one, other]: &[Vector; 2], [a, b]: [f64; 2]) -> Vector {
    let mut sum = zeros(one.len());
    sum.iter_mut().zip(one.iter().zip(other)).for_each(|(sum, (one, other))| *sum = a * one + b * other);
    sum
}
