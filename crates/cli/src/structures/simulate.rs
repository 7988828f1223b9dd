//! `mapgen simulate` of a structure: every impact from a state or an orbit on, and what the run settles on.

use serde::Deserialize;
use vibrochain_breather::{StructureModel, StructureMotion, StructureOrbit, structure_admissibility};
use vibrochain_eventsim::{
    ContactEvent, EventKind, Limits, StructureOutcome, StructureReport, StructureSimulation, StructureState, Time,
};
use vibrochain_lattice::Stop;
use vibrochain_maps::files::{CsvFile, Output, distinct, promises};
use vibrochain_maps::numbers::Number;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::text::read_text;

use super::orbit::{columns, found};
use super::run_answer::{MOST_PERIODS, REPETITIONS, answer, energy_text, settled, text};
use super::run_plot::RunPlot;
use crate::args::SimulateArgs;
use crate::common::console::{Console, nothing_else};
use crate::common::error::CliError;
use crate::simulate::pace::interrupted;
use crate::simulate::section::{Section, Sectioned};

/// The most bytes of a state.
const MOST_BYTES: u64 = 16 << 20;

/// Flights between two looks at a request to stop.
const FLIGHTS: u64 = 20_000;

/// Runs the subcommand for a structure.
///
/// # Errors
/// [`CliError`].
pub(crate) fn run(args: &SimulateArgs, scene: &StructureScene, console: &mut Console<'_>) -> Result<(), CliError> {
    let others = [("animate", args.animate.is_some()), ("perturb", args.perturb.is_some())];
    if let Some((flag, _)) = others.iter().find(|(_, given)| *given) {
        let message = format!(
            "--{flag} is of chains without dashpots: a structure's run has --impacts, --trajectory, --section, --plot and --json"
        );
        return Err(CliError::Request(message));
    }
    if !(1..=1_000_000).contains(&args.samples) {
        let message = format!("--samples {} is out of range: give a whole number from 1 to 1000000", args.samples);
        return Err(CliError::Request(message));
    }
    let periods = args.periods;
    if !(0.0..1e15).contains(&periods) {
        return Err(CliError::Request(format!("--periods {periods} is out of range: give a number from 0 to 1e15")));
    }
    let taken = distinct(
        &[
            ("--scene", args.model.scene.as_deref()),
            ("--state", args.state.as_deref()),
            ("--near", args.which.near.as_deref()),
        ],
        &[
            ("--impacts", args.impacts.as_deref()),
            ("--trajectory", args.trajectory.as_deref()),
            ("--section", args.section.as_deref()),
            ("--plot", args.plot.as_deref()),
        ],
    )?;
    nothing_else(args.json, taken)?;
    args.impacts.as_deref().map(|path| promises("--impacts", path, "a table", &["csv"])).transpose()?;
    let model = scene.model().map_err(CliError::Request)?;
    let Start { psi, modes, from, orbit } = start(args, scene, &model)?;
    let structure = (**model.structure()).clone();
    let simulation = StructureSimulation::new(structure, model.omega(), psi, &modes);
    let mut simulation = simulation.map_err(|error| CliError::Request(error.to_string()))?;
    // Keeping account costs more than the flights.
    let form = if console.verbose { scene.energy_form().map_err(CliError::Request)? } else { None };
    let before = form.as_ref().map_or(0.0, |form| form.energy(&modes));
    if let Some(form) = &form {
        simulation = simulation.with_balance(form.clone());
    }
    let stop = (console.interrupt)()?;
    let table = args.impacts.as_deref().map(Output::create).transpose()?;
    let trajectory = args.trajectory.as_deref();
    let trajectory = trajectory.map(|path| CsvFile::create("--trajectory", path, columns(&model))).transpose()?;
    let hit = orbit.as_ref().map_or(vec![0], |(orbit, _)| {
        let mut hit: Vec<usize> = orbit.impacts().iter().map(|impact| impact.contact).collect();
        hit.sort_unstable();
        hit.dedup();
        hit
    });
    let section = Sectioned {
        period: model.period(),
        psi,
        start: 0.0,
        count: model.structure().contacts().len(),
        home: hit.clone(),
        names: ["contact", "contact", "contact_velocity"],
    };
    let section = Section::open(args, section)?;
    let plot = RunPlot::open(args, scene, &model, (&from, hit[0]), orbit)?;
    let mut kept = Kept { trajectory, section, plot, ..Kept::new(table)? };
    let report = match sampled(&mut simulation, args, &stop, &mut kept) {
        // What was simulated is kept.
        Err(CliError::Interrupted) => {
            kept.finish()?;
            return Err(interrupted(args, simulation.time()));
        }
        report => report?,
    };
    kept.finish()?;
    let rests = simulation.state().contacts.iter().any(|contact| contact.resting.is_some());
    let settled = settled(&model, psi, &kept.events, report.time, rests);
    let told = if args.json {
        let value = answer(scene, &model, psi, &report, kept.counts, &settled);
        format!("{value:#}\n")
    } else {
        let mut told = text(&model, &from, &report, kept.counts, &settled);
        if let (Some(form), Some(balance)) = (&form, simulation.balance()) {
            told.push_str(&energy_text([before, form.energy(&simulation.state().modes)], &balance));
        }
        told
    };
    console.answer(&told, args.json, taken)
}

