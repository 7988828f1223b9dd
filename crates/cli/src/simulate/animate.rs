//! A run that moves: the chain between its barriers.

use vibrochain_breather::Orbit;
use vibrochain_eventsim::{Event, Simulation};
use vibrochain_lattice::{Barrier, Model};
use vibrochain_maps::files::Output;
use vibrochain_plot::{Animation, Format, Instant, MOST_MASSES, Moving, Page, animation};

use crate::args::SimulateArgs;
use crate::common::error::CliError;

/// Periods of the run that are shown, the last ones: longer, and nobody looks to the end.
const SHOWN: f64 = 12.0;

/// Pictures of a period at most: at 25 a second it takes two to three seconds.
const PICTURES: u64 = 64;

/// What is collected of a run.
pub(crate) struct Film(Option<Reel>);

struct Reel {
    moving: Moving,
    file: Output,
    page: Page,
    picture: Animation,
    /// Periods of the whole run.
    periods: f64,
    /// Samples from one picture to the next.
    stride: u64,
    seen: u64,
    impacts: Vec<(usize, bool)>,
    velocity: Vec<f64>,
}

impl Film {
    pub(crate) fn open(args: &SimulateArgs, model: &Model, orbit: Option<&Orbit>) -> Result<Self, CliError> {
        let Some(path) = args.animate.as_deref() else { return Ok(Self(None)) };
        let name = path.display();
        let Some(moving) = Moving::of(path) else {
            let advice = "the kind of moving picture is not known; end the name in .gif, .png or .svg";
            return Err(CliError::Request(format!("--animate {name}: {advice}")));
        };
        args.page.checked(true, "--animate")?;
        let page = args.page.page(Format::Png)?;
        let chain = model.chain();
        let masses = chain.sites();
        if masses > MOST_MASSES {
            refuse!("--animate {name}: {masses} masses cannot be told apart, at most {MOST_MASSES} can");
        }
        let lowest = if chain.is_ring() { -(masses.saturating_sub(1) as i64 / 2) } else { 0 };
        let barriers = (model.asymmetry() - 1.0, model.asymmetry() + 1.0);
        let title = crate::common::caption::describe_run(args, model, orbit);
        let still = vec![Instant { displacement: vec![0.0; masses], impacts: Vec::new() }];
        let of = |instants| Animation { title: title.clone(), barriers, length: chain.length(), lowest, instants };
        animation(&of(still), moving, page.to_measure()).map_err(|error| CliError::Request(error.0))?;
        Ok(Self(Some(Reel {
            moving,
            file: Output::create(path)?,
            page,
            picture: of(Vec::new()),
            periods: args.periods,
            stride: args.samples.div_ceil(PICTURES).max(1),
            seen: 0,
            impacts: Vec::new(),
            velocity: vec![0.0; masses],
        })))
    }

    pub(crate) fn is_wanted(&self) -> bool {
        self.0.is_some()
    }

    pub(crate) fn hit(&mut self, event: &Event) {
        if let Some(reel) = &mut self.0 {
            let impact = (event.site, event.barrier == Barrier::Upper);
            if !reel.impacts.contains(&impact) {
                reel.impacts.push(impact);
            }
        }
    }

    pub(crate) fn see(&mut self, simulation: &Simulation) {
        let Some(reel) = &mut self.0 else { return };
        let due = reel.seen.is_multiple_of(reel.stride);
        reel.seen += 1;
        if !due {
            return;
        }
        let time = simulation.time();
        let left = reel.periods - (time.periods() as f64 + time.part());
        let impacts = std::mem::take(&mut reel.impacts);
        // The end of a whole number of periods is the beginning of the next round.
        if left < SHOWN + 1e-9 && (left > 1e-9 || reel.picture.instants.is_empty()) {
            let mut displacement = vec![0.0; reel.velocity.len()];
            simulation.read(&mut displacement, &mut reel.velocity);
            reel.picture.instants.push(Instant { displacement, impacts });
        } else if let (true, Some(first)) = (left <= 1e-9, reel.picture.instants.first_mut()) {
            first.impacts.extend(impacts);
        }
    }

    pub(crate) fn finish(self) -> Result<(), CliError> {
        let Some(Reel { moving, file, page, picture, .. }) = self.0 else { return Ok(()) };
        let bytes = animation(&picture, moving, page).map_err(|error| CliError::Computation(error.to_string()))?;
        Ok(file.finish_with(&bytes)?)
    }
}
