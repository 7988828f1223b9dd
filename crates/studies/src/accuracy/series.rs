//! The paper's Fourier series of the kernels χ₁, χ₂, χ₃, plain and with its tail summed in closed form.
//!
//! ```text
//! K₀(t)  =  (1/T) [g(0) + 2 Σ_{j≥1} g(jω) cos jωt] ,       K₀′(t) = −(2/T) Σ_{j≥1} jω g(jω) sin jωt
//! ```
//!
//! with the harmonic response g(w) = Σ_k b_k²/(Ω_k²−w²). Far above the band g(w) = −Σ_m s_m/w^{2m+2}, s_m = Σ_k b_k² Ω_k^{2m}:
//! the plain series stops with an error of order 1/J because s₀ = 1. Taken out of every term and put back as a whole,
//!
//! ```text
//! Σ cos jx/j^{2m}   = (−1)^{m+1} (2π)^{2m}/(2·(2m)!)     B_{2m}(x/2π)
//! Σ sin jx/j^{2m+1} = (−1)^{m+1} (2π)^{2m+1}/(2·(2m+1)!) B_{2m+1}(x/2π)
//! ```
//!
//! with Bernoulli's polynomials, the first n powers leave an error of order J^{−2n−1} (Kummer).

use std::f64::consts::TAU;

use vibrochain_lattice::{Chain, Spectrum, harmonic_response};

/// The most powers that can be taken out.
pub(super) const MOST_TAILS: usize = 4;

/// One of the paper's kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Chi {
    /// χ₁(φ) = −2K₀(φ)
    One,
    /// χ₂ = −2K₀(0)
    Two,
    /// χ₃(φ) = 2K₀′(φ)
    Three,
}

impl Chi {
    pub(super) const ALL: [Self; 3] = [Self::One, Self::Two, Self::Three];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::One => "χ₁",
            Self::Two => "χ₂",
            Self::Three => "χ₃",
        }
    }
}

/// Coefficients of the series of a chain: reusable for any φ.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Series {
    omega: f64,
    /// g(0), g(ω), … g(Jω), from the first on without their tails.
    harmonics: Vec<f64>,
    /// s_m/ω^{2m+2} of the powers taken out.
    tails: Vec<f64>,
}

impl Series {
    /// `terms` harmonics, with `tails` powers (up to [`MOST_TAILS`]) summed in closed form.
    pub(super) fn new(chain: &Chain, omega: f64, terms: u32, tails: usize) -> Self {
        let spectrum = Spectrum::new(*chain);
        let modes = || spectrum.frequencies().iter().zip(spectrum.weights());
        let moment = |m: usize| -> f64 {
            let power = m as i32;
            let sum: f64 = modes().map(|(frequency, weight)| weight * (frequency * frequency).powi(power)).sum();
            sum / omega.powi(2 * power + 2)
        };
        let tails: Vec<f64> = (0..tails.min(MOST_TAILS)).map(moment).collect();
        let harmonics = (0..=terms)
            .map(|j| {
                let response = harmonic_response(chain, f64::from(j) * omega, 0);
                if j == 0 || tails.is_empty() {
                    return response;
                }
                let inverse = 1.0 / (f64::from(j) * f64::from(j));
                response + inverse * tails.iter().rev().fold(0.0, |sum, tail| sum * inverse + tail)
            })
            .collect();
        Self { omega, harmonics, tails }
    }

    /// A kernel at 0 ≤ `phi` ≤ T.
    pub(super) fn chi(&self, chi: Chi, phi: f64) -> f64 {
        match chi {
            Chi::One => -2.0 * self.value(phi),
            Chi::Two => -2.0 * self.value(0.0),
            Chi::Three => 2.0 * self.slope(phi),
        }
    }

    fn value(&self, t: f64) -> f64 {
        let x = self.omega * t;
        let sum: f64 = self.harmonics.iter().enumerate().skip(1).map(|(j, g)| g * (j as f64 * x).cos()).sum();
        let tail: f64 = self.tails.iter().enumerate().map(|(m, tail)| tail * periodic(2 * m + 2, x)).sum();
        let mean = self.harmonics.first().copied().unwrap_or_default();
        (mean + 2.0 * (sum - tail)) * self.omega / TAU
    }

