//! Cells on many threads. Each thread takes the next few cells, computes them and makes of them what is wanted; the thread
//! that asked puts the results in order. Nobody waits for a slow row, and a sink that waits for its disk stops nobody until
//! it is dozens of blocks behind.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, mpsc};

use rayon::ThreadPool;
use vibrochain_lattice::Stop;

use crate::grid::Grid;
use crate::scene::Scene;
use crate::summary::Summary;

/// A thread takes no more than this part of its share of the cells that are left: so blocks become small towards the end, and all threads
/// end together.
const PART: u64 = 4;

/// Blocks that may be taken before the sink has seen them, per thread: a fraction of a second of cells, some megabytes.
const AHEAD: u64 = 16;

/// What is to be computed, and on what.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a, S = Scene> {
    /// The scene.
    pub scene: &'a S,
    /// The threads.
    pub pool: &'a ThreadPool,
    /// Raised to stop early.
    pub stop: &'a Stop,
}

/// Some neighbouring cells of one part.
#[derive(Debug)]
pub struct Block<T> {
    /// Which of the parts.
    pub part: usize,
    /// The numbers of its cells.
    pub cells: Range<u64>,
    /// Whether it ends its part.
    pub last: bool,
    /// The counts of its cells.
    pub summary: Summary,
    /// What was made of them.
    pub made: T,
}

/// How a sweep ended.
#[derive(Debug, PartialEq)]
pub enum Ended<E, T = Summary> {
    /// All cells are done; what they add up to.
    Complete(T),
    /// The stop flag was raised.
    Stopped,
    /// The sink refused.
    Failed(E),
}

/// What the threads share: the next cells to take.
struct Queue<'a> {
    parts: &'a [Range<u64>],
    threads: u64,
    /// The most cells of a block.
    block: u64,
    ahead: u64,
    state: Mutex<State>,
    moved: Condvar,
}

#[derive(Default)]
struct State {
    part: usize,
    /// Cells taken of this part.
    offset: u64,
    /// Cells of all parts that nobody has taken.
    left: u64,
    taken: u64,
    collected: u64,
    /// Threads that wait for the sink.
    waiting: u64,
    closed: bool,
}

/// A block yet to be computed, and its place in the order.
struct Order {
    number: u64,
    part: usize,
    cells: Range<u64>,
    last: bool,
}

impl Queue<'_> {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next block; waits while the sink is too far behind.
    fn take(&self) -> Option<Order> {
        let mut state = self.lock();
        while !state.closed && state.taken - state.collected >= self.ahead {
            state.waiting += 1;
            state = self.moved.wait(state).unwrap_or_else(PoisonError::into_inner);
            state.waiting -= 1;
        }
        while self.parts.get(state.part).is_some_and(|part| part.is_empty()) {
            state.part += 1;
        }
        let part = self.parts.get(state.part).filter(|_| !state.closed)?;
        let start = part.start + state.offset;
        let block = (state.left / (PART * self.threads)).clamp(1, self.block);
        let end = (start + block).min(part.end);
        let order = Order { number: state.taken, part: state.part, cells: start..end, last: end == part.end };
        state.taken += 1;
        (state.offset, state.left) = (state.offset + end - start, state.left - (end - start));
        if order.last {
            (state.part, state.offset) = (state.part + 1, 0);
        }
        Some(order)
    }

    fn collected(&self) {
        let mut state = self.lock();
        state.collected += 1;
        // Waking nobody is a call of the system, too.
        if state.waiting > 0 {
            self.moved.notify_one();
        }
    }

    fn close(&self) {
        self.lock().closed = true;
        self.moved.notify_all();
    }
}

/// Closes the queue of a thread that panics, or the others would wait for its block for ever.
struct Watch<'a, 'b>(&'a Queue<'b>);

impl Drop for Watch<'_, '_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.close();
        }
    }
}

/// How many cells are taken at a time at most, and how many such blocks before the sink has seen them, per thread.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace {
    pub(super) block: u64,
    pub(super) ahead: u64,
}

/// Computes the cells of all parts, makes `digest` of a few at a time, on any thread, and hands these to `sink` in order,
/// on this one.
pub fn blocks<S: Grid, T: Send, E>(
    job: &Job<'_, S>,
    parts: &[Range<u64>],
    digest: impl Fn(Range<u64>, &[S::Cell]) -> T + Sync,
    sink: impl FnMut(Block<T>) -> Result<(), E>,
) -> Ended<E> {
    let scene = job.scene;
    let pace = Pace { block: scene.block(), ahead: AHEAD };
    let begin = || (scene.worker(job.stop), Vec::new());
    let make = |(worker, cells): &mut (S::Worker, Vec<S::Cell>), range: Range<u64>| {
        scene.compute(worker, range.clone(), job.stop, cells)?;
        let mut summary = Summary::default();
        cells.iter().for_each(|cell| summary.count(&scene.shown(cell)));
        Some((summary, digest(range, cells)))
    };
    in_order(job, parts, pace, begin, make, sink)
}

