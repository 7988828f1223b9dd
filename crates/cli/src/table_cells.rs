//! The cells of a table that `mapgen sweep` or `merge` has written.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use vibrochain_maps::cell::Cell;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::table::{Reader, header};

use crate::error::CliError;

/// Bytes that are read at once.
const PIECE: usize = 1 << 16;

/// Reads the table of a scene, named by a flag, and hands each cell with its number to `each`.
///
/// # Errors
/// [`CliError::Request`] of a file that cannot be read, or is not the table of this scene.
pub(crate) fn read(flag: &str, path: &Path, scene: &Scene, mut each: impl FnMut(u64, &Cell)) -> Result<(), CliError> {
    let wrong = |what: String| CliError::Request(format!("{flag} {}: {what}", path.display()));
    let unreadable = |error: std::io::Error| wrong(format!("it cannot be read as a table: {error}"));
    let packed = path
        .extension()
        .is_some_and(|end| ["gz", "zst", "parquet"].iter().any(|known| end.eq_ignore_ascii_case(known)));
    if packed {
        return Err(wrong("only .csv is read here: unpack it first, or sweep to .csv".to_owned()));
    }
    let mut file = BufReader::new(File::open(path).map_err(unreadable)?);
    let expected = header(scene);
    let mut found = Vec::new();
    file.by_ref().take(expected.len() as u64).read_to_end(&mut found).map_err(unreadable)?;
    if found != expected.as_bytes() {
        return Err(wrong(format!("its columns are not those of this scene, {}", expected.trim_end())));
    }
    let mut reader = Reader::new(scene, 0..scene.cells());
    let mut piece = vec![0; PIECE];
    loop {
        match file.read(&mut piece).map_err(unreadable)? {
            0 => break,
            count => reader.take(&piece[..count], &mut each).map_err(wrong)?,
        }
    }
    reader.whole().map_err(wrong).map(|_| ())
}
