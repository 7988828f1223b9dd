//! Flight of the lattice in windows, and restarts.
//!
//! A window starts with all masses at one instant, the base, and expands their series over a horizon H. One bound
//! clears the masses that cannot reach a barrier; the others enter a queue, keyed by the time before which they have
//! certainly no contact. What happens in between is a restart of the masses that can feel it before the window ends:
//! all of them on a small lattice or in several layers, a few neighbours in a long row ([`crate::restart`]).

use std::collections::BinaryHeap;
use std::ops::Range;

use wide::f64x8;

use crate::bound;
use crate::event::Work;
use crate::queue::Entry;
use crate::ring::{Contact, Ring};
use crate::series::{CORRECTED, Extent, LANES, Rows, links};
use crate::time::Clock;
use crate::units::{MAX_ORDER, ORDERS, Units, spread};
use crate::watch::{Kind, Step, Watch, safe_step};
use crate::weights::Weights;
use vibrochain_lattice::{Barrier, Ends};

/// A mass is cleared if its bound stays this far from the barriers: the rounding of displacements below 2, many times.
const CLEARANCE: f64 = 64.0 * f64::EPSILON;

/// Events this close together, in internal time (or relative to the time since the base, if that is longer), happen
/// together: roots of series of size one are known no better.
const SIMULTANEOUS: f64 = 8.0 * f64::EPSILON;

/// Cost of restarting a mass in the middle of a window relative to its share of a whole window; measured.
const RESTART_COST: f64 = 2.0;

/// On rings this small the rounding errors of every mass repeat with every impact, not only those of the mass that
/// leaves a barrier.
const FEW: usize = 4;

/// From this size on an event restarts a part of the ring, as a rule.
const LARGE: usize = 64;

const NONE: u32 = u32::MAX;

/// Change of the rate of events, relative, below which the order of the series stays what it was: costs of neighbouring orders differ
/// by more where they differ at all.
const SAME_RATE: f64 = 1.0 / 16.0;

/// An order that has been chosen, with its horizon, and for what.
#[derive(Debug, Clone, Copy)]
struct Choice {
    least: u8,
    rate: f64,
    order: usize,
    horizon: f64,
}

/// A contact that is due.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Due {
    pub(crate) site: usize,
    pub(crate) barrier: Barrier,
    /// It is the release of a mass at rest.
    pub(crate) release: bool,
    /// Of a release right at the start of a series, the order of the derivative that pulls the mass off.
    pub(crate) pull: Option<u8>,
}

/// The ring in flight.
#[derive(Debug, Clone)]
pub(crate) struct Engine {
    pub(crate) units: Units,
    /// Phase of the force at time zero, internal time.
    pub(crate) psi: f64,
    pub(crate) clock: Clock,
    pub(crate) ring: Ring,
    pub(crate) rows: Rows,
    /// Origin of each mass's series, since the base; `moved` lists those that are not 0.
    pub(crate) origin: Vec<f64>,
    pub(crate) moved: Vec<usize>,
    /// Certified length of the window, since the base.
    pub(crate) horizon: f64,
    /// Fastest velocity met so far, for the remainder of the series.
    pub(crate) fastest: f64,
    pub(crate) work: Work,
    pub(crate) due: Vec<Due>,
    pub(crate) force: [f64; MAX_ORDER + 1],
    pub(crate) weights: Weights,
    /// Events a unit of internal time, a running mean.
    pub(crate) event_rate: f64,
    /// State of the generator ([`spread`]) of the instants of restarts.
    pub(crate) seed: u64,
    /// Masses that leave a barrier, and what rounding took from their series.
    departures: Vec<usize>,
    lost: Vec<(usize, [f64; CORRECTED])>,
    /// Time since the last event, at the base.
    pub(crate) since_event: f64,
    /// Horizons of all orders, for velocities up to `horizons_for`.
    horizons: [f64; ORDERS.len()],
    horizons_for: f64,
    chosen: Option<Choice>,
    fractions: [f64; MAX_ORDER + 1],
    version: Vec<u32>,
    slot: Vec<u32>,
    pub(crate) watches: Vec<Watch>,
    queue: BinaryHeap<Entry>,
    /// Work space of an expansion, of a part of the ring, and of the parts themselves.
    pub(crate) soft: Vec<(usize, u8)>,
    links: Vec<[u32; 4]>,
    pub(crate) resting_columns: Vec<usize>,
    pub(crate) part_rows: Rows,
    pub(crate) parts: Vec<(usize, usize)>,
    x_next: Vec<f64>,
    v_next: Vec<f64>,
}

