//! `mapgen simulate`: an event-driven run from an orbit or from any state.

pub(crate) mod animate;
pub(crate) mod follow;
pub(crate) mod pace;
pub(crate) mod recorder;
pub mod recording;
pub(crate) mod section;
pub mod start;

use std::fmt::Write as _;

use serde_json::{Value, json};
use vibrochain_breather::{Finder, Orbit};
use vibrochain_eventsim::{Event, Outcome, Report, Simulation};
use vibrochain_fate::{End, LOOKED_AT, Pattern, Witness};
use vibrochain_floquet::{Analyser, Tolerance};
use vibrochain_lattice::{Model, Short, Stop};

use crate::along::{Start, picked};
use crate::args::{Direction, SimulateArgs};
use crate::common::answer::printed;
use crate::common::caption::perturbed;
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::model::{Chosen, chosen};
use crate::common::schemas::SIMULATE;
use crate::common::which;
use crate::simulate::animate::Film;
use crate::simulate::follow::Run;
use crate::simulate::pace::interrupted;
use crate::simulate::recorder::Recorder;
use crate::simulate::recording::{ImpactTable, Plot, Trajectory, orbit_time};
use crate::simulate::section::{Section, Sectioned};
use crate::simulate::start::{Start as State, leading_mode_at};
use crate::structures;
use vibrochain_maps::numbers::Number;

/// Windows of flight that a run may need at least, impacts aside; of a single mass 1e15 are some three years.
const MAX_WINDOWS: f64 = 1e15;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &SimulateArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    if let Some(scene) = structures::asked(&args.model)? {
        return structures::simulate::run(args, &scene, console);
    }
    ensure!(
        !args.in_sequence,
        "--in-sequence is of structures: masses of a chain share no coordinate, and hit at one instant in any order"
    );
    let chosen = chosen(&args.model, console)?;
    let model = chosen.model;
    let args = &args.lasting(model.period())?;
    let taken = follow::checked(args)?;
    let periods = args.periods;
    let stop = (console.interrupt)()?;
    let (start, home) = starting_point(args, &chosen, &stop, console)?;
    let orbit = home.as_ref().map(|home| &home.orbit);
    let mut simulation = Simulation::new(&model, start.psi, &start.displacement, &start.velocity)
        .map_err(|error| CliError::Request(error.to_string()))?;
    let windows = simulation.least_windows(simulation.time_of(periods.trunc() as u64, periods.fract()));
    ensure!(
        windows <= MAX_WINDOWS || args.max_impacts.is_some(),
        "{} is out of range here: a period of omega = {} is so long against the swing of a mass that they take {windows:.0e} windows of flight, the limit is {MAX_WINDOWS:.0e}; give at most {:.0e}, or --max-impacts",
        args.length(),
        Number(model.omega()),
        // Half of it, so that the one digit is not rounded beyond the limit.
        0.5 * periods / windows * MAX_WINDOWS
    );

    let (chain, sites) = (model.chain(), model.chain().sites());
    let impacts = args.impacts.as_deref().map(|path| ImpactTable::open(path, start.time, Some(chain.layout())));
    let mut impacts = impacts.transpose()?;
    let trajectory = args.trajectory.as_deref().map(|path| Trajectory::of_chain(path, start.time, sites));
    let mut trajectory = trajectory.transpose()?;
    let sectioned = Sectioned {
        period: model.period(),
        psi: start.psi,
        start: start.time,
        count: sites,
        home: orbit.map_or(vec![0], Orbit::hit_sites),
        names: ["site", "displacement", "velocity"],
    };
    let mut section = Section::open(args, sectioned)?;
    let mut plot = Plot::open(args, &model, orbit, &start)?;
    let mut film = Film::open(args, &model, orbit)?;

    // Samples if somebody wants them, otherwise the end alone.
    let samples = if trajectory.is_some() || plot.is_some() || film.is_some() { args.samples } else { 0 };
    let pattern = orbit.map(Pattern::of);
    let witness = Witness::new(&model, pattern.as_ref().map(|pattern| (pattern, start.time)));
    let (start, mut ends) = (start.time, Ends { witness, events: 0 });
    let recorders: &mut [&mut dyn Recorder] = &mut [&mut impacts, &mut trajectory, &mut plot, &mut film, &mut ends];
    let mut run = Run { simulation: &mut simulation, section: &mut section, recorders };
    let (report, stopped) = run.follow(args, samples, &stop, console)?;
    // What was simulated is kept, however the run ended.
    impacts.map_or(Ok(()), ImpactTable::finish)?;
    trajectory.map_or(Ok(()), Trajectory::finish)?;
    section.map_or(Ok(()), Section::finish)?;
    plot.map_or(Ok(()), Plot::finish)?;
    film.map_or(Ok(()), Film::finish)?;
    let distance = orbit.map(|orbit| deviation(orbit, &simulation, start)).transpose()?;
    let told = Told {
        args,
        model: &model,
        simulation: &simulation,
        report: &report,
        stopped,
        start,
        home: home.as_ref(),
        fate: ends.witness.outcome(simulation.time()),
        distance,
        events: ends.events,
    };
    let text = if args.json { printed(&told.answer())? } else { told.text(console.verbose) };
    console.answer(&text, args.json, taken)?;
    match report.outcome {
        Outcome::Stopped => Err(interrupted(args, simulation.time())),
        _ if stopped => Err(interrupted(args, simulation.time())),
        Outcome::TimeReached | Outcome::ImpactsReached => Ok(()),
        Outcome::Cascade { contact, barrier, bounces } => Err(CliError::Computation(format!(
            "site {} has met the {barrier} barrier {bounces} times in a cascade that does not end: with restitution 1 a mass that is pressed against its barrier bounces for ever; give a restitution below 1",
            model.chain().layout().name(contact)
        ))),
        // Masses share nothing, and no mode of a chain feeds itself.
        Outcome::WorkLimit | Outcome::Simultaneous { .. } | Outcome::Diverged { .. } => {
            Err(CliError::Computation("the limit on work was reached; simulate fewer periods".to_owned()))
        }
    }
}

