//! Is an orbit physical? Every impact must meet its barrier from inside, and between impacts every mass must stay
//! strictly inside the gap, for the whole period: decided by bounds, not by samples.
//!
//! The distance of a mass to a barrier is smallest at a turning point, v̇_n = 0 (impacts of the mass itself aside, where it
//! is 0 by definition). On an interval |t − c| ≤ r, with |v⃛| ≤ B,
//!
//! ```text
//! v(t) ∈ v ± (|v̇| r + |v̈| r²/2 + B r³/6),        v̇(t) ∈ v̇ ± (|v̈| r + B r²/2)         (values at c)
//! ```
//!
//! so that an interval is discarded if it cannot come closer than the smallest distance known so far, or if v̇ has no
//! zero on it; settled if v̈ has none (one turning point at most, found to rounding); and halved otherwise. The
//! smallest distance of all is the margin.

use vibrochain_lattice::Barrier;

use crate::error::BreatherError;
use crate::motion::{Kinematics, Motion};
use crate::orbit::Orbit;

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
/// [`BreatherError::Resonance`], which an orbit that exists has already passed.
pub fn admissibility(orbit: &Orbit) -> Result<Admissibility, BreatherError> {
    let mut motion = Motion::of(orbit)?;
    Ok(Watch::default().check(orbit, &mut motion))
}

/// Work space of the check.
#[derive(Debug, Clone, Default)]
pub(crate) struct Watch {
    /// (site, interval, centre, radius)
    pending: Vec<(usize, usize, f64, f64)>,
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

/// Intervals this narrow against the fastest motion are settled as they are: v changes by less than rounding on them.
const NARROW: f64 = 1e-9;

impl Watch {
    /// Decides for `orbit`, whose motion `motion` holds.
    pub(crate) fn check(&mut self, orbit: &Orbit, motion: &mut Motion) -> Admissibility {
        if let Some((impact, wrong)) = orbit.impacts().iter().enumerate().find(|(_, impact)| !impact.is_right_signed())
        {
            let obstruction = Obstruction::WrongSign {
                impact,
                site: wrong.site,
                time: wrong.time,
                velocity_before: wrong.velocity_before,
            };
            return Admissibility { margin: None, obstruction: Some(obstruction) };
        }
        let model = orbit.model();
        let a = model.asymmetry();
        let mut closest = Closest { distance: f64::INFINITY, site: 0, barrier: Barrier::Lower, time: 0.0 };
        // Impacts at one site: the ring is symmetric about it. Reversible: so is time, about 0 and half a period.
        let sites = motion.sites();
        let home = orbit.impact_site();
        let watched = if home.is_some() { sites / 2 + 1 } else { sites };
        let place = |n: usize| home.map_or(n, |home| (home + n) % sites);
        let is_hit = |site: usize| orbit.impacts().iter().any(|impact| impact.site == site);
        let horizon = if orbit.is_reversible() { 0.5 * orbit.period() } else { orbit.period() };
        let top = motion.top_frequency();
        for interval in 0..motion.intervals() {
            let (start, length) = motion.interval(interval);
            if start >= horizon {
                break;
            }
            let length = length.min(horizon - start);
            // About one radian of the fastest motion to begin with.
            let pieces = 2 + (0.7 * length * top) as usize;
            let radius = 0.5 * length / pieces as f64;
            let jerk = motion.jerk_bound(interval);
            self.pending.clear();
            for piece in 0..pieces {
                let centre = (2 * piece + 1) as f64 * radius;
                motion.seek(interval, centre);
                for n in 0..watched {
                    let site = place(n);
                    let now = motion.site(site);
                    if !is_hit(site) {
                        closest.note(a, site, start + centre, now.displacement);
                    }
                    if may_turn_closer(&now, radius, jerk, a, closest.distance) {
                        self.pending.push((site, interval, centre, radius));
                    }
                }
            }
            // A mass that is not hit may turn exactly where intervals meet; symmetry makes it turn at both ends of a
            // reversible half period, and there a single-sided breather's own mass too.
            for (elapsed, is_end) in [(0.0, false), (length, true)] {
                motion.seek(interval, elapsed);
                for n in 0..watched {
                    let site = place(n);
                    let turns_at_end = is_end && orbit.is_reversible() && orbit.impacts().len() == 1;
                    if !is_hit(site) || turns_at_end {
                        closest.note(a, site, start + elapsed, motion.site(site).displacement);
                    }
                }
            }
            while let Some((site, interval, centre, radius)) = self.pending.pop() {
                self.refine(motion, (site, interval), (centre, radius), start, jerk, a, &mut closest);
            }
        }
        let obstruction = (closest.distance <= 0.0).then_some(Obstruction::Crossing {
            site: closest.site,
            barrier: closest.barrier,
            time: closest.time,
            excess: -closest.distance,
        });
        Admissibility { margin: closest.distance.is_finite().then_some(closest.distance), obstruction }
    }