    fn slope(&self, t: f64) -> f64 {
        let x = self.omega * t;
        let term = |(j, g): (usize, &f64)| j as f64 * g * (j as f64 * x).sin();
        let sum: f64 = self.harmonics.iter().enumerate().skip(1).map(term).sum();
        let tail: f64 = self.tails.iter().enumerate().map(|(m, tail)| tail * periodic(2 * m + 1, x)).sum();
        -2.0 * (sum - tail) * self.omega * self.omega / TAU
    }
}

/// Σ_{j≥1} cos jx/j^n for even n, Σ sin jx/j^n for odd n, 0 ≤ x ≤ 2π, n = 1 … 8; for n = 1 the mean, 0, at the ends.
fn periodic(n: usize, x: f64) -> f64 {
    if n == 1 && (x <= 0.0 || x >= TAU) {
        return 0.0;
    }
    // B_n(y) from its falling powers, and n!.
    let (coefficients, factorial): (&[f64], f64) = match n {
        1 => (&[1.0, -0.5], 1.0),
        2 => (&[1.0, -1.0, 1.0 / 6.0], 2.0),
        3 => (&[1.0, -1.5, 0.5, 0.0], 6.0),
        4 => (&[1.0, -2.0, 1.0, 0.0, -1.0 / 30.0], 24.0),
        5 => (&[1.0, -2.5, 5.0 / 3.0, 0.0, -1.0 / 6.0, 0.0], 120.0),
        6 => (&[1.0, -3.0, 2.5, 0.0, -0.5, 0.0, 1.0 / 42.0], 720.0),
        7 => (&[1.0, -3.5, 3.5, 0.0, -7.0 / 6.0, 0.0, 1.0 / 6.0, 0.0], 5040.0),
        _ => (&[1.0, -4.0, 14.0 / 3.0, 0.0, -7.0 / 3.0, 0.0, 2.0 / 3.0, 0.0, -1.0 / 30.0], 40_320.0),
    };
    let y = x / TAU;
    let polynomial = coefficients.iter().fold(0.0, |sum, c| sum * y + c);
    let sign = if n % 4 < 2 { -1.0 } else { 1.0 };
    sign * TAU.powi(n as i32) / (2.0 * factorial) * polynomial
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibrochain_lattice::ImpulseResponse;

    #[test]
    fn bernoulli_sums_are_the_sums() {
        for n in 1..=8 {
            for x in [0.0, 0.7, 3.0, 5.9, TAU] {
                // The average of two partial sums: what is left is of second order in 1/j.
                let term = |j: u32| {
                    let (sin, cos) = (f64::from(j) * x).sin_cos();
                    (if n % 2 == 0 { cos } else { sin }) / f64::from(j).powi(n)
                };
                let last = 200_000;
                let sum: f64 = (1..last).map(term).sum::<f64>() + 0.5 * term(last);
                let slack = if n > 2 { 1e-9 } else { 2e-5 };
                assert!((periodic(n as usize, x) - sum).abs() < slack, "{n} {x}: {} {sum}", periodic(n as usize, x));
            }
        }
    }

    #[test]
    fn each_power_taken_out_raises_the_order_by_two() {
        let (chain, omega) = (Chain::new(21, 0.2, 0.1).unwrap(), 1.5);
        let response = ImpulseResponse::new(&Spectrum::new(chain), omega).unwrap();
        let phi = 0.31 * response.period();
        for chi in Chi::ALL {
            let exact = match chi {
                Chi::One => -2.0 * response.value(0, phi),
                Chi::Two => -2.0 * response.value(0, 0.0),
                Chi::Three => 2.0 * response.derivative(0, phi),
            };
            let error = |terms, tails| (Series::new(&chain, omega, terms, tails).chi(chi, phi) - exact).abs();
            // Between the impulses the series of K₀ converges like 1/J².
            let least = if chi == Chi::One { 1e-8 } else { 1e-5 };
            assert!(error(2000, 0) > least && error(2000, 0) < 1e-3, "{chi:?} {:e}", error(2000, 0));
            assert!(error(100, 1) < 1e-5 && error(1000, 1) < 1e-8, "{chi:?}");
            assert!(error(10, 2) < 1e-5 && error(100, 2) < 1e-9, "{chi:?}");
            assert!(error(20, 4) < 1e-12, "{chi:?} {:e}", error(20, 4));
        }
        // The paper's 2000 terms: 0.4/J in χ₂.
        let paper = Series::new(&chain, omega, 2000, 0).chi(Chi::Two, phi) + 2.0 * response.value(0, 0.0);
        assert!((paper.abs() * 2000.0 - 0.4).abs() < 0.05, "{paper}");
    }
}
