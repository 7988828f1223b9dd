//! The table of a sweep, of rows that come in order: as they are computed, or from chunks. It holds none of them.

use std::path::Path;

use vibrochain_lattice::Stop;

use super::chunk::{Fault, read};
use super::content::{Content, ReadRows};
use super::plan::Plan;
use super::store::Store;
use crate::cell::Cell;
use crate::error::MapError;
use crate::grid::Grid;
use crate::summary::Summary;
use crate::table::{Rows, TableFile};

/// Who looks at the cells of a table as it grows: pictures.
pub trait Watcher<T = Cell> {
    /// Whether anybody looks.
    fn looks(&self) -> bool;
    /// Forgets what it has seen.
    fn begin(&mut self);
    /// Sees a cell.
    fn cell(&mut self, number: u64, cell: &T);
}

/// Why there is no table.
#[derive(Debug)]
pub enum Unassembled {
    /// A chunk cannot be trusted.
    Chunk(u64, Fault),
    /// The table cannot be written.
    Table(MapError),
    /// The stop flag was raised.
    Stopped,
}

/// What may go wrong within a chunk.
enum Trouble {
    Fault(Fault),
    Table(MapError),
}

impl From<Fault> for Trouble {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}

/// A table under way, and who looks on.
pub struct Assembly<'a, C: Content<S>, S: Grid> {
    content: &'a C,
    plan: &'a Plan<S>,
    layout: C::Layout,
    table: TableFile,
    watcher: &'a mut dyn Watcher<C::Item>,
}

impl<S: Grid, C: Content<S>> std::fmt::Debug for Assembly<'_, C, S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Assembly").finish_non_exhaustive()
    }
}

impl<'a, S: Grid, C: Content<S>> Assembly<'a, C, S> {
    /// Starts with the names of the columns; who looks on forgets earlier rows. At most `threads` threads compress the table, if it is
    /// to be compressed.
    ///
    /// # Errors
    /// [`MapError`] if the table cannot be written.
    pub fn begin(
        content: &'a C,
        plan: &'a Plan<S>,
        out: &Path,
        threads: usize,
        watcher: &'a mut dyn Watcher<C::Item>,
    ) -> Result<Self, MapError> {
        let mut table = content.create(out, &plan.scene, threads)?;
        table.text(content.header(&plan.scene).as_bytes())?;
        watcher.begin();
        Ok(Self { content, plan, layout: content.layout(&plan.scene), table, watcher })
    }

    /// Whether cells are wanted, and not their text alone.
    pub fn wants_cells(&self) -> bool {
        self.watcher.looks() || self.table.wants_cells()
    }

    fn cell(&mut self, number: u64, cell: &C::Item) -> Result<(), MapError> {
        self.watcher.cell(number, cell);
        if !self.table.wants_cells() {
            return Ok(());
        }
        self.content.put(&mut self.table, (&self.plan.scene, &self.layout), number, cell)
    }

    /// Takes the next rows.
    ///
    /// # Errors
    /// [`MapError`] if the table cannot be written; it must then be thrown away.
    pub fn rows(&mut self, rows: &Rows<C::Item>) -> Result<(), MapError> {
        if self.wants_cells() {
            rows.cells.iter().try_for_each(|(number, cell)| self.cell(*number, cell))?;
        }
        self.table.text(&rows.text)
    }

    /// Flushes to disk what it has got, while others compute what comes next.
    ///
    /// # Errors
    /// As [`Assembly::rows`].
    pub fn sync(&mut self) -> Result<(), MapError> {
        self.table.sync()
    }

    /// Takes the rows of all chunks.
    ///
    /// # Errors
    /// [`Unassembled`]; the table must then be thrown away.
    pub fn chunks(&mut self, folder: &Path, stop: &Stop) -> Result<Summary, Unassembled> {
        let mut total = Summary::default();
        for chunk in 0..self.plan.chunks() {
            match self.chunk(chunk, &Store::path(folder, chunk), stop) {
                Ok(summary) => total.add(&summary),
                Err(Trouble::Fault(Fault::Stopped)) => return Err(Unassembled::Stopped),
                Err(Trouble::Fault(fault)) => return Err(Unassembled::Chunk(chunk, fault)),
                Err(Trouble::Table(error)) => return Err(Unassembled::Table(error)),
            }
        }
        Ok(total)
    }

    fn chunk(&mut self, chunk: u64, path: &Path, stop: &Stop) -> Result<Summary, Trouble> {
        let plan = self.plan;
        let mut reader = self.wants_cells().then(|| self.content.reader(&plan.scene, plan.range(chunk)));
        let damaged = |wrong| Trouble::Fault(Fault::Damaged(wrong));
        let mut taken = Ok(());
        let summary = read(path, plan, chunk, stop, |text| {
            if let Some(reader) = &mut reader {
                let mut each = |number: u64, cell: &C::Item| {
                    if taken.is_ok() {
                        taken = self.cell(number, cell);
                    }
                };
                reader.take(text, &mut each).map_err(damaged)?;
            }
            std::mem::replace(&mut taken, Ok(())).and_then(|()| self.table.text(text)).map_err(Trouble::Table)
        })?;
        if let Some(reader) = reader {
            let mut each = |number: u64, cell: &C::Item| {
                if taken.is_ok() {
                    taken = self.cell(number, cell);
                }
            };
            reader.finish(&summary, &mut each).map_err(damaged)?;
        }
        taken.map(|()| summary).map_err(Trouble::Table)
    }

    /// The table.
    #[must_use]
    pub fn into_table(self) -> TableFile {
        self.table
    }
}
