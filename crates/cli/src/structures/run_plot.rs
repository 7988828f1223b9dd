//! The picture of a structure's run: a contact at its end, over the orbit it began on, and the velocities of all impacts.

use vibrochain_breather::{ContactMotion, LoadedStructure, Orbit};
use vibrochain_eventsim::{Event, EventKind, Simulation};
use vibrochain_lattice::Contact;
use vibrochain_maps::structure::StructureScene;
use vibrochain_plot::{Curves, Mark, Pane, Series, curves_picture, run_trace};

use crate::args::SimulateArgs;
use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;
use crate::simulate::recorder::Recorder;
use crate::simulate::recording::Trace;

/// Impacts of each contact at most: some for every pixel.
const IMPACTS: usize = 40_000;

/// Contacts that have a colour.
const CONTACTS: usize = 5;

/// Collects what the picture needs.
pub(super) struct RunPlot {
    files: PictureFiles,
    title: String,
    home: usize,
    contact: Contact,
    periods: f64,
    /// A period in units of time, where nothing has one that is worth a word.
    unit: Option<f64>,
    trace: Trace,
    orbit: Option<(Orbit, f64)>,
    /// Of each contact that hits, in the order of their first impacts: how fast it is before each.
    velocities: Vec<(usize, Thinned)>,
}

/// Points of which every other one is dropped, again and again, once there are too many.
struct Thinned {
    points: Vec<(f64, f64)>,
    stride: u64,
    seen: u64,
}

impl Thinned {
    fn push(&mut self, point: (f64, f64)) {
        if self.seen.is_multiple_of(self.stride) {
            if self.points.len() == IMPACTS {
                let mut keep = false;
                self.points.retain(|_| {
                    keep = !keep;
                    keep
                });
                self.stride *= 2;
            }
            self.points.push(point);
        }
        self.seen += 1;
    }
}

impl RunPlot {
    /// Of a run that begins at `from`, of which contact `home` is traced; on an orbit, at a time of its own clock.
    pub(super) fn open(
        args: &SimulateArgs,
        scene: &StructureScene,
        (model, has_period): (&LoadedStructure, bool),
        (from, home): (&str, usize),
        orbit: Option<(Orbit, f64)>,
    ) -> Result<Option<Self>, CliError> {
        let files = PictureFiles::one("--plot", args.plot.as_deref(), &args.page)?;
        if files.is_empty() {
            return Ok(None);
        }
        let title = format!("{}, from {from}: {}", scene.heading(), scene.here());
        let plot = Self {
            files,
            title,
            home,
            contact: model.structure().contacts()[home],
            periods: args.periods,
            unit: (!has_period).then(|| model.period()),
            trace: Trace::new(args),
            orbit,
            velocities: Vec::new(),
        };
        plot.files.fit(|page| curves_picture(&plot.picture(), page))?;
        Ok(Some(plot))
    }

    pub(super) fn finish(self) -> Result<(), CliError> {
        let picture = self.picture();
        self.files.draw(|page| curves_picture(&picture, page))
    }

    fn picture(&self) -> Curves {
        let levels = [self.contact.lower, self.contact.upper].into_iter().flatten().collect();
        let unit = self.unit.unwrap_or(1.0);
        let timed = |&(periods, height): &(f64, f64)| (periods * unit, height);
        let [simulated, analytic] =
            [&self.trace.simulated, &self.trace.analytic].map(|points| points.iter().map(timed).collect::<Vec<_>>());
        let mut trace = run_trace(&format!("g of contact {}", self.home), &simulated, &analytic, levels);
        let mut x = "time in periods (whole run)";
        if self.unit.is_some() {
            x = "time";
            trace.x = x.to_owned();
        }
        let dots = |(colour, (contact, velocities)): (usize, &(usize, Thinned))| {
            let name = if self.velocities.len() > 1 { format!("contact {contact}") } else { String::new() };
            let mark = if velocities.points.len() > 400 { Mark::Dot } else { Mark::Small(colour) };
            Series::marks(name, colour, mark, velocities.points.iter().map(timed))
        };
        let impacts = Pane {
            x: x.to_owned(),
            y: "velocity g′ before impacts".to_owned(),
            x_range: Some(0.0..self.periods.max(1e-9) * unit),
            levels: vec![0.0],
            series: self.velocities.iter().enumerate().map(dots).collect(),
            ..Pane::default()
        };
        let panes = vec![trace, impacts];
        Curves { title: self.title.clone(), panes, columns: 1, pane: (1100, 400), ..Curves::default() }
    }
}

impl Recorder for RunPlot {
    fn event(&mut self, event: &Event) {
        if event.kind != EventKind::Impact {
            return;
        }
        let periods = event.time.in_periods();
        let barrier = self.contact.barrier(event.barrier).filter(|_| event.contact == self.home);
        barrier.into_iter().for_each(|barrier| self.trace.hit(periods, barrier));
        let velocities = &mut self.velocities;
        let known = velocities.iter().position(|(contact, _)| *contact == event.contact);
        let at = known.unwrap_or(velocities.len());
        if at == velocities.len() && at < CONTACTS {
            velocities.push((event.contact, Thinned { points: Vec::new(), stride: 1, seen: 0 }));
        }
        if let Some((_, velocities)) = velocities.get_mut(at) {
            velocities.push((periods, event.velocity_before));
        }
    }

    fn look(&mut self, simulation: &Simulation) -> Result<(), CliError> {
        let time = simulation.time();
        let periods = time.in_periods();
        if !self.trace.is_due(periods) {
            return Ok(());
        }
        self.trace.simulated.extend(simulation.contact(self.home).map(|contact| (periods, contact.place)));
        let Some((orbit, start)) = &self.orbit else { return Ok(()) };
        let Some(contacts) = orbit.contacts() else { return Ok(()) };
        let rounds = time.periods() % u64::from(orbit.force_periods());
        let now = rounds as f64 * orbit.force_period() + time.offset() + start;
        let (motion, now) = (ContactMotion::new(contacts)?, now.rem_euclid(orbit.period()));
        let i = orbit.impacts().partition_point(|impact| impact.time <= now).saturating_sub(1);
        let [place, ..] = motion.contact(self.home, i, now - orbit.impacts()[i].time);
        self.trace.analytic.push((periods, place));
        Ok(())
    }
}
