//! Along a branch, one way: steps, folds, and what ends the way.

use vibrochain_breather::walk::{Stride, Walk, walk};
use vibrochain_breather::{BranchError, BranchPoint, ContactOrbit, Pace};

use super::confirm::{Confirmed, HALVINGS, LEAST_LENGTH};
use super::{At, Follower, Seen};
use crate::bracket::zero;
use crate::events::{FAINT, Test, UNBOUNDED, strongest};
use crate::locate::answer::{End, Event, LocateError};
use crate::locate::course::Station;
use crate::locate::ends::Ended;

/// Steps at most in one direction.
const MOST_STEPS: usize = 20_000;

/// A heading this small against the other end's is that of a place where the branch turns.
const STILL: f64 = 1e-2;

/// The value at which a way ends, and why.
type Way = (f64, End);

/// What became of a step.
enum Passage {
    /// It goes on; what is seen at its end.
    On(Box<Seen>),
    /// The branch ends.
    Ends(Way),
}

impl Follower {
    /// Follows one direction to the end of the way; what it passes is kept, but for the start.
    pub(crate) fn follow(&mut self, start: &BranchPoint, seen: Seen) -> Result<Way, LocateError> {
        if start.value() == self.limit(start) {
            return Ok((start.value(), End::Range));
        }
        let strength = strongest(start.orbit()).max(f64::MIN_POSITIVE);
        let why = End::Lost(BranchError::NoConvergence);
        let mut walker = Walker { follower: self, start, point: start.clone(), seen, strength, steps: 0, why };
        walk(&mut walker, 0.25 * Pace::LONGEST)
    }

    /// The end of a way that leads no farther: `otherwise`, unless simpler orbits stand right ahead.
    fn given_up(&mut self, point: &BranchPoint, first: f64, otherwise: End) -> Way {
        match self.ends.simpler_ahead(point, first) {
            Some(Ended { value, end, event }) => {
                self.passed.extend(event.filter(|one| self.watches(one.event)).map(Station::Event));
                (value, end)
            }
            None => (point.value(), otherwise),
        }
    }

    /// The end of the range that the branch is heading for.
    fn limit(&self, point: &BranchPoint) -> f64 {
        if point.heading() > 0.0 { self.stretch.to } else { self.stretch.from }
    }

    /// The next point, at most at the limit; whether it is the last.
    fn advance(&mut self, point: &BranchPoint, length: f64) -> Result<(BranchPoint, bool), BranchError> {
        let (from, to) = (self.stretch.from, self.stretch.to);
        // Round a fold the way leads to the other end of the range.
        let beyond = |heading: f64, value: f64| if heading > 0.0 { value >= to } else { value <= from };
        // The range is one unit of the parameter.
        let reached = point.value() + length * point.heading() * self.range();
        let next = if beyond(point.heading(), reached) { None } else { Some(self.branch.step(point, length)?) };
        match next.filter(|next| !beyond(point.heading(), next.value()) && !beyond(next.heading(), next.value())) {
            Some(next) => Ok((next, false)),
            None => Ok((self.branch.at(point, self.limit(point))?, true)),
        }
    }

    /// Whether the branch has come back to where it began: `start` lies on the way from `point` to `next`.
    fn closes(&mut self, start: &BranchPoint, point: &BranchPoint, next: &BranchPoint) -> bool {
        let (to_start, to_next) = (self.branch.length_between(point, start), self.branch.length_between(point, next));
        0.0 < to_start
            && to_start <= to_next
            && self.branch.step(point, to_start).is_ok_and(|there| {
                self.branch.distance(&there, start) <= LEAST_LENGTH && there.heading() * start.heading() >= 0.0
            })
    }

    /// A step with all that happens in it. Where the branch turns back it may end: on more symmetric orbits, or at a fold round which it is not
    /// followed.
    fn passage(&mut self, from: At<'_>, next: &BranchPoint) -> Result<Passage, LocateError> {
        let turns = from.0.heading() * next.heading() <= 0.0;
        if turns {
            // A point that happens to be where it turns tells by rounding alone: its neighbour beyond tells better.
            let half = 0.5 * self.branch.length_between(from.0, next);
            let still = |one: &BranchPoint, other: &BranchPoint| one.heading().abs() < STILL * other.heading().abs();
            let before = if still(from.0, next) { self.branch.step(from.0, -half).ok() } else { None };
            let behind = if still(next, from.0) { self.branch.step(next, half).ok() } else { None };
            if let Some(way) = self.mirrored(before.as_ref().unwrap_or(from.0), behind.as_ref().unwrap_or(next))? {
                return Ok(Passage::Ends(way));
            }
        }
        if !turns || self.stretch.whole {
            return Ok(Passage::On(self.watch(from, next)?.into()));
        }
        let length = self.branch.length_between(from.0, next);
        let seen = self.look_on(next, length)?;
        let Confirmed::At(fold, evidence) = self.confirm(Test::Fold, from, (next, &seen), HALVINGS)? else {
            return Ok(Passage::Ends((next.value(), End::Lost(BranchError::NoConvergence))));
        };
        let way = (fold.value, End::Fold { error: fold.error });
        let along = self.length_to(from.0, &fold);
        let middle = self.branch.step(from.0, 0.5 * length)?;
        let middle_seen = self.look_on(&middle, length)?;
        let [mut crossings, behind] = self.crossings([from, (&middle, &middle_seen), (next, &seen)], [true; 2])?;
        let half = self.branch.length_between(from.0, &middle);
        crossings.extend(behind.into_iter().map(|(at, located)| (half + at, located)));
        let before = self
            .all_between(from, (next, &seen), crossings)?
            .into_iter()
            .filter(|(at, one)| *at < along && one.event != Event::Fold);
        self.passed.extend(before.map(|(_, located)| Station::Event(located)));
        if self.watches(Event::Fold) {
            let fold = self.told(Event::Fold, (from.0, along), *fold, evidence)?;
            self.passed.push(Station::Event(fold));
        }
        Ok(Passage::Ends(way))
    }

