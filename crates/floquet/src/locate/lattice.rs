//! Branches of a lattice's orbits as one of its parameters varies: those of the lattice as a structure with contacts at the masses that hit.

use vibrochain_breather::{BranchError, BreatherError, ModelFamily, Orbit, StructureOrbit};
use vibrochain_lattice::{Parameter, Resonance, Spectrum, Stop};

use super::answer::{Answer, BranchedOrbit, Branching, End, Event, LocateError, Located, Search};
use super::course::{Course, Diagram, DiagramPoint, FollowedBranch, Station};
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
    if event != Event::Grazing && !has_moving_multipliers(orbit) {
        return Err(LocateError::NoMultiplier);
    }
    let of = OfLattice { start: orbit, free };
    let (start, family, value) = of.begun(stop)?;
    let Answer { located, unresolved, ends, evaluations, spectra } =
        branch_events(&start, &family, value, (event, [from, to]), stop)?;
    let located = located.into_iter().map(|one| of.located(one)).collect::<Result<_, _>>()?;
    Ok(Answer { located, unresolved, ends: ends.map(|end| of.end(end)), evaluations, spectra })
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
    let mut events = events.clone();
    if !has_moving_multipliers(orbit) {
        // Only multipliers show the other events.
        events.retain(|event| *event == Event::Grazing);
    }
    let of = OfLattice { start: orbit, free };
    let (start, family, value) = of.begun(stop)?;
    let request = BranchRequest { from, to, events, generations, tolerance };
    let found = branches(&start, &family, value, &request, stop)?;
    let Diagram { dead_ends, complete, evaluations, spectra, .. } = found;
    let branches = found.branches.into_iter().map(|branch| of.branch(branch)).collect::<Result<_, _>>()?;
    Ok(Diagram { branches, dead_ends, complete, evaluations, spectra })
}

/// Whether the branch of `orbit` can be followed over a range.
fn check(orbit: &Orbit, free: Parameter, (from, to): (f64, f64)) -> Result<(), LocateError> {
    let start = orbit.model().get(free);
    if !(from <= start && start <= to && from < to) {
        return Err(LocateError::Range { free, start, from, to });
    }
    if to - from < LEAST * start.abs() {
        return Err(LocateError::Short { free, from, to });
    }
    for end in [from, to] {
        orbit.model().with(free, end).map_err(BreatherError::from)?;
    }
    if orbit.model().is_conservative() && matches!(free, Parameter::Amplitude | Parameter::Restitution) {
        return Err(LocateError::NoForce { free });
    }
    Ok(())
}

/// A single mass without force keeps its trivial pair alone.
fn has_moving_multipliers(orbit: &Orbit) -> bool {
    orbit.model().chain().sites() > 1 || !orbit.model().is_conservative()
}

/// What is found of the lattice as a structure, as it is told of the lattice.
struct OfLattice<'a> {
    start: &'a Orbit,
    free: Parameter,
}

impl OfLattice<'_> {
    /// The orbit to start from as one of the structure, its models as the parameter varies, and where that is.
    fn begun(&self, stop: &Stop) -> Result<(StructureOrbit, ModelFamily, f64), LocateError> {
        let (start, family, values) =
            StructureOrbit::along(self.start, &[self.free], stop).map_err(BranchError::from)?;
        Ok((start, family, values[0]))
    }

    fn orbit(&self, orbit: &StructureOrbit, value: f64) -> Result<Orbit, LocateError> {
        let model = self.start.model().with(self.free, value).map_err(BreatherError::from)?;
        Ok(orbit.to_orbit(&model, self.start.family())?)
    }

    /// Modes of a lattice are numbered by their wave.
    fn end(&self, (value, end): (f64, End)) -> (f64, End) {
        let End::Resonance(resonance) = end else { return (value, end) };
        let model = self.start.model().with(self.free, value).ok();
        let wave = model.map(|model| Spectrum::new(*model.chain()).nearest(resonance.frequency));
        (value, End::Resonance(Resonance { mode: wave.unwrap_or(resonance.mode), ..resonance }))
    }

    fn located(&self, of: Located<StructureOrbit>) -> Result<Located, LocateError> {
        let orbit = self.orbit(&of.orbit, of.value)?;
        let branching = of.branching.map(|branching| {
            let branched = |one: BranchedOrbit<StructureOrbit>| {
                let orbit = self.orbit(&one.orbit, branching.value)?;
                Ok::<_, LocateError>(BranchedOrbit { orbit, physical: one.physical, verdict: one.verdict })
            };
            let orbits = branching.orbits.into_iter().map(branched).collect::<Result<Vec<_>, _>>()?;
            Ok::<_, LocateError>(Branching { value: branching.value, above: branching.above, orbits })
        });
        let Located { event, value, error, evidence, physical, sides, evaluations, .. } = of;
        Ok(Located {
            event,
            value,
            error,
            orbit,
            evidence,
            physical,
            sides,
            branching: branching.transpose()?,
            evaluations,
        })
    }

    fn station(&self, station: Station<StructureOrbit>) -> Result<Station, LocateError> {
        Ok(match station {
            Station::Point(DiagramPoint { value, orbit, margin, physical, verdict }) => {
                Station::Point(DiagramPoint { value, orbit: self.orbit(&orbit, value)?, margin, physical, verdict })
            }
            Station::Event(located) => Station::Event(self.located(located)?),
        })
    }

    fn branch(&self, branch: FollowedBranch<StructureOrbit>) -> Result<FollowedBranch, LocateError> {
        let FollowedBranch { origin, generation, stations, unresolved, untold, ends } = branch;
        let stations = stations.into_iter().map(|station| self.station(station)).collect::<Result<_, _>>()?;
        let ends = ends.into_iter().map(|end| self.end(end)).collect();
        Ok(FollowedBranch { origin, generation, stations, unresolved, untold, ends })
    }
}
