//! Orbits of any linear structure: a scene as JSON in, the answer as JSON out.

use std::path::Path;

use pyo3::prelude::*;
use vibrochain_breather::{
    StructureFound, StructureOrbit, StructureOrbitError, StructureSearch, Word, structure_orbits,
};
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Barrier, Stop, StructureError};
use vibrochain_maps::structure::answer::json;
use vibrochain_maps::structure::{Answered, StructureScene};

use crate::call::long;
use crate::failure::Failure;

impl From<StructureOrbitError> for Failure {
    fn from(error: StructureOrbitError) -> Self {
        let message = error.to_string();
        match error {
            StructureOrbitError::Structure(StructureError::Resonance { .. }) => Self::IllConditioned(message),
            StructureOrbitError::LossWithoutLoad
            | StructureOrbitError::Unbalanced
            | StructureOrbitError::Unfelt
            | StructureOrbitError::Singular => Self::NoBreather(message),
            StructureOrbitError::NotConverged { .. } | StructureOrbitError::Structure(StructureError::NotConverged) => {
                Self::NotConverged(message)
            }
            _ => Self::Request(message),
        }
    }
}

/// Orbits of a word, or the one near given impacts (contact, barrier, time, impulse), of the structure in `scene`.
#[pyfunction]
#[pyo3(signature = (scene, word, force_periods, threshold, near, psi))]
pub(crate) fn _structure(
    py: Python<'_>,
    scene: String,
    word: Option<String>,
    force_periods: u32,
    threshold: f64,
    near: Vec<(usize, String, f64, f64)>,
    psi: f64,
) -> PyResult<String> {
    let work = move |_: &Stop| {
        let scene = StructureScene::of_text(&scene, Path::new(".")).map_err(Failure::Request)?;
        let model = scene.model().map_err(Failure::Request)?;
        let tolerance = vibrochain_maps::scene::tolerance_from(threshold).map_err(Failure::Request)?;
        let tolerance = if threshold == 0.0 { Tolerance::Rounding } else { tolerance };
        let found = match &word {
            Some(word) => {
                let word: Word = word.parse().map_err(|error| Failure::Request(format!("word {word}: {error}")))?;
                structure_orbits(&model, &word, force_periods)?
            }
            None => {
                let impacts = near.iter().map(|(contact, barrier, time, impulse)| {
                    let named = Barrier::from_name(barrier);
                    let wrong = || Failure::Request(format!("barrier {barrier} is unknown: give lower or upper"));
                    Ok((*contact, named.ok_or_else(wrong)?, *time, *impulse))
                });
                let impacts = impacts.collect::<Result<Vec<_>, Failure>>()?;
                if impacts.is_empty() {
                    return Err(Failure::request("there are no impacts to begin near: give a word, or an orbit"));
                }
                let orbit = StructureOrbit::near(&model, force_periods, psi, &impacts)?;
                StructureFound { orbits: vec![orbit], search: StructureSearch::Starts { starts: 1 } }
            }
        };
        let answered = found.orbits.iter().map(|orbit| Answered::new(orbit, tolerance));
        let answered = answered.collect::<Result<Vec<_>, StructureOrbitError>>()?;
        Ok::<String, Failure>(json(&scene, &model, word.as_deref().unwrap_or("near"), &found, &answered).to_string())
    };
    long(py, |_| Ok(()), work)
}
