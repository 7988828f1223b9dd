//! By windows of one radian of the fastest motion, in which the motion of every mass is a polynomial.

use super::Watch;
use crate::admissible::gap::{Closest, Depth, Gap, RESOLUTION};
use crate::error::BreatherError;
use crate::motion::Motion;
use crate::motion::polynomial::{turning_points, with_overlap};
use crate::orbit::LatticeOrbit;

/// A window's length in radians of the fastest motion; with it the polynomials' order is enough.
const WINDOW: f64 = 1.0;

/// A mass slower than this, in the window's units, where an interval begins with another's impact, turns right there, for what a
/// displacement can tell: 1e-18 of it is missing. By rounding the turning point may be in neither interval.
const STILL: f64 = 1e-9;

/// Impacts closer than this part of the period are at one instant.
const SIMULTANEOUS: f64 = 1e-9;

/// Windows that are looked at before a motion is declared too stiff to be followed.
const MAX_WINDOWS: f64 = 5e6;

impl Watch {
    pub(super) fn by_windows(
        &mut self,
        orbit: LatticeOrbit<'_>,
        motion: &mut Motion,
        depth: Depth,
        horizon: f64,
        closest: &mut Closest,
    ) -> Result<(), BreatherError> {
        let model = orbit.model();
        let a = model.asymmetry();
        let gap = Gap::around(a);
        let is_hit = |site: usize| orbit.impacts().iter().any(|impact| impact.site == site);
        let hit_at = |site: usize, t: f64| {
            let then = |time: f64| (time - t).abs() <= SIMULTANEOUS * orbit.period();
            orbit.impacts().iter().any(|impact| impact.site == site && then(impact.time))
        };
        let turns_back = orbit.is_reversible() && horizon == 0.5 * orbit.period();
        let goes_on = orbit.is_reversible() && !turns_back;
        let rate = motion.top_frequency() / WINDOW;
        if horizon * rate > MAX_WINDOWS {
            return Err(BreatherError::TooStiff { windows: horizon * rate, limit: MAX_WINDOWS });
        }
        // A ring whose modes all stand still takes its unit from the period.
        self.window.set_rate(rate.max(1.0 / horizon));
        let force = model.force_wave();
        let unit = self.window.unit();
        'search: for interval in 0..motion.intervals() {
            let (start, length) = motion.interval(interval);
            if start >= horizon {
                break;
            }
            let length = length.min(horizon - start);
            let windows = 1 + (length * rate) as usize;
            // In the window's units of time.
            let step = length / windows as f64 / unit;
            self.window.set(&self.watched, motion, interval, 0.0);
            for w in 0..windows {
                self.stop.heard()?;
                let elapsed = length * (w as f64 / windows as f64);
                if w > 0 {
                    self.window.advance(&self.watched, motion, interval, elapsed);
                }
                for (i, &site) in self.watched.sites().iter().enumerate() {
                    let still = || self.window.velocity(i).abs() < STILL;
                    if !is_hit(site) || w == 0 && !hit_at(site, start) && still() {
                        closest.note(gap, site, start + elapsed, self.window.displacement(i));
                    }
                }
                let pushes = self.window.pushes(&force, motion.force_time(interval, elapsed));
                for block in self.window.blocks(&self.watched) {
                    self.window.expand(&self.watched, model, &pushes, block.clone());
                    self.window.enclose(step);
                    for i in block {
                        let (low, high) = self.window.range(i);
                        if (1.0 - (high - a)).min(1.0 + (low - a)) < closest.distance - RESOLUTION {
                            let (polynomial, site) = (self.window.polynomial(i), self.watched.sites()[i]);
                            turning_points(
                                &polynomial,
                                with_overlap(step, [w > 0, w + 1 < windows || goes_on]),
                                &mut self.pending,
                                closest.distance,
                                &mut |s, displacement| {
                                    closest.note(gap, site, start + elapsed + s * unit, displacement);
                                    closest.distance
                                },
                                a,
                            );
                        }
                    }
                }
                if depth == Depth::First && closest.distance <= 0.0 {
                    break 'search;
                }
            }
            // The end of the last window: masses that are not hit may turn right there, and at a reversible half period
            // those do that are hit at its other end alone.
            let turns = turns_back && start + length >= horizon;
            let late = |site: usize| orbit.impacts().iter().any(|impact| impact.site == site && impact.time > 0.0);
            for (i, &site) in self.watched.sites().iter().enumerate() {
                if !is_hit(site) || turns && !late(site) {
                    closest.note(gap, site, start + length, self.window.final_displacement(i));
                }
            }
        }
        // An impact's interval may reach beyond the period.
        closest.time = closest.time.rem_euclid(orbit.period());
        Ok(())
    }
}
