//! Cascades of impacts on one barrier: how many there were, and the limits that are still ahead.

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

/// A rest whose event is not due yet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pending {
    pub(crate) site: usize,
    pub(crate) barrier: Barrier,
    at: f64,
}

/// Of all masses, or of all contacts of a structure. Times count from the base.
#[derive(Debug, Clone)]
pub(crate) struct Cascades {
    bounces: Vec<Option<Bounces>>,
    pending: Vec<Pending>,
}

impl Cascades {
    pub(crate) fn new(sites: usize) -> Self {
        Self { bounces: vec![None; sites], pending: Vec::new() }
    }

    /// Site `site` comes to rest at `at`.
    pub(crate) fn rest_at(&mut self, site: usize, barrier: Barrier, at: f64) {
        self.pending.push(Pending { site, barrier, at });
    }

    /// When the next one comes to rest; infinite: none does.
    pub(crate) fn next_rest(&self) -> f64 {
        self.pending.iter().map(|pending| pending.at).fold(f64::INFINITY, f64::min)
    }

    /// Those that have come to rest by `at`.
    pub(crate) fn rested_by(&mut self, at: f64) -> Vec<Pending> {
        self.take(|pending| pending.at <= at)
    }

    /// Those of one site, whose rest ends before its own cascade did: the end is now.
    pub(crate) fn cut_short(&mut self, site: usize) -> Vec<Pending> {
        self.take(|pending| pending.site == site)
    }

    fn take(&mut self, is_due: impl Fn(&Pending) -> bool) -> Vec<Pending> {
        let due = self.pending.iter().copied().filter(&is_due).collect();
        self.pending.retain(|pending| !is_due(pending));
        due
    }

    /// The base moves on.
    pub(crate) fn rebased(&mut self, by: f64) {
        self.pending.iter_mut().for_each(|pending| pending.at = (pending.at - by).max(0.0));
    }

    /// Counts an impact at `now`: how many there were in succession, each within `wait` of the one before.
    pub(crate) fn count(&mut self, site: usize, barrier: Barrier, clock: &Clock, now: f64, wait: f64) -> u32 {
        let (periods, offset) = clock.after(now);
        let count = match self.bounces[site] {
            Some(last) if last.barrier == barrier && now - clock.until(last.periods, last.offset) < wait => {
                last.count.saturating_add(1)
            }
            _ => 1,
        };
        self.bounces[site] = Some(Bounces { barrier, count, periods, offset });
        count
    }

    /// Begins to count anew.
    pub(crate) fn forget(&mut self, site: usize) {
        self.bounces[site] = None;
    }
}
