//! One way along a curve: the orbit's equations with what vanishes at the event, over two numbers that are free, are followed by the one tracer.
//! Where something else happens on the way a monitor changes its sign.

use crate::events::FAINT;
use vibrochain_breather::line::{Line, Side, Step, chord_error, joined, side_ahead, trace};
use vibrochain_breather::system::{System, Vector, unit};
use vibrochain_breather::{BranchError, ContactOrbit, Continuation, Pace, SolutionCurve};

use super::answer::{CurveEnd, CurveError, EventCurve, Special, SpecialPoint};
use super::monitors::{GROWTH, Seen};
use super::tracer::{CurveRequest, PUSHED, TracedPoint, Tracer, values};
use crate::events::{AtEvent, EventSystem, TOUCHES, Test, UNBOUNDED, Watcher, resonance_beside, strongest};
use crate::locate::{Event, Evidence};

/// From where an event was located the curve is no farther than this.
const START: f64 = 1e-3;

/// Points as near as this are one.
const SAME: f64 = 1e-6;

/// So near to the side of the window where masses are not coupled, a curve that is lost leads there.
const BARELY: f64 = 1e-4;

/// How often a step is halved on which pairs of multipliers become real or complex.
const MOST_HALVED: usize = 6;

/// Points as near as this are one place.
const CLOSEST: f64 = 1e-14;

/// What vanishes at an event, and its mark there.
fn test_of(event: Event, evidence: Evidence, orbit: &ContactOrbit) -> Option<(Test, Option<f64>)> {
    Some(match (event, evidence) {
        (Event::Pitchfork, _) if orbit.is_conservative() => (Test::AnotherOne, None),
        (Event::Pitchfork, _) => (Test::One, None),
        (Event::Fold, _) => (Test::Fold, None),
        (Event::PeriodDoubling, _) => (Test::MinusOne, None),
        (Event::NeimarkSacker, Evidence::Multiplier(mu)) => {
            (if orbit.is_lossless() { Test::Collision } else { Test::Circle }, Some(mu.arg().abs()))
        }
        (Event::Grazing, Evidence::Impact(i)) => (Test::Velocity(i), None),
        (Event::Sticking, Evidence::Impact(i)) => (Test::Release(i), None),
        (Event::Grazing, Evidence::Touch(touch)) => match Test::corner(&touch, orbit) {
            Some(corner) => (corner, None),
            None => (Test::Touch(touch.site, touch.barrier), Some(touch.time / orbit.period())),
        },
        _ => return None,
    })
}

