//! The manifest beside a table: what the table is of, and what the heading of its picture says of that. That of a sweep is written by
//! `vibrochain_maps`.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use vibrochain_fate::Ensemble;
use vibrochain_maps::files::Output;
use vibrochain_maps::grid::Grid;
use vibrochain_maps::manifest::{REVISION, VERSION};
use vibrochain_maps::numbers::plain;
use vibrochain_maps::scene::MAX_BYTES;
use vibrochain_maps::table::stem;
use vibrochain_maps::text::{clipped, read_text};

use crate::common::answer::{joined, printed};
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
        let program = json!({ "schema": TABLE, "program": "mapgen", "version": VERSION, "revision": REVISION });
        let all = joined(joined(program, json!({ "command": command, "rows": rows })), json!(about));
        Ok(file.finish_with(printed(&all)?.as_bytes())?)
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
    ensure!(told == command, wrong(&format!("it is of a table of {told}, the table is one of {command}")));
    Ok((rows, serde_json::from_str(&text).map_err(unreadable)?))
}

/// What the table of an ensemble is of, besides its scene.
#[derive(Deserialize)]
pub(crate) struct OfRuns {
    pub(crate) ensemble: Ensemble,
}

/// What the table of a scene is of, and of an ensemble over it.
#[derive(Serialize)]
pub(crate) struct OfScene<'a> {
    title: Option<&'a str>,
    #[serde(flatten)]
    scene: Map<String, Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ensemble: Option<&'a Ensemble>,
}

impl<'a> OfScene<'a> {
    pub(crate) fn new<S: Grid>(scene: &'a S, ensemble: Option<&'a Ensemble>) -> Self {
        Self { title: scene.title(), scene: scene.parts(), ensemble }
    }
}
