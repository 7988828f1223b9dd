//! Sweeps: cells in parallel, results in a fixed order whatever the number of threads, in chunks that outlive the process.
//!
//! | module | holds |
//! |---|---|
//! | `engine` | cells on many threads, handed on in order |
//! | `plan` | how a scene is cut into chunks, and what tells two sweeps apart |
//! | `chunk` | the file of one chunk |
//! | `store` | the folder of chunks |
//! | `shard` | which chunks are whose |
//! | `work` | computes the chunks that are missing |
//! | `assemble` | the table, of rows as they come or of all chunks |

mod assemble;
mod chunk;
mod engine;
mod plan;
mod shard;
mod store;
mod work;

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use rayon::ThreadPool;

use crate::cell::{Cell, Class, Status};
use crate::scene::Scene;

pub(crate) use crate::sweep::assemble::{Assembly, Unassembled};
pub(crate) use crate::sweep::chunk::{Fault, Writer};
pub use crate::sweep::engine::{Block, Ended, Job, blocks};
pub use crate::sweep::plan::Plan;
pub use crate::sweep::shard::{Shard, ShardFlag};
pub(crate) use crate::sweep::store::{Claim, Store};
pub(crate) use crate::sweep::work::{Grown, Todo, Worked, rows, work};

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
    /// Of these cells.
    pub fn of(cells: &[Cell]) -> Self {
        let mut summary = Self::default();
        for cell in cells {
            if let Some(class) = cell.class {
                summary.classes[class as usize] += 1;
            }
            summary.statuses[cell.status as usize] += 1;
            summary.worst_residual = summary.worst_residual.max(cell.residual);
        }
        summary
    }

    /// Adds the counts of other cells.
    pub fn add(&mut self, other: &Self) {
        self.classes.iter_mut().zip(other.classes).for_each(|(count, more)| *count += more);
        self.statuses.iter_mut().zip(other.statuses).for_each(|(count, more)| *count += more);
        self.worst_residual = self.worst_residual.max(other.worst_residual);
    }

    /// Number of cells counted.
    pub fn cells(&self) -> u64 {
        self.statuses.iter().sum()
    }
}

/// Computes all cells of a scene and hands them to `sink` in order, some at a time, with the number of the first. `tick`
/// is called, from any thread, with each number of cells that is done.
pub fn sweep<E>(
    scene: &Scene,
    pool: &ThreadPool,
    stop: &AtomicBool,
    tick: impl Fn(u64) + Sync,
    mut sink: impl FnMut(Range<u64>, &[Cell]) -> Result<(), E>,
) -> Ended<E> {
    let whole = 0..scene.cells();
    let digest = |range: Range<u64>, cells: &[Cell]| {
        tick(range.end - range.start);
        cells.to_vec()
    };
    blocks(&Job { scene, pool, stop }, &[whole], digest, |block| sink(block.cells, &block.made))
}
