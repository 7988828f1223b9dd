//! A table by columns (Parquet), made of the rows of the plain one.

use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::lines::Lines;
use crate::output::Output;
use crate::scene::Scene;
use crate::table::columns;

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
pub(crate) struct Columns {
    writer: SerializedFileWriter<Output>,
    columns: Vec<Column>,
    lines: Lines,
    rows: usize,
    /// The first line, which names the columns, is still to come.
    header: bool,
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
    /// Starts the file of a scene's table.
    pub(crate) fn new(scene: &Scene, output: Output) -> io::Result<Self> {
        let (mut fields, mut list) = (Vec::new(), Vec::new());
        for name in columns(scene) {
            let (physical, values, optional) = match name {
                "class" | "mechanism" => (Physical::BYTE_ARRAY, Values::Words(Vec::new()), true),
                "status" => (Physical::BYTE_ARRAY, Values::Words(Vec::new()), false),
                "solutions" => (Physical::INT64, Values::Counts(Vec::new()), false),
                "spectral_radius" | "margin" => (Physical::DOUBLE, Values::Numbers(Vec::new()), true),
                _ => (Physical::DOUBLE, Values::Numbers(Vec::new()), false),
            };
            fields.push(field(name, physical, optional).map_err(failed)?);
            list.push(Column { values, present: Vec::new(), optional });
        }
        let schema = Type::group_type_builder("table").with_fields(fields).build().map_err(failed)?;
        let properties = WriterProperties::builder().set_compression(Compression::ZSTD(ZstdLevel::default())).build();
        let writer = SerializedFileWriter::new(output, Arc::new(schema), Arc::new(properties)).map_err(failed)?;
        Ok(Self { writer, columns: list, lines: Lines::default(), rows: 0, header: true })
    }

    /// The file.
    pub(crate) fn output(&self) -> &Output {
        self.writer.inner()
    }

    /// Writes the last rows and what tells where all of them are.
    pub(crate) fn finish(mut self) -> io::Result<Output> {
        self.write_group()?;
        self.writer.into_inner().map_err(failed)
    }

    fn row(&mut self, line: &[u8]) -> io::Result<()> {
        if std::mem::take(&mut self.header) {
            return Ok(());
        }
        let foreign = || io::Error::new(io::ErrorKind::InvalidData, "a row that is none of this table");
        let line = std::str::from_utf8(line).map_err(|_| foreign())?;
        let mut fields = line.split(',');
        for column in &mut self.columns {
            let text = fields.next().ok_or_else(foreign)?;
            let there = !text.is_empty();
            if column.optional {
                column.present.push(i16::from(there));
            }
            if !there && column.optional {
                continue;
            }
            match &mut column.values {
                Values::Numbers(list) => list.push(text.parse().map_err(|_| foreign())?),
                Values::Counts(list) => list.push(text.parse().map_err(|_| foreign())?),
                Values::Words(list) => list.push(ByteArray::from(text)),
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

impl Write for Columns {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        let mut lines = std::mem::take(&mut self.lines);
        let taken = lines.take(buffer, |line| self.row(line));
        self.lines = lines;
        taken.map(|()| buffer.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
