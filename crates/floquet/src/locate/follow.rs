//! Along the branch, both ways: steps, folds, and what ends the way.

use nalgebra::Complex;
use vibrochain_breather::{Branch, BranchError, BranchPoint, BreatherError, Found, Orbit, Pace};
use vibrochain_lattice::{Parameter, Stop};

use super::answer::{Answer, End, Event, Evidence, LocateError, Located, Search};
use super::follower::{Follower, Observation, Passed, shift_of};
use crate::bracket::zero;

/// Steps as short as this next to a resonance lead nowhere but to it.
const CRAWL: f64 = 1e-6;

/// An orbit whose impulses have grown by this factor is on its way to infinity.
const UNBOUNDED: f64 = 1e4;

/// A branch that is lost this near to a resonance, as a part of the range, ends there.
const NEAR: f64 = 1e-3;

/// Impulses this much smaller than at the start, or than a mass of the ring's own speed would have, are about to vanish.
const FAINT: f64 = 1e-2;

/// Newton's steps for a peak that is nearly met.
const PEAK_STEPS: usize = 6;

/// The equations of a fold move a turning point by no more than this, in units: the root of rounding, with room.
const SETTLED: f64 = 1e-6;

/// Steps at most in one direction.
const MOST_STEPS: usize = 20_000;

/// The shortest range, as a part of the start: a fiftieth of it, and a thousandth of that, are more than rounding.
const LEAST: f64 = 1e-9;

/// What became of a step in which the branch turned back.
enum Round {
    /// It goes on; what is seen at its end.
    On(Observation),
    /// The branch ends.
    Ends(f64, End),
}

/// Follows the branch of `orbit` both ways, to the ends of the range or of the branch, and collects all events. Two that
/// cancel within one step (a fiftieth of the range at most) are not seen.
///
/// # Errors
/// [`LocateError`].
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_floquet::{Event, Search, locate};
/// use vibrochain_lattice::{Chain, Model, Parameter};
/// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.07, 0.8, 0.165, 0.25)?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let search = Search::new(orbit, Event::PeriodDoubling, Parameter::Amplitude);
/// let answer = locate(orbit, &search)?;
/// assert!((answer.located[0].value - 0.158908086).abs() < 1e-9);
/// assert!(answer.located[0].branching.as_ref().is_some_and(|doubled| doubled.orbits.len() == 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn locate(orbit: &Orbit, search: &Search) -> Result<Answer, LocateError> {
    locate_until(orbit, search, &Stop::default())
}

/// The same, until `stop` is raised, which is looked at before every orbit and every eigenvalue problem.
///
/// # Errors
/// As [`locate`]; [`LocateError::Stopped`].
pub fn locate_until(orbit: &Orbit, search: &Search, stop: &Stop) -> Result<Answer, LocateError> {
    let Search { free, from, to, .. } = *search;
    check(orbit, free, (from, to))?;
    let start = orbit.model().get(free);
    let mut follower = Follower::new(Branch::through(orbit, free, to - from)?, (from, to), vec![search.event], stop);
    let point = follower.branch.start()?;
    let (up, down) = if point.heading() < 0.0 { (point.reversed(), point) } else { (point.clone(), point.reversed()) };
    let ends = [follower.follow(down)?, follower.follow(up)?];
    // On the way a failure may be an end.
    stop.heard()?;
    let (evaluations, spectra) = (follower.evaluations(), follower.spectra);
    let mut located: Vec<Located> = follower.passed.into_iter().filter_map(Passed::event).collect();
    located.sort_by(|a, b| (a.value - start).abs().total_cmp(&(b.value - start).abs()));
    // A start right on the event is found from both sides.
    located.dedup_by(|b, a| (a.value - b.value).abs() <= a.error + b.error);
    Ok(Answer { located, unresolved: follower.unresolved, ends, evaluations, spectra })
}

/// Whether the branch of `orbit` can be followed over a range.
pub(super) fn check(orbit: &Orbit, free: Parameter, (from, to): (f64, f64)) -> Result<(), LocateError> {
    let start = orbit.model().get(free);
    if !(from <= start && start <= to && from < to) {
        return Err(LocateError::Range { free, start, from, to });
    }
    if to - from < LEAST * start.abs() {
        return Err(LocateError::Short { free, from, to });
    }
    for end in [from, to] {
        orbit.model().with(free, end).map_err(BreatherError::from)?;
    }
    if orbit.model().is_conservative() && matches!(free, Parameter::Amplitude | Parameter::Restitution) {
        return Err(LocateError::NoForce { free });
    }
    Ok(())
}

