//! A branch of orbits of a structure, followed both ways as one number of it varies, with the events on it.
//!
//! A step holds an event where a test function changes its sign, or the number of multipliers outside the circle changes. Newton's method
//! solves the orbit's equations together with the test function; the step is halved until the solution lies in it.

use nalgebra::Complex;
use vibrochain_breather::system::{System, Vector, unit};
use vibrochain_breather::{
    Approach, BranchError, Departure, Pace, StructureBranch, StructureBranchPoint, StructureFamily, StructureOrbit,
    structure_admissibility, structure_is_physical,
};
use vibrochain_lattice::Stop;

use super::curve::OfStructures;
use super::ends::Ahead;
use super::seen::{At, Seen, changes, described, guesses, touch_between, value};
use super::stability::structure_stability;
use super::switch::departure;
use crate::bracket::{crossing, zero};
use crate::curve::{TOUCHES, UNBOUNDED, Watcher, strongest};
use crate::events::{AtEvent, EventOrbit, Solved, Test, another_one, minus_one, solve};
use crate::locate::{
    Diagram, End, Event, Evidence, FollowedBranch, LocateError, Located, Station, Traced, Tracing, Unresolved,
    first_step, grown,
};
use crate::verdict::{Tolerance, Verdict};

type C = Complex<f64>;

/// What is passed on one way.
type Stations = Vec<Station<StructureOrbit>>;

/// A multiplier farther than this from where it should be, relative, is not the zero of the function.
const POLE: f64 = 1e-4;

/// How often a step is halved until Newton's method finds the event in it.
const HALVINGS: usize = 8;

/// Steps as short as this next to a resonance lead nowhere but to it.
const CRAWL: f64 = 1e-6;

/// Steps at most in one direction.
const MOST_STEPS: usize = 20_000;

/// The orbit at which a branch ends is no farther than this from where it turned back, as a part of the range.
const NEAR: f64 = 1e-3;

/// Beside an event where symmetry is lost symmetric orbits are taken up this far, as a part of the range.
const ASIDE: f64 = 1e-3;

/// Lengths as short as this are rounding.
const SETTLED: f64 = 1e-6;

/// What is asked of a branch of a structure.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct StructureCourse {
    /// Least value of the number that varies.
    pub from: f64,
    /// Largest value.
    pub to: f64,
    /// The events that are looked for.
    pub events: Vec<Event>,
    /// How often a branch may leave another: 0 for the orbit's own alone.
    pub generations: u32,
    /// What counts as stable.
    pub tolerance: Tolerance,
}

/// The bifurcation diagram of an orbit of a structure: its branch as a number of `family` goes on from `value` both ways, through folds, to the
/// ends of the range or of the branch, with all events that are asked for; and so many generations of the branches that leave it at period
/// doublings, where symmetry is lost, and at grazings. Two events that cancel within one step, a fiftieth of the range at most, are not seen.
///
/// # Errors
/// [`LocateError`]: no such range, no such model, stopped.
pub fn structure_diagram(
    orbit: &StructureOrbit,
    family: &StructureFamily,
    value: f64,
    course: &StructureCourse,
    stop: &Stop,
) -> Result<Diagram<StructureOrbit>, LocateError> {
    let tracing = StructureTracing { family, course, stop };
    let own = tracing.both_ways(orbit, value)?;
    grown(&tracing, own, course.generations)
}

/// The orbit's own branch of [`structure_diagram`].
///
/// # Errors
/// As [`structure_diagram`].
pub fn structure_branch(
    orbit: &StructureOrbit,
    family: &StructureFamily,
    value: f64,
    course: &StructureCourse,
    stop: &Stop,
) -> Result<FollowedBranch<StructureOrbit>, LocateError> {
    StructureTracing { family, course, stop }.both_ways(orbit, value).map(|traced| traced.branch)
}

/// Who follows the branches of a structure's orbits.
struct StructureTracing<'a> {
    family: &'a StructureFamily,
    course: &'a StructureCourse,
    stop: &'a Stop,
}