/// Why a run ended, in a word of the answers.
pub(crate) fn name_of(outcome: &Outcome) -> &'static str {
    match outcome {
        Outcome::TimeReached => "time-reached",
        Outcome::ImpactsReached => "impacts-reached",
        Outcome::Simultaneous { .. } => "simultaneous",
        Outcome::Cascade { .. } => "cascade",
        Outcome::Diverged { .. } => "diverged",
        Outcome::WorkLimit => "work-limit",
        Outcome::Stopped => "interrupted",
    }
}

/// The state to start from and the orbit to compare with.
fn starting_point(
    args: &SimulateArgs,
    chosen: &Chosen,
    stop: &Stop,
    console: &mut Console<'_>,
) -> Result<(State, Option<Start>), CliError> {
    if let Some(path) = &args.state {
        return Ok((start::read(path, SIMULATE, args.psi)?, None));
    }
    let (model, which) = (&chosen.model, which::wanted(&args.which, chosen.scene.as_ref())?);
    let mut finder = Finder::new(model.chain().sites()).until(stop);
    let orbits = which::some(which::find(&which, model, &mut finder, Some(console))?.1)?;
    let is_physical = |orbit: &Orbit| Ok(finder.admissibility(orbit)?.is_physical());
    let home = picked((orbits, ""), args.solution, is_physical).map_err(|error| match error {
        CliError::IllPosed(none) => CliError::IllPosed(format!("no orbit to start from: {none}")),
        error => error,
    })?;
    if args.solution.is_some() && !finder.admissibility(&home.orbit)?.is_physical() {
        refuse!("solution {} is not physical; `mapgen orbit` tells why", home.number);
    }
    let orbit = &home.orbit;
    let mut start = State::on(orbit)?;
    if let Some(size) = args.perturb {
        ensure!(size.is_finite(), "--perturb {} is out of range: give a finite size", Short(size));
        match args.direction {
            Direction::Random => start.perturb_at_random(model, size, args.seed),
            Direction::Unstable => {
                let verdict = Analyser::default().stability(orbit, &mut finder, Tolerance::Rounding)?.verdict;
                ensure!(
                    !verdict.stable,
                    "--direction unstable: this breather is stable, it has no such direction; use --direction random"
                );
                let mode = leading_mode_at(orbit, start.time, stop)?;
                start.perturb_along(model, size, &mode);
            }
        }
    }
    Ok((start, Some(home)))
}

/// Largest distance of any mass from the orbit, now.
fn deviation(orbit: &Orbit, simulation: &Simulation, start: f64) -> Result<f64, CliError> {
    let (exact, _) = State::states(orbit, orbit_time(orbit, simulation.time(), start))?;
    let masses = simulation.state().displacement.into_iter().zip(exact);
    Ok(masses.map(|(u, exact)| (u - exact).abs()).fold(0.0, f64::max))
}

/// What a run comes to, and how many events it has.
struct Ends<'a> {
    witness: Witness<'a>,
    events: u64,
}

impl Recorder for Ends<'_> {
    fn event(&mut self, event: &Event) {
        self.events += 1;
        self.witness.see(event);
    }
}

