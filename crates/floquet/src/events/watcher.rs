//! Who looks at orbits along a branch or a curve.

use nalgebra::Complex;
use vibrochain_breather::Admissibility;

use super::orbit::EventOrbit;
use crate::locate::LocateError;
use crate::verdict::{Tolerance, Verdict};

/// A contact no farther beyond a barrier than this part of what it moves by touches it.
pub(crate) const TOUCHES: f64 = 1e-9;

/// An orbit whose impulses have grown by this factor is on its way to infinity.
pub(crate) const UNBOUNDED: f64 = 1e4;

/// Multipliers, and the verdict if it comes with them.
pub(crate) type Spectrum = (Vec<Complex<f64>>, Option<Verdict>);

/// Looks at orbits.
pub(crate) trait Watcher {
    /// Of this kind.
    type Orbit: EventOrbit;
    /// Impulses this small, against the first, are on their way to none.
    const FAINT: f64;

    /// Whether an orbit is physical, and what is nearest to a barrier.
    fn admissibility(&mut self, orbit: &Self::Orbit) -> Result<Admissibility, LocateError>;
    /// Multipliers of the modes that feel the impacts; without losses ν = ½(μ + 1/μ) of each pair.
    fn spectrum(&mut self, orbit: &Self::Orbit, tolerance: Tolerance) -> Result<Spectrum, LocateError>;
    /// The verdict.
    fn verdict(&mut self, orbit: &Self::Orbit, tolerance: Tolerance) -> Result<Verdict, LocateError>;
    /// What impulses are compared to.
    fn strength(&self, orbit: &Self::Orbit) -> f64;
    /// Spectra worked out.
    fn spectra(&self) -> usize;
}

/// The largest impulse of an orbit.
pub(crate) fn strongest(orbit: &impl EventOrbit) -> f64 {
    orbit.arrivals().iter().map(|arrival| arrival.impulse.abs()).fold(0.0, f64::max)
}
