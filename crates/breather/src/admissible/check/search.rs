//! The search for where masses of a lattice, or contacts of any structure, come nearest to their barriers.

use smallvec::SmallVec;
use vibrochain_lattice::simd::lanes::Lane;
use vibrochain_lattice::{Barrier, Stop};

use crate::admissible::answer::Obstruction;
use crate::admissible::gap::{Closest, Depth};
use crate::orbit::{Impact, SIMULTANEOUS, time_between};

/// Lists of a search. The next search reuses their memory.
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
    /// The velocity that an impulse of 1 at one contact gives another one: it has a corner there. None where masses are apart.
    mobility: Option<&'a dyn Fn(usize, usize) -> f64>,
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
        Self { impacts, period, stops, mobility: None, clear, depth, stop, lists, closest }
    }

    /// The same along an orbit of contacts: an impact of one may jerk the others (`mobility`), and after impact n its contact is surely off its barrier
    /// for the time `clear[n]`.
    pub(crate) fn of_contacts(self, mobility: &'a dyn Fn(usize, usize) -> f64, clear: SmallVec<[f64; 4]>) -> Self {
        Self { mobility: Some(mobility), clear, ..self }
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

    /// The impacts at an instant.
    fn at(&self, time: f64) -> impl Iterator<Item = (usize, &Impact)> {
        let is_then = move |impact: &Impact| time_between(impact.time, time, self.period) <= SIMULTANEOUS * self.period;
        self.impacts.iter().enumerate().filter(move |(_, impact)| is_then(impact))
    }

    /// Whether it hits any barrier at an instant.
    pub(super) fn hits_at(&self, site: usize, time: f64) -> bool {
        self.at(time).any(|(_, impact)| impact.site == site)
    }

    /// The velocity that impacts of others give it at an instant.
    pub(super) fn jolt(&self, site: usize, time: f64) -> f64 {
        let Some(mobility) = self.mobility else { return 0.0 };
        self.at(time).map(|(_, impact)| mobility(site, impact.site) * impact.impulse).sum()
    }

    /// For how long after an instant it is surely off a barrier that it has just hit; 0 where nothing is known.
    pub(crate) fn clear_after(&self, site: usize, barrier: Barrier, time: f64) -> Option<f64> {
        let (impact, _) = self.at(time).find(|(_, impact)| (impact.site, impact.barrier) == (site, barrier))?;
        Some(self.clear.get(impact).copied().unwrap_or_default())
    }
}