/// Follows an event at `orbit`, one of the orbits of `base` at its origin, both ways through a window.
pub(crate) fn followed(
    (base, orbit): (Continuation, &ContactOrbit),
    watcher: Watcher,
    asked: &CurveRequest<'_>,
) -> Result<EventCurve, CurveError> {
    let not_there = || CurveError::NotThere(asked.event);
    let (test, mark) = test_of(asked.event, asked.evidence, orbit).ok_or_else(not_there)?;
    let mut base = base;
    let origin = base.origin()?;
    let mut manifold = SolutionCurve::of(EventSystem::new(base, test, &origin, mark));
    let z = manifold.system().origin()?;
    let last = z.len() - 1;
    // Where the curve stands still in one number it moves in the other.
    let first = manifold.correct(&z, &unit(z.len(), last), START, false);
    let first = first.or_else(|_| manifold.correct(&z, &unit(z.len(), last - 1), START, false));
    let first = first.map_err(|error| match error {
        BranchError::NoConvergence => not_there(),
        other => other.into(),
    })?;
    if manifold.system().push_along(first.tangent()).abs() > PUSHED {
        let message = "orbits of this symmetry, which they lose here, exist at no other value of one of the two numbers: no curve passes";
        return Err(BranchError::Model(message.to_owned()).into());
    }
    let strength = strongest(&first.orbit().orbit).max(f64::MIN_POSITIVE);
    // By symmetry several impacts may have no velocity all along.
    let still = |velocity: f64| velocity.abs() <= TOUCHES * first.orbit().orbit.speed();
    let impacts = first.orbit().orbit.impacts();
    let grazing = match test {
        Test::Velocity(own) => (0..impacts.len()).filter(|&i| i == own || still(impacts[i].velocity_before)).collect(),
        _ => Vec::new(),
    };
    let vanish = grazing.len() == impacts.len() || strongest(&first.orbit().orbit) < FAINT * strength;
    let mut tracer = Tracer { manifold, watcher, test, asked, strength, vanish, grazing };
    let (behind, special_behind, end_behind) = tracer.way(first.reversed());
    let (ahead, special_ahead, end) = match end_behind {
        CurveEnd::Closed => (vec![first], Vec::new(), CurveEnd::Closed),
        _ => tracer.way(first),
    };
    let before = behind.len();
    let there = |at: usize, one: Noted| Noted { at, ..one };
    let mut special: Vec<_> = special_behind.into_iter().map(|one| there(before - 1 - one.at, one)).collect();
    special.extend(special_ahead.into_iter().map(|one| there(before - 1 + one.at, one)));
    special.sort_by_key(|one| one.at);
    let points = joined(behind, ahead);
    let told = |Noted { at, special, error }| SpecialPoint { special, point: at, values: values(&points[at]), error };
    let special = special.into_iter().map(told).collect();
    let errors = tracer.errors(&points);
    let points = points.iter().zip(errors).map(|(point, error)| tracer.described(point, error));
    let points = points.collect::<Result<_, _>>().map_err(BranchError::from)?;
    Ok(EventCurve {
        event: asked.event,
        evidence: asked.evidence,
        points,
        special,
        ends: [end_behind, end],
        evaluations: tracer.manifold.evaluations(),
        spectra: tracer.watcher.spectra(),
    })
}

/// What happens at one of a way's points.
#[derive(Debug, Clone, Copy)]
struct Noted {
    at: usize,
    special: Special,
    /// How far along the curve it may be.
    error: f64,
}

/// What happens between two points, and where.
struct Located<P> {
    /// Behind the first of them.
    along: f64,
    point: P,
    special: Special,
    error: f64,
}

/// Points of a way, what happens at some of them, and how it ends.
type Passed = (Vec<TracedPoint>, Vec<Noted>, CurveEnd);

impl Tracer<'_> {
    fn way(&mut self, start: TracedPoint) -> Passed {
        let seen = self.seen(&start, GROWTH);
        let tolerance = self.asked.walk.tolerance;
        let mut way = Way { tracer: self, seen, special: Vec::new(), told: 0, why: BranchError::NoConvergence };
        let (points, end) = trace(&mut way, start, tolerance);
        (points, way.special, end)
    }
}

/// What is seen at a length along a step.
type SeenAt = (f64, Seen);

impl Tracer<'_> {
    /// Parts of a step, halved where pairs of multipliers become real or complex on the way: a pair that is seen at one end alone may have
    /// crossed the circle before.
    fn alike(&mut self, passed: &[TracedPoint], ends: [SeenAt; 2]) -> Vec<[SeenAt; 2]> {
        let (mut open, mut parts) = (vec![(ends, 0)], Vec::new());
        while let Some(([from, to], halved)) = open.pop() {
            let middle = 0.5 * (from.0 + to.0);
            let differs = halved < MOST_HALVED && from.1.pairs() != to.1.pairs();
            match differs.then(|| self.advance(passed, middle).ok()).flatten() {
                Some(point) => {
                    let middle = (middle, self.seen(&point, GROWTH));
                    open.extend([([middle.clone(), to], halved + 1), ([from, middle], halved + 1)]);
                }
                None => parts.push([from, to]),
            }
        }
        parts
    }
}

/// One way along the curve from its start.
struct Way<'t, 'a> {
    tracer: &'t mut Tracer<'a>,
    /// At the last point.
    seen: Seen,
    special: Vec<Noted>,
    /// How many of these were known before the last step.
    told: usize,
    /// Why the last step failed.
    why: BranchError,
}

