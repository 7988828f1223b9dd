//! What else happens along a curve: monitors, which change their sign where it does.

use nalgebra::Complex;

use super::answer::Special;
use super::tracer::{TracedPoint, Tracer, is_physical};
use crate::events::half_sums::upper_half;
use crate::events::{AtEvent, TOUCHES, Test, another_one, minus_one};
use crate::locate::Event;
use crate::verdict::Tolerance;

type C = Complex<f64>;

/// The least growth that tells a pair from the circle.
pub(super) const GROWTH: f64 = 1e-12;

/// Something that happens on a curve where its value changes the sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Monitor {
    pub(super) special: Special,
    /// Which of several of one kind.
    which: usize,
    pub(super) value: f64,
}

impl Monitor {
    pub(super) fn is(&self, other: &Self) -> bool {
        (self.special, self.which) == (other.special, other.which)
    }
}

/// What is seen at a point.
#[derive(Debug, Clone, Default)]
pub(super) struct Seen {
    pub(super) monitors: Vec<Monitor>,
    /// Whether the orbit is physical, touches aside.
    pub(super) physical: Option<bool>,
    /// Whether pairs are left out that do not grow enough to be told from the circle.
    pub(super) on_circle: bool,
}

impl Seen {
    /// How many pairs of multipliers are watched on their way to the circle.
    pub(super) fn pairs(&self) -> usize {
        self.monitors.iter().filter(|monitor| monitor.special == Special::With(Event::NeimarkSacker)).count()
    }
}

impl Tracer<'_> {
    /// What is seen at a point; pairs that grow or fall by no more than `least` are taken to be on the circle.
    pub(super) fn seen(&mut self, point: &TracedPoint, least: f64) -> Seen {
        let AtEvent { orbit, mark, determinant, fold_determinant } = point.orbit();
        let mut monitors = Vec::new();
        let mut add = |special, which, value: f64| {
            if value.is_finite() {
                monitors.push(Monitor { special, which, value });
            }
        };
        let (speed, event) = (orbit.speed(), self.asked.event);
        let told = self.watcher.admissibility(orbit).ok();
        let physical = told.as_ref().map(|told| is_physical(told, orbit));
        if let (true, Some(theta)) = (self.has_angle(), *mark) {
            // There the curve ends.
            add(Special::OneToOne, 0, theta);
            add(Special::OneToTwo, 0, std::f64::consts::PI - theta);
        }
        let mut on_circle = false;
        if !self.asked.walk.special {
            return Seen { monitors, physical, on_circle };
        }
        for (i, impact) in orbit.impacts().iter().enumerate() {
            if !self.grazing.contains(&i) {
                add(Special::With(Event::Grazing), 1 + i, impact.barrier.sign() * impact.velocity_before / speed);
            }
        }
        for (i, hit) in orbit.hits().iter().enumerate() {
            if let (false, Ok(Some([acceleration, _]))) = (self.test == Test::Release(i), orbit.acceleration_after(i)) {
                add(
                    Special::With(Event::Sticking),
                    i,
                    -hit.barrier.sign() * acceleration / (orbit.model().omega() * speed),
                );
            }
        }
        // Where one touches all along, be it with an impact, others are told once they are beyond.
        let own = if event == Event::Grazing { TOUCHES } else { 0.0 };
        if let Some(margin) = told.and_then(|told| told.margin) {
            add(Special::With(Event::Grazing), 0, margin * orbit.model().omega() / speed + own);
        }
        if let (true, Some(theta)) = (self.has_angle(), *mark) {
            add(Special::OneToThree, 0, theta.cos() + 0.5);
            add(Special::OneToFour, 0, theta.cos());
        }
        if !matches!(event, Event::Fold | Event::Pitchfork) && !orbit.is_conservative() {
            add(Special::With(Event::Fold), 0, *fold_determinant);
            if determinant != fold_determinant {
                add(Special::With(Event::Pitchfork), 0, determinant / fold_determinant);
            }
        }
        // An impact without velocity leaves no multiplier that could be told.
        if !matches!(self.test, Test::Velocity(_)) {
            if self.test != Test::MinusOne {
                add(Special::With(Event::PeriodDoubling), 0, minus_one(orbit).unwrap_or(f64::NAN));
            }
            if self.test != Test::AnotherOne {
                add(Special::With(Event::Pitchfork), 1, another_one(orbit).unwrap_or(f64::NAN));
            }
            // Where multipliers cannot be computed no special point is reported; the curve itself does not need them.
            let values =
                self.watcher.spectrum(orbit, Tolerance::Rounding).map(|(values, _)| values).unwrap_or_default();
            on_circle = self.multipliers(&values, orbit.is_lossless(), least, &mut add);
        }
        Seen { monitors, physical, on_circle }
    }

    /// Another multiplier where the curve's own is, and pairs that cross the circle; whether some are left out as being on it.
    fn multipliers(&self, values: &[C], lossless: bool, least: f64, add: &mut dyn FnMut(Special, usize, f64)) -> bool {
        let own = match self.test {
            Test::Fold | Test::One | Test::AnotherOne => Some((1.0, Special::OneToOne)),
            Test::MinusOne => Some((-1.0, Special::OneToTwo)),
            _ => None,
        };
        if let Some((goal, strong)) = own {
            add(strong, 0, second_at(C::new(goal, 0.0), values));
        }
        if lossless {
            return false;
        }
        let mut growths: Vec<f64> = upper_half(values).into_iter().map(|value| value.norm().ln()).collect();
        let all = growths.len();
        growths.retain(|growth| growth.abs() >= least);
        let on_circle = growths.len() < all;
        if self.test == Test::Circle {
            let own = growths.iter().map(|growth| growth.abs()).fold(f64::INFINITY, f64::min);
            growths.retain(|growth| growth.abs() > own);
        }
        growths.sort_by(|a, b| b.total_cmp(a));
        growths.into_iter().enumerate().for_each(|(k, growth)| add(Special::With(Event::NeimarkSacker), k, growth));
        on_circle
    }
}

