//! The file of a scene: of a structure, or of a chain that is one.

use std::path::Path;

use super::StructureScene;
use super::text::told;
use crate::error::MapError;
use crate::grid::Files;
use crate::structure::damped_chain;
use crate::structure::named::{MOST_BYTES, Named};
use crate::text::read_text;

impl StructureScene {
    /// The scene of a file if it is one of a structure; `None` of a chain's.
    ///
    /// # Errors
    /// [`MapError::Request`] with the file and what is wrong in it.
    pub fn read(path: &Path) -> Result<Option<Self>, MapError> {
        text_of(path).map(|text| Self::checked(path, &text, &Files::new())).transpose()
    }

    /// Whether a file is a scene of a structure, or of a chain that is one.
    #[must_use]
    pub fn is_at(path: &Path) -> bool {
        text_of(path).is_some()
    }

    /// The same of a text.
    pub(in crate::structure) fn is_scene(text: &str) -> bool {
        // What is no table at all is told by those who read chains. Of JSON, answers of commands speak of structures, too.
        told(text).is_ok_and(|told| {
            let is_answer = told.contains_key("schema");
            !is_answer && (told.contains_key("structure") || damped_chain::is_one(&told))
        })
    }

    /// The scene of a text with the files `kept`, or those beside `path`.
    pub(in crate::structure) fn checked(path: &Path, text: &str, kept: &Files) -> Result<Self, MapError> {
        let read = || {
            if !told(text)?.contains_key("structure") {
                return damped_chain::read(told(text)?);
            }
            Self::of_given(text, &Named::new(path.parent().unwrap_or(Path::new(".")), kept))
        };
        read().map_err(|why: String| MapError::Request(format!("{}: {why}", path.display())))
    }
}

/// The text of a file if it is such a scene.
fn text_of(path: &Path) -> Option<String> {
    // What cannot be read, and what can be read only once, is left to those who read chains.
    let plain = path.metadata().is_ok_and(|data| data.is_file());
    plain.then(|| read_text("the scene", path, MOST_BYTES).ok()).flatten().filter(|text| StructureScene::is_scene(text))
}