/// Takes blocks of the cells of all parts, some at a time, on any thread, each of which does what `begin` has given it, and hands what
/// `make` makes of them to `sink` in order, on this one. `make` tells `None` if it was stopped.
pub(super) fn in_order<S: Sync, W, T: Send, E>(
    job: &Job<'_, S>,
    parts: &[Range<u64>],
    pace: Pace,
    begin: impl Fn() -> W + Sync,
    make: impl Fn(&mut W, Range<u64>) -> Option<(Summary, T)> + Sync,
    mut sink: impl FnMut(Block<T>) -> Result<(), E>,
) -> Ended<E> {
    let threads = job.pool.current_num_threads().max(1) as u64;
    let left = parts.iter().map(|part| part.end - part.start).sum();
    let state = Mutex::new(State { left, ..State::default() });
    let (block, ahead) = (pace.block, pace.ahead * threads);
    let queue = Queue { parts, threads, block, ahead, state, moved: Condvar::new() };
    let stopped = AtomicBool::new(job.stop.is_raised());
    // Before a worker takes its memory.
    if stopped.load(Ordering::Relaxed) {
        return Ended::Stopped;
    }
    let mut total = Summary::default();
    let mut failure = None;
    job.pool.in_place_scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        for _ in 0..threads {
            let (sender, queue, begin, make, stopped) = (sender.clone(), &queue, &begin, &make, &stopped);
            scope.spawn(move |_| {
                let _watch = Watch(queue);
                let mut worker = begin();
                while let Some(order) = queue.take() {
                    let Order { number, part, cells, last } = order;
                    let Some((summary, made)) = make(&mut worker, cells.clone()) else {
                        stopped.store(true, Ordering::Relaxed);
                        queue.close();
                        return;
                    };
                    // A collector that has gone wants nothing more.
                    let _ = sender.send((number, Block { part, cells, last, summary, made }));
                }
            });
        }
        drop(sender);
        let mut waiting = BTreeMap::new();
        let mut next = 0;
        for (number, block) in receiver {
            waiting.insert(number, block);
            while let Some(block) = waiting.remove(&next) {
                next += 1;
                queue.collected();
                total.add(&block.summary);
                if failure.is_none()
                    && let Err(error) = sink(block)
                {
                    failure = Some(error);
                    queue.close();
                }
            }
        }
    });
    match failure {
        Some(error) => Ended::Failed(error),
        None if stopped.load(Ordering::Relaxed) => Ended::Stopped,
        None => Ended::Complete(total),
    }
}

/// Computes all cells of a scene and hands them to `sink` in order, some at a time, with the number of the first. `tick`
/// is called, from any thread, with each number of cells that is done.
pub fn sweep<S: Grid, E>(
    scene: &S,
    pool: &ThreadPool,
    stop: &Stop,
    tick: impl Fn(u64) + Sync,
    mut sink: impl FnMut(Range<u64>, &[S::Cell]) -> Result<(), E>,
) -> Ended<E> {
    let whole = 0..scene.cells();
    let digest = |range: Range<u64>, cells: &[S::Cell]| {
        tick(range.end - range.start);
        cells.to_vec()
    };
    blocks(&Job { scene, pool, stop }, &[whole], digest, |block| sink(block.cells, &block.made))
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;

    fn scene() -> Scene {
        let text = r#"
            [model]
            sites = 3
            gamma1 = 0.2
            asymmetry = 0.4
            [sweep]
            x = { parameter = "omega", from = 0.4, to = 3.0, points = 40 }
            y = { parameter = "gamma2", from = 0.0, to = 0.3, points = 60 }
            [compute]
            families = ["double-sided"]
        "#;
        Scene::parse(Path::new("scene.toml"), text).unwrap()
    }

    fn pool(threads: usize) -> ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    #[test]
    fn every_cell_of_every_part_comes_once_and_in_order() {
        let scene = scene();
        let stop = Stop::default();
        for threads in [1, 3] {
            let pool = pool(threads);
            let job = Job { scene: &scene, pool: &pool, stop: &stop };
            let parts = [5..5, 7..1000, 1000..1001, 30..40, 2399..2400, 9..9];
            let (mut seen, mut ends) = (Vec::new(), Vec::new());
            let ended = blocks(
                &job,
                &parts,
                |range, cells| (range.count(), cells.len()),
                |block| {
                    assert_eq!(block.made.0, block.made.1);
                    assert_eq!(block.summary.cells(), block.made.1 as u64);
                    if block.last {
                        ends.push(block.part);
                    }
                    seen.extend(block.cells);
                    Ok::<_, ()>(())
                },
            );
            assert!(matches!(ended, Ended::Complete(summary) if summary.cells() == 1005));
            assert_eq!(seen, parts.iter().cloned().flatten().collect::<Vec<_>>());
            assert_eq!(ends, [1, 2, 3, 4]);
        }
    }

    #[test]
    fn a_sink_that_refuses_and_a_flag_that_is_raised_end_it() {
        let (scene, pool) = (scene(), pool(2));
        let flag = Arc::new(AtomicBool::new(false));
        let stop = Stop::from(&flag);
        let mut left = 3;
        let ended = super::sweep(
            &scene,
            &pool,
            &stop,
            |_| {},
            |_, _| {
                left -= 1;
                if left == 0 { Err("full") } else { Ok(()) }
            },
        );
        assert!(matches!(ended, Ended::Failed("full")) && left == 0);
        // By the one thread that computes, after its first block: it begins no other. (Raised by the sink it could come when all
        // are computed.)
        let raise = |_| flag.store(true, Ordering::Relaxed);
        let ended = super::sweep(&scene, &self::pool(1), &stop, raise, |_, _| Ok::<_, ()>(()));
        assert!(matches!(ended, Ended::Stopped));
    }
}
