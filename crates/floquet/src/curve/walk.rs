//! Steps along a curve.

use vibrochain_breather::line::{Line, Step, chord_error, foreseen, joined, side_ahead, trace};
use vibrochain_breather::{BranchError, Orbit, Surface, SurfacePoint};
use vibrochain_lattice::{Parameter, Resonance, Spectrum};

use super::answer::{CurveEnd, CurveError, CurvePoint, EventCurve, Special, SpecialPoint, Walk, Window};
use super::signal::{Blind, Sight, Signal, Value};
use super::walker::{Foot, Walker};
use crate::locate::{Event, Evidence};

/// Steps by which the gradient of the signal is taken: error and rounding balance.
const GRADIENT: f64 = 1e-6;

/// Secants at most to one point. One that leaves as little as `SETTLED` is the last; from `NOISE` on so is one that shrinks no more, which
/// is rounding.
const SECANTS: usize = 12;
const NOISE: f64 = 1e-9;
const SETTLED: f64 = 4.0 * f64::EPSILON;

/// Points as near as this are one.
const SAME: f64 = 1e-14;

/// The curve may be this part of a step away from where it was expected.
const ASTRAY: f64 = 0.1;

/// Cosine of the angle by which it may turn in a step.
const STRAIGHT: f64 = 0.9;

/// From a start that was located to its error the curve is no farther than this.
const START: f64 = 1e-3;

/// Impulses this much larger or smaller than at the start, or than those of a tenth of the forcing's own speed, are on their way to
/// infinity or to 0.
const UNBOUNDED: f64 = 1e4;
const FAINT: f64 = 1e-6;
const OWN_SPEED: f64 = 0.1;

/// A curve that is lost this near to a resonance, as a part of ω, ends there.
const NEAR: f64 = 1e-3;

/// One way along the curve from its start.
struct Way<'a> {
    walker: &'a mut Walker,
    until: &'a dyn Fn([f64; 2], Option<bool>) -> bool,
    /// Along the curve at the start.
    direction: [f64; 2],
    special: Vec<(usize, Special, f64)>,
    /// How many of these were known before the last step.
    told: usize,
    /// Why the last step failed.
    why: Blind,
}

/// What a way has passed.
struct Passed {
    feet: Vec<Foot>,
    special: Vec<(usize, Special, f64)>,
    end: CurveEnd,
}

/// Follows the event at `orbit` both ways through a window of two parameters. `evidence` is what shows it
/// ([`Located`](crate::Located)); `tolerance` is how far a straight line between neighbouring points may be from the curve, as a part
/// of the window's sides.
///
/// # Errors
/// [`CurveError`]. What stops the curve on its way is its end, not an error.
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_floquet::{Event, Search, Window, curve, locate};
/// use vibrochain_lattice::{Chain, Model, Parameter};
/// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.07, 0.8, 0.165, 0.25)?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let found = locate(orbit, &Search::new(orbit, Event::PeriodDoubling, Parameter::Amplitude))?;
/// let window = Window { parameters: [Parameter::Amplitude, Parameter::Restitution], from: [0.1, 0.2], to: [0.3, 0.3] };
/// let doubling = curve(&found.located[0].orbit, Event::PeriodDoubling, found.located[0].evidence, &window, 1e-4)?;
/// assert!(doubling.points.len() > 10 && doubling.points.iter().all(|point| point.error < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn curve(
    orbit: &Orbit,
    event: Event,
    evidence: Evidence,
    window: &Window,
    tolerance: f64,
) -> Result<EventCurve, CurveError> {
    curve_along(orbit, event, evidence, &Walk::new(*window, tolerance))
}

/// The same, no farther and with no more on the way than is asked for.
///
/// # Errors
/// As [`curve`].
pub fn curve_along(orbit: &Orbit, event: Event, evidence: Evidence, walk: &Walk<'_>) -> Result<EventCurve, CurveError> {
    let &Walk { window, tolerance, special, until, ref stop } = walk;
    check(orbit, &window, tolerance)?;
    let (signal, mark) = Signal::of(event, evidence, orbit).ok_or(CurveError::NotThere(event))?;
    let sides = window.sides();
    let free = [0, 1].map(|i| (window.parameters[i], sides[i]));
    let sight = Sight::new(orbit.model().chain().sites(), stop);
    let surface = Surface::through(orbit, free)?.until(stop);
    let grazing = signal.grazing(orbit);
    let mut walker = Walker { surface, sight, signal, grazing, event, window, tolerance, special };
    let started = walker.start(mark);
    stop.heard()?;
    let (start, direction) = started.map_err(|blind| match blind {
        Blind::Lost(error) => CurveError::Branch(error),
        Blind::Unwatched(error) => CurveError::Floquet(error),
        Blind::Other => CurveError::NotThere(event),
    })?;
    // The other way, across is the other way, too.
    let turned = Foot { slope: -start.slope, ..start.clone() };
    let behind = walker.follow(&turned, direction.map(|x| -x), until);
    let ahead = match behind.end {
        CurveEnd::Closed => Passed { feet: vec![start.clone()], special: Vec::new(), end: CurveEnd::Closed },
        _ => walker.follow(&start, direction, until),
    };
    let curve = walker.joined(evidence, behind, ahead);
    // On the way a failure is an end.
    stop.heard()?;
    Ok(curve)
}