    /// One interval of one mass: discard, settle or halve.
    #[expect(clippy::too_many_arguments, reason = "one interval and the state of the search")]
    fn refine(
        &mut self,
        motion: &mut Motion,
        (site, interval): (usize, usize),
        (centre, radius): (f64, f64),
        start: f64,
        jerk: f64,
        a: f64,
        closest: &mut Closest,
    ) {
        motion.seek(interval, centre);
        let now = motion.site(site);
        if !may_turn_closer(&now, radius, jerk, a, closest.distance) {
            return;
        }
        if now.acceleration.abs() > jerk * radius {
            // v̇ is monotone: at most one turning point.
            if let Some((elapsed, displacement)) = turning_point(motion, site, interval, centre, radius) {
                closest.note(a, site, start + elapsed, displacement);
            }
        } else if radius * motion.top_frequency() < NARROW {
            closest.note(a, site, start + centre, now.displacement);
        } else {
            self.pending.push((site, interval, centre - 0.5 * radius, 0.5 * radius));
            self.pending.push((site, interval, centre + 0.5 * radius, 0.5 * radius));
        }
    }
}

/// Whether a mass could turn on the interval, nearer to a barrier than `distance`.
fn may_turn_closer(now: &Kinematics, radius: f64, jerk: f64, a: f64, distance: f64) -> bool {
    let (speed, acceleration) = (now.velocity.abs(), now.acceleration.abs());
    if speed > radius * (acceleration + 0.5 * jerk * radius) {
        return false;
    }
    let reach = radius * (speed + radius * (0.5 * acceleration + jerk * radius / 6.0));
    1.0 - (now.displacement - a).abs() - reach < distance
}

/// The zero of a monotone v̇ on an interval, if there is one: time since the interval's start, and the displacement.
fn turning_point(motion: &mut Motion, site: usize, interval: usize, centre: f64, radius: f64) -> Option<(f64, f64)> {
    let mut at = |elapsed: f64| {
        motion.seek(interval, elapsed);
        motion.site(site)
    };
    let (mut low, mut high) = (centre - radius, centre + radius);
    let (first, last) = (at(low).velocity, at(high).velocity);
    if first * last > 0.0 {
        return None;
    }
    let mut x = centre;
    for _ in 0..60 {
        let now = at(x);
        let step = now.velocity / now.acceleration;
        // Near the zero the displacement is flat: an error of `step` in time is one of v̈·step²/2 in place.
        if now.velocity == 0.0 || 0.5 * (now.velocity * step).abs() < 0.25 * f64::EPSILON {
            return Some((x, now.displacement - 0.5 * now.velocity * step));
        }
        if (now.velocity < 0.0) == (first < 0.0) {
            low = x;
        } else {
            high = x;
        }
        let newton = x - step;
        x = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    Some((x, at(x).displacement))
}
