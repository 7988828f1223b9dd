//! Leaves of a grid that is refined where its cells differ.
//!
//! A cell is halved along both axes if what lives there is not what lives in one of the cells beside it, as far as these are refined
//! themselves by then. Whether it is follows from cells at most two of the grid's away, whoever asks: so leaves are the same
//! in whatever order, and by however many processes, they are found. Nothing is computed that no answer depends on.
//!
//! A cell that a stripe passes is halved, too. Stripes of conservative families are followed beforehand (`covered`). In maps with impact words
//! the orders of signatures (`orders`) are told at each point where a square begins; if the four at and beside a square differ, a stripe passes.
//!
//! Where the border lies beyond all four quarters they are alike, and one leaf again. That changes what is written, and not what is halved:
//! no neighbour sees it. Of squares of two columns and rows no decision hangs on the quarters but the first, so these are computed only as
//! far as the leaves depend on them: not where the squares on both sides are alike, if all others turn out to be, too, nor where it is the
//! edge of a stripe that lies between, and that is known to be beyond them.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::OnceLock;

use vibrochain_breather::Family;
use vibrochain_floquet::Mechanism;
use vibrochain_lattice::{Point, Stop};

use super::covered::Covered;
use super::engine::Job;
use super::orders::{CellOrderFinder, CellOrders};
use super::tiles::{Sample, Tiles};
use crate::cell::{Cell, Class, Worker};
use crate::extent::Extent;
use crate::grid::Grid;
use crate::scene::Scene;

/// What all threads share: the cells of the grid that is refined, each computed once, and where more is to be seen than they show.
pub(super) struct RefineContext<'a> {
    scene: &'a Scene,
    /// The scene of the finest grid.
    finest: Scene,
    /// Columns and rows of the finest grid.
    size: [u32; 2],
    /// Sides of a cell of the grid, in cells of the finest.
    whole: u32,
    cells: Vec<OnceLock<Sample>>,
    stripes: Covered,
    /// Whether orders of signatures tell where a stripe passes. Then none is followed beforehand.
    ordered: bool,
}

impl<'a> RefineContext<'a> {
    /// Of a scene that is refined; nothing of one that is not.
    pub(super) fn new(job: &Job<'a>) -> Option<Self> {
        let scene = job.scene;
        let whole = scene.refine?.size();
        let [x, y] = scene.plane()?.map(|axis| axis.points() as u32 * whole);
        let cells = (0..scene.cells()).map(|_| OnceLock::new()).collect();
        let finest = scene.finest();
        let ordered = scene.follows_orders();
        let stripes = if ordered { Covered::default() } else { job.pool.install(|| Covered::of(&finest, job.stop)) };
        Some(Self { scene, finest, size: [x, y], whole, cells, stripes, ordered })
    }
}

/// What must be alike for two cells to be one leaf.
type Lives = (Option<Class>, Option<Mechanism>, u32);

fn lives(cell: &Cell) -> Lives {
    (cell.class, cell.mechanism, cell.solutions)
}

/// What lives in a cell, and the orders of its signatures, if they are known.
#[derive(Debug, Clone, Copy)]
struct Seen {
    lives: Lives,
    orders: Option<CellOrders>,
}

impl Seen {
    fn of(sample: &Sample) -> Self {
        Self { lives: lives(&sample.cell), orders: sample.orders }
    }
}

/// Whether a stripe passes between some of these: orders that are known differ.
fn are_parted(all: [Seen; 4]) -> bool {
    let mut known = all.into_iter().filter_map(|seen| seen.orders);
    let first = known.next();
    known.any(|other| Some(other) != first)
}

/// Whether two cells may be one leaf: nothing that stands in words in a table differs.
pub(super) fn are_alike(one: &Cell, other: &Cell) -> bool {
    let modes = |cell: &Cell| cell.collision.map(|collision| (collision.modes, collision.harmonic));
    lives(one) == lives(other) && one.status == other.status && modes(one) == modes(other)
}

/// Leaves found, each with the number of its cell.
pub(super) type Leaves = Vec<(u64, Cell)>;

/// The squares to the right, above, and above to the right.
fn beside(square: Extent) -> [Extent; 3] {
    let Extent { column, row, size } = square;
    let next = [column, row].map(|first| first + size);
    [(next[0], row), (column, next[1]), (next[0], next[1])].map(|(column, row)| Extent { column, row, size })
}

