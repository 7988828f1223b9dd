//! Rows of a sweep, whose blocks share the digits of the axis that runs fastest.

use std::ops::Range;

use super::rows::{ROW, Rows, Table};
use crate::grid::Grid;
use crate::numbers::Number;
use crate::scene::Scene;

/// Values of an axis whose digits are kept, at most: a megabyte.
const MOST: usize = 1 << 15;

/// Makes rows of cells, of any block of a scene and on any thread.
#[derive(Debug)]
pub struct RowWriter<'a, S: Grid = Scene> {
    scene: &'a S,
    /// Whether the cells are handed on with their rows.
    cells: bool,
    /// The digits of all values of the fastest axis, one after the other, and where each ends; none if they are too many, or if each is
    /// written once.
    digits: Vec<u8>,
    ends: Vec<usize>,
}

impl<'a, S: Grid> RowWriter<'a, S> {
    /// For a scene; the cells themselves are handed on, too, if `cells` asks for them.
    #[must_use]
    pub fn new(scene: &'a S, cells: bool) -> Self {
        let mut writer = Self { scene, cells, digits: Vec::new(), ends: Vec::new() };
        let axis = scene.axes().first().filter(|axis| axis.points() <= MOST && scene.axes().len() > 1);
        for value in axis.iter().flat_map(|axis| (0..axis.points()).map(|i| axis.value(i))) {
            Number(value).push(&mut writer.digits);
            writer.ends.push(writer.digits.len());
        }
        writer
    }

    /// The digits of value number `i`.
    fn digits(&self, i: usize) -> Option<&[u8]> {
        let begin = if i == 0 { 0 } else { *self.ends.get(i - 1)? };
        self.digits.get(begin..*self.ends.get(i)?)
    }

    /// Rows of the cells numbered `range`.
    #[must_use]
    pub fn rows(&self, range: Range<u64>, cells: &[S::Cell]) -> Rows<S::Cell> {
        let mut table = Table::new(self.scene);
        table.text.reserve(ROW * cells.len());
        let points = self.ends.len().max(1);
        let mut column = (range.start % points as u64) as usize;
        let mut rest = cells.iter();
        self.scene.walk(range.clone(), |point| {
            let row = rest.next().map(|cell| table.write_at(point, self.digits(column), cell));
            column = if column + 1 == points { 0 } else { column + 1 };
            row.is_some()
        });
        let kept = if self.cells { range.clone().zip(cells.iter().cloned()).collect() } else { Vec::new() };
        Rows { range, cells: kept, text: table.text }
    }
}
