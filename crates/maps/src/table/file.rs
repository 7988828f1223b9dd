//! The file of a table, in the form that the end of its name asks for.

use std::io::Write;
use std::path::Path;

use super::columns::Value;
use super::fields::ColumnType;
#[cfg(feature = "parquet")]
use super::parquet::Columns;
use crate::error::MapError;
#[cfg(feature = "compress")]
use crate::files::Gzip;
use crate::files::Output;
use crate::files::ending;

/// The forms of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// `.csv`, or no ending.
    Plain,
    /// `.csv.gz`
    Gzip,
    /// `.csv.zst`
    Zstd,
    /// `.parquet`
    Columns,
}

impl Form {
    /// What the end of its name says, in small letters or capitals.
    ///
    /// # Errors
    /// [`MapError::Request`] for an ending that no table has.
    pub fn of(path: &Path) -> Result<Self, MapError> {
        let (form, inner) = match ending(path).as_deref() {
            Some("parquet") => return Ok(Self::Columns),
            Some("gz") => (Self::Gzip, path.with_extension("")),
            Some("zst") => (Self::Zstd, path.with_extension("")),
            _ => (Self::Plain, path.to_owned()),
        };
        if ending(&inner).is_none_or(|end| end == "csv") {
            return Ok(form);
        }
        let name = path.display();
        Err(MapError::Request(format!(
            "--out {name}: the kind of table is not known; end the name in .csv, .csv.gz, .csv.zst or .parquet"
        )))
    }
}

/// Level of gzip: larger ones take several times as long for a hundredth of the size.
#[cfg(feature = "compress")]
const GZIP_LEVEL: u32 = 6;

/// Level of zstd, its own default.
#[cfg(feature = "compress")]
const ZSTD_LEVEL: i32 = 3;

/// Bytes that a thread of zstd takes at a time: by default they are eight times as many, and most tables no more than one such piece. Where
/// they end depends on the bytes alone, so that the file is the same for any number of threads.
#[cfg(feature = "compress")]
const ZSTD_PIECE: u32 = 1 << 20;

/// The most threads of zstd: one compresses what some seven compute (`cargo bench --bench chunks` tells), and each has megabytes of its own.
#[cfg(feature = "compress")]
const ZSTD_THREADS: u32 = 16;

/// A table under way.
pub enum TableFile {
    /// As it is.
    Plain(Output),
    /// `.gz`
    #[cfg(feature = "compress")]
    Gzip(Gzip<Output>),
    /// `.zst`
    #[cfg(feature = "compress")]
    Zstd(Box<zstd::Encoder<'static, Output>>),
    /// `.parquet`
    #[cfg(feature = "parquet")]
    Columns(Box<Columns>),
}

/// The name of a table without the endings that tell its form: map.csv.gz → map.
pub fn stem(name: &str) -> &str {
    let without = |name: &'_ str, ends: &[&str]| {
        let (stem, end) = name.rsplit_once('.').filter(|(stem, _)| !stem.is_empty())?;
        ends.iter().any(|known| end.eq_ignore_ascii_case(known)).then_some(stem.len())
    };
    let name = without(name, &["gz", "zst"]).map_or(name, |length| &name[..length]);
    without(name, &["csv", "parquet"]).map_or(name, |length| &name[..length])
}

impl TableFile {
    /// As [`Output::create`], of a table of these columns. At most `threads` threads compress what is written.
    pub fn create(path: &Path, columns: &[ColumnType], threads: usize) -> Result<Self, MapError> {
        match Form::of(path)? {
            Form::Plain => Output::create(path).map(Self::Plain),
            Form::Columns => Self::by_columns(path, columns),
            form => Self::compressed(path, form, threads),
        }
    }

    #[cfg(feature = "parquet")]
    fn by_columns(path: &Path, columns: &[ColumnType]) -> Result<Self, MapError> {
        let columns = Columns::new(columns, Output::create(path)?);
        let columns =
            columns.map_err(|error| MapError::Computation(format!("cannot begin {}: {error}", path.display())))?;
        Ok(Self::Columns(Box::new(columns)))
    }

    #[cfg(not(feature = "parquet"))]
    fn by_columns(path: &Path, _: &[ColumnType]) -> Result<Self, MapError> {
        refuse!("{}: .parquet needs a build with the feature `parquet`", path.display())
    }

    #[cfg(feature = "compress")]
    fn compressed(path: &Path, form: Form, threads: usize) -> Result<Self, MapError> {
        let output = Output::create(path)?;
        if form == Form::Gzip {
            return Ok(Self::Gzip(Gzip::new(output, GZIP_LEVEL, threads)));
        }
        let cannot =
            |error: std::io::Error| MapError::Computation(format!("cannot compress {}: {error}", path.display()));
        let mut encoder = zstd::Encoder::new(output, ZSTD_LEVEL).map_err(cannot)?;
        encoder.include_checksum(true).map_err(cannot)?;
        encoder.multithread(u32::try_from(threads).unwrap_or(u32::MAX).clamp(1, ZSTD_THREADS)).map_err(cannot)?;
        encoder.set_parameter(zstd::zstd_safe::CParameter::JobSize(ZSTD_PIECE)).map_err(cannot)?;
        Ok(Self::Zstd(Box::new(encoder)))
    }

