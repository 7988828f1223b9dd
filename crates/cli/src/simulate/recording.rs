//! What a simulation leaves behind: tables of events and samples, and the picture.

use std::path::Path;

use vibrochain_breather::{Impact, Motion, Orbit};
use vibrochain_eventsim::{Event, Simulation, Time};
use vibrochain_lattice::{Barrier, Layout, Model};
use vibrochain_maps::files::CsvFile;
use vibrochain_maps::numbers::Number;
use vibrochain_plot::field::FieldWriter;
use vibrochain_plot::{RunPicture, run_picture};

use crate::args::SimulateArgs;
use crate::common::caption::describe_run;
use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;
use crate::simulate::recorder::Recorder;
use crate::simulate::start::Start;

/// The time on an orbit's own clock: whole periods are taken off before they cost digits.
pub fn orbit_time(orbit: &Orbit, time: Time, start: f64) -> f64 {
    let periods = time.periods() % u64::from(orbit.force_periods());
    periods as f64 * orbit.force_period() + time.offset() + start
}

/// One row an event. Of a chain `time,site,barrier,velocity_before,velocity_after,kind`, `layer` after `site` where there are several; of a
/// structure the contact for the site, and `impulse` before `kind`.
pub(crate) struct ImpactTable {
    file: CsvFile,
    /// How masses are called, of a chain.
    layout: Option<Layout>,
    start: f64,
    /// The first row that could not be written.
    failure: Option<CliError>,
}

impl ImpactTable {
    /// Of a run that begins at the time `start` of its clock.
    pub(crate) fn open(path: &Path, start: f64, layout: Option<Layout>) -> Result<Self, CliError> {
        let mut header = vec!["time", "contact", "barrier", "velocity_before", "velocity_after", "kind"];
        match layout {
            None => header.insert(5, "impulse"),
            Some(layout) => {
                header[1] = "site";
                header.splice(2..2, (layout.layers > 1).then_some("layer"));
            }
        }
        Ok(Self { file: CsvFile::create("--impacts", path, header)?, layout, start, failure: None })
    }

    pub(crate) fn finish(self) -> Result<(), CliError> {
        Ok(self.file.finish()?)
    }
}

impl Recorder for ImpactTable {
    fn event(&mut self, event: &Event) {
        let number = |x: f64| Number(x).to_string();
        let &Event { contact, barrier, velocity_before, velocity_after, impulse, kind, .. } = event;
        let (name, layer) = self.layout.map_or((contact, 0), |layout| layout.place(contact));
        let layer = self.layout.is_some_and(|layout| layout.layers > 1).then(|| layer.to_string());
        let impulse = self.layout.is_none().then(|| number(impulse));
        let row = [number(event.time.on_clock(self.start)), name.to_string()].into_iter().chain(layer);
        let row = row.chain([barrier.name().to_owned(), number(velocity_before), number(velocity_after)]);
        if let Err(error) = self.file.row(row.chain(impulse).chain([kind.name().to_owned()])) {
            self.failure.get_or_insert(error.into());
        }
    }

    fn failed(&mut self) -> Option<CliError> {
        self.failure.take()
    }
}

/// `time,displacement_0,…,velocity_0,…`
pub(crate) fn trajectory_columns(sites: usize) -> impl Iterator<Item = String> {
    let columns = move |name: &'static str| (0..sites).map(move |n| format!("{name}_{n}"));
    std::iter::once("time".to_owned()).chain(columns("displacement")).chain(columns("velocity"))
}

/// One row a sample: the time, of a structure what its contacts do, and all coordinates with their velocities.
pub(crate) struct Trajectory {
    file: CsvFile,
    start: f64,
    with_contacts: bool,
}

impl Trajectory {
    /// Of a run of a chain that begins at the time `start` of its clock.
    pub(crate) fn of_chain(path: &Path, start: f64, sites: usize) -> Result<Self, CliError> {
        let file = CsvFile::create("--trajectory", path, trajectory_columns(sites))?;
        Ok(Self { file, start, with_contacts: false })
    }

    /// Of a structure, with what its contacts do first.
    pub(crate) fn of_structure(path: &Path, columns: impl Iterator<Item = String>) -> Result<Self, CliError> {
        Ok(Self { file: CsvFile::create("--trajectory", path, columns)?, start: 0.0, with_contacts: true })
    }

    pub(crate) fn finish(self) -> Result<(), CliError> {
        Ok(self.file.finish()?)
    }
}

impl Recorder for Trajectory {
    fn look(&mut self, simulation: &Simulation) -> Result<(), CliError> {
        let (state, time) = (simulation.state(), simulation.time().on_clock(self.start));
        let contacts = if self.with_contacts { simulation.contacts() } else { Vec::new() };
        let (places, velocities): (Vec<f64>, Vec<f64>) =
            contacts.iter().map(|contact| (contact.place, contact.velocity)).unzip();
        let all = [vec![time], places, velocities, state.displacement, state.velocity];
        Ok(self.file.row(all.iter().flatten().map(f64::to_string))?)
    }
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
        let (period, every) = (orbit.force_period(), f64::from(orbit.force_periods()));
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

impl Recorder for Plot {
    fn event(&mut self, event: &Event) {
        if event.contact == self.home {
            self.trace.hit(event.time.in_periods(), place(self.picture.barriers, event.barrier));
        }
    }

    fn look(&mut self, simulation: &Simulation) -> Result<(), CliError> {
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
        Ok(())
    }
}

/// Where a barrier is.
fn place((lower, upper): (f64, f64), barrier: Barrier) -> f64 {
    match barrier {
        Barrier::Lower => lower,
        Barrier::Upper => upper,
    }
}
