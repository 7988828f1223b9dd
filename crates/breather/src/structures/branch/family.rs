//! Models by the values of numbers that are free, and what it shows of a structure that one of them moves.

use std::sync::Arc;

use crate::error::BreatherError;
use crate::structures::equations::Equations;
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
    /// Which of them is the coupling of the masses, if one is: where it is 0, all modes have the same multipliers.
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

/// Refuses numbers that bring losses or a load to an orbit without a load, or that change nothing of a self-excited structure.
pub(super) fn check(family: &ModelFamily, values: &[f64], equations: &Equations<'_>) -> Result<(), BreatherError> {
    if equations.forced {
        return Ok(());
    }
    for which in 0..values.len() {
        let moved = aside(family, values, which);
        let mut structures = moved.iter().flatten().map(LoadedStructure::structure);
        if !equations.has_time() && structures.clone().any(|structure| !structure.is_lossless()) {
            return Err(BreatherError::LossWithoutLoad);
        }
        if structures.any(|structure| structure.is_forced()) {
            return Err(BreatherError::LoadWithoutPhase { which });
        }
        // As ω does, which no load has.
        let is_idle = || matches!(&moved, [Ok(one), Ok(other)] if one.structure() == other.structure());
        if equations.self_excited && is_idle() {
            return Err(BreatherError::NoEffect);
        }
    }
    Ok(())
}
