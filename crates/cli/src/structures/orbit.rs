//! `mapgen orbit` of a structure: all orbits of a word that are found, with their stability.

use std::path::Path;

use serde::Deserialize;
use vibrochain_breather::{
    Family, StructureFound, StructureModel, StructureOrbit, StructureOrbitError, StructureSearch, Word,
    structure_orbits,
};
use vibrochain_lattice::Barrier;
use vibrochain_maps::scene::tolerance_from;
use vibrochain_maps::structure::answer::json;
use vibrochain_maps::structure::{Answered, StructureScene};
use vibrochain_maps::text::read_text;

use super::answer::text;
use crate::args::{OrbitArgs, WhichArgs};
use crate::common::console::Console;
use crate::common::error::CliError;

/// The most bytes of a file with an orbit.
const MOST_BYTES: u64 = 16 << 20;

/// Runs the subcommand for a structure.
///
/// # Errors
/// [`CliError`]; that there is no orbit is an answer.
pub(crate) fn run(args: &OrbitArgs, scene: &StructureScene, console: &mut Console<'_>) -> Result<(), CliError> {
    let pictures =
        args.plot.is_some() || args.all_plots.is_some() || args.trajectory.is_some() || args.multipliers.is_some();
    if pictures {
        let message = "orbits of structures are told in words and by --json: --plot, --all-plots, --trajectory and --multipliers are of chains";
        return Err(CliError::Request(message.to_owned()));
    }
    let model = scene.model().map_err(CliError::Request)?;
    let tolerance = args.threshold.map_or(Ok(scene.tolerance), tolerance_from).map_err(CliError::Request)?;
    let (found, word, periods) = found(&args.which, scene, &model)?;
    let answered = found
        .orbits
        .iter()
        .map(|orbit| Answered::new(orbit, tolerance))
        .collect::<Result<Vec<_>, StructureOrbitError>>()?;
    let heading =
        format!("{word}{}", if periods > 1 { format!(" over {periods} periods of the load") } else { String::new() });
    let told = if args.json {
        let value = json(scene, &model, &heading, &found, &answered);
        format!("{value:#}\n")
    } else {
        text(&model, &heading, &found, &answered)
    };
    console.answer(&told, args.json, false)?;
    match answered.iter().find_map(|answered| answered.stability.as_ref().err()) {
        Some(error) => Err(CliError::from(error.clone()).about("stability could not be computed")),
        None => Ok(()),
    }
}

/// The orbits that flags or the scene ask for, with their word and its periods of the load.
pub(crate) fn found(
    which: &WhichArgs,
    scene: &StructureScene,
    model: &StructureModel,
) -> Result<(StructureFound, String, u32), CliError> {
    if let Some(path) = &which.near {
        let orbit = near(path, model)?;
        let (word, periods) = (orbit.word(), orbit.force_periods());
        return Ok((
            StructureFound { orbits: vec![orbit], search: StructureSearch::Starts { starts: 1 } },
            word,
            periods,
        ));
    }
    let of_family = which
        .family
        .and_then(|family| Some((Word::of_family(family)?, if family == Family::PeriodDoubled { 2 } else { 1 })));
    let (word, periods) = match (&which.word, of_family, &scene.word, &scene.words[..]) {
        (Some(word), ..) => (word.clone(), scene.force_periods),
        (None, Some(named), ..) => named,
        (None, None, Some(word), _) => (word.clone(), scene.force_periods),
        (None, None, None, [(word, periods)]) => (word.clone(), *periods),
        _ => {
            return Err(CliError::Request(
                "which orbits? give --word, as in 0+ or 0-,1+: contacts and their barriers".to_owned(),
            ));
        }
    };
    let periods = which.force_periods.unwrap_or(periods);
    Ok((structure_orbits(model, &word, periods)?, word.to_string(), periods))
}

/// Impacts of a file.
#[derive(Deserialize)]
struct Near {
    impacts: Vec<NearImpact>,
    #[serde(default)]
    psi: Option<f64>,
    #[serde(default)]
    period: Option<f64>,
}

#[derive(Deserialize)]
struct NearImpact {
    #[serde(alias = "site")]
    contact: usize,
    barrier: String,
    time: f64,
    impulse: f64,
}

/// The orbit next to that of a file: what --json has printed, or an object with `impacts`.
fn near(path: &Path, model: &StructureModel) -> Result<StructureOrbit, CliError> {
    let text = read_text("the orbit", path, MOST_BYTES)?;
    let wrong = |what: &dyn std::fmt::Display| CliError::Request(format!("{}: {what}", path.display()));
    let mut value: serde_json::Value = serde_json::from_str(&text).map_err(|error| wrong(&error))?;
    // What a run has settled on.
    if let Some(repeated) = value.get_mut("repeats").filter(|repeated| repeated.is_object()) {
        value = repeated.take();
    }
    if let Some(first) = value.get_mut("solutions").and_then(|list| list.get_mut(0)) {
        value = first.take();
    }
    let near: Near = serde_json::from_value(value).map_err(|error| wrong(&error))?;
    if near.impacts.is_empty() {
        return Err(wrong(&"it has no impacts"));
    }
    let impacts: Vec<(usize, Barrier, f64, f64)> = near
        .impacts
        .iter()
        .map(|impact| {
            let barrier = [Barrier::Lower, Barrier::Upper].into_iter().find(|barrier| barrier.name() == impact.barrier);
            let barrier =
                barrier.ok_or_else(|| wrong(&format!("barrier {} is unknown: give lower or upper", impact.barrier)))?;
            Ok((impact.contact, barrier, impact.time, impact.impulse))
        })
        .collect::<Result<_, CliError>>()?;
    let periods = near.period.map_or(1.0, |period| (period / model.period()).round()).clamp(1.0, 1e6) as u32;
    Ok(StructureOrbit::near(model, periods, near.psi.unwrap_or(0.0), &impacts)?)
}
