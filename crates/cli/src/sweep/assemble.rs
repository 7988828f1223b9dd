//! Makes one table of all chunks, in order and without holding it.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::CliError;
use crate::lines::Lines;
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

/// Takes rows.
pub(crate) type Taker<'a> = dyn FnMut(&[u8]) + 'a;

/// Writes the table of all chunks to `table` and hands every row to `row`, if there is one.
///
/// # Errors
/// [`Unassembled`]; the table must then be thrown away.
pub(crate) fn assemble(
    plan: &Plan,
    folder: &Path,
    stop: &AtomicBool,
    table: &mut TableFile,
    mut row: Option<&mut Taker<'_>>,
) -> Result<Summary, Unassembled> {
    let mut total = Summary::default();
    let mut lines = Lines::default();
    let first = table.write_all(header(&plan.scene).as_bytes());
    first.map_err(|error| Unassembled::Table(table.unwritten(&error)))?;
    for chunk in 0..plan.chunks() {
        if stop.load(Ordering::Relaxed) {
            return Err(Unassembled::Stopped);
        }
        let summary = read(&Store::path(folder, chunk), plan, chunk, |rows| {
            if let Some(row) = &mut row {
                // It has nothing to fail at.
                let _ = lines.take(rows, |line| {
                    row(line);
                    Ok(())
                });
            }
            table.write_all(rows).map_err(|error| Trouble::Table(table.unwritten(&error)))
        });
        match summary {
            Ok(summary) => total.add(&summary),
            Err(Trouble::Fault(fault)) => return Err(Unassembled::Chunk(chunk, fault)),
            Err(Trouble::Table(error)) => return Err(Unassembled::Table(error)),
        }
    }
    Ok(total)
}
