//! Steps along a curve.

use vibrochain_breather::{BranchError, Orbit, Surface, SurfacePoint};
use vibrochain_lattice::{Parameter, Resonance, Spectrum};

use super::answer::{CurveEnd, CurveError, CurvePoint, EventCurve, Special, SpecialPoint, Walk, Window};
use super::signal::{Blind, Sight, Signal, Value};
use super::walker::{Foot, Walker};
use crate::locate::{Event, Evidence};

/// The first step, the longest and the shortest, in units: a side of the window is one unit, and so is a change of order 1 of the orbit.
const FIRST: f64 = 1e-3;
const LONGEST: f64 = 0.03;
const SHORTEST: f64 = 1e-9;

/// Steps by which the gradient of the signal is taken: error and rounding balance.
const GRADIENT: f64 = 1e-6;

/// Points through which the next one is extrapolated.
const THROUGH: usize = 4;

/// Secants at most to one point. One that leaves as little as `SETTLED` is the last; from `NOISE` on so is one that shrinks no more, which
/// is rounding.
const SECANTS: usize = 12;
const NOISE: f64 = 1e-9;
const SETTLED: f64 = 4.0 * f64::EPSILON;

/// Points as near as this are one.
const SAME: f64 = 1e-14;

/// So many steps in a row that are as short as this lead nowhere.
const CRAWL: f64 = 1e-6;
const MOST_CRAWLING: usize = 64;

/// The curve may be this part of a step away from where it was expected.
const ASTRAY: f64 = 0.1;

/// Cosine of the angle by which it may turn in a step.
const STRAIGHT: f64 = 0.9;

/// From a start that was located to its error the curve is no farther than this.
const START: f64 = 1e-3;

/// The straight line between two points may err by this part of the tolerance: what is foreseen is not quite what comes.
const ROOM: f64 = 0.6;

/// Longer and shorter steps, at most.
const GROW: f64 = 1.5;
const SHRINK: f64 = 0.4;

/// Points of a curve at most.
const MOST_POINTS: usize = 50_000;

/// Impulses this much larger or smaller than at the start, or than those of a tenth of the forcing's own speed, are on their way to
/// infinity or to 0.
const UNBOUNDED: f64 = 1e4;
const FAINT: f64 = 1e-6;
const OWN_SPEED: f64 = 0.1;

/// A curve that is lost this near to a resonance, as a part of ω, ends there.
const NEAR: f64 = 1e-3;

