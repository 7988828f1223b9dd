//! A branch: the curve that one orbit draws when one parameter is varied.
//!
//! With x the unknowns of the orbit's equations F (`equations`) and λ the parameter, the branch is the curve F(x, λ) = 0 in
//! z = (x, λ), each coordinate in its natural unit. From a point z₀ with unit tangent τ the curve is described by the
//! length σ along the tangent,
//!
//! ```text
//! F(z) = 0,     τ·(z − z₀) = σ ,
//! ```
//!
//! which stays regular where the branch turns back in λ (a fold: ∂F/∂x is singular, the bordered matrix is not). The
//! fold itself is F = 0 and det ∂F/∂x = 0.
//!
//! On a branch of symmetric orbits (double-sided, φ = T/2) asymmetric ones branch off where ∂F/∂x is singular in a direction
//! that breaks the symmetry. There the curve is followed among symmetric orbits alone ([`Reduction`]), so that it passes
//! through regularly, while the determinant of all equations tells of the pitchfork.

pub(crate) mod at_resonance;
pub(crate) mod departure;
pub(crate) mod resonances;

use vibrochain_lattice::{Parameter, Stop};

use crate::equations::linear::unit;
use crate::equations::unknowns::Unknowns;
use crate::error::BranchError;
use crate::orbit::Orbit;
use crate::tracer::corrector::Continuation;
use crate::tracer::reduction::Reduction;
use crate::tracer::solution_curve::{SolutionCurve, SolutionPoint, normed};
use crate::tracer::system::System;

/// A point of a branch.
pub type BranchPoint = SolutionPoint<Orbit>;

/// One branch, to be followed step by step.
///
/// ```
/// use vibrochain_breather::{Branch, Family, breathers};
/// use vibrochain_lattice::{Chain, Model, Parameter, Point};
/// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
/// let model = ring.omega(1.07).asymmetry(0.8).amplitude(0.165).restitution(0.25).model()?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let mut branch = Branch::through(orbit, Parameter::Amplitude, 0.1)?;
/// // Downwards the branch turns back at a fold, 0.157927…
/// let mut point = branch.start()?.reversed();
/// let mut least = point.value();
/// while point.heading() < 0.0 {
///     point = branch.step(&point, 0.02)?;
///     least = least.min(point.value());
/// }
/// assert!((least - 0.15793).abs() < 1e-4 && point.heading() > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Branch = SolutionCurve<Continuation>;

impl Branch {
    /// The same, along which no step is made once `stop` is raised.
    #[must_use]
    pub fn until(mut self, stop: &Stop) -> Self {
        self.equations.finder = self.equations.finder.until(stop);
        self
    }

    /// The branch of `free` through an orbit of any word. `unit` is the length along the parameter that counts like a change
    /// of order 1 of the orbit.
    ///
    /// # Errors
    /// [`BranchError::Breather`] at a resonance, which an orbit that exists has already passed.
    pub fn through(orbit: &Orbit, free: Parameter, unit: f64) -> Result<Self, BranchError> {
        let unknowns = Unknowns::of(orbit);
        Self::with(orbit, (free, unit), unknowns, Reduction::of(orbit, &[free], &unknowns))
    }

    /// The free parameter.
    pub fn free(&self) -> Parameter {
        self.equations.free[0]
    }

    /// The branch of a word among orbits with all the symmetry that the impacts of `orbit` have: it passes the points where others
    /// branch off that lack it.
    pub(crate) fn of_symmetric(orbit: &Orbit, free: Parameter, unit: f64) -> Result<Self, BranchError> {
        let unknowns = Unknowns::of(orbit);
        Self::with(orbit, (free, unit), unknowns, Reduction::of_word(orbit, &unknowns))
    }

    /// In these unknowns.
    pub(crate) fn with(
        orbit: &Orbit,
        free: (Parameter, f64),
        unknowns: Unknowns,
        reduction: Reduction,
    ) -> Result<Self, BranchError> {
        Ok(Self::of(Continuation::new(orbit, &[free], unknowns, reduction)?))
    }

    /// The same point, with impulses measured by what they are there from here on: of a branch along which they grow without bound,
    /// equal steps are then equal factors, where they would be equal differences for ever.
    pub(crate) fn rescaled(&mut self, point: BranchPoint) -> BranchPoint {
        let before = self.equations.units.clone();
        self.equations.rescale(&point.orbit);
        let own = before.iter().zip(&self.equations.units);
        let tangent = point.tangent.iter().zip(own).map(|(x, (before, now))| x * before / now);
        BranchPoint { tangent: normed(tangent.collect()), ..point }
    }

    /// The orbit of the branch at the parameter of the one it was made with, which is only near it.
    pub(crate) fn nearby(&mut self, reach: f64) -> Result<Orbit, BranchError> {
        let z = self.equations.origin()?;
        let fixed = unit(z.len(), z.len() - 1);
        let z = self.equations.newton(&z, Some(&fixed), reach, false)?;
        Ok(self.equations.evaluate(&z)?.orbit)
    }

    /// Number of masses.
    pub fn sites(&self) -> usize {
        self.equations.origin.model().chain().sites()
    }
}
