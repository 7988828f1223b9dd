//! Steps along a curve.

use vibrochain_breather::line::{foreseen, side_ahead};
use vibrochain_breather::{Surface, SurfacePoint};
use vibrochain_lattice::Parameter;

use super::answer::CurveEnd;
use super::signal::{Blind, Sight, Signal, Value};
use super::walker::{Foot, Walker};

/// Steps by which the gradient of the signal is taken: error and rounding balance.
const GRADIENT: f64 = 1e-6;

/// Secants at most to one point. One that leaves as little as `SETTLED` is the last; from `NOISE` on so is one that shrinks no more, which
/// is rounding.
const SECANTS: usize = 12;
const NOISE: f64 = 1e-9;
const SETTLED: f64 = 4.0 * f64::EPSILON;

/// The curve may be this part of a step away from where it was expected.
const ASTRAY: f64 = 0.1;

/// Cosine of the angle by which it may turn in a step.
const STRAIGHT: f64 = 0.9;

/// From a start that was located to its error the curve is no farther than this.
const START: f64 = 1e-3;

/// The perpendicular, a quarter turn to the left.
fn across([x, y]: [f64; 2]) -> [f64; 2] {
    [-y, x]
}

pub(super) fn plus([x, y]: [f64; 2], [u, v]: [f64; 2], factor: f64) -> [f64; 2] {
    [x + factor * u, y + factor * v]
}

