//! Internal units and the table of Taylor orders.
//!
//! Time is scaled by a power of two (exactly, therefore) such that the fastest rate
//!
//! ```text
//! r = max(√(γ₁+4γ₂+4γ₃), jω, ω/4)      (ω/4 to keep windows near a period; j the highest harmonic of the force)
//! ```
//!
//! lies in [1, 2) (of other structures that of their modes). Every coefficient of every series then is of the size of the motion, for any γ and ω.

/// Highest order of a Taylor series.
pub(crate) const MAX_ORDER: usize = 24;

/// Orders in use. All even: a displacement and a velocity start one chain of coefficients each.
pub(crate) const ORDERS: [usize; 8] = [10, 12, 14, 16, 18, 20, 22, 24];

/// What a truncated series may miss, relative to the motion: an eighth of a unit in the last place.
pub(crate) const REMAINDER: f64 = f64::EPSILON / 8.0;

/// How fast derivatives grow: |d_{k+2}| ≤ r² max(|d_k|, |d_{k+1}|/r) + |F_k|, and |F_k| ≤ A r^k.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Growth {
    /// r
    pub(crate) rate: f64,
    /// A; half of it where only every other derivative counts.
    pub(crate) forced: f64,
}

/// 1/k!.
pub(crate) fn inverse_factorials() -> [f64; MAX_ORDER + 1] {
    let mut table = [1.0; MAX_ORDER + 1];
    let mut factorial = 1.0; // exact up to 22!, and right to the last digit beyond
    for (k, entry) in table.iter_mut().enumerate().skip(1) {
        factorial *= k as f64;
        *entry = 1.0 / factorial;
    }
    table
}

/// The next number of a reproducible sequence in −1 … 1 (Knuth's linear congruential generator).
pub(crate) fn spread(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
    f64::from((*seed >> 32) as i32) * 2f64.powi(-31)
}

/// How many neighbours on either side in a row can feel, within `time`, what happens to a mass now, through springs and dashpots between them.
///
/// A jump of velocity Δv displaces the m-th neighbour by at most about Δv γ₂^m τ^{2m+1}/(2m+1)!, and with `size`
/// for Δv this is compared with rounding. A dashpot passes on what a spring would take twice as many derivatives for: the divisor of the i-th
/// passage is then no less than i+1, of a spring (i+1)(i+2).
pub(crate) fn reach([spring, dashpot]: [f64; 2], time: f64, size: f64) -> usize {
    let (square, first) = (spring.abs() * time * time, dashpot.abs() * time);
    let mut term = size * time;
    let mut m = 0;
    while term > REMAINDER {
        m += 1;
        let k = m as f64;
        term *=
            if first == 0.0 { square / (2.0 * k * (2.0 * k + 1.0)) } else { (square / (k + 2.0) + first) / (k + 1.0) };
    }
    m
}

#[cfg(test)]
mod tests;
