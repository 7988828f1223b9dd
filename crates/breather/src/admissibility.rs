//! Is an orbit physical? Every impact must meet its barrier from inside, and between impacts every mass must stay
//! strictly inside the gap, for the whole period: decided by bounds, not by samples.
//!
//! The distance of a mass to a barrier is smallest at a turning point, v̇_n = 0 (impacts of the mass itself aside, where
//! it is 0 by definition). Window by window the motion of every mass is a polynomial p(s), exact to rounding. A mass is
//! passed over if its polynomial cannot come closer than the smallest distance known so far. Otherwise its turning
//! points are isolated: on |s − c| ≤ r, with |p‴| ≤ B,
//!
//! ```text
//! p′(s) ∈ p′ ± (|p″| r + B r²/2)     no turning point if 0 is outside,
//! p″(s) ∈ p″ ± B r                   at most one if 0 is outside, found by its change of sign,
//! ```
//!
//! and the interval is halved otherwise. The smallest distance of all is the margin. Symmetry halves the work twice:
//! masses n and M − n about a single impacted site, and a conservative orbit's mirror image in time.

use vibrochain_lattice::Barrier;

use crate::error::BreatherError;
use crate::motion::Motion;
use crate::orbit::Orbit;
use crate::window::{Polynomial, Watched, Window};

/// What keeps a solution from being an orbit of the real chain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Obstruction {
    /// An impact whose mass moves away from its barrier before it: the barrier would have to pull.
    WrongSign {
        /// Index of the impact.
        impact: usize,
        /// The mass.
        site: usize,
        /// Its time.
        time: f64,
        /// The velocity before it.
        velocity_before: f64,
    },
    /// A mass beyond a barrier between impacts; the place where it is farthest out.
    Crossing {
        /// The mass.
        site: usize,
        /// The barrier.
        barrier: Barrier,
        /// When, within the period.
        time: f64,
        /// By how much.
        excess: f64,
    },
}

impl std::fmt::Display for Obstruction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::WrongSign { impact, site, time, velocity_before } => write!(
                f,
                "impact {impact} (site {site}, t = {time}) has the wrong sign: the mass would leave its barrier at velocity {velocity_before} before being hit"
            ),
            Self::Crossing { site, barrier, time, excess } => {
                write!(f, "site {site} is {excess} beyond the {} barrier at t = {time}", barrier.name())
            }
        }
    }
}

/// The answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Admissibility {
    /// Smallest distance left between any mass and a barrier at a turning point; negative if a mass crosses. `None`
    /// if an impact has the wrong sign, which makes distances moot.
    pub margin: Option<f64>,
    /// What is in the way, if anything.
    pub obstruction: Option<Obstruction>,
    /// Where that smallest distance is.
    pub closest: Option<Approach>,
}

/// Where and when a mass comes closest to a barrier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    /// The mass.
    pub site: usize,
    /// The barrier.
    pub barrier: Barrier,
    /// When, within the period.
    pub time: f64,
}

impl Admissibility {
    /// Nothing is in the way.
    pub fn is_physical(&self) -> bool {
        self.obstruction.is_none()
    }
}

/// Checks an orbit: the one-shot form of [`crate::Finder::admissibility`].
///
/// # Errors
/// [`BreatherError::TooStiff`]; [`BreatherError::Resonance`], which an orbit that exists has already passed.
pub fn admissibility(orbit: &Orbit) -> Result<Admissibility, BreatherError> {
    let mut motion = Motion::of(orbit)?;
    Watch::default().check(orbit, &mut motion, Depth::Worst)
}

/// How far to look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Depth {
    /// To the worst obstruction.
    Worst,
    /// To the first one.
    First,
}

/// Work space of the check.
#[derive(Debug, Clone, Default)]
pub(crate) struct Watch {
    watched: Watched,
    window: Window,
    pending: Vec<(f64, f64)>,
}

/// The closest approach so far.
struct Closest {
    distance: f64,
    site: usize,
    barrier: Barrier,
    time: f64,
}

impl Closest {
    /// Takes note of a mass at one place; its distances to both barriers count.
    fn note(&mut self, asymmetry: f64, site: usize, time: f64, displacement: f64) {
        for barrier in [Barrier::Lower, Barrier::Upper] {
            let distance = 1.0 - (displacement - asymmetry) * barrier.sign();
            if distance < self.distance {
                *self = Self { distance, site, barrier, time };
            }
        }
    }
}

/// Closer approaches than this are not told apart: it is the rounding of a displacement of order 1.
const RESOLUTION: f64 = 8.0 * f64::EPSILON;

/// Intervals this narrow, as a part of their window, are settled as they are: p changes by less than rounding on them.
const NARROW: f64 = 1e-9;

/// A window's length in radians of the fastest motion; with it the polynomials' order is enough.
const WINDOW: f64 = 1.0;

/// Windows that are looked at before a motion is declared too stiff to be followed.
const MAX_WINDOWS: f64 = 5e6;

