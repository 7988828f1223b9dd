//! What a simulation leaves behind: tables of events and samples, and the picture.

use std::path::Path;

use vibrochain_breather::{Impact, Motion, Orbit};
use vibrochain_eventsim::{Event, Simulation, Time};
use vibrochain_lattice::{Barrier, Layout, Model};
use vibrochain_maps::files::CsvFile;
use vibrochain_plot::field::FieldWriter;
use vibrochain_plot::{RunPicture, run_picture};

use crate::args::SimulateArgs;
use crate::common::caption::describe_run;
use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;
use crate::simulate::start::Start;

/// The time on an orbit's own clock: whole periods are taken off before they cost digits.
pub fn orbit_time(orbit: &Orbit, time: Time, start: f64) -> f64 {
    let periods = time.periods() % u64::from(orbit.force_periods());
    periods as f64 * orbit.model().period() + time.offset() + start
}

/// `time,site,barrier,velocity_before,velocity_after,kind`, one row a mass; `layer` after `site` where there are several.
pub(crate) struct ImpactTable {
    file: CsvFile,
    layout: Layout,
    start: f64,
    /// The first row that could not be written; the simulation cannot stop for it at once.
    pub(crate) failure: Option<CliError>,
}

impl ImpactTable {
    pub(crate) fn open(path: &Path, start: f64, model: &Model) -> Result<Self, CliError> {
        let layout = model.chain().layout();
        let mut header = vec!["time", "site", "barrier", "velocity_before", "velocity_after", "kind"];
        if layout.layers > 1 {
            header.insert(2, "layer");
        }
        Ok(Self { file: CsvFile::create("--impacts", path, header)?, layout, start, failure: None })
    }

    pub(crate) fn write(&mut self, event: &Event) {
        let (site, layer) = self.layout.place(event.contact);
        let mut row = vec![
            event.time.on_clock(self.start).to_string(),
            site.to_string(),
            event.barrier.name().to_owned(),
            event.velocity_before.to_string(),
            event.velocity_after.to_string(),
            event.kind.name().to_owned(),
        ];
        if self.layout.layers > 1 {
            row.insert(2, layer.to_string());
        }
        if let Err(error) = self.file.row(row) {
            self.failure.get_or_insert(error.into());
        }
    }

    pub(crate) fn finish(self) -> Result<(), CliError> {
        Ok(self.file.finish()?)
    }
}

/// `time,displacement_0,…,velocity_0,…`
pub(crate) fn trajectory_columns(sites: usize) -> impl Iterator<Item = String> {
    let columns = move |name: &'static str| (0..sites).map(move |n| format!("{name}_{n}"));
    std::iter::once("time".to_owned()).chain(columns("displacement")).chain(columns("velocity"))
}

/// Periods at the end of the run of which what is hit is shown.
const SHOWN: f64 = 8.0;

/// Points of its trace at most: some for every pixel.
const POINTS: f64 = 8000.0;

/// One of so many samples.
pub(crate) struct Every {
    stride: u64,
    seen: u64,
}

impl Every {
    pub(crate) fn new(stride: u64) -> Self {
        Self { stride: stride.max(1), seen: 0 }
    }

    /// Whether it is this one.
    pub(crate) fn is_due(&mut self) -> bool {
        self.seen += 1;
        (self.seen - 1).is_multiple_of(self.stride)
    }
}

/// Places of what is hit over periods, at the end of a run.
pub(crate) struct Trace {
    /// Of the whole run.
    periods: f64,
    /// The samples that are points.
    traced: Every,
    pub(crate) simulated: Vec<(f64, f64)>,
    pub(crate) analytic: Vec<(f64, f64)>,
}

impl Trace {
    pub(crate) fn new(args: &SimulateArgs) -> Self {
        let traced = Every::new((SHOWN * args.samples as f64 / POINTS) as u64);
        Self { periods: args.periods, traced, simulated: Vec::new(), analytic: Vec::new() }
    }

    /// Takes note of an impact: between samples the tips of a trace would be cut off.
    pub(crate) fn hit(&mut self, periods: f64, barrier: f64) {
        // Of a mass that bounces on a barrier nobody sees each.
        let seen = |last: &(f64, f64)| last.1 == barrier && periods - last.0 < SHOWN / POINTS;
        if periods >= self.periods - SHOWN && !self.simulated.last().is_some_and(seen) {
            self.simulated.push((periods, barrier));
        }
    }

