//! `mapgen simulate`: an event-driven run from an orbit or from any state.

use std::fmt::Write as _;
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use vibrochain_breather::{Finder, Found, Motion, Orbit};
use vibrochain_eventsim::{Event, Limits, Outcome, Simulation, Time};
use vibrochain_lattice::Model;

use crate::args::{Direction, SimulateArgs};
use crate::error::CliError;
use crate::orbit_command::{family, model};
use crate::output::Output;
use crate::start::{Start, leading_mode_at};

/// Steps of a run that writes no samples: often enough for a progress bar and Ctrl-C.
const STEPS: u64 = 400;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &SimulateArgs) -> Result<(), CliError> {
    let model = model(&args.model)?;
    if args.samples == 0 || args.samples > 1_000_000 {
        let message = format!("--samples {} is out of range: give a whole number from 1 to 1000000", args.samples);
        return Err(CliError::Request(message));
    }
    let (start, orbit) = starting_point(args, &model)?;
    let mut simulation = Simulation::new(&model, start.psi, &start.displacement, &start.velocity)
        .map_err(|error| CliError::Request(error.to_string()))?;

    let mut impacts = args.impacts.as_deref().map(|path| ImpactTable::open(path, start.time)).transpose()?;
    let mut trajectory =
        args.trajectory.as_deref().map(|path| Trajectory::open(path, start.time, &model)).transpose()?;
    let mut plot = Plot::open(args, &model, orbit.as_ref(), &start)?;
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed))
        .map_err(|error| CliError::Computation(format!("cannot listen for Ctrl-C: {error}")))?;

    // Samples a period if somebody wants them, otherwise a step of whole periods.
    let sampled = trajectory.is_some() || plot.is_wanted();
    let (per_period, stride) = if sampled { (args.samples, 1) } else { (1, args.periods.div_ceil(STEPS).max(1)) };
    let bar = progress(args.periods);
    let mut counts = Counts::default();
    let mut report = simulation.run(&Limits::until(Time::new(&model, 0, 0.0)), |event| counts.see(event, &mut impacts));
    let mut step = 0_u64;
    let mut stopped = false;
    loop {
        trajectory.iter_mut().try_for_each(|trajectory| trajectory.write(&simulation))?;
        plot.see(&simulation);
        if let Some(error) = impacts.as_mut().and_then(|table| table.failure.take()) {
            return Err(error);
        }
        bar.set_position(report.time.periods());
        stopped = stopped || stop.load(Ordering::Relaxed);
        if stopped || report.outcome != Outcome::TimeReached || step >= args.periods * per_period {
            break;
        }
        step = (step + stride).min(args.periods * per_period);
        let time = Time::new(&model, step / per_period, (step % per_period) as f64 / per_period as f64);
        let left = args.max_impacts.map_or(u64::MAX, |most| most.saturating_sub(report.work.impacts));
        let limits = Limits { until: Some(time), impacts: left, ..Limits::default() };
        report = simulation.run(&limits, |event| counts.see(event, &mut impacts));
    }
    bar.finish_and_clear();

    // What was simulated is kept, however the run ended.
    impacts.map_or(Ok(()), ImpactTable::finish)?;
    trajectory.map_or(Ok(()), Trajectory::finish)?;
    plot.finish()?;
    let mut text = counts.summary(&simulation, report.outcome, stopped);
    if let Some(orbit) = &orbit {
        let distance = deviation(orbit, &simulation, start.time)?;
        let _ = writeln!(text, "largest distance from the orbit at the end: {distance:.3e}");
    }
    std::io::stdout()
        .write_all(text.as_bytes())
        .map_err(|error| CliError::Computation(format!("cannot write to standard output: {error}")))?;
    match report.outcome {
        _ if stopped => Err(CliError::Stopped),
        Outcome::TimeReached | Outcome::ImpactsReached => Ok(()),
        Outcome::Cascade { site, barrier, bounces } => Err(CliError::Computation(format!(
            "site {site} has met the {} barrier {bounces} times in a cascade that does not end: with restitution 1 a mass that is pressed against its barrier bounces for ever; give a restitution below 1",
            barrier.name()
        ))),
        Outcome::WorkLimit => {
            Err(CliError::Computation("the limit on work was reached; simulate fewer periods".to_owned()))
        }
    }
}

