//! `studies errata`: what a user of the paper needs to correct, each with its evidence.
//!
//! | module | holds |
//! |---|---|
//! | `formulas` | printed formulas against what holds: both are evaluated |
//! | `matrices` | the printed monodromy matrix against differences of the simulated return map |
//! | `points` | bifurcation points, each with the command that finds it |
//! | `statements` | statements of the text, each with a command that shows otherwise |
//! | `evidence` | runs those commands and quotes them |

mod evidence;
mod formulas;
mod matrices;
mod points;
mod statements;

use crate::args::ErrataArgs;
use vibrochain_cli::common::console::Console;
use vibrochain_cli::common::error::CliError;
use vibrochain_maps::files::Output;
use vibrochain_maps::manifest::VERSION;

/// A printed formula, what holds, and the error of either where it can be evaluated.
struct Correction {
    place: &'static str,
    printed: &'static str,
    holds: &'static str,
    /// What the two numbers are.
    measure: &'static str,
    errors: (f64, f64),
}

fn computation(error: impl std::fmt::Display) -> CliError {
    CliError::Computation(error.to_string())
}

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &ErrataArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let file = args.out.as_deref().map(|path| Output::document("--out", path)).transpose()?;
    let mut text = format!("{}{VERSION}{}", PREFACE.0, PREFACE.1);
    for correction in formulas::corrections()?.into_iter().chain(matrices::corrections()?) {
        let Correction { place, printed, holds, measure, errors } = correction;
        text += &format!("| {place} | {printed} | {holds} | {measure} | {:.1e} | {:.0e} |\n", errors.0, errors.1);
    }
    text += LETTERS;
    text += points::HEADING;
    for point in points::POINTS {
        text += &point.markdown(console)?;
    }
    text += statements::HEADING;
    for statement in statements::STATEMENTS {
        text += &statement.markdown(console)?;
    }
    match file {
        Some(file) => Ok(file.finish_with(text.as_bytes())?),
        None => console.print(&text),
    }
}

const PREFACE: (&str, &str) = (
    "# Corrections to the paper

Printed by `studies errata`, mapgen ",
    ": every number below is computed by that command, and every quotation is what the command above it prints. The paper is
\"Localization in finite asymmetric vibro-impact chains\" by I. Grinberg and O. V. Gendelman; letters are its own. T = 2π/ω.
Formulas that are not listed hold as printed.

## Formulas

Both versions are evaluated on exact kernels at orbits that the program finds by other means. *printed* and *mended* are the
errors of both; a right formula leaves rounding, given to one digit, since it differs between machines. So do the last digits of quoted
answers.

| where | printed | holds | error of | printed | mended |
|---|---|---|---|---|---|
",
);

/// Slips that no number shows.
const LETTERS: &str = "
Slips of single letters: |x − a| = 1 in the on-site potential is |u − a| = 1; 1₀ in f₀^{−N−1} + 1₀ is 1; the condition
u̇₀(0) = 0 has the other sign in front of its sum (same zeros); in the equations of motion of the doubled orbit both impulses
are added, +2p₂Σδ.
";
