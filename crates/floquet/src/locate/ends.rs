//! Where a branch of orbits ends on simpler ones: on those that repeat or mirror themselves, or on those without two impacts that come together
//! and vanish.

use nalgebra::Complex;
use vibrochain_breather::system::System;
use vibrochain_breather::{
    Branch, BranchError, BranchPoint, ContactOrbit, Continuation, Departure, Family, ModelFamily,
};
use vibrochain_lattice::{Resonance, Stop};

use super::answer::{End, Event, EventSide, Evidence, Located};
use crate::bracket::zero;
use crate::events::{AtEvent, Solved, Test, Watcher, bounded, resonance_beside, solve};
use crate::verdict::Tolerance;
use vibrochain_breather::time_between;

/// Two impacts of one contact this near to each other, as a part of the period, and this slow, against what moves there, are about to vanish: the
/// flight between them is as short as they are slow.
const MERGING: f64 = 1e-3;

/// How far from the last orbit the simpler one may be, in units.
const REACH: f64 = 0.1;

/// The orbit, or the resonance, at which a branch ends is no farther than this from where it turned back, as a part of the range.
const NEAR: f64 = 1e-3;

/// A branch, and the point of it to begin at.
pub(crate) type Begun = (Branch, BranchPoint);

/// How a branch may end, by an event of other orbits there.
pub(crate) struct Ended {
    pub(crate) value: f64,
    pub(crate) end: End,
    pub(crate) event: Option<Located>,
}

/// What stands beside branches of a structure's orbits, and at their ends.
pub(crate) struct BranchEnds {
    pub(super) family: ModelFamily,
    /// What its orbits are called while their impacts are those of it.
    pub(super) name: Family,
    /// The length of the range.
    pub(super) range: f64,
    pub(super) tolerance: Tolerance,
    pub(super) stop: Stop,
    /// Who looks at orbits beside the branch.
    pub(super) others: Watcher,
}

impl BranchEnds {
    /// The resonance right ahead of a point, behind which there is none that could tell.
    pub(super) fn resonance_ahead(&self, point: &BranchPoint) -> Option<(f64, Resonance)> {
        let resonance = resonance_beside(point.orbit())?;
        Some((self.resonant(point, &resonance).unwrap_or(point.value()), resonance))
    }

    /// Simpler orbits right ahead, where the branch is lost; the `first` orbit was so strong. All impulses vanish there, or it is the grazing at
    /// which two impacts next to each other vanish together. On both sides of it, and of one of the two alone, there are orbits;
    /// of both there are none beyond.
    pub(super) fn simpler_ahead(&mut self, point: &BranchPoint, first: f64) -> Option<Ended> {
        if let Some(ended) = self.vanishing_ahead(point, first) {
            return Some(ended);
        }
        let (orbit, impacts) = (point.orbit(), point.orbit().impacts());
        let (period, slow, last) = (orbit.period(), MERGING * orbit.speed(), impacts.len() - 1);
        let merge = |i: usize, j: usize| {
            let (one, other) = (&impacts[i], &impacts[j]);
            (one.site, one.barrier) == (other.site, other.barrier)
                && time_between(one.time, other.time, period) <= MERGING * period
                && one.velocity_before.abs().max(other.velocity_before.abs()) <= slow
        };
        let pair = (0..last).map(|i| (i, i + 1)).chain((last > 1).then_some((0, last)));
        let (kept, lost) = pair.into_iter().find(|(i, j)| merge(*i, *j))?;
        let simpler = orbit.without_impact(lost).ok()?;
        let solved = self.solved(&simpler, Test::Velocity(kept), point.value())?;
        // It lies ahead.
        if (solved.value - point.value()) * point.heading() < 0.0 {
            return None;
        }
        if impacts.len() == 2
            && let Some(value) = self.touch_beside(orbit, solved.value)
        {
            return Some(Ended { value, end: End::ImpulsesVanish, event: None });
        }
        let end = if impacts.len() == 2 { End::ImpulsesVanish } else { End::Grazing };
        let event = self.told(Event::Grazing, Evidence::Impact(kept), solved, point)?;
        Some(Ended { value: event.value, end, event: Some(event) })
    }