/// Makes one leaf of those from the first on, if they are four quarters of a square and alike.
fn merge(found: &mut Leaves, first: usize, square: Extent) {
    let [(_, one), others @ ..] = &mut found[first..] else { return };
    if others.len() != 3 || others.iter().any(|(_, other)| !are_alike(one, other)) {
        return;
    }
    one.extent = Some(square);
    // Of all that was computed, and not of what is written, the worst is told.
    one.residual = others.iter().map(|(_, other)| other.residual).fold(one.residual, f64::max);
    found.truncate(first + 1);
}

/// Finds leaves, one a thread.
pub(super) struct Refiner<'a, 'b> {
    context: &'a RefineContext<'b>,
    stop: &'a Stop,
    worker: Worker,
    orders: CellOrderFinder,
    /// The point of the cell computed last.
    point: Point,
    tiles: Tiles,
    /// What lives in cells of the last column and row of the finest grid, which stand for those beyond.
    last: HashMap<[u32; 2], Seen>,
}

impl<'a, 'b> Refiner<'a, 'b> {
    pub(super) fn new(context: &'a RefineContext<'b>, stop: &'a Stop) -> Self {
        let worker = Worker::new(context.scene.base.sites()).until(stop);
        let tiles = Tiles::new(context.size.map(|points| (points / context.whole) as usize), context.whole.ilog2());
        Self {
            context,
            stop,
            worker,
            orders: CellOrderFinder::default(),
            point: context.scene.base,
            tiles,
            last: HashMap::new(),
        }
    }

    /// The leaves of some cells of the grid, one after the other: of each those of its first quarter first. `None` if it was stopped.
    pub(super) fn leaves(&mut self, range: Range<u64>) -> Option<Leaves> {
        self.tiles.age();
        self.last.clear();
        let mut found = Vec::new();
        for number in range {
            self.of_square(self.context.scene.extent(number)?, number, &mut found)?;
        }
        Some(found)
    }

    fn of_square(&mut self, square: Extent, number: u64, found: &mut Leaves) -> Option<()> {
        let first = found.len();
        if square.size == 2 {
            return self.of_last_square(square, number, found);
        }
        if !self.is_halved(square)? {
            let cell = self.sample(square.sample())?.cell;
            found.push((number, Cell { extent: Some(square), ..cell }));
            return Some(());
        }
        for quarter in square.quarters() {
            self.of_square(quarter, number, found)?;
        }
        merge(found, first, square);
        Some(())
    }

    /// The leaves of a square whose quarters are cells of the finest grid.
    fn of_last_square(&mut self, square: Extent, number: u64, found: &mut Leaves) -> Option<()> {
        let sample = *self.sample(square.sample())?;
        let (cell, here) = (sample.cell, Seen::of(&sample));
        let divided = self.context.stripes.divides(square, cell.class);
        let [right, above, across] = if divided { [true; 3] } else { self.unexplained(square, here)? };
        if !(right || above || across) {
            found.push((number, Cell { extent: Some(square), ..cell }));
            return Some(());
        }
        let (first, quarters) = (found.len(), square.quarters());
        // The last quarter has nothing alike on both sides, of the others only those that differences point to.
        let mut cells = [Some(cell), None, None, None];
        let mut alike = true;
        for i in [(3, true), (1, right), (2, above)].into_iter().filter_map(|(i, asked)| asked.then_some(i)) {
            let other = self.compute(quarters[i].sample(), false)?.cell;
            cells[i] = Some(other);
            alike = are_alike(&cell, &other);
            if !alike {
                break;
            }
        }
        for (quarter, known) in quarters.into_iter().zip(cells) {
            let of_quarter = match known {
                Some(known) => known,
                None if alike => cell,
                None => self.compute(quarter.sample(), false)?.cell,
            };
            found.push((number, Cell { extent: Some(quarter), ..of_quarter }));
        }
        merge(found, first, square);
        Some(())
    }

    /// Computes the cell at a place of the finest grid.
    fn compute(&mut self, at: [u32; 2], ordered: bool) -> Option<Sample> {
        self.context.finest.set(&mut self.point, at);
        // The scene's corners were checked, so that every point between is a valid model.
        let model = self.point.model().ok()?;
        let task = &self.context.scene.task;
        let (cell, orders) = if ordered {
            self.orders.cell(&mut self.worker, &model, task)
        } else {
            (self.worker.cell(&model, task), None)
        };
        // One that was stopped is none.
        (!self.stop.is_raised()).then_some(Sample { cell, orders })
    }