fn check(orbit: &Orbit, window: &Window, tolerance: f64) -> Result<(), CurveError> {
    let [one, other] = window.parameters;
    if one == other {
        return Err(CurveError::Same(one));
    }
    if !(1e-12..=1e-2).contains(&tolerance) {
        return Err(CurveError::Tolerance(tolerance));
    }
    let conservative = orbit.model().is_conservative();
    for (i, parameter) in window.parameters.into_iter().enumerate() {
        let (value, from, to) = (orbit.model().get(parameter), window.from[i], window.to[i]);
        if !(from <= value && value <= to && from < to) {
            return Err(CurveError::Outside { parameter, value, from, to });
        }
        if conservative && matches!(parameter, Parameter::Amplitude | Parameter::Restitution) {
            return Err(CurveError::NoForce(parameter));
        }
    }
    Ok(())
}

/// The perpendicular, a quarter turn to the left.
fn across([x, y]: [f64; 2]) -> [f64; 2] {
    [-y, x]
}

fn plus([x, y]: [f64; 2], [u, v]: [f64; 2], factor: f64) -> [f64; 2] {
    [x + factor * u, y + factor * v]
}

fn length([x, y]: [f64; 2]) -> f64 {
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

    fn plane(&self, point: &SurfacePoint) -> [f64; 2] {
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
    fn start(&mut self, mark: f64) -> Result<(Foot, [f64; 2]), Blind> {
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
    fn ahead(&self, feet: &[Foot], direction: [f64; 2], h: f64) -> ([f64; 2], f64) {
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
    fn edge(&mut self, feet: &[Foot], direction: [f64; 2], longest: f64) -> Option<(Foot, CurveEnd)> {
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
    fn is_inside(&self, [x, y]: [f64; 2]) -> bool {
        let inside = |part: f64| (-1e-12..=1.0 + 1e-12).contains(&part);
        inside(x) && inside(y)
    }

    /// Follows the curve in one direction to its end.
    fn follow(&mut self, start: &Foot, direction: [f64; 2], until: &dyn Fn([f64; 2], Option<bool>) -> bool) -> Passed {
        let tolerance = self.tolerance;
        let mut way = Way { walker: self, until, direction, special: Vec::new(), told: 0, why: Blind::Other };
        let (feet, end) = trace(&mut way, start.clone(), tolerance);
        Passed { feet, special: way.special, end }
    }

    /// Whether the curve is back where it began, between two feet.
    fn passes(&self, start: &Foot, from: &Foot, to: &Foot) -> bool {
        let step = self.surface.between(&from.point, &to.point);
        let back = self.surface.between(&from.point, &start.point);
        let share = (back[0] * step[0] + back[1] * step[1]) / (step[0] * step[0] + step[1] * step[1]);
        let aside = length(plus(back, step, -share));
        (0.0..=1.0).contains(&share)
            && aside <= 0.2 * length(step)
            && self.surface.distance(&from.point, &start.point) <= 1.5 * length(step)
    }

    /// One curve of two ways from its start.
    fn joined(mut self, evidence: Evidence, behind: Passed, ahead: Passed) -> EventCurve {
        let closed = behind.end == CurveEnd::Closed;
        let count = behind.feet.len();
        let turned = |(place, kind, error): (usize, Special, f64)| (count - 1 - place, kind, error);
        let mut special: Vec<(usize, Special, f64)> = behind.special.into_iter().rev().map(turned).collect();
        special.extend(ahead.special.into_iter().map(|(place, kind, error)| (count - 1 + place, kind, error)));
        let feet = joined(behind.feet, ahead.feet);
        let errors = self.errors(&feet);
        let points: Vec<CurvePoint> =
            feet.iter().zip(&errors).map(|(foot, error)| self.described(foot, *error)).collect();
        let named = |(point, special, error): (usize, Special, f64)| SpecialPoint {
            special,
            point,
            values: points[point].values,
            error,
        };
        let special = special.into_iter().map(named).collect();
        let ends = if closed { [CurveEnd::Closed, CurveEnd::Closed] } else { [behind.end, ahead.end] };
        let evaluations = self.surface.evaluations();
        EventCurve { event: self.event, evidence, points, special, ends, evaluations, spectra: self.sight.spectra }
    }

    fn described(&mut self, foot: &Foot, error: f64) -> CurvePoint {
        let angle = self.signal.has_angle().then(|| foot.mark.clamp(-1.0, 1.0).acos() / std::f64::consts::PI);
        let (values, orbit) = (foot.point.values(), foot.point.orbit().clone());
        CurvePoint { values, error, orbit, angle, physical: foot.aspects.physical }
    }
}

impl Line for Way<'_> {
    type Point = Foot;
    type End = CurveEnd;
    const CLOSED: CurveEnd = CurveEnd::Closed;
    const LONG: CurveEnd = CurveEnd::Long;

    fn ahead(&mut self, feet: &[Foot], length: f64) -> Option<Step<Foot, CurveEnd>> {
        let (walker, direction, last) = (&mut *self.walker, self.direction, feet.last()?);
        let (far, _) = walker.ahead(feet, direction, length);
        self.why = Blind::Other;
        if walker.is_inside(plus(walker.plane(&last.point), last.point.heading(far), 1.0)) {
            match walker.advance(feet, direction, length) {
                Ok(next) if walker.is_inside(walker.plane(&next.point)) => return Some(Step::On(next)),
                Ok(_) => {}
                Err(blind) => {
                    self.why = blind;
                    return None;
                }
            }
        }
        walker.edge(feet, direction, length).map(|(foot, end)| Step::Out(Some(foot), end))
    }

    fn bend(&self, feet: [&Foot; 3]) -> f64 {
        let [a, b, c] = feet.map(|foot| foot.at);
        chord_error(feet.map(|foot| self.walker.plane(&foot.point)), [b - a, c - b])
    }

    fn closed(&mut self, feet: &[Foot], next: &Foot) -> Option<Foot> {
        let closed = feet.len() > 3 && self.walker.passes(&feet[0], &feet[feet.len() - 1], next);
        closed.then(|| Foot { at: next.at, ..feet[0].clone() })
    }

    fn pass(&mut self, feet: &mut Vec<Foot>, next: Foot) {
        self.told = self.special.len();
        for (kind, foot, error) in self.walker.between(feet, self.direction, &next) {
            // Those at one place are all told of that place.
            if feet.last().is_some_and(|last| foot.at - last.at > SAME) {
                feet.push(foot);
            }
            self.special.push((feet.len() - 1, kind, error));
        }
        if feet.last().is_some_and(|last| next.at - last.at > SAME) {
            feet.push(next);
        }
    }

    fn ended(&mut self, feet: &mut Vec<Foot>) -> Option<CurveEnd> {
        let last = feet.last()?;
        if last.aspects.ends {
            let real = |(_, one, _): &&(usize, Special, f64)| matches!(one, Special::OneToOne | Special::OneToTwo);
            let passed = self.special[self.told..].iter().rfind(real).map(|&(place, special, _)| (place, special));
            // Where rounding hides the place itself the curve ends beside it.
            let other = if last.mark > 0.0 { Special::OneToOne } else { Special::OneToTwo };
            let (place, kind) = passed.unwrap_or((feet.len().saturating_sub(2), other));
            feet.truncate(place + 1);
            self.special.retain(|(other, ..)| *other <= place);
            return Some(CurveEnd::Special(kind));
        }
        if (self.until)(last.point.values(), last.aspects.physical) {
            return Some(CurveEnd::Halted);
        }
        let first = feet[0].point.orbit();
        let scale = first.strength().max(OWN_SPEED * first.model().omega());
        // On a curve along which all impulses vanish, the first point's are rounding.
        let vanish = first.strength() < FAINT * scale;
        match last.point.orbit().strength() / scale {
            UNBOUNDED.. => Some(CurveEnd::Unbounded),
            ..FAINT if !vanish => Some(CurveEnd::ImpulsesVanish),
            _ => None,
        }
    }

    fn lost(&self, feet: &[Foot]) -> CurveEnd {
        let orbit = feet[feet.len() - 1].point.orbit();
        if let Some(resonance) = resonance(orbit) {
            return CurveEnd::Resonance(resonance);
        }
        match self.why.clone() {
            Blind::Other if orbit.model().loss() == 0.0 && self.walker.signal.is_spectral() => CurveEnd::Thin,
            Blind::Lost(error) => CurveEnd::Lost(error),
            Blind::Unwatched(error) => CurveEnd::Unwatched(error),
            Blind::Other => CurveEnd::Lost(BranchError::NoConvergence),
        }
    }
}

/// The resonance that an orbit stands next to.
fn resonance(orbit: &Orbit) -> Option<Resonance> {
    let (spectrum, omega) = (Spectrum::new(*orbit.model().chain()), orbit.frequency());
    let near = |(mode, &frequency): (usize, &f64)| {
        let harmonic = (frequency / omega).round();
        let distance = (-harmonic).mul_add(omega, frequency);
        (harmonic >= 1.0 && distance.abs() <= NEAR * omega).then_some(Resonance {
            harmonic: harmonic as u64,
            mode,
            frequency,
            omega,
            distance,
        })
    };
    let all = spectrum.frequencies().iter().enumerate().filter_map(near);
    all.min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()))
}
