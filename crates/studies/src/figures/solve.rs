//! The physical orbits at a point, with their stability; names of points and columns about orbits that several figures
//! have in common.

use vibrochain_breather::{Family, Finder, Orbit, OrbitList};
use vibrochain_floquet::{Analyser, Stability, Tolerance};
use vibrochain_lattice::Model;

use vibrochain_cli::common::error::CliError;
use vibrochain_maps::caption::describe;

/// A physical orbit.
#[derive(Debug, Clone)]
pub(super) struct Solved {
    pub(super) orbit: Orbit,
    pub(super) margin: Option<f64>,
    pub(super) stability: Stability,
}

/// A failure of the mathematics, in this command's words.
pub(super) fn computation(error: impl std::fmt::Display) -> CliError {
    CliError::Computation(error.to_string())
}

/// All physical orbits of a family, in order of φ.
///
/// # Errors
/// [`CliError::Computation`], [`CliError::IllPosed`].
pub(super) fn physical(model: &Model, family: Family) -> Result<Vec<Solved>, CliError> {
    let mut finder = Finder::new(model.chain().sites());
    let (mut analyser, mut found) = (Analyser::default(), OrbitList::default());
    finder.find(model, family, &mut found)?;
    let mut solved = Vec::new();
    for orbit in std::mem::take(&mut found.orbits) {
        let admissibility = finder.admissibility(&orbit)?;
        if admissibility.is_physical() {
            let stability = analyser.stability(&orbit, &mut finder, Tolerance::Rounding)?;
            solved.push(Solved { orbit, margin: admissibility.margin, stability });
        }
    }
    Ok(solved)
}

/// The physical orbit of the smallest spectral radius.
///
/// # Errors
/// As [`physical`]; [`CliError::Computation`] also if there is none.
pub(super) fn leading(model: &Model, family: Family) -> Result<Solved, CliError> {
    let radius = |solved: &Solved| solved.stability.verdict.spectral_radius;
    physical(model, family)?
        .into_iter()
        .min_by(|a, b| radius(a).total_cmp(&radius(b)))
        .ok_or_else(|| computation(format!("no physical {} breather at {}", family.name(), describe(model))))
}

/// "stable", "unstable, plus-one", …
pub(super) fn verdict(solved: &Solved) -> String {
    let verdict = solved.stability.verdict;
    match verdict.mechanism {
        Some(mechanism) => format!("unstable, {}", mechanism.name()),
        None if verdict.undecided => "undecided".to_owned(),
        None => "stable".to_owned(),
    }
}

/// Names of the columns of [`row`].
pub(super) const COLUMNS: &str = "φ/T | ψ/T | impulses | margin | \\|μ\\| | verdict |";

/// The rule below them.
pub(super) const RULE: &str = "---|---|---|---|---|---|";

/// An orbit in a table of findings; times in periods of the orbit.
pub(super) fn row(solved: &Solved) -> String {
    let orbit = &solved.orbit;
    let part = |time: Option<f64>, period: f64| time.map_or(String::new(), |time| format!("{:.6}", time / period));
    let impulses: Vec<_> = orbit.impacts().iter().map(|impact| format!("{:.6}", impact.impulse)).collect();
    format!(
        "{} | {} | {} | {} | {:.6} | {} |",
        part(orbit.phi(), orbit.period()),
        part(orbit.psi(), orbit.force_period()),
        impulses.join(", "),
        solved.margin.map_or(String::new(), |margin| format!("{margin:.6}")),
        solved.stability.verdict.spectral_radius,
        verdict(solved)
    )
}
