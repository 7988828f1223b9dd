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
//! such a pair, real or not, is a double zero of E; with little loss its two zeros are closer than can be told apart. What E leaves unresolved is
//! sought among the orbits of the lattice as a structure (`as_structure`).

use std::f64::consts::FRAC_PI_2;

use smallvec::SmallVec;
use vibrochain_lattice::{ImpulseResponse, Model};

use crate::error::NoBreather;
use crate::orbit::Draft;
use crate::roots::interval::Zeros;
use crate::search::families::forced_single::amplitude_for;
use crate::search::families::one_mass::OneMass;
use crate::search::families::pattern::Pattern;
use crate::search::families::two_impacts::{
    SYMMETRIC, SYMMETRIC_GUARD, TwoImpactSolution, TwoImpacts, shortest_flight,
};

/// A chain whose mass moves by a cosine of this amplitude under the force alone.
#[derive(Clone, Copy)]
pub(crate) struct Forced<'a> {
    pub(crate) model: &'a Model,
    /// Of the orbit's period.
    pub(crate) response: &'a ImpulseResponse,
    pub(crate) force: f64,
    /// A list with open places is better than none.
    pub(crate) is_last: bool,
}

/// All double-sided solutions; with `places` those whose |δ| is in one of them. `None` where that leaves places open, unless it is the last way.
pub(crate) fn double_sided(
    forced: &Forced<'_>,
    zeros: &mut Zeros,
    places: Option<&[(f64, f64)]>,
    mut found: impl FnMut(Draft),
) -> Option<Result<(), NoBreather>> {
    let &Forced { model, response, force, is_last } = forced;
    let (omega, q, a) = (model.omega(), model.loss(), model.asymmetry());
    let problem = TwoImpacts::new(Pattern::DOUBLE_SIDED, model, response, force);
    let half = 0.5 * response.period();
    let edge = half - shortest_flight(response, omega * force.abs());
    let d = 2.0 * (response.dynamic_at_half() - response.dynamic_at_impulse());
    let symmetric = q * a * (response.static_stiffness() * d).abs() <= SYMMETRIC;
    let guard = if symmetric { SYMMETRIC_GUARD * half } else { 0.0 };
    let ranges = ranges(places.unwrap_or(&[(0.0, half)]), guard, edge);
    let least = if places.is_some() { 1 } else { LEAST };
    let alone = search(&problem, model, zeros, &ranges, least);
    if !is_last && is_doubtful(zeros, response) {
        return None;
    }
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
            return Some(Err(NoBreather::ForceTooWeak { threshold }));
        }
    }
    let solution = |&delta: &f64| solution(&problem, alone.as_ref(), delta);
    count += zeros.simple.iter().filter_map(solution).map(&mut emit).count();
    Some(outcome(count, zeros.unresolved.len() + zeros.exhausted))
}

/// So near a resonance, by [`ImpulseResponse::condition`], intervals that were not looked at are no matter of their number; and nearer than this
/// zeros as close as the square of the distance are lost in rounding.
const NEAR: f64 = 1e4;
const LOST: f64 = 1e8;

/// Whether the list may lack some that the lattice as a structure has.
fn is_doubtful(zeros: &Zeros, response: &ImpulseResponse) -> bool {
    let condition = response.condition();
    !zeros.unresolved.is_empty() || condition > NEAR && zeros.exhausted > 0 || condition > LOST
}

/// None at all is an answer only if no place was left open.
pub(crate) fn outcome(count: usize, open: usize) -> Result<(), NoBreather> {
    if count + open == 0 { Err(NoBreather::NoPhase) } else { Ok(()) }
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

/// All solutions with both impacts on one barrier; `None` where that leaves places open, unless it is the last way. Each is listed once, begun at the impact that [`listed`] says.
pub(crate) fn alike(
    pattern: Pattern,
    forced: &Forced<'_>,
    zeros: &mut Zeros,
    mut found: impl FnMut(Draft),
) -> Option<Result<(), NoBreather>> {
    let &Forced { model, response, force, is_last } = forced;
    if response.static_stiffness() == 0.0 {
        return Some(Err(NoBreather::NetImpulse));
    }
    let problem = TwoImpacts::new(pattern, model, response, force);
    let range = listed(pattern, model, 0.5 * response.period());
    let alone = search(&problem, model, zeros, &[range], LEAST);
    if !is_last && is_doubtful(zeros, response) {
        return None;
    }
    // Without loss δ = 0 solves by itself, for X = 0; Y = Ã and Y = −Ã are one orbit, begun at either impact.
    let middle = (pattern.turns_round() && model.loss() == 0.0).then(|| problem.with_phase(0.0, FRAC_PI_2)).flatten();
    let solution = |&delta: &f64| solution(&problem, alone.as_ref(), delta);
    let mut count = 0;
    for solution in zeros.simple.iter().filter_map(solution).chain(middle) {
        count += 1;
        found(draft(&problem, &solution));
    }
    Some(outcome(count, zeros.unresolved.len() + zeros.exhausted))
}

/// The δ of orbits with two impacts on one barrier, each of which solves twice, at δ and −δ: in one period of the force it begins with
/// the shorter flight, doubled with the longer one. Where δ = 0 solves by itself, with impacts alike that repeat after half the time or
/// without loss, it is left out.
fn listed(pattern: Pattern, model: &Model, half: f64) -> [f64; 2] {
    let (edge, guard) = (half * (1.0 - SYMMETRIC_GUARD), SYMMETRIC_GUARD * half);
    match pattern.turns_round() {
        true => [-edge, if model.loss() == 0.0 { -guard } else { 0.0 }],
        false => [guard, edge],
    }
}

/// The orbit of a solution.
fn draft(problem: &TwoImpacts<'_>, solution: &TwoImpactSolution) -> Draft {
    let phi = 0.5 * problem.response.period() + solution.delta;
    solution.draft(problem.response, problem.pattern, phase(solution.theta, phi, problem.omega))
}

/// An orbit of other equations with the impulses that these give for its times.
#[cold]
pub(crate) fn with_times_of(known: Draft, pattern: Pattern, forced: &Forced<'_>) -> Draft {
    let &Forced { model, response, force, .. } = forced;
    let problem = TwoImpacts::new(pattern, model, response, force);
    let phi = known.impacts.get(1).map_or(0.0, |hit| hit.time);
    let theta = problem.omega * (known.psi + 0.5 * phi);
    problem.with_phase(phi - 0.5 * response.period(), theta).map_or(known, |solution| draft(&problem, &solution))
}

/// ψ = θ/ω − φ/2, folded into one period of the force.
fn phase(theta: f64, phi: f64, omega: f64) -> f64 {
    (theta - 0.5 * omega * phi).rem_euclid(std::f64::consts::TAU) / omega
}
