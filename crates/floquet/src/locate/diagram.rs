//! The bifurcation diagram of an orbit in one parameter: its branch through all folds, every event on it, and the branches that
//! leave it.

use vibrochain_breather::{Branch, BranchPoint, Orbit};
use vibrochain_lattice::Stop;

use super::answer::{End, Event, LocateError};
use super::course::{Course, Diagram, DiagramPoint, FollowedBranch, Origin, Station};
use super::follow::check;
use super::follower::{Follower, Passed};
use super::switch::{departure, first_step};
use crate::verdict::Tolerance;

/// Branches at most, however many generations are asked for.
const MOST_BRANCHES: usize = 256;

/// The bifurcation diagram through an orbit: its branch is followed both ways, through folds, to whatever ends it; all events that the
/// course asks for are found in one pass; and so many generations of the branches that leave it are followed likewise.
///
/// # Errors
/// [`LocateError`]. What stops a branch on its way is its end, not an error.
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_floquet::{Course, Event, diagram};
/// use vibrochain_lattice::{Chain, Model, Parameter};
/// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.07, 0.8, 0.165, 0.25)?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let course = Course { from: 0.15, to: 0.17, ..Course::new(orbit, Parameter::Amplitude) };
/// let diagram = diagram(orbit, &course)?;
/// // Down through the period doubling to the fold, and back up on its other side.
/// let events: Vec<Event> = diagram.branches[0].events().map(|located| located.event).collect();
/// assert!(events.contains(&Event::Fold) && events.contains(&Event::PeriodDoubling));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn diagram(orbit: &Orbit, course: &Course) -> Result<Diagram, LocateError> {
    diagram_until(orbit, course, &Stop::default())
}

/// The same, until `stop` is raised, which is looked at before every orbit and every eigenvalue problem.
///
/// # Errors
/// As [`diagram`]; [`LocateError::Stopped`].
pub fn diagram_until(orbit: &Orbit, course: &Course, stop: &Stop) -> Result<Diagram, LocateError> {
    check(orbit, course.free, (course.from, course.to))?;
    let mut diagram =
        Diagram { branches: Vec::new(), dead_ends: Vec::new(), complete: true, evaluations: 0, spectra: 0 };
    let branch = Branch::through(orbit, course.free, course.to - course.from)?;
    let mut follower = course.follower(branch, stop);
    let point = follower.branch.start()?;
    if orbit.model().chain().sites() == 1 {
        follower.without_those_that_cannot_be(point.orbit())?;
    }
    diagram.take_both_ways(follower, course, (None, 0), point)?;
    let mut next = 0;
    while next < diagram.branches.len() {
        if diagram.branches[next].generation < course.generations {
            for station in 0..diagram.branches[next].stations.len() {
                if diagram.branches.len() >= MOST_BRANCHES {
                    diagram.complete = false;
                    return Ok(diagram);
                }
                diagram.switch(course, Origin { branch: next, station }, stop)?;
            }
        }
        next += 1;
    }
    // On the way a failure may be an end.
    stop.heard()?;
    Ok(diagram)
}

impl Course {
    fn follower(&self, branch: Branch, stop: &Stop) -> Follower {
        let mut follower = Follower::new(branch, (self.from, self.to), self.events.clone(), stop);
        follower.whole = true;
        follower
    }
}

impl Follower {
    /// An orbit without a multiplier that could move has no event that multipliers show.
    fn without_those_that_cannot_be(&mut self, orbit: &Orbit) -> Result<(), LocateError> {
        match self.spectrum(orbit) {
            Err(LocateError::NoMultiplier) => self.events.retain(|event| *event == Event::Grazing),
            Err(error) => return Err(error),
            Ok(_) => {}
        }
        Ok(())
    }

    fn described(&mut self, point: &BranchPoint, tolerance: Tolerance) -> DiagramPoint {
        let (orbit, finder) = (point.orbit(), &mut self.finder);
        let admissibility = finder.admissibility(orbit).ok();
        let physical = admissibility.as_ref().map(|answer| answer.is_physical());
        let verdict = self.analyser.verdict(orbit, finder, tolerance).ok();
        let margin = admissibility.and_then(|answer| answer.margin);
        DiagramPoint { value: point.value(), orbit: orbit.clone(), margin, physical, verdict }
    }
}

