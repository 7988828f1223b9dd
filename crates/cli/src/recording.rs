//! What a simulation leaves behind: tables of events and samples, and the picture.

use std::path::Path;

use vibrochain_breather::Orbit;
use vibrochain_eventsim::{Event, Simulation, Time};
use vibrochain_lattice::Model;

use crate::args::SimulateArgs;
use crate::error::CliError;
use crate::output::Output;
use crate::start::Start;

/// The time on an orbit's own clock: whole periods are taken off before they cost digits.
pub(crate) fn orbit_time(orbit: &Orbit, time: Time, start: f64) -> f64 {
    let periods = time.periods() % u64::from(orbit.force_periods());
    periods as f64 * orbit.model().period() + time.offset() + start
}

fn unwritable(path: &Path, error: &dyn std::fmt::Display) -> CliError {
    CliError::Computation(format!("could not write {}: {error}", path.display()))
}

/// `time,site,barrier,velocity_before,velocity_after,kind`, one row a mass.
pub(crate) struct ImpactTable {
    writer: csv::Writer<Output>,
    path: std::path::PathBuf,
    start: f64,
    /// The first row that could not be written; the simulation cannot stop for it at once.
    pub(crate) failure: Option<CliError>,
}

impl ImpactTable {
    pub(crate) fn open(path: &Path, start: f64) -> Result<Self, CliError> {
        let mut writer = csv::Writer::from_writer(Output::create(path)?);
        let header = ["time", "site", "barrier", "velocity_before", "velocity_after", "kind"];
        writer.write_record(header).map_err(|error| unwritable(path, &error))?;
        Ok(Self { writer, path: path.to_owned(), start, failure: None })
    }

    pub(crate) fn write(&mut self, event: &Event) {
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

    pub(crate) fn finish(self) -> Result<(), CliError> {
        self.writer.into_inner().map_err(|error| unwritable(&self.path, error.error()))?.commit()
    }
}

/// `time,displacement_0,…,velocity_0,…`, one row a sample.
pub(crate) struct Trajectory {
    writer: csv::Writer<Output>,
    path: std::path::PathBuf,
    start: f64,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
}

impl Trajectory {
    pub(crate) fn open(path: &Path, start: f64, model: &Model) -> Result<Self, CliError> {
        let sites = model.chain().sites();
        let mut writer = csv::Writer::from_writer(Output::create(path)?);
        let columns = |name: &'static str| (0..sites).map(move |n| format!("{name}_{n}"));
        let header = std::iter::once("time".to_owned()).chain(columns("displacement")).chain(columns("velocity"));
        writer.write_record(header).map_err(|error| unwritable(path, &error))?;
        Ok(Self { writer, path: path.to_owned(), start, displacement: vec![0.0; sites], velocity: vec![0.0; sites] })
    }

    pub(crate) fn write(&mut self, simulation: &Simulation) -> Result<(), CliError> {
        simulation.read(&mut self.displacement, &mut self.velocity);
        let time = self.start + simulation.time().to_f64();
        let row = std::iter::once(&time).chain(&self.displacement).chain(&self.velocity).map(f64::to_string);
        self.writer.write_record(row).map_err(|error| unwritable(&self.path, &error))
    }

    pub(crate) fn finish(self) -> Result<(), CliError> {
        self.writer.into_inner().map_err(|error| unwritable(&self.path, error.error()))?.commit()
    }
}

#[cfg(feature = "plot")]
pub(crate) use with_plot::Plot;
#[cfg(not(feature = "plot"))]
pub(crate) use without_plot::Plot;

#[cfg(feature = "plot")]
mod with_plot {
    use vibrochain_breather::{Motion, Orbit};
    use vibrochain_eventsim::Simulation;
    use vibrochain_lattice::Model;

    use super::{CliError, Output, SimulateArgs, Start, orbit_time};
    use crate::plot::{Format, RunPicture, open, run_picture};

    /// Columns of the space–time picture.
    const COLUMNS: u64 = 1000;

    /// Periods at the end of the run of which the impacting mass is shown.
    const SHOWN: u64 = 8;

    /// Collects what the picture needs, and no more of a long run.
    pub(crate) struct Plot(Option<Collected>);

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
        pub(crate) fn open(
            args: &SimulateArgs,
            model: &Model,
            orbit: Option<&Orbit>,
            start: &Start,
        ) -> Result<Self, CliError> {
            let Some((format, file)) = open(args.plot.as_deref())? else { return Ok(Self(None)) };
            let motion = orbit.map(|orbit| Motion::of(orbit).map(|motion| (orbit.clone(), motion))).transpose();
            let motion = motion.map_err(|error| CliError::Computation(error.to_string()))?;
            let sites = model.chain().sites();
            let picture = RunPicture {
                title: crate::figures::solve::describe(model),
                barriers: (model.asymmetry() - 1.0, model.asymmetry() + 1.0),
                simulated: Vec::new(),
                analytic: Vec::new(),
                columns: Vec::new(),
                periods: args.periods as f64,
            };
            let samples = args.periods * args.samples;
            Ok(Self(Some(Collected {
                format,
                file,
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

        pub(crate) fn is_wanted(&self) -> bool {
            self.0.is_some()
        }

        pub(crate) fn see(&mut self, simulation: &Simulation) {
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

        pub(crate) fn finish(self) -> Result<(), CliError> {
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

    pub(crate) struct Plot;

    impl Plot {
        pub(crate) fn open(args: &SimulateArgs, _: &Model, _: Option<&Orbit>, _: &Start) -> Result<Self, CliError> {
            match args.plot {
                Some(_) => Err(CliError::Request("--plot needs a build with the feature `plot`".to_owned())),
                None => Ok(Self),
            }
        }

        pub(crate) fn is_wanted(&self) -> bool {
            false
        }

        pub(crate) fn see(&mut self, _: &Simulation) {}

        pub(crate) fn finish(self) -> Result<(), CliError> {
            Ok(())
        }
    }
}
