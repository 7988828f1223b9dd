//! The breathers that a command is asked about: of a family, of an impact word, or near a given one.

use std::path::Path;

use serde::Deserialize;
use vibrochain_breather::{BreatherError, Family, Finder, Hit, Limit, Orbit, OrbitList, Scope, Word};
use vibrochain_lattice::{Barrier, Model};

use crate::args::WhichArgs;
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::impact_table::{self, Struck};
use crate::common::schemas::{self, ORBIT, expect};
use vibrochain_maps::cell::SYMMETRIC;
use vibrochain_maps::followed::over;
use vibrochain_maps::numbers::{Number, plain};
use vibrochain_maps::scene::Given;

/// Families that are searched for by name.
const FAMILIES: [Family; 3] = [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled];

/// What the flags ask for, or else the file that the model comes from: the orbit it holds, or its only family or word.
///
/// # Errors
/// [`CliError::Request`] where neither says it.
pub(crate) fn wanted(which: &WhichArgs, scene: Option<&Given>) -> Result<WhichArgs, CliError> {
    let is_of_word = which.family.is_none() && which.near.is_none();
    ensure!(
        which.force_periods.is_none() || is_of_word,
        "--force-periods says how long a word is: give it with --word"
    );
    let Some(scene) = scene.filter(|_| which.family.is_none() && which.word.is_none() && which.near.is_none()) else {
        return Ok(which.clone());
    };
    let none = WhichArgs { family: None, word: None, force_periods: None, near: None };
    if scene.has_orbits {
        return Ok(WhichArgs { near: Some(scene.path.clone()), ..none });
    }
    let path = scene.path.display();
    match scene.families.as_slice() {
        [] => refuse!("{path} does not say which breathers: give --family, --word or --near"),
        [one] if one == SYMMETRIC => Ok(WhichArgs { family: Some(Family::DoubleSided), ..none }),
        [one] => match FAMILIES.into_iter().find(|family| family.name() == one) {
            Some(family) => Ok(WhichArgs { family: Some(family), ..none }),
            None => {
                let word = one.parse().map_err(|error| CliError::Request(format!("{path}: families: {error}")))?;
                Ok(WhichArgs { word: Some(word), force_periods: which.force_periods, ..none })
            }
        },
        several => refuse!("{path} has {}: say which by --family, --word or --near", several.join(", ")),
    }
}

/// Their name in headings, and all there are, or those that completeness speaks of.
///
/// # Errors
/// [`CliError`]; that there is none is an answer.
pub(crate) fn find(
    which: &WhichArgs,
    model: &Model,
    finder: &mut Finder,
    console: Option<&mut Console<'_>>,
) -> Result<(String, OrbitList), CliError> {
    let mut found = OrbitList::default();
    if let Some(family) = which.family {
        search(model, &mut found, |model, found| finder.find(model, family, found))?;
        return Ok((family.name().to_owned(), found));
    }
    if let Some(word) = &which.word {
        word.check(&model.chain().layout()).map_err(|error| CliError::Request(format!("--word: {error}")))?;
        let canonical = word.canonical(model);
        if let (true, Some(console)) = (canonical != *word, console) {
            console.summary(&format!("{word} is the word {canonical}"));
        }
        let Some(periods) = which.force_periods else {
            search(model, &mut found, |model, found| finder.find_word(model, &canonical, Scope::All, found))?;
            return Ok((canonical.to_string(), found));
        };
        ensure!(
            !model.is_conservative() || periods <= 1,
            "--force-periods counts periods of a force: without one the word's period is 2π/omega, give omega/N"
        );
        search(model, &mut found, |model, found| finder.find_word_over(model, &canonical, periods, found))?;
        return Ok((over(&canonical.to_string(), periods), found));
    }
    let Some(path) = &which.near else {
        refuse!("give --family, --word, --near FILE or --scene FILE");
    };
    let mut polished = |near: &Orbit| finder.polish(near).map_err(|error| CliError::from(error).about("--near"));
    // Once: what comes through a pipe cannot be read again.
    let text = std::fs::read_to_string(path).map_err(|error| CliError::file("cannot read orbit", path, &error))?;
    let orbit = if impact_table::is_one(&text) {
        let settled = impact_table::settled(&text, model.period());
        let (periods, struck) = settled.map_err(|what| wrong(path, &what))?;
        let hits = struck.iter().map(|one| hit(path, model, one)).collect::<Result<Vec<_>, _>>()?;
        let about = |error: BreatherError| CliError::from(error).about("--near");
        let lead = |psi: f64| polished(&Orbit::from_impulses(model, periods, psi, &hits).map_err(about)?);
        let impulses = |orbit: &Orbit| orbit.impacts().iter().map(|impact| impact.impulse).collect();
        impact_table::nearest(&struck, model.period(), lead, impulses)?
    } else {
        polished(&read(path, &text, model)?)?
    };
    let word = Word::of(&orbit).to_string();
    Ok((word, OrbitList::near(orbit)))
}

