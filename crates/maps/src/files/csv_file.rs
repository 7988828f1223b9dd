//! Tables of numbers that commands leave beside their answers.

use std::path::Path;

use serde::Serialize;
use serde_json::Value;

use super::destination::promises;
use super::output::Output;
use crate::error::MapError;

/// A table under way.
pub struct CsvFile {
    writer: csv::Writer<Output>,
}

impl CsvFile {
    /// Opens the file that `flag` names, and writes the names of the columns.
    ///
    /// # Errors
    /// [`MapError::Request`] if it cannot be written, or is named as something else; those of [`CsvFile::row`].
    pub fn create<T: AsRef<[u8]>>(
        flag: &str,
        path: &Path,
        header: impl IntoIterator<Item = T>,
    ) -> Result<Self, MapError> {
        promises(flag, path, "a table as plain CSV", &["csv"])?;
        let mut file = Self { writer: csv::Writer::from_writer(Output::create(path)?) };
        file.row(header)?;
        Ok(file)
    }

    /// Writes a row.
    ///
    /// # Errors
    /// As [`Output::unwritten`].
    pub fn row<T: AsRef<[u8]>>(&mut self, row: impl IntoIterator<Item = T>) -> Result<(), MapError> {
        self.writer.write_record(row).map_err(|error| self.writer.get_ref().without_row(error))
    }

    /// Writes the values of a tuple or a struct as a row: nothing for what is not there or no number, the values of a list with spaces between.
    ///
    /// # Errors
    /// As [`Output::unwritten`].
    pub fn record(&mut self, values: &impl Serialize) -> Result<(), MapError> {
        match serde_json::to_value(values).map_err(|error| MapError::Computation(error.to_string()))? {
            Value::Object(fields) => self.row(fields.values().map(text)),
            Value::Array(fields) => self.row(fields.iter().map(text)),
            field => self.row([text(&field)]),
        }
    }

    /// The file behind the rows written so far, for those that need no quotes and are text already.
    ///
    /// # Errors
    /// As [`Output::unwritten`].
    pub fn into_output(mut self) -> Result<Output, MapError> {
        self.writer.flush().map_err(|error| self.writer.get_ref().unwritten(&error))?;
        // What could not be written has been told; nothing is left to write.
        self.writer.into_inner().map_err(|error| MapError::Computation(error.to_string()))
    }

    /// Puts the table in its place.
    ///
    /// # Errors
    /// As [`Output::commit`].
    pub fn finish(self) -> Result<(), MapError> {
        self.into_output()?.commit()
    }
}

/// A value as a field.
fn text(value: &Value) -> String {
    match (value, value.as_f64()) {
        (Value::Null, _) => String::new(),
        (Value::String(text), _) => text.clone(),
        (Value::Array(values), _) => values.iter().map(text).collect::<Vec<_>>().join(" "),
        // Not as JSON has it: without a fraction of zero, and without an exponent.
        (Value::Number(number), Some(value)) if number.is_f64() => value.to_string(),
        (value, _) => value.to_string(),
    }
}
