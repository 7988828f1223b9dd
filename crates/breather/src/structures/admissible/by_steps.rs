//! By bounds of the acceleration alone: with d the distance to a barrier and B ≥ |g″| on the rest of a flight, d stays positive until the
//! root of d + d′h − Bh²/2. Steps to these roots pass no contact, however stiff some modes are.

use std::convert::Infallible;

use vibrochain_lattice::Barrier;

use crate::admissible::check::search::Search;
use crate::error::BreatherError;
use crate::roots::bracket::zero;
use crate::structures::flight::ContactMotion;
use crate::structures::orbit::ContactOrbit;

/// Distances below this part of a contact's reach are a touch.
const TOUCH: f64 = 1e-13;

/// Steps for one contact in one flight; a graze of 1e-13 takes some dozens.
const MOST_STEPS: usize = 2_000_000;

/// One contact and one barrier in one flight.
struct Watch<'a> {
    motion: &'a ContactMotion<'a>,
    contact: usize,
    barrier: Barrier,
    stop: f64,
    i: usize,
    length: f64,
    touch: f64,
}

impl Watch<'_> {
    /// The distance to the barrier and its derivative.
    fn distance(&self, s: f64) -> [f64; 2] {
        let [place, velocity, _] = self.motion.contact(self.contact, self.i, s);
        let sign = self.barrier.sign();
        [sign * (self.stop - place), -sign * velocity]
    }

    /// The least distance at a turning point or end of the flight, and where; `None` if it only goes. `leaves`, `arrives`: it is on the
    /// barrier at the ends, and surely off it for so long after the first.
    fn least(&self, leaves: Option<f64>, arrives: bool) -> Result<Option<(f64, f64)>, BreatherError> {
        let bend = |s: f64| self.motion.bound(self.contact, 2, self.i, [s, self.length]) * (1.0 + 1e-12);
        let whole = bend(0.0);
        let (first, last) = (self.distance(0.0), self.distance(self.length));
        // Between its first turn and here it comes back no farther than this.
        let mut s = leaves.map_or(0.0, |clear| (1.999 * first[1] / whole).max(clear));
        let end = if arrives { self.length - (1.999 * -last[1] / whole).max(0.0) } else { self.length };
        let mut least: Option<(f64, f64)> = None;
        let mut keep = |d: f64, s: f64| {
            if least.is_none_or(|(other, _)| d < other) {
                least = Some((d, s));
            }
        };
        s = s.min(end);
        let mut before: Option<(f64, f64)> = None;
        for _ in 0..MOST_STEPS {
            self.motion.heard()?;
            let [d, slope] = self.distance(s);
            if let Some((s_before, slope_before)) = before
                && slope_before < 0.0
                && slope >= 0.0
            {
                let turn = self.turning(s_before, s);
                keep(self.distance(turn)[0], turn);
            }
            if d <= self.touch {
                // Beyond, or as good as there: how far it goes.
                let turn = self.deepest(s);
                keep(self.distance(turn)[0].min(0.0), turn);
                return Ok(least);
            }
            if s >= end {
                return Ok(least);
            }
            let bend = bend(s).max(f64::MIN_POSITIVE);
            let step = (slope + (slope * slope + 2.0 * bend * d).sqrt()) / bend;
            before = Some((s, slope));
            s = (s + step.max(1e-9 * self.length)).min(end);
        }
        Err(BreatherError::LongFlight { contact: self.contact, steps: MOST_STEPS })
    }

    /// Where the distance turns between two places.
    fn turning(&self, low: f64, high: f64) -> f64 {
        let slope = |s: f64| self.distance(s)[1];
        if slope(low) >= 0.0 {
            return low;
        }
        let Ok(turn) = zero((low, slope(low)), (high, slope(high)), self.length, |s| Ok::<_, Infallible>(slope(s)));
        turn
    }

    /// The first turn after a place beyond the barrier.
    fn deepest(&self, from: f64) -> f64 {
        let step = 1e-3 * self.length;
        let mut s = from;
        while s < self.length {
            let next = (s + step).min(self.length);
            if self.distance(next)[1] >= 0.0 {
                return self.turning(s, next);
            }
            s = next;
        }
        self.length
    }
}

/// Looks at the flight after impact `i` by bounds alone, step by step.
pub(super) fn search(
    search: &mut Search<'_>,
    orbit: &ContactOrbit,
    motion: &ContactMotion<'_>,
    order: &[usize],
    i: usize,
) -> Result<(), BreatherError> {
    let (begins, length) = (orbit.impacts()[i].time, motion.until_next(i));
    for &contact in order {
        let stops = &orbit.model().structure().contacts()[contact];
        for barrier in [Barrier::Lower, Barrier::Upper] {
            let Some(stop) = stops.barrier(barrier) else { continue };
            if search.is_decided() {
                continue;
            }
            let touch = TOUCH * stops.reach().max(f64::MIN_POSITIVE);
            let watch = Watch { motion, contact, barrier, stop, i, length, touch };
            let leaves = search.clear_after(contact, barrier, begins);
            let arrives = search.clear_after(contact, barrier, begins + length).is_some();
            if let Some((least, s)) = watch.least(leaves, arrives)? {
                search.note(least, (contact, barrier), begins + s);
            }
        }
    }
    Ok(())
}
