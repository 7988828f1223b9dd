//! Forced breathers of two impacts of one mass, double-sided or both on one barrier: all of them, from the zeros of E(δ) (see
//! `two_impacts`).
//!
//! Eliminating the phase has a price without loss (q = 0). Time reversal then maps solutions to solutions of the same φ,
//! (d, Y) → (−d, −Y) with both impacts on one barrier and, at a = 0, (d, X) → (−d, −X) for a double-sided one, and with
//!
//! ```text
//! F = χ₃ sin h − ωD cos h,   H = ωΣ sin h − χ₃ cos h,   Δ = FH
//! both on one barrier    E = F² (β²χ₃² − Ã²H²)
//! double-sided, a = 0    E = H² (χ₃² − Ã²F²)
//! ```
//!
//! such a pair, real or not, is a double zero of E; with little loss its two zeros are closer than can be told apart. In the
//! plane of φ and ψ they are apart, so that whatever E leaves unresolved is searched for there (`forced_harmonics`).
//! There, a double zero is a fold.

use std::f64::consts::FRAC_PI_2;

use smallvec::SmallVec;
use vibrochain_lattice::Model;

use crate::error::NoBreather;
use crate::orbit::Draft;
use crate::roots::interval::Zeros;
use crate::search::families::forced_harmonics::{self, Forced, Searches, outcome};
use crate::search::families::forced_single::amplitude_for;
use crate::search::families::one_mass::OneMass;
use crate::search::families::pattern::Pattern;
use crate::search::families::two_impacts::{
    SYMMETRIC, SYMMETRIC_GUARD, TwoImpactSolution, TwoImpacts, shortest_flight,
};

/// All double-sided solutions under a cosine whose motion reaches `force`; with `places` those whose |δ| is in one of them.
pub(crate) fn double_sided(
    forced: &Forced<'_>,
    force: f64,
    searches: &mut Searches<'_>,
    places: Option<&[(f64, f64)]>,
    mut found: impl FnMut(Draft),
) -> Result<(), NoBreather> {
    let &Forced { model, response, .. } = forced;
    let (omega, q, a) = (model.omega(), model.loss(), model.asymmetry());
    let problem = TwoImpacts::new(Pattern::DOUBLE_SIDED, model, response, force);
    let half = 0.5 * response.period();
    let edge = half - shortest_flight(response, omega * force.abs());
    let d = 2.0 * (response.dynamic_at_half() - response.dynamic_at_impulse());
    let symmetric = q * a * (response.static_stiffness() * d).abs() <= SYMMETRIC;
    let guard = if symmetric { SYMMETRIC_GUARD * half } else { 0.0 };
    let ranges = ranges(places.unwrap_or(&[(0.0, half)]), guard, edge);
    let alone = search(&problem, model, searches.zeros, &ranges, if places.is_some() { 1 } else { LEAST });
    if !searches.zeros.unresolved.is_empty() {
        let in_plane = |searches: &mut Searches<'_>, drafts: &mut Vec<Draft>| {
            forced_harmonics::double_sided(forced, searches, |draft| drafts.push(draft))
        };
        if let Some(outcome) = by_plane(searches, alone.is_some(), in_plane, &mut found) {
            return outcome;
        }
    }
    let zeros = &*searches.zeros;
    let mut emit = |solution: TwoImpactSolution| found(draft(&problem, &solution));
    let mut count = 0;
    if symmetric {
        // At δ = 0 one condition vanishes; the other, ωD X + q Y = q, is a line that meets the circle.
        count += symmetric_phases(omega * d, q, force)
            .into_iter()
            .flatten()
            .filter_map(|theta| problem.with_phase(0.0, theta))
            .map(&mut emit)
            .count();
        if count + zeros.simple.len() + zeros.exhausted == 0 {
            let distance = q / q.hypot(omega * d);
            let threshold = amplitude_for(model, force, distance);
            return Err(NoBreather::ForceTooWeak { threshold });
        }
    }
    let solution = |&delta: &f64| solution(&problem, alone.as_ref(), delta);
    count += zeros.simple.iter().filter_map(solution).map(&mut emit).count();
    outcome(count, zeros.exhausted)
}

/// Intervals that a search of the whole period begins with at least.
const LEAST: usize = 8;

/// Places of δ ≥ 0 and their mirror images, rising, as far as they are between `guard` and `edge`.
fn ranges(places: &[(f64, f64)], guard: f64, edge: f64) -> SmallVec<[[f64; 2]; 8]> {
    let mut after: SmallVec<[[f64; 2]; 8]> =
        places.iter().map(|&(from, to)| [from.max(guard), to.min(edge)]).filter(|[from, to]| from < to).collect();
    let middle = if after.first().is_some_and(|[from, _]| *from == 0.0) { Some(after.remove(0)[1]) } else { None };
    let before = after.iter().rev().map(|[from, to]| [-to, -from]);
    before.chain(middle.map(|to| [-to, to])).chain(after.iter().copied()).collect()
}

