//! `mapgen words`: words of two instants on a few sites, each of which hits as a family does, whose orbits live at a point.

use std::fmt::Write as _;

use serde::Serialize;
use serde_json::json;
use vibrochain_breather::{BreatherError, Family, Finder, NoBreather, Obstruction, OrbitList, Scope, Word};
use vibrochain_floquet::{Analyser, Mechanism, Tolerance, Verdict};
use vibrochain_lattice::{Layout, Model, Parameter, Stop};

use crate::args::{SiteFamily, WordsArgs};
use crate::common::answer::printed;
use crate::common::console::{Console, destinations};
use crate::common::error::CliError;
use crate::common::model::chosen;
use crate::common::schemas::WORDS;
use crate::sweep::report::counted;
use vibrochain_maps::files::CsvFile;

/// The most words that are looked at, before symmetry makes them fewer: some minutes of work.
const MOST: f64 = 1e5;

const HEADER: [&str; 8] =
    ["word", "solution", "physical", "margin", "stable", "mechanism", "spectral_radius", "obstruction"];

/// Steps in γ₂ of `--from-zero`, and halvings of the one in which an orbit stops being physical.
const STEPS: u32 = 200;
const HALVINGS: u32 = 44;

/// One orbit of a word, as tables and JSON have it.
#[derive(Serialize)]
struct Row {
    word: String,
    solution: usize,
    physical: bool,
    margin: Option<f64>,
    stable: Option<bool>,
    mechanism: Option<Mechanism>,
    spectral_radius: Option<f64>,
    obstruction: Option<String>,
    #[serde(skip)]
    verdict: Option<Verdict>,
}

