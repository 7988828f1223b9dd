//! A branch of orbits, followed both ways as one number of its structure varies, with the events on it, and the branches that leave it.

use vibrochain_breather::{Branch, BranchError, BranchPoint, ContactOrbit, Departure, Family, ModelFamily, Orbit};
use vibrochain_lattice::Stop;

use super::answer::{Answer, End, Event, LocateError, Located};
use super::course::{Diagram, FollowedBranch, Origin, Station};
use super::ends::BranchEnds;
use super::follower::follow::upwards;
use super::follower::{Follower, Stretch};
use super::switch::{departure, first_step};
use crate::events::Watcher;
use crate::verdict::Tolerance;

/// Branches at most, however many generations are asked for.
const MOST_BRANCHES: usize = 256;

/// What is asked of a branch.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct BranchRequest {
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

/// The bifurcation diagram of an orbit: its branch as a number of `family` goes on from `value` both ways, through folds, to the
/// ends of the range or of the branch, with all events that are asked for; and so many generations of the branches that leave it at period
/// doublings, where symmetry is lost, and at grazings.
///
/// # Errors
/// [`LocateError`]: no such range, no such model, stopped.
pub fn branches(
    orbit: &Orbit,
    family: &ModelFamily,
    value: f64,
    course: &BranchRequest,
    stop: &Stop,
) -> Result<Diagram, LocateError> {
    let BranchRequest { from, to, .. } = *course;
    if !(from <= value && value <= to && from < to) {
        let message =
            format!("{value} is not in a range from {from} to {to}: give one with from < to around the start");
        return Err(BranchError::Model(message).into());
    }
    let tracing = Tracing { family, name: orbit.family(), course, stop };
    let mut branch = tracing.branch(&*orbit.followed(stop)?, value)?;
    let point = branch.start()?;
    let own = both_ways(tracing.follower(branch), point)?;
    let diagram = grown(&tracing, own, course.generations)?;
    // On the way a failure may be an end.
    stop.heard()?;
    Ok(diagram)
}

/// The events of one kind on the branch of an orbit as a number of `family` goes on from `start` both ways, as far as the ends of the range or of
/// the branch, a fold among them.
///
/// # Errors
/// As [`branches`].
pub fn branch_events(
    orbit: &Orbit,
    family: &ModelFamily,
    start: f64,
    (event, [from, to]): (Event, [f64; 2]),
    stop: &Stop,
) -> Result<Answer, LocateError> {
    let course = BranchRequest { from, to, events: vec![event], generations: 0, tolerance: Tolerance::Rounding };
    let tracing = Tracing { family, name: orbit.family(), course: &course, stop };
    let mut follower = tracing.follower(tracing.branch(&*orbit.followed(stop)?, start)?);
    follower.stretch.whole = false;
    let up = upwards(follower.branch.start()?);
    let seen = follower.look(&up)?;
    let ends = [follower.follow(&up.reversed(), seen.clone())?, follower.follow(&up, seen)?];
    // On the way a failure may be an end.
    stop.heard()?;
    let (evaluations, spectra) = (follower.evaluations(), follower.spectra());
    let event = |station: Station| match station {
        Station::Event(located) => Some(located),
        Station::Point(_) => None,
    };
    let mut located: Vec<Located> = follower.passed.into_iter().filter_map(event).collect();
    located.sort_by(|a, b| (a.value - start).abs().total_cmp(&(b.value - start).abs()));
    // A start right on the event is found from both sides.
    located.dedup_by(|b, a| (a.value - b.value).abs() <= a.error + b.error);
    Ok(Answer { located, unresolved: follower.unresolved, ends, evaluations, spectra })
}

/// The branches of an orbit and of those that leave it.
struct Tracing<'a> {
    family: &'a ModelFamily,
    /// What its orbits are called.
    name: Family,
    course: &'a BranchRequest,
    stop: &'a Stop,
}

impl Tracing<'_> {
    fn range(&self) -> f64 {
        self.course.to - self.course.from
    }

    fn branch(&self, orbit: &ContactOrbit, value: f64) -> Result<Branch, BranchError> {
        Branch::through(orbit, self.family.clone(), value, self.range(), self.stop)
    }

    /// Who follows a branch.
    fn follower(&self, branch: Branch) -> Follower {
        let BranchRequest { from, to, ref events, tolerance, .. } = *self.course;
        let stretch = Stretch { from, to, events: events.clone(), tolerance, whole: true };
        Follower::new(branch, Watcher::default(), self.ends(), stretch, self.stop)
    }

    /// Right where symmetry is lost there are two directions; beside it, amid the two orbits that branch off, the symmetric one has one.
    fn through(&self, located: &Located) -> Result<(Branch, BranchPoint), BranchError> {
        let amid = located.branching.as_ref().and_then(|pair| {
            let one = pair.orbits.first()?.orbit.at_contacts(self.stop).ok()?;
            Some((one.evened()?.map_err(BranchError::from), pair.value))
        });
        let (symmetric, value) = amid.ok_or(BranchError::NoConvergence)?;
        let mut branch = self.branch(&symmetric?, value)?;
        let point = branch.start()?;
        Ok((branch, point))
    }

    /// What stands at the ends of branches.
    fn ends(&self) -> BranchEnds {
        let (family, others) = (self.family.clone(), Watcher::default());
        let (range, tolerance, stop) = (self.range(), self.course.tolerance, self.stop.clone());
        BranchEnds { family, name: self.name, range, tolerance, stop, others }
    }
}

/// A branch that was followed, and what that has cost.
struct Traced {
    branch: FollowedBranch,
    evaluations: usize,
    spectra: usize,
}

