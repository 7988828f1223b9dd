//! Who walks along a branch, and what is seen on the way.

use nalgebra::Complex;
use vibrochain_breather::{Branch, Finder, Orbit};

use super::answer::{Event, Search, Unresolved};
use crate::analyser::Analyser;

/// The longest step, in units: the range is one unit, and so is a change of order 1 of the orbit.
pub(super) const LONGEST: f64 = 0.02;

/// The branch, the search along it, and work space.
pub(super) struct Follower {
    pub(super) branch: Branch,
    pub(super) analyser: Analyser,
    pub(super) finder: Finder,
    pub(super) search: Search,
    pub(super) unresolved: Vec<Unresolved>,
    /// Orbits assembled on other branches.
    pub(super) others: usize,
    pub(super) spectra: usize,
}

/// What was seen at a point.
#[derive(Debug, Clone, Default)]
pub(super) struct Observation {
    /// Velocity before each impact, towards its barrier.
    pub(super) velocities: Vec<f64>,
    pub(super) margin: Option<f64>,
    pub(super) equations: f64,
    /// ln|D| and the sign of D, det(A + shift) made regular.
    pub(super) determinant: (f64, f64),
    /// Eigenvalues: μ, or ν of a reversible orbit.
    pub(super) values: Vec<Complex<f64>>,
}

/// The shift s of det(A + s) that shows an event, for those that the spectrum shows; `None` where the orbit's own equations
/// do. A holds μ, or ν of a reversible orbit, which are both ±1 together.
pub(super) fn shift_of(event: Event, orbit: &Orbit) -> Option<f64> {
    match event {
        Event::PeriodDoubling => Some(1.0),
        Event::Pitchfork if orbit.model().is_conservative() => Some(-1.0),
        _ => None,
    }
}
