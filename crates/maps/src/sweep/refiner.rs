//! Leaves of a grid that is refined where its cells differ.
//!
//! A cell is halved along both axes if what lives there is not what lives in one of the cells beside it, as far as these are refined
//! themselves by then. Whether it is follows from cells at most two of the grid's away, whoever asks: so leaves are the same
//! in whatever order, and by however many processes, they are found. Nothing is computed that no answer depends on.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use vibrochain_floquet::Mechanism;

use super::covered::Covered;
use super::engine::Job;
use crate::cell::{Cell, Class, Worker};
use crate::extent::Extent;
use crate::scene::Scene;

/// What all threads share: the cells of the grid that is refined, each computed once, and where more is to be seen than they show.
pub(super) struct Ground<'a> {
    scene: &'a Scene,
    /// The scene of the finest grid.
    finest: Scene,
    /// Columns and rows of the finest grid.
    size: [u32; 2],
    /// Sides of a cell of the grid, in cells of the finest.
    whole: u32,
    cells: Vec<OnceLock<Cell>>,
    stripes: Covered,
}

impl<'a> Ground<'a> {
    /// Of a scene that is refined; nothing of one that is not.
    pub(super) fn new(job: &Job<'a>) -> Option<Self> {
        let scene = job.scene;
        let whole = scene.refine?.size();
        let [x, y] = scene.plane()?.map(|axis| axis.points() as u32 * whole);
        let cells = (0..scene.cells()).map(|_| OnceLock::new()).collect();
        let finest = scene.finest();
        let stripes = job.pool.install(|| Covered::of(&finest, job.stop));
        Some(Self { scene, finest, size: [x, y], whole, cells, stripes })
    }
}

/// What must be alike for two cells to be one leaf.
type Lives = (Option<Class>, Option<Mechanism>, u32);

fn lives(cell: &Cell) -> Lives {
    (cell.class, cell.mechanism, cell.solutions)
}

/// Mixes numbers that are places: of a grid, so that neighbours must not fall on one another. The multiplier is 2⁶⁴ over the golden ratio.
#[derive(Default)]
struct Mixed(u64);

impl Hasher for Mixed {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_u64(u64::from(*byte)));
    }

    fn write_u64(&mut self, number: u64) {
        let product = u128::from(self.0.rotate_left(5) ^ number) * 0x9e37_79b9_7f4a_7c15;
        self.0 = (product as u64) ^ (product >> 64) as u64;
    }
}

/// Answers by place, of the cells under way and of those before, which may be their neighbours.
struct Memory<T> {
    new: HashMap<u64, T, BuildHasherDefault<Mixed>>,
    old: HashMap<u64, T, BuildHasherDefault<Mixed>>,
}

impl<T: Copy> Memory<T> {
    fn new() -> Self {
        Self { new: HashMap::default(), old: HashMap::default() }
    }

    fn get(&mut self, key: u64) -> Option<T> {
        if let Some(known) = self.new.get(&key) {
            return Some(*known);
        }
        let known = self.old.remove(&key)?;
        self.new.insert(key, known);
        Some(known)
    }

    fn insert(&mut self, key: u64, value: T) -> T {
        self.new.insert(key, value);
        value
    }

    fn age(&mut self) {
        std::mem::swap(&mut self.new, &mut self.old);
        self.new.clear();
    }
}

/// Who finds leaves, one a thread.
pub(super) struct Refiner<'a, 'b> {
    ground: &'a Ground<'b>,
    stop: &'a AtomicBool,
    worker: Worker,
    /// Cells of the finest grid that have been computed.
    cells: Memory<Cell>,
    /// Whether squares are halved.
    halved: Memory<bool>,
}

/// A number for a place of the finest grid: 2²⁰ columns and rows at most.
fn key([column, row]: [u32; 2]) -> u64 {
    u64::from(row) << 32 | u64::from(column)
}

impl<'a, 'b> Refiner<'a, 'b> {
    pub(super) fn new(ground: &'a Ground<'b>, stop: &'a AtomicBool) -> Self {
        let worker = Worker::new(ground.scene.base.sites());
        Self { ground, stop, worker, cells: Memory::new(), halved: Memory::new() }
    }

