//! Events of a step: where a test function changes its sign Newton's method solves the orbit's equations together with it, and the step is halved
//! until the solution lies in it.

use nalgebra::Complex;
use vibrochain_breather::{Approach, BranchPoint, Pace};

use super::seen::{changes, corners, marks, touch_between, value};
use super::{At, Follower};
use crate::bracket::crossing;
use crate::events::{AtEvent, Solved, TOUCHES, Test, bounded, solve};
use crate::locate::answer::{Event, EventSide, Evidence, LocateError, Located};

type C = Complex<f64>;

/// How often a step is halved until Newton's method finds the event, or the fold, in it: down to 1/256 of the step.
pub(super) const HALVINGS: usize = 8;

/// Lengths as short as this are rounding.
pub(super) const LEAST_LENGTH: f64 = 1e-6;

/// A solution may be this part of a step outside it, where the event is at its end.
const SLACK: f64 = 1e-3;

/// An event whose error is more than this part of the step is not claimed: rounding may have made it.
const CLAIMED: f64 = 1e-2;

/// How far beside an event another one of its kind is looked for, as a part of the step; and so many at most.
pub(super) const BESIDE: f64 = 1e-4;
const MOST_IN_STEP: usize = 32;

/// An event, and its length along the step.
pub(super) type Found = (f64, Located);

/// A part of a step that is still to be looked at.
pub(super) struct Part<P> {
    pub(super) from: P,
    pub(super) to: P,
    /// How often the step was halved for it.
    pub(super) depth: u32,
}

impl<P> Part<P> {
    /// What it leaves on both sides of something in it, as far as there is a place beside that.
    pub(super) fn parted(self, [before, behind]: [Option<P>; 2]) -> impl Iterator<Item = Self> {
        let Self { from, to, depth } = self;
        let behind = behind.map(|from| Self { from, to, depth: depth + 1 });
        behind.into_iter().chain(before.map(|to| Self { from, to, depth: depth + 1 }))
    }
}

/// What the search for the event of a change of sign has found.
pub(super) enum Confirmed {
    /// An event, and what shows it.
    At(Box<Solved>, Evidence),
    /// A jump, as where an equation has a pole.
    Nothing,
    /// Rounding hides it.
    Hidden,
}

impl Follower {
    /// The events of all test functions of one value between two points.
    pub(super) fn zeros_between(
        &mut self,
        from: At<'_>,
        to: At<'_>,
        found: &mut Vec<Found>,
    ) -> Result<(), LocateError> {
        let turns = from.0.heading() * to.0.heading() <= 0.0;
        // An orbit that may begin at any time has another +1 where the rest of its equations says so.
        let one = match from.1.another_one {
            _ if turns => Test::Fold,
            Some(_) => Test::AnotherOne,
            None => Test::One,
        };
        let mut tests = vec![one, Test::MinusOne];
        tests.extend((0..from.1.velocities.len()).map(Test::Velocity));
        tests.extend((0..from.1.releases.len()).map(Test::Release));
        tests.retain(|test| changes(*test, from, to));
        tests.extend(touch_between(from, to));
        tests.retain(|test| self.watches(test.event(turns)));
        for test in tests {
            self.zeros_of(test, from, to, MOST_IN_STEP, found)?;
        }
        Ok(())
    }