    /// Whether the next sample, at this time, is a point.
    pub(crate) fn is_due(&mut self, periods: f64) -> bool {
        self.traced.is_due() && periods >= self.periods - SHOWN - 1e-9
    }
}

/// Collects what the picture needs, and no more of a long run.
pub(crate) struct Plot {
    files: PictureFiles,
    /// Without its trace and its field, until the end.
    picture: RunPicture,
    trace: Trace,
    field: FieldWriter,
    orbit: Option<(Orbit, Motion)>,
    home: usize,
    start: f64,
    scratch: (Vec<f64>, Vec<f64>),
}

impl Plot {
    pub(crate) fn open(
        args: &SimulateArgs,
        model: &Model,
        orbit: Option<&Orbit>,
        start: &Start,
    ) -> Result<Option<Self>, CliError> {
        args.page.checked(args.plot.is_some() || args.animate.is_some(), "--plot or --animate")?;
        let Some(path) = args.plot.as_deref() else { return Ok(None) };
        let files = PictureFiles::one("--plot", Some(path), &args.page)?;
        let motion = orbit.map(|orbit| Motion::of(orbit).map(|motion| (orbit.clone(), motion))).transpose()?;
        let sites = model.chain().sites();
        let field = || FieldWriter::new(model.chain(), args.periods, args.samples);
        let picture = RunPicture {
            title: describe_run(args, model, orbit),
            barriers: (model.asymmetry() - 1.0, model.asymmetry() + 1.0),
            simulated: Vec::new(),
            analytic: Vec::new(),
            field: field().finish(),
            periods: args.periods,
        };
        files.fit(|page| run_picture(&picture, page))?;
        Ok(Some(Self {
            files,
            picture,
            trace: Trace::new(args),
            field: field(),
            home: orbit.and_then(Orbit::impact_site).unwrap_or(0),
            orbit: motion,
            start: start.time,
            scratch: (vec![0.0; sites], vec![0.0; sites]),
        }))
    }

    pub(crate) fn hit(&mut self, event: &Event) {
        if event.contact == self.home {
            self.trace.hit(event.time.in_periods(), place(self.picture.barriers, event.barrier));
        }
    }

    pub(crate) fn see(&mut self, simulation: &Simulation) {
        let time = simulation.time();
        let periods = time.in_periods();
        let is_point = self.trace.is_due(periods);
        if is_point || self.field.wants() {
            simulation.read(&mut self.scratch.0, &mut self.scratch.1);
        }
        let u = &self.scratch.0;
        self.field.see(u, periods);
        if is_point {
            self.trace.simulated.push((periods, u.get(self.home).copied().unwrap_or(0.0)));
            if let Some((orbit, motion)) = &mut self.orbit {
                let now = motion.at(self.home, orbit_time(orbit, time, self.start));
                self.trace.analytic.push((periods, now.displacement));
            }
        }
    }

    pub(crate) fn finish(self) -> Result<(), CliError> {
        let tips = self.tips();
        let Self { files, picture, trace: Trace { simulated, mut analytic, .. }, field, .. } = self;
        analytic.extend(tips);
        analytic.sort_by(|one, other| one.0.total_cmp(&other.0));
        let picture = RunPicture { simulated, analytic, field: field.finish(), ..picture };
        files.draw(|page| run_picture(&picture, page))
    }

    /// The impacts of the orbit's own mass within its trace.
    fn tips(&self) -> Vec<(f64, f64)> {
        let (barriers, analytic) = (&self.picture.barriers, &self.trace.analytic);
        let (Some((orbit, _)), Some(first), Some(last)) = (&self.orbit, analytic.first(), analytic.last()) else {
            return Vec::new();
        };
        let (period, every) = (orbit.model().period(), f64::from(orbit.force_periods()));
        let own = orbit.impacts().iter().filter(|impact| impact.site == self.home);
        let of = |impact: &Impact| {
            let at = (impact.time - self.start) / period;
            let next = at + every * ((first.0 - at) / every).ceil();
            let height = place(*barriers, impact.barrier);
            let rounds = ((last.0 - next) / every).floor().clamp(-1.0, SHOWN) as i64;
            (0..=rounds).map(move |k| (next + k as f64 * every, height))
        };
        own.flat_map(of).collect()
    }
}

/// Where a barrier is.
fn place((lower, upper): (f64, f64), barrier: Barrier) -> f64 {
    match barrier {
        Barrier::Lower => lower,
        Barrier::Upper => upper,
    }
}
