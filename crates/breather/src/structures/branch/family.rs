//! Models by the values of numbers that are free, and what it shows of a structure that one of them moves.

use std::sync::Arc;

use crate::structures::model::LoadedStructure;

/// How far a number is moved, relative, to see whether it brings losses, changes nothing at all, or breaks a symmetry.
pub(super) const MOVED: f64 = 1e-3;

/// Models by the values of the numbers that are free; what is wrong with values that have none.
pub type ModelFamily = Arc<dyn Fn(&[f64]) -> Result<LoadedStructure, String> + Send + Sync>;

/// Numbers of a model that vary along branches and curves.
#[derive(Clone)]
pub struct FreeNumbers {
    /// The models by their values.
    pub models: ModelFamily,
    /// Where they begin.
    pub start: Vec<f64>,
    /// What they are called.
    pub names: Vec<String>,
    /// Which of them couples the masses: where it is 0, multipliers of modes become as one.
    pub coupling: Option<usize>,
}

/// The models on both sides of these values of the numbers, in one of them.
fn aside(family: &ModelFamily, values: &[f64], which: usize) -> [Result<LoadedStructure, String>; 2] {
    [1.0, -1.0].map(|sign| {
        let mut moved = values.to_vec();
        moved[which] += sign * MOVED * values[which].abs().max(1.0);
        family(&moved)
    })
}

/// Whether one of the numbers brings losses where it moves.
pub(super) fn loses_energy(family: &ModelFamily, values: &[f64], which: usize) -> bool {
    aside(family, values, which).into_iter().flatten().any(|model| !model.structure().is_lossless())
}

/// Whether one of the numbers brings a load that changes where it moves.
pub(super) fn brings_load(family: &ModelFamily, values: &[f64], which: usize) -> bool {
    aside(family, values, which).into_iter().flatten().any(|model| model.structure().is_forced())
}

/// Whether a self-excited structure is the same wherever one of the numbers moves: ω, which no load has.
pub(super) fn is_idle(family: &ModelFamily, values: &[f64], which: usize) -> bool {
    matches!(aside(family, values, which), [Ok(one), Ok(other)] if one.structure() == other.structure())
}