    /// The events of one of them, which changes its sign between two points.
    fn zeros_of(
        &mut self,
        test: Test,
        from: At<'_>,
        to: At<'_>,
        most: usize,
        found: &mut Vec<Found>,
    ) -> Result<(), LocateError> {
        let (length, turns) = (self.branch.length_between(from.0, to.0), test == Test::Fold);
        let (solved, evidence) = match self.confirm(test, from, to, HALVINGS)? {
            Confirmed::At(solved, evidence) if turns || solved.error <= CLAIMED * length * self.range() => {
                (solved, evidence)
            }
            Confirmed::Nothing => return Ok(()),
            Confirmed::At(..) | Confirmed::Hidden => {
                self.hidden(from.0.value(), to.0.value());
                return Ok(());
            }
        };
        let along = self.length_to(from.0, &solved);
        if found
            .iter()
            .any(|(other, located)| located.event == test.event(false) && (other - along).abs() <= LEAST_LENGTH)
        {
            return Ok(());
        }
        let located = self.told(test.event(turns), (from.0, along), *solved, evidence)?;
        found.push((along, located));
        // Of three that are near each other it may be any.
        for (end, s) in [(from, along - BESIDE * length), (to, along + BESIDE * length)] {
            let outside = if s < along { s <= 0.0 } else { s >= length };
            if most == 0 || turns || outside {
                continue;
            }
            let Ok(beside) = self.branch.step(from.0, s) else { continue };
            let (Some(here), Some(there)) = (self.read(test, &beside), value(test, end)) else { continue };
            if (here > 0.0) != (there > 0.0) {
                let seen = self.look(&beside)?;
                let beside = (&beside, &seen);
                let (low, high) = if s < along { (end, beside) } else { (beside, end) };
                self.zeros_of(test, low, high, most - 1, found)?;
            }
        }
        Ok(())
    }

    pub(super) fn length_to(&mut self, from: &BranchPoint, solved: &Solved) -> f64 {
        self.branch.length_to(from, &solved.coordinates)
    }

    /// The event of a test function between two points where it changes its sign.
    pub(super) fn confirm(
        &mut self,
        test: Test,
        from: At<'_>,
        to: At<'_>,
        halvings: usize,
    ) -> Result<Confirmed, LocateError> {
        // The contact that is nearest to its barrier at one end may not be the one that touches first.
        let test = if matches!(test, Test::Touch(..)) { touch_between(from, to).unwrap_or(test) } else { test };
        let share = match (value(test, from), value(test, to)) {
            (Some(a), Some(b)) if a != b => (a / (a - b)).clamp(0.0, 1.0),
            _ => 0.5,
        };
        for mark in marks(test, [from, to]) {
            if let Some((solved, evidence)) = self.solved(test, (from.0, to.0), share, mark) {
                return Ok(Confirmed::At(Box::new(solved), evidence));
            }
        }
        if matches!(test, Test::Touch(..)) {
            for corner in corners([from, to]) {
                if let Some((solved, evidence)) = self.solved(corner, (from.0, to.0), share, None) {
                    return Ok(Confirmed::At(Box::new(solved), evidence));
                }
            }
        }
        self.stop.heard()?;
        let length = self.branch.length_between(from.0, to.0);
        if halvings == 0 {
            return Ok(self.bracketed(test, from.0, length));
        }
        let Ok(middle) = self.branch.step(from.0, 0.5 * length) else { return Ok(Confirmed::Hidden) };
        let seen = self.look(&middle)?;
        let middle = (&middle, &seen);
        let before =
            changes(test, from, middle) || matches!(test, Test::Touch(..)) && touch_between(from, middle).is_some();
        let (from, to) = if before { (from, middle) } else { (middle, to) };
        self.confirm(test, from, to, halvings - 1)
    }

    /// The solution in a step, from a guess at a share of it.
    pub(super) fn solved(
        &mut self,
        test: Test,
        (from, to): (&BranchPoint, &BranchPoint),
        share: f64,
        mark: Option<f64>,
    ) -> Option<(Solved, Evidence)> {
        let length = self.branch.length_between(from, to);
        let ends = from.coordinates().iter().zip(to.coordinates());
        let mut z: Vec<f64> = ends.map(|(a, b)| a + share * (b - a)).collect();
        if matches!(test, Test::One | Test::Circle)
            && let Ok(there) = self.branch.step(from, share * length)
        {
            // Symmetric orbits are told by their symmetry, which a chord loses; and of many pairs the nearest is found.
            z = there.coordinates().to_vec();
        }
        let reach = (2.0 * length).max(LEAST_LENGTH);
        let solved = solve(self.branch.system(), test, (&z, mark), reach).ok()?;
        let solved = self.beside_resonance(test, from, solved)?;
        let along = self.length_to(from, &solved);
        // A fixed length would let in a neighbour: events may be as near to each other as they like.
        let slack = LEAST_LENGTH.min(SLACK * length);
        let evidence = if (-slack..=length + slack).contains(&along) { self.evidence(test, &solved) } else { None };
        evidence.map(|evidence| (solved, evidence))
    }