/// A branch from a point of it to both sides.
fn both_ways(mut follower: Follower, point: BranchPoint) -> Result<Traced, LocateError> {
    let up = upwards(point);
    let seen = follower.look(&up)?;
    let mut ends = vec![follower.follow(&up.reversed(), seen.clone())?];
    let mut stations: Vec<_> = follower.passed.drain(..).rev().collect();
    follower.pass(&up, &seen)?;
    if ends[0].1 != End::Closed {
        ends.push(follower.follow(&up, seen)?);
    }
    stations.append(&mut follower.passed);
    Ok(traced(follower, stations, ends))
}

/// A branch that was followed.
fn traced(follower: Follower, stations: Vec<Station>, ends: Vec<(f64, End)>) -> Traced {
    let (evaluations, spectra) = (follower.evaluations(), follower.spectra());
    let (unresolved, untold) = (follower.unresolved, follower.untold);
    let branch = FollowedBranch { origin: None, generation: 0, stations, unresolved, untold, ends };
    Traced { branch, evaluations, spectra }
}

/// A branch that leaves another, with its first step.
struct Leaving {
    branch: Branch,
    start: BranchPoint,
    first: BranchPoint,
}

impl Leaving {
    fn of(tracing: &Tracing<'_>, place: (&ContactOrbit, f64), departure: &Departure) -> Option<Self> {
        let (branch, start) = tracing.ends().leaving(place, departure).ok()?;
        let mut follower = tracing.follower(branch);
        let watcher = &mut follower.watcher;
        let is_physical = |orbit: &ContactOrbit| watcher.admissibility(orbit).is_ok_and(|told| told.is_physical());
        let first = first_step(&mut follower.branch, &start, departure, is_physical)?;
        Some(Self { branch: follower.branch, start, first })
    }

    /// That branch, from where it leaves to its end.
    fn followed(self, tracing: &Tracing<'_>) -> Result<Traced, LocateError> {
        let Self { branch, start, first } = self;
        let mut follower = tracing.follower(branch);
        // Right at its beginning an orbit may have no multipliers.
        let at_start = follower.look(&start).unwrap_or_default();
        follower.pass(&start, &at_start)?;
        let seen = follower.look(&first)?;
        follower.pass(&first, &seen)?;
        let end = follower.follow(&first, seen)?;
        let stations = std::mem::take(&mut follower.passed);
        Ok(traced(follower, stations, vec![end]))
    }
}

/// The diagram of an orbit's own branch and so many generations of those that leave it.
fn grown(tracing: &Tracing<'_>, own: Traced, generations: u32) -> Result<Diagram, LocateError> {
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
                switch(&mut diagram, tracing, Origin { branch: next, station })?;
            }
        }
        next += 1;
    }
    Ok(diagram)
}

impl Diagram {
    /// Adds a branch that was followed.
    fn take(&mut self, traced: Traced, origin: Option<Origin>, generation: u32) {
        self.evaluations += traced.evaluations;
        self.spectra += traced.spectra;
        self.branches.push(FollowedBranch { origin, generation, ..traced.branch });
    }
}

/// Takes up the branch that leaves at an event, if one does.
fn switch(diagram: &mut Diagram, tracing: &Tracing<'_>, origin: Origin) -> Result<(), LocateError> {
    let parent = &diagram.branches[origin.branch];
    let Station::Event(located) = &parent.stations[origin.station] else { return Ok(()) };
    let Ok(orbit) = located.orbit.at_contacts(tracing.stop) else { return Ok(()) };
    let departure = departure(located, &orbit).filter(|_| parent.is_physical_about(origin.station));
    let Some(departure) = departure else { return Ok(()) };
    let generation = parent.generation + 1;
    // What leaves a branch is not of that branch, however near it is at first.
    let known = |value: f64, orbit: &Orbit| {
        let others = diagram.branches.iter().enumerate().filter(|(i, _)| *i != origin.branch);
        others.into_iter().any(|(_, branch)| branch.holds(value, orbit))
    };
    if parent.ends_on_simpler(located.value) {
        // The pair ends on the symmetric orbits: those are what goes on.
        if !known(located.value, &located.orbit) {
            let (branch, point) = match tracing.through(located) {
                Ok(begun) => begun,
                // What has been followed so far is no worse for it.
                Err(BranchError::NoConvergence) => {
                    diagram.dead_ends.push(origin);
                    return Ok(());
                }
                Err(error) => return Err(error.into()),
            };
            let symmetric = both_ways(tracing.follower(branch), point)?;
            diagram.take(symmetric, Some(origin), generation);
        }
        return Ok(());
    }
    // The branch that would leave here has come here from its other end.
    if diagram.branches.iter().any(|branch| branch.ends_at(located)) {
        return Ok(());
    }
    let Some(leaving) = Leaving::of(tracing, (&orbit, located.value), &departure) else {
        // Where the energy of a conservative orbit is extreme nothing branches off.
        if !(located.event == Event::Pitchfork && located.orbit.is_conservative()) {
            diagram.dead_ends.push(origin);
        }
        return Ok(());
    };
    if known(leaving.first.value(), &leaving.first.orbit().to_orbit(tracing.name)?) {
        return Ok(());
    }
    let traced = leaving.followed(tracing)?;
    // At its far end one that comes back is the same branch from the other side, and too close to its end to be told by a step.
    let stations = &traced.branch.stations;
    let point = |station: &Station| match station {
        Station::Point(point) => Some(known(point.value, &point.orbit)),
        Station::Event(_) => None,
    };
    let again = stations[stations.len() / 2..].iter().find_map(point) == Some(true);
    if again {
        diagram.evaluations += traced.evaluations;
        diagram.spectra += traced.spectra;
    } else {
        diagram.take(traced, Some(origin), generation);
    }
    Ok(())
}