/// A way from a start.
struct Way {
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
        CurveEnd::Closed => Way { feet: vec![start.clone()], special: Vec::new(), end: CurveEnd::Closed },
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

/// What a straight line between the last two of three places errs by, if the curve is a parabola through them: (1/8) of the second
/// difference across it, for steps of these lengths.
fn chord_error([a, b, c]: [[f64; 2]; 3], [before, last]: [f64; 2]) -> f64 {
    let rate = |to: [f64; 2], from: [f64; 2], step: f64| plus(to, from, -1.0).map(|x| x / step);
    let (first, second) = (rate(b, a, before), rate(c, b, last));
    let bend = plus(second, first, -1.0).map(|x| 2.0 * x / (before + last));
    let chord = plus(c, b, -1.0);
    let norm = length(chord);
    // Where the curve stands still in the plane all of the bend counts.
    let bend = if norm > 0.0 { (bend[0] * chord[1] - bend[1] * chord[0]).abs() / norm } else { length(bend) };
    bend * last * last / 8.0
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
        let through = &feet[feet.len().saturating_sub(THROUGH)..];
        if through.len() == 1 {
            return (direction.map(|x| h * x), last.mark);
        }
        let (mut place, mut mark) = ([0.0; 2], 0.0);
        for (i, foot) in through.iter().enumerate() {
            let others = through.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| other.at);
            let weight: f64 = others.map(|other| (last.at + h - other) / (foot.at - other)).product();
            place = plus(place, self.surface.between(&last.point, &foot.point), weight);
            mark += weight * foot.mark;
        }
        (place, mark)
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
        let (from, sides) = (self.plane(&last.point), self.window.sides());
        let (far, mark) = self.ahead(feet, direction, longest);
        let heading = last.point.heading(far);
        // The side that is met first, and when.
        let met = |i: usize| {
            let goal = if heading[i] > 0.0 { 1.0 } else { 0.0 };
            (i, goal, (goal - from[i]) / heading[i])
        };
        let (which, goal, share) =
            (0..2).map(met).filter(|(_, _, share)| (0.0..=4.0).contains(share)).min_by(|a, b| a.2.total_cmp(&b.2))?;
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
        debug_assert!(sides.iter().all(|side| *side > 0.0));
        inside.then_some((Foot { point, at, mark: value.mark, slope: last.slope, aspects }, end))
    }

    /// Whether a place is in the window, but for rounding.
    fn is_inside(&self, [x, y]: [f64; 2]) -> bool {
        let inside = |part: f64| (-1e-12..=1.0 + 1e-12).contains(&part);
        inside(x) && inside(y)
    }

    /// Follows the curve in one direction to its end.
    fn follow(&mut self, start: &Foot, direction: [f64; 2], until: &dyn Fn([f64; 2], Option<bool>) -> bool) -> Way {
        let mut feet = vec![start.clone()];
        let (mut h, mut special) = (FIRST, Vec::new());
        // On a curve along which all impulses vanish, the first point's impulses are rounding and set no scale.
        let first = start.point.orbit().strength();
        let scale = first.max(OWN_SPEED * start.point.orbit().model().omega());
        let vanish = first < FAINT * scale;
        let (mut why, mut crawling) = (Blind::Other, 0);
        let end = loop {
            if feet.len() > MOST_POINTS {
                break CurveEnd::Long;
            }
            let Some(last) = feet.last() else { break CurveEnd::Closed };
            if h < SHORTEST || crawling > MOST_CRAWLING {
                break self.given_up(last, why);
            }
            let outside = {
                let (far, _) = self.ahead(&feet, direction, h);
                !self.is_inside(plus(self.plane(&last.point), last.point.heading(far), 1.0))
            };
            let step = if outside { Err(Blind::Other) } else { self.advance(&feet, direction, h) };
            let next = match step {
                Ok(next) if self.is_inside(self.plane(&next.point)) => next,
                Err(blind) if !outside => {
                    (h, why) = (SHRINK * h, blind);
                    continue;
                }
                _ => {
                    // On its way out of the window.
                    if let Some((foot, end)) = self.edge(&feet, direction, h) {
                        let length = foot.at - feet.last().map_or(0.0, |last| last.at);
                        if length > SAME {
                            self.mark_special(&mut feet, &mut special, direction, foot);
                        }
                        break end;
                    }
                    (h, why) = (SHRINK * h, Blind::Other);
                    continue;
                }
            };
            let error = match feet.len() {
                1 => 0.0,
                n => {
                    let (a, b) = (&feet[n - 2], &feet[n - 1]);
                    let places = [&a.point, &b.point, &next.point].map(|point| self.plane(point));
                    chord_error(places, [b.at - a.at, next.at - b.at])
                }
            };
            let taken = next.at - feet[feet.len() - 1].at;
            crawling = if taken < CRAWL { crawling + 1 } else { 0 };
            if error > self.tolerance && taken > SHORTEST.sqrt() {
                h = taken * (ROOM * self.tolerance / error).sqrt().max(0.1);
                continue;
            }
            let closed = feet.len() > 3 && self.passes(start, &feet[feet.len() - 1], &next);
            let next = if closed { Foot { at: feet[feet.len() - 1].at + taken, ..start.clone() } } else { next };
            let ends = next.aspects.ends;
            let strength = next.point.orbit().strength() / scale;
            let (told, mark) = (special.len(), next.mark);
            self.mark_special(&mut feet, &mut special, direction, next);
            if closed {
                break CurveEnd::Closed;
            }
            if ends {
                let real = |(_, one, _): &&(usize, Special, f64)| matches!(one, Special::OneToOne | Special::OneToTwo);
                let passed = special[told..].iter().rfind(real).map(|&(place, special, _)| (place, special));
                // Where rounding hides the place itself the curve ends beside it.
                let other = if mark > 0.0 { Special::OneToOne } else { Special::OneToTwo };
                let (place, kind) = passed.unwrap_or((feet.len().saturating_sub(2), other));
                feet.truncate(place + 1);
                special.retain(|(other, ..)| *other <= place);
                break CurveEnd::Special(kind);
            }
            if feet.last().is_some_and(|last| until(last.point.values(), last.aspects.physical)) {
                break CurveEnd::Halted;
            }
            if strength > UNBOUNDED {
                break CurveEnd::Unbounded;
            }
            if strength < FAINT && !vanish {
                break CurveEnd::ImpulsesVanish;
            }
            let wanted = if error > 0.0 { (ROOM * self.tolerance / error).sqrt() } else { GROW };
            h = (h.max(taken) * wanted.clamp(SHRINK, GROW)).min(LONGEST);
        };
        Way { feet, special, end }
    }

    /// Adds a foot, after what is special between it and the last one.
    fn mark_special(
        &mut self,
        feet: &mut Vec<Foot>,
        special: &mut Vec<(usize, Special, f64)>,
        direction: [f64; 2],
        next: Foot,
    ) {
        let found = self.between(feet, direction, &next);
        for (kind, foot, error) in found {
            // Those at one place are all told of that place.
            if feet.last().is_some_and(|last| foot.at - last.at > SAME) {
                feet.push(foot);
            }
            special.push((feet.len() - 1, kind, error));
        }
        if feet.last().is_some_and(|last| next.at - last.at > SAME) {
            feet.push(next);
        }
    }

    /// Why a curve goes no farther.
    fn given_up(&self, last: &Foot, why: Blind) -> CurveEnd {
        if let Some(resonance) = resonance(last.point.orbit()) {
            return CurveEnd::Resonance(resonance);
        }
        match why {
            Blind::Other if last.point.orbit().model().loss() == 0.0 && self.signal.is_spectral() => CurveEnd::Thin,
            Blind::Lost(error) => CurveEnd::Lost(error),
            Blind::Unwatched(error) => CurveEnd::Unwatched(error),
            Blind::Other => CurveEnd::Lost(BranchError::NoConvergence),
        }
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
    fn joined(mut self, evidence: Evidence, behind: Way, ahead: Way) -> EventCurve {
        let closed = behind.end == CurveEnd::Closed;
        let count = behind.feet.len();
        let turned = |(place, kind, error): (usize, Special, f64)| (count - 1 - place, kind, error);
        let mut special: Vec<(usize, Special, f64)> = behind.special.into_iter().rev().map(turned).collect();
        special.extend(ahead.special.into_iter().map(|(place, kind, error)| (count - 1 + place, kind, error)));
        let mut feet: Vec<Foot> = behind.feet.into_iter().rev().collect();
        feet.pop();
        feet.extend(ahead.feet);
        let errors = self.errors(&feet);
        let points = feet.iter().zip(&errors).map(|(foot, error)| self.described(foot, *error)).collect();
        let special =
            special.into_iter().map(|(point, special, error)| SpecialPoint { special, point, error }).collect();
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chords_of_a_circle_err_by_their_sagitta() {
        // Three points of a circle of radius 1, uneven steps.
        let at = |t: f64| [t.cos(), t.sin()];
        for (before, last) in [(0.02_f64, 0.03_f64), (0.03, 0.01)] {
            let error = chord_error([at(0.0), at(before), at(before + last)], [before, last]);
            let sagitta = 1.0 - (0.5 * last).cos();
            assert!((error / sagitta - 1.0).abs() < 0.01, "{error} {sagitta}");
        }
        assert!(chord_error([[0.0, 0.0], [1.0, 1.0], [3.0, 3.0]], [1.0, 2.0]) < 1e-15);
    }
}
