//! Along the branch, both ways: steps, folds, and what ends the way.

use nalgebra::Complex;
use vibrochain_breather::{Branch, BranchError, BranchPoint, BreatherError, Finder, Found, Orbit};
use vibrochain_lattice::Parameter;

use super::answer::{Answer, End, Event, LocateError, Located, Search};
use super::follower::{Follower, LONGEST, Observation, shift_of};
use crate::analyser::Analyser;
use crate::bracket::zero;

/// The shortest step: where even this one fails, the branch is lost.
const SHORTEST: f64 = 1e-9;

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
    let Search { free, from, to, .. } = *search;
    let start = orbit.model().get(free);
    if !(from <= start && start <= to && from < to) {
        return Err(LocateError::Range { free, start, from, to });
    }
    for end in [from, to] {
        orbit.model().with(free, end).map_err(BreatherError::from)?;
    }
    if orbit.model().is_conservative() && matches!(free, Parameter::Amplitude | Parameter::Restitution) {
        return Err(LocateError::NoForce { free });
    }
    let mut follower = Follower {
        branch: Branch::through(orbit, free, to - from)?,
        analyser: Analyser::default(),
        finder: Finder::new(orbit.model().chain().sites()),
        search: *search,
        unresolved: Vec::new(),
        others: 0,
        spectra: 0,
    };
    let point = follower.branch.start()?;
    let (up, down) = if point.heading() < 0.0 { (point.reversed(), point) } else { (point.clone(), point.reversed()) };
    let mut located = Vec::new();
    let mut ends = Vec::new();
    for point in [down, up] {
        let (value, end) = follower.follow(point, &mut located)?;
        ends.push((value, end));
    }
    located.sort_by(|a, b| (a.value - start).abs().total_cmp(&(b.value - start).abs()));
    // A start right on the event is found from both sides.
    located.dedup_by(|b, a| (a.value - b.value).abs() <= a.error + b.error);
    let lost = || (start, End::Lost(BranchError::NoConvergence));
    let mut ends = ends.into_iter();
    let ends = [ends.next().unwrap_or_else(lost), ends.next().unwrap_or_else(lost)];
    let (evaluations, spectra) = (follower.evaluations(), follower.spectra);
    Ok(Answer { located, unresolved: follower.unresolved, ends, evaluations, spectra })
}

impl Follower {
    pub(super) fn evaluations(&self) -> usize {
        self.branch.evaluations() + self.others
    }