impl StructureTracing<'_> {
    fn follower(&self, branch: StructureBranch) -> Follower<'_> {
        let StructureTracing { family, course, stop } = *self;
        let ahead = Ahead { family, range: self.range(), tolerance: course.tolerance, stop };
        Follower { branch, course, stop, ahead, unresolved: Vec::new() }
    }

    fn range(&self) -> f64 {
        self.course.to - self.course.from
    }

    /// The branch through an orbit, both ways.
    fn both_ways(&self, orbit: &StructureOrbit, value: f64) -> Result<Traced<StructureOrbit>, LocateError> {
        let StructureCourse { from, to, .. } = *self.course;
        if !(from <= value && value <= to && from < to) {
            let message =
                format!("{value} is not in a range from {from} to {to}: give one with from < to around the start");
            return Err(BranchError::Model(message).into());
        }
        let mut branch = StructureBranch::of_structure(orbit, self.family.clone(), value, self.range(), self.stop)?;
        let up = branch.start()?;
        let up = if up.heading() < 0.0 { up.reversed() } else { up };
        let mut follower = self.follower(branch);
        let (mut stations, first_end) = follower.follow(up.reversed())?;
        let mut ends = vec![first_end];
        stations.reverse();
        if ends[0].1 != End::Closed {
            let (ahead, end) = follower.follow(up)?;
            stations.extend(ahead.into_iter().skip(1));
            ends.push(end);
        }
        Ok(follower.traced(stations, ends))
    }
}

impl Tracing for StructureTracing<'_> {
    type Orbit = StructureOrbit;
    type Leaving = (StructureBranch, StructureBranchPoint, StructureBranchPoint);

    fn departure(&self, located: &Located<StructureOrbit>) -> Option<Departure> {
        departure(located)
    }

    fn through(&self, located: &Located<StructureOrbit>) -> Result<Traced<StructureOrbit>, LocateError> {
        // Right where symmetry is lost there are two directions; beside it the symmetric orbits have one.
        let StructureCourse { from, to, .. } = *self.course;
        let aside = if located.value < 0.5 * (from + to) { ASIDE } else { -ASIDE };
        let value = located.value + aside * self.range();
        let family = self.family.clone();
        let mut branch = StructureBranch::of_structure(&located.orbit, family, located.value, self.range(), self.stop)?;
        let mut z = Vector::from(branch.system().origin()?);
        let last = z.len() - 1;
        z[last] = value;
        let beside = branch.correct(&z, &[unit(last + 1, last)], 1.0, false)?;
        self.both_ways(beside.orbit(), value)
    }

    fn leaving(&self, located: &Located<StructureOrbit>, departure: &Departure) -> Option<Self::Leaving> {
        let place = (located.value, located.value.abs().max(self.range()));
        let leaving =
            StructureBranch::leaving_structure(&located.orbit, departure, self.family.clone(), place, self.stop);
        let (mut branch, start) = leaving.ok()?;
        let is_physical = |orbit: &StructureOrbit| structure_is_physical(orbit).is_ok_and(|told| told.is_physical());
        let first = first_step(&mut branch, &start, departure, is_physical)?;
        Some((branch, start, first))
    }

    fn first((_, _, first): &Self::Leaving) -> (f64, &StructureOrbit) {
        (first.value(), first.orbit())
    }

    fn follow(&self, (branch, start, first): Self::Leaving) -> Result<Traced<StructureOrbit>, LocateError> {
        let mut follower = self.follower(branch);
        let (behind, end) = follower.follow(first)?;
        let seen = Seen::at(&start, self.course.tolerance);
        let mut stations = vec![Station::Point(described(&start, &seen))];
        stations.extend(behind);
        Ok(follower.traced(stations, vec![end]))
    }
}

struct Follower<'a> {
    branch: StructureBranch,
    course: &'a StructureCourse,
    stop: &'a Stop,
    ahead: Ahead<'a>,
    unresolved: Vec<Unresolved>,
}

