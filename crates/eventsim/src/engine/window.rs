//! Order and length of a window, and the masses that may have a contact in it.

use std::ops::Range;

use vibrochain_lattice::Ends;
use wide::f64x8;

use super::{Engine, NONE};
use crate::bound;
use crate::queue::Entry;
use crate::ring::Contact;
use crate::safe_step::safe_step;
use crate::series::{LANES, eight};
use crate::stencil::Extent;
use crate::units::spread;
use crate::watch::Watch;

/// A mass is cleared if its bound stays this far from the barriers: the rounding of displacements below 2, many times.
const CLEARANCE: f64 = 64.0 * f64::EPSILON;

/// On rings this small the rounding errors of every mass repeat with every impact, not only those of the mass that
/// leaves a barrier.
const FEW: usize = 4;

impl Engine {
    /// Order and horizon of the next window.
    fn choose_order(&mut self, least: u8) -> (usize, f64) {
        if self.fastest > self.horizons_for {
            self.horizons_for = 2.0 * self.fastest;
            self.horizons = self.units.horizons(self.horizons_for);
            self.pace.choose_anew();
        }
        let (units, sites) = (&self.units, self.ring.sites() as f64);
        let touched = |horizon: f64| {
            let share = (2 * units.reach(horizon, 1.0) + 3) as f64 / sites;
            (units.is_row && share < 0.5).then_some(share)
        };
        self.pace.choose(least, &self.horizons, touched)
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
        self.rows.expand_chain(extent, &self.units, &self.force, order, pressed);
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
        let tail = bound::tail(&self.rows, sites, self.units.growth(), horizon);
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
}
