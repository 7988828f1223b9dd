//! Restarts at an event: of the whole lattice, or of the masses that can feel it ([`crate::part`]). Several layers are always restarted whole.

use super::Engine;
use crate::bound;
use crate::cascade::Change;
use crate::part::{self, DITHER, LEAST_REACH, Part, ranges};
use crate::ring::Contact;
use crate::series::LANES;
use crate::stencil::Extent;
use crate::units::spread;
use vibrochain_lattice::Ends;

impl Engine {
    /// Restarts the flight at `s` since the base, not before `floor`, with the contacts in `due`. The instant of the
    /// restart, and whether the base has moved there.
    pub(crate) fn restart(&mut self, s: f64, floor: f64, changes: &mut Vec<Change>) -> (f64, bool) {
        self.pace.note_event(s);
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

    /// The parts of the row within `reach` of the contacts that are due. False if all of the lattice had better be restarted.
    fn split(&self, reach: usize, parts: &mut Vec<Part>) -> bool {
        let row = (self.ring.sites(), self.units.chain.ends() == Ends::Closed);
        self.units.is_row && part::split((self.due.len(), |i| self.due[i].site), reach, row, parts)
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
}
