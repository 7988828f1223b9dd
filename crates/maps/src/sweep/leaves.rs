//! The leaves of cells that are refined, on many threads.

use std::ops::Range;

use super::engine::{Block, Ended, Job, Pace, in_order};
use super::refiner::{RefineContext, Refiner};
use crate::cell::Cell;
use crate::grid::Grid;
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
    context: &RefineContext<'_>,
    parts: &[Range<u64>],
    digest: impl Fn(Range<u64>, Vec<(u64, Cell)>) -> T + Sync,
    sink: impl FnMut(Block<T>) -> Result<(), E>,
) -> Ended<E> {
    let block = (MOST_LEAVES / job.scene.cells_within()).clamp(1, BLOCK);
    let begin = || Refiner::new(context, job.stop);
    let make = |refiner: &mut Refiner<'_, '_>, range: Range<u64>| {
        let found = refiner.leaves(range.clone())?;
        let mut summary = Summary::default();
        found.iter().for_each(|(_, leaf)| summary.count(leaf));
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
    let Some(context) = RefineContext::new(job) else { return Ended::Complete(Summary::default()) };
    let digest = |range: Range<u64>, leaves: Vec<(u64, Cell)>| {
        tick(range.end - range.start);
        leaves
    };
    leaves(job, &context, parts, digest, |block| sink(&block.made))
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::path::Path;

    use rayon::ThreadPool;
    use rayon::iter::{IntoParallelIterator, ParallelIterator};
    use vibrochain_lattice::Stop;

    use super::*;
    use crate::cell::Worker;
    use crate::extent::Extent;
    use crate::scene::Scene;
    use crate::sweep::covered::Covered;
    use crate::sweep::engine::sweep;
    use crate::sweep::orders::{CellOrderFinder, CellOrders};
    use crate::sweep::refiner::are_alike;

    const SCENE: &str = r#"
        [model]
        sites = 5
        gamma1 = 0.2
        asymmetry = 0.4
        [sweep]
        x = { parameter = "omega", from = 0.4, to = 3.0, points = 40 }
        y = { parameter = "gamma2", from = 0.0, to = 0.3, points = 30 }
        refine = { depth = 3 }
        [compute]
        families = ["double-sided", "single-sided"]
        stability = true
        collisions = true
    "#;

    /// The rule in plain words, of all cells of the finest grid.
    struct Plain<'a> {
        cells: &'a [Cell],
        /// Where they tell of stripes.
        orders: &'a [Option<CellOrders>],
        size: [u32; 2],
        whole: u32,
        stripes: &'a Covered,
    }

    impl Plain<'_> {
        fn index(&self, [column, row]: [u32; 2]) -> usize {
            let [columns, rows] = self.size;
            (row.min(rows - 1) * columns + column.min(columns - 1)) as usize
        }

        fn cell(&self, at: [u32; 2]) -> Cell {
            self.cells[self.index(at)]
        }

        fn is_halved(&self, square: Extent) -> bool {
            let Extent { column, row, size } = square;
            let cell = self.cell([column, row]);
            let lives = |cell: &Cell| (cell.class, cell.mechanism, cell.solutions);
            let beside = [[column + size, row], [column, row + size], [column + size, row + size]];
            if size == 1 {
                return false;
            }
            let beside = beside.map(|at| self.first_of_leaf(at, size));
            let mut orders: Vec<_> = beside.iter().chain(&[[column, row]]).filter_map(|at| self.order(*at)).collect();
            orders.dedup();
            let differs = |at: &[u32; 2]| lives(&self.cell(*at)) != lives(&cell);
            orders.len() > 1 || self.stripes.divides(square, cell.class) || beside.iter().any(differs)
        }

        fn order(&self, at: [u32; 2]) -> Option<CellOrders> {
            self.orders.get(self.index(at)).copied().flatten()
        }

        /// Where the leaf at a place begins, halved down to squares of some size.
        fn first_of_leaf(&self, at: [u32; 2], least: u32) -> [u32; 2] {
            if at.iter().zip(self.size).any(|(place, points)| *place >= points) {
                return at;
            }
            let mut size = self.whole;
            loop {
                let [column, row] = at.map(|place| place / size * size);
                if size == least || !self.is_halved(Extent { column, row, size }) {
                    return [column, row];
                }
                size /= 2;
            }
        }

        fn leaves(&self, square: Extent, found: &mut Vec<Cell>) {
            if !self.is_halved(square) {
                return found.push(Cell { extent: Some(square), ..self.cell(square.sample()) });
            }
            let first = found.len();
            square.quarters().into_iter().for_each(|quarter| self.leaves(quarter, found));
            let (one, others) = found[first..].split_first().unwrap();
            if others.len() == 3 && others.iter().all(|other| are_alike(one, other)) {
                found.truncate(first + 1);
                found[first].extent = Some(square);
            }
        }
    }

    fn pool(threads: usize) -> ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    fn leaves_of(scene: &Scene, threads: usize, parts: &[Range<u64>]) -> Vec<(u64, Cell)> {
        let (pool, stop, mut all) = (pool(threads), Stop::default(), Vec::new());
        let ended = refined(
            &Job { scene, pool: &pool, stop: &stop },
            parts,
            |_| {},
            |some| {
                all.extend_from_slice(some);
                Ok::<_, ()>(())
            },
        );
        assert!(matches!(ended, Ended::Complete(summary) if summary.computed == all.len() as u64));
        // What was computed and is not written counts for this alone.
        all.iter_mut().for_each(|(_, cell)| cell.residual = 0.0);
        all
    }

    #[test]
    fn leaves_are_those_of_the_rule_in_plain_words() {
        let existence = SCENE.replace("stability = true", "").replace("collisions = true", "");
        let words = SCENE.replace("\"double-sided\", ", "\"0+1+,0-1-\", ").replace("sites = 5", "sites = 6");
        for (text, merged) in [(SCENE, 500), (existence.as_str(), 50), (words.as_str(), 200)] {
            let scene = Scene::parse(Path::new("scene.toml"), text).unwrap();
            let (finest, stop) = (scene.finest(), Stop::default());
            let mut cells = Vec::new();
            let keep = |_, some: &[Cell]| {
                cells.extend_from_slice(some);
                Ok::<_, ()>(())
            };
            assert!(matches!(sweep(&finest, &pool(2), &stop, |_| {}, keep), Ended::Complete(_)));
            cells.iter_mut().for_each(|cell| cell.residual = 0.0);
            let size = [320, 240];
            let (mut stripes, mut orders) = (Covered::default(), Vec::new());
            if scene.follows_orders() {
                let finders = || (Worker::new(6), CellOrderFinder::default());
                let of_cell = |(worker, orders): &mut (Worker, CellOrderFinder), number| {
                    let model = finest.point(number).model().unwrap();
                    orders.cell(worker, &model, &finest.task).1
                };
                orders = (0..finest.cells()).into_par_iter().map_init(finders, of_cell).collect();
                assert!(orders.iter().collect::<HashSet<_>>().len() > 5);
            } else {
                stripes = Covered::of(&finest, &stop);
            }
            let plain = Plain { cells: &cells, orders: &orders, size, whole: 8, stripes: &stripes };
            let (mut expected, mut quarters) = (Vec::new(), 0);
            for number in 0..scene.cells() {
                let (whole, mut some) = (scene.extent(number).unwrap(), Vec::new());
                plain.leaves(whole, &mut some);
                quarters += some.iter().filter(|leaf| plain.is_halved(leaf.extent.unwrap())).count();
                expected.extend(some.into_iter().map(|leaf| (number, leaf)));
            }
            // Many are four quarters that are alike.
            assert!(quarters > merged, "{quarters}");
            let all = scene.cells();
            for (threads, parts) in [
                (3, std::iter::once(0..all).collect()),
                (1, (0..all).map(|number| number..number + 1).collect()),
                (2, vec![0..1, 1..77, 77..400, 400..all]),
            ] {
                assert!(leaves_of(&scene, threads, &parts) == expected, "{threads} {}", parts.len());
            }
            // Of some cells alone, the last first.
            let parts = [700..all, 5..9, 300..700];
            let of = |part: &Range<u64>| expected.iter().filter(|(number, _)| part.contains(number)).copied().collect();
            let some: Vec<Vec<_>> = parts.iter().map(of).collect();
            assert!(leaves_of(&scene, 2, &parts) == some.concat());
        }
    }
}