/// Changes its sign where, beside one of `values` that is at `goal`, a second one gets there.
///
/// Rounding splits the two where they meet, but leaves their sum alone. All others count by their directions only, so that the function is
/// as large as the distance of the second one. NaN where there is none.
fn second_at(goal: C, values: &[C]) -> f64 {
    let mut from_goal: Vec<C> = values.iter().map(|value| (value - goal) / (1.0 + value.norm())).collect();
    from_goal.sort_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()));
    if from_goal.len() < 2 {
        return f64::NAN;
    }
    let rest: C = from_goal[2..].iter().map(|value| value / value.norm()).product();
    (from_goal[..2].iter().sum::<C>() * rest).re
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The zeros of (x + 1)(x + 1 − s)(x² + 1)(x − 2), split by rounding where two meet.
    #[test]
    fn a_second_multiplier_is_seen_through_the_split_of_the_first_two() {
        let goal = C::new(-1.0, 0.0);
        let at = |s: f64| {
            let middle = -1.0 + 0.5 * s;
            let apart = C::new(0.25 * s * s - 1e-16, 0.0).sqrt();
            let values = [goal + middle + 1.0 + apart, goal + middle + 1.0 - apart];
            second_at(goal, &[values[0], C::new(0.0, 1.0), C::new(0.0, -1.0), values[1], C::new(2.0, 0.0)])
        };
        for s in [1e-2, 1e-5, 1e-8, 1e-11] {
            for sign in [-1.0, 1.0] {
                assert!((at(sign * s) / (0.5 * sign * s) - 1.0).abs() < 2.0 * s + 1e-4, "{s}: {}", at(sign * s));
            }
        }
        // One alone, as a mass has it that nothing drives, has no second one, whatever rounding makes of it.
        assert!(second_at(goal, &[]).is_nan() && second_at(goal, &[goal + 1e-15]).is_nan());
    }
}