/// The run, looked at once a sample where somebody wants that, and where the section does.
fn sampled(
    simulation: &mut StructureSimulation,
    args: &SimulateArgs,
    stop: &Stop,
    kept: &mut Kept,
) -> Result<StructureReport, CliError> {
    let (periods, samples) = (args.periods, args.samples);
    let end = simulation.time_of(periods as u64, periods.fract());
    let steps = if kept.is_sampled() { (periods * samples as f64) as u64 } else { 0 };
    let mut step = 0;
    kept.look(simulation)?;
    loop {
        step += 1;
        let is_last = step > steps;
        let until =
            if is_last { end } else { simulation.time_of(step / samples, (step % samples) as f64 / samples as f64) };
        while let Some(due) = kept.section.as_ref().and_then(|section| section.due(until)) {
            let report = follow(simulation, due, args.max_impacts, stop, kept)?;
            if report.outcome != StructureOutcome::TimeReached {
                return Ok(report);
            }
            let contacts = simulation.state().contacts;
            let (places, velocities): (Vec<f64>, Vec<f64>) =
                contacts.iter().map(|contact| (contact.place, contact.velocity)).unzip();
            kept.section.iter_mut().try_for_each(|section| section.look(due, &places, &velocities))?;
        }
        let report = follow(simulation, until, args.max_impacts, stop, kept)?;
        // The last sample is at the end, once.
        let is_double = is_last && steps > 0 && (periods * samples as f64).fract() == 0.0;
        if !is_double {
            kept.look(simulation)?;
        }
        if is_last || report.outcome != StructureOutcome::TimeReached {
            return Ok(report);
        }
    }
}

/// Where a run begins.
struct Start {
    psi: f64,
    modes: Vec<[f64; 2]>,
    /// In words.
    from: String,
    /// The orbit, and the time on its clock.
    orbit: Option<(StructureOrbit, f64)>,
}

/// The phase of the loads, the modes' coordinates, and from where the run begins.
fn start(args: &SimulateArgs, scene: &StructureScene, model: &StructureModel) -> Result<Start, CliError> {
    let of_no_orbit = |psi, modes, from| Ok(Start { psi, modes, from, orbit: None });
    if let Some(path) = &args.state {
        #[derive(Deserialize)]
        struct State {
            displacement: Vec<f64>,
            velocity: Vec<f64>,
            #[serde(default)]
            psi: f64,
        }
        let text = read_text("the state", path, MOST_BYTES)?;
        let state: State =
            serde_json::from_str(&text).map_err(|error| CliError::Request(format!("{}: {error}", path.display())))?;
        let modes = scene.modes_of(&state.displacement, &state.velocity);
        let modes = modes.map_err(|why| CliError::Request(format!("{}: {why}", path.display())))?;
        return of_no_orbit(args.psi.unwrap_or(state.psi), modes, format!("the state of {}", path.display()));
    }
    let named = args.which.family.is_some() || args.which.word.is_some() || args.which.near.is_some();
    if !named && scene.word.is_none() {
        let (psi, modes) = (args.psi.unwrap_or(0.0), model.structure().still());
        return of_no_orbit(psi, modes, "rest under the static load".to_owned());
    }
    let (found, word, _) = found(&args.which, scene, model)?;
    let orbit = match args.solution {
        Some(number) => found.orbits.get(number.wrapping_sub(1)).ok_or_else(|| {
            CliError::Request(format!("--solution {number} does not exist: {word} has {} here", found.orbits.len()))
        })?,
        None => {
            let physical =
                |orbit: &&StructureOrbit| structure_admissibility(orbit).is_ok_and(|answer| answer.is_physical());
            let first = found.orbits.iter().find(physical);
            first.ok_or_else(|| CliError::IllPosed(format!("{word} has no physical orbit here to start on")))?
        }
    };
    // In the flight before the first impact.
    let motion = StructureMotion::new(orbit)?;
    let last = orbit.impacts().len() - 1;
    let lapse = 0.5 * motion.until_next(last);
    let time = orbit.impacts()[last].time + lapse;
    let (psi, modes) = (orbit.psi().unwrap_or(0.0) + time, motion.modes(last, lapse)?);
    Ok(Start { psi, modes, from: format!("the orbit {word}"), orbit: Some((orbit.clone(), time)) })
}