/// Finds the zeros of E on all ranges. What it leaves open of a mass without coupling is asked once more of the flights' equations, which
/// know of no resonance; they are returned if the zeros are theirs.
fn search(
    problem: &TwoImpacts<'_>,
    model: &Model,
    zeros: &mut Zeros,
    ranges: &[[f64; 2]],
    least: usize,
) -> Option<OneMass> {
    ranges.iter().for_each(|[from, to]| problem.zeros(zeros, *from, *to, least));
    if zeros.unresolved.len() + zeros.exhausted == 0 {
        return None;
    }
    let alone = OneMass::new(problem.pattern, model)?;
    zeros.forget();
    ranges.iter().for_each(|[from, to]| alone.zeros(zeros, *from, *to));
    Some(alone)
}

/// What a search `in_plane` finds, which separates the zeros that E leaves unresolved. None where the zeros in δ stand instead, those of the
/// flights' equations (`alone`): next to a resonance the plane, whose kernels are large and cancel, is lost in rounding, and these with
/// their few unresolved places know better.
fn by_plane(
    searches: &mut Searches<'_>,
    alone: bool,
    in_plane: impl FnOnce(&mut Searches<'_>, &mut Vec<Draft>) -> Result<(), NoBreather>,
    found: impl FnMut(Draft),
) -> Option<Result<(), NoBreather>> {
    let kept = alone.then(|| searches.zeros.clone());
    searches.zeros.forget();
    let mut drafts = Vec::new();
    let outcome = in_plane(searches, &mut drafts);
    if let Some(kept) = kept.filter(|kept| kept.exhausted == 0 && searches.plane.exhausted > 0) {
        *searches.zeros = kept;
        searches.plane.clear();
        return None;
    }
    drafts.into_iter().for_each(found);
    Some(outcome)
}

/// Impulses and phase at a zero that [`search`] has found.
fn solution(problem: &TwoImpacts<'_>, alone: Option<&OneMass>, delta: f64) -> Option<TwoImpactSolution> {
    match alone {
        Some(alone) => problem.with_phase(delta, alone.phase(delta)),
        None => problem.solution(delta),
    }
}

/// θ of the solutions with φ = T/2, where they exist: ωDX + qY = q on the circle X² + Y² = Ã².
fn symmetric_phases(normal_x: f64, q: f64, force: f64) -> [Option<f64>; 2] {
    let normal_y = q;
    let length = normal_x.hypot(normal_y);
    let cosine = q / (length * force);
    if cosine.is_nan() || cosine.abs() > 1.0 {
        return [None, None];
    }
    let (direction, opening) = (normal_y.atan2(normal_x), cosine.acos());
    [Some(direction + opening), (opening > 0.0).then_some(direction - opening)]
}

/// All solutions with both impacts on one barrier. Each is listed once, begun at the impact that
/// [`forced_harmonics::listed`] says.
pub(crate) fn alike(
    pattern: Pattern,
    forced: &Forced<'_>,
    force: f64,
    searches: &mut Searches<'_>,
    mut found: impl FnMut(Draft),
) -> Result<(), NoBreather> {
    forced.static_stiffness()?;
    let &Forced { model, response, .. } = forced;
    let problem = TwoImpacts::new(pattern, model, response, force);
    let range = forced_harmonics::listed(pattern, model, 0.5 * response.period());
    let alone = search(&problem, model, searches.zeros, &[range], LEAST);
    if !searches.zeros.unresolved.is_empty() {
        let in_plane = |searches: &mut Searches<'_>, drafts: &mut Vec<Draft>| {
            forced_harmonics::alike(pattern, forced, searches, |draft| drafts.push(draft))
        };
        if let Some(outcome) = by_plane(searches, alone.is_some(), in_plane, &mut found) {
            return outcome;
        }
    }
    let zeros = &*searches.zeros;
    // Without loss δ = 0 solves by itself, for X = 0; Y = Ã and Y = −Ã are one orbit, begun at either impact.
    let middle = (pattern.turns_round() && model.loss() == 0.0).then(|| problem.with_phase(0.0, FRAC_PI_2)).flatten();
    let solution = |&delta: &f64| solution(&problem, alone.as_ref(), delta);
    let mut count = 0;
    for solution in zeros.simple.iter().filter_map(solution).chain(middle) {
        count += 1;
        found(draft(&problem, &solution));
    }
    outcome(count, zeros.exhausted)
}

/// The orbit of a solution.
fn draft(problem: &TwoImpacts<'_>, solution: &TwoImpactSolution) -> Draft {
    let phi = 0.5 * problem.response.period() + solution.delta;
    solution.draft(problem.response, problem.pattern, phase(solution.theta, phi, problem.omega))
}

/// ψ = θ/ω − φ/2, folded into one period of the force.
fn phase(theta: f64, phi: f64, omega: f64) -> f64 {
    (theta - 0.5 * omega * phi).rem_euclid(std::f64::consts::TAU) / omega
}
