//! `mapgen orbit` of a structure: all orbits of a word that are found, with their stability.

use std::path::Path;

use serde::Deserialize;
use vibrochain_breather::{
    BreatherError, ContactMotion, ContactOrbit, Family, Hit, LoadedStructure, Orbit, OrbitList, Word,
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
use crate::common::impact_table;
use crate::orbit::multiplier_file::MultiplierFile;
use crate::orbit::pictures::{OrbitPictures, apart};
use crate::orbit::trajectory::OrbitTrajectory;

/// The most bytes of a file with an orbit.
const MOST_BYTES: u64 = 16 << 20;

/// A solution with what it is of, as pictures take it.
pub(super) struct Drawn<'a> {
    pub(super) answered: &'a Answered<'a>,
    pub(super) scene: &'a StructureScene,
    pub(super) word: &'a str,
}

/// Runs the subcommand for a structure.
///
/// # Errors
/// [`CliError`]; that there is no orbit is an answer.
pub(crate) fn run(args: &OrbitArgs, scene: &StructureScene, console: &mut Console<'_>) -> Result<(), CliError> {
    let taken = apart(args)?;
    let stop = (console.interrupt)()?;
    let model = scene.model()?;
    let tolerance = args.threshold.map_or(Ok(scene.tolerance), tolerance_from)?;
    let file = args.multipliers.as_deref().map(MultiplierFile::create).transpose()?;
    let trajectory = OrbitTrajectory::open(args, columns(&model))?;
    let pictures = OrbitPictures::open(args)?;
    let OfWord { found, word, periods } = found(&args.which, scene, &model)?;
    let answered =
        found.orbits.iter().map(|orbit| Answered::new(orbit, tolerance)).collect::<Result<Vec<_>, BreatherError>>()?;
    let heading =
        format!("{word}{}", if periods > 1 { format!(" over {periods} periods of the load") } else { String::new() });
    let told = if args.json {
        let value = json(scene, &model, &heading, &found, &answered);
        format!("{value:#}\n")
    } else {
        text(scene, &heading, &found, &answered)
    };
    console.answer(&told, args.json, taken)?;
    if let Some(mut file) = file {
        for (one, number) in answered.iter().zip(1..) {
            let multipliers = one.stability.iter().flat_map(|stability| stability.multipliers.iter().copied());
            file.rows(number, multipliers, &stop, |_| None::<usize>)?;
        }
        file.finish()?;
    }
    if let Some(mut table) = trajectory {
        for (one, number) in answered.iter().zip(1..) {
            let Some(contacts) = one.orbit.contacts() else { continue };
            let motion = ContactMotion::new(contacts)?;
            table.period(number, contacts.period(), |time| state(&motion, contacts, time))?;
        }
        table.finish()?;
    }
    let drawn = answered.iter().map(|answered| Drawn { answered, scene, word: &heading });
    pictures.finish(&drawn.collect::<Vec<_>>(), console)?;
    match answered.iter().find_map(|answered| answered.stability.as_ref().err()) {
        Some(error) => Err(CliError::from(error.clone()).about("stability could not be computed")),
        None => Ok(()),
    }
}

/// `time,contact_0,…,contact_velocity_0,…,displacement_0,…,velocity_0,…`: coordinates where the structure has them.
pub(super) fn columns(model: &LoadedStructure) -> impl Iterator<Item = String> + use<> {
    let structure = model.structure();
    let (contacts, coordinates) = (structure.contacts().len(), structure.coordinates());
    let columns = |name: &'static str, count: usize| (0..count).map(move |n| format!("{name}_{n}"));
    let contacts = columns("contact", contacts).chain(columns("contact_velocity", contacts));
    let coordinates = columns("displacement", coordinates).chain(columns("velocity", coordinates));
    std::iter::once("time".to_owned()).chain(contacts).chain(coordinates)
}

/// These columns after the time, at a time within a period of an orbit or at its end.
fn state(motion: &ContactMotion<'_>, orbit: &ContactOrbit, time: f64) -> Result<Vec<f64>, CliError> {
    let impacts = orbit.impacts();
    let i = impacts.partition_point(|impact| impact.time <= time).saturating_sub(1);
    let s = time - impacts[i].time;
    let contacts: Vec<[f64; 3]> =
        (0..orbit.model().structure().contacts().len()).map(|contact| motion.contact(contact, i, s)).collect();
    let coordinates = motion.coordinates(i, s)?;
    let of_contacts = [0, 1].into_iter().flat_map(|n| contacts.iter().map(move |contact| contact[n]));
    let of_coordinates = [0, 1].into_iter().flat_map(|n| coordinates.iter().map(move |state| state[n]));
    Ok(of_contacts.chain(of_coordinates).collect())
}

/// Orbits of a word.
pub(crate) struct OfWord {
    pub(crate) found: OrbitList,
    pub(crate) word: String,
    /// Periods of the load.
    pub(crate) periods: u32,
}

/// The orbits that flags or the scene ask for.
pub(crate) fn found(which: &WhichArgs, scene: &StructureScene, model: &LoadedStructure) -> Result<OfWord, CliError> {
    if let Some(path) = &which.near {
        let orbit = near(path, model)?;
        let (word, periods) = (Word::of(&orbit).to_string(), orbit.force_periods());
        return Ok(OfWord { found: OrbitList::near(orbit), word, periods });
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
            refuse!("which orbits? give --word, as in 0+ or 0-,1+: contacts and their barriers");
        }
    };
    let periods = which.force_periods.unwrap_or(periods);
    Ok(OfWord { found: model.orbits(&word, periods)?, word: word.to_string(), periods })
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

/// The orbit next to that of a file: what --json has printed, an object with `impacts`, or the table of a run that has settled on one.
fn near(path: &Path, model: &LoadedStructure) -> Result<Orbit, CliError> {
    let text = read_text("the orbit", path, MOST_BYTES)?;
    let wrong = |what: &dyn std::fmt::Display| CliError::Request(format!("{}: {what}", path.display()));
    if impact_table::is_one(&text) {
        let (periods, struck) = impact_table::settled(&text, model.period()).map_err(|why| wrong(&why))?;
        let impacts: Vec<_> = struck.iter().map(|one| Hit::new(one.site, one.barrier, one.time, one.impulse)).collect();
        let lead = |psi: f64| model.orbit_near(periods, psi, &impacts);
        return Ok(impact_table::nearest(&struck, model.period(), lead, Orbit::impulses)?);
    }
    let mut value: serde_json::Value = serde_json::from_str(&text).map_err(|error| wrong(&error))?;
    // What a run has settled on.
    if let Some(repeated) = value.get_mut("repeats").filter(|repeated| repeated.is_object()) {
        value = repeated.take();
    }
    if let Some(first) = value.get_mut("solutions").and_then(|list| list.get_mut(0)) {
        value = first.take();
    }
    let near: Near = serde_json::from_value(value).map_err(|error| wrong(&error))?;
    ensure!(!near.impacts.is_empty(), wrong(&"it has no impacts"));
    let impacts: Vec<Hit> = near
        .impacts
        .iter()
        .map(|impact| {
            let barrier = Barrier::from_name(&impact.barrier)
                .ok_or_else(|| wrong(&format!("barrier {} is unknown: give lower or upper", impact.barrier)))?;
            Ok(Hit::new(impact.contact, barrier, impact.time, impact.impulse))
        })
        .collect::<Result<_, CliError>>()?;
    let periods = near.period.map_or(1.0, |period| (period / model.period()).round()).clamp(1.0, 1e6) as u32;
    Ok(model.orbit_near(periods, near.psi.unwrap_or(0.0), &impacts)?)
}
