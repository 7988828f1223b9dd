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
pub(crate) mod resonances;

use vibrochain_lattice::{Parameter, Stop};

use crate::branch_error::BranchError;
use crate::equations::linear::unit;
use crate::equations::unknowns::Unknowns;
use crate::orbit::Orbit;
use crate::tracer::corrector::Continuation;
use crate::tracer::reduction::Reduction;
use crate::tracer::solution_curve::{SolutionCurve, SolutionPoint, normed};
use crate::tracer::system::System;

/// A point of a branch.
pub(crate) type BranchPoint = SolutionPoint<Orbit>;

/// One branch, to be followed step by step.
pub(crate) type Branch = SolutionCurve<Continuation>;

impl Branch {
    /// The same, along which no step is made once `stop` is raised.
    #[must_use]
    pub(crate) fn until(mut self, stop: &Stop) -> Self {
        self.equations.finder = self.equations.finder.until(stop);
        self
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
}