    /// What was computed for the squares that begin at a place.
    fn sample(&mut self, at: [u32; 2]) -> Option<&Sample> {
        let ordered = self.context.ordered;
        // The one of a whole cell is computed once, for all threads.
        if self.tiles.is_first(at) {
            let place = self.context.cells.get(self.tiles.number(at))?;
            if place.get().is_none() {
                let sample = self.compute(at, ordered)?;
                return Some(place.get_or_init(|| sample));
            }
            return place.get();
        }
        if self.tiles.cell(at).is_none() {
            let sample = self.compute(at, ordered)?;
            self.tiles.set_cell(at, sample);
        }
        self.tiles.cell(at)
    }

    /// What is seen in the leaf that a square is a part of, or in the square itself if it is one or is halved.
    fn seen_about(&mut self, square: Extent) -> Option<Seen> {
        let mask = self.context.whole - 1;
        let mut at = Extent { column: square.column & !mask, row: square.row & !mask, size: self.context.whole };
        while at.size > square.size && self.is_halved(at)? {
            let size = at.size / 2;
            at = Extent { column: square.column & !(size - 1), row: square.row & !(size - 1), size };
        }
        self.sample(at.sample()).map(Seen::of)
    }

    /// Whether a square is halved, as far as its own size is asked: only squares of one that is halved are there.
    fn is_halved(&mut self, square: Extent) -> Option<bool> {
        if let Some(known) = self.tiles.halved(square.sample(), square.size) {
            return Some(known);
        }
        let sample = self.sample(square.sample())?;
        let (class, here) = (sample.cell.class, Seen::of(sample));
        let halved = self.context.stripes.divides(square, class) || self.differs(square, here)?;
        self.tiles.set_halved(square.sample(), square.size, halved);
        Some(halved)
    }

    /// What is seen to the right, above, and above to the right.
    fn seen_round(&mut self, square: Extent) -> Option<[Seen; 3]> {
        let [right, above, across] = beside(square);
        Some([self.seen_beside(right)?, self.seen_beside(above)?, self.seen_beside(across)?])
    }

    /// Whether what is seen in a square is not what is seen to the right, above, and above to the right. A border between two points
    /// that were computed lies in the square of the lower one: so it is halved, and the other is not.
    fn differs(&mut self, square: Extent, here: Seen) -> Option<bool> {
        let round @ [right, above, across] = self.seen_round(square)?;
        Some(are_parted([here, right, above, across]) || round.iter().any(|there| there.lives != here.lives))
    }

    /// Where it differs, but for what the edge of a stripe explains that is surely beyond all cells of the square: these are then alike.
    fn unexplained(&mut self, square: Extent, here: Seen) -> Option<[bool; 3]> {
        let round @ [right, above, across] = self.seen_round(square)?;
        // Where words are looked for, what takes longest has been done: nothing is left to guess.
        if self.context.ordered
            && (are_parted([here, right, above, across]) || round.iter().any(|there| there.lives != here.lives))
        {
            return Some([true; 3]);
        }
        let mut differ = [false; 3];
        for ((differs, there), beside) in differ.iter_mut().zip(round).zip(beside(square)) {
            *differs = there.lives != here.lives && !self.is_edge_between(square, here.lives, beside, there.lives);
        }
        Some(differ)
    }

    /// Whether all that differs is that one lies in a stripe and the other does not.
    fn is_edge_between(&self, square: Extent, here: Lives, beside: Extent, there: Lives) -> bool {
        let (inside, family) = match (here.0, there.0) {
            (Some(Class::UnstableDouble), Some(Class::StableDouble)) => (true, Family::DoubleSided),
            (Some(Class::StableDouble), Some(Class::UnstableDouble)) => (false, Family::DoubleSided),
            (Some(Class::UnstableSingle), Some(Class::StableSingle)) => (true, Family::SingleSided),
            (Some(Class::StableSingle), Some(Class::UnstableSingle)) => (false, Family::SingleSided),
            _ => return false,
        };
        // Beyond the last column or row there are no cells.
        let [columns, rows] = self.context.size;
        if beside.column >= columns || beside.row >= rows {
            return false;
        }
        let holds = |square: Extent| self.context.stripes.holds(square, family);
        here.2 == there.2 && holds(square) == Some(inside) && holds(Extent { size: 1, ..beside }) == Some(!inside)
    }

    /// What is seen in the first cell of a square, or, beyond the last column or row, in that.
    fn seen_beside(&mut self, square: Extent) -> Option<Seen> {
        let [columns, rows] = self.context.size;
        if square.column < columns && square.row < rows {
            return self.seen_about(square);
        }
        let at = [square.column.min(columns - 1), square.row.min(rows - 1)];
        if let Some(known) = self.last.get(&at) {
            return Some(*known);
        }
        let found = Seen::of(&self.compute(at, self.context.ordered)?);
        self.last.insert(at, found);
        Some(found)
    }
}
