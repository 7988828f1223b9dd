//! One way along a curve: the orbit's equations with what vanishes at the event, over two numbers that are free, are followed by the one tracer.
//! Where something else happens on the way a monitor changes its sign.

use nalgebra::Complex;
use vibrochain_breather::line::{Line, Step, chord_error, joined, side_ahead, trace};
use vibrochain_breather::system::{System, Vector, dot, unit, zeros};
use vibrochain_breather::{Admissibility, BranchError, Manifold, ManifoldPoint, Obstruction};

use super::answer::{CurveEnd, CurveError, CurvePoint, EventCurve, Special, SpecialPoint};
use crate::bracket::crossing;
use crate::events::half_sums::upper_half;
use crate::events::{
    AtEvent, EventOrbit, EventSystem, TOUCHES, Test, UNBOUNDED, Watcher, another_one, minus_one, strongest,
};
use crate::followed::Followed;
use crate::locate::{Event, Evidence};
use crate::verdict::Tolerance;

type C = Complex<f64>;

/// From where an event was located the curve is no farther than this.
const START: f64 = 1e-3;

/// What holds symmetric orbits together, in units of their equations, is no more than this: rounding.
const PUSHED: f64 = 1e-8;

/// Points as near as this are one.
const SAME: f64 = 1e-6;

/// Feet as near as this are one place.
const CLOSEST: f64 = 1e-14;

/// The least growth that tells a pair from the circle.
const GROWTH: f64 = 1e-12;

/// The error is worked out at every so many points; between two it is no more than this times the larger of theirs.
const EVERY: usize = 16;
const BETWEEN: f64 = 2.0;

/// The curve may be this part of a step away from where it was foreseen.
const ASTRAY: f64 = 0.1;

/// Cosine of the angle by which it may turn in a step.
const STRAIGHT: f64 = 0.9;

/// Feet through which the next one is foreseen, each farther from the next than this part of the step.
const THROUGH: usize = 4;
const CROWDED: f64 = 0.1;

type Foot<O> = ManifoldPoint<AtEvent<O>, 1>;

fn norm(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}

/// Values of both numbers.
fn values<O>(foot: &Foot<O>) -> [f64; 2] {
    let z = foot.coordinates();
    [z[z.len() - 2], z[z.len() - 1]]
}

/// Something that happens on a curve where its value changes the sign.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Monitor {
    special: Special,
    /// Which of several of one kind.
    which: usize,
    value: f64,
}

impl Monitor {
    fn is(&self, other: &Self) -> bool {
        (self.special, self.which) == (other.special, other.which)
    }
}

/// Whether an orbit is physical, touches aside.
fn is_physical(told: &Admissibility, orbit: &impl EventOrbit) -> bool {
    match told.obstruction {
        None => true,
        Some(Obstruction::Crossing { excess, .. }) => excess <= TOUCHES * orbit.speed() / orbit.omega(),
        Some(Obstruction::WrongSign { velocity_before, .. }) => velocity_before.abs() <= TOUCHES * orbit.speed(),
    }
}

/// What is seen at a foot.
#[derive(Debug, Clone, Default)]
struct Seen {
    monitors: Vec<Monitor>,
    /// Whether the orbit is physical, touches aside.
    physical: Option<bool>,
}

/// What is followed, and how.
pub(crate) struct Asked<'a> {
    pub(crate) event: Event,
    pub(crate) evidence: Evidence,
    /// Least and largest values of both numbers.
    pub(crate) window: [[f64; 2]; 2],
    pub(crate) tolerance: f64,
    /// The number at whose least value masses are not coupled, if it is that.
    pub(crate) uncoupled: Option<usize>,
    /// Whether points of codimension two are looked for.
    pub(crate) special: bool,
    /// Told of each point, whether the curve need go no farther.
    pub(crate) until: &'a dyn Fn([f64; 2], Option<bool>) -> bool,
}