    /// The leaves of some cells of the grid, one after the other: of each those of its first quarter first. `None` if it was stopped.
    pub(super) fn leaves(&mut self, range: Range<u64>, each: &mut dyn FnMut(u64, Cell)) -> Option<()> {
        self.cells.age();
        self.halved.age();
        for number in range {
            let whole = self.ground.scene.extent(number)?;
            self.of_square(whole, &mut |cell| each(number, cell))?;
        }
        Some(())
    }

    fn of_square(&mut self, square: Extent, each: &mut dyn FnMut(Cell)) -> Option<()> {
        if self.is_halved(square)? {
            return square.quarters().into_iter().try_for_each(|quarter| self.of_square(quarter, each));
        }
        let cell = self.cell(square)?;
        each(Cell { extent: Some(square), ..cell });
        Some(())
    }

    /// What was computed for a square.
    fn cell(&mut self, square: Extent) -> Option<Cell> {
        let Ground { scene, finest, size, whole, cells, .. } = self.ground;
        let sample = square.sample();
        let compute = |worker: &mut Worker| {
            if self.stop.load(Ordering::Relaxed) {
                return None;
            }
            let number = u64::from(sample[1]) * u64::from(size[0]) + u64::from(sample[0]);
            // The scene's corners were checked, so that every point between is a valid model.
            let model = finest.point(number).model().ok()?;
            Some(worker.cell(&model, &scene.task))
        };
        // The one of a whole cell is computed once, for all threads.
        let of_whole = Extent { column: sample[0] & !(whole - 1), row: sample[1] & !(whole - 1), size: *whole };
        // As numbers: two halves just written and read again as one would wait for the writing, as long as all the rest of this takes.
        if key(of_whole.sample()) == key(sample) {
            let columns = u64::from(size[0] / whole);
            let number = u64::from(sample[1] / whole) * columns + u64::from(sample[0] / whole);
            let place = cells.get(number as usize)?;
            if let Some(cell) = place.get() {
                return Some(*cell);
            }
            let cell = compute(&mut self.worker)?;
            return Some(*place.get_or_init(|| cell));
        }
        if let Some(cell) = self.cells.get(key(sample)) {
            return Some(cell);
        }
        let cell = compute(&mut self.worker)?;
        Some(self.cells.insert(key(sample), cell))
    }

    /// What lives in the leaf that a square is a part of, or in the square itself if it is one or is halved.
    fn lives_about(&mut self, square: Extent) -> Option<Lives> {
        let mask = self.ground.whole - 1;
        let mut at = Extent { column: square.column & !mask, row: square.row & !mask, size: self.ground.whole };
        while at.size > square.size && self.is_halved(at)? {
            let size = at.size / 2;
            at = Extent { column: square.column & !(size - 1), row: square.row & !(size - 1), size };
        }
        self.cell(at).as_ref().map(lives)
    }

    /// Whether a square is halved, as far as its own size is asked: only squares of one that is halved are there.
    fn is_halved(&mut self, square: Extent) -> Option<bool> {
        if square.size == 1 {
            return Some(false);
        }
        // Squares of different sizes have different middles.
        let middle = [square.column, square.row].map(|first| 2 * first + square.size);
        if let Some(known) = self.halved.get(key(middle)) {
            return Some(known);
        }
        let halved = self.differs(square)?;
        Some(self.halved.insert(key(middle), halved))
    }

    fn differs(&mut self, square: Extent) -> Option<bool> {
        let cell = self.cell(square)?;
        let here = lives(&cell);
        if self.ground.stripes.divides(square, cell.class) {
            return Some(true);
        }
        // A border between two points that were computed lies in the square of the lower one: so it is halved, and the other is not.
        let Extent { column, row, size } = square;
        let next = [column, row].map(|first| first + size);
        for (column, row) in [(next[0], row), (column, next[1]), (next[0], next[1])] {
            if self.lives_beside(Extent { column, row, size })? != here {
                return Some(true);
            }
        }
        Some(false)
    }

    /// What lives in the first cell of a square, or, beyond the last column or row, in that.
    fn lives_beside(&mut self, square: Extent) -> Option<Lives> {
        let [columns, rows] = self.ground.size;
        if square.column < columns && square.row < rows {
            return self.lives_about(square);
        }
        let last = Extent { column: square.column.min(columns - 1), row: square.row.min(rows - 1), size: 1 };
        self.cell(last).as_ref().map(lives)
    }
}
