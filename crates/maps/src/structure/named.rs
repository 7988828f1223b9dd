//! Matrices and modes in the files that a scene names.

use std::cell::RefCell;
use std::path::Path;

use nalgebra::DMatrix;

use super::matrix_market;
use super::tables::{MatrixGiven, StructureTable};
use crate::grid::Files;
use crate::text::read_text;

/// The most bytes of a scene, and of a file that it names.
pub(super) const MOST_BYTES: u64 = 64 << 20;

/// The files that a scene names, of which some are at hand.
pub(super) struct Named<'a> {
    folder: &'a Path,
    kept: &'a Files,
    read: RefCell<Files>,
}

impl<'a> Named<'a> {
    /// Those `kept`, all others in a folder.
    pub(super) fn new(folder: &'a Path, kept: &'a Files) -> Self {
        Self { folder, kept, read: RefCell::default() }
    }

    /// All that were read.
    pub(super) fn read(&self) -> Files {
        self.read.borrow().clone()
    }

    fn text(&self, what: &str, name: &str) -> Result<String, String> {
        let text = match self.kept.get(name) {
            Some(text) => text.clone(),
            None => read_text(what, &self.folder.join(name), MOST_BYTES).map_err(|error| error.to_string())?,
        };
        self.read.borrow_mut().insert(name.to_owned(), text.clone());
        Ok(text)
    }

    /// The matrix of that name.
    pub(super) fn matrix(&self, name: &str, given: &MatrixGiven) -> Result<DMatrix<f64>, String> {
        match given {
            MatrixGiven::Rows(rows) if rows.is_empty() => {
                Err(format!("{name} is empty: give a row for each coordinate"))
            }
            MatrixGiven::Rows(rows) => {
                let columns = rows.first().map_or(0, Vec::len);
                if let Some(row) = rows.iter().position(|row| row.len() != columns) {
                    return Err(format!("{name}: row {row} has {} entries, row 0 has {columns}", rows[row].len()));
                }
                Ok(DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j]))
            }
            MatrixGiven::File(file) => {
                let text = self.text("the matrix", file).map_err(|error| format!("{name}: {error}"))?;
                matrix_market::read(&text).map_err(|why| format!("{name}: {}: {why}", self.folder.join(file).display()))
            }
        }
    }

    /// A table of modes: frequency, ratio, load, static, and contact0, contact1, … as columns.
    pub(super) fn modes(&self, file: &str) -> Result<StructureTable, String> {
        let told = |why: String| format!("modes: {}: {why}", self.folder.join(file).display());
        let text = self.text("the modes", file).map_err(|error| format!("modes: {error}"))?;
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let names = reader.headers().map_err(|error| told(error.to_string()))?.clone();
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
        for (number, row) in reader.records().enumerate() {
            let row = row.map_err(|error| told(error.to_string()))?;
            for (column, text) in columns.iter_mut().zip(&row) {
                column.push(text.parse().map_err(|_| told(format!("row {}: {text} is not a number", number + 1)))?);
            }
        }
        let mut table = StructureTable::default();
        let mut shapes: Vec<(usize, Vec<f64>)> = Vec::new();
        for (name, column) in names.iter().zip(columns) {
            match name {
                "frequency" => table.frequencies = Some(column),
                "ratio" => table.ratios = Some(column),
                "load" => table.load_shapes = Some(column),
                "static" => table.static_shapes = Some(column),
                _ => match name.strip_prefix("contact").and_then(|number| number.parse().ok()) {
                    Some(number) => shapes.push((number, column)),
                    None => {
                        return Err(told(format!(
                            "column {name} is unknown: give frequency, ratio, load, static, contact0, …"
                        )));
                    }
                },
            }
        }
        shapes.sort_by_key(|(number, _)| *number);
        if shapes.iter().enumerate().any(|(i, (number, _))| i != *number) {
            return Err(told("columns contact0, contact1, … are to be there each once".to_owned()));
        }
        table.contact_shapes = Some(shapes.into_iter().map(|(_, column)| column).collect());
        Ok(table)
    }
}
