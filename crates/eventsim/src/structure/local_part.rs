//! New series in the middle of a window, of those coordinates of a row that can feel what has happened ([`crate::part`]).
//!
//! Only where contact n sees mass n as it is, and as long as none rests or leaves its barrier with a derivative of high order: these are told by
//! series of all coordinates from one instant.

use super::approach::Place;
use super::local_flight::{LocalFlight, Sweep};
use super::motion::{Due, FORGET};
use crate::bound;
use crate::part::{LEAST_REACH, Part, ranges, split};
use crate::ring::Contact;
use crate::series::{LANES, eight};
use crate::units::reach;
use crate::weights::Weights;
use vibrochain_lattice::{Complex, Ends};

/// Jump of a velocity against the size of the motion in units of the rate: (1+e) of a velocity that is at most twice that size.
const JUMP: f64 = 4.0;

impl LocalFlight {
    /// The share of all masses that restarts with one at any time in a window, if it is less than half.
    pub(super) fn touched(&self, horizon: f64) -> Option<f64> {
        let (_, coupling) = self.local.row().filter(|_| self.is_direct)?;
        let touched = 2 * reach(coupling, horizon, JUMP) + 3;
        Some(touched as f64 / self.place.len() as f64).filter(|share| *share < 0.5)
    }

    /// The parts that feel contacts which are due at `s` since the base in internal time; `None`: all masses do, or are to be restarted anyway.
    pub(super) fn parts(&self, due: &[Due], s: f64) -> Option<Vec<Part>> {
        let (ends, coupling) = self.local.row().filter(|_| self.is_partible)?;
        let reach = reach(coupling, self.horizon - s, JUMP).max(LEAST_REACH);
        let mut parts = Vec::new();
        let row = (self.place.len(), ends[0] == Ends::Closed);
        split((due.len(), |i| due[i].contact), reach, row, &mut parts).then_some(parts)
    }

    /// Carries masses of a part alone to `s` as the new origin of their series, where loads are `turned`.
    pub(super) fn carry(&mut self, places: &mut [Place], part: Part, s: f64, turned: &[Complex<f64>]) {
        self.now.clear();
        self.now.extend_from_slice(turned);
        for (masses, _) in ranges(part, self.place.len()) {
            for base in masses.clone().step_by(LANES) {
                // How far they have moved: measured from a barrier that has more digits than where they are.
                let still = [0.0; LANES];
                let lapses = eight(&self.origin, base).map(|origin| s - origin);
                let (moved, velocity) = self.series.rows.each_at(base, &still, &lapses, &self.local.inverse);
                for (n, i) in (base..masses.end.min(base + LANES)).zip(0..) {
                    if lapses[i] > 0.0 {
                        self.carry_one(&mut places[n], n, s, [moved[i], velocity[i]]);
                    }
                }
            }
        }
    }

    fn carry_one(&mut self, place: &mut Place, n: usize, s: f64, [moved, velocity]: [f64; 2]) {
        let scale = self.local.scale;
        if place.reference.is_some() {
            let off = place.v.map_or(0.0, |v| v / scale - self.velocity[n]);
            let (x, v) = (place.x + (moved + off * (s - self.origin[n])), velocity + off);
            let size = (self.place[n] + moved).abs() + velocity.abs();
            *place = if x.abs() > FORGET * size {
                Place { reference: None, x: self.place[n] + moved, v: None, touch: Contact::Free }
            } else {
                // A flight so short that even the distance underflows has not left.
                let touch = if x == 0.0 { place.touch } else { Contact::Free };
                Place { x, v: Some(v * scale), touch, ..*place }
            };
        }
        if self.origin[n] == 0.0 {
            self.moved.push(n);
        }
        self.origin[n] = s;
        self.place[n] += moved;
        self.velocity[n] = velocity;
    }

    /// New series of a part whose masses are at `s`: `found` is told of contacts that bounds do not clear.
    pub(super) fn restart(&mut self, part: Part, s: f64, mut found: impl FnMut(&Self, usize, Sweep)) {
        let Some((ends, _)) = self.local.row() else { return };
        let ((start, length), n) = (part, self.place.len());
        let (local, order) = (self.local.clone(), self.series.rows.order);
        let mut rows = std::mem::take(&mut self.part_rows);
        rows.reset(length);
        let is_end = [start == 0, start + length == n];
        let beyond = [0, 1].map(|side| (ends[side] != Ends::Closed && is_end[side]).then_some(ends[side]));
        let mut weights = Weights::zero();
        for (side, other) in [(start + n - 1) % n, (start + length) % n].into_iter().enumerate() {
            if beyond[side].is_none() {
                weights.plain(s - self.origin[other], order, &local.inverse_factorial);
                self.series.rows.shifted(other, self.place[other], &weights, &mut rows.edges[side]);
            }
        }
        let ranges = ranges(part, n);
        for (masses, first) in &ranges {
            let (places, velocities) = rows.data[first + 1..].split_at_mut(rows.stride);
            places[..masses.len()].copy_from_slice(&self.place[masses.clone()]);
            velocities[..masses.len()].copy_from_slice(&self.velocity[masses.clone()]);
        }
        local.fill(&mut rows, &ranges, beyond, &self.now, order, |_, _| {});
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
    }

    /// Those of `count` contacts from `base` on, masses all, that their bounds do not clear.
    pub(super) fn sift(
        &self,
        bounds: &bound::Group,
        base: usize,
        count: usize,
        found: &mut impl FnMut(&Self, usize, Sweep),
    ) {
        let of = |eight: &wide::f64x8, lane: usize| eight.as_array()[lane];
        for lane in 0..count {
            let contact = base + lane;
            let (rise, fall) = (of(&bounds.rise, lane), of(&bounds.fall, lane));
            if !self.is_clear(contact, self.place[contact], [rise, fall]) {
                let (bend_up, bend_down) = (of(&bounds.bend_up, lane), of(&bounds.bend_down, lane));
                found(self, contact, Sweep { rise, fall, bend_up, bend_down });
            }
        }
    }
}