    /// Follows one direction to the end of the way.
    fn follow(&mut self, start: BranchPoint, located: &mut Vec<Located>) -> Result<(f64, End), LocateError> {
        let upwards = start.heading() > 0.0;
        let limit = if upwards { self.search.to } else { self.search.from };
        let beyond = |value: f64| if upwards { value >= limit } else { value <= limit };
        let mut point = start;
        if point.value() == limit {
            return Ok((limit, End::Range));
        }
        let mut seen = self.look(&point)?;
        let mut length = 0.25 * LONGEST;
        let first = strength(point.orbit());
        for _ in 0..MOST_STEPS {
            let (next, last) = match self.advance(&point, length, limit, beyond) {
                Ok(next) => next,
                Err(error) => {
                    length *= 0.25;
                    if length < CRAWL
                        && let Some(end) = self.resonance_ahead(&point)
                    {
                        return Ok(end);
                    }
                    if length < SHORTEST {
                        return Ok(self.given_up(&point, first, End::Lost(error)));
                    }
                    continue;
                }
            };
            if let Some((value, resonance)) = self.branch.resonance_within(point.value(), next.value()) {
                return Ok((value, End::Resonance(resonance)));
            }
            if next.heading() * point.heading() <= 0.0 {
                let turned = self.turn(&point, &seen, &next, located);
                return turned.or_else(|error| self.stopped(&point, first, error));
            }
            let watched = self.look(&next).and_then(|next_seen| {
                self.all_between((&point, &seen), (&next, &next_seen), located)?;
                Ok(next_seen)
            });
            let next_seen = match watched {
                Ok(next_seen) => next_seen,
                Err(error) => return self.stopped(&point, first, error),
            };
            (point, seen) = (next, next_seen);
            if last {
                return Ok((limit, End::Range));
            }
            let growth = strength(point.orbit()) / first;
            if growth > UNBOUNDED {
                return Ok((point.value(), End::Unbounded));
            }
            // Impulses that grow without bound set a longer scale, as long as the parameter does not move far.
            let longest = LONGEST * growth.clamp(1.0, 1.0 / point.heading().abs());
            length = (1.5 * length).min(longest);
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
        let (orbit, free) = (point.orbit(), self.search.free);
        let (impact, psi) = (orbit.impacts().first()?, orbit.psi()?);
        if strength(orbit) > FAINT * first.max(orbit.model().omega()) {
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
        let (from, Search { from: least, to: most, .. }) = (point.value(), self.search);
        let to = (from + (NEAR * (most - least)).copysign(point.heading())).clamp(least, most);
        let (low, high) = (touch(from)?, touch(to)?);
        ((low > 0.0) != (high > 0.0))
            .then(|| zero((from, low), (to, high), to.abs(), |value| touch(value).ok_or(())).ok())?
    }

    /// Right before a resonance there is no next point that could tell.
    fn resonance_ahead(&self, point: &BranchPoint) -> Option<(f64, End)> {
        let near = (NEAR * (self.search.to - self.search.from)).copysign(point.heading());
        let (value, resonance) = self.branch.resonance_within(point.value(), point.value() + near)?;
        Some((value, End::Resonance(resonance)))
    }

    /// The next point, at most at the limit; whether it is the last.
    fn advance(
        &mut self,
        point: &BranchPoint,
        length: f64,
        limit: f64,
        beyond: impl Fn(f64) -> bool,
    ) -> Result<(BranchPoint, bool), BranchError> {
        // The range is one unit of the parameter.
        let reached = point.value() + length * point.heading() * (self.search.to - self.search.from);
        if beyond(reached) {
            return Ok((self.branch.at(point, limit)?, true));
        }
        let next = self.branch.step(point, length)?;
        if beyond(next.value()) {
            return Ok((self.branch.at(point, limit)?, true));
        }
        Ok((next, false))
    }

    /// The branch turns back between two points: a fold, or the end of asymmetric orbits on the symmetric one.
    fn turn(
        &mut self,
        point: &BranchPoint,
        seen: &Observation,
        next: &BranchPoint,
        located: &mut Vec<Located>,
    ) -> Result<(f64, End), LocateError> {
        if next.determinant() * point.determinant() > 0.0 {
            // Asymmetric orbits end on the symmetric one and go on as their own mirror images: there the equations are
            // singular in two directions, but among symmetric orbits in none.
            let found = if self.search.event == Event::Pitchfork { self.on_symmetric(point, next)? } else { None };
            let value = found.as_ref().map_or(next.value(), |found| found.value);
            located.extend(found);
            return Ok((value, End::Pitchfork));
        }
        let fold = self.fold(point, next)?;
        let goal = Complex::new(1.0, 0.0);
        let sign = self.nearest_to(&fold, goal)?;
        if !self.is_at(sign, goal, &fold)? {
            return Ok((fold.value(), End::Lost(BranchError::NoConvergence)));
        }
        if self.search.event == Event::Fold {
            let error = fold.parameter_error() + 2.0 * f64::EPSILON * fold.value().abs();
            let found = self.describe(&fold, error, sign)?;
            located.push(found);
        } else if self.search.event != Event::Pitchfork || shift_of(Event::Pitchfork, point.orbit()).is_some() {
            // An event may lie before it; not a pitchfork of the equations, whose determinant vanishes at the fold itself.
            let at_fold = self.look(&fold)?;
            self.all_between((point, seen), (&fold, &at_fold), located)?;
        }
        Ok((fold.value(), End::Fold { error: fold.parameter_error() }))
    }

    /// The fold between two points: where the heading vanishes, and from there by its equations.
    fn fold(&mut self, point: &BranchPoint, next: &BranchPoint) -> Result<BranchPoint, LocateError> {
        let length = self.branch.length_between(point, next);
        let branch = &mut self.branch;
        let heading = |s: f64| branch.step(point, s).map(|there| there.heading());
        let s = zero((0.0, point.heading()), (length, next.heading()), length, heading)?;
        let turned = self.branch.step(point, s)?;
        let settled = self.branch.fold(&turned).ok();
        let same = |fold: &BranchPoint| self.branch.length_between(&turned, fold).abs() <= SETTLED;
        Ok(settled.filter(same).unwrap_or(turned))
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
        let reach = 2.0 * (next.value() - point.value()).abs() + 1e-6 * (self.search.to - self.search.from);
        let (from, to) = (next.value() - reach, next.value() + reach);
        let search = Search { from: from.max(self.search.from), to: to.min(self.search.to), ..self.search };
        let mut answer = locate(nearest, &search)?;
        self.others += answer.evaluations;
        self.spectra += answer.spectra;
        answer.located.truncate(1);
        Ok(answer.located.pop())
    }
}

/// The largest impulse.
fn strength(orbit: &Orbit) -> f64 {
    orbit.impacts().iter().map(|impact| impact.impulse.abs()).fold(f64::MIN_POSITIVE, f64::max)
}
