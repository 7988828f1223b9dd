//! Windows of local series, and new series in the middle of one, of those coordinates of a row that can feel what has happened
//! ([`crate::series::part`]): only where contact n sees mass n as it is.

use crate::flight::Flight;
use crate::flight::local::{Local, LocalSeries};
use crate::flight::local_flight::{LocalFlight, Sweep, begin_rows};
use crate::flight::places::{Place, Places};
use crate::flight::system::System;
use crate::motion::{Due, Motion};
use crate::series::bound;
use crate::series::part::{DITHER, LEAST_REACH, Part, ranges, split};
use crate::series::weights::Weights;
use crate::series::{LANES, eight};
use crate::units::{MAX_ORDER, ORDERS, reach, spread};
use crate::watch::queue::Candidates;
use crate::watch::safe_step::safe_step;
use crate::watch::{Contact, Watch};
use vibrochain_lattice::{Barrier, Ends};

/// Jump of a velocity against the size of the motion in units of the rate: (1+e) of a velocity that is at most twice that size.
const JUMP: f64 = 4.0;

impl LocalFlight {
    /// The share of all masses that restarts with one at any time in a window of each order, if it is less than half.
    pub(crate) fn touched(local: &Local, is_direct: bool) -> [Option<f64>; ORDERS.len()] {
        let share = |horizon: f64| {
            let (_, coupling) = local.row().filter(|_| is_direct)?;
            let touched = 2 * reach(coupling, horizon, JUMP) + 3;
            Some(touched as f64 / local.operator.masses.len() as f64).filter(|share| *share < 0.5)
        };
        local.horizons.map(share)
    }

    /// Finds the parts that feel contacts which are due at `s` since the base in internal time. False: all masses do, or are to be restarted anyway.
    pub(crate) fn split(&mut self, due: &[Due], s: f64) -> bool {
        let Some((ends, coupling)) = self.local.row().filter(|_| self.is_direct) else { return false };
        let reach = reach(coupling, self.horizon - s, JUMP).max(LEAST_REACH);
        let row = (self.x.len(), ends[0] == Ends::Closed);
        split((due.len(), |i| due[i].contact), reach, row, &mut self.parts)
    }

    /// Carries masses of a part alone to `s` as the new origin of their series.
    pub(crate) fn carry(&mut self, places: &mut Places, part: Part, s: f64) {
        for (masses, _) in ranges(part, self.x.len()) {
            for base in masses.clone().step_by(LANES) {
                // How far they have moved: measured from a barrier that has more digits than where they are.
                let still = [0.0; LANES];
                let lapses = eight(&self.origin, base).map(|origin| s - origin);
                let (moved, velocity) = self.series.rows.each_at(base, &still, &lapses, &self.local.inverse);
                for (n, i) in (base..masses.end.min(base + LANES)).zip(0..) {
                    if lapses[i] > 0.0 {
                        self.carry_one(places, n, s, [moved[i], velocity[i]]);
                    }
                }
            }
        }
    }

    fn carry_one(&mut self, places: &mut Places, n: usize, s: f64, [moved, velocity]: [f64; 2]) {
        if self.origin[n] == 0.0 {
            self.moved.push(n);
        }
        self.origin[n] = s;
        self.x[n] += moved;
        self.velocity[n] = velocity;
        let place = places[n];
        if place.reference.is_some() && !places.is_resting(n) {
            places.set(n, self.settled(n, &place));
        }
    }

    /// New series of a part whose masses are at `s`: `found` is told of contacts that bounds do not clear, and of those at rest with the forces
    /// on them.
    pub(crate) fn restart(
        &mut self,
        places: &Places,
        part: Part,
        s: f64,
        mut found: impl FnMut(&Self, usize, Sweep),
    ) -> Vec<PartRest> {
        let mut rests: Vec<PartRest> = Vec::new();
        let Some((ends, _)) = self.local.row() else { return rests };
        let ((start, length), n) = (part, self.x.len());
        let (local, order) = (self.local.clone(), self.series.rows.order);
        let mut rows = std::mem::take(&mut self.part_rows);
        rows.reset(length);
        let is_end = [start == 0, start + length == n];
        let beyond = [0, 1].map(|side| (ends[side] != Ends::Closed && is_end[side]).then_some(ends[side]));
        let mut weights = Weights::zero();
        for (side, other) in [(start + n - 1) % n, (start + length) % n].into_iter().enumerate() {
            if beyond[side].is_none() {
                let lapse = s - self.origin[other];
                if weights.high[1] != lapse {
                    weights.plain(lapse, order, &local.inverse_factorial);
                }
                self.series.rows.shifted(other, self.position(other), &weights, &mut rows.edges[side]);
            }
        }
        let ranges = ranges(part, n);
        for (masses, first) in &ranges {
            begin_rows(self.state(), &mut rows, *first, masses.clone());
        }
        let column = |n: usize| {
            ranges.iter().find(|(masses, _)| masses.contains(&n)).map(|(masses, first)| n - masses.start + first)
        };
        for &n in places.resting() {
            if let (Some(column), Contact::Resting(barrier)) = (column(n), places[n].touch) {
                rests.push(PartRest { contact: (n, barrier), column, forces: [0.0; MAX_ORDER + 1] });
            }
        }
        let mut soft = std::mem::take(&mut self.series.soft);
        soft.clear();
        soft.extend(places.soft().filter_map(|(n, order)| Some((column(n)?, order))));
        local.fill(&mut rows, &ranges, beyond, &self.now, order, |k, to| {
            for rest in &mut rests {
                rest.forces[k] = -to[rest.column + 1] * local.operator.masses[rest.contact.0];
                to[rest.column + 1] = 0.0;
            }
            let is_none = |first: &u8| k + 2 < usize::from(*first);
            soft.iter().filter(|(_, first)| is_none(first)).for_each(|(n, _)| to[n + 1] = 0.0);
        });
        self.series.soft = soft;
        let fractions = bound::fractions(self.horizon - s);
        for (masses, first) in &ranges {
            self.series.rows.take(&rows, *first, masses.start, masses.len());
            for base in masses.clone().step_by(LANES) {
                // A part has no tail bound of its own: the pass starts at the top.
                let bounds = bound::group(&rows, first + base - masses.start, order + 1, 0.0, &fractions);
                self.sift(&bounds, base, LANES.min(masses.end - base), &mut found);
            }
        }
        self.part_rows = rows;
        rests
    }
}

