//! Branches of a lattice's orbits as one of its parameters varies: those of the lattice as a structure with contacts at the masses that hit.

use vibrochain_breather::{BreatherError, Orbit};
use vibrochain_lattice::{Model, Parameter, Part, Stop};

use super::answer::{Answer, Event, LocateError, Search};
use super::course::{Course, Diagram};
use super::diagram::{BranchRequest, branch_events, branches};

/// The shortest range, as a part of the start: a fiftieth of it, and a thousandth of that, are more than rounding.
const LEAST: f64 = 1e-9;

/// Follows the branch of `orbit` both ways, to the ends of the range or to a fold or another end of the branch, and collects all events.
///
/// # Errors
/// [`LocateError`].
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_floquet::{Event, Search, locate};
/// use vibrochain_lattice::{Parameter, Point};
/// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
/// let model = ring.omega(1.07).asymmetry(0.8).amplitude(0.165).restitution(0.25).model()?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let search = Search::new(orbit, Event::PeriodDoubling, Parameter::Amplitude);
/// let answer = locate(orbit, &search)?;
/// assert!((answer.located[0].value - 0.158908086).abs() < 1e-9);
/// assert!(answer.located[0].branching.as_ref().is_some_and(|doubled| doubled.orbits.len() == 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn locate(orbit: &Orbit, search: &Search) -> Result<Answer, LocateError> {
    locate_until(orbit, search, &Stop::default())
}

/// The same, until `stop` is raised, which is looked at before every orbit and every spectrum.
///
/// # Errors
/// As [`locate`]; [`LocateError::Stopped`].
pub fn locate_until(orbit: &Orbit, search: &Search, stop: &Stop) -> Result<Answer, LocateError> {
    let Search { event, free, from, to } = *search;
    check(orbit, free, (from, to))?;
    let lattice = orbit.lattice()?;
    if event != Event::Grazing && !has_moving_multipliers(lattice.model()) {
        return Err(LocateError::NoMultiplier);
    }
    branch_events(orbit, &lattice.models(&[free], stop), lattice.model().get(free), (event, [from, to]), stop)
}

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
    let &Course { free, from, to, ref events, generations, tolerance } = course;
    check(orbit, free, (from, to))?;
    let (lattice, mut events) = (orbit.lattice()?, events.clone());
    if !has_moving_multipliers(lattice.model()) {
        // Only multipliers show the other events.
        events.retain(|event| *event == Event::Grazing);
    }
    let request = BranchRequest { from, to, events, generations, tolerance };
    branches(orbit, &lattice.models(&[free], stop), lattice.model().get(free), &request, stop)
}

/// Whether a parameter other than that of the model leaves no orbit without a force.
fn needs_force(free: Parameter) -> bool {
    matches!(free.row().part, Part::Driving | Part::Dashpots)
}

/// Whether the branch of `orbit` can be followed over a range.
fn check(orbit: &Orbit, free: Parameter, (from, to): (f64, f64)) -> Result<(), LocateError> {
    let model = orbit.lattice()?.model();
    let start = model.get(free);
    if !(from <= start && start <= to && from < to) {
        return Err(LocateError::Range { free, start, from, to });
    }
    if to - from < LEAST * start.abs() {
        return Err(LocateError::Short { free, from, to });
    }
    for end in [from, to] {
        model.with(free, end).map_err(BreatherError::from)?;
    }
    if model.is_conservative() && needs_force(free) {
        return Err(LocateError::NoForce { free });
    }
    Ok(())
}

/// A single mass without force keeps its trivial pair alone.
fn has_moving_multipliers(model: &Model) -> bool {
    model.chain().sites() > 1 || !model.is_conservative()
}
