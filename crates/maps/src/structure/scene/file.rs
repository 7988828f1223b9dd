//! The file of a scene: of a structure, or of a chain that is one.

use std::path::Path;

use super::StructureScene;
use super::text::Parsed;
use crate::error::MapError;
use crate::grid::Files;
use crate::scene::MAX_BYTES;
use crate::structure::damped_chain;
use crate::structure::named::Named;
use crate::text::read_text;

impl StructureScene {
    /// The scene of a file if it is one of a structure; `None` of a chain's.
    ///
    /// # Errors
    /// [`MapError::Request`] with the file and what is wrong in it.
    pub fn read(path: &Path) -> Result<Option<Self>, MapError> {
        let text = text_of(path);
        let scene = text.as_deref().and_then(|text| scene_in(path, text));
        scene.map(|parsed| Self::of_parsed(path, parsed, &Files::new())).transpose()
    }

    /// Whether a file is a scene of a structure, or of a chain that is one.
    #[must_use]
    pub fn is_at(path: &Path) -> bool {
        text_of(path).is_some_and(|text| Self::is_scene(&text))
    }

    /// The same of a text.
    pub(in crate::structure) fn is_scene(text: &str) -> bool {
        scene_in(Path::new(""), text).is_some()
    }

    /// The scene of a text with the files `kept`, or those beside `path`.
    pub(in crate::structure) fn checked(path: &Path, text: &str, kept: &Files) -> Result<Self, MapError> {
        Self::of_parsed(path, Parsed::of(path, text)?, kept)
    }

    fn of_parsed(path: &Path, parsed: Parsed<'_>, kept: &Files) -> Result<Self, MapError> {
        let scene = match parsed.told.get("structure") {
            Some(_) => Self::of_file(parsed.tables()?, &Named::new(path.parent().unwrap_or(Path::new(".")), kept)),
            None => damped_chain::read(parsed.tables()?),
        };
        scene.map_err(|why| MapError::Request(format!("{}: {why}", path.display())))
    }
}

/// The text of a plain file: what cannot be read, and what can be read only once, is left to those who read chains.
fn text_of(path: &Path) -> Option<String> {
    let plain = path.metadata().is_ok_and(|data| data.is_file());
    plain.then(|| read_text("the scene", path, MAX_BYTES).ok()).flatten()
}

/// A text if it is such a scene.
fn scene_in<'a>(path: &'a Path, text: &'a str) -> Option<Parsed<'a>> {
    // What is no table at all is told by those who read chains. Of JSON, answers of commands speak of structures, too.
    Parsed::of(path, text).ok().filter(|Parsed { told, .. }| {
        told.get("schema").is_none() && (told.get("structure").is_some() || damped_chain::is_one(told))
    })
}