impl Watch {
    /// Decides for `orbit`, whose motion `motion` holds.
    pub(crate) fn check(
        &mut self,
        orbit: &Orbit,
        motion: &mut Motion,
        depth: Depth,
    ) -> Result<Admissibility, BreatherError> {
        if let Some((impact, wrong)) = orbit.impacts().iter().enumerate().find(|(_, impact)| !impact.is_right_signed())
        {
            let (site, time, velocity_before) = (wrong.site, wrong.time, wrong.velocity_before);
            let obstruction = Obstruction::WrongSign { impact, site, time, velocity_before };
            return Ok(Admissibility { margin: None, obstruction: Some(obstruction), closest: None });
        }
        let model = orbit.model();
        let a = model.asymmetry();
        let home = orbit.impact_site();
        self.watched.set(motion.sites(), home);
        let is_hit = |site: usize| orbit.impacts().iter().any(|impact| impact.site == site);
        let horizon = if orbit.is_reversible() { 0.5 * orbit.period() } else { orbit.period() };
        let rate = motion.top_frequency() / WINDOW;
        if horizon * rate > MAX_WINDOWS {
            return Err(BreatherError::TooStiff { windows: horizon * rate, limit: MAX_WINDOWS });
        }
        // A ring whose modes all stand still takes its unit from the period.
        self.window.set_rate(rate.max(1.0 / horizon));
        let force = model.force_wave();
        let unit = self.window.unit();
        let mut closest = Closest { distance: f64::INFINITY, site: 0, barrier: Barrier::Lower, time: 0.0 };
        'search: for interval in 0..motion.intervals() {
            let (start, length) = motion.interval(interval);
            if start >= horizon {
                break;
            }
            let length = length.min(horizon - start);
            let windows = 1 + (length * rate) as usize;
            // In the window's units of time.
            let step = length / windows as f64 / unit;
            self.window.place(&self.watched, motion, interval, 0.0);
            for w in 0..windows {
                let elapsed = length * (w as f64 / windows as f64);
                if w > 0 {
                    self.window.advance(&self.watched, motion, interval, elapsed);
                }
                self.window.expand(&self.watched, model, &force, motion.force_time(interval, elapsed));
                for (i, &site) in self.watched.sites.iter().enumerate() {
                    if !is_hit(site) {
                        closest.note(a, site, start + elapsed, self.window.displacement(i));
                    }
                }
                self.window.enclose(step);
                for (i, &site) in self.watched.sites.iter().enumerate() {
                    let (low, high) = self.window.range(i);
                    if (1.0 - (high - a)).min(1.0 + (low - a)) < closest.distance - RESOLUTION {
                        let polynomial = self.window.polynomial(i);
                        turning_points(
                            &polynomial,
                            step,
                            &mut self.pending,
                            &mut |s, displacement| {
                                closest.note(a, site, start + elapsed + s * unit, displacement);
                                closest.distance
                            },
                            a,
                        );
                    }
                }
                if depth == Depth::First && closest.distance <= 0.0 {
                    break 'search;
                }
            }
            // The end of the last window: masses that are not hit may turn right there, and at a reversible half period
            // a single-sided breather's own mass does.
            let ends = orbit.is_reversible() && orbit.impacts().len() == 1;
            for (i, &site) in self.watched.sites.iter().enumerate() {
                if ends || !is_hit(site) {
                    closest.note(a, site, start + length, self.window.final_displacement(i));
                }
            }
        }
        let (site, barrier, time) = (closest.site, closest.barrier, closest.time.rem_euclid(orbit.period()));
        let crossing = Obstruction::Crossing { site, barrier, time, excess: -closest.distance };
        let found = closest.distance.is_finite();
        Ok(Admissibility {
            margin: found.then_some(closest.distance),
            obstruction: (closest.distance <= 0.0).then_some(crossing),
            closest: found.then_some(Approach { site, barrier, time }),
        })
    }
}

/// Reports the turning points on 0 … `length` that could come closer than the smallest distance, which `note` returns.
fn turning_points(
    polynomial: &Polynomial,
    length: f64,
    pending: &mut Vec<(f64, f64)>,
    note: &mut impl FnMut(f64, f64) -> f64,
    a: f64,
) {
    let bound = polynomial.third_bound(length);
    let mut distance = f64::INFINITY;
    pending.clear();
    pending.push((0.0, length));
    while let Some((low, high)) = pending.pop() {
        let (centre, radius) = (0.5 * (low + high), 0.5 * (high - low));
        let [value, slope, curvature] = polynomial.jet(centre);
        let turn = radius * (curvature.abs() + 0.5 * bound * radius);
        let reach = radius * (slope.abs() + 0.5 * turn);
        if slope.abs() > turn || 1.0 - (value - a).abs() - reach >= distance {
            continue;
        }
        if curvature.abs() > bound * radius {
            if let Some((s, value)) = turning_point(polynomial, low, high) {
                distance = note(s, value);
            }
        } else if radius < NARROW * length {
            distance = note(centre, value);
        } else {
            pending.push((centre, high));
            pending.push((low, centre));
        }
    }
}

/// The zero of a monotone p′ on an interval, if there is one, and the displacement there.
fn turning_point(polynomial: &Polynomial, mut low: f64, mut high: f64) -> Option<(f64, f64)> {
    let (first, last) = (polynomial.evaluate(low).1, polynomial.evaluate(high).1);
    if first * last > 0.0 {
        return None;
    }
    let mut s = 0.5 * (low + high);
    for _ in 0..60 {
        let [value, slope, curvature] = polynomial.jet(s);
        let step = slope / curvature;
        // Near the zero the displacement is flat: an error of `step` in time is one of p″·step²/2 in place.
        if slope == 0.0 || 0.5 * (slope * step).abs() < 0.25 * f64::EPSILON {
            let shift = if slope == 0.0 { 0.0 } else { step };
            return Some((s - shift, value - 0.5 * slope * shift));
        }
        if (slope < 0.0) == (first < 0.0) {
            low = s;
        } else {
            high = s;
        }
        let newton = s - step;
        s = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    Some((s, polynomial.evaluate(s).0))
}
