//! The physical orbits at a point, with their stability; names of points and columns about orbits that several figures
//! have in common.

use vibrochain_breather::{Family, Finder, Found, Impact, Orbit};
use vibrochain_floquet::{Analyser, Stability, Tolerance};
use vibrochain_lattice::{Model, Spectrum, far_motion};

use crate::error::CliError;
use vibrochain_maps::force;

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
    let (mut analyser, mut found) = (Analyser::default(), Found::default());
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

/// "N = 20, γ₁ = 0.2, …": all that is fixed.
pub(crate) fn describe(model: &Model) -> String {
    in_common(&[model])
}

/// What several points of a figure have in common; what differs is told by its curves.
pub(super) fn in_common(models: &[&Model]) -> String {
    let parts = |model: &Model| {
        let chain = model.chain();
        let mut parts = vec![
            format!("N = {}", chain.sites() - 1),
            format!("γ₁ = {}", chain.gamma1()),
            format!("γ₂ = {}", chain.gamma2()),
            format!("ω = {}", model.omega()),
            format!("a = {}", model.asymmetry()),
        ];
        parts.extend(force::caption(model));
        parts
    };
    let all: Vec<Vec<String>> = models.iter().map(|model| parts(model)).collect();
    let common = |part: &&String| all.iter().all(|parts| parts.contains(part));
    all.first().into_iter().flatten().filter(common).cloned().collect::<Vec<_>>().join(", ")
}

/// Harmonics of a far field that are added at most; the nearest neighbours need the most of them.
const MAX_TERMS: u64 = 1_000_000;

/// By how much a mass `n` ≥ 1 sites from the one that takes all impacts differs from the uniform motion, in full relative accuracy:
/// by harmonics, of which every one falls from site to site by its own factor.
pub(crate) fn beside(orbit: &Orbit, spectrum: &Spectrum, n: usize, time: f64) -> f64 {
    let since = |impact: &Impact| (time - impact.time).rem_euclid(orbit.period());
    let impulses: Vec<_> = orbit.impacts().iter().map(|impact| (since(impact), impact.impulse)).collect();
    far_motion(spectrum, orbit.frequency(), n, &impulses, MAX_TERMS).0
}

/// "stable", "unstable, plus-one", …
pub(super) fn verdict(solved: &Solved) -> String {
    let verdict = solved.stability.verdict;
    match verdict.mechanism {
        Some(mechanism) => format!("unstable, {}", mechanism.name()),
        None if verdict.marginal => "marginal".to_owned(),
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
        part(orbit.psi(), orbit.model().period()),
        impulses.join(", "),
        solved.margin.map_or(String::new(), |margin| format!("{margin:.6}")),
        solved.stability.verdict.spectral_radius,
        verdict(solved)
    )
}