pub(super) fn length([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

impl Walker {
    pub(super) fn value(&mut self, point: &SurfacePoint, expected: f64) -> Result<Value, Blind> {
        self.sight.value(self.signal, point, expected)
    }

    /// Who looks for the same on another surface.
    pub(super) fn beside(&self, surface: Surface) -> Self {
        let stop = self.sight.finder.stop();
        let (sight, surface) = (Sight::new(self.sight.sites, stop), surface.until(stop));
        let Self { signal, event, window, tolerance, special, .. } = *self;
        Self { surface, sight, signal, grazing: self.grazing.clone(), event, window, tolerance, special }
    }

    pub(super) fn plane(&self, point: &SurfacePoint) -> [f64; 2] {
        self.window.parts(point.values())
    }

    /// The signal's gradient along both tangents.
    pub(super) fn gradient(&mut self, point: &SurfacePoint, mark: f64) -> Result<[f64; 2], Blind> {
        let here = self.value(point, mark)?.value;
        let mut gradient = [0.0; 2];
        for (i, slope) in gradient.iter_mut().enumerate() {
            let mut side = |h: f64| -> Result<f64, Blind> {
                let along = if i == 0 { [h, 0.0] } else { [0.0, h] };
                let there = self.surface.step(point, along)?;
                Ok(self.value(&there, mark)?.value)
            };
            // One-sided at the end of a parameter's range.
            *slope = match (side(GRADIENT), side(-GRADIENT)) {
                (Ok(high), Ok(low)) => (high - low) / (2.0 * GRADIENT),
                (Ok(high), Err(_)) => (high - here) / GRADIENT,
                (Err(_), Ok(low)) => (here - low) / GRADIENT,
                (Err(blind), Err(_)) => return Err(blind),
            };
        }
        if length(gradient) > 0.0 { Ok(gradient) } else { Err(Blind::Other) }
    }

    /// The first point, and a direction along the curve.
    pub(super) fn start(&mut self, mark: f64) -> Result<(Foot, [f64; 2]), Blind> {
        let mut point = self.surface.start()?;
        if let Signal::Shifted { shift, .. } = self.signal {
            let _ = self.sight.spectrum(point.orbit())?;
            // At the event itself there is no size: that of a place beside it is as good.
            let beside = self.surface.step(&point, [GRADIENT.sqrt(), 0.0])?;
            let _ = self.sight.spectrum(beside.orbit())?;
            let log = self.sight.determinant(beside.orbit(), shift).0;
            self.signal = Signal::Shifted { shift, log };
        }
        let mark = self.value(&point, mark)?.mark;
        let gradient = self.gradient(&point, mark)?;
        let slope = length(gradient);
        let normal = gradient.map(|x| x / slope);
        // A located event is on the curve but for its error.
        let (found, value, slope) = self.across(&point.clone(), [0.0; 2], (normal, slope), (mark, 0.0), START)?;
        point = found;
        let aspects = self.aspects(&point, value.mark);
        Ok((Foot { point, at: 0.0, mark: value.mark, slope, aspects }, across(normal.map(|x| -x))))
    }

    /// The point on the curve at `base` and as far across as need be, no farther than `reach`; the signal there, and its slope.
    pub(super) fn across(
        &mut self,
        from: &SurfacePoint,
        base: [f64; 2],
        (normal, slope): ([f64; 2], f64),
        (mark, aside): (f64, f64),
        reach: f64,
    ) -> Result<(SurfacePoint, Value, f64), Blind> {
        self.secants((slope, aside, reach), |walker, s| {
            let point = walker.surface.step(from, plus(base, normal, s))?;
            let value = walker.value(&point, mark)?;
            Ok((point, value))
        })
    }

    /// The zero of the signal on a line, by secants from `aside`, with the slope expected.
    fn secants(
        &mut self,
        (mut slope, aside, reach): (f64, f64, f64),
        mut at: impl FnMut(&mut Self, f64) -> Result<(SurfacePoint, Value), Blind>,
    ) -> Result<(SurfacePoint, Value, f64), Blind> {
        let side = slope.signum();
        let (mut s, mut last) = (aside, f64::INFINITY);
        let (mut point, mut value) = at(self, s)?;
        for _ in 0..SECANTS {
            let step = -value.value / slope;
            let moved = (s + step).abs();
            if moved.is_nan() || moved > reach {
                return Err(Blind::Other);
            }
            if step == 0.0 || last <= NOISE && step.abs() >= 0.5 * last {
                return Ok((point, value, slope));
            }
            let (next, next_value) = at(self, s + step)?;
            let secant = (next_value.value - value.value) / step;
            // Between two edges of a stripe the slope turns round: the other one is not meant.
            if secant * side > 0.0 && step.abs() > NOISE {
                slope = secant;
            } else if step.abs() > 1e-2 * reach {
                return Err(Blind::Other);
            }
            (s, point, value, last) = (s + step, next, next_value, step.abs());
            if last <= NOISE && (value.value / slope).abs() <= SETTLED {
                return Ok((point, value, slope));
            }
        }
        if last <= NOISE { Ok((point, value, slope)) } else { Err(Blind::Other) }
    }

    /// Where the curve is expected at a length ahead of the last foot: in the tangents' plane there, with the mark. Through one foot
    /// alone, along `direction`.
    pub(super) fn ahead(&self, feet: &[Foot], direction: [f64; 2], h: f64) -> ([f64; 2], f64) {
        let Some(last) = feet.last() else { return ([0.0; 2], 0.0) };
        if feet.len() == 1 {
            return (direction.map(|x| h * x), last.mark);
        }
        let places = feet.iter().map(|foot| {
            let [x, y] = self.surface.between(&last.point, &foot.point);
            (foot.at, [x, y, foot.mark])
        });
        let [x, y, mark] = foreseen(places, last.at + h);
        ([x, y], mark)
    }

    /// The next foot, a length ahead of the last.
    pub(super) fn advance(&mut self, feet: &[Foot], direction: [f64; 2], h: f64) -> Result<Foot, Blind> {
        let last = feet.last().ok_or(Blind::Other)?;
        let (base, mark) = self.ahead(feet, direction, h);
        let norm = length(base);
        let normal = across(base.map(|x| x / norm));
        // It does not turn back between two points.
        let back = feet.len().checked_sub(2).map(|i| self.surface.between(&last.point, &feet[i].point));
        if back.is_some_and(|back| back[0] * base[0] + back[1] * base[1] > -STRAIGHT * norm * length(back)) {
            return Err(Blind::Other);
        }
        let (point, value, slope) = self.across(&last.point, base, (normal, last.slope), (mark, 0.0), ASTRAY * norm)?;
        let at = last.at + self.surface.distance(&last.point, &point);
        let aspects = self.aspects(&point, value.mark);
        Ok(Foot { point, at, mark: value.mark, slope, aspects })
    }

    /// The foot at which the curve leaves the window: one parameter at the end of its range.
    pub(super) fn edge(&mut self, feet: &[Foot], direction: [f64; 2], longest: f64) -> Option<(Foot, CurveEnd)> {
        let last = feet.last()?;
        let (far, mark) = self.ahead(feet, direction, longest);
        let side = side_ahead(self.plane(&last.point), last.point.heading(far));
        let (which, goal, share) = side.filter(|(_, _, share)| *share <= 4.0)?;
        let value = if goal > 0.0 { self.window.to[which] } else { self.window.from[which] };
        let (base, _) = self.ahead(feet, direction, longest * share.min(1.0));
        let normal = across(far.map(|x| x / length(far)));
        // Along the edge the way is not across the curve, and the slope another.
        let reach = 0.5 * length(far).max(1e-6);
        let probe = GRADIENT.max(1e-3 * length(base));
        let on_edge = |walker: &mut Self, s: f64| -> Result<(SurfacePoint, Value), Blind> {
            let along = plus(base, normal, s);
            let point = walker.surface.step_to(&last.point, along, (which, value), normal)?;
            let value = walker.value(&point, mark)?;
            Ok((point, value))
        };
        let slope = (on_edge(self, probe).ok()?.1.value - on_edge(self, 0.0).ok()?.1.value) / probe;
        let (point, value, _) = self.secants((slope, 0.0, reach), on_edge).ok()?;
        let parts = self.plane(&point);
        let inside = (0..2).all(|i| i == which || (-1e-9..=1.0 + 1e-9).contains(&parts[i]));
        let uncoupled =
            self.window.parameters[which] == Parameter::Gamma2 && self.window.from[which] == 0.0 && goal == 0.0;
        let end = if uncoupled { CurveEnd::Uncoupled } else { CurveEnd::Edge };
        let at = last.at + self.surface.distance(&last.point, &point);
        let aspects = self.aspects(&point, value.mark);
        inside.then_some((Foot { point, at, mark: value.mark, slope: last.slope, aspects }, end))
    }

    /// Whether a place is in the window, but for rounding.
    pub(super) fn is_inside(&self, [x, y]: [f64; 2]) -> bool {
        let inside = |part: f64| (-1e-12..=1.0 + 1e-12).contains(&part);
        inside(x) && inside(y)
    }
}
