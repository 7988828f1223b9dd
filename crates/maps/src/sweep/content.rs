//! What the rows of a table tell of each cell: how it is computed, written and read back.

use std::ops::Range;
use std::path::Path;

use super::engine::{Block, Ended, Job, blocks};
use crate::error::MapError;
use crate::grid::Grid;
use crate::summary::Summary;
use crate::table::{Layout, Reader, RowWriter, Rows, TableFile, Value, header};

/// Takes what was computed, in order.
pub type Sink<'a, T> = &'a mut dyn FnMut(Block<Rows<T>>) -> Result<(), MapError>;

/// What is computed of every cell of a scene. Chunks, shards and tables are the same whatever it is; each cell has a row, or
/// several that follow each other.
pub trait Content<S: Grid>: Sync {
    /// What is known of one cell.
    type Item;
    /// What a table that wants items needs to know of them all.
    type Layout;
    /// Reads its rows.
    type Reader<'a>: ReadRows<Self::Item>
    where
        S: 'a;

    /// The names of the columns, as they stand in the file.
    fn header(&self, scene: &S) -> String;

    /// Opens a table.
    ///
    /// # Errors
    /// As [`TableFile::create`].
    fn create(&self, out: &Path, scene: &S, threads: usize) -> Result<TableFile, MapError>;

    /// What [`Content::put`] needs.
    fn layout(&self, scene: &S) -> Self::Layout;

    /// Hands an item, of the cell of this number, to a table that wants items and not their text.
    ///
    /// # Errors
    /// [`MapError`] if it cannot be written.
    fn put(
        &self,
        table: &mut TableFile,
        of: (&S, &Self::Layout),
        number: u64,
        item: &Self::Item,
    ) -> Result<(), MapError>;

    /// Computes all cells of `parts` and hands them to `sink` in order, their items, too, if these are `wanted` and not the rows
    /// alone. `tick` is called, from any thread, with each number of steps that is done.
    fn compute(
        &self,
        job: &Job<'_, S>,
        parts: &[Range<u64>],
        wanted: bool,
        tick: &(dyn Fn(u64) + Sync),
        sink: Sink<'_, Self::Item>,
    ) -> Ended<MapError>;

    /// Reads the rows of the cells numbered `cells`.
    fn reader<'a>(&self, scene: &'a S, cells: Range<u64>) -> Self::Reader<'a>;
}

/// Reads rows against the cells they must be of.
pub trait ReadRows<T> {
    /// Reads the rows in `bytes`, which may end anywhere, and hands what they tell to `each`, with the number of the cell.
    ///
    /// # Errors
    /// What is wrong with the first row that is not as it must be.
    fn take(&mut self, bytes: &[u8], each: &mut dyn FnMut(u64, &T)) -> Result<(), String>;

    /// Hands on what has waited for more, and tells the counts of the rows, if that was every one.
    ///
    /// # Errors
    /// What is missing.
    fn whole(self, each: &mut dyn FnMut(u64, &T)) -> Result<Summary, String>;

    /// The same, which must have these counts.
    ///
    /// # Errors
    /// What is wrong.
    fn finish(self, summary: &Summary, each: &mut dyn FnMut(u64, &T)) -> Result<(), String>;
}

/// The content of a sweep's table: a row a cell.
#[derive(Debug, Clone, Copy)]
pub struct Cells;

impl<S: Grid> Content<S> for Cells {
    type Item = S::Cell;
    type Layout = Layout<S>;
    type Reader<'a>
        = Reader<'a, S>
    where
        S: 'a;

    fn header(&self, scene: &S) -> String {
        header(scene)
    }

    fn create(&self, out: &Path, scene: &S, threads: usize) -> Result<TableFile, MapError> {
        TableFile::create(out, &Layout::new(scene).types(scene), threads)
    }

    fn layout(&self, scene: &S) -> Layout<S> {
        Layout::new(scene)
    }

    fn put(
        &self,
        table: &mut TableFile,
        (scene, layout): (&S, &Layout<S>),
        number: u64,
        cell: &S::Cell,
    ) -> Result<(), MapError> {
        let point = scene.point(number);
        let places = layout.places.iter().map(|place| Some(Value::Number(S::value(&point, *place))));
        table.row(places.chain(layout.columns.iter().map(|column| (column.get)(cell))))
    }

    fn compute(
        &self,
        job: &Job<'_, S>,
        parts: &[Range<u64>],
        wanted: bool,
        tick: &(dyn Fn(u64) + Sync),
        sink: Sink<'_, S::Cell>,
    ) -> Ended<MapError> {
        let writer = RowWriter::new(job.scene, wanted);
        let digest = |range: Range<u64>, cells: &[S::Cell]| {
            tick(range.end - range.start);
            writer.rows(range, cells)
        };
        blocks(job, parts, digest, sink)
    }

    fn reader<'a>(&self, scene: &'a S, cells: Range<u64>) -> Reader<'a, S> {
        Reader::new(scene, cells)
    }
}

impl<S: Grid> ReadRows<S::Cell> for Reader<'_, S> {
    fn take(&mut self, bytes: &[u8], each: &mut dyn FnMut(u64, &S::Cell)) -> Result<(), String> {
        self.take(bytes, each)
    }

    fn whole(self, _: &mut dyn FnMut(u64, &S::Cell)) -> Result<Summary, String> {
        self.whole()
    }

    fn finish(self, summary: &Summary, _: &mut dyn FnMut(u64, &S::Cell)) -> Result<(), String> {
        self.finish(summary)
    }
}