/// The state to start from and the orbit to compare with.
fn starting_point(args: &SimulateArgs, model: &Model) -> Result<(Start, Option<Orbit>), CliError> {
    if let Some(path) = &args.state {
        return Ok((Start::read(path, args.psi.unwrap_or(0.0))?, None));
    }
    let Some(name) = args.family else {
        return Err(CliError::Request("nothing to start from: give --family or --state FILE".to_owned()));
    };
    let computation = |error: &dyn std::fmt::Display| CliError::Computation(error.to_string());
    let mut finder = Finder::new(model.chain().sites());
    let mut found = Found::default();
    finder.find(model, family(name), &mut found).map_err(|error| computation(&error))?;
    let count = found.orbits.len();
    let mut chosen = None;
    for (i, orbit) in found.orbits.drain(..).enumerate() {
        let physical = finder.admissibility(&orbit).map_err(|error| computation(&error))?.is_physical();
        if args.solution.map_or(physical, |number| number == i + 1) {
            chosen = Some((orbit, physical));
            break;
        }
    }
    let orbit = match (chosen, args.solution, found.none) {
        (Some((orbit, true)), _, _) => orbit,
        (Some((_, false)), Some(number), _) => {
            return Err(CliError::Request(format!("solution {number} is not physical; `mapgen orbit` tells why")));
        }
        (_, Some(number), None) if count > 0 => {
            return Err(CliError::Request(format!(
                "--solution {number} is out of range: there are {count}, give 1 to {count}"
            )));
        }
        (_, _, Some(reason)) => return Err(CliError::Computation(format!("no orbit to start from: {reason}"))),
        _ => {
            return Err(CliError::Computation(format!(
                "no orbit to start from: none of {count} solutions is physical"
            )));
        }
    };
    let mut start = Start::on(&orbit)?;
    if let Some(size) = args.perturb {
        if !size.is_finite() {
            return Err(CliError::Request(format!("--perturb {size} is out of range: give a finite size")));
        }
        match args.direction {
            Direction::Random => start.perturb_at_random(model, size, args.seed),
            Direction::Unstable => {
                let mode = leading_mode_at(&orbit, start.time).map_err(|error| computation(&error))?;
                start.perturb_along(model, size, &mode);
            }
        }
    }
    Ok((start, Some(orbit)))
}

/// Largest distance of any mass from the orbit, now.
fn deviation(orbit: &Orbit, simulation: &Simulation, start: f64) -> Result<f64, CliError> {
    let mut motion = Motion::of(orbit).map_err(|error| CliError::Computation(error.to_string()))?;
    motion.at(0, orbit_time(orbit, simulation.time(), start));
    let state = simulation.state();
    let masses = state.displacement.iter().enumerate();
    Ok(masses.map(|(n, u)| (u - motion.site(n).displacement).abs()).fold(0.0, f64::max))
}

/// The time on an orbit's own clock: whole periods are taken off before they cost digits.
pub(crate) fn orbit_time(orbit: &Orbit, time: Time, start: f64) -> f64 {
    let periods = time.periods() % u64::from(orbit.force_periods());
    periods as f64 * orbit.model().period() + time.offset() + start
}

