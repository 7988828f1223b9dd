//! The bifurcation diagram of an orbit in one parameter: its branch through all folds, every event on it, and the branches that
//! leave it.

use vibrochain_breather::{Branch, BranchError, BranchPoint, Departure, Orbit};
use vibrochain_lattice::Stop;

use super::answer::{End, Event, LocateError, Located};
use super::chain::{OfChain, check, following, has_moving_multipliers};
use super::course::{Course, Diagram, FollowedBranch, Origin, Station};
use super::follower::follow::upwards;
use super::follower::{Begun, Ends, Follower, OrbitOf, Point, Stretch, Track};
use super::switch::{departure, first_step};
use crate::events::Watcher;
use crate::followed::Followed;

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
/// use vibrochain_lattice::{Parameter, Point};
/// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
/// let model = ring.omega(1.07).asymmetry(0.8).amplitude(0.165).restitution(0.25).model()?;
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
    let mut events = course.events.clone();
    if !has_moving_multipliers(orbit) {
        // Only multipliers show the other events.
        events.retain(|event| *event == Event::Grazing);
    }
    let tracing = ChainTracing { course, events, sites: orbit.model().chain().sites(), stop };
    let mut branch = Branch::through(orbit, course.free, course.to - course.from)?.until(stop);
    let point = branch.start()?;
    let own = both_ways(tracing.follower(branch), point)?;
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

/// Which branches a diagram has: those of a chain's orbits, or of a structure's.
pub(crate) trait Tracing {
    /// What stands at their ends.
    type Ends: Ends;

    /// Who follows a branch.
    fn follower(&self, branch: Track<Self::Ends>) -> Follower<Self::Ends>;
    /// The branch through the orbit of an event, and a point to begin at.
    fn through(&self, located: &Located<OrbitOf<Self::Ends>>) -> Result<Begun<Self::Ends>, BranchError>;
    /// What stands at the ends of branches of such orbits.
    fn ends(&self) -> Self::Ends;
}

/// A branch from a point of it to both sides.
pub(crate) fn both_ways<E: Ends>(
    mut follower: Follower<E>,
    point: Point<E>,
) -> Result<Traced<OrbitOf<E>>, LocateError> {
    let up = upwards::<E>(point);
    let seen = follower.look(&up)?;
    let mut ends = vec![follower.follow(&up.reversed(), seen.clone())?];
    let mut stations: Vec<_> = follower.passed.drain(..).rev().collect();
    follower.pass(&up, &seen);
    if ends[0].1 != End::Closed {
        ends.push(follower.follow(&up, seen)?);
    }
    stations.append(&mut follower.passed);
    Ok(traced(follower, stations, ends))
}

/// A branch that was followed.
fn traced<E: Ends>(
    follower: Follower<E>,
    stations: Vec<Station<OrbitOf<E>>>,
    ends: Vec<(f64, End)>,
) -> Traced<OrbitOf<E>> {
    let (evaluations, spectra) = (follower.evaluations(), follower.spectra());
    let (unresolved, untold) = (follower.unresolved, follower.untold);
    let branch = FollowedBranch { origin: None, generation: 0, stations, unresolved, untold, ends };
    Traced { branch, evaluations, spectra }
}

/// A branch that leaves another, with its first step.
struct Leaving<E: Ends> {
    branch: Track<E>,
    start: Point<E>,
    first: Point<E>,
}

impl<E: Ends> Leaving<E> {
    fn of(tracing: &impl Tracing<Ends = E>, located: &Located<OrbitOf<E>>, departure: &Departure) -> Option<Self> {
        let place = (&located.orbit, located.value);
        let (branch, start) = tracing.ends().leaving(place, departure).ok()?;
        let mut follower = tracing.follower(branch);
        let watcher = &mut follower.watcher;
        let is_physical = |orbit: &OrbitOf<E>| watcher.admissibility(orbit).is_ok_and(|told| told.is_physical());
        let first = first_step(&mut follower.branch, &start, departure, is_physical)?;
        Some(Self { branch: follower.branch, start, first })
    }

    /// That branch, from where it leaves to its end.
    fn followed(self, tracing: &impl Tracing<Ends = E>) -> Result<Traced<OrbitOf<E>>, LocateError> {
        let Self { branch, start, first } = self;
        let mut follower = tracing.follower(branch);
        // Right at its beginning an orbit may have no multipliers.
        let at_start = follower.look(&start).unwrap_or_default();
        follower.pass(&start, &at_start);
        let seen = follower.look(&first)?;
        follower.pass(&first, &seen);
        let end = follower.follow(&first, seen)?;
        let stations = std::mem::take(&mut follower.passed);
        Ok(traced(follower, stations, vec![end]))
    }
}

/// The diagram of an orbit's own branch and so many generations of those that leave it.
pub(crate) fn grown<T: Tracing>(
    tracing: &T,
    own: Traced<OrbitOf<T::Ends>>,
    generations: u32,
) -> Result<Diagram<OrbitOf<T::Ends>>, LocateError> {
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

impl<O: Followed> Diagram<O> {
    /// Adds a branch that was followed.
    fn take(&mut self, traced: Traced<O>, origin: Option<Origin>, generation: u32) {
        self.evaluations += traced.evaluations;
        self.spectra += traced.spectra;
        self.branches.push(FollowedBranch { origin, generation, ..traced.branch });
    }
}

/// Takes up the branch that leaves at an event, if one does.
fn switch<T: Tracing>(diagram: &mut Diagram<OrbitOf<T::Ends>>, tracing: &T, origin: Origin) -> Result<(), LocateError> {
    let parent = &diagram.branches[origin.branch];
    let Station::Event(located) = &parent.stations[origin.station] else { return Ok(()) };
    let Some(departure) = departure(located).filter(|_| parent.is_physical_about(origin.station)) else {
        return Ok(());
    };
    let generation = parent.generation + 1;
    // What leaves a branch is not of that branch, however near it is at first.
    let known = |value: f64, orbit: &OrbitOf<T::Ends>| {
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
    let Some(leaving) = Leaving::of(tracing, located, &departure) else {
        // Where the energy of a conservative orbit is extreme nothing branches off.
        if !(located.event == Event::Pitchfork && located.orbit.is_conservative()) {
            diagram.dead_ends.push(origin);
        }
        return Ok(());
    };
    if known(leaving.first.value(), leaving.first.orbit()) {
        return Ok(());
    }
    let traced = leaving.followed(tracing)?;
    // At its far end one that comes back is the same branch from the other side, and too close to its end to be told by a step.
    let stations = &traced.branch.stations;
    let point = |station: &Station<OrbitOf<T::Ends>>| match station {
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

/// The branches of a chain's orbits.
struct ChainTracing<'a> {
    course: &'a Course,
    events: Vec<Event>,
    sites: usize,
    stop: &'a Stop,
}

impl Tracing for ChainTracing<'_> {
    type Ends = OfChain;

    fn follower(&self, branch: Branch) -> Follower<OfChain> {
        let Course { from, to, tolerance, .. } = *self.course;
        following(branch, Stretch { from, to, events: self.events.clone(), tolerance, whole: true }, self.stop)
    }

    fn through(&self, located: &Located) -> Result<(Branch, BranchPoint), BranchError> {
        let Course { free, from, to, .. } = *self.course;
        let mut branch = Branch::through(&located.orbit, free, to - from)?.until(self.stop);
        let point = branch.start()?;
        Ok((branch, point))
    }

    fn ends(&self) -> OfChain {
        let Course { free, from, to, .. } = *self.course;
        OfChain::new(self.sites, free, [from, to], self.stop)
    }
}
