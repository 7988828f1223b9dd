//! A branch of orbits of a structure, followed both ways as one number of it varies, with the events on it, and the branches that leave it.

use vibrochain_breather::{BranchError, StructureBranch, StructureBranchPoint, StructureFamily, StructureOrbit};
use vibrochain_lattice::Stop;

use super::ends::OfStructure;
use super::watcher::OfStructures;
use crate::locate::follower::{Follower, Stretch};
use crate::locate::{Diagram, Event, LocateError, Located, Tracing, both_ways, grown};
use crate::verdict::Tolerance;

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
/// doublings, where symmetry is lost, and at grazings.
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
    let StructureCourse { from, to, .. } = *course;
    if !(from <= value && value <= to && from < to) {
        let message =
            format!("{value} is not in a range from {from} to {to}: give one with from < to around the start");
        return Err(BranchError::Model(message).into());
    }
    let tracing = StructureTracing { family, course, stop };
    let mut branch = tracing.branch(orbit, value)?;
    let point = branch.start()?;
    let own = both_ways(tracing.follower(branch), point)?;
    let diagram = grown(&tracing, own, course.generations)?;
    // On the way a failure may be an end.
    stop.heard()?;
    Ok(diagram)
}

/// The branches of a structure's orbits.
struct StructureTracing<'a> {
    family: &'a StructureFamily,
    course: &'a StructureCourse,
    stop: &'a Stop,
}

impl StructureTracing<'_> {
    fn range(&self) -> f64 {
        self.course.to - self.course.from
    }

    fn branch(&self, orbit: &StructureOrbit, value: f64) -> Result<StructureBranch, BranchError> {
        StructureBranch::of_structure(orbit, self.family.clone(), value, self.range(), self.stop)
    }
}

impl Tracing for StructureTracing<'_> {
    type Ends = OfStructure;

    fn follower(&self, branch: StructureBranch) -> Follower<OfStructure> {
        let StructureCourse { from, to, ref events, tolerance, .. } = *self.course;
        let stretch = Stretch { from, to, events: events.clone(), tolerance, whole: true };
        Follower::new(branch, OfStructures::default(), self.ends(), stretch, self.stop)
    }

    /// Right where symmetry is lost there are two directions; beside it, amid the two orbits that branch off, the symmetric one has one.
    fn through(
        &self,
        located: &Located<StructureOrbit>,
    ) -> Result<(StructureBranch, StructureBranchPoint), BranchError> {
        let amid = located.branching.as_ref().and_then(|pair| {
            let symmetric = pair.orbits.first()?.orbit.evened()?;
            Some((symmetric.map_err(BranchError::from), pair.value))
        });
        let (symmetric, value) = amid.ok_or(BranchError::NoConvergence)?;
        let mut branch = self.branch(&symmetric?, value)?;
        let point = branch.start()?;
        Ok((branch, point))
    }

    fn ends(&self) -> OfStructure {
        let (family, others) = (self.family.clone(), OfStructures::default());
        let (range, tolerance, stop) = (self.range(), self.course.tolerance, self.stop.clone());
        OfStructure { family, range, tolerance, stop, others }
    }
}
