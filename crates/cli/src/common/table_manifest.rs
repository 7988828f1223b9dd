//! The manifest beside a table: what the table is of, and what the heading of its picture says of that. That of a sweep is written by
//! `vibrochain_maps`.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use vibrochain_fate::Ensemble;
use vibrochain_maps::files::Output;
use vibrochain_maps::manifest::{REVISION, VERSION, scene_parts};
use vibrochain_maps::numbers::plain;
use vibrochain_maps::scene::{MAX_BYTES, Scene};
use vibrochain_maps::table::stem;
use vibrochain_maps::text::{clipped, read_text};

use crate::common::chunked_run::place;
use crate::common::error::CliError;
use crate::common::schemas::{TABLE, expect};

/// Characters shown of what is wrong with a manifest.
const MOST_TOLD: usize = 200;

/// Where the manifest of a table goes: map.csv, map.csv.gz and map → map.manifest.json.
pub(crate) fn manifest_path(table: &Path) -> PathBuf {
    let name = table.file_name().unwrap_or_default().to_string_lossy().into_owned();
    table.with_file_name(format!("{}.manifest.json", stem(&name)))
}

/// The same of a table that may be one; none beside standard output, a pipe or a device.
pub(crate) fn beside(table: Option<&Path>) -> Result<Option<PathBuf>, CliError> {
    let Some(table) = table else { return Ok(None) };
    Ok(place(table)?.map(|_| manifest_path(table)))
}

/// A manifest that is to be written.
pub(crate) struct Manifest(Option<Output>);

impl Manifest {
    /// # Errors
    /// [`CliError::Request`] if it cannot be.
    pub(crate) fn create(path: Option<&Path>) -> Result<Self, CliError> {
        Ok(Self(path.map(Output::create).transpose()?))
    }

    /// Writes what a table of `command` with so many rows is of.
    pub(crate) fn finish(self, command: &str, rows: u64, about: &impl Serialize) -> Result<(), CliError> {
        let Some(file) = self.0 else { return Ok(()) };
        let mut all = Map::new();
        let mut add = |name: &str, value: Value| drop(all.insert(name.to_owned(), value));
        add("schema", TABLE.into());
        add("program", "mapgen".into());
        add("version", VERSION.into());
        add("revision", REVISION.into());
        add("command", command.into());
        add("rows", rows.into());
        let about = serde_json::to_value(about).map_err(|error| CliError::Computation(error.to_string()))?;
        if let Value::Object(about) = about {
            all.extend(about);
        }
        Ok(file.finish_with(format!("{:#}\n", Value::Object(all)).as_bytes())?)
    }
}

/// What every manifest has.
#[derive(Deserialize)]
struct Common {
    schema: Option<String>,
    command: Option<String>,
    rows: Option<u64>,
}

/// Reads what a table of `command` is of, and how many rows it has.
///
/// # Errors
/// [`CliError::Request`] of a file that is no such manifest.
pub(crate) fn read<T: DeserializeOwned>(path: &Path, command: &str) -> Result<(u64, T), CliError> {
    let text = read_text("manifest", path, MAX_BYTES)?;
    let wrong = |what: &str| CliError::Request(format!("manifest {}: {}", path.display(), clipped(what, MOST_TOLD)));
    let unreadable = |error: serde_json::Error| wrong(&plain(&error.to_string()));
    let common: Common = serde_json::from_str(&text).map_err(unreadable)?;
    expect(path, Some(common.schema.as_deref().unwrap_or("none")), TABLE)?;
    let (told, Some(rows)) = (common.command.unwrap_or_default(), common.rows) else {
        return Err(wrong("it does not say how many rows the table has"));
    };
    if told != command {
        return Err(wrong(&format!("it is of a table of {told}, the table is one of {command}")));
    }
    Ok((rows, serde_json::from_str(&text).map_err(unreadable)?))
}

/// How runs of an ensemble are started, how long they are, and by what they are told apart.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Runs {
    starts: u64,
    perturb: f64,
    seed: u64,
    periods: u64,
    transient: f64,
    tolerance: f64,
    leave: f64,
}

impl From<&Ensemble> for Runs {
    fn from(ensemble: &Ensemble) -> Self {
        let Ensemble { starts, size, seed, periods, transient, tolerance, leave } = *ensemble;
        Self { starts, perturb: size, seed, periods, transient, tolerance, leave }
    }
}

impl From<Runs> for Ensemble {
    fn from(runs: Runs) -> Self {
        let Runs { starts, perturb, seed, periods, transient, tolerance, leave } = runs;
        Self { starts, size: perturb, seed, periods, transient, tolerance, leave }
    }
}

/// What the table of an ensemble is of, besides its scene.
#[derive(Deserialize)]
pub(crate) struct OfRuns {
    pub(crate) ensemble: Runs,
}

/// What the table of a scene is of, and of an ensemble over it.
pub(crate) fn of_scene(scene: &Scene, ensemble: Option<&Ensemble>) -> Map<String, Value> {
    let mut all = Map::from_iter([("title".to_owned(), scene.title.clone().into())]);
    all.extend(scene_parts(scene));
    let runs = ensemble.and_then(|ensemble| serde_json::to_value(Runs::from(ensemble)).ok());
    all.extend(runs.map(|runs| ("ensemble".to_owned(), runs)));
    all
}