impl Follower {
    pub(super) fn evaluations(&self) -> usize {
        self.branch.evaluations() + self.others
    }

    /// Follows one direction to the end of the way.
    pub(super) fn follow(&mut self, start: BranchPoint) -> Result<(f64, End), LocateError> {
        let mut point = start.clone();
        if point.value() == self.limit(&point) {
            return Ok((point.value(), End::Range));
        }
        let mut seen = self.look(&point)?;
        let mut pace = Pace::new(0.25 * Pace::LONGEST);
        let first = point.orbit().strength().max(f64::MIN_POSITIVE);
        for step in 0..MOST_STEPS {
            self.stop().heard()?;
            let (next, last) = match self.advance(&point, pace.length()) {
                Ok(next) => next,
                Err(error) => {
                    let shorter = pace.shorten();
                    if pace.length() < CRAWL
                        && let Some(end) = self.resonance_ahead(&point)
                    {
                        return Ok(end);
                    }
                    if shorter {
                        continue;
                    }
                    return Ok(self.given_up(&point, first, End::Lost(error)));
                }
            };
            if let Some((value, resonance)) = self.branch.resonance_within(&point, next.value()) {
                return Ok((value, End::Resonance(resonance)));
            }
            let closed = self.whole && step > 0 && self.passes(&start, &point, &next);
            let next = if closed { start.clone() } else { next };
            let (turns, from) = (next.heading() * point.heading() <= 0.0, (&point, &seen));
            let watched = if turns { self.round(from, &next) } else { self.watch(from, &next).map(Round::On) };
            let next_seen = match watched {
                Ok(Round::On(next_seen)) => next_seen,
                Ok(Round::Ends(value, end)) => return Ok((value, end)),
                Err(error) => return self.stopped(&point, first, error),
            };
            (point, seen) = (next, next_seen);
            if closed {
                return Ok((point.value(), End::Closed));
            }
            if last {
                return Ok((point.value(), End::Range));
            }
            let growth = point.orbit().strength() / first;
            if growth > UNBOUNDED {
                return Ok((point.value(), End::Unbounded));
            }
            // Impulses that grow without bound set a longer scale, as long as the parameter does not move far.
            let longest = Pace::LONGEST * growth.clamp(1.0, 1.0 / point.heading().abs());
            pace.lengthen(f64::INFINITY, longest);
        }
        let lost = || self.given_up(&point, first, End::Lost(BranchError::NoConvergence));
        Ok(self.resonance_ahead(&point).unwrap_or_else(lost))
    }

    /// A failure on the way ends the way, it does not undo what was found before.
    fn stopped(&self, point: &BranchPoint, first: f64, error: LocateError) -> Result<(f64, End), LocateError> {
        match error {
            LocateError::Branch(error) => Ok(self.given_up(point, first, End::Lost(error))),
            LocateError::Floquet(error) => Ok(self.given_up(point, first, End::Unwatched(error))),
            other => Err(other),
        }
    }

    /// The end of a way that leads no farther: `otherwise`, unless the impulses vanish right ahead.
    fn given_up(&self, point: &BranchPoint, first: f64, otherwise: End) -> (f64, End) {
        match self.vanishing_ahead(point, first) {
            Some(value) => (value, End::ImpulsesVanish),
            None => (point.value(), otherwise),
        }
    }

