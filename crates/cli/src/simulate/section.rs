//! Poincaré sections of a simulated run, as a table.

use vibrochain_breather::Orbit;
use vibrochain_eventsim::{Event, EventKind, Simulation, Time};
use vibrochain_fate::Strobe;
use vibrochain_lattice::Model;

use crate::args::{SectionName, SimulateArgs};
use crate::common::error::CliError;
use crate::simulate::start::Start;
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
    /// The first row that could not be written; the simulation cannot stop for it at once.
    failure: Option<CliError>,
}

impl Section {
    pub(crate) fn open(
        args: &SimulateArgs,
        model: &Model,
        orbit: Option<&Orbit>,
        start: &Start,
    ) -> Result<Option<Self>, CliError> {
        let Some(path) = &args.section else { return Ok(None) };
        let (skip, phase) = (args.skip, args.section_phase);
        if !(skip >= 0.0 && skip <= args.periods) {
            let message = format!("--skip {skip} is out of range: give a number of periods from 0 to {}", args.periods);
            return Err(CliError::Request(message));
        }
        if !(0.0..1.0).contains(&phase) {
            return Err(CliError::Request(format!(
                "--section-phase {phase} is out of range: give a part from 0, below 1"
            )));
        }
        let mut sites = args.section_sites.clone();
        if sites.is_empty() {
            sites = orbit.map_or(vec![0], Orbit::hit_sites);
        }
        sites.sort_unstable();
        sites.dedup();
        let last = model.chain().sites() - 1;
        if let Some(site) = sites.iter().find(|site| **site > last) {
            return Err(CliError::Request(format!(
                "--section-sites {site} does not exist: give sites from 0 to {last}"
            )));
        }
        if sites.len() > MAX_SITES {
            return Err(CliError::Request(format!("--section-sites has more than {MAX_SITES} sites: give fewer")));
        }
        let columns = |name: &'static str| sites.iter().map(move |site| format!("{name}_{site}"));
        let words = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let (strobe, header) = match args.section_at {
            SectionName::Strobe => {
                let strobe = Strobe::new(model, start.psi, phase);
                // The phase is less than a period away.
                let first = ((skip.floor() as u64).saturating_sub(1)..=skip.ceil() as u64)
                    .find(|&i| part(strobe.time(i)) >= skip);
                let columns = columns("displacement").chain(columns("velocity"));
                let header = words(&["time", "period", "phase"]).into_iter().chain(columns).collect();
                (Some((strobe, first.unwrap_or(skip.ceil() as u64))), header)
            }
            SectionName::Impact => {
                let names = ["time", "period", "phase", "site", "barrier", "velocity_before", "velocity_after"];
                (None, words(&names))
            }
        };
        let file = CsvFile::create("--section", path, header)?;
        let (period, psi) = (model.period(), start.psi);
        Ok(Some(Self { file, strobe, sites, start: start.time, psi, period, skip, failure: None }))
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

    /// Looks at the run at a time that was due.
    pub(crate) fn look(&mut self, simulation: &Simulation) -> Result<(), CliError> {
        let Some((_, next)) = &mut self.strobe else { return Ok(()) };
        *next += 1;
        let state = simulation.state();
        let of = |values: &[f64]| self.sites.iter().map(|&n| values[n].to_string()).collect::<Vec<_>>();
        let row = self.place(simulation.time()).into_iter();
        let row = row.chain(of(&state.displacement)).chain(of(&state.velocity)).collect::<Vec<_>>();
        Ok(self.file.row(row)?)
    }

    /// Takes note of an event.
    pub(crate) fn see(&mut self, event: &Event) {
        let wanted = self.strobe.is_none()
            && event.kind == EventKind::Impact
            && part(event.time) >= self.skip
            && self.sites.binary_search(&event.site).is_ok();
        if !wanted {
            return;
        }
        let rest = [
            event.site.to_string(),
            event.barrier.name().to_owned(),
            event.velocity_before.to_string(),
            event.velocity_after.to_string(),
        ];
        if let Err(error) = self.file.row(self.place(event.time).into_iter().chain(rest)) {
            self.failure.get_or_insert(error.into());
        }
    }

    /// The failure to write a row, once.
    pub(crate) fn failed(&mut self) -> Option<CliError> {
        self.failure.take()
    }

    pub(crate) fn finish(self) -> Result<(), CliError> {
        Ok(self.file.finish()?)
    }
}

/// A time in periods.
fn part(time: Time) -> f64 {
    time.periods() as f64 + time.part()
}
