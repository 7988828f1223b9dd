//! The room between a mass's barriers, and where a mass is nearest to one, as far as that is looked for.

use vibrochain_lattice::{Barrier, Contact};

/// How far to look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Depth {
    /// To the worst obstruction.
    Worst,
    /// To the first one.
    First,
}

/// Closer approaches than this are not told apart: it is the rounding of a displacement of order 1.
pub(crate) const RESOLUTION: f64 = 8.0 * f64::EPSILON;

/// Closest approaches that differ by less than this, relative to them beyond the size of the gap, are alike but for rounding of the orbit itself.
const ALIKE: f64 = 64.0 * f64::EPSILON;

/// Where a mass may be: no farther than `half` from `centre`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gap {
    pub(crate) centre: f64,
    pub(crate) half: f64,
}

impl Gap {
    /// That of each mass of a chain.
    pub(crate) fn around(asymmetry: f64) -> Self {
        Self { centre: asymmetry, half: 1.0 }
    }

    /// That of a contact, seen from where it is `still`, which goes no farther than `excursion` from there: beyond that a barrier that is not there may
    /// as well be.
    pub(crate) fn of(contact: &Contact, still: f64, excursion: f64) -> Self {
        let far = |stop: f64| 2.0 * (excursion + (stop - still).abs());
        match (contact.lower, contact.upper) {
            (Some(lower), Some(upper)) => {
                Self { centre: 0.5 * ((lower - still) + (upper - still)), half: 0.5 * (upper - lower) }
            }
            (Some(lower), None) => Self { centre: lower - still + far(lower), half: far(lower) },
            (None, Some(upper)) => Self { centre: upper - still - far(upper), half: far(upper) },
            (None, None) => Self { centre: 0.0, half: f64::INFINITY },
        }
    }

    /// From the nearer barrier.
    pub(crate) fn distance(self, displacement: f64) -> f64 {
        self.half - (displacement - self.centre).abs()
    }
}

/// The closest approach so far.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Closest {
    pub(crate) distance: f64,
    pub(crate) site: usize,
    pub(crate) barrier: Barrier,
    pub(crate) time: f64,
}

impl Closest {
    /// Before any is known.
    pub(crate) const NONE: Self = Self { distance: f64::INFINITY, site: 0, barrier: Barrier::Lower, time: 0.0 };

    /// Takes note of a mass at one place; its distances to both barriers count.
    pub(crate) fn note(&mut self, gap: Gap, site: usize, time: f64, displacement: f64) {
        for barrier in [Barrier::Lower, Barrier::Upper] {
            let distance = gap.half - (displacement - gap.centre) * barrier.sign();
            self.note_distance(distance, gap.half, (site, barrier), time);
        }
    }

    /// Takes note of a distance to a barrier, half of whose gap is so large.
    pub(crate) fn note_distance(&mut self, distance: f64, half: f64, (site, barrier): (usize, Barrier), time: f64) {
        if distance < self.distance - ALIKE * distance.abs().max(half) || self.distance == f64::INFINITY {
            *self = Self { distance, site, barrier, time };
        } else {
            // Approaches that a symmetry makes alike differ by rounding: the first one is told.
            self.distance = self.distance.min(distance);
        }
    }
}