    /// The event of simpler orbits at which this branch, which turns back there, leaves them.
    pub(super) fn meeting(&mut self, [point, next]: [&BranchPoint; 2], value: f64) -> Option<Located> {
        let nearest = if point.heading().abs() < next.heading().abs() { point } else { next };
        let met = self.evened(nearest);
        met.filter(|met| (met.value - value).abs() <= NEAR * self.range)
    }

    /// The branch that leaves an orbit at a value, and the point where it does.
    pub(super) fn leaving(
        &self,
        (orbit, value): (&ContactOrbit, f64),
        departure: &Departure,
    ) -> Result<Begun, BranchError> {
        let place = (value, value.abs().max(self.range));
        Branch::leaving(orbit, departure, self.family.clone(), place, &self.stop)
    }

    /// The value at which a mode is in resonance, next to a branch's point.
    fn resonant(&self, point: &BranchPoint, resonance: &Resonance) -> Option<f64> {
        let periods = f64::from(point.orbit().force_periods());
        let family = point.orbit().model().like(&self.family, &[point.value()]);
        let off = |value: f64| {
            let model = family(&[value]).ok()?;
            let rate = model.structure().modes().get(resonance.mode)?.rates()[0];
            Some((-(resonance.harmonic as f64)).mul_add(model.omega() / periods, rate.im))
        };
        let scale = point.value().abs().max(self.range);
        let ends = [-NEAR, NEAR].map(|by| point.value() + by * scale);
        let [low, high] = [off(ends[0])?, off(ends[1])?];
        let differ = (low > 0.0) != (high > 0.0);
        differ.then(|| zero((ends[0], low), (ends[1], high), scale, |value| off(value).ok_or(())).ok())?
    }

    fn evened(&mut self, point: &BranchPoint) -> Option<Located> {
        let orbit = point.orbit();
        let simpler = orbit.evened()?.ok()?;
        let doubled = simpler.period() < 0.75 * orbit.period();
        let (test, event, goal) =
            if doubled { (Test::MinusOne, Event::PeriodDoubling, -1.0) } else { (Test::One, Event::Pitchfork, 1.0) };
        let solved = self.solved(&simpler, test, point.value())?;
        let evidence = self.others.multiplier_at(&solved.at.orbit, Complex::new(goal, 0.0), self.tolerance)?;
        self.told(event, evidence, solved, point)
    }

    fn solved(&self, simpler: &ContactOrbit, test: Test, value: f64) -> Option<Solved> {
        let through = || -> Result<Solved, BranchError> {
            let family = self.family.clone();
            let mut base = Continuation::through(simpler, family, &[value], &[self.range], &self.stop)?;
            let z = base.origin()?;
            solve(&base, test, (&z, None), REACH)
        };
        through().ok()
    }

    fn told(&mut self, event: Event, evidence: Evidence, solved: Solved, point: &BranchPoint) -> Option<Located> {
        let physical = |orbit: &ContactOrbit| orbit.first_obstruction().ok().map(|told| told.is_physical());
        let beside = self.others.verdict(point.orbit(), self.tolerance).into_iter();
        let side = |stability| EventSide { value: point.value(), stability, physical: physical(point.orbit()) };
        let Solved { at: AtEvent { orbit, .. }, value, error, .. } = solved;
        let branching = self.branch_off(event, (&orbit, value));
        Some(Located {
            event,
            value,
            error,
            physical: physical(&orbit),
            evidence: evidence.begun_with(orbit.first_of(self.name), &orbit),
            orbit: bounded(&orbit).into_orbit(self.name).ok()?,
            sides: beside.map(side).collect(),
            branching,
            evaluations: 0,
        })
    }
}