impl Engine {
    pub(crate) fn new(units: Units, psi: f64, ring: Ring) -> Self {
        let sites = ring.sites();
        let fastest = ring.v.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let horizons = units.horizons(fastest);
        Self {
            clock: Clock::new(units.omega),
            psi,
            rows: Rows::new(sites),
            origin: vec![0.0; sites],
            moved: Vec::new(),
            horizon: 0.0,
            fastest,
            work: Work::default(),
            due: Vec::new(),
            force: [0.0; MAX_ORDER + 1],
            weights: Weights::zero(),
            event_rate: 0.0,
            seed: 1,
            departures: Vec::new(),
            lost: Vec::new(),
            since_event: 0.0,
            horizons,
            horizons_for: fastest,
            chosen: None,
            fractions: [0.0; MAX_ORDER + 1],
            version: vec![0; sites],
            slot: vec![NONE; sites],
            watches: Vec::new(),
            queue: BinaryHeap::new(),
            soft: Vec::new(),
            links: links(&units.chain),
            resting_columns: Vec::new(),
            part_rows: Rows::default(),
            parts: Vec::new(),
            x_next: vec![0.0; sites],
            v_next: vec![0.0; sites],
            units,
            ring,
        }
    }

    /// The force and its derivatives `after` the base.
    pub(crate) fn set_force(&mut self, after: f64) {
        self.units.force(self.clock.offset() + after + self.psi, &mut self.force);
    }

    /// The longest window of any order.
    pub(crate) fn longest_window(&self) -> f64 {
        self.horizons.into_iter().fold(0.0, f64::max)
    }

    /// Order and horizon of the next window: least cost a unit of time at the present rate of events.
    ///
    /// A mass that leaves a barrier with a derivative of high order needs a series that has it: `least` orders.
    fn choose_order(&mut self, least: u8) -> (usize, f64) {
        let rate = self.event_rate;
        if self.fastest > self.horizons_for {
            self.horizons_for = 2.0 * self.fastest;
            self.horizons = self.units.horizons(self.horizons_for);
        } else if let Some(chosen) = self.chosen
            && chosen.least == least
            && (rate - chosen.rate).abs() <= SAME_RATE * chosen.rate
        {
            return (chosen.order, chosen.horizon);
        }
        let sites = self.ring.sites() as f64;
        let mut best = (f64::INFINITY, ORDERS[0], self.horizons[0]);
        let enough = |order: usize| order >= usize::from(least);
        for (&order, &horizon) in ORDERS.iter().zip(&self.horizons).filter(|(order, _)| enough(**order)) {
            let k = order as f64;
            // Every event restarts the ring, and the rest of the window is lost …
            let used = if rate * horizon > 1e-9 { -(-rate * horizon).exp_m1() / rate } else { horizon };
            let mut cost = k * sites / used;
            // … or its neighbours only.
            let touched = (2 * self.units.reach(horizon, 1.0) + 3) as f64;
            if self.units.is_row && touched < 0.5 * sites {
                cost = cost.min(k * (sites / horizon + RESTART_COST * rate * touched));
            }
            if cost < best.0 {
                best = (cost, order, horizon);
            }
        }
        let (_, order, horizon) = best;
        self.chosen = Some(Choice { least, rate, order, horizon });
        (order, horizon)
    }

