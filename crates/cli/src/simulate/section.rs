//! Poincaré sections of a simulated run, as a table.

use vibrochain_eventsim::{Event, EventKind, Simulation, Time};
use vibrochain_fate::Strobe;

use crate::args::{SectionName, SimulateArgs};
use crate::common::error::CliError;
use crate::simulate::recorder::Recorder;
use vibrochain_maps::files::CsvFile;

/// The most masses of a section.
const MAX_SITES: usize = 1000;

/// A section under way.
pub(crate) struct Section {
    file: CsvFile,
    /// Instants once a period, and the number of the next one; without them the section is at impacts.
    strobe: Option<(Strobe, u64)>,
    sites: Vec<usize>,
    /// Time of the run's start, and the phase of the force there, as a time.
    start: f64,
    psi: f64,
    period: f64,
    /// Periods left out.
    skip: f64,
    /// The first row that could not be written.
    failure: Option<CliError>,
}

/// What a section is of.
pub(crate) struct Sectioned<'a> {
    /// Of the force.
    pub(crate) period: f64,
    /// Phase of the force at the start, as a time, and the time of the start.
    pub(crate) psi: f64,
    pub(crate) start: f64,
    /// Masses or contacts there are, and those that are looked at unless others are asked for.
    pub(crate) count: usize,
    pub(crate) home: Vec<usize>,
    /// What columns call one, its place and its velocity.
    pub(crate) names: [&'a str; 3],
}

impl Section {
    pub(crate) fn open(args: &SimulateArgs, of: Sectioned<'_>) -> Result<Option<Self>, CliError> {
        let Sectioned { period, psi, start, count, home, names: [site, place, velocity] } = of;
        let Some(path) = &args.section else { return Ok(None) };
        let (skip, phase) = (args.skip, args.section_phase);
        if !(skip >= 0.0 && skip <= args.periods) {
            refuse!("--skip {skip} is out of range: give a number of periods from 0 to {}", args.periods);
        }
        ensure!((0.0..1.0).contains(&phase), "--section-phase {phase} is out of range: give a part from 0, below 1");
        let mut sites = args.section_sites.clone();
        if sites.is_empty() {
            sites = home;
        }
        sites.sort_unstable();
        sites.dedup();
        let last = count.saturating_sub(1);
        if let Some(site) = sites.iter().find(|site| **site > last) {
            refuse!("--section-sites {site} does not exist: give sites from 0 to {last}");
        }
        ensure!(sites.len() <= MAX_SITES, "--section-sites has more than {MAX_SITES} sites: give fewer");
        let columns = |name: &str| sites.iter().map(|site| format!("{name}_{site}")).collect::<Vec<_>>();
        let words = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let (strobe, header) = match args.section_at {
            SectionName::Strobe => {
                let strobe = Strobe::of_period(period, psi, phase);
                // The phase is less than a period away.
                let first = ((skip.floor() as u64).saturating_sub(1)..=skip.ceil() as u64)
                    .find(|&i| strobe.time(i).in_periods() >= skip);
                let header = [words(&["time", "period", "phase"]), columns(place), columns(velocity)].concat();
                (Some((strobe, first.unwrap_or(skip.ceil() as u64))), header)
            }
            SectionName::Impact => {
                let names = ["time", "period", "phase", site, "barrier", "velocity_before", "velocity_after"];
                (None, words(&names))
            }
        };
        let file = CsvFile::create("--section", path, header)?;
        Ok(Some(Self { file, strobe, sites, start, psi, period, skip, failure: None }))
    }

    /// The next instant at which the section looks at the run, if that is not after `end`.
    pub(crate) fn due(&self, end: Time) -> Option<Time> {
        let (strobe, next) = self.strobe.as_ref()?;
        let time = strobe.time(*next);
        ((time.periods(), time.offset()) <= (end.periods(), end.offset())).then_some(time)
    }

    /// Time, whole periods, and phase of the force in periods.
    fn place(&self, time: Time) -> [String; 3] {
        let phase = (time.part() + self.psi / self.period).rem_euclid(1.0);
        // 1 up to rounding is 0.
        let phase = if phase > 1.0 - 1e-12 { 0.0 } else { phase };
        [time.on_clock(self.start).to_string(), time.periods().to_string(), phase.to_string()]
    }

    pub(crate) fn finish(self) -> Result<(), CliError> {
        Ok(self.file.finish()?)
    }
}

impl Recorder for Section {
    /// Takes note of an impact.
    fn event(&mut self, event: &Event) {
        let is_seen = event.kind == EventKind::Impact && self.strobe.is_none() && event.time.in_periods() >= self.skip;
        if !is_seen || self.sites.binary_search(&event.contact).is_err() {
            return;
        }
        let [before, after] = [event.velocity_before, event.velocity_after].map(|velocity| velocity.to_string());
        let rest = [event.contact.to_string(), event.barrier.name().to_owned(), before, after];
        if let Err(error) = self.file.row(self.place(event.time).into_iter().chain(rest)) {
            self.failure.get_or_insert(error.into());
        }
    }

    /// Looks at the run at a time that was due.
    fn look(&mut self, simulation: &Simulation) -> Result<(), CliError> {
        let Some((_, next)) = &mut self.strobe else { return Ok(()) };
        *next += 1;
        let seen: Vec<_> = self.sites.iter().filter_map(|&contact| simulation.contact(contact)).collect();
        let places = seen.iter().map(|contact| contact.place.to_string());
        let velocities = seen.iter().map(|contact| contact.velocity.to_string());
        Ok(self.file.row(self.place(simulation.time()).into_iter().chain(places).chain(velocities))?)
    }

    fn failed(&mut self) -> Option<CliError> {
        self.failure.take()
    }
}
