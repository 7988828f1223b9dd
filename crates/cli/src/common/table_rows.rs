//! A table that has been written, as it is read again: first the names of its columns, then its rows.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use vibrochain_maps::fields::Fields;
use vibrochain_maps::grid::Grid;
use vibrochain_maps::summary::Summary;
use vibrochain_maps::sweep::{Content, ReadRows};

use crate::common::error::CliError;

/// Bytes that are read at once.
const PIECE: usize = 1 << 16;

/// The longest line of names: of a diagram that looks at every mass of the largest lattice.
const LONGEST: u64 = 1 << 24;

/// The most rows of a table that is held whole: hours of work have some ten thousand.
const MOST_ROWS: u64 = 5_000_000;

/// A table, read as far as its first row.
pub(crate) struct TableRows {
    /// What a message calls it.
    name: String,
    file: BufReader<Box<dyn Read>>,
    /// The first line.
    pub(crate) header: String,
}

impl TableRows {
    /// Opens the table that `flag` names; `-` is standard input.
    ///
    /// # Errors
    /// [`CliError::Request`] of a file that cannot be read, or is no plain CSV.
    pub(crate) fn open(flag: &str, path: &Path) -> Result<Self, CliError> {
        let name = format!("{flag} {}", path.display());
        let wrong = |what: &str| wrong(&name, what);
        let unreadable = |error: io::Error| unreadable(&name, &error);
        let packed = path
            .extension()
            .is_some_and(|end| ["gz", "zst", "parquet"].iter().any(|known| end.eq_ignore_ascii_case(known)));
        ensure!(!packed, wrong("only .csv is read here: unpack it first, or sweep to .csv"));
        let file: Box<dyn Read> = if path.as_os_str() == "-" {
            Box::new(io::stdin())
        } else {
            Box::new(File::open(path).map_err(unreadable)?)
        };
        let mut file = BufReader::with_capacity(PIECE, file);
        let mut header = String::new();
        file.by_ref().take(LONGEST).read_line(&mut header).map_err(unreadable)?;
        if !header.ends_with('\n') {
            let what = if header.is_empty() { "it is empty" } else { "its first line is no line of names" };
            return Err(wrong(&format!("{what}: give a table, in CSV")));
        }
        Ok(Self { name, file, header })
    }

    /// The names of its columns.
    pub(crate) fn columns(&self) -> Vec<&str> {
        self.header.trim_end().split(',').collect()
    }

    /// A request that this table makes wrong.
    pub(crate) fn wrong(&self, what: &str) -> CliError {
        wrong(&self.name, what)
    }

    /// Reads what is told of all cells of a scene, and hands each with its number to `each`; what they add up to.
    ///
    /// # Errors
    /// [`CliError::Request`] of a table that is not of this content and scene.
    pub(crate) fn cells<S: Grid, C: Content<S>>(
        mut self,
        content: &C,
        scene: &S,
        each: &mut dyn FnMut(u64, &C::Item),
    ) -> Result<Summary, CliError> {
        let expected = content.header(scene);
        if self.header != expected {
            return Err(self.wrong(&format!("its columns are not those of this scene, {}", expected.trim_end())));
        }
        let mut reader = content.reader(scene, 0..scene.cells());
        loop {
            let piece = self.file.fill_buf().map_err(|error| unreadable(&self.name, &error))?;
            if piece.is_empty() {
                break;
            }
            let count = piece.len();
            reader.take(piece, each).map_err(|what| wrong(&self.name, &what))?;
            self.file.consume(count);
        }
        reader.whole(each).map_err(|what| wrong(&self.name, &what))
    }

    /// Reads all rows, as many as a manifest has told, by their fields.
    ///
    /// # Errors
    /// [`CliError::Request`] with the number of the first row that is not as it must be.
    pub(crate) fn rows(
        self,
        told: u64,
        mut each: impl FnMut(&mut Fields<'_, &str>) -> Result<(), String>,
    ) -> Result<(), CliError> {
        let Self { name, file, header } = self;
        let wrong = |what: String| wrong(&name, &what);
        let columns: Vec<&str> = header.trim_end().split(',').collect();
        let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(file);
        let (mut record, mut count) = (csv::StringRecord::new(), 0_u64);
        loop {
            let of_row = |what: &dyn std::fmt::Display| wrong(format!("row {}: {what}", count + 1));
            if !reader.read_record(&mut record).map_err(|error| of_row(&error))? {
                break;
            }
            if count == MOST_ROWS {
                return Err(wrong(format!("it has more than {MOST_ROWS} rows, which are held at once: give fewer")));
            }
            Fields::of(&columns, &record).and_then(|mut fields| each(&mut fields)).map_err(|what| of_row(&what))?;
            count += 1;
        }
        ensure!(count == told, wrong(format!("it has {count} rows, its manifest says {told}")));
        Ok(())
    }
}

fn wrong(name: &str, what: &str) -> CliError {
    CliError::Request(format!("{name}: {what}"))
}

fn unreadable(name: &str, error: &io::Error) -> CliError {
    wrong(name, &format!("it cannot be read as a table: {error}"))
}