    #[cfg(not(feature = "compress"))]
    fn compressed(path: &Path, _: Form, _: usize) -> Result<Self, MapError> {
        refuse!("{}: compression needs a build with the feature `compress`", path.display())
    }

    fn output(&self) -> &Output {
        match self {
            Self::Plain(output) => output,
            #[cfg(feature = "compress")]
            Self::Gzip(encoder) => encoder.get_ref(),
            #[cfg(feature = "compress")]
            Self::Zstd(encoder) => encoder.get_ref(),
            #[cfg(feature = "parquet")]
            Self::Columns(columns) => columns.output(),
        }
    }

    /// Whether this form wants cells; else it wants their text.
    #[must_use]
    pub fn wants_cells(&self) -> bool {
        match self {
            #[cfg(feature = "parquet")]
            Self::Columns(_) => true,
            _ => false,
        }
    }

    /// Takes the values of the next row, in a form that wants cells.
    ///
    /// # Errors
    /// [`MapError`] if it cannot be written.
    pub fn row<'a>(&mut self, values: impl Iterator<Item = Option<Value<'a>>>) -> Result<(), MapError> {
        match self {
            #[cfg(feature = "parquet")]
            Self::Columns(columns) => columns.row(values).map_err(|error| columns.output().unwritten(&error)),
            _ => {
                let _ = values;
                Ok(())
            }
        }
    }

    /// Takes the text of the next rows, in a form that wants it.
    ///
    /// # Errors
    /// [`MapError`] if it cannot be written.
    pub fn text(&mut self, rows: &[u8]) -> Result<(), MapError> {
        let written = match self {
            Self::Plain(output) => output.write_all(rows),
            #[cfg(feature = "compress")]
            Self::Gzip(encoder) => encoder.write_all(rows),
            #[cfg(feature = "compress")]
            Self::Zstd(encoder) => encoder.write_all(rows),
            #[cfg(feature = "parquet")]
            Self::Columns(_) => Ok(()),
        };
        written.map_err(|error| self.output().unwritten(&error))
    }

    /// Flushes to disk what was written of a table as it is, so that less is left for the end. Of a compressed one, far smaller, all is
    /// left.
    ///
    /// # Errors
    /// As [`Output::sync`].
    pub fn sync(&mut self) -> Result<(), MapError> {
        match self {
            Self::Plain(output) => output.sync(),
            #[cfg(any(feature = "compress", feature = "parquet"))]
            _ => Ok(()),
        }
    }

    /// Writes what the compression has held back, and as [`Output::commit`].
    pub fn commit(self) -> Result<(), MapError> {
        #[cfg(feature = "compress")]
        let failed = |error: &std::io::Error| MapError::Computation(format!("could not finish the table: {error}"));
        match self {
            Self::Plain(output) => output,
            #[cfg(feature = "compress")]
            Self::Gzip(encoder) => encoder.finish().map_err(|error| failed(&error))?,
            #[cfg(feature = "compress")]
            Self::Zstd(encoder) => encoder.finish().map_err(|error| failed(&error))?,
            #[cfg(feature = "parquet")]
            Self::Columns(columns) => columns.finish().map_err(|error| failed(&error))?,
        }
        .commit()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{Form, MapError, stem};

    #[test]
    fn the_end_of_a_name_is_the_form_of_its_table_and_promises_nothing_else() {
        for (names, form) in [
            (&["map", "map.csv", "MAP.CSV", "-", ".csv", "folder.h5/map"][..], Form::Plain),
            (&["map.csv.gz", "map.gz", "x.CSV.GZ", "x.csv.Gz"], Form::Gzip),
            (&["map.csv.zst", "x.Csv.ZST"], Form::Zstd),
            (&["map.parquet", "map.PARQUET"], Form::Columns),
        ] {
            names.iter().for_each(|name| assert_eq!(Form::of(Path::new(name)).unwrap(), form, "{name}"));
        }
        for name in
            ["map.h5", "map.json", "map.h5.gz", "map.parquet.zst", "map.csv.bz2", "map.5", "map.csv.part", "m.gz.gz"]
        {
            let error = Form::of(Path::new(name)).unwrap_err();
            assert!(
                matches!(error, MapError::Request(_)) && error.to_string().contains("end the name in .csv"),
                "{error}"
            );
        }
    }

    #[test]
    fn the_manifest_of_every_form_has_the_name_of_the_table() {
        for name in [
            "map",
            "map.csv",
            "map.csv.gz",
            "map.csv.zst",
            "map.gz",
            "map.parquet",
            "map.CSV.GZ",
            "map.Csv",
            "map.PARQUET",
        ] {
            assert_eq!(stem(name), "map");
        }
        assert_eq!((stem("map.5"), stem(".csv"), stem("a.b.csv")), ("map.5", ".csv", "a.b"));
    }
}
