//! The regions of a scene: what lives in a face is what its cell says.

use crate::cell::{Cell, Status, Worker};
use crate::error::MapError;
use crate::regions::plane::Regions;
use crate::regions::subdivision::Subdivision;
use crate::regions::window::Window;
use crate::scene::Scene;

impl<T: Clone + Eq + Send + Sync> Regions<T> {
    /// The window of a scene cut by borders, as [`Subdivision::new`] has it, and classified by cells, as
    /// [`Subdivision::classified`] has it: `class` says what of a cell counts, its class, or its mechanism, too.
    ///
    /// # Errors
    /// [`MapError::Request`] for a scene without a plane of two ranges, and those of [`Subdivision::new`].
    pub fn of_scene(
        scene: &Scene,
        borders: &[Vec<[f64; 2]>],
        tolerance: f64,
        samples: usize,
        class: impl Fn(&Cell) -> T + Send + Sync,
    ) -> Result<Self, MapError> {
        let subdivision = Subdivision::new(Window::of(scene)?, borders, tolerance)?;
        let worker = || Worker::new(scene.base.sites());
        // What lives where a cell is not known; places beside it tell.
        let unknown = Cell { class: None, status: Status::IllConditioned, ..Cell::EMPTY };
        let none = class(&unknown);
        let at = |worker: &mut Worker, point: [f64; 2]| {
            // The scene's corners were checked, so that every point between is a valid model.
            class(&scene.at(&point).model().map_or(unknown, |model| worker.cell(&model, &scene.task)))
        };
        Ok(subdivision.classified_but(samples, worker, at, |answer| *answer == none))
    }
}