impl Diagram {
    /// Follows a branch from a point of it to both sides.
    fn take_both_ways(
        &mut self,
        mut follower: Follower,
        course: &Course,
        place: (Option<Origin>, u32),
        point: BranchPoint,
    ) -> Result<(), LocateError> {
        let (up, down) =
            if point.heading() < 0.0 { (point.reversed(), point) } else { (point.clone(), point.reversed()) };
        let first = follower.follow(down)?;
        let mut stations: Vec<Passed> = follower.passed.drain(..).rev().collect();
        stations.push(Passed::Point(up.clone()));
        let mut ends = vec![first];
        if ends[0].1 != End::Closed {
            ends.push(follower.follow(up)?);
            stations.append(&mut follower.passed);
        }
        self.take(follower, course, place, stations, ends);
        Ok(())
    }

    /// Adds a branch that was followed.
    fn take(
        &mut self,
        mut follower: Follower,
        course: &Course,
        (origin, generation): (Option<Origin>, u32),
        passed: Vec<Passed>,
        ends: Vec<(f64, End)>,
    ) {
        let station = |passed| match passed {
            Passed::Point(point) => Station::Point(follower.described(&point, course.tolerance)),
            Passed::Event(located) => Station::Event(located),
        };
        let stations = passed.into_iter().map(station).collect();
        self.evaluations += follower.evaluations();
        self.spectra += follower.spectra;
        let (unresolved, untold) = (follower.unresolved, follower.untold);
        self.branches.push(FollowedBranch { origin, generation, stations, unresolved, untold, ends });
    }

    /// Takes up the branch that leaves at an event, if one does.
    fn switch(&mut self, course: &Course, origin: Origin, stop: &Stop) -> Result<(), LocateError> {
        let parent = &self.branches[origin.branch];
        let Station::Event(located) = &parent.stations[origin.station] else { return Ok(()) };
        let Some(departure) = departure(located).filter(|_| parent.is_physical_about(origin.station)) else {
            return Ok(());
        };
        let generation = parent.generation + 1;
        let unit = located.value.abs().max(course.to - course.from);
        // What leaves a branch is not of that branch, however near it is at first.
        let known = |value: f64, orbit: &Orbit| {
            let others = self.branches.iter().enumerate().filter(|(i, _)| *i != origin.branch);
            others.into_iter().any(|(_, branch)| branch.holds(value, orbit))
        };
        if parent.ends.contains(&(located.value, End::Pitchfork)) {
            // The pair ends on the symmetric orbits: those are what goes on.
            if known(located.value, &located.orbit) {
                return Ok(());
            }
            let mut follower =
                course.follower(Branch::through(&located.orbit, course.free, course.to - course.from)?, stop);
            let point = follower.branch.start()?;
            return self.take_both_ways(follower, course, (Some(origin), generation), point);
        }
        let leaving = Branch::leaving(&located.orbit, &departure, course.free, unit);
        let taken = leaving.ok().and_then(|(branch, start)| {
            let mut branch = branch.until(stop);
            let first = first_step(&mut branch, &start, &departure, stop)?;
            Some((branch, start, first))
        });
        let Some((branch, start, first)) = taken else {
            // Where the energy of a conservative orbit is extreme nothing branches off.
            if !(located.event == Event::Pitchfork && located.orbit.model().is_conservative()) {
                self.dead_ends.push(origin);
            }
            return Ok(());
        };
        if known(first.value(), first.orbit()) {
            return Ok(());
        }
        let mut follower = course.follower(branch, stop);
        let end = follower.follow(first.clone())?;
        let mut stations = vec![Passed::Point(start), Passed::Point(first)];
        stations.append(&mut follower.passed);
        // At its far end one that comes back is the same branch from the other side, and too close to its end to be told by a step.
        let point = |passed: &Passed| match passed {
            Passed::Point(point) => Some((point.value(), point.orbit().clone())),
            Passed::Event(_) => None,
        };
        let middle = stations[stations.len() / 2..].iter().find_map(point);
        if middle.is_some_and(|(value, orbit)| known(value, &orbit)) {
            self.evaluations += follower.evaluations();
            self.spectra += follower.spectra;
            return Ok(());
        }
        self.take(follower, course, (Some(origin), generation), stations, vec![end]);
        Ok(())
    }
}
