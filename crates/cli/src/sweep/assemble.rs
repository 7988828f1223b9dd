//! The table of a sweep, of rows that come in order: as they are computed, or from chunks. It holds none of them.

use std::convert::Infallible;
use std::io::Write;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use crate::error::CliError;
use crate::lines::Lines;
use crate::pictures::Pictures;
use crate::sweep::chunk::{Fault, read};
use crate::sweep::{Plan, Store, Summary};
use crate::table::header;
use crate::table_file::TableFile;

/// Why there is no table.
#[derive(Debug)]
pub(crate) enum Unassembled {
    /// A chunk cannot be trusted.
    Chunk(u64, Fault),
    /// The table cannot be written.
    Table(CliError),
    /// The stop flag was raised.
    Stopped,
}

/// What may go wrong within a chunk.
enum Trouble {
    Fault(Fault),
    Table(CliError),
}

impl From<Fault> for Trouble {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}

/// A table under way, and what its pictures keep of it.
pub(crate) struct Assembly<'a, 'b> {
    table: TableFile,
    pictures: &'a mut Pictures<'b>,
    lines: Lines,
}

impl<'a, 'b> Assembly<'a, 'b> {
    /// Starts with the names of the columns; of earlier rows the pictures keep nothing.
    ///
    /// # Errors
    /// [`CliError`] if the table cannot be written.
    pub(crate) fn begin(plan: &Plan, out: &Path, pictures: &'a mut Pictures<'b>) -> Result<Self, CliError> {
        let mut table = TableFile::create(out, &plan.scene)?;
        table.write_all(header(&plan.scene).as_bytes()).map_err(|error| table.unwritten(&error))?;
        pictures.begin();
        Ok(Self { table, pictures, lines: Lines::default() })
    }

    /// Takes the next rows.
    ///
    /// # Errors
    /// [`CliError`] if the table cannot be written; it must then be thrown away.
    pub(crate) fn rows(&mut self, rows: &[u8]) -> Result<(), CliError> {
        if self.pictures.wanted() {
            // It has nothing to fail at.
            let _ = self.lines.take(rows, |line| {
                self.pictures.row(line);
                Ok::<_, Infallible>(())
            });
        }
        self.table.write_all(rows).map_err(|error| self.table.unwritten(&error))
    }

    /// Takes the rows of all chunks.
    ///
    /// # Errors
    /// [`Unassembled`]; the table must then be thrown away.
    pub(crate) fn chunks(&mut self, plan: &Plan, folder: &Path, stop: &AtomicBool) -> Result<Summary, Unassembled> {
        let mut total = Summary::default();
        for chunk in 0..plan.chunks() {
            let path = Store::path(folder, chunk);
            match read(&path, plan, chunk, stop, |rows| self.rows(rows).map_err(Trouble::Table)) {
                Ok(summary) => total.add(&summary),
                Err(Trouble::Fault(Fault::Stopped)) => return Err(Unassembled::Stopped),
                Err(Trouble::Fault(fault)) => return Err(Unassembled::Chunk(chunk, fault)),
                Err(Trouble::Table(error)) => return Err(Unassembled::Table(error)),
            }
        }
        Ok(total)
    }

    /// The table.
    pub(crate) fn into_table(self) -> TableFile {
        self.table
    }
}
