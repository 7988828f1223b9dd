//! `mapgen words`: all impact words of a few sites whose orbits live at a point.

use std::fmt::Write as _;
use std::sync::atomic::Ordering;

use vibrochain_breather::{Family, Finder, Found, Wanted, Word};
use vibrochain_floquet::{Analyser, Tolerance, Verdict};

use crate::args::{SiteFamily, WordsArgs};
use crate::console::Console;
use crate::error::CliError;
use crate::orbit_command::model;
use vibrochain_maps::files::{CsvFile, distinct};
use vibrochain_maps::scene::tolerance_from;

/// The most words that are looked at, before symmetry makes them fewer: some minutes of work.
const MOST: f64 = 1e5;

const HEADER: [&str; 8] =
    ["word", "solution", "physical", "margin", "stable", "mechanism", "spectral_radius", "obstruction"];

/// One orbit of a word.
struct Row {
    word: String,
    solution: usize,
    margin: Option<f64>,
    verdict: Option<Verdict>,
    obstruction: Option<String>,
}

impl Row {
    fn is_physical(&self) -> bool {
        self.obstruction.is_none()
    }

    /// As a table has it.
    fn fields(&self) -> [String; 8] {
        let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let verdict = self.verdict.as_ref();
        let stable = verdict.filter(|verdict| !verdict.marginal).map_or(String::new(), |v| v.stable.to_string());
        let mechanism = verdict.and_then(|verdict| verdict.mechanism).map_or("", |mechanism| mechanism.name());
        [
            self.word.clone(),
            self.solution.to_string(),
            self.is_physical().to_string(),
            number(self.margin),
            stable,
            mechanism.to_owned(),
            number(verdict.map(|verdict| verdict.spectral_radius)),
            self.obstruction.clone().unwrap_or_default(),
        ]
    }

    fn is_stable(&self) -> bool {
        self.verdict.as_ref().is_some_and(|verdict| verdict.stable)
    }
}

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`]; that no word has an orbit is an answer.
pub fn run(args: &WordsArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let model = model(&args.model)?;
    let sites = model.chain().sites();
    let families: Vec<_> = (args.families.iter())
        .map(|name| match name {
            SiteFamily::DoubleSided => Family::DoubleSided,
            SiteFamily::SingleSided => Family::SingleSided,
        })
        .collect();
    let request = |message: String| Err(CliError::Request(message));
    if args.reach >= sites {
        return request(format!(
            "--reach {} is out of range: sites of this ring are at most {} apart",
            args.reach,
            sites - 1
        ));
    }
    if args.sites_used == 0 || args.sites_used > args.reach + 1 {
        let most = args.reach + 1;
        return request(format!(
            "--sites-used {} is out of range: --reach {} has room for 1 to {most}",
            args.sites_used, args.reach
        ));
    }
    if Word::combinations(args.sites_used, args.reach, &families) > MOST {
        return request(format!("these are more than {MOST} words: give fewer sites, a smaller reach or one family"));
    }
    let tolerance = match args.threshold {
        None => Tolerance::Rounding,
        Some(threshold) => tolerance_from(threshold).map_err(CliError::Request)?,
    };
    let taken = distinct(&[], &[("--csv", args.csv.as_deref())])?;
    let mut file = args.csv.as_deref().map(|path| CsvFile::create("--csv", path, HEADER)).transpose()?;
    let words = Word::enumerate(&model, args.sites_used, args.reach, &families)
        .map_err(|error| CliError::Request(error.to_string()))?;
    let stop = (console.interrupt)()?;
    let (mut finder, mut analyser, mut found) = (Finder::new(sites), Analyser::default(), Found::default());
    let mut rows = Vec::new();
    for word in &words {
        if stop.load(Ordering::Relaxed) {
            return Err(CliError::Interrupted);
        }
        finder.find_word(&model, word, Wanted::All, &mut found)?;
        for (i, orbit) in found.orbits.iter().enumerate() {
            let admissibility = finder.admissibility(orbit)?;
            let verdict = match admissibility.obstruction {
                Some(_) => None,
                None => Some(analyser.verdict(orbit, &mut finder, tolerance)?),
            };
            let obstruction = admissibility.obstruction.map(|obstruction| obstruction.to_string());
            rows.push(Row {
                word: word.to_string(),
                solution: i + 1,
                margin: admissibility.margin,
                verdict,
                obstruction,
            });
        }
    }
    console.answer(&text(&words, &rows, args.all), taken)?;
    if let Some(mut file) = file.take() {
        for row in rows.iter().filter(|row| args.all || row.is_physical()) {
            file.row(row.fields())?;
        }
        file.finish()?;
    }
    Ok(())
}

fn text(words: &[Word], rows: &[Row], all: bool) -> String {
    let mut out = String::new();
    let width = rows.iter().map(|row| row.word.len()).max().unwrap_or(0);
    for row in rows.iter().filter(|row| all || row.is_physical()) {
        let state = match (&row.obstruction, &row.verdict) {
            (Some(obstruction), _) => format!("not physical: {obstruction}"),
            (None, Some(verdict)) => match verdict.mechanism {
                Some(mechanism) => {
                    format!("unstable ({}), spectral radius {}", mechanism.name(), verdict.spectral_radius)
                }
                None if verdict.marginal => "marginal".to_owned(),
                None => "stable".to_owned(),
            },
            (None, None) => "physical".to_owned(),
        };
        let margin = row.margin.map_or(String::new(), |margin| format!("margin {margin:.6}, "));
        let _ = writeln!(out, "{:width$}  {margin}{state}", row.word);
    }
    let physical = rows.iter().filter(|row| row.is_physical()).count();
    let stable = rows.iter().filter(|row| row.is_physical() && row.is_stable()).count();
    let _ = writeln!(
        out,
        "{} words up to symmetry: {} orbits, {physical} physical, {stable} stable",
        words.len(),
        rows.len()
    );
    out
}
