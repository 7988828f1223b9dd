//! The file of a table, in the form that the end of its name asks for.

use std::io::{self, Write};
use std::path::Path;

#[cfg(feature = "parquet")]
use crate::columnar::Columns;
use crate::error::CliError;
use crate::output::Output;
use crate::scene::Scene;

/// Endings of compressed tables.
const COMPRESSED: [&str; 2] = [".gz", ".zst"];

/// Ending of tables by columns.
const PARQUET: &str = ".parquet";

/// Level of gzip: larger ones take several times as long for a hundredth of the size.
#[cfg(feature = "compress")]
const GZIP_LEVEL: u32 = 6;

/// Level of zstd, its own default.
#[cfg(feature = "compress")]
const ZSTD_LEVEL: i32 = 3;

/// A table under way.
pub(crate) enum TableFile {
    /// As it is.
    Plain(Output),
    /// `.gz`
    #[cfg(feature = "compress")]
    Gzip(flate2::write::GzEncoder<Output>),
    /// `.zst`
    #[cfg(feature = "compress")]
    Zstd(Box<zstd::Encoder<'static, Output>>),
    /// `.parquet`
    #[cfg(feature = "parquet")]
    Columns(Box<Columns>),
}

/// The name of a table without the endings that tell its form: map.csv.gz → map.
pub(crate) fn stem(name: &str) -> &str {
    let name = COMPRESSED.iter().find_map(|end| name.strip_suffix(end)).unwrap_or(name);
    name.strip_suffix(".csv").or(name.strip_suffix(PARQUET)).unwrap_or(name)
}

impl TableFile {
    /// As [`Output::create`].
    pub(crate) fn create(path: &Path, scene: &Scene) -> Result<Self, CliError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name.ends_with(PARQUET) {
            return Self::by_columns(path, scene);
        }
        let Some(end) = COMPRESSED.into_iter().find(|end| name.ends_with(end)) else {
            return Output::create(path).map(Self::Plain);
        };
        Self::compressed(path, end)
    }

    #[cfg(feature = "parquet")]
    fn by_columns(path: &Path, scene: &Scene) -> Result<Self, CliError> {
        let columns = Columns::new(scene, Output::create(path)?);
        let columns =
            columns.map_err(|error| CliError::Computation(format!("cannot begin {}: {error}", path.display())))?;
        Ok(Self::Columns(Box::new(columns)))
    }

    #[cfg(not(feature = "parquet"))]
    fn by_columns(path: &Path, _: &Scene) -> Result<Self, CliError> {
        let message = format!("{}: {PARQUET} needs a build with the feature `parquet`", path.display());
        Err(CliError::Request(message))
    }

    #[cfg(feature = "compress")]
    fn compressed(path: &Path, end: &str) -> Result<Self, CliError> {
        let output = Output::create(path)?;
        if end == ".gz" {
            return Ok(Self::Gzip(flate2::write::GzEncoder::new(output, flate2::Compression::new(GZIP_LEVEL))));
        }
        let cannot = |error: io::Error| CliError::Computation(format!("cannot compress {}: {error}", path.display()));
        let mut encoder = zstd::Encoder::new(output, ZSTD_LEVEL).map_err(cannot)?;
        encoder.include_checksum(true).map_err(cannot)?;
        Ok(Self::Zstd(Box::new(encoder)))
    }

    #[cfg(not(feature = "compress"))]
    fn compressed(path: &Path, end: &str) -> Result<Self, CliError> {
        let message = format!("{}: {end} needs a build with the feature `compress`", path.display());
        Err(CliError::Request(message))
    }

    /// As [`Output::unwritten`].
    pub(crate) fn unwritten(&self, error: &io::Error) -> CliError {
        match self {
            Self::Plain(output) => output.unwritten(error),
            #[cfg(feature = "compress")]
            Self::Gzip(encoder) => encoder.get_ref().unwritten(error),
            #[cfg(feature = "compress")]
            Self::Zstd(encoder) => encoder.get_ref().unwritten(error),
            #[cfg(feature = "parquet")]
            Self::Columns(columns) => columns.output().unwritten(error),
        }
    }

    /// Writes what the compression has held back, and as [`Output::commit`].
    pub(crate) fn commit(self) -> Result<(), CliError> {
        #[cfg(feature = "compress")]
        let failed = |error: &io::Error| CliError::Computation(format!("could not finish the table: {error}"));
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

impl Write for TableFile {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        match self {
            Self::Plain(output) => output.write(buffer),
            #[cfg(feature = "compress")]
            Self::Gzip(encoder) => encoder.write(buffer),
            #[cfg(feature = "compress")]
            Self::Zstd(encoder) => encoder.write(buffer),
            #[cfg(feature = "parquet")]
            Self::Columns(columns) => columns.write(buffer),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Plain(output) => output.flush(),
            #[cfg(feature = "compress")]
            Self::Gzip(encoder) => encoder.flush(),
            #[cfg(feature = "compress")]
            Self::Zstd(encoder) => encoder.flush(),
            #[cfg(feature = "parquet")]
            Self::Columns(columns) => columns.flush(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::stem;

    #[test]
    fn the_manifest_of_every_form_has_the_name_of_the_table() {
        for name in ["map", "map.csv", "map.csv.gz", "map.csv.zst", "map.gz", "map.parquet"] {
            assert_eq!(stem(name), "map");
        }
        assert_eq!(stem("map.5"), "map.5");
    }
}