    /// Where orbits come between two points to more symmetric ones and go on as their own images: there the equations are singular in two directions,
    /// so that the branch turns back without a change of their determinant's sign.
    fn mirrored(&mut self, point: &BranchPoint, next: &BranchPoint) -> Result<Option<Way>, LocateError> {
        if point.determinant() * next.determinant() <= 0.0 || !point.orbit().is_across(next.orbit()) {
            return Ok(None);
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
        let met = self.ends.meeting([point, next], nearest.1);
        self.stop.heard()?;
        let value = met.as_ref().map_or(nearest.1, |met| met.value);
        self.passed.extend(met.filter(|met| self.watches(met.event)).map(Station::Event));
        let end = if is_hit_again(point.orbit()) { End::PeriodDoubling } else { End::Pitchfork };
        Ok(Some((value, end)))
    }
}

/// One direction of the way.
struct Walker<'a> {
    follower: &'a mut Follower,
    start: &'a BranchPoint,
    /// The last point, and what is seen there.
    point: BranchPoint,
    seen: Seen,
    /// Of the strongest impact at the start.
    strength: f64,
    /// Made so far.
    steps: usize,
    /// Why the last step failed.
    why: End,
}

impl Walker<'_> {
    fn failed(&mut self, why: End) -> Stride<Way> {
        self.why = why;
        Stride::Failed
    }

    /// The end at a resonance right ahead.
    fn resonant(&self) -> Option<Way> {
        let ahead = self.follower.ends.resonance_ahead(&self.point);
        ahead.map(|(value, resonance)| (value, End::Resonance(self.point.orbit().model().by_wave(resonance))))
    }
}

impl Walk for Walker<'_> {
    type End = Way;
    type Error = LocateError;

    fn step(&mut self, length: f64) -> Result<Stride<Way>, LocateError> {
        self.follower.stop.heard()?;
        if self.steps == MOST_STEPS {
            return Ok(Stride::Ended(self.lost()?));
        }
        let (next, last) = match self.follower.advance(&self.point, length) {
            Ok(next) => next,
            Err(error) => {
                let resonant = if length < Pace::CRAWL { self.resonant() } else { None };
                return Ok(resonant.map_or_else(|| self.failed(End::Lost(error)), Stride::Ended));
            }
        };
        let follower = &mut *self.follower;
        if let Some((value, resonance)) = follower.branch.resonance_between(&self.point, &next) {
            return Ok(Stride::Ended((value, End::Resonance(resonance))));
        }
        let closed = follower.stretch.whole && self.steps > 0 && follower.closes(self.start, &self.point, &next);
        let next = if closed { self.start.clone() } else { next };
        let before = (follower.passed.len(), follower.unresolved.clone(), follower.untold);
        let failed = match follower.passage((&self.point, &self.seen), &next) {
            Ok(Passage::On(seen)) => {
                (self.point, self.seen) = (next, *seen);
                None
            }
            Ok(Passage::Ends(way)) => return Ok(Stride::Ended(way)),
            Err(LocateError::Branch(error)) => Some(End::Lost(error)),
            Err(LocateError::Floquet(error)) => Some(End::Unwatched(error)),
            Err(other) => return Err(other),
        };
        if let Some(failed) = failed {
            // A failure undoes its step, not what was found before.
            follower.passed.truncate(before.0);
            (follower.unresolved, follower.untold) = (before.1, before.2);
            return Ok(self.failed(failed));
        }
        let growth = strongest(self.point.orbit()) / self.strength;
        let end = match () {
            () if closed => End::Closed,
            () if last => End::Range,
            () if growth > UNBOUNDED => End::Unbounded,
            () if growth < FAINT => End::ImpulsesVanish,
            () => {
                self.steps += 1;
                self.why = End::Lost(BranchError::NoConvergence);
                // Impulses that grow without bound set a longer scale, as long as the parameter does not move far.
                let longest = Pace::LONGEST * growth.clamp(1.0, 1.0 / self.point.heading().abs());
                return Ok(Stride::Made { wanted: f64::INFINITY, longest });
            }
        };
        let here = self.point.value();
        let touch = || follower.ends.touch_beside(self.point.orbit(), here);
        let value = if end == End::ImpulsesVanish { touch().unwrap_or(here) } else { here };
        Ok(Stride::Ended((value, end)))
    }

    fn lost(&mut self) -> Result<Way, LocateError> {
        let resonant = if matches!(self.why, End::Lost(_)) { self.resonant() } else { None };
        Ok(resonant.unwrap_or_else(|| self.follower.given_up(&self.point, self.strength, self.why.clone())))
    }
}

/// The same point, heading to larger values.
pub(crate) fn upwards(point: BranchPoint) -> BranchPoint {
    if point.heading() < 0.0 { point.reversed() } else { point }
}

/// Whether the second half of an orbit hits the same places as its first, in the same order. Where its branch ends on more symmetric orbits, these then
/// repeat after half its period; where it does not, they are their own mirror images.
fn is_hit_again(orbit: &ContactOrbit) -> bool {
    let (one, other) = orbit.impacts().split_at(orbit.impacts().len() / 2);
    let mut pairs = one.iter().zip(other);
    one.len() == other.len() && pairs.all(|(a, b)| (a.site, a.barrier) == (b.site, b.barrier))
}