impl Follower<'_> {
    fn traced(self, stations: Stations, ends: Vec<(f64, End)>) -> Traced<StructureOrbit> {
        let (origin, generation, unresolved) = (None, 0, self.unresolved);
        let branch = FollowedBranch { origin, generation, stations, unresolved, untold: 0, ends };
        Traced { branch, evaluations: self.branch.evaluations(), spectra: 0 }
    }

    /// One way, from the start on: the start, then all that is passed.
    fn follow(&mut self, start: StructureBranchPoint) -> Result<(Stations, (f64, End)), LocateError> {
        let mut seen = Seen::at(&start, self.course.tolerance);
        let mut stations = vec![Station::Point(described(&start, &seen))];
        let mut point = start.clone();
        if point.value() == self.limit(&point) {
            return Ok((stations, (point.value(), End::Range)));
        }
        let mut pace = Pace::new(0.25 * Pace::LONGEST);
        let first = OfStructures.strength(point.orbit());
        for step in 0..MOST_STEPS {
            self.stop.heard()?;
            let (next, last) = match self.advance(&point, pace.length()) {
                Ok(next) => next,
                Err(error) => {
                    self.stop.heard()?;
                    let (shorter, resonance) = (pace.shorten(), point.orbit().resonance());
                    let near = pace.length() < CRAWL && resonance.is_some();
                    if shorter && !near {
                        continue;
                    }
                    if let Some((end, located)) = self.ahead.merging(&point).filter(|_| resonance.is_none()) {
                        let value = self.ended(located, &mut stations);
                        return Ok((stations, (value, end)));
                    }
                    let end = resonance.map_or(End::Lost(error), End::Resonance);
                    return Ok((stations, (point.value(), end)));
                }
            };
            let closed = step > 0 && self.closes(&start, &point, &next);
            let next = if closed { start.clone() } else { next };
            if let Some(value) = self.mirrored(&point, &next) {
                let nearest = if point.heading().abs() < next.heading().abs() { &point } else { &next };
                let met = self.ahead.meeting(nearest);
                let met = met.filter(|met| (met.value - value).abs() <= NEAR * (self.course.to - self.course.from));
                let value = met.map_or(value, |met| self.ended(met, &mut stations));
                return Ok((stations, (value, End::Pitchfork)));
            }
            let next_seen = Seen::at(&next, self.course.tolerance);
            let mut found = self.events((&point, &seen), (&next, &next_seen))?;
            found.sort_by(|(one, _), (other, _)| one.total_cmp(other));
            stations.extend(found.into_iter().map(|(_, located)| Station::Event(located)));
            stations.push(Station::Point(described(&next, &next_seen)));
            (point, seen) = (next, next_seen);
            let strength = strongest(point.orbit());
            let end = match () {
                () if closed => End::Closed,
                () if last => End::Range,
                () if strength > UNBOUNDED * first => End::Unbounded,
                () if strength < OfStructures::FAINT * first => End::ImpulsesVanish,
                () => {
                    // Impulses that grow without bound set a longer scale, as long as the number does not move far.
                    let growth = (strength / first).clamp(1.0, 1.0 / point.heading().abs());
                    pace.lengthen(f64::INFINITY, Pace::LONGEST * growth);
                    continue;
                }
            };
            return Ok((stations, (point.value(), end)));
        }
        Ok((stations, (point.value(), End::Lost(BranchError::NoConvergence))))
    }

    /// The value of an event at which the branch ends, which is one of its stations if it is asked for.
    fn ended(&self, located: Located<StructureOrbit>, stations: &mut Stations) -> f64 {
        let value = located.value;
        if self.course.events.contains(&located.event) {
            stations.push(Station::Event(located));
        }
        value
    }

    /// The end of the range that the branch is heading for.
    fn limit(&self, point: &StructureBranchPoint) -> f64 {
        if point.heading() > 0.0 { self.course.to } else { self.course.from }
    }

    /// The next point, at most at the limit; whether it is the last.
    fn advance(
        &mut self,
        point: &StructureBranchPoint,
        length: f64,
    ) -> Result<(StructureBranchPoint, bool), BranchError> {
        let (from, to) = (self.course.from, self.course.to);
        let beyond = |value: f64| value >= to || value <= from;
        let reached = point.value() + length * point.heading() * (to - from);
        let next = if beyond(reached) { None } else { Some(self.branch.step(point, length)?) };
        match next.filter(|next| !beyond(next.value())) {
            Some(next) => Ok((next, false)),
            None => Ok((self.branch.at(point, self.limit(point))?, true)),
        }
    }

    /// The value where orbits come to one that repeats or mirrors itself and go on as their own images: there the equations are singular in two
    /// directions, so that the branch turns back without a change of their determinant's sign.
    fn mirrored(&mut self, point: &StructureBranchPoint, next: &StructureBranchPoint) -> Option<f64> {
        let turns = point.heading() * next.heading() <= 0.0 && point.determinant() * next.determinant() > 0.0;
        if !(turns && point.orbit().is_across(next.orbit())) {
            return None;
        }
        // Right there the equations may fail: the orbit that came nearest tells it to the square of its distance.
        let mut nearest = [point, next].map(|end| (end.heading().abs(), end.value()));
        nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
        let [mut nearest, _] = nearest;
        let length = self.branch.length_between(point, next);
        let heading = |s: f64| -> Result<f64, BranchError> {
            let there = self.branch.step(point, s)?;
            if there.heading().abs() < nearest.0 {
                nearest = (there.heading().abs(), there.value());
            }
            Ok(there.heading())
        };
        let _ = zero((0.0, point.heading()), (length, next.heading()), length, heading);
        Some(nearest.1)
    }

    /// Whether the start lies on the way from `point` to `next`.
    fn closes(
        &mut self,
        start: &StructureBranchPoint,
        point: &StructureBranchPoint,
        next: &StructureBranchPoint,
    ) -> bool {
        let (to_start, to_next) = (self.branch.length_between(point, start), self.branch.length_between(point, next));
        0.0 < to_start
            && to_start <= to_next
            && self.branch.step(point, to_start).is_ok_and(|there| {
                self.branch.distance(&there, start) <= SETTLED && there.heading() * start.heading() >= 0.0
            })
    }

    /// What happens between two points.
    fn events(&mut self, from: At<'_>, to: At<'_>) -> Result<Vec<(f64, Located<StructureOrbit>)>, LocateError> {
        let turns = from.0.heading() * to.0.heading() <= 0.0;
        let changed = |test: Test| changes(test, from, to);
        let mut tests: Vec<Test> = Vec::new();
        let on_circle = if from.0.orbit().model().structure().is_lossless() { Test::Collision } else { Test::Circle };
        let real = usize::from(changed(Test::One)) + usize::from(changed(Test::MinusOne));
        let (before, after) = (from.1.outside.unwrap_or(0), to.1.outside.unwrap_or(0));
        // One that crosses at ±1 changes the number by one, a pair by two; without losses only what is not real is counted.
        let pairs = if on_circle == Test::Collision { before != after } else { before.abs_diff(after) > real };
        // Where the losses end all multipliers come to the circle.
        let lossless = |at: At<'_>| at.0.orbit().model().structure().is_lossless();
        let pairs = pairs && lossless(from) == lossless(to);
        // An orbit that may begin at any time turns back where its own equations say so, and has another +1 where the rest does.
        let one = if turns || from.1.another_one.is_none() { Test::One } else { Test::AnotherOne };
        tests.extend([one, Test::MinusOne].into_iter().filter(|test| changed(*test)));
        if pairs && from.1.outside.is_some() && to.1.outside.is_some() {
            tests.push(on_circle);
        }
        tests.extend((0..from.1.velocities.len()).map(Test::Velocity).filter(|test| changed(*test)));
        if let Some(touch) = touch_between(from, to) {
            tests.push(touch);
        }
        let mut found = Vec::new();
        for test in tests {
            let event = test.event(turns);
            if !self.course.events.contains(&event) {
                continue;
            }
            match self.settle(test, from, to, HALVINGS)? {
                Some((test, solved)) => {
                    let along = self.length_to(from.0, &solved);
                    if let Some(located) = self.told(event, test, (from.0, along), &solved)? {
                        found.push((along, located));
                    }
                }
                None => {
                    let values = [from.0.value(), to.0.value()];
                    self.unresolved.push(Unresolved { from: values[0].min(values[1]), to: values[0].max(values[1]) });
                }
            }
        }
        Ok(found)
    }

    fn length_to(&mut self, from: &StructureBranchPoint, solved: &Solved<StructureOrbit>) -> f64 {
        let chord = self.branch.chord_to(from, &solved.coordinates);
        self.branch.along(from, &chord)
    }

    /// The event of a test function between two points where it changes.
    fn settle(
        &mut self,
        test: Test,
        from: At<'_>,
        to: At<'_>,
        halvings: usize,
    ) -> Result<Option<(Test, Solved<StructureOrbit>)>, LocateError> {
        let length = self.branch.length_between(from.0, to.0);
        // What is nearest at one end need not be what touches first.
        let test = if matches!(test, Test::Touch(..)) { touch_between(from, to).unwrap_or(test) } else { test };
        let by_sign = match (value(test, from), value(test, to)) {
            (Some(a), Some(b)) if a != b => (a / (a - b)).clamp(0.0, 1.0),
            _ => 0.5,
        };
        for (share, mark) in guesses(test, from, to, by_sign) {
            let ends = from.0.coordinates().iter().zip(to.0.coordinates());
            let mut z: Vec<f64> = ends.map(|(a, b)| a + share * (b - a)).collect();
            if test == Test::One
                && let Ok(there) = self.branch.step(from.0, share * length)
            {
                // Symmetric orbits are told by their symmetry, which a chord loses.
                z = there.coordinates().to_vec();
            }
            let reach = (2.0 * length).max(SETTLED);
            let Ok(solved) = solve(self.branch.system(), test, (&z, mark), reach) else { continue };
            let along = self.length_to(from.0, &solved);
            if (-SETTLED..=length + SETTLED).contains(&along) && self.is_seen(test, &solved)? {
                return Ok(Some((test, solved)));
            }
        }
        self.stop.heard()?;
        if halvings == 0 {
            return Ok(self.bracketed(test, from.0, length).map(|solved| (test, solved)));
        }
        let Ok(middle) = self.branch.step(from.0, 0.5 * length) else { return Ok(None) };
        let seen = Seen::at(&middle, self.course.tolerance);
        let middle = (&middle, &seen);
        if changes(test, from, middle) || matches!(test, Test::Touch(..)) && touch_between(from, middle).is_some() {
            self.settle(test, from, middle, halvings - 1)
        } else {
            self.settle(test, middle, to, halvings - 1)
        }
    }

    /// Where Newton's method cannot lead, as to a point where symmetric orbits lose their symmetry: the zero along the branch.
    fn bracketed(&mut self, test: Test, from: &StructureBranchPoint, length: f64) -> Option<Solved<StructureOrbit>> {
        let read = |point: &StructureBranchPoint| match test {
            Test::One => Some(point.determinant()),
            Test::MinusOne => minus_one(point.orbit()).ok(),
            Test::AnotherOne => another_one(point.orbit()),
            _ => None,
        };
        let first = read(from)?;
        let branch = &mut self.branch;
        let mut at = |s: f64| branch.step(from, s).ok().and_then(|point| read(&point));
        let last = at(length)?;
        if (first > 0.0) == (last > 0.0) {
            return None;
        }
        let (s, along) = crossing([first, last], length, at)?;
        let point = self.branch.step(from, s).ok()?;
        let range = self.course.to - self.course.from;
        let error = along * point.heading().abs() * range + f64::EPSILON * point.value().abs();
        let at = AtEvent { orbit: point.orbit().clone(), mark: None, determinant: 0.0, fold_determinant: 0.0 };
        Some(Solved { at, coordinates: point.coordinates().into(), value: point.value(), error })
    }

    /// The multiplier of an event, if it is where it should be; of a grazing that which touches.
    fn evidence(&self, test: Test, solved: &Solved<StructureOrbit>) -> Result<Option<Evidence>, LocateError> {
        let orbit = &solved.at.orbit;
        let goal = match test {
            Test::Velocity(i) => return Ok(Some(Evidence::Impact(i))),
            Test::Touch(site, barrier) => {
                let time = solved.at.mark.unwrap_or(0.0).rem_euclid(1.0) * orbit.period();
                return Ok(Some(Evidence::Touch(Approach { site, barrier, time })));
            }
            Test::Fold | Test::One | Test::AnotherOne => C::new(1.0, 0.0),
            Test::MinusOne => C::new(-1.0, 0.0),
            Test::Circle | Test::Collision => C::from_polar(1.0, solved.at.mark.unwrap_or(0.0)),
        };
        // Two that meet are known to the root of rounding, and may not be told apart.
        let Ok(stability) = structure_stability(orbit, self.course.tolerance) else {
            return Ok(Some(Evidence::Multiplier(goal)));
        };
        let nearest = stability.multipliers.into_iter().min_by(|a, b| (a - goal).norm().total_cmp(&(b - goal).norm()));
        Ok(nearest.filter(|mu| (mu - goal).norm() <= POLE * (1.0 + goal.norm())).map(Evidence::Multiplier))
    }

    /// Whether a zero of the test function is an event.
    fn is_seen(&self, test: Test, solved: &Solved<StructureOrbit>) -> Result<bool, LocateError> {
        if matches!(test, Test::Touch(..)) {
            // Another contact may be beyond its barrier already.
            let orbit = &solved.at.orbit;
            let room = TOUCHES * orbit.speed() / orbit.model().omega();
            let margin = structure_admissibility(orbit).ok().and_then(|told| told.margin);
            return Ok(margin.is_some_and(|margin| margin >= -room));
        }
        Ok(self.evidence(test, solved)?.is_some())
    }

    fn told(
        &mut self,
        event: Event,
        test: Test,
        (from, along): (&StructureBranchPoint, f64),
        solved: &Solved<StructureOrbit>,
    ) -> Result<Option<Located<StructureOrbit>>, LocateError> {
        let Some(evidence) = self.evidence(test, solved)? else { return Ok(None) };
        let physical = structure_is_physical(&solved.at.orbit).ok().map(|told| told.is_physical());
        let mut verdicts: Vec<(f64, Verdict)> = Vec::new();
        for side in [-1e-2, 1e-2] {
            let Ok(point) = self.branch.step(from, along + side * Pace::LONGEST) else { continue };
            if let Ok(told) = structure_stability(point.orbit(), self.course.tolerance) {
                verdicts.push((point.value(), told.verdict));
            }
        }
        verdicts.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Some(Located {
            event,
            value: solved.value,
            error: solved.error,
            orbit: solved.at.orbit.clone(),
            evidence,
            physical,
            verdicts,
            branching: None,
            evaluations: self.branch.evaluations(),
        }))
    }
}
