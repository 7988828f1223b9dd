//! Where something else happens on a curve: points of codimension two.

use vibrochain_breather::{Obstruction, SurfacePoint};

use super::answer::Special;
use super::signal::{Blind, Signal, TOUCHES};
use super::walker::{Aspects, Foot, Walker};
use crate::bracket::{JUMP, SAFETY, zero};
use crate::locate::Event;
use crate::locate::spectrum_events::upper_half;

/// The least growth that tells a pair from the circle.
const GROWTH: f64 = 1e-12;

/// So many factors of a determinant are multiplied as they are: of more the product may have no place among numbers.
const MOST_FACTORS: f64 = 256.0;

/// How far beside a zero its function is looked at once more, as a part of the step.
const BESIDE: f64 = 1e-4;

impl Walker {
    pub(super) fn aspects(&mut self, point: &SurfacePoint, mark: f64) -> Aspects {
        let mut seen = Aspects::default();
        self.contacts(point, &mut seen);
        if self.special {
            self.determinants(point, &mut seen);
            // Where multipliers cannot be computed no special point is reported; the curve itself does not need them.
            let _ = self.multipliers(point, &mut seen);
        } else {
            seen.monitors.clear();
        }
        if self.signal.has_angle() {
            if self.special {
                seen.add(Special::OneToThree, 0, mark + 0.5);
                seen.add(Special::OneToFour, 0, mark);
            }
            // There the curve ends.
            seen.add(Special::OneToOne, 0, 1.0 - mark);
            seen.add(Special::OneToTwo, 0, 1.0 + mark);
            seen.ends = mark.abs() > 1.0;
        }
        seen
    }

    /// Other impacts that lose their velocity, and other masses that touch.
    fn contacts(&mut self, point: &SurfacePoint, seen: &mut Aspects) {
        let orbit = point.orbit();
        for (i, impact) in orbit.impacts().iter().enumerate() {
            // Those that lose their velocity together with the event's own tell nothing.
            if !self.grazing.contains(&i) {
                seen.add(Special::With(Event::Grazing), 1 + i, impact.velocity_before * impact.barrier.sign());
            }
        }
        let Ok(told) = self.sight.finder.admissibility(orbit) else { return };
        seen.physical = Some(match told.obstruction {
            None => true,
            Some(Obstruction::Crossing { excess, .. }) => excess <= TOUCHES,
            Some(Obstruction::WrongSign { velocity_before, .. }) => {
                velocity_before.abs() <= TOUCHES * orbit.model().omega()
            }
        });
        if let Some(margin) = told.margin {
            // Where one mass touches all along, be it with an impact, others are told once they are beyond.
            let own = if self.event == Event::Grazing { TOUCHES } else { 0.0 };
            seen.add(Special::With(Event::Grazing), 0, margin + own);
        }
    }

    /// Folds and pitchforks of the orbit's own equations.
    fn determinants(&mut self, point: &SurfacePoint, seen: &mut Aspects) {
        if self.event == Event::Fold || point.orbit().model().is_conservative() {
            return;
        }
        let (all, kept) = (point.determinant(), point.fold_determinant());
        if self.event != Event::Pitchfork {
            seen.add(Special::With(Event::Fold), 0, kept);
            if all != kept {
                seen.add(Special::With(Event::Pitchfork), 0, all / kept);
            }
        }
    }

    /// Multipliers ±1 and pairs on the circle, those of the curve's own event left out.
    fn multipliers(&mut self, point: &SurfacePoint, seen: &mut Aspects) -> Result<(), Blind> {
        let orbit = point.orbit();
        // An impact without velocity leaves no multiplier that could be told.
        if matches!(self.signal, Signal::Velocity(_)) {
            return Ok(());
        }
        let values = self.sight.spectrum(orbit)?;
        if values.is_empty() {
            return Ok(());
        }
        let own = match self.signal {
            Signal::Shifted { shift, .. } => Some(-shift),
            Signal::Fold | Signal::Equations => Some(1.0),
            _ => None,
        };
        let (elastic, conservative) = (orbit.model().loss() == 0.0, orbit.model().is_conservative());
        // A root of a product hides the one factor that vanishes: the more, the higher it is.
        let root = (values.len() as f64 / MOST_FACTORS).max(1.0);
        for (goal, event, strong) in
            [(-1.0, Event::PeriodDoubling, Special::OneToTwo), (1.0, Event::Pitchfork, Special::OneToOne)]
        {
            if own == Some(goal) {
                // All but the nearest.
                let nearest = values.iter().map(|value| (value - goal).norm()).fold(f64::INFINITY, f64::min);
                let rest = values.iter().filter(|value| (*value - goal).norm() > nearest);
                let product = rest.fold((0.0, 1.0), |(log, sign), value| {
                    let factor = value - goal;
                    let sign = if value.im == 0.0 { sign * factor.re.signum() } else { sign };
                    (log + factor.norm().ln(), sign)
                });
                seen.add(strong, 0, product.1 * (product.0 / root).exp());
            } else if goal < 0.0 || conservative {
                let (log, sign) = self.sight.determinant(orbit, -goal);
                seen.add(Special::With(event), 9, sign * (log / root).exp());
            }
        }
        if !elastic {
            let mut growths: Vec<f64> =
                upper_half(&values).iter().map(|value| value.norm().ln()).filter(|x| x.abs() > GROWTH).collect();
            if matches!(self.signal, Signal::Pair) {
                let own = growths.iter().map(|x| x.abs()).fold(f64::INFINITY, f64::min);
                growths.retain(|x| x.abs() > own);
            }
            growths.sort_by(|a, b| b.total_cmp(a));
            growths.iter().enumerate().for_each(|(k, x)| seen.add(Special::With(Event::NeimarkSacker), k, *x));
        }
        Ok(())
    }