/// The orbits that were found, of which there is one.
///
/// # Errors
/// [`CliError::IllPosed`] where there is none.
pub(crate) fn some(found: OrbitList) -> Result<Vec<Orbit>, CliError> {
    let OrbitList { orbits, completeness, .. } = found;
    match completeness.reason() {
        Some(reason) => Err(CliError::IllPosed(format!("no orbit to start from: {reason}"))),
        None if orbits.is_empty() => {
            Err(CliError::IllPosed(format!("no orbit was found to start from, and the list is {completeness}")))
        }
        None => Ok(orbits),
    }
}

/// A search; at a resonance, without one, what becomes there of the orbits beside it.
fn search(
    model: &Model,
    found: &mut OrbitList,
    mut find: impl FnMut(&Model, &mut OrbitList) -> Result<(), BreatherError>,
) -> Result<(), CliError> {
    let resonance = match find(model, found) {
        Err(BreatherError::Resonance(resonance)) => resonance,
        other => return Ok(other?),
    };
    let limits = Limit::all(model, &resonance, |model| {
        let mut beside = OrbitList::default();
        match find(model, &mut beside) {
            Ok(()) => Ok(beside.orbits),
            Err(stopped @ BreatherError::Stopped(_)) => Err(stopped),
            Err(_) => Ok(Vec::new()),
        }
    })?;
    let told = limits.first().map(|limit| format!("; {limit}")).unwrap_or_default();
    Err(CliError::IllPosed(format!("{resonance}{told}")))
}

#[derive(Deserialize)]
struct OrbitFile {
    #[serde(default, deserialize_with = "schemas::text")]
    schema: Option<String>,
    #[serde(default)]
    solutions: Vec<OrbitFile>,
    #[serde(default)]
    impacts: Vec<ImpactEntry>,
    psi: Option<f64>,
    period: Option<f64>,
}

#[derive(Deserialize)]
struct ImpactEntry {
    site: usize,
    #[serde(default)]
    layer: usize,
    barrier: String,
    time: f64,
    impulse: f64,
}

/// The place of a mass.
fn place(model: &Model, site: usize, layer: usize) -> Result<usize, String> {
    let layout = model.chain().layout();
    layout.index(site, layer).ok_or_else(|| format!("{layout} have no site {site}:{layer}"))
}

fn wrong(path: &Path, what: &str) -> CliError {
    CliError::Request(format!("{}: {what}", path.display()))
}

/// An impact of the table of a run.
fn hit(path: &Path, model: &Model, one: &Struck) -> Result<Hit, CliError> {
    let place = place(model, one.site, one.layer).map_err(|what| wrong(path, &what))?;
    Ok(Hit::new(place, one.barrier, one.time, one.impulse))
}

/// The orbit of a file, with its impacts at the same parts of the period, as one of `model`: roughly.
fn read(path: &Path, text: &str, model: &Model) -> Result<Orbit, CliError> {
    let wrong = |what: &str| {
        let form = r#"give {"impacts":[{"site":0,"barrier":"upper","time":0,"impulse":-1.5},…],"psi":0,"period":4.2}"#;
        wrong(path, &format!("{what}; {form}"))
    };
    let mut file: OrbitFile = serde_json::from_str(text).map_err(|error| wrong(&plain(&error.to_string())))?;
    expect(path, file.schema.as_deref(), ORBIT)?;
    if file.impacts.is_empty() && !file.solutions.is_empty() {
        file = file.solutions.swap_remove(0);
    }
    let latest = file.impacts.iter().map(|impact| impact.time).fold(0.0, f64::max);
    if file.period.is_none() && latest >= model.period() {
        return Err(wrong(&format!(
            "the key `period` is missing: an impact at t = {} is in no single period of omega = {}, 2π/omega = {}",
            Number(latest),
            Number(model.omega()),
            Number(model.period())
        )));
    }
    // Of another frequency: the same parts of the period.
    let periods = file.period.map_or(1.0, |period| (period / model.period()).round().max(1.0));
    let stretch = file.period.map_or(1.0, |period| periods * model.period() / period);
    let mut hits = Vec::new();
    for &ImpactEntry { site, layer, barrier: ref name, time, impulse } in &file.impacts {
        let barrier =
            Barrier::from_name(name).ok_or_else(|| wrong(&format!("`{name}` is no barrier, lower and upper are")))?;
        let place = place(model, site, layer).map_err(|why| wrong(&why))?;
        hits.push(Hit::new(place, barrier, time * stretch, impulse));
    }
    hits.sort_by(|one, other| one.time.total_cmp(&other.time));
    let psi = file.psi.unwrap_or(0.0) * stretch;
    Orbit::from_impulses(model, periods as u32, psi, &hits).map_err(|error| wrong(&error.to_string()))
}
