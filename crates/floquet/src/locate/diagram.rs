//! The bifurcation diagram of an orbit in one parameter: its branch through all folds, every event on it, and the branches that
//! leave it.

use vibrochain_breather::{Branch, BranchPoint, Departure, Finder, Orbit};
use vibrochain_lattice::Stop;

use super::answer::{End, Event, LocateError, Located};
use super::course::{Course, Diagram, DiagramPoint, FollowedBranch, Origin, Station};
use super::follow::check;
use super::follower::{Follower, Passed};
use super::switch::{departure, first_step};
use crate::followed::Followed;
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
    let tracing = ChainTracing { course, stop };
    let mut follower = tracing.follower(Branch::through(orbit, course.free, course.to - course.from)?);
    let point = follower.branch.start()?;
    if orbit.model().chain().sites() == 1 {
        follower.without_those_that_cannot_be(point.orbit())?;
    }
    let own = tracing.both_ways(follower, point)?;
    let diagram = grown(&tracing, own, course.generations)?;
    // On the way a failure may be an end.
    stop.heard()?;
    Ok(diagram)
}

/// A branch that was followed, and what that has cost.
pub(crate) struct Traced<O> {
    pub(crate) branch: FollowedBranch<O>,
    pub(crate) evaluations: usize,
    pub(crate) spectra: usize,
}

/// Who follows the branches of a diagram: those of a chain's orbits, or of a structure's.
pub(crate) trait Tracing {
    /// What is followed.
    type Orbit: Followed;
    /// A branch that leaves another, with its first step.
    type Leaving;

    /// How other orbits leave a branch at an event, if they do.
    fn departure(&self, located: &Located<Self::Orbit>) -> Option<Departure>;

    /// The branch through the orbit of an event, both ways.
    fn through(&self, located: &Located<Self::Orbit>) -> Result<Traced<Self::Orbit>, LocateError>;

    /// The branch that leaves at an event, if one does.
    fn leaving(&self, located: &Located<Self::Orbit>, departure: &Departure) -> Option<Self::Leaving>;

    /// Where its first step ends.
    fn first(leaving: &Self::Leaving) -> (f64, &Self::Orbit);

    /// That branch, from where it leaves to its end.
    fn follow(&self, leaving: Self::Leaving) -> Result<Traced<Self::Orbit>, LocateError>;
}

/// The diagram of an orbit's own branch and so many generations of those that leave it.
pub(crate) fn grown<T: Tracing>(
    tracing: &T,
    own: Traced<T::Orbit>,
    generations: u32,
) -> Result<Diagram<T::Orbit>, LocateError> {
    let mut diagram =
        Diagram { branches: Vec::new(), dead_ends: Vec::new(), complete: true, evaluations: 0, spectra: 0 };
    diagram.take(own, None, 0);
    let mut next = 0;
    while next < diagram.branches.len() {
        if diagram.branches[next].generation < generations {
            for station in 0..diagram.branches[next].stations.len() {
                if diagram.branches.len() >= MOST_BRANCHES {
                    diagram.complete = false;
                    return Ok(diagram);
                }
                diagram.switch(tracing, Origin { branch: next, station })?;
            }
        }
        next += 1;
    }
    Ok(diagram)
}

impl<O: Followed> Diagram<O> {
    /// Adds a branch that was followed.
    fn take(&mut self, traced: Traced<O>, origin: Option<Origin>, generation: u32) {
        self.evaluations += traced.evaluations;
        self.spectra += traced.spectra;
        self.branches.push(FollowedBranch { origin, generation, ..traced.branch });
    }