    /// How the curve goes on in the plane of the parameters, at a foot from which it leads on along `along`.
    fn velocity(&mut self, foot: &Foot, along: [f64; 2]) -> Result<[f64; 2], Blind> {
        let gradient = self.gradient(&foot.point, foot.mark)?;
        let norm = gradient[0].hypot(gradient[1]);
        let direction = [-gradient[1] / norm, gradient[0] / norm];
        let sign = (direction[0] * along[0] + direction[1] * along[1]).signum();
        Ok(foot.point.heading(direction.map(|x| sign * x)))
    }

    /// All that happens between the last of some feet and the next, in the order of the way, with its error.
    pub(super) fn between(&mut self, feet: &[Foot], direction: [f64; 2], next: &Foot) -> Vec<(Special, Foot, f64)> {
        let Some(last) = feet.last() else { return Vec::new() };
        let length = next.at - last.at;
        let mut found = Vec::new();
        for monitor in last.aspects.monitors.clone() {
            let Some(value) = next.aspects.get(&monitor) else { continue };
            if (value > 0.0) == (monitor.value > 0.0) {
                continue;
            }
            let ends = [monitor.value, value];
            let located =
                self.located(feet, direction, (length, ends), |_, foot| foot.aspects.get(&monitor).ok_or(Blind::Other));
            found.extend(located.map(|(foot, error)| (monitor.special, foot, error)));
        }
        if self.event == Event::Fold {
            found.extend(self.cusp(feet, direction, next, length));
        }
        found.sort_by(|one, other| one.1.at.total_cmp(&other.1.at));
        found
    }

    fn cusp(&mut self, feet: &[Foot], direction: [f64; 2], next: &Foot, length: f64) -> Option<(Special, Foot, f64)> {
        let last = feet.last()?;
        let along = self.surface.between(&last.point, &next.point);
        let before = self.velocity(last, along).ok()?;
        let back = self.surface.between(&next.point, &last.point).map(|x| -x);
        let after = self.velocity(next, back).ok()?;
        let against = |velocity: [f64; 2]| velocity[0] * before[0] + velocity[1] * before[1];
        if against(after) > 0.0 {
            return None;
        }
        let ends = [against(before), against(after)];
        let from = last.point.clone();
        let (foot, error) = self.located(feet, direction, (length, ends), |walker, foot| {
            let back = walker.surface.between(&foot.point, &from).map(|x| -x);
            let along = if back[0].hypot(back[1]) > 0.0 { back } else { along };
            Ok(against(walker.velocity(foot, along)?))
        })?;
        Some((Special::Cusp, foot, error))
    }

    /// The foot at which a function vanishes that has these values at both ends of a step, and its error.
    fn located(
        &mut self,
        feet: &[Foot],
        direction: [f64; 2],
        (length, ends): (f64, [f64; 2]),
        mut function: impl FnMut(&mut Self, &Foot) -> Result<f64, Blind>,
    ) -> Option<(Foot, f64)> {
        let mut at = |walker: &mut Self, h: f64| -> Result<(Foot, f64), Blind> {
            let foot = walker.advance(feet, direction, h)?;
            let value = function(walker, &foot)?;
            Ok((foot, value))
        };
        let h = zero((0.0, ends[0]), (length, ends[1]), length, |h| at(self, h).map(|(_, value)| value)).ok()?;
        let (foot, value) = at(self, h).ok()?;
        if value.abs() > JUMP * ends[0].abs().max(ends[1].abs()) {
            return None;
        }
        // One end of a corner is as straight as the other.
        let step = BESIDE * length;
        let beside = |walker: &mut Self, h: f64| at(walker, h).ok().map(|(_, value)| value);
        let mut beside = beside;
        let (low, high) = (beside(self, h - step), beside(self, h + step));
        let slope = match (low, high) {
            (Some(low), Some(high)) => (high - low) / (2.0 * step),
            (Some(low), None) => (value - low) / step,
            (None, Some(high)) => (high - value) / step,
            (None, None) => return None,
        };
        let middle = low.zip(high).map_or(0.0, |(low, high)| value - 0.5 * (low + high));
        let error = (SAFETY * (value.abs() + middle.abs()) / slope.abs()).min(length) + 4.0 * f64::EPSILON;
        Some((foot, error))
    }
}
