//! The sweep itself: rows in parallel, results in a fixed order whatever the number of threads.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::ThreadPool;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use crate::cell::{Cell, Class, Status, Worker};
use crate::scene::Scene;

/// Rows in flight per thread: enough that no thread waits for a slow row, few enough that memory stays small.
const ROWS_PER_THREAD: usize = 8;

/// Counts of a finished sweep.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Summary {
    /// Cells per class, in the order of [`Class::ALL`].
    pub classes: [u64; Class::ALL.len()],
    /// Cells per status, in the order of [`Status::ALL`].
    pub statuses: [u64; Status::ALL.len()],
    /// Largest residual of any physical orbit.
    pub worst_residual: f64,
}

impl Summary {
    fn count(&mut self, cell: &Cell) {
        if let Some(class) = cell.class {
            self.classes[class as usize] += 1;
        }
        self.statuses[cell.status as usize] += 1;
        self.worst_residual = self.worst_residual.max(cell.residual);
    }
}

/// How a sweep ended.
#[derive(Debug)]
pub enum Ended<E> {
    /// All rows are done.
    Complete(Summary),
    /// The stop flag was raised.
    Stopped,
    /// The sink refused a row.
    Failed(E),
}

/// Computes all cells, row by row (rows along x, from y's first value to its last), and hands each row to `sink` in that
/// order. `tick` is called, from any thread, after each row.
pub fn sweep<E>(
    scene: &Scene,
    pool: &ThreadPool,
    stop: &AtomicBool,
    tick: impl Fn() + Sync,
    mut sink: impl FnMut(usize, &[Cell]) -> Result<(), E>,
) -> Ended<E> {
    let mut summary = Summary::default();
    let block = ROWS_PER_THREAD * pool.current_num_threads().max(1);
    let mut first = 0;
    while first < scene.y.points {
        // Before a worker and its rows take their memory.
        if stop.load(Ordering::Relaxed) {
            return Ended::Stopped;
        }
        let rows = first..(first + block).min(scene.y.points);
        let computed: Vec<Option<Vec<Cell>>> = pool.install(|| {
            rows.clone()
                .into_par_iter()
                .map_init(
                    || Worker::new(scene.base.sites),
                    |worker, j| {
                        let cells = row(scene, worker, j, stop);
                        tick();
                        cells
                    },
                )
                .collect()
        });
        for (j, cells) in rows.zip(computed) {
            let Some(cells) = cells else { return Ended::Stopped };
            cells.iter().for_each(|cell| summary.count(cell));
            if let Err(error) = sink(j, &cells) {
                return Ended::Failed(error);
            }
        }
        first += block;
    }
    Ended::Complete(summary)
}

/// One row; `None` if stopped midway.
fn row(scene: &Scene, worker: &mut Worker, j: usize, stop: &AtomicBool) -> Option<Vec<Cell>> {
    let mut cells = Vec::with_capacity(scene.x.points);
    for i in 0..scene.x.points {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        // The scene's corners were checked, so that every point between is a valid model.
        let model = scene.point(i, j).model().ok()?;
        cells.push(worker.cell(&model, &scene.task));
    }
    Some(cells)
}
