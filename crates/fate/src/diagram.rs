//! Bifurcation diagrams by simulation: along one parameter, where runs are once a period when they have had time to settle.

use rayon::iter::{IntoParallelIterator, ParallelIterator};
use vibrochain_eventsim::{Outcome, Simulation, State};
use vibrochain_lattice::Stop;
use vibrochain_maps::cell::Worker;
use vibrochain_maps::grid::Grid;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::sweep::{Ended, Job};

use crate::ensemble::Ensemble;
use crate::fates::{Ensembled, From};
use crate::origin::Origin;
use crate::run::reach;
use crate::section::Strobe;

/// Cells whose points wait for each other, and how many numbers they may be together: a quarter of a gigabyte.
const BLOCK: u64 = 64;
const MOST_WAITING: u64 = 1 << 24;

/// Points of one cell at most.
pub const MAX_POINTS: u64 = 100_000;

/// One point of a section: displacement and velocity of each site, or contact, that is looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionPoint {
    /// Periods of the force since the start.
    pub period: u64,
    /// (u, u̇) of each site, or contact, in the order of [`Sectioned::watched`].
    pub states: Vec<(f64, f64)>,
}

/// One cell of a diagram.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The cell's number in the scene.
    pub number: u64,
    /// Its last section points.
    pub points: Vec<SectionPoint>,
    /// Whether the run was completed; if not, its points are those it came to.
    pub complete: bool,
}

/// A scene whose runs are looked at once a period.
pub trait Sectioned: Ensembled {
    /// The sites, or contacts, that are looked at.
    fn watched(&self) -> Vec<usize>;

    /// Whether a run may go on from the end of the one before.
    ///
    /// # Errors
    /// Why not.
    fn carries(&self) -> Result<(), String>;

    /// Whence a run of a cell goes on from a state at an instant of the section, or starts at rest; `None` where there is no model.
    fn origin(&self, cell: u64, state: Option<State>, worker: &mut Self::Worker) -> Option<Origin>;
}

/// A diagram that is asked for.
#[derive(Debug, Clone)]
pub struct Diagram<'a, S = Scene> {
    /// The scene, with one axis.
    pub scene: &'a S,
    /// How long a run is, and how its start is perturbed.
    pub ensemble: &'a Ensemble,
    /// Section points kept of each run.
    pub points: u64,
    /// Whether each run goes on from the end of the one before: cells then follow each other, and branches that live side by side are
    /// followed one at a time.
    pub carry: bool,
}

impl<S: Sectioned> Diagram<'_, S> {
    /// Computes all cells and hands them to `sink` in order. `tick` is called with each number of cells that is done.
    pub fn compute<E>(
        &self,
        job: &Job<'_, S>,
        tick: impl Fn(u64) + Sync,
        mut sink: impl FnMut(Column) -> Result<(), E>,
    ) -> Ended<E, ()> {
        let cells = Grid::cells(self.scene);
        let watched = self.scene.watched();
        let numbers = (2 * self.points).saturating_mul(watched.len() as u64).max(1);
        let block = if self.carry { 1 } else { (MOST_WAITING / numbers).clamp(1, BLOCK) };
        let mut carried: Option<State> = None;
        let mut first = 0;
        while first < cells {
            let numbers = first..(first + block).min(cells);
            first = numbers.end;
            let of = |number| {
                let column = self.column(number, &watched, carried.clone(), job.stop);
                tick(1);
                column
            };
            let done: Vec<_> = job.pool.install(|| numbers.into_par_iter().map(of).collect());
            for column in done {
                let Some((column, end)) = column else { return Ended::Stopped };
                carried = end;
                if let Err(error) = sink(column) {
                    return Ended::Failed(error);
                }
            }
        }
        Ended::Complete(())
    }

    /// One run, and where it ends if it is completed. `None` if stopped.
    fn column(
        &self,
        number: u64,
        watched: &[usize],
        carried: Option<State>,
        stop: &Stop,
    ) -> Option<(Column, Option<State>)> {
        if stop.is_raised() {
            return None;
        }
        let (mut points, mut end) = (Vec::new(), None);
        let Some((mut run, strobe)) = self.begin(number, carried, stop)? else {
            return Some((Column { number, points, complete: false }, None));
        };
        let first = self.ensemble.periods.saturating_sub(self.points);
        for period in 0..self.ensemble.periods {
            if stop.is_raised() {
                return None;
            }
            // A whole period at a time before the first point, so that nothing takes long to be stopped.
            if reach(&mut run, None, strobe.time(period), |_| {})?.outcome != Outcome::TimeReached {
                return Some((Column { number, points, complete: false }, None));
            }
            if period >= first {
                let seen = watched.iter().filter_map(|&contact| run.contact(contact));
                let states = seen.map(|contact| (contact.place, contact.velocity)).collect();
                points.push(SectionPoint { period, states });
                end = self.carry.then(|| run.state());
            }
        }
        Some((Column { number, points, complete: true }, end))
    }

    /// A run of a cell from the end of another one; or from what gives the cell its class, perturbed, or from rest where nothing does. With
    /// the instants at which it is looked at; `None` where nothing can start. The outer `None`: stopped.
    fn begin(&self, cell: u64, carried: Option<State>, stop: &Stop) -> Option<Option<(Simulation, Strobe)>> {
        let Self { scene, ensemble, .. } = self;
        let mut worker = scene.worker(stop);
        let departure = match carried {
            None => scene.find(cell, From::Class, &mut worker, stop)?.departures.pop(),
            Some(_) => None,
        };
        let (origin, perturbed) = match departure {
            Some(departure) => (Some(departure.home.origin), Some((ensemble.size, ensemble.seed_of(cell, 0, 0)))),
            None => (scene.origin(cell, carried, &mut worker), None),
        };
        Some(origin.and_then(|origin| {
            let run = origin.run(perturbed, stop)?;
            Some((if ensemble.in_sequence { run.in_sequence() } else { run }, origin.strobe()))
        }))
    }
}

impl Sectioned for Scene {
    /// The masses of the scene's words, and site 0 for families.
    fn watched(&self) -> Vec<usize> {
        let (layout, task) = (self.base.layout, &self.task);
        let of_words = task
            .words
            .iter()
            .flat_map(|word| word.letters())
            .filter_map(|letter| layout.index(letter.site, letter.layer));
        let mut sites: Vec<usize> = of_words.chain((!task.families.is_empty()).then_some(0)).collect();
        sites.sort_unstable();
        sites.dedup();
        sites
    }

    fn carries(&self) -> Result<(), String> {
        Ok(())
    }

    fn origin(&self, cell: u64, state: Option<State>, _: &mut Worker) -> Option<Origin> {
        let model = self.point(cell).model().ok()?;
        let still = || vec![0.0; model.chain().sites()];
        let (u, v) = state.map_or_else(|| (still(), still()), |state| (state.displacement, state.velocity));
        Some(Origin::of_masses(&model, u, v))
    }
}
