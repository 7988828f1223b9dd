//! Scenes as Python gives them, of a chain or of a structure, and what a map says of them.

use std::path::{Path, PathBuf};

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;
use vibrochain_fate::Ensembled;
use vibrochain_maps::cell::Class;
use vibrochain_maps::grid::{Files, Grid};
use vibrochain_maps::manifest::scene_parts;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::table::parameters;
use vibrochain_maps::text::read_text;
use vibrochain_plot::Mapped;

use crate::failure::Failure;

/// A scene over whose cells Python asks.
pub(crate) trait CellsScene: Grid + Ensembled + Mapped + 'static {
    /// All of it that decides what its map holds, as JSON, with its title.
    fn data(&self) -> String;

    /// Its heading, what is fixed, and what counts as stable.
    fn caption(&self) -> (String, String, String);

    /// Parameters that have a column, with the values of those that are fixed.
    fn fixed(&self) -> Vec<(String, f64)>;

    /// What the legend of a map calls a class beside others, where that is not of the class alone.
    fn legend(&self, class: Class, all: &[Class]) -> Option<String>;
}

impl CellsScene for Scene {
    fn data(&self) -> String {
        let mut parts = scene_parts(self);
        parts.extend(self.title.iter().map(|title| ("title".to_owned(), title.as_str().into())));
        Value::from(parts).to_string()
    }

    fn caption(&self) -> (String, String, String) {
        (self.heading(), Self::fixed(self), self.criterion())
    }

    fn fixed(&self) -> Vec<(String, f64)> {
        parameters(self).into_iter().map(|which| (which.name().to_owned(), self.base.get(which))).collect()
    }

    fn legend(&self, _: Class, _: &[Class]) -> Option<String> {
        None
    }
}

impl CellsScene for StructureScene {
    fn data(&self) -> String {
        Value::from(self.given().clone()).to_string()
    }

    fn caption(&self) -> (String, String, String) {
        (self.heading(), Self::fixed(self), self.criterion())
    }

    fn fixed(&self) -> Vec<(String, f64)> {
        self.places().into_iter().map(|which| (self.name_of(which), 0.0)).collect()
    }

    fn legend(&self, class: Class, all: &[Class]) -> Option<String> {
        Some(self.class(class, all))
    }
}

/// Whether a scene, a text with a name for messages or a file, is one of a structure.
///
/// # Errors
/// [`Failure`] where there is no such file.
pub(crate) fn is_of_structure(text: Option<&str>, path: &Path) -> Result<bool, Failure> {
    match text {
        Some(text) => Ok(StructureScene::is_one(text)),
        None => Failure::unless_there(path).map(|()| StructureScene::is_at(path)),
    }
}

/// A scene from its file, or from a text with a name for messages.
pub(crate) fn scene<S: Grid>(text: Option<&str>, path: &Path) -> Result<S, Failure> {
    match text {
        Some(text) => Ok(S::parse(path, text, &Files::new())?),
        None => {
            Failure::unless_there(path)?;
            Ok(S::parse(path, &read_text("scene", path, S::MOST_BYTES)?, &Files::new())?)
        }
    }
}

/// The parts of a scene in a file, as JSON.
#[pyfunction]
pub(crate) fn _scene(path: PathBuf) -> PyResult<String> {
    Ok(match is_of_structure(None, &path)? {
        true => scene::<StructureScene>(None, &path)?.data(),
        false => scene::<Scene>(None, &path)?.data(),
    })
}

/// What a scene's cells were made of, and its axes, the slowest first.
pub(crate) fn grid<S: CellsScene>(map: &Bound<'_, PyDict>, scene: &S) -> PyResult<()> {
    let py = map.py();
    map.set_item("scene", scene.data())?;
    map.set_item("caption", scene.caption())?;
    let axis = |axis: vibrochain_plot::MapAxis| {
        let values: Vec<f64> = (0..axis.values.points()).map(|i| axis.values.value(i)).collect();
        (axis.name, values.into_pyarray(py), axis.label)
    };
    let axes: Vec<_> = Mapped::axes(scene).into_iter().rev().map(axis).collect();
    map.set_item("axes", axes)?;
    map.set_item("parameters", scene.fixed())
}