    /// Where Newton's method cannot lead, as to a point where symmetric orbits lose their symmetry: the zero along the branch.
    fn bracketed(&mut self, test: Test, from: &BranchPoint, length: f64) -> Confirmed {
        if !matches!(test, Test::One | Test::MinusOne | Test::AnotherOne) {
            return Confirmed::Hidden;
        }
        let mut at = |s: f64| {
            let point = self.branch.step(from, s).ok()?;
            self.read(test, &point)
        };
        let (Some(first), Some(last)) = (at(0.0), at(length)) else { return Confirmed::Hidden };
        if (first > 0.0) == (last > 0.0) {
            return Confirmed::Hidden;
        }
        let Some((s, along)) = crossing([first, last], length, at) else { return Confirmed::Nothing };
        let Ok(point) = self.branch.step(from, s) else { return Confirmed::Hidden };
        let error = along * point.heading().abs() * self.range() + f64::EPSILON * point.value().abs();
        let at = AtEvent { orbit: point.orbit().clone(), mark: None, determinant: 0.0, fold_determinant: 0.0 };
        let solved = Solved { at, coordinates: point.coordinates().into(), value: point.value(), error };
        self.evidence(test, &solved).map_or(Confirmed::Nothing, |evidence| Confirmed::At(Box::new(solved), evidence))
    }

    /// The multiplier of an event, if it is where it should be; of a grazing that which touches, if nothing else is beyond a barrier.
    pub(super) fn evidence(&mut self, test: Test, solved: &Solved) -> Option<Evidence> {
        let orbit = &solved.at.orbit;
        let goal = match test {
            Test::Velocity(i) | Test::Release(i) => return Some(Evidence::Impact(i)),
            Test::Touch(site, barrier) | Test::Corner(site, barrier, _) => {
                let time = match test {
                    Test::Corner(.., impact) => orbit.hits().get(impact)?.time,
                    _ => solved.at.mark.unwrap_or(0.0).rem_euclid(1.0) * orbit.period(),
                };
                let room = TOUCHES * orbit.speed() / orbit.model().omega();
                self.watcher.admissibility(orbit).ok()?.margin.filter(|margin| *margin >= -room)?;
                return Some(Evidence::Touch(Approach { site, barrier, time }));
            }
            Test::Fold | Test::One | Test::AnotherOne => C::new(1.0, 0.0),
            Test::MinusOne => C::new(-1.0, 0.0),
            Test::Circle | Test::Collision => C::from_polar(1.0, solved.at.mark.unwrap_or(0.0)),
        };
        self.watcher.multiplier_at(orbit, goal, self.stretch.tolerance)
    }

    /// The event at a length along a step.
    pub(super) fn told(
        &mut self,
        event: Event,
        (from, along): (&BranchPoint, f64),
        solved: Solved,
        evidence: Evidence,
    ) -> Result<Located, LocateError> {
        let Solved { at: AtEvent { orbit, .. }, value, error, .. } = solved;
        let physical = self.watcher.admissibility(&orbit).ok().map(|told| told.is_physical());
        let mut sides: Vec<EventSide> = Vec::new();
        for side in [-1e-2, 1e-2] {
            // Along the curve: at a fold both sides lie on one side in the parameter.
            let Ok(point) = self.branch.step(from, along + side * Pace::LONGEST) else { continue };
            if let Ok(stability) = self.watcher.verdict(point.orbit(), self.stretch.tolerance) {
                let physical = self.watcher.admissibility(point.orbit()).ok().map(|told| told.is_physical());
                sides.push(EventSide { value: point.value(), stability, physical });
            }
        }
        sides.sort_by(|a, b| a.value.total_cmp(&b.value));
        let branching = self.ends.branch_off(event, (&orbit, value));
        let evaluations = self.evaluations();
        let name = self.ends.name;
        let evidence = evidence.begun_with(orbit.first_of(name), &orbit);
        let orbit = bounded(&orbit).into_orbit(name)?;
        Ok(Located { event, value, error, orbit, evidence, physical, sides, branching, evaluations })
    }
}