/// What is told of a run.
struct Told<'a> {
    args: &'a SimulateArgs,
    model: &'a Model,
    simulation: &'a Simulation,
    report: &'a Report,
    stopped: bool,
    /// Time of the start, on the clock of the orbit.
    start: f64,
    home: Option<&'a Start>,
    fate: vibrochain_fate::Outcome,
    /// From the orbit, at the end.
    distance: Option<f64>,
    events: u64,
}

impl Told<'_> {
    /// As JSON, with the state at the end.
    fn answer(&self) -> Value {
        let (simulation, fate) = (self.simulation, &self.fate);
        let (work, time, state) = (simulation.work(), simulation.time(), simulation.state());
        let outcome = if self.stopped { Outcome::Stopped } else { self.report.outcome };
        let word = match &fate.end {
            Some(End::Periodic(word)) => Some(word.to_string()),
            _ => None,
        };
        // The force repeats: its phase at the end needs no whole periods.
        let psi = (state.psi + time.offset()).rem_euclid(self.model.period());
        json!({
            "schema": SIMULATE,
            "outcome": name_of(&outcome),
            "parameters": self.model,
            "solution": self.home.map(|home| home.number),
            "start": self.start,
            "periods": time.periods(),
            "offset": time.offset(),
            "events": self.events,
            "impacts": work.impacts,
            "sticks": work.sticks,
            "releases": work.releases,
            "energy": simulation.energy(),
            "left": fate.left,
            "end": fate.end.as_ref().map(End::name),
            "word": word,
            "distance": self.distance,
            "state": { "displacement": state.displacement, "velocity": state.velocity, "psi": psi },
        })
    }

    /// For people. Writing to a String cannot fail.
    fn text(&self, verbose: bool) -> String {
        let (work, time, model) = (self.simulation.work(), self.simulation.time(), self.model);
        let mut out = String::new();
        let from = match self.home {
            Some(Start { orbit, number, count }) => format!("{} breather, solution {number} of {count}", orbit.name()),
            None => "from a state".to_owned(),
        };
        let _ = writeln!(out, "{from}{}; {model}", perturbed(self.args));
        let end = match self.report.outcome {
            _ if self.stopped => ", interrupted",
            Outcome::Stopped => ", interrupted",
            Outcome::TimeReached => "",
            Outcome::ImpactsReached => ", number of impacts reached",
            Outcome::Cascade { .. } => ", a cascade of impacts could not be resolved",
            Outcome::WorkLimit | Outcome::Simultaneous { .. } | Outcome::Diverged { .. } => ", limit on work reached",
        };
        let rests = match work.sticks {
            0 => String::new(),
            1 => ", 1 rest on a barrier".to_owned(),
            rests => format!(", {rests} rests on a barrier"),
        };
        let _ = writeln!(out, "{} periods, {} impacts{rests}{end}", pace::periods(time), work.impacts);
        let _ = writeln!(out, "outcome: {}", self.outcome());
        if let Some(distance) = self.distance {
            let clock = if self.may_drift() { ", on its clock" } else { "" };
            let _ = writeln!(out, "largest distance from the orbit at the end{clock}: {distance:.3e}");
        }
        if verbose {
            let _ = writeln!(
                out,
                "events {}, windows of flight {}, restarts {}, bounds {}, masses watched {}, refinements {}",
                self.events, work.windows, work.restarts, work.bounds, work.watched, work.refinements
            );
        }
        out
    }

    /// Whether it began beside the breather without a force: it is then next to another one of the family, whose frequency differs.
    fn may_drift(&self) -> bool {
        self.args.perturb.is_some_and(|size| size != 0.0) && self.model.amplitude() == 0.0
    }

    /// What the run has come to, in a sentence.
    fn outcome(&self) -> String {
        let last = self.simulation.time().periods().min(LOOKED_AT);
        let ends = match &self.fate.end {
            Some(End::Periodic(word)) => format!("its impacts repeat as {word}"),
            Some(End::Quiet) => format!("there is no impact in its last {last} periods"),
            None if self.fate.is_too_short => "it is too short to tell".to_owned(),
            _ => "its impacts do not repeat".to_owned(),
        };
        match (self.home, self.fate.left, &self.fate.end) {
            (Some(_), None, Some(End::Breather)) if self.may_drift() => {
                "its impacts stay those of the breather, while its phase may drift: without a force nothing holds it"
                    .to_owned()
            }
            (Some(_), None, Some(End::Breather)) => "it stays on the breather".to_owned(),
            (Some(_), None, None) => "it stays near the breather".to_owned(),
            (Some(_), Some(left), Some(End::Breather)) => {
                format!("it left the breather after {left:.1} periods and has come back to it")
            }
            (Some(_), Some(left), _) => format!("it left the breather after {left:.1} periods; at the end {ends}"),
            _ => ends,
        }
    }
}
