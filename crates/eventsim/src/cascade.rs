//! Cascades of impacts on one barrier: how many there were, and the limits that are still ahead.

use crate::event::{EventKind, Outcome};
use crate::time::Clock;
use vibrochain_lattice::Barrier;

/// Latest impacts on one barrier.
#[derive(Debug, Clone, Copy)]
struct Bounces {
    barrier: Barrier,
    count: u32,
    periods: u64,
    offset: f64,
}

/// What became of one contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Change {
    pub(crate) contact: usize,
    pub(crate) barrier: Barrier,
    pub(crate) before: f64,
    pub(crate) after: f64,
    /// P of an impact.
    pub(crate) impulse: f64,
    pub(crate) kind: EventKind,
    /// How much later than the contact: the limit of a cascade.
    pub(crate) delay: f64,
}

impl Change {
    pub(crate) fn still(contact: usize, barrier: Barrier, kind: EventKind, delay: f64) -> Self {
        Self { contact, barrier, before: 0.0, after: 0.0, impulse: 0.0, kind, delay }
    }
}

/// A rest whose event is not due yet.
#[derive(Debug, Clone, Copy)]
struct Pending {
    contact: usize,
    barrier: Barrier,
    at: f64,
}

/// Of all contacts. Times count from the base.
#[derive(Debug, Clone)]
pub(crate) struct Cascades {
    bounces: Vec<Option<Bounces>>,
    pending: Vec<Pending>,
}

impl Cascades {
    pub(crate) fn new(contacts: usize) -> Self {
        Self { bounces: vec![None; contacts], pending: Vec::new() }
    }

    /// Contact `contact` comes to rest at `at`.
    pub(crate) fn rest_at(&mut self, contact: usize, barrier: Barrier, at: f64) {
        self.pending.push(Pending { contact, barrier, at });
    }

    /// When the next one comes to rest; infinite: none does.
    pub(crate) fn next_rest(&self) -> f64 {
        self.pending.iter().map(|pending| pending.at).fold(f64::INFINITY, f64::min)
    }

    /// Tells of those that have come to rest by `at`.
    pub(crate) fn rested_by(&mut self, at: f64, observe: impl FnMut(&Change)) {
        self.take(|pending| pending.at <= at, observe);
    }

    fn take(&mut self, is_due: impl Fn(&Pending) -> bool, mut observe: impl FnMut(&Change)) {
        self.pending.retain(|pending| {
            if is_due(pending) {
                observe(&Change::still(pending.contact, pending.barrier, EventKind::Stick, 0.0));
            }
            !is_due(pending)
        });
    }

    /// Tells of changes at `now`, but for the rests that are still ahead, and counts bounces: the first cascade that has as many as `most`, each
    /// within what `wait` says of its contact.
    pub(crate) fn tell(
        &mut self,
        changes: &[Change],
        (clock, now): (&Clock, f64),
        most: u32,
        wait: impl Fn(usize) -> f64,
        mut observe: impl FnMut(&Change),
    ) -> Option<Outcome> {
        let mut cascade = None;
        for change in changes {
            let &Change { contact, barrier, kind, delay, .. } = change;
            if kind == EventKind::Stick && delay > 0.0 {
                self.rest_at(contact, barrier, now + delay);
                continue;
            }
            if kind == EventKind::Release {
                // A release before the end of its own cascade: then that end is now.
                self.take(|pending| pending.contact == contact, &mut observe);
            }
            observe(change);
            if kind == EventKind::Impact {
                let bounces = self.count(contact, barrier, clock, now, wait(contact));
                if bounces >= most {
                    self.bounces[contact] = None;
                    cascade = cascade.or(Some(Outcome::Cascade { contact, barrier, bounces }));
                }
            }
        }
        cascade
    }

    /// The base moves on.
    pub(crate) fn rebased(&mut self, by: f64) {
        self.pending.iter_mut().for_each(|pending| pending.at = (pending.at - by).max(0.0));
    }

    /// Counts an impact at `now`: how many there were in succession, each within `wait` of the one before.
    fn count(&mut self, contact: usize, barrier: Barrier, clock: &Clock, now: f64, wait: f64) -> u32 {
        let (periods, offset) = clock.after(now);
        let count = match self.bounces[contact] {
            Some(last) if last.barrier == barrier && now - clock.until(last.periods, last.offset) < wait => {
                last.count.saturating_add(1)
            }
            _ => 1,
        };
        self.bounces[contact] = Some(Bounces { barrier, count, periods, offset });
        count
    }
}
