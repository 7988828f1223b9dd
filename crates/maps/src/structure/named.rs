//! Matrices and modes in the files that a scene names.

use std::cell::RefCell;
use std::path::Path;

use nalgebra::DMatrix;

use super::matrix_market;
use super::sizes::check_size;
use super::tables::{MatrixGiven, StructureTable};
use crate::grid::Files;
use crate::text::{clipped, read_text};

/// The most bytes of a file that a scene names: four million entries.
pub(super) const MOST_FILE_BYTES: u64 = 64 << 20;

/// Characters of a column's name that an error shows.
const MOST_SHOWN: usize = 40;

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
            None => read_text(what, &self.folder.join(name), MOST_FILE_BYTES).map_err(|error| error.to_string())?,
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
                check_size("coordinates", rows.len()).map_err(|why| format!("{name}: {why}"))?;
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
        // Of a file of something else nothing is shown.
        let is_table = names.iter().any(|name| name == "frequency");
        if !is_table {
            return Err(told("its first line has no column frequency: it is no table of modes".to_owned()));
        }
        if let Some(twice) =
            names.iter().enumerate().find(|(i, name)| names.iter().take(*i).any(|other| other == *name))
        {
            return Err(told(format!("column {} has the name of another: name each once", twice.0 + 1)));
        }
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
        for (row, number) in reader.records().zip(1..) {
            let row = row.map_err(|error| told(error.to_string()))?;
            check_size("modes or more", number).map_err(told)?;
            for ((column, name), text) in columns.iter_mut().zip(&names).zip(&row) {
                let value = text.parse().map_err(|_| told(format!("row {number}: its {name} is not a number")))?;
                column.push(value);
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
                            "column {} is unknown: give frequency, ratio, load, static, contact0, …",
                            clipped(name, MOST_SHOWN)
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{Files, Named, StructureTable};

    fn modes(text: &str) -> Result<StructureTable, String> {
        let kept = Files::from_iter([("modes.csv".to_owned(), text.to_owned())]);
        Named::new(Path::new("."), &kept).modes("modes.csv")
    }

    #[test]
    fn a_table_of_modes_is_read_column_by_column() {
        let table = modes("contact1, frequency ,contact0\n1,2,3\n4,5,6\n").unwrap();
        assert_eq!(table.frequencies, Some(vec![2.0, 5.0]));
        assert_eq!(table.contact_shapes, Some(vec![vec![3.0, 6.0], vec![1.0, 4.0]]));
    }

    /// Two columns of one name: neither is dropped without a word. What is in a file of something else is not shown.
    #[test]
    fn what_is_no_table_of_modes_is_refused() {
        let secret = "root:x:0:0";
        for (text, why) in [
            ("frequency,load,load\n1,2,3\n".to_owned(), "column 3 has the name of another"),
            ("frequency,contact0,frequency\n1,2,3\n".to_owned(), "column 3 has the name of another"),
            (format!("{secret}:/root:/bin/sh\ndaemon:x:1\n"), "no column frequency"),
            (format!("{secret}\n"), "no column frequency"),
            (String::new(), "no column frequency"),
            (format!("frequency,load\n1,{secret}\n"), "row 1: its load is not a number"),
            ("frequency,load\n1\n".to_owned(), "found record with 1 field"),
            (format!("frequency,{}\n1,2\n", "secret".repeat(20)), "is unknown"),
            ("frequency,contact1\n1,2\n".to_owned(), "contact0"),
            (format!("frequency\n{}", "1\n".repeat(1001)), "are too many"),
        ] {
            let told = modes(&text).unwrap_err();
            assert!(told.contains(why) && !told.contains(secret) && told.len() < 250, "{told}");
        }
    }
}
