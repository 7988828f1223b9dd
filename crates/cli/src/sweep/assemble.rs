//! Makes one table of all chunks, in order and without holding it.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::CliError;
use crate::output::Output;
use crate::sweep::chunk::{Fault, read};
use crate::sweep::{Plan, Store, Summary};
use crate::table::header;

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

/// Cuts bytes that come in pieces into lines.
#[derive(Default)]
struct Lines {
    begun: Vec<u8>,
}

impl Lines {
    fn take(&mut self, bytes: &[u8], mut each: impl FnMut(&[u8])) {
        for piece in bytes.split_inclusive(|&byte| byte == b'\n') {
            match piece.strip_suffix(b"\n") {
                None => self.begun.extend_from_slice(piece),
                Some(line) if self.begun.is_empty() => each(line),
                Some(end) => {
                    self.begun.extend_from_slice(end);
                    each(&self.begun);
                    self.begun.clear();
                }
            }
        }
    }
}

/// Writes the table of all chunks to `table` and hands every row to `row`, if there is one.
///
/// # Errors
/// [`Unassembled`]; the table must then be thrown away.
pub(crate) fn assemble(
    plan: &Plan,
    folder: &Path,
    stop: &AtomicBool,
    table: &mut Output,
    mut row: Option<&mut dyn FnMut(&[u8])>,
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
                lines.take(rows, row);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_whole_however_they_are_cut() {
        let text = b"one,1\n\ntwo,2\nthree,3\n";
        for size in 1..text.len() {
            let (mut lines, mut seen) = (Lines::default(), Vec::new());
            for piece in text.chunks(size) {
                lines.take(piece, |line| seen.push(String::from_utf8(line.to_vec()).unwrap()));
            }
            assert_eq!(seen, ["one,1", "", "two,2", "three,3"], "{size}");
        }
    }
}
