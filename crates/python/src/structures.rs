//! Orbits of any linear structure: a scene as JSON in, the answer as JSON out.

use std::path::Path;

use numpy::{IntoPyArray, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use serde_json::{Value, json};
use vibrochain_breather::{BreatherError, ContactMotion, LoadedStructure, Orbit, OrbitList, Word};
use vibrochain_floquet::{
    BranchRequest, Diagram, Event, FollowedBranch, Station, Tolerance, Walk, Window, branches, event_curves,
};
use vibrochain_lattice::{Barrier, Stop};
use vibrochain_maps::followed::touch;
use vibrochain_maps::scene::tolerance_from;
use vibrochain_maps::structure::along::{event, family, numbers, value};
use vibrochain_maps::structure::answer::json as answer_of;
use vibrochain_maps::structure::{Answered, Setting, StructureScene};

use crate::breathers::PyCompleteness;
use crate::call::long;
use crate::failure::Failure;
use crate::lengths::Items;

/// Contact, barrier, time and impulse.
pub(crate) type Hit = (usize, String, f64, f64);

/// Orbits of a word, or the one near given impacts (contact, barrier, time, impulse), of the structure in `scene`.
#[pyfunction]
#[pyo3(signature = (scene, word, force_periods, threshold, near, psi))]
pub(crate) fn _structure(
    py: Python<'_>,
    scene: String,
    word: Option<String>,
    force_periods: u32,
    threshold: f64,
    near: Items<Hit>,
    psi: f64,
) -> PyResult<(String, PyCompleteness)> {
    let work = move |stop: &Stop| {
        let scene = StructureScene::of_text(&scene, Path::new("."))?.until(stop);
        let model = scene.model()?;
        let tolerance = tolerance(threshold)?;
        let found = match &word {
            Some(word) => {
                let word: Word = word.parse().map_err(|error| Failure::Request(format!("word {word}: {error}")))?;
                model.orbits(&word, force_periods)?
            }
            None => {
                let orbit = orbit_near(&model, force_periods, psi, &near.0)?;
                OrbitList::near(orbit)
            }
        };
        let answered = found.orbits.iter().map(|orbit| Answered::new(orbit, tolerance));
        let answered = answered.collect::<Result<Vec<_>, BreatherError>>()?;
        let answer = answer_of(&scene, &model, word.as_deref().unwrap_or("near"), &found, &answered).to_string();
        Ok::<_, Failure>((answer, PyCompleteness(found.completeness)))
    };
    long(py, |_| Ok(()), work)
}

/// Places and velocities of all contacts on the orbit near given impacts, at any times: an array over times, contacts and these
/// two.
#[pyfunction]
pub(crate) fn _structure_motion<'py>(
    py: Python<'py>,
    scene: String,
    near: Items<Hit>,
    psi: f64,
    force_periods: u32,
    times: Items<f64>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let (near, times) = (near.0, times.0);
    let count = times.len();
    let work = move |_: &Stop| {
        let (_, orbit) = structure_orbit(&scene, &near, psi, force_periods)?;
        let known = orbit.at_contacts(&Stop::default())?;
        let motion = ContactMotion::new(&known)?;
        let (impacts, contacts) = (orbit.impacts(), known.model().structure().contacts().len());
        let mut values = Vec::with_capacity(times.len() * contacts * 2);
        for time in times {
            let now = (time - impacts[0].time).rem_euclid(orbit.period()) + impacts[0].time;
            let i = impacts.partition_point(|impact| impact.time <= now).saturating_sub(1);
            for contact in 0..contacts {
                let [place, velocity, _] = motion.contact(contact, i, now - impacts[i].time);
                values.extend([place, velocity]);
            }
        }
        Ok::<_, Failure>((values, contacts))
    };
    let (values, contacts) = long(py, |_| Ok(()), work)?;
    values.into_pyarray(py).reshape([count, contacts, 2])
}

/// What counts as unstable: from an excess on, or, of 0, what is not rounding.
fn tolerance(threshold: f64) -> Result<Tolerance, Failure> {
    let tolerance = tolerance_from(threshold)?;
    Ok(if threshold == 0.0 { Tolerance::Rounding } else { tolerance })
}

/// A structure in JSON, and its orbit next to given impacts.
pub(crate) fn structure_orbit(
    scene: &str,
    near: &[Hit],
    psi: f64,
    force_periods: u32,
) -> Result<(StructureScene, Orbit), Failure> {
    let scene = StructureScene::of_text(scene, Path::new("."))?;
    let orbit = orbit_near(&scene.model()?, force_periods, psi, near)?;
    Ok((scene, orbit))
}

