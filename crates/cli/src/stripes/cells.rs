//! The cells of the map under the lines: computed as `mapgen sweep` does, or read from its table.

use std::path::Path;

use rayon::ThreadPool;
use vibrochain_lattice::Stop;

use crate::common::error::CliError;
use crate::common::table_rows::TableRows;
use crate::stripes::request::Request;
use vibrochain_maps::cell::Class;
use vibrochain_maps::sweep::{Cells, Ended, sweep};
use vibrochain_plot::Tile;

/// Class and mechanism of every cell, by rows.
///
/// # Errors
/// [`CliError::Request`] for a table that is not of this scene.
pub(super) fn cells(
    request: &Request,
    table: Option<&Path>,
    pool: &ThreadPool,
    stop: &Stop,
) -> Result<Vec<Tile>, CliError> {
    match table {
        Some(path) => read(request, path),
        None => {
            let mut tiles = Vec::new();
            let ended = sweep(
                &request.scene,
                pool,
                stop,
                |_| {},
                |_, cells| {
                    tiles.extend(cells.iter().map(Tile::from));
                    Ok::<_, std::convert::Infallible>(())
                },
            );
            match ended {
                Ended::Complete(_) => Ok(tiles),
                Ended::Stopped | Ended::Failed(_) => Err(CliError::Interrupted),
            }
        }
    }
}

/// The same from a table.
///
/// # Errors
/// [`CliError::Request`] for a table that is not of this scene.
pub(super) fn read(request: &Request, path: &Path) -> Result<Vec<Tile>, CliError> {
    let (mut tiles, mut without) = (Vec::new(), false);
    TableRows::open("--map", path)?.cells(&Cells, &request.scene, &mut |_, cell| {
        without |= matches!(cell.class, Some(Class::Double | Class::Single));
        tiles.push(Tile::from(cell));
    })?;
    ensure!(!without, "--map {}: it was made without stability; make it again with stability = true", path.display());
    Ok(tiles)
}