    /// Expands and bounds the whole ring from the base.
    pub(crate) fn begin_window(&mut self) {
        self.work.windows += 1;
        self.soft.clear();
        self.ring.soft_departures(&mut self.soft);
        let least = self.soft.iter().map(|(_, order)| *order).max().unwrap_or(0);
        let (order, longest) = self.choose_order(least);
        // Windows of varying length, so that the rounding errors of their weights do not add up.
        let horizon = longest * (1.0 - spread(&mut self.seed).abs() / 64.0);
        self.horizon = horizon;
        for watch in &self.watches {
            self.slot[watch.site] = NONE;
        }
        self.watches.clear();
        self.queue.clear();
        self.set_force(0.0);
        let sites = self.ring.sites();
        self.rows.begin(0, &self.ring, 0..sites);
        let resting = std::mem::take(&mut self.ring.resting);
        for &n in &resting {
            self.watch_rest(n, order);
        }
        let watches = &mut self.watches;
        let inverse = &self.units.inverse_factorial;
        let pressed = |i: usize, k: usize, value: f64| watches[i].press(k, value * inverse[k]);
        // Ghost columns are the walls of several layers.
        let ends = if self.units.is_row { self.units.chain.ends() } else { Ends::Fixed };
        let beyond = [Some(ends); 2];
        let extent = Extent { columns: sites, beyond, links: &self.links, resting: &resting, soft: &self.soft };
        self.rows.expand(extent, &self.units, &self.force, order, pressed);
        for &n in &resting {
            self.queue_rest(n);
        }
        self.ring.resting = resting;
        self.departures.clear();
        if sites <= FEW {
            self.departures.extend(0..sites);
        } else {
            self.ring.departures(&mut self.departures);
        }
        self.lost.clear();
        self.lost.extend(self.departures.iter().map(|&n| (n, self.rows.lost(n, &self.links, &self.units))));
        self.fractions = bound::fractions(horizon);
        let tail = bound::tail(&self.rows, sites, &self.units, horizon);
        for base in (0..sites).step_by(LANES) {
            let bounds = bound::group(&self.rows, base, bound::TAIL, tail, &self.fractions);
            self.sift(&bounds, base, LANES.min(sites - base));
        }
        self.work.bounds += sites as u64;
    }

    /// Queues those of `count` ≤ 8 masses from `base` on that their bounds do not clear.
    pub(crate) fn sift(&mut self, bounds: &bound::Group, base: usize, count: usize) {
        let [lower, upper, clearance] = [self.units.lower, self.units.upper, CLEARANCE].map(f64x8::splat);
        let [x, reference] = [&self.ring.x, &self.ring.reference].map(|all| f64x8::from(eight(all, base)));
        let (lowers, uppers) = (lower - reference, upper - reference);
        let below = (x + bounds.rise).simd_lt(uppers - clearance);
        let above = (x + bounds.fall).simd_gt(lowers + clearance);
        let mut unclear = !(below & above).to_bitmask() & ((1 << count) - 1);
        while unclear != 0 {
            let lane = unclear.trailing_zeros() as usize;
            unclear &= unclear - 1;
            let n = base + lane;
            let key = match self.ring.contact[n] {
                Contact::Resting(_) => continue,
                Contact::Leaving(_, order) if order > 1 => self.open(n),
                _ => {
                    let of = |eight: f64x8| eight.as_array()[lane];
                    let (x, v) = (self.ring.x[n], self.ring.v[n]);
                    let up = safe_step(of(uppers) - x, -v, of(bounds.bend_up));
                    up.min(safe_step(x - of(lowers), v, -of(bounds.bend_down)))
                }
            };
            self.enqueue(n, key);
        }
    }

    fn enqueue(&mut self, n: usize, after_origin: f64) {
        let key = self.origin[n] + after_origin;
        if key <= self.horizon {
            self.queue.push(Entry { key, site: n as u32, version: self.version[n] });
        }
    }

    /// Forgets what is known of the contacts of a range of masses.
    pub(crate) fn invalidate(&mut self, masses: Range<usize>) {
        self.version[masses.clone()].iter_mut().for_each(|version| *version = version.wrapping_add(1));
        self.slot[masses].fill(NONE);
    }

    /// Prepares the watch of a mass at rest; the expansion fills it in.
    pub(crate) fn watch_rest(&mut self, n: usize, order: usize) {
        let Contact::Resting(barrier) = self.ring.contact[n] else { return };
        // Force on a mass at a barrier: springs over distances below 2(1+a), and the drive.
        let size = self.units.rate * self.units.rate * 2.0 * self.units.upper + self.units.amplitude;
        let horizon = self.horizon - self.origin[n];
        self.slot[n] = self.watches.len() as u32;
        self.watches.push(Watch::rest(n, barrier, order, horizon, 4.0 * f64::EPSILON * size));
    }

    /// Bounds and queues the force of a mass at rest.
    pub(crate) fn queue_rest(&mut self, n: usize) {
        if let Some(watch) = self.watches.get_mut(self.slot[n] as usize) {
            let key = watch.prepare();
            self.work.bounds += 1;
            self.enqueue(n, key);
        }
    }