impl Line for Way<'_, '_> {
    type Point = TracedPoint;
    type End = CurveEnd;

    const CLOSED: CurveEnd = CurveEnd::Closed;
    const LONG: CurveEnd = CurveEnd::Long;

    fn ahead(&mut self, passed: &[Self::Point], length: f64) -> Option<Step<Self::Point, CurveEnd>> {
        let (last, asked) = (passed.last()?, self.tracer.asked);
        let mut told = |next: Result<Self::Point, BranchError>| next.map_err(|why| self.why = why).ok();
        let foreseen = self.tracer.foreseen(passed, length)?;
        // A number that has reached the end of its range may have no model beyond.
        let mut beyond = [foreseen[foreseen.len() - 2], foreseen[foreseen.len() - 1]];
        if asked.walk.window.holds(beyond) {
            let next = told(self.tracer.advance(passed, length))?;
            // Where rounding hides the way on, what is found may lie behind.
            if self.tracer.manifold.length_between(last, &next) <= CLOSEST {
                self.why = BranchError::NoConvergence;
                return None;
            }
            if asked.walk.window.holds(values(&next)) {
                return Some(Step::On(next));
            }
            beyond = values(&next);
        }
        let [here, there] = [values(last), beyond].map(|values| asked.walk.window.parts(values));
        let Side { parameter: which, goal, share } = side_ahead(here, [there[0] - here[0], there[1] - here[1]])?;
        let mut z = self.tracer.foreseen(passed, length * share.min(1.0))?;
        let place = z.len() - 2 + which;
        z[place] = if goal > 0.0 { asked.walk.window.to } else { asked.walk.window.from }[which];
        // The row heads the way of the step.
        let row: Vector = unit(z.len(), place).iter().map(|x| x * (2.0 * goal - 1.0)).collect();
        let edge = told(self.tracer.manifold.correct(&z, &row, START.max(length), false))?;
        let uncoupled = asked.uncoupled == Some(which) && goal == 0.0;
        let end = if uncoupled { CurveEnd::Uncoupled } else { CurveEnd::Edge };
        asked.walk.window.holds(values(&edge)).then_some(Step::Out(Some(edge), end))
    }

    /// Impulses that grow without bound set a longer scale.
    fn longest(&self, passed: &[Self::Point]) -> f64 {
        let growth = passed.last().map_or(1.0, |point| strongest(&point.orbit().orbit) / self.tracer.strength);
        Pace::LONGEST * growth.max(1.0)
    }

    fn bend(&self, through: [&Self::Point; 3]) -> f64 {
        let [a, b, c] = through;
        let lengths = [self.tracer.manifold.distance(a, b), self.tracer.manifold.distance(b, c)];
        chord_error(through.map(|point| self.tracer.asked.walk.window.parts(values(point))), lengths)
    }

    fn closed(&mut self, passed: &[Self::Point], next: &Self::Point) -> Option<Self::Point> {
        let (start, last) = (passed.first()?, passed.last()?);
        if passed.len() < 3 {
            return None;
        }
        let manifold = &self.tracer.manifold;
        let (to_start, to_next) = (manifold.length_between(last, start), manifold.length_between(last, next));
        if !(0.0 < to_start && to_start <= to_next) {
            return None;
        }
        let there = self.tracer.advance(passed, to_start).ok()?;
        (self.tracer.manifold.distance(&there, start) <= SAME).then(|| start.clone())
    }

