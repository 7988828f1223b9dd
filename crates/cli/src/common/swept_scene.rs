//! The scene of a map, of a chain or of a structure, as the commands take it that compute, draw and merge maps.

use serde_json::{Map, Value, json};
use vibrochain_fate::Sectioned;
use vibrochain_lattice::Parameter;
use vibrochain_maps::grid::Grid;
use vibrochain_maps::manifest::{object, scene_parts};
use vibrochain_maps::scene::Scene;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::structure::answer::structure;
use vibrochain_plot::Mapped;

use crate::args::{PictureArgs, QuantityName};
use crate::common::error::CliError;
use crate::common::model::springs;
use crate::common::pictures::Pictures;

/// A scene that commands over a map take.
pub(crate) trait SweptScene: Grid + Sectioned + Mapped + 'static {
    /// What a user may not expect of it.
    fn remark(&self) -> Option<&'static str> {
        None
    }

    /// Pictures of its map.
    ///
    /// # Errors
    /// [`CliError::Request`] for those that cannot be drawn or written.
    fn pictures(&self, wanted: &PictureArgs, show: QuantityName) -> Result<Pictures<Self>, CliError>;

    /// What it is, in the answer of an ensemble.
    ///
    /// # Errors
    /// [`CliError::Request`] of a scene without a model.
    fn about(&self) -> Result<Map<String, Value>, CliError>;
}

impl SweptScene for Scene {
    fn remark(&self) -> Option<&'static str> {
        let gamma2 = self.point(self.cells() - 1).get(Parameter::Gamma2);
        springs(&self.base.layout, gamma2)
    }

    fn pictures(&self, wanted: &PictureArgs, show: QuantityName) -> Result<Pictures<Self>, CliError> {
        Pictures::plan(wanted, show, self)
    }

    fn about(&self) -> Result<Map<String, Value>, CliError> {
        Ok(scene_parts(self))
    }
}

impl SweptScene for StructureScene {
    fn pictures(&self, wanted: &PictureArgs, show: QuantityName) -> Result<Pictures<Self>, CliError> {
        Pictures::of_structure(wanted, show, self)
    }

    fn about(&self) -> Result<Map<String, Value>, CliError> {
        let model = self.model()?;
        Ok(object([("structure", structure(self, &model)), ("axes", json!(self.axis_names))]))
    }
}
