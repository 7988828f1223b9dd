//! Who looks at orbits along a curve.

use nalgebra::Complex;
use vibrochain_breather::Admissibility;

use crate::events::EventOrbit;

/// A contact no farther beyond a barrier than this part of what it moves by touches it.
pub(crate) const TOUCHES: f64 = 1e-9;

/// An orbit whose impulses have grown by this factor is on its way to infinity.
pub(crate) const UNBOUNDED: f64 = 1e4;

/// Looks at orbits.
pub(crate) trait Watcher {
    /// Of this kind.
    type Orbit: EventOrbit;
    /// Impulses this small, against the first, are on their way to none.
    const FAINT: f64;

    /// Whether an orbit is physical, and what is nearest to a barrier.
    fn admissibility(&mut self, orbit: &Self::Orbit) -> Option<Admissibility>;
    /// Multipliers of the modes that feel the impacts; without losses ν = ½(μ + 1/μ) of each pair.
    fn values(&mut self, orbit: &Self::Orbit) -> Option<Vec<Complex<f64>>>;
    /// What impulses are compared to.
    fn strength(&self, orbit: &Self::Orbit) -> f64;
    /// Eigenvalue problems solved.
    fn spectra(&self) -> usize;
}

/// The largest impulse of an orbit.
pub(crate) fn strongest(orbit: &impl EventOrbit) -> f64 {
    orbit.arrivals().iter().map(|arrival| arrival.impulse.abs()).fold(0.0, f64::max)
}
