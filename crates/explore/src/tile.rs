//! The cells of a tile, as bytes.

use rayon::ThreadPool;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use vibrochain_floquet::Mechanism;
use vibrochain_lattice::Stop;
use vibrochain_maps::cell::{Cell, Class, Status, Worker};
use vibrochain_maps::scene::Scene;

use crate::view::CELLS;

/// Bytes of a cell: two numbers, four bytes.
const OF_A_CELL: usize = 2 * 8 + 4;

/// Bytes of a tile.
pub const BYTES: usize = CELLS * CELLS * OF_A_CELL;

/// Stands for what a cell has not: a class that is not known, no mechanism.
const NONE: u8 = u8::MAX;

/// Stands for the status of a point that is outside the model: a parameter is out of range.
const OUTSIDE: u8 = NONE;

/// Computes the cells of a tile's scene, and writes them one quantity after another, each by rows, the lowest y first: spectral radius and
/// margin as numbers of 8 bytes, the last byte first in rank (not a number where a cell has none); class, mechanism and status, each by its place in the list of
/// all; the number of solutions, up to 255. A status of 255 is a point with a parameter out of range. `None` if `stop` was raised.
#[must_use]
pub fn compute(scene: &Scene, pool: &ThreadPool, stop: &Stop) -> Option<Vec<u8>> {
    let row = |worker: &mut Worker, row: usize| -> Option<Vec<Option<Cell>>> {
        let cell = |number: usize| {
            let model = scene.point(number as u64).model();
            let cell = model.ok().map(|model| worker.cell(&model, &scene.task));
            // One that was stopped is none.
            (!stop.is_raised()).then_some(cell)
        };
        (row * CELLS..(row + 1) * CELLS).map(cell).collect()
    };
    let rows: Option<Vec<_>> = pool.install(|| {
        (0..CELLS)
            .into_par_iter()
            .with_min_len(8)
            .map_init(|| Worker::new(scene.base.sites()).until(stop), |worker, number| row(worker, number))
            .collect()
    });
    Some(bytes(&rows?.concat()))
}

fn bytes(cells: &[Option<Cell>]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(cells.len() * OF_A_CELL);
    let known = || cells.iter().map(Option::as_ref);
    let mut numbers = |of: fn(&Cell) -> Option<f64>| {
        known().for_each(|cell| bytes.extend(cell.and_then(of).unwrap_or(f64::NAN).to_le_bytes()));
    };
    numbers(|cell| cell.spectral_radius);
    numbers(|cell| cell.margin);
    let mut words = |of: fn(&Cell) -> u8, outside: u8| bytes.extend(known().map(|cell| cell.map_or(outside, of)));
    words(|cell| place(&Class::ALL, cell.class), NONE);
    words(|cell| place(&Mechanism::ALL, cell.mechanism), NONE);
    words(|cell| place(&Status::ALL, Some(cell.status)), OUTSIDE);
    words(|cell| u8::try_from(cell.solutions).unwrap_or(u8::MAX), 0);
    bytes
}

/// Where something is in the list of all.
fn place<T: PartialEq>(all: &[T], wanted: Option<T>) -> u8 {
    let found = wanted.and_then(|wanted| all.iter().position(|one| *one == wanted));
    found.and_then(|place| u8::try_from(place).ok()).unwrap_or(NONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_has_its_byte() {
        assert!((0..Class::ALL.len()).all(|i| usize::from(place(&Class::ALL, Some(Class::ALL[i]))) == i));
        assert!((0..Status::ALL.len()).all(|i| usize::from(place(&Status::ALL, Some(Status::ALL[i]))) == i));
        assert_eq!(place(&Mechanism::ALL, None), NONE);
        let cells = vec![Some(Cell { margin: Some(0.25), solutions: 300, ..Cell::EMPTY }), None];
        let bytes = bytes(&cells);
        assert_eq!(bytes.len(), 2 * OF_A_CELL);
        assert!(bytes[..16].chunks(8).all(|number| f64::from_le_bytes(number.try_into().unwrap()).is_nan()));
        assert_eq!(f64::from_le_bytes(bytes[16..24].try_into().unwrap()), 0.25);
        assert_eq!(bytes[32..], [0, NONE, NONE, NONE, 0, OUTSIDE, 255, 0]);
    }
}