fn progress(periods: u64) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(periods);
    if let Ok(style) =
        ProgressStyle::with_template("{bar:32} {percent:>3}%  {human_pos}/{human_len} periods  {eta} left")
    {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Events seen.
#[derive(Debug, Default)]
struct Counts {
    events: u64,
}

impl Counts {
    fn see(&mut self, event: &Event, table: &mut Option<ImpactTable>) {
        self.events += 1;
        if let Some(table) = table {
            table.write(event);
        }
    }

    fn summary(&self, simulation: &Simulation, outcome: Outcome, stopped: bool) -> String {
        let (work, time) = (simulation.work(), simulation.time());
        let how = match outcome {
            _ if stopped => "interrupted",
            Outcome::TimeReached => "time reached",
            Outcome::ImpactsReached => "number of impacts reached",
            Outcome::Cascade { .. } => "a cascade of impacts could not be resolved",
            Outcome::WorkLimit => "limit on work reached",
        };
        format!(
            "{how} after {} periods and {:.6} of one ({} events)\n\
             impacts {}, sticks {}, releases {}\n\
             windows of flight {}, restarts {}, bounds {}, masses watched {}, refinements {}\n",
            time.periods(),
            time.part(),
            self.events,
            work.impacts,
            work.sticks,
            work.releases,
            work.windows,
            work.restarts,
            work.bounds,
            work.watched,
            work.refinements
        )
    }
}

fn unwritable(path: &Path, error: &dyn std::fmt::Display) -> CliError {
    CliError::Computation(format!("could not write {}: {error}", path.display()))
}

/// `time,site,barrier,velocity_before,velocity_after,kind`, one row a mass.
struct ImpactTable {
    writer: csv::Writer<Output>,
    path: std::path::PathBuf,
    start: f64,
    failure: Option<CliError>,
}

impl ImpactTable {
    fn open(path: &Path, start: f64) -> Result<Self, CliError> {
        let mut writer = csv::Writer::from_writer(Output::create(path)?);
        let header = ["time", "site", "barrier", "velocity_before", "velocity_after", "kind"];
        writer.write_record(header).map_err(|error| unwritable(path, &error))?;
        Ok(Self { writer, path: path.to_owned(), start, failure: None })
    }

    fn write(&mut self, event: &Event) {
        let row = [
            (self.start + event.time.to_f64()).to_string(),
            event.site.to_string(),
            event.barrier.name().to_owned(),
            event.velocity_before.to_string(),
            event.velocity_after.to_string(),
            event.kind.name().to_owned(),
        ];
        if let Err(error) = self.writer.write_record(row) {
            self.failure.get_or_insert(unwritable(&self.path, &error));
        }
    }

    fn finish(self) -> Result<(), CliError> {
        self.writer.into_inner().map_err(|error| unwritable(&self.path, error.error()))?.commit()
    }
}

/// `time,displacement_0,…,velocity_0,…`, one row a sample.
struct Trajectory {
    writer: csv::Writer<Output>,
    path: std::path::PathBuf,
    start: f64,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
}

impl Trajectory {
    fn open(path: &Path, start: f64, model: &Model) -> Result<Self, CliError> {
        let sites = model.chain().sites();
        let mut writer = csv::Writer::from_writer(Output::create(path)?);
        let columns = |name: &'static str| (0..sites).map(move |n| format!("{name}_{n}"));
        let header = std::iter::once("time".to_owned()).chain(columns("displacement")).chain(columns("velocity"));
        writer.write_record(header).map_err(|error| unwritable(path, &error))?;
        Ok(Self { writer, path: path.to_owned(), start, displacement: vec![0.0; sites], velocity: vec![0.0; sites] })
    }

    fn write(&mut self, simulation: &Simulation) -> Result<(), CliError> {
        simulation.read(&mut self.displacement, &mut self.velocity);
        let time = self.start + simulation.time().to_f64();
        let row = std::iter::once(&time).chain(&self.displacement).chain(&self.velocity).map(f64::to_string);
        self.writer.write_record(row).map_err(|error| unwritable(&self.path, &error))
    }

    fn finish(self) -> Result<(), CliError> {
        self.writer.into_inner().map_err(|error| unwritable(&self.path, error.error()))?.commit()
    }
}

#[cfg(feature = "plot")]
use with_plot::Plot;
#[cfg(not(feature = "plot"))]
use without_plot::Plot;

#[cfg(feature = "plot")]
mod with_plot {
    use vibrochain_breather::{Motion, Orbit};
    use vibrochain_eventsim::Simulation;
    use vibrochain_lattice::Model;

    use super::{CliError, Output, SimulateArgs, Start, orbit_time};
    use crate::plot::{Format, RunPicture, run_picture};

    /// Columns of the space–time picture.
    const COLUMNS: u64 = 1000;

    /// Periods at the end of the run of which the impacting mass is shown.
    const SHOWN: u64 = 8;

    /// Collects what the picture needs, and no more of a long run.
    pub(super) struct Plot(Option<Collected>);

    struct Collected {
        format: Format,
        file: Output,
        picture: RunPicture,
        orbit: Option<(Orbit, Motion)>,
        home: usize,
        start: f64,
        stride: u64,
        from_period: u64,
        seen: u64,
        scratch: (Vec<f64>, Vec<f64>),
    }

    impl Plot {
        pub(super) fn open(
            args: &SimulateArgs,
            model: &Model,
            orbit: Option<&Orbit>,
            start: &Start,
        ) -> Result<Self, CliError> {
            let Some(path) = &args.plot else { return Ok(Self(None)) };
            let Some(format) = Format::of(path) else {
                let message = format!(
                    "--plot {}: the kind of picture is not known; end the name in .png or .svg",
                    path.display()
                );
                return Err(CliError::Request(message));
            };
            let motion = orbit.map(|orbit| Motion::of(orbit).map(|motion| (orbit.clone(), motion))).transpose();
            let motion = motion.map_err(|error| CliError::Computation(error.to_string()))?;
            let sites = model.chain().sites();
            let force = if model.is_conservative() {
                String::new()
            } else {
                format!(", A = {}, e = {}", model.amplitude(), model.restitution())
            };
            let title = format!(
                "N = {}, γ₁ = {}, γ₂ = {}, ω = {}, a = {}{force}",
                sites - 1,
                model.chain().gamma1(),
                model.chain().gamma2(),
                model.omega(),
                model.asymmetry()
            );
            let picture = RunPicture {
                title,
                barriers: (model.asymmetry() - 1.0, model.asymmetry() + 1.0),
                simulated: Vec::new(),
                analytic: Vec::new(),
                columns: Vec::new(),
                periods: args.periods as f64,
            };
            let samples = args.periods * args.samples;
            Ok(Self(Some(Collected {
                format,
                file: Output::create(path)?,
                picture,
                home: orbit.and_then(Orbit::impact_site).unwrap_or(0),
                orbit: motion,
                start: start.time,
                stride: samples.div_ceil(COLUMNS).max(1),
                from_period: args.periods.saturating_sub(SHOWN),
                seen: 0,
                scratch: (vec![0.0; sites], vec![0.0; sites]),
            })))
        }

        pub(super) fn is_wanted(&self) -> bool {
            self.0.is_some()
        }

        pub(super) fn see(&mut self, simulation: &Simulation) {
            let Some(collected) = &mut self.0 else { return };
            let time = simulation.time();
            let (column, trace) = (collected.seen % collected.stride == 0, time.periods() >= collected.from_period);
            collected.seen += 1;
            if !(column || trace) {
                return;
            }
            simulation.read(&mut collected.scratch.0, &mut collected.scratch.1);
            let u = &collected.scratch.0;
            if column {
                collected.picture.columns.push(u.clone());
            }
            if trace {
                let periods = time.periods() as f64 + time.part();
                collected.picture.simulated.push((periods, u.get(collected.home).copied().unwrap_or(0.0)));
                if let Some((orbit, motion)) = &mut collected.orbit {
                    let now = motion.at(collected.home, orbit_time(orbit, time, collected.start));
                    collected.picture.analytic.push((periods, now.displacement));
                }
            }
        }

        pub(super) fn finish(self) -> Result<(), CliError> {
            let Some(collected) = self.0 else { return Ok(()) };
            let bytes = run_picture(&collected.picture, collected.format)
                .map_err(|error| CliError::Computation(error.to_string()))?;
            collected.file.finish_with(&bytes)
        }
    }
}

#[cfg(not(feature = "plot"))]
mod without_plot {
    use vibrochain_breather::Orbit;
    use vibrochain_eventsim::Simulation;
    use vibrochain_lattice::Model;

    use super::{CliError, SimulateArgs, Start};

    pub(super) struct Plot;

    impl Plot {
        pub(super) fn open(args: &SimulateArgs, _: &Model, _: Option<&Orbit>, _: &Start) -> Result<Self, CliError> {
            match args.plot {
                Some(_) => Err(CliError::Request("--plot needs a build with the feature `plot`".to_owned())),
                None => Ok(Self),
            }
        }

        pub(super) fn is_wanted(&self) -> bool {
            false
        }

        pub(super) fn see(&mut self, _: &Simulation) {}

        pub(super) fn finish(self) -> Result<(), CliError> {
            Ok(())
        }
    }
}