    fn pass(&mut self, passed: &mut Vec<Self::Point>, next: Self::Point) {
        self.told = self.special.len();
        let seen = self.tracer.seen(&next, GROWTH);
        let Some(last) = passed.last().cloned() else { return };
        let length = self.tracer.manifold.length_between(&last, &next);
        let mut found: Vec<Located<Self::Point>> = Vec::new();
        let mut take = |tracer: &Tracer<'_>, located: Option<(Self::Point, f64)>, special| {
            let along = |point: &Self::Point| tracer.manifold.length_between(&last, point);
            found.extend(located.map(|(point, error)| Located { along: along(&point), point, special, error }));
        };
        let parts = self.tracer.alike(passed, [(0.0, self.seen.clone()), (length, seen.clone())]);
        for [(from, before), (to, after)] in &parts {
            // On its way a pair that crosses comes as near as one likes.
            let least = if before.on_circle || after.on_circle { GROWTH } else { 0.0 };
            for before in &before.monitors {
                let Some(after) = after.monitors.iter().find(|one| one.is(before)) else { continue };
                if (before.value > 0.0) == (after.value > 0.0) {
                    continue;
                }
                let located =
                    self.tracer.located(passed, [*from, *to], [before.value, after.value], |tracer, point| {
                        let there = tracer.seen(point, least);
                        there.monitors.iter().find(|one| one.is(before)).map(|one| one.value)
                    });
                take(self.tracer, located, before.special);
            }
        }
        if self.tracer.asked.event == Event::Fold && self.tracer.asked.walk.special {
            let located = self.tracer.cusp(passed, &next, length);
            take(self.tracer, located, Special::Cusp);
        }
        found.sort_by(|a, b| a.along.total_cmp(&b.along));
        let mut reached = 0.0;
        for Located { along, point, special, error } in found {
            // Those at one place are all told of that place.
            if along - reached > CLOSEST {
                passed.push(point);
                reached = along;
            }
            self.special.push(Noted { at: passed.len() - 1, special, error });
        }
        if length - reached > CLOSEST {
            passed.push(next);
        }
        self.seen = seen;
    }

    fn ended(&mut self, passed: &mut Vec<Self::Point>) -> Option<CurveEnd> {
        let point = passed.last()?;
        let AtEvent { orbit, mark, .. } = point.orbit();
        let theta = mark.filter(|_| self.tracer.has_angle());
        if let Some(theta) = theta.filter(|theta| !(0.0..=std::f64::consts::PI).contains(theta)) {
            let real = |one: &&Noted| matches!(one.special, Special::OneToOne | Special::OneToTwo);
            let reached = self.special[self.told..].iter().rfind(real).map(|one| (one.at, one.special));
            // Where rounding hides the place itself the curve ends beside it.
            let other = if theta < 0.0 { Special::OneToOne } else { Special::OneToTwo };
            let (place, special) = reached.unwrap_or((passed.len().saturating_sub(2), other));
            passed.truncate(place + 1);
            self.special.retain(|one| one.at <= place);
            return Some(CurveEnd::Special(special));
        }
        if (self.tracer.asked.walk.until)(values(point), self.seen.physical) {
            return Some(CurveEnd::Halted);
        }
        match strongest(orbit) / self.tracer.strength {
            _ if self.tracer.vanish => None,
            UNBOUNDED.. => Some(CurveEnd::Unbounded),
            share if share < FAINT => Some(CurveEnd::ImpulsesVanish),
            _ => None,
        }
    }

    fn lost(&self, passed: &[Self::Point]) -> CurveEnd {
        let orbit = passed.last().map(|point| &point.orbit().orbit);
        let resonance = orbit.and_then(|orbit| Some(orbit.model().by_wave(resonance_beside(orbit)?)));
        if let Some(resonance) = resonance {
            return CurveEnd::Resonance(resonance);
        }
        // Modes that are alike without coupling have multipliers that no digits tell apart nearby.
        let asked = self.tracer.asked;
        let part = |which: usize| passed.last().map_or(1.0, |point| asked.walk.window.parts(values(point))[which]);
        if asked.uncoupled.is_some_and(|which| part(which) <= BARELY) {
            return CurveEnd::Uncoupled;
        }
        let spectral = matches!(self.tracer.test, Test::Collision | Test::MinusOne | Test::AnotherOne);
        match self.why.clone() {
            BranchError::NoConvergence if spectral && orbit.is_some_and(ContactOrbit::is_lossless) => CurveEnd::Thin,
            why => CurveEnd::Lost(why),
        }
    }
}
