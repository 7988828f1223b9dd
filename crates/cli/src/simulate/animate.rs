//! A run that moves: the chain between its barriers.

use vibrochain_breather::Orbit;
use vibrochain_eventsim::{Event, Simulation};
use vibrochain_lattice::{Barrier, Model};
use vibrochain_maps::files::Output;
use vibrochain_plot::{Animation, Format, Instant, MOST_MASSES, Moving, Page, animation};

use crate::args::SimulateArgs;
use crate::common::caption::describe_run;
use crate::common::error::CliError;
use crate::simulate::recorder::Recorder;
use crate::simulate::recording::Every;

/// Periods of the run that are shown, the last ones: longer, and nobody looks to the end.
const SHOWN: f64 = 12.0;

/// Pictures of a period at most: at 25 a second it takes two to three seconds.
const PICTURES: u64 = 64;

/// What is collected of a run.
pub(crate) struct Film {
    moving: Moving,
    file: Output,
    page: Page,
    picture: Animation,
    /// Periods of the whole run.
    periods: f64,
    /// The samples that are pictures.
    shown: Every,
    impacts: Vec<(usize, bool)>,
    velocity: Vec<f64>,
}

impl Film {
    pub(crate) fn open(args: &SimulateArgs, model: &Model, orbit: Option<&Orbit>) -> Result<Option<Self>, CliError> {
        let Some(path) = args.animate.as_deref() else { return Ok(None) };
        let name = path.display();
        let Some(moving) = Moving::of(path) else {
            refuse!("--animate {name}: the kind of moving picture is not known; end the name in .gif, .png or .svg");
        };
        args.page.checked(true, "--animate")?;
        let page = args.page.page(Format::Png)?;
        let chain = model.chain();
        let masses = chain.sites();
        if masses > MOST_MASSES {
            refuse!("--animate {name}: {masses} masses cannot be told apart, at most {MOST_MASSES} can");
        }
        let mut picture = Animation {
            title: describe_run(args, model, orbit),
            barriers: (model.asymmetry() - 1.0, model.asymmetry() + 1.0),
            length: chain.length(),
            lowest: if chain.is_ring() { -(masses.saturating_sub(1) as i64 / 2) } else { 0 },
            instants: vec![Instant { displacement: vec![0.0; masses], impacts: Vec::new() }],
        };
        animation(&picture, moving, page.to_measure()).map_err(|error| CliError::Request(error.0))?;
        picture.instants.clear();
        Ok(Some(Self {
            moving,
            file: Output::create(path)?,
            page,
            picture,
            periods: args.periods,
            shown: Every::new(args.samples.div_ceil(PICTURES)),
            impacts: Vec::new(),
            velocity: vec![0.0; masses],
        }))
    }

    pub(crate) fn finish(self) -> Result<(), CliError> {
        let bytes = animation(&self.picture, self.moving, self.page);
        Ok(self.file.finish_with(&bytes.map_err(|error| CliError::Computation(error.to_string()))?)?)
    }
}

impl Recorder for Film {
    fn event(&mut self, event: &Event) {
        let impact = (event.contact, event.barrier == Barrier::Upper);
        if !self.impacts.contains(&impact) {
            self.impacts.push(impact);
        }
    }

    fn look(&mut self, simulation: &Simulation) -> Result<(), CliError> {
        if !self.shown.is_due() {
            return Ok(());
        }
        let left = self.periods - simulation.time().in_periods();
        let impacts = std::mem::take(&mut self.impacts);
        // The end of a whole number of periods is the beginning of the next round.
        if left < SHOWN + 1e-9 && (left > 1e-9 || self.picture.instants.is_empty()) {
            let mut displacement = vec![0.0; self.velocity.len()];
            simulation.read(&mut displacement, &mut self.velocity);
            self.picture.instants.push(Instant { displacement, impacts });
        } else if let (true, Some(first)) = (left <= 1e-9, self.picture.instants.first_mut()) {
            first.impacts.extend(impacts);
        }
        Ok(())
    }
}
