//! By local series: every mass as a polynomial of its own from the equation of motion, on windows of one radian of the fastest motion.

use vibrochain_lattice::DistinctMasses;

use super::search::Search;
use crate::admissible::gap::{Gap, RESOLUTION};
use crate::error::BreatherError;
use crate::motion::Motion;
use crate::motion::polynomial::{turning_points, with_overlap};
use crate::motion::window::Window;
use crate::orbit::LatticeOrbit;

/// A window is as long as the fastest motion takes for one radian: then the polynomials' order leaves a remainder below rounding.
const WINDOW: f64 = 1.0;

/// A mass slower than this, in the window's units, where an interval begins with another's impact, turns right there, for what a
/// displacement can tell: 1e-18 of it is missing. By rounding the turning point may be in neither interval.
const STILL: f64 = 1e-9;

/// Windows that are looked at before a motion is declared too stiff to be followed.
const MAX_WINDOWS: f64 = 5e6;

/// A flight between impacts: its number, how long it is looked at, and whether it goes on after that or ends with a turn of every mass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    pub(super) interval: usize,
    pub(super) begins: f64,
    pub(super) whole: f64,
    pub(super) goes_on: bool,
    pub(super) turns: bool,
}

/// Sets the window's unit of time by the fastest motion of an orbit, which is checked until `horizon`.
///
/// # Errors
/// [`BreatherError::TooStiff`]
pub(super) fn lay(window: &mut Window, motion: &Motion, horizon: f64) -> Result<(), BreatherError> {
    let rate = motion.top_frequency() / WINDOW;
    if horizon * rate > MAX_WINDOWS {
        return Err(BreatherError::TooStiff { windows: horizon * rate, limit: MAX_WINDOWS });
    }
    // A ring whose modes all stand still takes its unit from the period.
    window.set_rate(rate.max(1.0 / horizon));
    Ok(())
}

impl Search<'_> {
    /// Turning points of all masses in a flight.
    pub(super) fn by_series(
        &mut self,
        orbit: LatticeOrbit<'_>,
        motion: &mut Motion,
        (watched, window): (&DistinctMasses, &mut Window),
        Stretch { interval, begins, whole, goes_on, turns }: Stretch,
    ) -> Result<(), BreatherError> {
        let (model, a) = (orbit.model(), orbit.model().asymmetry());
        let (gap, force, unit) = (Gap::around(a), model.force_wave(), window.unit());
        let is_hit = |site: usize| orbit.impacts().iter().any(|impact| impact.site == site);
        let windows = 1 + (whole * motion.top_frequency() / WINDOW) as usize;
        // In the window's units of time.
        let step = whole / windows as f64 / unit;
        window.set(watched, motion, interval, 0.0);
        for w in 0..windows {
            self.stop.heard()?;
            let elapsed = whole * (w as f64 / windows as f64);
            if w > 0 {
                window.advance(watched, motion, interval, elapsed);
            }
            for (i, &site) in watched.sites().iter().enumerate() {
                let still = || window.velocity(i).abs() < STILL;
                if !is_hit(site) || w == 0 && !self.hits_at(site, begins) && still() {
                    self.closest.note(gap, site, begins + elapsed, window.displacement(i));
                }
            }
            let pushes = window.pushes(&force, motion.force_time(interval, elapsed));
            for block in window.blocks(watched) {
                window.expand(watched, model, &pushes, block.clone());
                window.enclose(step);
                for i in block {
                    let (low, high) = window.range(i);
                    if (1.0 - (high - a)).min(1.0 + (low - a)) < self.closest.distance - RESOLUTION {
                        let (polynomial, site) = (window.polynomial(i), watched.sites()[i]);
                        let range = with_overlap(step, [w > 0, w + 1 < windows || goes_on]);
                        let closest = &mut self.closest;
                        let (pending, so_far) = (&mut self.lists.pending, closest.distance);
                        let mut note = |s: f64, displacement: f64| {
                            closest.note(gap, site, begins + elapsed + s * unit, displacement);
                            closest.distance
                        };
                        turning_points(&polynomial, range, pending, so_far, &mut note, a);
                    }
                }
            }
            if self.is_decided() {
                return Ok(());
            }
        }
        // The end of the last window: masses that are not hit may turn right there, and at a reversible half period
        // those do that are hit at its other end alone.
        let late = |site: usize| orbit.impacts().iter().any(|impact| impact.site == site && impact.time > 0.0);
        for (i, &site) in watched.sites().iter().enumerate() {
            if !is_hit(site) || turns && !late(site) {
                self.closest.note(gap, site, begins + whole, window.final_displacement(i));
            }
        }
        Ok(())
    }
}
