//! `mapgen simulate` of a structure: every impact from a state or an orbit on, and what the run settles on.

use vibrochain_breather::{ContactMotion, LoadedStructure, Orbit, admissibility};
use vibrochain_eventsim::{Event, Simulation};
use vibrochain_maps::structure::{Setting, StructureScene};

use super::orbit::{OfWord, columns, found};
use super::run_answer::{End, MOST_PERIODS, REPETITIONS, answer, energy_text, settled, text};
use super::run_plot::RunPlot;
use crate::args::SimulateArgs;
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::schemas::STRUCTURE_RUN;
use crate::simulate::follow::{Run, checked};
use crate::simulate::pace::interrupted;
use crate::simulate::recorder::Recorder;
use crate::simulate::recording::{ImpactTable, Trajectory};
use crate::simulate::section::{Section, Sectioned};
use crate::simulate::start::{Start as Given, of_no_file, read};

/// Periods of a run, of which there are fewer.
const MOST: f64 = 1e15;

/// Runs the subcommand for a structure.
///
/// # Errors
/// [`CliError`].
pub(crate) fn run(args: &SimulateArgs, scene: &StructureScene, console: &mut Console<'_>) -> Result<(), CliError> {
    let others = [("animate", args.animate.is_some()), ("perturb", args.perturb.is_some())];
    if let Some((flag, _)) = others.iter().find(|(_, given)| *given) {
        refuse!("--{flag} is of lattices: a structure's run has --impacts, --trajectory, --section, --plot and --json");
    }
    let (model, has_period) = model(args, scene)?;
    let args = &args.lasting(model.period())?;
    ensure!(args.periods < MOST, "{} is out of range: give at most {MOST:e} periods", args.length());
    let taken = checked(args)?;
    let Start { psi, modes, from, orbit } = start(args, scene, &model)?;
    let simulation = Simulation::of_modes(model.structure().clone(), model.omega(), psi, &modes);
    let mut simulation = simulation.map_err(|error| CliError::Request(error.to_string()))?;
    if args.in_sequence || scene.in_sequence {
        simulation = simulation.in_sequence();
    }
    if console.verbose {
        console.remark(&simulation.flight().to_string());
    }
    // Keeping account costs more than the flights.
    let form = if console.verbose { scene.energy_form()? } else { None };
    let before = form.as_ref().map_or(0.0, |form| form.energy(&modes));
    if let Some(form) = &form {
        simulation = simulation.with_balance(form.clone());
    }
    let stop = (console.interrupt)()?;
    let mut table = args.impacts.as_deref().map(|path| ImpactTable::open(path, 0.0, None)).transpose()?;
    let trajectory = args.trajectory.as_deref().map(|path| Trajectory::of_structure(path, columns(&model)));
    let mut trajectory = trajectory.transpose()?;
    let hit = orbit.as_ref().map_or(vec![0], |(orbit, _)| {
        let mut hit: Vec<usize> = orbit.impacts().iter().map(|impact| impact.site).collect();
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
    let mut section = Section::open(args, section)?;
    let mut plot = RunPlot::open(args, scene, (&model, has_period), (&from, hit[0]), orbit)?;
    let samples = if trajectory.is_some() || plot.is_some() { args.samples } else { 0 };
    let mut latest = Latest::default();
    let recorders: &mut [&mut dyn Recorder] = &mut [&mut table, &mut trajectory, &mut plot, &mut latest];
    let mut run = Run { simulation: &mut simulation, section: &mut section, recorders };
    let (report, stopped) = run.follow(args, samples, &stop, console)?;
    let Latest { counts, events } = latest;
    // What was simulated is kept.
    trajectory.map_or(Ok(()), Trajectory::finish)?;
    section.map_or(Ok(()), Section::finish)?;
    plot.map_or(Ok(()), RunPlot::finish)?;
    table.map_or(Ok(()), ImpactTable::finish)?;
    if stopped {
        return Err(interrupted(args, simulation.time()));
    }
    let rests = simulation.contacts().iter().any(|contact| contact.resting.is_some());
    let settled = if has_period {
        let settled = settled(&model, psi, &events, (report.time, rests), &stop);
        settled.map_err(|_| interrupted(args, simulation.time()))?
    } else if rests {
        End::AtRest
    } else {
        End::Untold
    };
    let told = if args.json {
        let value = answer(scene, (&model, has_period), psi, &report, &simulation.state(), counts, &settled);
        format!("{value:#}\n")
    } else {
        let mut told = text((&model, has_period), &from, &report, counts, &settled);
        if let (Some(form), Some(balance)) = (&form, simulation.balance()) {
            told.push_str(&energy_text([before, form.energy(&simulation.state().modes)], &balance));
        }
        told
    };
    console.answer(&told, args.json, taken)
}

/// A run of a structure in which nothing has a period lasts so many, as many as its picture shows.
const PARTS: f64 = 8.0;

/// The model, and whether anything has a period: without a load and a frequency the run is divided into parts instead.
fn model(args: &SimulateArgs, scene: &StructureScene) -> Result<(LoadedStructure, bool), CliError> {
    let which = &args.which;
    let on_orbit = which.family.is_some() || which.word.is_some() || which.near.is_some() || scene.word.is_some();
    let from_orbit = on_orbit && args.state.is_none();
    if scene.omega().is_some() || from_orbit || scene.structure()?.is_forced() {
        return Ok((scene.model()?, true));
    }
    let Some(time) = args.time.filter(|time| (0.0..=f64::MAX).contains(time)) else {
        // What is out of range is told with its flag.
        args.lasting(1.0)?;
        refuse!("nothing here has a period, there is neither a load nor omega: give --time, the length of the run");
    };
    ensure!(args.section.is_none(), "--section takes phases of a load, and there is none: give omega, or --impacts");
    let mut scene = scene.clone();
    scene.set(Setting::Omega, std::f64::consts::TAU * if time > 0.0 { PARTS / time } else { 1.0 })?;
    Ok((scene.model()?, false))
}

/// Where a run begins.
struct Start {
    psi: f64,
    modes: Vec<[f64; 2]>,
    /// In words.
    from: String,
    /// The orbit, and the time on its clock.
    orbit: Option<(Orbit, f64)>,
}

/// The phase of the loads, the modes' coordinates, and from where the run begins.
fn start(args: &SimulateArgs, scene: &StructureScene, model: &LoadedStructure) -> Result<Start, CliError> {
    let of_no_orbit = |psi, modes, from| Ok(Start { psi, modes, from, orbit: None });
    if let Some(path) = &args.state {
        let Given { displacement, velocity, psi, .. } = read(path, STRUCTURE_RUN, args.psi)?;
        let modes = scene.modes_of(&displacement, &velocity);
        let name = if of_no_file(path).is_some() { "given".into() } else { format!("of {}", path.display()) };
        let modes = modes.map_err(|why| CliError::Request(format!("the state {name}: {why}")))?;
        return of_no_orbit(psi, modes, format!("the state {name}"));
    }
    let named = args.which.family.is_some() || args.which.word.is_some() || args.which.near.is_some();
    if !named && scene.word.is_none() {
        let (psi, modes) = (args.psi.unwrap_or(0.0), model.structure().still());
        return of_no_orbit(psi, modes, "rest under the static load".to_owned());
    }
    let OfWord { found, word, .. } = found(&args.which, scene, model)?;
    let orbit = match args.solution {
        Some(number) => found.orbits.get(number.wrapping_sub(1)).ok_or_else(|| {
            CliError::Request(format!("--solution {number} does not exist: {word} has {} here", found.orbits.len()))
        })?,
        None => {
            let physical = |orbit: &&Orbit| admissibility(orbit).is_ok_and(|answer| answer.is_physical());
            let first = found.orbits.iter().find(physical);
            first.ok_or_else(|| CliError::IllPosed(format!("{word} has no physical orbit here to start on")))?
        }
    };
    // In the flight before the first impact.
    let contacts = orbit.at_contacts(model.stop())?;
    let motion = ContactMotion::new(&contacts)?;
    let last = orbit.impacts().len() - 1;
    let lapse = 0.5 * motion.until_next(last);
    let time = orbit.impacts()[last].time + lapse;
    let (psi, modes) = (orbit.psi().unwrap_or(0.0) + time, motion.modes(last, lapse)?);
    Ok(Start { psi, modes, from: format!("the orbit {word}"), orbit: Some((orbit.clone(), time)) })
}

/// Counts of a run, and the events of as many periods as may repeat.
#[derive(Default)]
struct Latest {
    counts: [usize; 3],
    events: Vec<Event>,
}

/// Events are thinned out once there are this many.
const MANY: usize = 1 << 16;

impl Recorder for Latest {
    fn event(&mut self, event: &Event) {
        let Self { counts, events } = self;
        counts[event.kind as usize] += 1;
        if events.len() >= MANY {
            // So often the longest pattern, and the period under way.
            let from = event.time.periods().saturating_sub(REPETITIONS * MOST_PERIODS + 1);
            events.retain(|event| event.time.periods() >= from);
            if events.len() >= MANY {
                // So many impacts a period repeat nothing that is worth a word.
                events.drain(..MANY / 2);
            }
        }
        events.push(*event);
    }
}