    /// Starts to follow mass `n`; the time since its origin before which it has no contact.
    fn open(&mut self, n: usize) -> f64 {
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
        let barriers = (self.units.lower - reference, self.units.upper - reference);
        let watch = Watch::flight(n, c, order, horizon, barriers, bend, self.ring.contact[n]);
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

    /// Weights of the whole ring at `s` since the base. On a small ring every event restarts all masses, at instants that
    /// may repeat; on a large one the varying windows spread the rounding of the weights.
    fn weights_at(&self, s: f64) -> Weights {
        let mut weights = Weights::zero();
        if self.ring.sites() < LARGE {
            weights.precise(s, self.rows.order, &self.units.inverse_factorial);
        } else {
            weights.plain(s, self.rows.order, &self.units.inverse_factorial);
        }
        weights
    }

    /// Moves the base to `s`: the states of all masses there, and nothing in flight.
    pub(crate) fn rebase(&mut self, s: f64) {
        self.weights = self.weights_at(s);
        let (mut x, mut v) = (std::mem::take(&mut self.x_next), std::mem::take(&mut self.v_next));
        self.states_at(s, &self.weights, &mut x, &mut v);
        (self.x_next, self.v_next) = (x, v);
        for (n, lost) in &self.lost {
            // For a mass restarted since, it has served its turn.
            if self.origin[*n] == 0.0 {
                (self.x_next[*n], self.v_next[*n]) = self.rows.at(*n, self.ring.x[*n], &self.weights, Some(lost));
            }
        }
        self.moved.drain(..).for_each(|n| self.origin[n] = 0.0);
        std::mem::swap(&mut self.ring.x, &mut self.x_next);
        std::mem::swap(&mut self.ring.v, &mut self.v_next);
        self.ring.settle_all();
        self.clock.advance(s);
        self.since_event += s;
    }

    /// Displacements and velocities (internal) at `s` since the base, within the certified part of the window.
    pub(crate) fn read(&self, s: f64, x: &mut [f64], v: &mut [f64]) {
        self.states_at(s, &self.weights_at(s), x, v);
    }

    /// The same with the weights for masses whose series begin at the base.
    fn states_at(&self, s: f64, weights: &Weights, x: &mut [f64], v: &mut [f64]) {
        self.rows.at_all(&self.ring.x, weights, x, v);
        if self.moved.is_empty() {
            return;
        }
        for ((base, x), v) in (0..).step_by(LANES).zip(x.chunks_mut(LANES)).zip(v.chunks_mut(LANES)) {
            let origins = &self.origin[base..base + x.len()];
            if origins.iter().all(|origin| *origin == 0.0) {
                continue;
            }
            let (x_then, v_then) = self.group_at(base, s);
            for (i, origin) in origins.iter().enumerate() {
                if *origin != 0.0 {
                    (x[i], v[i]) = (x_then[i], v_then[i]);
                }
            }
        }
    }

    /// Displacements and velocities at `s` of eight masses from `base` on, whatever the origins of their series.
    fn group_at(&self, base: usize, s: f64) -> ([f64; LANES], [f64; LANES]) {
        let lapses = eight(&self.origin, base).map(|origin| s - origin);
        self.rows.each_at(base, &eight(&self.ring.x, base), &lapses, &self.units.inverse)
    }

    /// Carries the masses of a range alone to `s`, as the new origin of their series.
    pub(crate) fn carry(&mut self, masses: Range<usize>, s: f64) {
        for base in masses.clone().step_by(LANES) {
            let (x, v) = self.group_at(base, s);
            for ((n, x), v) in (base..masses.end).zip(x).zip(v) {
                let origin = &mut self.origin[n];
                if s > *origin {
                    if *origin == 0.0 {
                        self.moved.push(n);
                    }
                    *origin = s;
                    (self.ring.x[n], self.ring.v[n]) = (x, v);
                    self.ring.settle(n);
                }
            }
        }
    }
}

/// Eight of `all` numbers from `base` on; beyond the last there are zeros.
fn eight(all: &[f64], base: usize) -> [f64; LANES] {
    all[base..].first_chunk().copied().unwrap_or_else(|| {
        let mut some = [0.0; LANES];
        some.iter_mut().zip(&all[base..]).for_each(|(some, one)| *some = *one);
        some
    })
}
