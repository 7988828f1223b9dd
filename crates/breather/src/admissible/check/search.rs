//! The search for where masses of a lattice, or contacts of any structure, come nearest to their barriers.

use smallvec::SmallVec;
use vibrochain_lattice::simd::lanes::Lane;
use vibrochain_lattice::{Barrier, Stop};

use crate::admissible::answer::Obstruction;
use crate::admissible::gap::{Closest, Depth};
use crate::orbit::{Impact, SIMULTANEOUS, time_between};

/// Lists of a search, in the same memory from one to the next.
#[derive(Debug, Clone, Default)]
pub(crate) struct Lists {
    pub(super) pending: Vec<(f64, f64)>,
    /// Contacts where windows begin and end.
    pub(super) rows: Vec<Lane>,
}

/// A search along an orbit, as far as it has come.
pub(crate) struct Search<'a> {
    impacts: &'a [Impact],
    period: f64,
    /// Barriers of a mass or contact, the lower one first.
    stops: &'a dyn Fn(usize) -> [Option<f64>; 2],
    /// Whether an impact may jerk others than the mass that is hit: they have a corner there.
    pub(super) has_corners: bool,
    /// For how long after each impact its contact is surely off its barrier; nothing where velocities tell.
    clear: SmallVec<[f64; 4]>,
    pub(super) depth: Depth,
    pub(super) stop: &'a Stop,
    pub(super) lists: &'a mut Lists,
    pub(crate) closest: Closest,
}

/// What keeps impacts from being those of an orbit, if one pulls.
pub(crate) fn wrong_sign(impacts: &[Impact]) -> Option<Obstruction> {
    let (impact, wrong) = impacts.iter().enumerate().find(|(_, impact)| !impact.is_right_signed())?;
    let (site, time, velocity_before) = (wrong.site, wrong.time, wrong.velocity_before);
    Some(Obstruction::WrongSign { impact, site, time, velocity_before })
}

impl<'a> Search<'a> {
    /// Along an orbit with these impacts.
    pub(crate) fn new(
        (impacts, period): (&'a [Impact], f64),
        stops: &'a dyn Fn(usize) -> [Option<f64>; 2],
        depth: Depth,
        stop: &'a Stop,
        lists: &'a mut Lists,
    ) -> Self {
        let (clear, closest) = (SmallVec::new(), Closest::NONE);
        Self { impacts, period, stops, has_corners: false, clear, depth, stop, lists, closest }
    }

    /// Of contacts, which may have corners, and are off their barriers for so long after each impact.
    pub(crate) fn of_contacts(self, clear: SmallVec<[f64; 4]>) -> Self {
        Self { has_corners: true, clear, ..self }
    }

    /// Barriers of a mass or contact, each with its place.
    pub(super) fn barriers(&self, site: usize) -> [Option<(Barrier, f64)>; 2] {
        let [lower, upper] = (self.stops)(site);
        [lower.map(|stop| (Barrier::Lower, stop)), upper.map(|stop| (Barrier::Upper, stop))]
    }

    /// Nothing that is still to come changes the answer.
    pub(crate) fn is_decided(&self) -> bool {
        self.depth == Depth::First && self.closest.distance <= 0.0
    }

    /// Takes note of a distance to a barrier.
    pub(crate) fn note(&mut self, distance: f64, (site, barrier): (usize, Barrier), time: f64) {
        let half = match (self.stops)(site) {
            [Some(lower), Some(upper)] => 0.5 * (upper - lower),
            _ => 0.0,
        };
        self.closest.note_distance(distance, half, (site, barrier), time);
    }

    /// Whether a mass or contact ever hits a barrier. One that does not comes no less near than it is anywhere.
    pub(super) fn hits(&self, site: usize, barrier: Barrier) -> bool {
        self.impacts.iter().any(|impact| (impact.site, impact.barrier) == (site, barrier))
    }

    /// Whether it hits any barrier at an instant.
    pub(super) fn hits_at(&self, site: usize, time: f64) -> bool {
        let is_then = |impact: &Impact| time_between(impact.time, time, self.period) <= SIMULTANEOUS * self.period;
        self.impacts.iter().any(|impact| impact.site == site && is_then(impact))
    }

    /// For how long after an instant it is surely off a barrier that it has just hit; 0 where nothing is known.
    pub(crate) fn clear_after(&self, site: usize, barrier: Barrier, time: f64) -> Option<f64> {
        let is_then = |impact: &Impact| time_between(impact.time, time, self.period) <= SIMULTANEOUS * self.period;
        let is_it = |impact: &Impact| (impact.site, impact.barrier) == (site, barrier) && is_then(impact);
        let impact = self.impacts.iter().position(is_it)?;
        Some(self.clear.get(impact).copied().unwrap_or_default())
    }
}