impl Row {
    fn is_stable(&self) -> bool {
        self.verdict.as_ref().is_some_and(|verdict| verdict.stable)
    }
}

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`]; that no word has an orbit is an answer.
pub fn run(args: &WordsArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let chosen = chosen(&args.model, console)?;
    let model = chosen.model;
    let families = families(args, &model.chain().layout())?;
    let tolerance = chosen.tolerance(args.threshold)?;
    let taken =
        destinations(args.json, &[("--scene", args.model.scene.as_deref())], &[("--out", args.out.as_deref())])?;
    let stop = (console.interrupt)()?;
    let file = args.out.as_deref().map(|path| CsvFile::create("--out", path, HEADER)).transpose()?;
    let words = Word::enumerate(&model, args.sites_used, args.reach, &families)
        .map_err(|error| CliError::Request(error.to_string()))?;
    ensure!(
        !args.from_zero || model.is_conservative(),
        "--from-zero follows words without force and losses; under a force the search does, and `mapgen orbit --word` tells what ends each branch"
    );
    if args.from_zero {
        return console.answer(&fates(&model, &words, &stop)?, false, taken);
    }
    let (rows, unsearched) = rows(&model, &words, tolerance, &stop)?;
    let answer = if args.json {
        // How many words there are up to symmetry, how many orbits they have, and those that are listed.
        let listed: Vec<&Row> = rows.iter().filter(|row| args.all || row.physical).collect();
        printed(&json!({
            "schema": WORDS,
            "parameters": model,
            "words": words.len(),
            "orbits": rows.len(),
            "unsearched": unsearched,
            "solutions": listed,
        }))?
    } else {
        text(&words, &rows, &unsearched, args.all)
    };
    console.answer(&answer, args.json, taken)?;
    if let Some(mut file) = file {
        for row in rows.iter().filter(|row| args.all || row.physical) {
            file.record(row)?;
        }
        file.finish()?;
    }
    Ok(())
}

/// The families asked for, if there is room for their words on the lattice, and they are not too many.
fn families(args: &WordsArgs, layout: &Layout) -> Result<Vec<Family>, CliError> {
    let asked = |name| args.families.contains(&name) || args.families.contains(&SiteFamily::Either);
    let known = [(SiteFamily::DoubleSided, Family::DoubleSided), (SiteFamily::SingleSided, Family::SingleSided)];
    let families: Vec<_> = known.into_iter().filter_map(|(name, family)| asked(name).then_some(family)).collect();
    let last = layout.length.saturating_sub(1);
    let (sites, reach) = (args.sites_used, args.reach);
    ensure!(reach <= last, "--reach {reach} is out of range: sites of this chain are at most {last} apart");
    let most = (reach + 1) * layout.layers;
    let has_room = (1..=most).contains(&sites);
    ensure!(has_room, "--sites-used {sites} is out of range: --reach {reach} has room for 1 to {most}");
    let count = Word::combinations(layout, sites, reach, &families);
    ensure!(count <= MOST, "these are more than {MOST} words: give fewer sites, a smaller reach or one family");
    Ok(families)
}

/// The orbits of all words, each with what is known of it; and the words that cannot be searched for.
fn rows(model: &Model, words: &[Word], tolerance: Tolerance, stop: &Stop) -> Result<(Vec<Row>, Vec<String>), CliError> {
    let mut finder = Finder::new(model.chain().sites()).until(stop);
    let (mut analyser, mut found) = (Analyser::default(), OrbitList::default());
    let (mut rows, mut unsearched) = (Vec::new(), Vec::new());
    for word in words {
        finder.find_word(model, word, Scope::All, &mut found)?;
        if let Some(NoBreather::NotSearched(_)) = found.completeness.reason() {
            unsearched.push(word.to_string());
        }
        for (i, orbit) in found.orbits.iter().enumerate() {
            let admissibility = finder.admissibility(orbit)?;
            let verdict = match admissibility.obstruction {
                Some(_) => None,
                None => Some(analyser.verdict(orbit, &mut finder, tolerance)?),
            };
            let obstruction = admissibility.obstruction.map(|obstruction| obstruction.told(&model.chain().layout()));
            rows.push(Row {
                word: word.to_string(),
                solution: i + 1,
                physical: obstruction.is_none(),
                margin: admissibility.margin,
                stable: verdict.filter(|verdict| !verdict.undecided).map(|verdict| verdict.stable),
                mechanism: verdict.and_then(|verdict| verdict.mechanism),
                spectral_radius: verdict.map(|verdict| verdict.spectral_radius),
                obstruction,
                verdict,
            });
        }
    }
    Ok((rows, unsearched))
}

/// How far each word is physical, one a line.
fn fates(model: &Model, words: &[Word], stop: &Stop) -> Result<String, CliError> {
    let mut finder = Finder::new(model.chain().sites()).until(stop);
    let mut fates = Vec::new();
    for word in words {
        fates.push(format!("{word}  {}", fate(&mut finder, model, word)?));
    }
    Ok(format!("{}\n{} up to symmetry\n", fates.join("\n"), counted(words.len(), "word")))
}

/// How far a word is physical from masses without coupling on, all couplings in proportion, and what ends that; windows narrower
/// than a step may be missed.
fn fate(finder: &mut Finder, model: &Model, word: &Word) -> Result<String, CliError> {
    let [gamma2, gamma3] = [Parameter::Gamma2, Parameter::Gamma3].map(|coupling| model.get(coupling));
    // In the usual case γ₂ itself, otherwise a part of all couplings.
    let (target, part) = if gamma3 == 0.0 { (gamma2, 1.0) } else { (1.0, gamma2) };
    let said = |value: f64, digits: Option<usize>| {
        let number = |x: f64| digits.map_or_else(|| x.to_string(), |digits| format!("{x:.digits$}"));
        let of_layers = if gamma3 == 0.0 { String::new() } else { format!(", gamma3 = {}", number(value * gamma3)) };
        format!("gamma2 = {}{of_layers}", number(value * part))
    };
    let (mut found, layout) = (OrbitList::default(), model.chain().layout());
    // What is in the way of the word's first orbit, if anything.
    let mut obstacle = |value: f64| -> Result<Option<String>, CliError> {
        let model = model.with(Parameter::Gamma2, value * part)?;
        let model = if gamma3 == 0.0 { model } else { model.with(Parameter::Gamma3, value * gamma3)? };
        match finder.find_word(&model, word, Scope::All, &mut found) {
            Err(BreatherError::Resonance(resonance)) => return Ok(Some(resonance.to_string())),
            other => other?,
        }
        let Some(orbit) = found.orbits.first() else {
            return Ok(Some(found.completeness.reason().map_or_else(String::new, |reason| reason.to_string())));
        };
        Ok(finder.admissibility(orbit)?.obstruction.map(|obstruction| match obstruction {
            Obstruction::WrongSign { site, .. } => {
                format!("an impact of site {} loses its velocity", layout.name(site))
            }
            Obstruction::Sticking { site, .. } => format!("site {} begins to rest", layout.name(site)),
            Obstruction::Crossing { site, barrier, .. } => {
                format!("site {} touches the {barrier} barrier", layout.name(site))
            }
        }))
    };
    let mut last = 0.0;
    for step in 0..=STEPS {
        let value = target * f64::from(step) / f64::from(STEPS);
        let Some(mut why) = obstacle(value)? else {
            last = value;
            continue;
        };
        if step == 0 {
            return Ok(format!("not physical at {}: {why}", said(0.0, None)));
        }
        let (mut low, mut high) = (last, value);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match obstacle(middle)? {
                None => low = middle,
                Some(reason) => (high, why) = (middle, reason),
            }
        }
        return Ok(format!("physical up to {}: {why}", said(high, Some(12))));
    }
    Ok(format!("physical up to {}", said(target, None)))
}

fn text(words: &[Word], rows: &[Row], unsearched: &[String], all: bool) -> String {
    let mut out = String::new();
    let width = rows.iter().map(|row| row.word.len()).max().unwrap_or(0);
    for row in rows.iter().filter(|row| all || row.physical) {
        let state = match (&row.obstruction, &row.verdict) {
            (Some(obstruction), _) => format!("not physical: {obstruction}"),
            (None, Some(verdict)) => match verdict.mechanism {
                Some(mechanism) => {
                    format!("unstable ({}), spectral radius {}", mechanism.name(), verdict.spectral_radius)
                }
                None if verdict.undecided => "undecided".to_owned(),
                None => "stable".to_owned(),
            },
            (None, None) => "physical".to_owned(),
        };
        let margin = row.margin.map_or(String::new(), |margin| format!("margin {margin:.6}, "));
        let _ = writeln!(out, "{:width$}  {margin}{state}", row.word);
    }
    let physical = rows.iter().filter(|row| row.physical).count();
    let stable = rows.iter().filter(|row| row.physical && row.is_stable()).count();
    let _ = writeln!(
        out,
        "{} up to symmetry: {}, {physical} physical, {stable} stable",
        counted(words.len(), "word"),
        counted(rows.len(), "orbit")
    );
    if !unsearched.is_empty() {
        let _ = writeln!(
            out,
            "{} of them were not searched, `mapgen orbit --word` tells why: {}",
            unsearched.len(),
            unsearched.join("  ")
        );
    }
    out
}
