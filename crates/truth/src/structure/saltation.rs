//! The monodromy matrix, impact by impact.
//!
//! With f the state's derivative, Z the impact's map and h = (w, 0), a perturbation is multiplied at an impact by the saltation matrix
//! S = Z + (f⁺ − Z f⁻) hᵀ/(hᵀf⁻): accelerations of loads and dashpots may jump with the velocity.

use super::shooting::{Round, Shooting};
use crate::error::TruthError;
use crate::linear::{Matrix, dot, product};
use crate::real::Real;

/// The product of all flights and saltations, of (q, q′/σ).
pub(super) fn monodromy(shooting: &Shooting, round: &Round) -> Result<Matrix, TruthError> {
    let (n, states) = (shooting.flow.coordinates(), 2 * shooting.flow.coordinates());
    let bits = shooting.flow.bits();
    let one = |i: usize, j: usize| if i == j { Real::one(bits) } else { Real::zero(bits) };
    let mut matrix: Matrix = (0..states).map(|i| (0..states).map(|j| one(i, j)).collect()).collect();
    for ((hit, before), flight) in shooting.hits.iter().zip(&round.before).zip(&round.flights) {
        let (arriving, leaving) = (shooting.flow.slope(before), shooting.flow.slope(&shooting.after(hit, before)));
        let speed = dot(&hit.weights, &arriving[..n]);
        // f⁺ − Zf⁻ over hᵀf⁻.
        let reset = shooting.after(hit, &arriving);
        let slip: Vec<Real> = leaving.iter().zip(&reset).map(|(f, zf)| (f - zf) / &speed).collect();
        if slip.iter().any(|entry| !entry.is_finite()) {
            return Err(TruthError::Singular { what: "an impact without speed: its saltation is not finite" });
        }
        let mut jumped: Matrix = (0..states).map(|_| Vec::with_capacity(states)).collect();
        for j in 0..states {
            let column: Vec<Real> = matrix.iter().map(|row| row[j].clone()).collect();
            let seen = dot(&hit.weights, &column[..n]);
            let after = shooting.after(hit, &column);
            for (row, (entry, slip)) in jumped.iter_mut().zip(after.iter().zip(&slip)) {
                row.push(entry + slip * &seen);
            }
        }
        let own: Matrix = flight[..states].iter().map(|row| row[..states].to_vec()).collect();
        matrix = product(&own, &jumped);
    }
    Ok(matrix)
}
