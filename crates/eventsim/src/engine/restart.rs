//! Restarts at an event: of the whole lattice, or of the masses that can feel it.
//!
//! What happens to a mass reaches its m-th neighbour with γ₂^m τ^{2m+1}/(2m+1)!: within the rest of a window only the
//! nearest R neighbours on either side can notice ([`Units::reach`](crate::units::Units::reach)), and only they get new
//! series, from the same stencil; at the ends of the part the neighbours' series are known, and stay (at the end of the
//! row there are none). An event then costs what R costs, whatever the length of the row. Several layers are always
//! restarted whole.
//!
//! Parts that touch are restarted as one, so that simultaneous events keep the mirror symmetry of a ring to the bit.

use std::ops::Range;

use super::Engine;
use crate::bound;
use crate::cascade::Change;
use crate::ring::Contact;
use crate::series::LANES;
use crate::stencil::Extent;
use crate::units::spread;
use vibrochain_lattice::Ends;

/// Least number of neighbours restarted on either side: the derivatives that decide a contact look two masses far.
const LEAST_REACH: usize = 3;

/// How far from the computed instant, relative to its distance from the base, a restart may take place: the rounding
/// of that instant. A breather repeats its flights to the bit, and rounding errors that repeat add up; spread over the
/// neighbouring instants they average out. The impact law corrects for the distance left to the barrier.
const DITHER: f64 = 8.0 * f64::EPSILON;

/// A part of the row: first site and number of masses.
type Part = (usize, usize);

/// The masses of a part, each range with its first column: over the end of the ring there are two.
fn ranges((start, length): Part, sites: usize) -> [(Range<usize>, usize); 2] {
    let end = start + length;
    [(start..end.min(sites), 0), (0..end.saturating_sub(sites), length.min(sites - start))]
}

impl Engine {
    /// Restarts the flight at `s` since the base, not before `floor`, with the contacts in `due`. The instant of the
    /// restart, and whether the base has moved there.
    pub(crate) fn restart(&mut self, s: f64, floor: f64, changes: &mut Vec<Change>) -> (f64, bool) {
        self.note_event(s);
        let s = (s + s * (DITHER * spread(&mut self.seed))).max(floor);
        let reach = self.units.reach(self.horizon - s, self.fastest.max(1.0)).max(LEAST_REACH);
        let mut parts = std::mem::take(&mut self.parts);
        let apart = self.split(reach, &mut parts);
        if apart {
            for &part in &parts {
                for (masses, _) in ranges(part, self.ring.sites()) {
                    self.carry(masses, s);
                }
            }
            self.collide(s, changes);
            for &part in &parts {
                self.expand_part(part, s);
            }
        } else {
            self.rebase(s);
            self.collide(0.0, changes);
            self.begin_window();
        }
        self.parts = parts;
        (s, !apart)
    }

    /// The parts of the row within `reach` of the contacts that are due, merged where less than a mass is between
    /// them. False if they make up so much of the lattice that all of it had better be restarted.
    fn split(&self, reach: usize, parts: &mut Vec<Part>) -> bool {
        parts.clear();
        let (sites, due) = (self.ring.sites(), &self.due);
        if !self.units.is_row || (2 * reach + 1).saturating_mul(due.len()).saturating_mul(2) > sites {
            return false;
        }
        let closed = self.units.chain.ends() == Ends::Closed;
        // Distance from a contact to the next around the ring; a part begins after a wide one.
        let count = due.len();
        let gap = |i: usize| {
            let (from, to) = (due[i].site, due[(i + 1) % count].site);
            if to > from { to - from } else { to + sites - from }
        };
        let wide = |i: usize| gap(i) > 2 * reach + 2 || (!closed && i + 1 == count);
        let Some(cut) = (0..count).find(|&i| wide(i)) else { return false };
        let mut start = None;
        let mut length = 1;
        for i in (0..count).map(|i| (cut + 1 + i) % count) {
            let first = *start.get_or_insert(due[i].site);
            if !wide(i) {
                length += gap(i);
                continue;
            }
            parts.push(if closed {
                ((first + sites - reach) % sites, length + 2 * reach)
            } else {
                let begin = first.saturating_sub(reach);
                (begin, (first + length + reach).min(sites) - begin)
            });
            start = None;
            length = 1;
        }
        true
    }

    /// New series, bounds and watches for a part whose masses are at `s`.
    fn expand_part(&mut self, part: Part, s: f64) {
        let (start, length) = part;
        let sites = self.ring.sites();
        let site = |i: usize| if start + i < sites { start + i } else { start + i - sites };
        let order = self.rows.order;
        self.work.restarts += 1;
        let mut rows = std::mem::take(&mut self.part_rows);
        rows.reset(length);
        // On a ring both sides go on.
        let ends = self.units.chain.ends();
        let at_end = |last: bool| (ends != Ends::Closed && last).then_some(ends);
        let beyond = [at_end(start == 0), at_end(start + length == sites)];
        for (side, n) in [site(sites - 1), site(length)].into_iter().enumerate() {
            // (At the end of a row the expansion knows better.)
            let lapse = s - self.origin[n];
            if self.weights.high[1] != lapse {
                self.weights.plain(lapse, order, &self.units.inverse_factorial);
            }
            self.rows.shifted(n, self.ring.position(n), &self.weights, &mut rows.edges[side]);
        }
        let (mut resting, mut soft) = (std::mem::take(&mut self.resting_columns), std::mem::take(&mut self.soft));
        resting.clear();
        soft.clear();
        let first_watch = self.watches.len();
        for (masses, first) in ranges(part, sites) {
            rows.begin(first, &self.ring, masses.clone());
            self.invalidate(masses.clone());
            for (i, n) in (first..).zip(masses) {
                match self.ring.contact[n] {
                    Contact::Resting(_) => {
                        resting.push(i);
                        self.watch_rest(n, order);
                    }
                    Contact::Leaving(_, order) if order > 1 => soft.push((i, order)),
                    _ => {}
                }
            }
        }
        let watches = &mut self.watches[first_watch..];
        let inverse = &self.units.inverse_factorial;
        let pressed = |i: usize, k: usize, value: f64| watches[i].press(k, value * inverse[k]);
        let extent = Extent { columns: length, beyond, links: &[], resting: &resting, soft: &soft };
        rows.expand_chain(extent, &self.units, &self.force, order, pressed);
        for &i in &resting {
            self.queue_rest(site(i));
        }
        let fractions = bound::fractions(self.horizon - s);
        for (masses, first) in ranges(part, sites) {
            self.rows.take(&rows, first, masses.start, masses.len());
            for base in masses.clone().step_by(LANES) {
                // A part has no tail bound of its own: the pass starts at the top.
                let bounds = bound::group(&rows, first + base - masses.start, order + 1, 0.0, &fractions);
                self.sift(&bounds, base, LANES.min(masses.end - base));
            }
        }
        self.work.bounds += length as u64;
        (self.part_rows, self.resting_columns, self.soft) = (rows, resting, soft);
    }

    /// Takes note of an event at `s` since the base: a mean over some sixteen events; the rate is its inverse.
    fn note_event(&mut self, s: f64) {
        let flight = self.since_event + s;
        self.since_event = -s;
        let mean = if self.event_rate > 0.0 { 1.0 / self.event_rate } else { flight };
        let mean = mean + (flight - mean) / 16.0;
        self.event_rate = if mean > 0.0 { 1.0 / mean } else { 0.0 };
    }
}