impl Asked<'_> {
    fn parts(&self, values: [f64; 2]) -> [f64; 2] {
        let [from, to] = self.window;
        [0, 1].map(|i| (values[i] - from[i]) / (to[i] - from[i]))
    }

    fn holds(&self, values: [f64; 2]) -> bool {
        let [from, to] = self.window;
        (0..2).all(|i| (from[i]..=to[i]).contains(&values[i]))
    }
}

/// What vanishes at an event, and its mark there.
fn test_of(event: Event, evidence: Evidence, orbit: &impl EventOrbit) -> Option<(Test, Option<f64>)> {
    Some(match (event, evidence) {
        (Event::Pitchfork, _) if orbit.is_conservative() => (Test::AnotherOne, None),
        (Event::Pitchfork, _) => (Test::One, None),
        (Event::Fold, _) => (Test::Fold, None),
        (Event::PeriodDoubling, _) => (Test::MinusOne, None),
        (Event::NeimarkSacker, Evidence::Multiplier(mu)) => {
            (if orbit.is_lossless() { Test::Collision } else { Test::Circle }, Some(mu.arg().abs()))
        }
        (Event::Grazing, Evidence::Impact(i)) => (Test::Velocity(i), None),
        (Event::Grazing, Evidence::Touch(touch)) => {
            (Test::Touch(touch.site, touch.barrier), Some(touch.time / orbit.period()))
        }
        _ => return None,
    })
}