/// What is kept of a run: the table's rows as they come, counts, and the events of as many periods as may repeat.
struct Kept {
    table: Option<csv::Writer<Output>>,
    trajectory: Option<CsvFile>,
    section: Option<Section>,
    plot: RunPlot,
    counts: [usize; 3],
    events: Vec<ContactEvent>,
}

/// Events are thinned out once there are this many.
const MANY: usize = 1 << 16;

impl Kept {
    fn new(table: Option<Output>) -> Result<Self, CliError> {
        let mut table = table.map(csv::Writer::from_writer);
        if let Some(table) = &mut table {
            let names = ["time", "contact", "barrier", "velocity_before", "velocity_after", "impulse", "kind"];
            table.write_record(names).map_err(unwritten)?;
        }
        let (trajectory, section, plot) = (None, None, RunPlot::default());
        Ok(Self { table, trajectory, section, plot, counts: [0; 3], events: Vec::new() })
    }

    fn is_sampled(&self) -> bool {
        self.trajectory.is_some() || self.plot.is_wanted()
    }

    /// Takes a sample.
    fn look(&mut self, simulation: &StructureSimulation) -> Result<(), CliError> {
        if !self.is_sampled() {
            return Ok(());
        }
        let StructureState { place, velocity, contacts, time, .. } = simulation.state();
        self.plot.look(time, &contacts)?;
        let Some(table) = &mut self.trajectory else { return Ok(()) };
        let (places, velocities) = contacts.iter().map(|contact| (contact.place, contact.velocity)).unzip();
        let all: [Vec<f64>; 5] = [vec![time.to_f64()], places, velocities, place, velocity];
        Ok(table.row(all.iter().flatten().map(f64::to_string))?)
    }

    fn take(&mut self, event: &ContactEvent) -> Result<(), CliError> {
        let place = match event.kind {
            EventKind::Impact => 0,
            EventKind::Stick => 1,
            EventKind::Release => 2,
        };
        self.counts[place] += 1;
        if event.kind == EventKind::Impact {
            self.plot.hit(event);
            let velocities = [event.velocity_before, event.velocity_after];
            if let Some(section) = &mut self.section {
                section.hit(event.time, event.contact, event.barrier, velocities);
                section.failed().map_or(Ok(()), Err)?;
            }
        }
        if let Some(table) = &mut self.table {
            let number = |x: f64| Number(x).to_string();
            let row = [
                number(event.time.to_f64()),
                event.contact.to_string(),
                event.barrier.name().to_owned(),
                number(event.velocity_before),
                number(event.velocity_after),
                number(event.impulse),
                event.kind.name().to_owned(),
            ];
            table.write_record(row).map_err(unwritten)?;
        }
        if self.events.len() >= MANY {
            // So often the longest pattern, and the period under way.
            let from = event.time.periods().saturating_sub(REPETITIONS * MOST_PERIODS + 1);
            self.events.retain(|event| event.time.periods() >= from);
            if self.events.len() >= MANY {
                // So many impacts a period repeat nothing that is worth a word.
                self.events.drain(..MANY / 2);
            }
        }
        self.events.push(*event);
        Ok(())
    }

    fn finish(&mut self) -> Result<(), CliError> {
        self.trajectory.take().map_or(Ok(()), CsvFile::finish)?;
        self.section.take().map_or(Ok(()), Section::finish)?;
        std::mem::take(&mut self.plot).finish()?;
        let Some(table) = self.table.take() else { return Ok(()) };
        let file = table.into_inner().map_err(|error| CliError::Computation(error.to_string()))?;
        Ok(file.commit()?)
    }
}

fn unwritten(error: csv::Error) -> CliError {
    CliError::Computation(error.to_string())
}

/// The run, looked at for a request to stop.
fn follow(
    simulation: &mut StructureSimulation,
    until: Time,
    most: Option<u64>,
    stop: &Stop,
    kept: &mut Kept,
) -> Result<StructureReport, CliError> {
    loop {
        let left = most.map_or(u64::MAX, |most| most.saturating_sub(kept.counts[0] as u64));
        let limits = Limits { until: Some(until), impacts: left, flights: FLIGHTS, ..Limits::default() };
        let mut failed = Ok(());
        let report = simulation.run(&limits, |event| {
            if failed.is_ok() {
                failed = kept.take(event);
            }
        });
        failed?;
        if stop.is_raised() {
            return Err(CliError::Interrupted);
        }
        if report.outcome != StructureOutcome::WorkLimit {
            return Ok(report);
        }
    }
}