    /// Where, right ahead, the motion that the force drives alone touches the barrier of orbits with hardly any impulse left, of the
    /// `first`: there the impulses vanish together, the impacts merge, and the equations have no other orbit next to them.
    fn vanishing_ahead(&self, point: &BranchPoint, first: f64) -> Option<f64> {
        let (orbit, free) = (point.orbit(), self.free);
        let (impact, psi) = (orbit.impacts().first()?, orbit.psi()?);
        if orbit.strength() > FAINT * first.max(orbit.model().omega()) {
            return None;
        }
        let touch = |value: f64| {
            let model = orbit.model().with(free, value).ok()?;
            let motion = model.steady().ok()?.at(impact.site);
            // The peak, where the impact is, but for little.
            let mut t = (impact.time + psi) * model.period() / orbit.model().period();
            for _ in 0..PEAK_STEPS {
                let [_, velocity, acceleration, _] = motion.jet(t);
                t -= velocity / acceleration;
            }
            Some(impact.barrier.sign() * (motion.value(t) - model.barrier(impact.barrier)))
        };
        let from = point.value();
        let to = (from + (NEAR * self.range()).copysign(point.heading())).clamp(self.from, self.to);
        let (low, high) = (touch(from)?, touch(to)?);
        ((low > 0.0) != (high > 0.0))
            .then(|| zero((from, low), (to, high), to.abs(), |value| touch(value).ok_or(())).ok())?
    }

    /// Right before a resonance there is no next point that could tell.
    fn resonance_ahead(&self, point: &BranchPoint) -> Option<(f64, End)> {
        let near = (NEAR * self.range()).copysign(point.heading());
        let (value, resonance) = self.branch.resonance_within(point, point.value() + near)?;
        Some((value, End::Resonance(resonance)))
    }

    /// The end of the range that the branch is heading for.
    fn limit(&self, point: &BranchPoint) -> f64 {
        if point.heading() > 0.0 { self.to } else { self.from }
    }

    /// The next point, at most at the limit; whether it is the last.
    fn advance(&mut self, point: &BranchPoint, length: f64) -> Result<(BranchPoint, bool), BranchError> {
        // Round a fold the way leads to the other end of the range.
        let beyond = |heading: f64, value: f64| if heading > 0.0 { value >= self.to } else { value <= self.from };
        // The range is one unit of the parameter.
        let reached = point.value() + length * point.heading() * self.range();
        let next = if beyond(point.heading(), reached) { None } else { Some(self.branch.step(point, length)?) };
        match next.filter(|next| !beyond(point.heading(), next.value()) && !beyond(next.heading(), next.value())) {
            Some(next) => Ok((next, false)),
            None => Ok((self.branch.at(point, self.limit(point))?, true)),
        }
    }

    /// Whether the branch has come back to where it began: `start` lies on the way from `point` to `next`.
    fn passes(&mut self, start: &BranchPoint, point: &BranchPoint, next: &BranchPoint) -> bool {
        let (to_start, to_next) = (self.branch.length_between(point, start), self.branch.length_between(point, next));
        if !(0.0 < to_start && to_start <= to_next) {
            return false;
        }
        let there = self.branch.step(point, to_start);
        there.is_ok_and(|there| {
            self.branch.distance(&there, start) <= SETTLED && there.heading() * start.heading() >= 0.0
        })
    }

    /// The branch turns back between two points: at the end of asymmetric orbits on the symmetric one, or at a fold, round which the whole
    /// branch goes on to `next`.
    fn round(&mut self, (point, seen): (&BranchPoint, &Observation), next: &BranchPoint) -> Result<Round, LocateError> {
        if let Some((value, end)) = self.mirrored(point, next)? {
            return Ok(Round::Ends(value, end));
        }
        let Some((fold, evidence)) = self.fold(point, next)? else {
            return Ok(Round::Ends(next.value(), End::Lost(BranchError::NoConvergence)));
        };
        let (watched, whole) = (self.events.clone(), self.whole);
        // A pitchfork this near to it is not told from it: the determinant of the equations vanishes at the fold itself.
        let told = |event: &Event| !whole && shift_of(*event, point.orbit()).is_some();
        self.events.retain(|event| *event != Event::Pitchfork || told(event));
        let around = |follower: &mut Self| {
            let at_fold = follower.look(&fold)?;
            follower.all_between((point, seen), (&fold, &at_fold))?;
            if watched.contains(&Event::Fold) {
                follower.describe_fold(&fold, evidence)?;
            }
            if whole { follower.watch((&fold, &at_fold), next).map(drop) } else { Ok(()) }
        };
        let passed = around(self);
        self.events = watched;
        passed?;
        if whole {
            return Ok(Round::On(self.look(next)?));
        }
        Ok(Round::Ends(fold.value(), End::Fold { error: self.branch.parameter_error(&fold) }))
    }

