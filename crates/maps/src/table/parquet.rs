//! A table by columns (Parquet).

use std::io;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::columns::{Kind, Value};
use super::fields::ColumnType;
use crate::files::Output;

/// Rows held in memory before they are written: readers skip and share such groups.
const GROUP: usize = 1 << 17;

/// The values of one column, and for each row whether there is one.
struct Column {
    values: Values,
    present: Vec<i16>,
    optional: bool,
}

enum Values {
    Numbers(Vec<f64>),
    Counts(Vec<i64>),
    Words(Vec<ByteArray>),
}

/// A table by columns under way.
pub struct Columns {
    writer: SerializedFileWriter<Output>,
    columns: Vec<Column>,
    rows: usize,
}

fn failed(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(inner) => match inner.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(other) => io::Error::other(other),
        },
        other => io::Error::other(other),
    }
}

fn field(name: &str, physical: Physical, optional: bool) -> Result<Arc<Type>, ParquetError> {
    let repetition = if optional { Repetition::OPTIONAL } else { Repetition::REQUIRED };
    let kind = (physical == Physical::BYTE_ARRAY).then_some(LogicalType::String);
    let built = Type::primitive_type_builder(name, physical).with_repetition(repetition).with_logical_type(kind);
    built.build().map(Arc::new)
}

impl Columns {
    /// Starts the file of a table of these columns.
    pub fn new(columns: &[ColumnType], output: Output) -> io::Result<Self> {
        let (mut types, mut list) = (Vec::new(), Vec::new());
        for ColumnType { name, kind, optional } in columns {
            let (physical, values) = match kind {
                Kind::Word | Kind::Text => (Physical::BYTE_ARRAY, Values::Words(Vec::new())),
                Kind::Count => (Physical::INT64, Values::Counts(Vec::new())),
                Kind::Number => (Physical::DOUBLE, Values::Numbers(Vec::new())),
            };
            types.push(field(name, physical, *optional).map_err(failed)?);
            list.push(Column { values, present: Vec::new(), optional: *optional });
        }
        let schema = Type::group_type_builder("table").with_fields(types).build().map_err(failed)?;
        let properties = WriterProperties::builder().set_compression(Compression::ZSTD(ZstdLevel::default())).build();
        let writer = SerializedFileWriter::new(output, Arc::new(schema), Arc::new(properties)).map_err(failed)?;
        Ok(Self { writer, columns: list, rows: 0 })
    }

    /// The file.
    pub fn output(&self) -> &Output {
        self.writer.inner()
    }

    /// Writes the last rows and what tells where all of them are.
    pub fn finish(mut self) -> io::Result<Output> {
        self.write_group()?;
        self.writer.into_inner().map_err(failed)
    }

    /// Takes the next row.
    ///
    /// # Errors
    /// Those of the file.
    pub fn row<'a>(&mut self, values: impl Iterator<Item = Option<Value<'a>>>) -> io::Result<()> {
        for (column, value) in self.columns.iter_mut().zip(values) {
            if column.optional {
                column.present.push(i16::from(value.is_some()));
            }
            match (value, &mut column.values) {
                (Some(Value::Number(number)), Values::Numbers(list)) => list.push(number),
                (Some(Value::Count(count)), Values::Counts(list)) => list.push(count.cast_signed()),
                (Some(Value::Word(text) | Value::Text(text)), Values::Words(list)) => list.push(ByteArray::from(text)),
                (None, _) if column.optional => {}
                _ => return Err(io::Error::other("a column without its value")),
            }
        }
        self.rows += 1;
        if self.rows == GROUP { self.write_group() } else { Ok(()) }
    }

    fn write_group(&mut self) -> io::Result<()> {
        if self.rows == 0 {
            return Ok(());
        }
        self.rows = 0;
        let mut group = self.writer.next_row_group().map_err(failed)?;
        for column in &mut self.columns {
            let Some(mut writer) = group.next_column().map_err(failed)? else { break };
            let present = column.optional.then_some(column.present.as_slice());
            let written = match &mut column.values {
                Values::Numbers(list) => {
                    let written = writer.typed::<DoubleType>().write_batch(list, present, None);
                    list.clear();
                    written
                }
                Values::Counts(list) => {
                    let written = writer.typed::<Int64Type>().write_batch(list, present, None);
                    list.clear();
                    written
                }
                Values::Words(list) => {
                    let written = writer.typed::<ByteArrayType>().write_batch(list, present, None);
                    list.clear();
                    written
                }
            };
            written.map_err(failed)?;
            column.present.clear();
            writer.close().map_err(failed)?;
        }
        group.close().map_err(failed)?;
        Ok(())
    }
}