/// Follows an event at `orbit`, one of the orbits of `base` at its origin, both ways through a window.
pub(crate) fn followed<S, W>(
    (base, orbit): (S, &W::Orbit),
    watcher: W,
    asked: &Asked<'_>,
) -> Result<EventCurve<W::Orbit>, CurveError>
where
    S: System<Orbit = W::Orbit>,
    W: Watcher,
{
    let not_there = || CurveError::NotThere(asked.event);
    let (test, mark) = test_of(asked.event, asked.evidence, orbit).ok_or_else(not_there)?;
    let mut base = base;
    let origin = base.origin()?;
    let mut manifold = Manifold::<_, 1>::of(EventSystem::new(base, test, &origin, mark));
    let z = manifold.system().origin()?;
    let last = z.len() - 1;
    // Where the curve stands still in one number it moves in the other.
    let first = manifold.correct(&z, &[unit(z.len(), last)], START, false);
    let first = first.or_else(|_| manifold.correct(&z, &[unit(z.len(), last - 1)], START, false));
    let first = first.map_err(|error| match error {
        BranchError::NoConvergence => not_there(),
        other => other.into(),
    })?;
    if manifold.system().push_along(&first.tangents()[0]).abs() > PUSHED {
        let message = "orbits of this symmetry, which they lose here, exist at no other value of one of the two numbers: no curve passes";
        return Err(BranchError::Model(message.to_owned()).into());
    }
    let strength = watcher.strength(&first.orbit().orbit);
    // By symmetry several impacts may have no velocity all along.
    let still = |velocity: f64| velocity.abs() <= TOUCHES * first.orbit().orbit.speed();
    let arrivals = first.orbit().orbit.arrivals();
    let grazing = match test {
        Test::Velocity(own) => (0..arrivals.len()).filter(|&i| i == own || still(arrivals[i].velocity)).collect(),
        _ => Vec::new(),
    };
    let vanish = grazing.len() == arrivals.len() || strongest(&first.orbit().orbit) < W::FAINT * strength;
    let mut tracer = Tracer { manifold, watcher, test, asked, strength, vanish, grazing };
    let (behind, special_behind, end_behind) = tracer.way(first.reversed());
    let (ahead, special_ahead, end) = match end_behind {
        CurveEnd::Closed => (vec![first], Vec::new(), CurveEnd::Closed),
        _ => tracer.way(first),
    };
    let before = behind.len();
    let behind_there = |(at, special, error): (usize, Special, f64)| (before - 1 - at, special, error);
    let mut special: Vec<_> = special_behind.into_iter().map(behind_there).collect();
    special.extend(special_ahead.into_iter().map(|(at, special, error)| (before - 1 + at, special, error)));
    special.sort_by_key(|one| one.0);
    let feet = joined(behind, ahead);
    let special = special.into_iter().map(|(point, special, error)| SpecialPoint {
        special,
        point,
        values: values(&feet[point]),
        error,
    });
    let special = special.collect();
    let errors = tracer.errors(&feet);
    let points = feet.iter().zip(errors).map(|(foot, error)| tracer.described(foot, error)).collect();
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

/// Who follows a curve.
struct Tracer<'a, S, W>
where
    S: System<Orbit = W::Orbit>,
    W: Watcher,
{
    manifold: Manifold<EventSystem<S>, 1>,
    watcher: W,
    test: Test,
    asked: &'a Asked<'a>,
    /// Impulses of the first orbit.
    strength: f64,
    /// All impulses vanish all along.
    vanish: bool,
    /// The impacts that have no velocity all along.
    grazing: Vec<usize>,
}

/// Feet of a way, what happens at which of them, and how it ends.
type Passed<O> = (Vec<Foot<O>>, Vec<(usize, Special, f64)>, CurveEnd);

impl<S, W> Tracer<'_, S, W>
where
    S: System<Orbit = W::Orbit>,
    W: Watcher,
{
    fn way(&mut self, start: Foot<W::Orbit>) -> Passed<W::Orbit> {
        let seen = self.seen(&start);
        let tolerance = self.asked.tolerance;
        let mut way = Way { tracer: self, seen, special: Vec::new(), told: 0, why: BranchError::NoConvergence };
        let (feet, end) = trace(&mut way, start, tolerance);
        (feet, way.special, end)
    }

    fn has_angle(&self) -> bool {
        matches!(self.test, Test::Circle | Test::Collision)
    }

    fn seen(&mut self, foot: &Foot<W::Orbit>) -> Seen {
        let AtEvent { orbit, mark, determinant, fold_determinant } = foot.orbit();
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
        if !self.asked.special {
            return Seen { monitors, physical };
        }
        for (i, (arrival, hit)) in orbit.arrivals().iter().zip(orbit.hits()).enumerate() {
            if !self.grazing.contains(&i) {
                add(Special::With(Event::Grazing), 1 + i, hit.barrier.sign() * arrival.velocity / speed);
            }
        }
        // Where one touches all along, be it with an impact, others are told once they are beyond.
        let own = if event == Event::Grazing { TOUCHES } else { 0.0 };
        if let Some(margin) = told.and_then(|told| told.margin) {
            add(Special::With(Event::Grazing), 0, margin * orbit.omega() / speed + own);
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
            let values = self.watcher.spectrum(orbit, Tolerance::Rounding).map(|(values, _)| values).unwrap_or_default();
            self.multipliers(&values, orbit.is_lossless(), &mut add);
        }
        Seen { monitors, physical }
    }

    /// Another multiplier where the curve's own is, and pairs on the circle.
    fn multipliers(&self, values: &[C], lossless: bool, add: &mut dyn FnMut(Special, usize, f64)) {
        let own = match self.test {
            Test::Fold | Test::One | Test::AnotherOne => Some((1.0, Special::OneToOne)),
            Test::MinusOne => Some((-1.0, Special::OneToTwo)),
            _ => None,
        };
        if let (Some((goal, strong)), false) = (own, values.is_empty()) {
            // All but the nearest.
            let distance = |value: &C| (value - goal).norm();
            let nearest = values.iter().map(distance).fold(f64::INFINITY, f64::min);
            let rest = values.iter().filter(|value| distance(value) > nearest);
            add(strong, 0, rest.map(|value| (value - goal) / (1.0 + value.norm())).product::<C>().re);
        }
        if lossless {
            return;
        }
        let growths = upper_half(values).into_iter().map(|value| value.norm().ln());
        let mut growths: Vec<f64> = growths.filter(|growth| growth.abs() > GROWTH).collect();
        if self.test == Test::Circle {
            let own = growths.iter().map(|growth| growth.abs()).fold(f64::INFINITY, f64::min);
            growths.retain(|growth| growth.abs() > own);
        }
        growths.sort_by(|a, b| b.total_cmp(a));
        growths.into_iter().enumerate().for_each(|(k, growth)| add(Special::With(Event::NeimarkSacker), k, growth));
    }

    /// Where the curve is expected, a length ahead of the last of some feet: through several of them, as edges of stripes are near to each other.
    fn foreseen(&self, feet: &[Foot<W::Orbit>], length: f64) -> Option<Vector> {
        let last = feet.last()?;
        // Those that nearly are one place tell nothing of how it bends.
        let mut places = vec![(0.0, last)];
        let (mut at, mut apart) = (0.0, 0.0);
        for pair in feet.windows(2).rev() {
            let step = self.manifold.distance(&pair[0], &pair[1]);
            (at, apart) = (at - step, apart + step);
            if apart > CROWDED * length.abs() {
                places.push((at, &pair[0]));
                apart = 0.0;
            }
            if places.len() == THROUGH {
                break;
            }
        }
        if places.len() == 1 {
            return Some(self.manifold.ahead(last, [length]));
        }
        let mut sum = zeros(last.coordinates().len());
        for (i, (at, foot)) in places.iter().enumerate() {
            let others = places.iter().enumerate().filter(|(j, _)| *j != i);
            let weight: f64 = others.map(|(_, (other, _))| (length - other) / (at - other)).product();
            sum.iter_mut().zip(foot.coordinates()).for_each(|(sum, x)| *sum += weight * x);
        }
        Some(sum)
    }

    /// The foot a length ahead of the last of some feet.
    fn advance(&mut self, feet: &[Foot<W::Orbit>], length: f64) -> Result<Foot<W::Orbit>, BranchError> {
        let foreseen = self.foreseen(feet, length).ok_or(BranchError::NoConvergence)?;
        self.advance_to(feet, &foreseen)
    }

    /// The foot near where it is foreseen, across the way there.
    fn advance_to(&mut self, feet: &[Foot<W::Orbit>], foreseen: &[f64]) -> Result<Foot<W::Orbit>, BranchError> {
        let last = feet.last().ok_or(BranchError::NoConvergence)?;
        let way = self.manifold.chord_to(last, foreseen);
        let length = norm(&way);
        let direction = way.iter().map(|x| x / length).collect();
        let next = self.manifold.correct(foreseen, &[direction], ASTRAY * length, false)?;
        // It does not turn back between two points.
        let back = feet.len().checked_sub(2).map(|i| self.manifold.chord_to(last, feet[i].coordinates()));
        let turns = |back: Vector| -dot(&back, &way) < STRAIGHT * length * norm(&back);
        // Symmetry is lost with the numbers themselves: no symmetric orbits are there that could lose it.
        let pushed = self.manifold.system().push(next.orbit()).abs() > PUSHED;
        if pushed || back.is_some_and(turns) { Err(BranchError::NoConvergence) } else { Ok(next) }
    }

    /// Where on a step from the last of some feet a function vanishes that has these values at its ends.
    fn located(
        &mut self,
        feet: &[Foot<W::Orbit>],
        length: f64,
        ends: [f64; 2],
        mut value: impl FnMut(&mut Self, &Foot<W::Orbit>) -> Option<f64>,
    ) -> Option<(Foot<W::Orbit>, f64)> {
        let (s, error) = crossing(ends, length, |s| {
            let foot = self.advance(feet, s).ok()?;
            value(self, &foot)
        })?;
        Some((self.advance(feet, s).ok()?, error.min(length)))
    }

    /// How the curve goes on in the plane of both numbers.
    fn heading(&self, foot: &Foot<W::Orbit>) -> [f64; 2] {
        let [tangent] = foot.tangents();
        [tangent[tangent.len() - 2], tangent[tangent.len() - 1]]
    }

    /// Two folds meet where the curve turns back in both numbers.
    fn cusp(&mut self, feet: &[Foot<W::Orbit>], to: &Foot<W::Orbit>, length: f64) -> Option<(Foot<W::Orbit>, f64)> {
        let before = self.heading(feet.last()?);
        let against = |[x, y]: [f64; 2]| x * before[0] + y * before[1];
        let ends = [against(before), against(self.heading(to))];
        if ends[1] > 0.0 {
            return None;
        }
        self.located(feet, length, ends, |tracer, foot| Some(against(tracer.heading(foot))))
    }

    /// The error at each of the feet, as a part of the window's sides.
    fn errors(&mut self, feet: &[Foot<W::Orbit>]) -> Vec<f64> {
        let last = feet.len().saturating_sub(1);
        let places: Vec<usize> = (0..last).step_by(EVERY).chain([last]).collect();
        let told: Vec<f64> =
            places.iter().map(|&i| self.manifold.system().error(&feet[i]).unwrap_or(f64::INFINITY)).collect();
        let mut errors = vec![f64::INFINITY; feet.len()];
        for (pair, told) in places.windows(2).zip(told.windows(2)) {
            errors[pair[0]..=pair[1]].fill(BETWEEN * told[0].max(told[1]));
        }
        places.iter().zip(&told).for_each(|(&i, error)| errors[i] = *error);
        errors
    }

    fn described(&mut self, foot: &Foot<W::Orbit>, error: f64) -> CurvePoint<W::Orbit> {
        let AtEvent { orbit, mark, .. } = foot.orbit();
        let told = self.watcher.admissibility(orbit).ok();
        let physical = told.map(|told| is_physical(&told, orbit));
        let angle = mark.filter(|_| self.has_angle()).map(|theta| theta.clamp(0.0, std::f64::consts::PI));
        let angle = angle.map(|theta| theta / std::f64::consts::PI);
        CurvePoint { values: values(foot), error, orbit: orbit.clone(), angle, physical }
    }
}

/// One way along the curve from its start.
struct Way<'t, 'a, S, W>
where
    S: System<Orbit = W::Orbit>,
    W: Watcher,
{
    tracer: &'t mut Tracer<'a, S, W>,
    /// At the last foot.
    seen: Seen,
    special: Vec<(usize, Special, f64)>,
    /// How many of these were known before the last step.
    told: usize,
    /// Why the last step failed.
    why: BranchError,
}

impl<S, W> Line for Way<'_, '_, S, W>
where
    S: System<Orbit = W::Orbit>,
    W: Watcher,
{
    type Point = Foot<W::Orbit>;
    type End = CurveEnd;

    const CLOSED: CurveEnd = CurveEnd::Closed;
    const LONG: CurveEnd = CurveEnd::Long;

    fn ahead(&mut self, passed: &[Self::Point], length: f64) -> Option<Step<Self::Point, CurveEnd>> {
        let (last, asked) = (passed.last()?, self.tracer.asked);
        let mut told = |next: Result<Self::Point, BranchError>| next.map_err(|why| self.why = why).ok();
        let foreseen = self.tracer.foreseen(passed, length)?;
        // A number that has reached the end of its range may have no model beyond.
        let mut beyond = [foreseen[foreseen.len() - 2], foreseen[foreseen.len() - 1]];
        if asked.holds(beyond) {
            let next = told(self.tracer.advance_to(passed, &foreseen))?;
            if asked.holds(values(&next)) {
                return Some(Step::On(next));
            }
            beyond = values(&next);
        }
        let [here, there] = [values(last), beyond].map(|values| asked.parts(values));
        let (which, goal, share) = side_ahead(here, [there[0] - here[0], there[1] - here[1]])?;
        let mut z = self.tracer.foreseen(passed, length * share.min(1.0))?;
        let place = z.len() - 2 + which;
        z[place] = asked.window[usize::from(goal > 0.0)][which];
        // The row heads the way of the step.
        let row: Vector = unit(z.len(), place).iter().map(|x| x * (2.0 * goal - 1.0)).collect();
        let edge = told(self.tracer.manifold.correct(&z, &[row], START.max(length), false))?;
        let uncoupled = asked.uncoupled == Some(which) && goal == 0.0;
        let end = if uncoupled { CurveEnd::Uncoupled } else { CurveEnd::Edge };
        asked.holds(values(&edge)).then_some(Step::Out(Some(edge), end))
    }

    /// Impulses that grow without bound set a longer scale.
    fn longest(&self, passed: &[Self::Point]) -> f64 {
        let growth = passed.last().map_or(1.0, |foot| strongest(&foot.orbit().orbit) / self.tracer.strength);
        Self::LONGEST * growth.max(1.0)
    }

    fn bend(&self, through: [&Self::Point; 3]) -> f64 {
        let [a, b, c] = through;
        let lengths = [self.tracer.manifold.distance(a, b), self.tracer.manifold.distance(b, c)];
        chord_error(through.map(|foot| self.tracer.asked.parts(values(foot))), lengths)
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
        let seen = self.tracer.seen(&next);
        let Some(last) = passed.last().cloned() else { return };
        let length = self.tracer.manifold.length_between(&last, &next);
        let mut found: Vec<(f64, Self::Point, Special, f64)> = Vec::new();
        let mut take = |tracer: &Tracer<'_, S, W>, located: Option<(Self::Point, f64)>, special| {
            let along = |foot: &Self::Point| tracer.manifold.length_between(&last, foot);
            found.extend(located.map(|(foot, error)| (along(&foot), foot, special, error)));
        };
        for before in &self.seen.monitors {
            let Some(after) = seen.monitors.iter().find(|one| one.is(before)) else { continue };
            if (before.value > 0.0) == (after.value > 0.0) {
                continue;
            }
            let located = self.tracer.located(passed, length, [before.value, after.value], |tracer, foot| {
                let there = tracer.seen(foot);
                there.monitors.iter().find(|one| one.is(before)).map(|one| one.value)
            });
            take(self.tracer, located, before.special);
        }
        if self.tracer.asked.event == Event::Fold && self.tracer.asked.special {
            let located = self.tracer.cusp(passed, &next, length);
            take(self.tracer, located, Special::Cusp);
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut reached = 0.0;
        for (along, foot, special, error) in found {
            // Those at one place are all told of that place.
            if along - reached > CLOSEST {
                passed.push(foot);
                reached = along;
            }
            self.special.push((passed.len() - 1, special, error));
        }
        if length - reached > CLOSEST {
            passed.push(next);
        }
        self.seen = seen;
    }

    fn ended(&mut self, passed: &mut Vec<Self::Point>) -> Option<CurveEnd> {
        let foot = passed.last()?;
        let AtEvent { orbit, mark, .. } = foot.orbit();
        let theta = mark.filter(|_| self.tracer.has_angle());
        if let Some(theta) = theta.filter(|theta| !(0.0..=std::f64::consts::PI).contains(theta)) {
            let real = |(_, one, _): &&(usize, Special, f64)| matches!(one, Special::OneToOne | Special::OneToTwo);
            let reached = self.special[self.told..].iter().rfind(real).map(|&(place, special, _)| (place, special));
            // Where rounding hides the place itself the curve ends beside it.
            let other = if theta < 0.0 { Special::OneToOne } else { Special::OneToTwo };
            let (place, special) = reached.unwrap_or((passed.len().saturating_sub(2), other));
            passed.truncate(place + 1);
            self.special.retain(|(other, ..)| *other <= place);
            return Some(CurveEnd::Special(special));
        }
        if (self.tracer.asked.until)(values(foot), self.seen.physical) {
            return Some(CurveEnd::Halted);
        }
        match strongest(orbit) / self.tracer.strength {
            _ if self.tracer.vanish => None,
            UNBOUNDED.. => Some(CurveEnd::Unbounded),
            share if share < W::FAINT => Some(CurveEnd::ImpulsesVanish),
            _ => None,
        }
    }

    fn lost(&self, passed: &[Self::Point]) -> CurveEnd {
        let orbit = passed.last().map(|foot| &foot.orbit().orbit);
        if let Some(resonance) = orbit.and_then(EventOrbit::resonance) {
            return CurveEnd::Resonance(resonance);
        }
        let spectral = matches!(self.tracer.test, Test::Collision | Test::MinusOne | Test::AnotherOne);
        match self.why.clone() {
            BranchError::NoConvergence if spectral && orbit.is_some_and(EventOrbit::is_lossless) => CurveEnd::Thin,
            why => CurveEnd::Lost(why),
        }
    }
}
