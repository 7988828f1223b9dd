//! Impacts, and when two of them are one.

use vibrochain_lattice::Barrier;

/// Impacts closer than this part of the period are at one instant: farther apart than rounding of their times, nearer than anything
/// that happens between two of them.
pub(crate) const SIMULTANEOUS: f64 = 1e-9;

/// The time between two instants of an orbit that repeats itself: half a period at most, in the unit of the arguments.
///
/// ```
/// assert!((vibrochain_breather::time_between(0.5, 5.75, 6.0) - 0.75).abs() < 1e-15);
/// ```
pub fn time_between(one: f64, other: f64, period: f64) -> f64 {
    let ahead = (one - other).rem_euclid(period);
    ahead.min(period - ahead)
}

/// One impact of an orbit: of a lattice dimensionless, of any other structure in units of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Impact {
    /// The mass that hits; of a structure the number of the contact.
    pub site: usize,
    /// The barrier it hits.
    pub barrier: Barrier,
    /// Time within the orbit's period, 0 ≤ t < period.
    pub time: f64,
    /// Momentum P the barrier gives to the mass, signed (the paper's 2p₁, −2p₂).
    pub impulse: f64,
    /// Velocity just before, −P/(m(1+e)), with m = 1 of a mass of a lattice.
    pub velocity_before: f64,
    /// Velocity just after, eP/(m(1+e)).
    pub velocity_after: f64,
    /// Acceleration just before, force included. Where nothing damps the motion, the impact does not change it.
    pub acceleration: f64,
}

impl Impact {
    /// An impact is right-signed if the mass moves outward, towards its barrier, before it.
    pub fn is_right_signed(&self) -> bool {
        self.velocity_before * self.barrier.sign() > 0.0
    }
}

/// An impact as it is given: the rest of [`Impact`] follows.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
pub struct Hit {
    /// The mass that hits.
    pub site: usize,
    /// The barrier it hits.
    pub barrier: Barrier,
    /// Time within the orbit's period.
    pub time: f64,
    /// Momentum that the barrier gives to the mass, signed.
    pub impulse: f64,
}

impl Hit {
    /// An impact of mass `site` on `barrier`.
    pub fn new(site: usize, barrier: Barrier, time: f64, impulse: f64) -> Self {
        Self { site, barrier, time, impulse }
    }
}

impl From<&Impact> for Hit {
    fn from(impact: &Impact) -> Self {
        Self::new(impact.site, impact.barrier, impact.time, impact.impulse)
    }
}
