//! Where a branch of orbits ends on simpler ones: on those that repeat or mirror themselves, or on those without two impacts that come together
//! and vanish.

use nalgebra::Complex;
use vibrochain_breather::system::System;
use vibrochain_breather::{
    BranchError, Departure, StructureBranch, StructureBranchPoint, StructureContinuation, StructureFamily,
    StructureOrbit,
};
use vibrochain_lattice::{Resonance, Stop};

use super::watcher::OfStructures;
use crate::bracket::zero;
use crate::events::{EventOrbit, Solved, Test, Watcher, solve};
use crate::locate::branch_off::branch_off;
use crate::locate::follower::confirm::{AWAY, multiplier_at};
use crate::locate::follower::{Ended, Ends};
use crate::locate::{End, Event, EventSide, Evidence, LocateError, Located};
use crate::verdict::Tolerance;
use vibrochain_breather::time_between;

/// Two impacts of one contact this near to each other, as a part of the period, and this slow, against what moves there, are about to vanish: the
/// flight between them is as short as they are slow.
const MERGING: f64 = 1e-3;

/// How far from the last orbit the simpler one may be, in units.
const REACH: f64 = 0.1;

/// The orbit, or the resonance, at which a branch ends is no farther than this from where it turned back, as a part of the range.
const NEAR: f64 = 1e-3;

/// Branches of a structure's orbits.
pub(super) struct OfStructure {
    pub(super) family: StructureFamily,
    /// The length of the range.
    pub(super) range: f64,
    pub(super) tolerance: Tolerance,
    pub(super) stop: Stop,
    /// Who looks at orbits beside the branch.
    pub(super) others: OfStructures,
}

impl Ends for OfStructure {
    type Watcher = OfStructures;
    type System = StructureContinuation;
    const VANISHED: f64 = 1e-9;

    fn resonance_between(
        branch: &StructureBranch,
        from: &StructureBranchPoint,
        to: &StructureBranchPoint,
    ) -> Option<(f64, Resonance)> {
        branch.resonance_between(from, to)
    }

    fn resonance_ahead(&self, _: &StructureBranch, point: &StructureBranchPoint) -> Option<(f64, Resonance)> {
        let resonance = point.orbit().resonance()?;
        Some((self.resonant(point, &resonance).unwrap_or(point.value()), resonance))
    }

    /// The grazing at which two impacts next to each other vanish together. On both sides of it, and of one of the two alone, there are orbits;
    /// of both there are none beyond.
    fn simpler_ahead(&mut self, point: &StructureBranchPoint, first: f64) -> Option<Ended<StructureOrbit>> {
        if let Some(ended) = self.vanishing_ahead(point, first) {
            return Some(ended);
        }
        let (orbit, impacts) = (point.orbit(), point.orbit().impacts());
        let (period, slow, last) = (orbit.period(), MERGING * orbit.speed(), impacts.len() - 1);
        let merge = |i: usize, j: usize| {
            let (one, other) = (&impacts[i], &impacts[j]);
            (one.contact, one.barrier) == (other.contact, other.barrier)
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
        let end = if impacts.len() == 2 { End::ImpulsesVanish } else { End::Grazing };
        let event = self.told(Event::Grazing, Evidence::Impact(kept), solved, point);
        Some(Ended { value: event.value, end, event: Some(event) })
    }

    /// The event of simpler orbits at which this branch, which turns back there, leaves them.
    fn meeting(
        &mut self,
        [point, next]: [&StructureBranchPoint; 2],
        _length: f64,
        value: f64,
    ) -> Result<Option<Located<StructureOrbit>>, LocateError> {
        let nearest = if point.heading().abs() < next.heading().abs() { point } else { next };
        let met = self.evened(nearest);
        Ok(met.filter(|met| (met.value - value).abs() <= NEAR * self.range))
    }

    fn leaving(
        &self,
        (orbit, value): (&StructureOrbit, f64),
        departure: &Departure,
    ) -> Result<(StructureBranch, StructureBranchPoint), BranchError> {
        let place = (value, value.abs().max(self.range));
        StructureBranch::leaving_structure(orbit, departure, self.family.clone(), place, &self.stop)
    }

    fn others(&mut self) -> &mut OfStructures {
        &mut self.others
    }
}

impl OfStructure {
    /// The value at which a mode is in resonance, next to a branch's point.
    fn resonant(&self, point: &StructureBranchPoint, resonance: &Resonance) -> Option<f64> {
        let periods = f64::from(point.orbit().force_periods());
        let off = |value: f64| {
            let model = (self.family)(&[value]).ok()?;
            let rate = model.structure().modes().get(resonance.mode)?.rates()[0];
            Some((-(resonance.harmonic as f64)).mul_add(model.omega() / periods, rate.im))
        };
        let scale = point.value().abs().max(self.range);
        let ends = [-NEAR, NEAR].map(|by| point.value() + by * scale);
        let [low, high] = [off(ends[0])?, off(ends[1])?];
        let differ = (low > 0.0) != (high > 0.0);
        differ.then(|| zero((ends[0], low), (ends[1], high), scale, |value| off(value).ok_or(())).ok())?
    }

    fn evened(&mut self, point: &StructureBranchPoint) -> Option<Located<StructureOrbit>> {
        let orbit = point.orbit();
        let simpler = orbit.evened()?.ok()?;
        let doubled = simpler.period() < 0.75 * orbit.period();
        let (test, event, goal) =
            if doubled { (Test::MinusOne, Event::PeriodDoubling, -1.0) } else { (Test::One, Event::Pitchfork, 1.0) };
        let solved = self.solved(&simpler, test, point.value())?;
        let evidence = multiplier_at(&mut self.others, &solved.at.orbit, Complex::new(goal, 0.0), self.tolerance)?;
        Some(self.told(event, evidence, solved, point))
    }

    fn solved(&self, simpler: &StructureOrbit, test: Test, value: f64) -> Option<Solved<StructureOrbit>> {
        let through = || -> Result<Solved<StructureOrbit>, BranchError> {
            let family = self.family.clone();
            let mut base = StructureContinuation::through(simpler, family, &[value], &[self.range], &self.stop)?;
            let z = base.origin()?;
            solve(&base, test, (&z, None), REACH)
        };
        through().ok()
    }

    fn told(
        &mut self,
        event: Event,
        evidence: Evidence,
        solved: Solved<StructureOrbit>,
        point: &StructureBranchPoint,
    ) -> Located<StructureOrbit> {
        let physical = |orbit: &StructureOrbit| orbit.first_obstruction().ok().map(|told| told.is_physical());
        let beside = self.others.verdict(point.orbit(), self.tolerance).into_iter();
        let side = |stability| EventSide { value: point.value(), stability, physical: physical(point.orbit()) };
        let distance = AWAY * solved.value.abs().max(1e-2 * self.range);
        let branching = branch_off(self, event, (&solved.at.orbit, solved.value), distance);
        Located {
            event,
            value: solved.value,
            error: solved.error,
            physical: physical(&solved.at.orbit),
            orbit: solved.at.orbit,
            evidence,
            sides: beside.map(side).collect(),
            branching,
            evaluations: 0,
        }
    }
}
