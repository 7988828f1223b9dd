//! Event-driven runs.

use numpy::{IntoPyArray, PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use vibrochain_eventsim::{Event, EventKind, Limits, Outcome, Report, Simulation, State, StateError, Time};
use vibrochain_fate::Start;
use vibrochain_lattice::{Barrier, Layout, Model, Short, Stop};

use crate::call::long;
use crate::failure::{Failure, whole};
use crate::lengths::room;
use crate::orbits::PyOrbit;
use crate::params::PyModel;

/// The most events that are kept: some gigabytes.
const MOST_EVENTS: usize = 50_000_000;

/// Impacts between two looks at how many events there are: a second of work.
const MANY_IMPACTS: u64 = 1_000_000;

/// Windows of flight that a run may need at least, as of `mapgen`: of a single mass 1e15 are some three years.
const MOST_WINDOWS: f64 = 1e15;

/// Where a run on an orbit starts: the time before the first impact, displacements, velocities, the phase of the force there.
#[pyfunction]
pub(crate) fn _start(py: Python<'_>, orbit: PyRef<'_, PyOrbit>) -> PyResult<Py<PyAny>> {
    let orbit = orbit.0.clone();
    let Start { displacement, velocity, psi, time } = long(py, |_| Ok(()), move |_| Start::on(&orbit))?;
    let parts = (time, displacement.into_pyarray(py), velocity.into_pyarray(py), psi);
    Ok(parts.into_pyobject(py)?.into_any().unbind())
}

/// A run that is asked for.
struct Course {
    model: Model,
    start: f64,
    state: (Vec<f64>, Vec<f64>),
    psi: f64,
    /// When to look, and when to end.
    looks: Vec<Time>,
    end: Time,
    impacts: u64,
}

/// Events by columns.
#[derive(Default)]
struct Events {
    time: Vec<f64>,
    site: Vec<i64>,
    layer: Vec<i64>,
    upper: Vec<bool>,
    before: Vec<f64>,
    after: Vec<f64>,
    kind: Vec<i8>,
    /// Words of `kind`, by code.
    words: Vec<&'static str>,
}

impl Events {
    fn push(&mut self, event: &Event, layout: &Layout, start: f64) {
        if self.time.len() > MOST_EVENTS {
            return;
        }
        let (site, layer) = layout.place(event.contact);
        self.time.push(event.time.on_clock(start));
        self.site.push(site as i64);
        self.layer.push(layer as i64);
        self.upper.push(event.barrier == Barrier::Upper);
        self.before.push(event.velocity_before);
        self.after.push(event.velocity_after);
        self.kind.push(match event.kind {
            EventKind::Impact => 0,
            EventKind::Stick => 1,
            EventKind::Release => 2,
        });
    }
}

/// What a run leaves.
struct Recorded {
    events: Events,
    times: Vec<f64>,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    last: State,
    report: Report,
}

impl Course {
    fn run(self, stop: &Stop) -> Result<Recorded, Failure> {
        let Self { model, start, state: (displacement, velocity), psi, looks, end, impacts } = self;
        let mut simulation = Simulation::new(&model, psi, &displacement, &velocity)?;
        let windows = simulation.least_windows(end);
        if windows > MOST_WINDOWS && impacts == u64::MAX {
            return Err(Failure::TooLarge(format!(
                "{} periods of omega = {} take {windows:.0e} windows of flight, the limit is {MOST_WINDOWS:.0e}: give fewer \
                 periods, or max_impacts",
                Short(end.in_periods()),
                Short(model.omega())
            )));
        }
        let (sites, layout) = (model.chain().sites(), model.chain().layout());
        let numbers = looks.len().checked_mul(sites);
        let (mut displacement, mut velocity) = (room(numbers)?, room(numbers)?);
        let (mut events, mut times) = (Events::default(), Vec::new());
        let (mut now, mut speed) = (vec![0.0; sites], vec![0.0; sites]);
        simulation.heed(stop);
        let watched = |time: Time| looks.contains(&time);
        let mut report = None;
        for (place, &target) in looks.iter().chain((!watched(end)).then_some(&end)).enumerate() {
            let told = loop {
                let left = impacts.saturating_sub(simulation.work().impacts);
                let limits = Limits { until: Some(target), impacts: left.min(MANY_IMPACTS), ..Limits::default() };
                let told = simulation.run(&limits, |event| events.push(event, &layout, start));
                if events.time.len() > MOST_EVENTS {
                    return Err(Failure::TooLarge(format!(
                        "a run of more than {MOST_EVENTS} events does not fit into memory: give fewer periods, or max_impacts"
                    )));
                }
                if told.outcome != Outcome::ImpactsReached || left <= MANY_IMPACTS {
                    break told;
                }
            };
            report = Some(told);
            match told.outcome {
                Outcome::TimeReached => {}
                Outcome::Cascade { contact, barrier, bounces } => {
                    return Err(Failure::NotConverged(format!(
                        "site {} has met the {barrier} barrier {bounces} times in a cascade that does not end: with restitution \
                         1 a mass that is pressed against its barrier bounces for ever; give a restitution below 1",
                        layout.name(contact)
                    )));
                }
                _ => break,
            }
            if place < looks.len() {
                simulation.read(&mut now, &mut speed);
                times.push(simulation.time().on_clock(start));
                displacement.extend_from_slice(&now);
                velocity.extend_from_slice(&speed);
            }
        }
        let report = report.ok_or_else(|| Failure::Other("nothing was simulated".to_owned()))?;
        events.words = [EventKind::Impact, EventKind::Stick, EventKind::Release].map(EventKind::name).to_vec();
        Ok(Recorded { events, times, displacement, velocity, last: simulation.state(), report })
    }
}

/// The times of `samples` a period of the force over some periods, both ends included; or those asked for.
fn looks(
    model: &Model,
    start: f64,
    periods: Option<f64>,
    samples: u64,
    times: Option<Vec<f64>>,
) -> Result<(Vec<Time>, Time), Failure> {
    let Some(times) = times else {
        let periods = periods.unwrap_or(20.0);
        if !(periods >= 0.0 && periods.is_finite()) {
            refuse!("periods = {} is out of range: give a number from 0", Short(periods));
        }
        let count = periods * samples as f64;
        let mut all: Vec<Time> = room((count < 1e15).then_some(count as usize))?;
        let sample = |step: u64| Time::new(model, step / samples, (step % samples) as f64 / samples as f64);
        let end = Time::new(model, periods.trunc() as u64, periods.fract());
        if samples > 0 {
            all.extend((0..=count as u64).map(sample));
            all.extend((all.last() != Some(&end)).then_some(end));
        }
        return Ok((all, end));
    };
    let mut before = start;
    let mut all = Vec::new();
    for time in times {
        if !(time >= before && time.is_finite()) {
            let (time, before) = (Short(time), Short(before));
            refuse!("times: {time} comes after {before}: give finite times that rise from the start of the run");
        }
        before = time;
        let part = (time - start) / model.period();
        all.push(Time::new(model, part.trunc() as u64, part.fract()));
    }
    let last = all.last().copied().unwrap_or(Time::new(model, 0, 0.0));
    Ok((all, last))
}

/// A run from a state at the time `start` of its clock.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "one a keyword of vibrochain.simulate")]
pub(crate) fn _simulate<'py>(
    py: Python<'py>,
    model: PyRef<'_, PyModel>,
    start: f64,
    state: (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>),
    psi: f64,
    periods: Option<f64>,
    samples: &Bound<'py, PyAny>,
    times: Option<PyReadonlyArray1<'py, f64>>,
    max_impacts: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let model = model.0;
    let sites = model.chain().sites();
    // An array can be longer than its memory: lengths before copies.
    let one_a_mass = |name, values: &PyReadonlyArray1<'_, f64>| match values.len() {
        found if found == sites => Ok(values.as_array().to_vec()),
        found => Err(Failure::from(StateError::Length { name, found, sites })),
    };
    let state = (one_a_mass("displacement", &state.0)?, one_a_mass("velocity", &state.1)?);
    if let Some(times) = &times {
        room::<f64>(times.len().checked_mul(sites))?;
    }
    let times = times.map(|times| times.as_array().to_vec());
    let samples = whole("samples", samples, 0, 1_000_000)? as u64;
    let most = max_impacts.map(|most| whole("max_impacts", most, 0, i64::MAX)).transpose()?;
    let (looks, end) = looks(&model, start, periods, samples, times)?;
    let course = Course { model, start, state, psi, looks, end, impacts: most.map_or(u64::MAX, |most| most as u64) };
    let Recorded { events, times, displacement, velocity, last, report } =
        long(py, |_| Ok(()), move |stop| course.run(stop))?;
    let run = PyDict::new(py);
    let columns = PyDict::new(py);
    columns.set_item("time", events.time.into_pyarray(py))?;
    columns.set_item("site", events.site.into_pyarray(py))?;
    columns.set_item("layer", events.layer.into_pyarray(py))?;
    columns.set_item("barrier", events.upper.into_pyarray(py))?;
    columns.set_item("velocity_before", events.before.into_pyarray(py))?;
    columns.set_item("velocity_after", events.after.into_pyarray(py))?;
    columns.set_item("kind", (events.kind.into_pyarray(py), events.words))?;
    run.set_item("events", columns)?;
    run.set_item("times", times.into_pyarray(py))?;
    run.set_item("displacement", displacement.into_pyarray(py))?;
    run.set_item("velocity", velocity.into_pyarray(py))?;
    run.set_item("last", (last.displacement.into_pyarray(py), last.velocity.into_pyarray(py)))?;
    run.set_item("end", report.time.on_clock(start))?;
    run.set_item("complete", report.outcome == Outcome::TimeReached)?;
    run.set_item("impacts", report.work.impacts)?;
    Ok(run)
}
