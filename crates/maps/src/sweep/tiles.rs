//! What one thread knows of the cells of the grid that is refined: of each by places within it, so that nothing need be looked for.

use super::orders::CellOrders;
use crate::cell::Cell;

/// What was computed at a place: the cell, and the orders of its signatures, if they were asked for and are known.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) cell: Cell,
    pub(super) orders: Option<CellOrders>,
}

/// What is known of the squares that begin at a place.
#[derive(Debug, Clone, Copy, Default)]
struct Place {
    /// Which of the tile's cells was computed there, counted from 1; 0 if none was.
    cell: u32,
    /// The sizes, each a power of two, of which it is known whether the square is halved, and those of squares that are.
    known: u16,
    halved: u16,
}

/// A cell of the grid.
#[derive(Debug, Default)]
struct Tile {
    /// Its number.
    number: usize,
    /// When it was last asked for.
    used: u64,
    first: Place,
    /// Places of even columns and rows, which squares begin at; none as long as only the first was asked for.
    places: Vec<Place>,
    cells: Vec<Sample>,
}

/// Cells of the grid that have been asked for lately.
#[derive(Debug)]
pub(super) struct Tiles {
    /// How often a cell may be halved, and how many there are in a row.
    depth: u32,
    columns: usize,
    /// Where that of each cell is, counted from 1; 0 if it is not there.
    of: Vec<u32>,
    tiles: Vec<Tile>,
    /// Those that are no cell's at present.
    free: Vec<u32>,
    now: u64,
}

impl Tiles {
    /// Of a grid with so many columns and rows, halved so often.
    pub(super) fn new([columns, rows]: [usize; 2], depth: u32) -> Self {
        Self { depth, columns, of: vec![0; columns * rows], tiles: Vec::new(), free: Vec::new(), now: 1 }
    }

    /// Forgets what was not asked for since it was called last.
    pub(super) fn age(&mut self) {
        let Self { of, tiles, free, now, .. } = self;
        for (i, tile) in tiles.iter_mut().enumerate() {
            if of[tile.number] == i as u32 + 1 && tile.used < *now {
                of[tile.number] = 0;
                tile.first = Place::default();
                tile.places.clear();
                tile.cells.clear();
                free.push(i as u32);
            }
        }
        *now += 1;
    }

    /// The number of the cell that a place is in.
    pub(super) fn number(&self, [column, row]: [u32; 2]) -> usize {
        (row >> self.depth) as usize * self.columns + (column >> self.depth) as usize
    }

    /// Whether a cell of the grid begins at a place.
    pub(super) fn is_first(&self, [column, row]: [u32; 2]) -> bool {
        (column | row) & ((1 << self.depth) - 1) == 0
    }

    fn tile(&mut self, at: [u32; 2]) -> usize {
        let number = self.number(at);
        let known = self.of[number];
        let tile = if known > 0 {
            known as usize - 1
        } else {
            let tile = self.free.pop().map_or(self.tiles.len(), |tile| tile as usize);
            if tile == self.tiles.len() {
                self.tiles.push(Tile::default());
            }
            self.of[number] = tile as u32 + 1;
            self.tiles[tile].number = number;
            tile
        };
        self.tiles[tile].used = self.now;
        tile
    }

    fn place(&mut self, at: [u32; 2]) -> (usize, &mut Place) {
        let (i, is_first, depth) = (self.tile(at), self.is_first(at), self.depth);
        let tile = &mut self.tiles[i];
        if is_first {
            return (i, &mut tile.first);
        }
        if tile.places.is_empty() {
            tile.places.resize(1 << (2 * (depth - 1)), Place::default());
        }
        let [column, row] = at.map(|place| (place & ((1 << depth) - 1)) as usize / 2);
        (i, &mut tile.places[row << (depth - 1) | column])
    }

    /// Whether the square of this size that begins at a place is halved, if that is known.
    pub(super) fn halved(&mut self, at: [u32; 2], size: u32) -> Option<bool> {
        let place = self.place(at).1;
        (u32::from(place.known) & size != 0).then_some(u32::from(place.halved) & size != 0)
    }

    /// Remembers whether it is.
    pub(super) fn set_halved(&mut self, at: [u32; 2], size: u32, halved: bool) {
        let place = self.place(at).1;
        // 256 at most.
        place.known |= size as u16;
        place.halved |= if halved { size as u16 } else { 0 };
    }

    /// What was computed at a place, of even column and row, that is not the first of a cell.
    pub(super) fn cell(&mut self, at: [u32; 2]) -> Option<&Sample> {
        let (tile, place) = self.place(at);
        let cell = (place.cell as usize).checked_sub(1)?;
        self.tiles[tile].cells.get(cell)
    }

    /// Remembers it.
    pub(super) fn set_cell(&mut self, at: [u32; 2], cell: Sample) {
        let tile = self.tile(at);
        let cells = &mut self.tiles[tile].cells;
        cells.push(cell);
        let number = cells.len() as u32;
        self.place(at).1.cell = number;
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    /// Against lists by place, of which some are forgotten.
    #[test]
    fn what_was_asked_for_lately_is_known_and_nothing_else_is() {
        let mut random = fastrand::Rng::with_seed(8);
        let (grid, depth) = ([5_u32, 4_u32], 3);
        let mut tiles = Tiles::new(grid.map(|points| points as usize), depth);
        let (mut cells, mut halved) = (HashMap::new(), HashMap::new());
        let (mut used, mut now) = (HashMap::new(), 0);
        let mut seen = [0; 4];
        for step in 1..40_000_u32 {
            let size = 2 << random.u32(..depth);
            let at = grid.map(|points| random.u32(..(points << depth) / size) * size);
            let number = tiles.number(at);
            assert_eq!(number, (at[1] / 8 * 5 + at[0] / 8) as usize);
            // Forgotten if it was not asked for since the time before the last.
            if used.insert(number, now).is_some_and(|last| last + 1 < now) {
                cells.retain(|at: &[u32; 2], _| tiles.number(*at) != number);
                halved.retain(|(at, _): &([u32; 2], u32), _| tiles.number(*at) != number);
            }
            let (known, expected) = (tiles.halved(at, size), halved.get(&(at, size)).copied());
            assert_eq!(known, expected, "{at:?} {size}");
            seen[usize::from(known.is_some())] += 1;
            if known.is_none() && random.bool() {
                let is = random.bool();
                tiles.set_halved(at, size, is);
                halved.insert((at, size), is);
            }
            if !tiles.is_first(at) {
                let known = tiles.cell(at).map(|sample| sample.cell.solutions);
                assert_eq!(known, cells.get(&at).copied(), "{at:?}");
                seen[2 + usize::from(known.is_some())] += 1;
                if known.is_none() {
                    tiles.set_cell(at, Sample { cell: Cell { solutions: step, ..Cell::EMPTY }, orders: None });
                    cells.insert(at, step);
                }
            }
            if random.u32(..12) == 0 {
                tiles.age();
                now += 1;
            }
        }
        assert!(seen.iter().all(|times| *times > 1000), "{seen:?}");
        // As many as are asked for at once, and no more.
        assert!(tiles.tiles.len() <= 20);
    }
}