/// The orbit next to given impacts.
fn orbit_near(model: &LoadedStructure, force_periods: u32, psi: f64, near: &[Hit]) -> Result<Orbit, Failure> {
    let impacts = near.iter().map(|(contact, barrier, time, impulse)| {
        let named = Barrier::from_name(barrier);
        let wrong = || Failure::Request(format!("barrier {barrier} is unknown: give lower or upper"));
        Ok(vibrochain_breather::Hit::new(*contact, named.ok_or_else(wrong)?, *time, *impulse))
    });
    let impacts = impacts.collect::<Result<Vec<_>, Failure>>()?;
    ensure!(!impacts.is_empty(), "there are no impacts to begin near: give a word, or an orbit");
    Ok(model.orbit_near(force_periods, psi, &impacts)?)
}

/// How many points lie before each event.
pub(crate) fn places(stations: &[Station]) -> Vec<usize> {
    let before = stations.iter().scan(0, |points, station| {
        *points += usize::from(matches!(station, Station::Point(_)));
        Some((station, *points))
    });
    before.filter(|(station, _)| matches!(station, Station::Event(_))).map(|(_, points)| points).collect()
}

/// A branch of orbits: with the branch that it leaves, and where; and how many points lie before each event.
fn told(found: &Diagram, branch: &FollowedBranch) -> Value {
    let first = branch.points().next().map(|point| &point.orbit);
    json!({
        "word": first.map_or(String::new(), Orbit::name),
        "generation": branch.generation,
        "force_periods": first.map_or(1, Orbit::force_periods),
        "origin": branch.origin.and_then(|origin| Some((origin.branch, found.event_at(origin)?.value))),
        "points": branch.points().collect::<Vec<_>>(),
        "events": branch.events().map(event).collect::<Value>(),
        "places": places(&branch.stations),
        "unresolved": branch.unresolved,
        "ends": branch.ends.iter().map(|(value, end)| (*value, end.name())).collect::<Vec<_>>(),
    })
}

/// The branch of an orbit along a number of the structure in `scene`, with so many generations of those that leave it, and, over two
/// numbers, the curves of the events on it.
#[pyfunction]
#[pyo3(signature = (scene, near, psi, force_periods, free, start, stop_at, events, generations, tolerance, threshold))]
#[expect(clippy::too_many_arguments, reason = "named ones in Python")]
pub(crate) fn _structure_along(
    py: Python<'_>,
    scene: String,
    near: Items<Hit>,
    psi: f64,
    force_periods: u32,
    free: Items<String>,
    start: Items<f64>,
    stop_at: Items<f64>,
    events: Items<String>,
    generations: u32,
    tolerance: f64,
    threshold: f64,
) -> PyResult<String> {
    let (near, free, start, stop_at, events) = (near.0, free.0, start.0, stop_at.0, events.0);
    let work = move |stop: &Stop| {
        let scene = StructureScene::of_text(&scene, Path::new("."))?.until(stop);
        let model = scene.model()?;
        let named = |name: &String| {
            let setting: Setting = name.parse()?;
            Ok((setting, value(&scene, setting)?))
        };
        let free = free.iter().map(named).collect::<Result<Vec<_>, Failure>>()?;
        let known =
            |name: &String| Event::from_name(name).ok_or_else(|| Failure::Request(format!("{name} is no event")));
        let mut wanted = events.iter().map(known).collect::<Result<Vec<_>, Failure>>()?;
        if wanted.is_empty() {
            wanted = Event::ALL.to_vec();
        }
        let excess = self::tolerance(threshold)?;
        let orbit = orbit_near(&model, force_periods, psi, &near)?;
        let (setting, value) = free[0];
        let course = BranchRequest { from: start[0], to: stop_at[0], events: wanted, generations, tolerance: excess };
        let found = branches(&orbit, &family(&scene, &[setting]), value, &course, stop)?;
        let followed = match free[..] {
            [(first, _), (second, _)] => {
                let window = Window { from: [start[0], start[1]], to: [stop_at[0], stop_at[1]] };
                let walk = Walk { stop: stop.clone(), ..Walk::new(window, tolerance) };
                event_curves(found.branches[0].events(), &numbers(&scene, &[first, second])?, &walk)?
            }
            _ => Vec::new(),
        };
        let settings: Vec<Setting> = free.iter().map(|(setting, _)| *setting).collect();
        // The orbit's own branch first; what stands at the axes, and above the picture.
        let answer = json!({
            "branches": found.branches.iter().map(|branch| told(&found, branch)).collect::<Value>(),
            "complete": found.complete,
            "touches": followed.iter().map(touch).collect::<Vec<_>>(),
            "curves": followed,
            "labels": settings.iter().map(|setting| scene.label(*setting)).collect::<Vec<_>>(),
            "heading": scene.fixed_but(&orbit.name(), &settings),
        });
        Ok::<_, Failure>(answer.to_string())
    };
    long(py, |_| Ok(()), work)
}
