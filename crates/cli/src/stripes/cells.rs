//! The cells of the map under the lines: computed as `mapgen sweep` does, or read from its table.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use rayon::ThreadPool;
use vibrochain_floquet::Mechanism;
use vibrochain_lattice::Short;

use crate::error::CliError;
use crate::stripes::request::Request;
use vibrochain_maps::cell::Class;
use vibrochain_maps::point::Parameter;
use vibrochain_maps::sweep::{Ended, sweep};
use vibrochain_maps::table::{names, parameters};
use vibrochain_plot::Tile;

/// Class and mechanism of every cell, by rows.
///
/// # Errors
/// [`CliError::Request`] for a table that is not of this scene.
pub(super) fn cells(
    request: &Request,
    table: Option<&Path>,
    pool: &ThreadPool,
    stop: &AtomicBool,
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

fn read(request: &Request, path: &Path) -> Result<Vec<Tile>, CliError> {
    let scene = &request.scene;
    let wrong = |what: String| CliError::Request(format!("--map {}: {what}", path.display()));
    let unreadable = |error: csv::Error| wrong(format!("it cannot be read as a table: {error}"));
    let mut reader = csv::Reader::from_path(path).map_err(unreadable)?;
    let expected = names(scene);
    let header = reader.headers().map_err(unreadable)?;
    if !header.iter().take(expected.len()).eq(expected.iter().copied()) {
        return Err(wrong(format!("its columns are not those of this scene, {}", expected.join(","))));
    }
    let first = parameters(scene).len();
    let mut tiles = Vec::new();
    for (number, record) in reader.records().enumerate() {
        let record = record.map_err(unreadable)?;
        let line = number + 2;
        if number as u64 >= scene.cells() {
            return Err(wrong(format!("it has more than the {} cells of this scene", scene.cells())));
        }
        let point = scene.point(number as u64);
        for (field, parameter) in record.iter().zip([Parameter::Gamma2, Parameter::Omega]) {
            let value = point.get(parameter);
            // Written in digits that read back the same.
            if field.parse::<f64>() != Ok(value) {
                let name = parameter.name();
                return Err(wrong(format!("line {line} has {name} = {field} where this scene has {}", Short(value))));
            }
        }
        let word = |column: usize| record.get(column).unwrap_or_default();
        let class = Class::ALL.into_iter().find(|class| class.name() == word(first));
        let mechanism = Mechanism::from_name(word(first + 1));
        let unknown = class.is_none() && !word(first).is_empty();
        if unknown || mechanism.is_none() && !word(first + 1).is_empty() {
            return Err(wrong(format!("line {line} has class `{}`, mechanism `{}`", word(first), word(first + 1))));
        }
        if matches!(class, Some(Class::Double | Class::Single)) {
            return Err(wrong("it was made without stability; make it again with stability = true".to_owned()));
        }
        tiles.push(Tile { class, mechanism });
    }
    if (tiles.len() as u64) < scene.cells() {
        return Err(wrong(format!("it has {} of the {} cells of this scene", tiles.len(), scene.cells())));
    }
    Ok(tiles)
}
