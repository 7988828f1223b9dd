//! The file of a scene: of a structure, or of a chain that is one.

use std::path::Path;

use super::damped_chain;
use super::scene::StructureScene;
use crate::error::MapError;
use crate::text::read_text;

/// The most bytes of a scene.
const MOST_BYTES: u64 = 64 << 20;

impl StructureScene {
    /// The scene of a file if it is one of a structure; `None` of a chain's, or of JSON.
    ///
    /// # Errors
    /// [`MapError::Request`] with the file and what is wrong in it.
    pub fn read(path: &Path) -> Result<Option<Self>, MapError> {
        // What cannot be read, and what can be read only once, is left to those who read chains.
        let plain = path.metadata().is_ok_and(|data| data.is_file());
        let Some(text) = plain.then(|| read_text("the scene", path, MOST_BYTES).ok()).flatten() else {
            return Ok(None);
        };
        if text.trim_start().starts_with('{') {
            return Ok(None);
        }
        // What is no table at all is told by those who read chains.
        let Ok(table) = text.parse::<toml::Table>() else { return Ok(None) };
        if !table.contains_key("structure") {
            let damped = damped_chain::is_one(&table);
            let scene = damped.then(|| damped_chain::read(&text)).transpose();
            return scene.map_err(|why| MapError::Request(format!("{}: {why}", path.display())));
        }
        let folder = path.parent().unwrap_or(Path::new("."));
        Self::of_text(&text, folder).map(Some).map_err(|why| MapError::Request(format!("{}: {why}", path.display())))
    }
}