/// A mass at rest in a part, with the derivatives of the force on it.
pub(crate) struct PartRest {
    pub(crate) contact: (usize, Barrier),
    column: usize,
    pub(crate) forces: [f64; MAX_ORDER + 1],
}

impl Motion {
    /// The certified window of local series: contacts that bounds do not clear are candidates from where parabolas above and below them
    /// first meet a barrier.
    pub(crate) fn begin_local(&mut self) {
        let Self { flight: Flight::Local(flight), system, places, candidates, seed, .. } = self else { return };
        self.unit = 1.0 / flight.local.scale;
        self.work.bounds += places.len() as u64;
        self.horizon = flight.begin(system, places, seed, |flight, contact, sweep| {
            admit((flight, system), (contact, &places[contact]), sweep, candidates);
        });
        let LocalSeries { held, forces, .. } = &flight.series;
        for (held, forces) in held.contacts.iter().zip(forces) {
            self.work.bounds += 1;
            admit_rest(flight, flight.rest_watch(system, *held, forces), candidates);
        }
    }

    /// Moves to what is due at `s`, not before `floor`: the parts that feel it, in the middle of the window, or the base. The instant, and whether the
    /// base has moved there.
    pub(crate) fn arrive(&mut self, s: f64, floor: f64) -> (f64, bool) {
        if let Flight::Local(flight) = &mut self.flight
            && self.ledger.is_none()
            && flight.split(&self.due, s * flight.local.scale)
        {
            // A flight that repeats would repeat its rounding.
            let s = (s + s * (DITHER * spread(&mut self.seed))).max(floor);
            self.system.loads.turn_on(&flight.turned, s, &mut flight.now);
            for i in 0..flight.parts.len() {
                flight.carry(&mut self.places, flight.parts[i], s * flight.local.scale);
            }
            self.is_apart = true;
            return (s, false);
        }
        self.rebase(s);
        (s, true)
    }

    /// Starts new series where the events that were due at `s` have changed something.
    pub(crate) fn restart(&mut self, s: f64) {
        if !self.is_apart {
            self.begin();
            return;
        }
        self.is_apart = false;
        let Self { flight: Flight::Local(flight), system, places, candidates, work, .. } = self else { return };
        let parts = std::mem::take(&mut flight.parts);
        for &part in &parts {
            work.restarts += 1;
            work.bounds += part.1 as u64;
            ranges(part, places.len()).into_iter().flat_map(|(masses, _)| masses).for_each(|n| candidates.forget(n));
            let rests = flight.restart(places, part, s * flight.local.scale, |flight, contact, sweep| {
                admit((flight, system), (contact, &places[contact]), sweep, candidates);
            });
            for rest in rests {
                admit_rest(flight, flight.rest_watch(system, rest.contact, &rest.forces), candidates);
            }
        }
        flight.parts = parts;
    }
}

/// Takes a contact at rest up among the candidates, if it may be released.
fn admit_rest(flight: &LocalFlight, mut watch: Watch, candidates: &mut Candidates) {
    let key = flight.origin(watch.site) + watch.prepare();
    if key <= flight.horizon {
        candidates.push(watch.site, key / flight.local.scale, None, Some(watch));
    }
}

/// Takes a contact up among the candidates, from where parabolas above and below it first meet a barrier.
fn admit(
    (flight, system): (&LocalFlight, &System),
    (contact, place): (usize, &Place),
    sweep: Sweep,
    candidates: &mut Candidates,
) {
    let (watch, after) = match place.touch {
        Contact::Resting(_) => return,
        Contact::Leaving(_, 2..) => {
            let watch = flight.watch(contact, place, place.barriers(system, contact));
            (Some(watch), watch.tau)
        }
        _ => {
            let Sweep { bend_up, bend_down, .. } = sweep;
            let [lower, upper] = flight.limits(system, contact, place);
            let [x, v] = [0, 1].map(|k| flight.own(contact, place, k));
            let step = |gap: f64, slope: f64, bend: f64| {
                if gap.is_finite() { safe_step(gap, slope, bend) } else { f64::INFINITY }
            };
            (None, step(upper - x, -v, bend_up).min(step(x - lower, v, -bend_down)))
        }
    };
    let key = flight.origin(contact) + after;
    if key <= flight.horizon {
        candidates.push(contact, key / flight.local.scale, None, watch);
    }
}
