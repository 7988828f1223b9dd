//! What `mapgen stripes` is asked for, checked.

use std::path::Path;

use crate::common::error::CliError;
use vibrochain_breather::Family;
use vibrochain_floquet::participating_modes;
use vibrochain_lattice::Parameter;
use vibrochain_maps::scene::{Axis, Scene, Values};
use vibrochain_plot::Tile;

/// The most cells of a map: it is held whole, at about ten bytes a cell.
const MOST_CELLS: u64 = 10_000_000;

/// The most pairs of modes that are looked at, in all cells together: some nanoseconds each, an hour.
const MOST_PAIRS: u64 = 1_000_000_000_000;

/// Equally spaced values.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    pub(super) first: f64,
    pub(super) step: f64,
    pub(super) points: usize,
}

impl Steps {
    /// The value at a place between the points, in steps.
    pub(super) fn value(&self, place: f64) -> f64 {
        self.first + place * self.step
    }
}

/// A checked request.
#[derive(Debug)]
pub(super) struct Request {
    pub(super) scene: Scene,
    pub(super) omega: Steps,
    pub(super) gamma2: Steps,
    /// Number of the internal mode, above that of all others.
    pub(super) internal: usize,
}

impl Request {
    /// # Errors
    /// [`CliError::Request`].
    pub(super) fn read(path: &Path) -> Result<Self, CliError> {
        let scene = Scene::read(path)?;
        let name = path.display();
        let wrong = |what: &str| CliError::Request(format!("{name}: {what}"));
        ensure!(
            scene.is_conservative(),
            wrong("stripes are collisions of modes without loss: give a scene without force and with elastic impacts")
        );
        let cells = scene.cells();
        if cells > MOST_CELLS {
            return Err(wrong(&format!("the map has {cells} cells and is held whole: give at most {MOST_CELLS}")));
        }
        let model = scene.point(0).model().map_err(|error| wrong(&error.to_string()))?;
        let modes = model.chain().even_modes() as u64;
        // Half of all k, l, of both families.
        if modes.saturating_mul(modes).saturating_mul(cells) > MOST_PAIRS {
            let most = if scene.base.layout.is_ring() { 2 } else { 1 } * (MOST_PAIRS / cells).isqrt() - 1;
            let sites = scene.base.sites();
            return Err(wrong(&format!(
                "every pair of the modes of {sites} masses in every one of {cells} cells is too much: give at most {most} sites, or fewer points"
            )));
        }
        let axes = scene.plane().filter(|[x, y]| x.parameter == Parameter::Omega && y.parameter == Parameter::Gamma2);
        let Some([x, y]) = axes else {
            return Err(wrong(
                "lines are drawn over frequency and coupling: give a scene with x = omega and y = gamma2",
            ));
        };
        let (Some(omega), Some(gamma2)) = (steps(x), steps(y)) else {
            return Err(wrong("lines are drawn over equally spaced cells: give both axes by from, to and points"));
        };
        if !scene.task.stability {
            return Err(wrong("the map must tell stable from unstable cells: set stability = true in [compute]"));
        }
        // Families of scenes are at site 0.
        let internal = participating_modes(model.chain(), 0).len().saturating_sub(1);
        Ok(Self { scene, omega, gamma2, internal })
    }

    /// Number of a cell.
    pub(super) fn cell(&self, row: usize, column: usize) -> usize {
        row * self.omega.points + column
    }
}

fn steps(axis: &Axis) -> Option<Steps> {
    match axis.values {
        Values::Linear { from, to, points } => {
            Some(Steps { first: from, step: (to - from) / (points - 1) as f64, points })
        }
        _ => None,
    }
}

/// What is known of a tile's orbit: its family.
pub(super) fn family(tile: &Tile) -> Option<Family> {
    let (family, _) = tile.class?.parts()?;
    Some(family).filter(|family| *family != Family::Word)
}
