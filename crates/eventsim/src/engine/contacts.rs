//! The next contacts of a window.

use super::{Due, Engine, NONE};
use crate::bound;
use crate::units::MAX_ORDER;
use crate::watch::{Flight, Kind, Step, Watch};

/// Events this close together, in internal time (or relative to the time since the base, if that is longer), happen
/// together: roots of series of size one are known no better.
const SIMULTANEOUS: f64 = 8.0 * f64::EPSILON;

impl Engine {
    /// Starts to follow mass `n`; the time since its origin before which it has no contact.
    pub(super) fn open(&mut self, n: usize) -> f64 {
        let order = self.rows.order;
        let mut c = [0.0; MAX_ORDER + 1];
        let horizon = self.horizon - self.origin[n];
        // The second derivative is d_2 + d_3 s + …: bounded on the way.
        let mut bend = bound::Enclosure::default();
        for k in (1..=order).rev() {
            let derivative = self.rows.get(k, n);
            c[k] = derivative * self.units.inverse_factorial[k];
            if k > 1 {
                bend.add(derivative, horizon * self.units.inverse[k - 1]);
            }
        }
        c[0] = self.ring.x[n];
        let reference = self.ring.reference[n];
        let (lower, upper) = (self.units.lower - reference, self.units.upper - reference);
        let flight = Flight { c, order, horizon, lower, upper, bend, contact: self.ring.contact[n] };
        let watch = Watch::flight(n, &flight);
        self.work.watched += 1;
        self.slot[n] = self.watches.len() as u32;
        let tau = watch.tau;
        self.watches.push(watch);
        tau
    }

    /// The next contacts up to `limit` (since the base): those within [`SIMULTANEOUS`] of the first are left in
    /// `due`, by site. `None`: there are none up to `limit`.
    ///
    /// Completeness: every mass not cleared by its bound has one entry whose key is a time before which it has no
    /// contact. The earliest entry is advanced by certified steps until it is no longer the earliest or its contact
    /// is reached; so when a contact comes out first, no mass has an earlier one.
    pub(crate) fn next_contacts(&mut self, limit: f64) -> Option<f64> {
        self.due.clear();
        let mut last = limit;
        let mut first = None;
        while let Some(&entry) = self.queue.peek() {
            if entry.key > last {
                break;
            }
            let n = entry.site as usize;
            if entry.version != self.version[n] {
                self.queue.pop();
                continue;
            }
            if self.slot[n] == NONE {
                let opened = self.open(n);
                // The queue's key came from a parabola through the same point with its own bound: keep the better.
                let known = entry.key - self.origin[n];
                if let Some(watch) = self.watches.last_mut()
                    && known > opened
                {
                    watch.tau = known;
                }
            }
            let origin = self.origin[n];
            let Some(watch) = self.watches.get_mut(self.slot[n] as usize) else { break };
            if let Some(barrier) = watch.hit {
                if first.is_none() {
                    first = Some(entry.key);
                    last = entry.key + SIMULTANEOUS * entry.key.max(1.0);
                }
                let release = matches!(watch.kind, Kind::Rest(_));
                self.due.push(Due { site: n, barrier, release, pull: watch.first_pull() });
                self.queue.pop();
                continue;
            }
            self.work.refinements += 1;
            let step = watch.step();
            let key = origin + watch.tau;
            if step == Step::Clear || key > self.horizon {
                self.queue.pop();
            } else if let Some(mut top) = self.queue.peek_mut() {
                // It finds its new place from here: mostly it stays the earliest.
                top.key = key;
            }
        }
        self.due.sort_unstable_by_key(|due| due.site);
        first
    }
}