    /// Where asymmetric orbits end on the symmetric one between two points and go on as their own mirror images: there the equations
    /// are singular in two directions, but among symmetric orbits in none.
    fn mirrored(&mut self, point: &BranchPoint, next: &BranchPoint) -> Result<Option<(f64, End)>, LocateError> {
        if next.determinant() * point.determinant() <= 0.0 {
            return Ok(None);
        }
        let found = if self.watches(Event::Pitchfork) { self.on_symmetric(point, next)? } else { None };
        let value = found.as_ref().map_or_else(|| self.turning(point, next), |found| found.value);
        self.passed.extend(found.map(Passed::Event));
        Ok(Some((value, End::Pitchfork)))
    }

    /// The value at which the branch turns back between two points. Right there the equations may fail: the orbit that came nearest
    /// tells it to the square of its distance.
    fn turning(&mut self, point: &BranchPoint, next: &BranchPoint) -> f64 {
        let length = self.branch.length_between(point, next);
        let mut nearest = (next.heading().abs(), next.value());
        let heading = |s: f64| -> Result<f64, BranchError> {
            let there = self.branch.step(point, s)?;
            if there.heading().abs() < nearest.0 {
                nearest = (there.heading().abs(), there.value());
            }
            Ok(there.heading())
        };
        let _ = zero((0.0, point.heading()), (length, next.heading()), length, heading);
        nearest.1
    }

    fn describe_fold(&mut self, fold: &BranchPoint, evidence: Evidence) -> Result<(), LocateError> {
        let error = self.branch.parameter_error(fold) + 2.0 * f64::EPSILON * fold.value().abs();
        let found = self.describe(Event::Fold, fold, error, evidence)?;
        self.passed.push(Passed::Event(found));
        Ok(())
    }

    /// The fold between two points, where the heading vanishes, and from there by its equations; its multiplier +1. `None` where
    /// there is no such multiplier.
    fn fold(
        &mut self,
        point: &BranchPoint,
        next: &BranchPoint,
    ) -> Result<Option<(BranchPoint, Evidence)>, LocateError> {
        let length = self.branch.length_between(point, next);
        let branch = &mut self.branch;
        let heading = |s: f64| branch.step(point, s).map(|there| there.heading());
        let s = zero((0.0, point.heading()), (length, next.heading()), length, heading)?;
        let turned = self.branch.step(point, s)?;
        let settled = self.branch.fold(&turned).ok();
        let same = |fold: &BranchPoint| self.branch.length_between(&turned, fold).abs() <= SETTLED;
        let fold = settled.filter(same).unwrap_or(turned);
        let goal = Complex::new(1.0, 0.0);
        let evidence = self.nearest_to(&fold, goal)?;
        Ok(self.is_at(evidence, goal, &fold)?.then_some((fold, evidence)))
    }

    /// The pitchfork on the symmetric branch that asymmetric orbits meet between two points.
    fn on_symmetric(&mut self, point: &BranchPoint, next: &BranchPoint) -> Result<Option<Located>, LocateError> {
        let orbit = next.orbit();
        let mut found = Found::default();
        self.finder.find(orbit.model(), orbit.family(), &mut found)?;
        let impulse = |orbit: &Orbit| orbit.impacts().first().map_or(0.0, |impact| impact.impulse);
        let half = 0.5 * orbit.period();
        let symmetric = found.orbits.iter().filter(|one| one.phi().is_some_and(|phi| (phi - half).abs() < 1e-9 * half));
        let unlike = |one: &Orbit| (impulse(one) - impulse(orbit)).abs();
        let Some(nearest) = symmetric.min_by(|a, b| unlike(a).total_cmp(&unlike(b))) else { return Ok(None) };
        // The parabola's vertex lies between the two points, and the parameter has no steeper way to it than from either.
        let steepest = point.heading().abs() + next.heading().abs();
        let scale = self.range().max(next.value().abs());
        let reach = self.branch.length_between(point, next).abs() * steepest * scale + 1e-6 * self.range();
        let reach = reach.max(4.0 * LEAST * next.value().abs());
        let (from, to) = ((next.value() - reach).max(self.from), (next.value() + reach).min(self.to));
        let search = Search { event: Event::Pitchfork, free: self.free, from, to };
        let mut answer = locate_until(nearest, &search, self.stop())?;
        self.others += answer.evaluations;
        self.spectra += answer.spectra;
        answer.located.truncate(1);
        Ok(answer.located.pop())
    }
}
