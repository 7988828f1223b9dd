//! The leaves of cells that are refined, on many threads.

use std::ops::Range;

use super::engine::{Block, Ended, Job, Pace, in_order};
use super::refiner::{Ground, Refiner};
use crate::cell::Cell;
use crate::summary::Summary;

/// The most cells taken at a time. Two rows above and two below are looked at besides, as far as they decide what is refined.
const BLOCK: u64 = 1024;

/// The most leaves that a block may have, if all is refined to the end: 200 MB.
const MOST_LEAVES: u64 = 1 << 20;

/// Blocks that may be taken before the sink has seen them, per thread: most have some ten thousand leaves, 3 MB.
const AHEAD: u64 = 4;

/// Finds the leaves of the cells of all parts, makes `digest` of those of some neighbours at a time, on any thread, and hands these to
/// `sink` in order, on this one. Leaves come by the numbers of their cells.
pub(super) fn leaves<T: Send, E>(
    job: &Job<'_>,
    ground: &Ground<'_>,
    parts: &[Range<u64>],
    digest: impl Fn(Range<u64>, Vec<(u64, Cell)>) -> T + Sync,
    sink: impl FnMut(Block<T>) -> Result<(), E>,
) -> Ended<E> {
    let block = (MOST_LEAVES / job.scene.cells_within()).clamp(1, BLOCK);
    let begin = || Refiner::new(ground, job.stop);
    let make = |refiner: &mut Refiner<'_, '_>, range: Range<u64>| {
        let (mut found, mut summary) = (Vec::new(), Summary::default());
        refiner.leaves(range.clone(), &mut |number, leaf| {
            summary.count(&leaf);
            found.push((number, leaf));
        })?;
        Some((summary, digest(range, found)))
    };
    in_order(job, parts, Pace { block, ahead: AHEAD }, begin, make, sink)
}

/// Finds the leaves of the cells of `parts` of a scene that is refined and hands those of some neighbouring cells at a time to `sink`, in
/// order, each with the number of its cell. `tick` is called, from any thread, with each number of cells that is done. A scene that is not
/// refined has none: its cells are those of [`sweep`](super::sweep()).
pub fn refined<E>(
    job: &Job<'_>,
    parts: &[Range<u64>],
    tick: impl Fn(u64) + Sync,
    mut sink: impl FnMut(&[(u64, Cell)]) -> Result<(), E>,
) -> Ended<E> {
    let Some(ground) = Ground::new(job) else { return Ended::Complete(Summary::default()) };
    let digest = |range: Range<u64>, leaves: Vec<(u64, Cell)>| {
        tick(range.end - range.start);
        leaves
    };
    leaves(job, &ground, parts, digest, |block| sink(&block.made))
}
