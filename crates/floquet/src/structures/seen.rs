//! What is seen at a point of a branch, and what that tells of the step to the next one.

use nalgebra::Complex;
use vibrochain_breather::{Approach, StructureBranchPoint, StructureOrbit, structure_admissibility};

use super::stability::structure_stability;
use crate::analyser::Stability;
use crate::events::{EventOrbit, Test, another_one, minus_one};
use crate::locate::DiagramPoint;
use crate::verdict::Tolerance;

type C = Complex<f64>;

/// A multiplier farther from the circle than this is off it: without losses rounding moves double ones by less, and with them growth as slow as
/// this is none.
const OFF_LOSSLESS: f64 = 1e-6;
const OFF: f64 = 1e-10;

/// Pairs of multipliers that may be the one that meets the circle.
const MOST_GUESSES: usize = 6;

/// What is seen at a point.
pub(super) struct Seen {
    pub(super) margin: Option<f64>,
    pub(super) closest: Option<Approach>,
    pub(super) physical: Option<bool>,
    pub(super) stability: Option<Stability>,
    /// Of each impact towards its barrier.
    pub(super) velocities: Vec<f64>,
    pub(super) minus_one: f64,
    pub(super) another_one: Option<f64>,
    /// Multipliers off the circle, or of those off it without losses that are not real.
    pub(super) outside: Option<usize>,
}

/// A point with what is seen there.
pub(super) type At<'a> = (&'a StructureBranchPoint, &'a Seen);

impl Seen {
    /// All of it.
    pub(super) fn at(point: &StructureBranchPoint, tolerance: Tolerance) -> Self {
        let orbit = point.orbit();
        let admissibility = structure_admissibility(orbit).ok();
        let stability = structure_stability(orbit, tolerance).ok();
        let lossless = orbit.is_lossless();
        let off = |mu: &&C| {
            let beyond = mu.norm() - 1.0;
            if lossless { beyond.abs() > OFF_LOSSLESS && mu.im.abs() > OFF_LOSSLESS } else { beyond > OFF }
        };
        let outside = stability.as_ref().map(|stability| stability.multipliers.iter().filter(off).count());
        let velocities = orbit.impacts().iter().map(|impact| impact.barrier.sign() * impact.velocity_before).collect();
        Self {
            margin: admissibility.as_ref().and_then(|told| told.margin),
            closest: admissibility.as_ref().and_then(|told| told.closest),
            physical: admissibility.map(|told| told.is_physical()),
            stability,
            velocities,
            minus_one: minus_one(orbit).unwrap_or(f64::NAN),
            another_one: another_one(orbit),
            outside,
        }
    }
}

/// The value of a test function at a point, where it is one number that changes its sign.
pub(super) fn value(test: Test, (point, seen): At<'_>) -> Option<f64> {
    match test {
        Test::Fold => Some(point.fold_determinant()),
        Test::One => Some(point.determinant()),
        Test::AnotherOne => seen.another_one,
        Test::MinusOne => Some(seen.minus_one),
        Test::Velocity(i) => seen.velocities.get(i).copied(),
        Test::Touch(..) => seen.margin,
        Test::Circle | Test::Collision => None,
    }
}

/// Whether a test function tells of an event between two points.
pub(super) fn changes(test: Test, from: At<'_>, to: At<'_>) -> bool {
    match (value(test, from), value(test, to)) {
        (Some(a), Some(b)) => (a > 0.0) != (b > 0.0),
        _ if matches!(test, Test::Circle | Test::Collision) => from.1.outside != to.1.outside,
        _ => false,
    }
}

/// What touches where the least distance changes its sign.
pub(super) fn touch_between(from: At<'_>, to: At<'_>) -> Option<Test> {
    let (before, after) = (from.1.margin?, to.1.margin?);
    let beyond = if before <= 0.0 { from.1 } else { to.1 };
    let touch = beyond.closest.filter(|_| (before > 0.0) != (after > 0.0))?;
    Some(Test::Touch(touch.site, touch.barrier))
}

/// Where in a step an event may be, and its mark, the likeliest first.
pub(super) fn guesses(test: Test, from: At<'_>, to: At<'_>, by_sign: f64) -> Vec<(f64, Option<f64>)> {
    match test {
        Test::Touch(site, barrier) => {
            let of = |at: At<'_>| {
                let closest = at.1.closest.filter(|one| (one.site, one.barrier) == (site, barrier))?;
                Some((by_sign, Some(closest.time / at.0.orbit().period())))
            };
            [of(from), of(to)].into_iter().flatten().collect()
        }
        Test::Circle | Test::Collision => {
            let upper = |at: At<'_>| -> Vec<C> {
                let all = at.1.stability.iter().flat_map(|stability| stability.multipliers.iter());
                all.filter(|mu| mu.im > 0.0).copied().collect()
            };
            // Each with its neighbour at the other end, those that cross first.
            let (before, after) = (upper(from), upper(to));
            let growth = |mu: &C| mu.norm().ln();
            let mut pairs: Vec<(f64, f64, f64)> = Vec::new();
            for one in &before {
                let near = |a: &&C, b: &&C| (*a - one).norm().total_cmp(&(*b - one).norm());
                let Some(other) = after.iter().min_by(near) else { continue };
                let (a, b) = (growth(one), growth(other));
                // Those of modes that no contact of the orbit feels never leave the circle.
                if a.abs().max(b.abs()) <= OFF {
                    continue;
                }
                let crosses = (a > 0.0) != (b > 0.0);
                let share = if crosses { a / (a - b) } else { 0.5 };
                let rank = if crosses { 0.0 } else { a.abs().min(b.abs()) };
                pairs.push((rank, share, one.arg() + share * (other.arg() - one.arg())));
            }
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
            pairs.into_iter().take(MOST_GUESSES).map(|(_, share, angle)| (share, Some(angle))).collect()
        }
        _ => vec![(by_sign, None)],
    }
}

/// A point as a diagram has it.
pub(super) fn described(point: &StructureBranchPoint, seen: &Seen) -> DiagramPoint<StructureOrbit> {
    DiagramPoint {
        value: point.value(),
        orbit: point.orbit().clone(),
        margin: seen.margin,
        physical: seen.physical,
        verdict: seen.stability.as_ref().map(|stability| stability.verdict),
    }
}