    /// Takes up the branch that leaves at an event, if one does.
    fn switch<T: Tracing<Orbit = O>>(&mut self, tracing: &T, origin: Origin) -> Result<(), LocateError> {
        let parent = &self.branches[origin.branch];
        let Station::Event(located) = &parent.stations[origin.station] else { return Ok(()) };
        let Some(departure) = tracing.departure(located).filter(|_| parent.is_physical_about(origin.station)) else {
            return Ok(());
        };
        let generation = parent.generation + 1;
        // What leaves a branch is not of that branch, however near it is at first.
        let known = |value: f64, orbit: &O| {
            let others = self.branches.iter().enumerate().filter(|(i, _)| *i != origin.branch);
            others.into_iter().any(|(_, branch)| branch.holds(value, orbit))
        };
        if parent.ends.contains(&(located.value, End::Pitchfork)) {
            // The pair ends on the symmetric orbits: those are what goes on.
            if !known(located.value, &located.orbit) {
                let symmetric = tracing.through(located)?;
                self.take(symmetric, Some(origin), generation);
            }
            return Ok(());
        }
        // The branch that would leave here has come here from its other end.
        if self.branches.iter().any(|branch| branch.ends_at(located)) {
            return Ok(());
        }
        let Some(leaving) = tracing.leaving(located, &departure) else {
            // Where the energy of a conservative orbit is extreme nothing branches off.
            if !(located.event == Event::Pitchfork && located.orbit.is_conservative()) {
                self.dead_ends.push(origin);
            }
            return Ok(());
        };
        let (value, orbit) = T::first(&leaving);
        if known(value, orbit) {
            return Ok(());
        }
        let traced = tracing.follow(leaving)?;
        // At its far end one that comes back is the same branch from the other side, and too close to its end to be told by a step.
        let stations = &traced.branch.stations;
        let point = |station: &Station<O>| match station {
            Station::Point(point) => Some(known(point.value, &point.orbit)),
            Station::Event(_) => None,
        };
        let again = stations[stations.len() / 2..].iter().find_map(point) == Some(true);
        if again {
            self.evaluations += traced.evaluations;
            self.spectra += traced.spectra;
        } else {
            self.take(traced, Some(origin), generation);
        }
        Ok(())
    }
}

/// Who follows a chain's orbits.
struct ChainTracing<'a> {
    course: &'a Course,
    stop: &'a Stop,
}

impl ChainTracing<'_> {
    fn follower(&self, branch: Branch) -> Follower {
        let Course { from, to, .. } = *self.course;
        let mut follower = Follower::new(branch, (from, to), self.course.events.clone(), self.stop);
        follower.whole = true;
        follower
    }

    /// A branch from a point of it to both sides.
    fn both_ways(&self, mut follower: Follower, point: BranchPoint) -> Result<Traced<Orbit>, LocateError> {
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
        Ok(self.traced(follower, stations, ends))
    }

    /// A branch that was followed.
    fn traced(&self, mut follower: Follower, passed: Vec<Passed>, ends: Vec<(f64, End)>) -> Traced<Orbit> {
        let station = |passed| match passed {
            Passed::Point(point) => Station::Point(follower.described(&point, self.course.tolerance)),
            Passed::Event(located) => Station::Event(located),
        };
        let stations = passed.into_iter().map(station).collect();
        let (evaluations, spectra) = (follower.evaluations(), follower.spectra);
        let (unresolved, untold) = (follower.unresolved, follower.untold);
        let branch = FollowedBranch { origin: None, generation: 0, stations, unresolved, untold, ends };
        Traced { branch, evaluations, spectra }
    }
}

impl Tracing for ChainTracing<'_> {
    type Orbit = Orbit;
    type Leaving = (Branch, BranchPoint, BranchPoint);

    fn departure(&self, located: &Located) -> Option<Departure> {
        departure(located)
    }

    fn through(&self, located: &Located) -> Result<Traced<Orbit>, LocateError> {
        let Course { free, from, to, .. } = *self.course;
        let mut follower = self.follower(Branch::through(&located.orbit, free, to - from)?);
        let point = follower.branch.start()?;
        self.both_ways(follower, point)
    }

    fn leaving(&self, located: &Located, departure: &Departure) -> Option<Self::Leaving> {
        let Course { free, from, to, .. } = *self.course;
        let (branch, start) =
            Branch::leaving(&located.orbit, departure, free, located.value.abs().max(to - from)).ok()?;
        let mut branch = branch.until(self.stop);
        let mut finder = Finder::new(branch.sites()).until(self.stop);
        let is_physical = |orbit: &Orbit| finder.admissibility(orbit).is_ok_and(|told| told.is_physical());
        let first = first_step(&mut branch, &start, departure, is_physical)?;
        Some((branch, start, first))
    }

    fn first((_, _, first): &Self::Leaving) -> (f64, &Orbit) {
        (first.value(), first.orbit())
    }

    fn follow(&self, (branch, start, first): Self::Leaving) -> Result<Traced<Orbit>, LocateError> {
        let mut follower = self.follower(branch);
        let end = follower.follow(first.clone())?;
        let mut stations = vec![Passed::Point(start), Passed::Point(first)];
        stations.append(&mut follower.passed);
        Ok(self.traced(follower, stations, vec![end]))
    }
}

impl Follower {
    /// Looks for grazing alone if no multiplier of this orbit can move: only multipliers show the other events.
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
