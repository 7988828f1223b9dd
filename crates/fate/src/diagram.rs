//! Bifurcation diagrams by simulation: along one parameter, where runs are once a period when they have had time to settle.

use rayon::iter::{IntoParallelIterator, ParallelIterator};
use vibrochain_breather::Orbit;
use vibrochain_eventsim::Simulation;
use vibrochain_lattice::{Barrier, Model, Stop};
use vibrochain_maps::cell::Worker;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::sweep::{Ended, Job};

use crate::ensemble::Ensemble;
use crate::origin::Reached;
use crate::run::reach;
use crate::section::Strobe;
use crate::start::Start;

/// Cells whose points wait for each other, and how many numbers they may be together: a quarter of a gigabyte.
const BLOCK: u64 = 64;
const MOST_WAITING: u64 = 1 << 24;

/// Points of one cell at most.
pub const MAX_POINTS: u64 = 100_000;

/// One point of a section: displacement and velocity of each site that is looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionPoint {
    /// Periods of the force since the start.
    pub period: u64,
    /// (u, u̇) of each site, in the order of [`Diagram::sites`].
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

/// A diagram that is asked for.
#[derive(Debug, Clone)]
pub struct Diagram<'a> {
    /// The scene, with one axis.
    pub scene: &'a Scene,
    /// How long a run is, and how its start is perturbed.
    pub ensemble: &'a Ensemble,
    /// Section points kept of each run.
    pub points: u64,
    /// Whether each run goes on from the end of the one before: cells then follow each other, and branches that live side by side are
    /// followed one at a time.
    pub carry: bool,
}

/// Where a run begins.
type State = (Vec<f64>, Vec<f64>, f64);

impl Diagram<'_> {
    /// The masses that are looked at: those of the scene's words, and site 0 for families.
    #[must_use]
    pub fn sites(&self) -> Vec<usize> {
        let layout = self.scene.base.layout;
        let task = &self.scene.task;
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

    /// Computes all cells and hands them to `sink` in order. `tick` is called with each number of cells that is done.
    pub fn compute<E>(
        &self,
        job: &Job<'_>,
        tick: impl Fn(u64) + Sync,
        mut sink: impl FnMut(Column) -> Result<(), E>,
    ) -> Ended<E, ()> {
        let cells = self.scene.cells();
        let numbers = (2 * self.points).saturating_mul(self.sites().len() as u64).max(1);
        let block = if self.carry { 1 } else { (MOST_WAITING / numbers).clamp(1, BLOCK) };
        let mut carried: Option<State> = None;
        let mut first = 0;
        while first < cells {
            let numbers = first..(first + block).min(cells);
            first = numbers.end;
            let of = |number| {
                let column = self.column(number, carried.clone(), job.stop);
                tick(1);
                column
            };
            let done: Vec<_> = job.pool.install(|| numbers.into_par_iter().map(of).collect());
            for column in done {
                let Some((column, end)) = column else { return Ended::Stopped };
                carried = Some(end).filter(|_| self.carry && column.complete);
                if let Err(error) = sink(column) {
                    return Ended::Failed(error);
                }
            }
        }
        Ended::Complete(())
    }

    /// One run. `None` if stopped.
    fn column(&self, number: u64, carried: Option<State>, stop: &Stop) -> Option<(Column, State)> {
        if stop.is_raised() {
            return None;
        }
        let model = self.scene.point(number).model().ok()?;
        let (u, v, psi) = match carried {
            Some((u, v, psi)) => (within(u, &model), v, psi),
            None => self.start(number, &model, stop),
        };
        let incomplete = |points| Column { number, points, complete: false };
        let Ok(mut simulation) = Simulation::new(&model, psi, &u, &v) else {
            return Some((incomplete(Vec::new()), (u, v, psi)));
        };
        let (sites, strobe) = (self.sites(), Strobe::new(&model, psi, 0.0));
        let (mut points, first) = (Vec::new(), self.ensemble.periods.saturating_sub(self.points));
        for period in 0..self.ensemble.periods {
            if stop.is_raised() {
                return None;
            }
            // A whole period at a time before the first point, so that nothing takes long to be stopped.
            if reach(&mut simulation, None, strobe.time(period), stop, |_| {})? != Reached::Time {
                return Some((incomplete(points), (u, v, psi)));
            }
            if period >= first {
                let state = simulation.state();
                let states = sites.iter().map(|&n| (state.displacement[n], state.velocity[n])).collect();
                points.push(SectionPoint { period, states });
            }
        }
        let state = simulation.state();
        // At a point of the section the phase is 0.
        Some((Column { number, points, complete: true }, (state.displacement, state.velocity, 0.0)))
    }

    /// The breather that gives the cell its class, perturbed; where there is none, rest.
    fn start(&self, number: u64, model: &Model, stop: &Stop) -> State {
        let sites = model.chain().sites();
        let mut best: Option<Orbit> = None;
        Worker::new(sites).until(stop).examine(model, &self.scene.task, |orbit, better| {
            if better {
                best = Some(orbit.clone());
            }
        });
        match best.and_then(|orbit| Start::on(&orbit).ok()) {
            Some(mut start) => {
                start.perturb_at_random(model, self.ensemble.size, self.ensemble.seed_of(number, 0, 0));
                (start.displacement, start.velocity, start.psi)
            }
            None => (vec![0.0; sites], vec![0.0; sites], 0.0),
        }
    }
}

/// Displacements of another model's run, brought between the barriers of this one.
fn within(mut u: Vec<f64>, model: &Model) -> Vec<f64> {
    let [low, high] = [Barrier::Lower, Barrier::Upper].map(|barrier| model.barrier(barrier));
    u.iter_mut().for_each(|u| *u = u.clamp(low, high));
    u
}
