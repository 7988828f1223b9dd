//! What a physical orbit can radiate: a bound that rules orbits out before their motion is looked at.
//!
//! The impacts of an orbit drive the ring at the harmonics of its frequency. With
//!
//! ```text
//! P̂_j = |Σ_i P_i e^{ijωt_i}| ,      G_n(w) = Σ_k b_k² cos(2πkn/M) / (Ω_k² − w²)
//! ```
//!
//! the j-th Fourier coefficient of mass n has the modulus P̂_j |G_n(jω)|/T. A mass that stays inside its gap has |u_n − a| ≤ 1,
//! and such a function no coefficient beyond the mean of |cos|, 2/π, for j ≥ 1. So a physical orbit without force has
//!
//! ```text
//! P̂_j ≤ L_j = (2/π) T / |G_n(jω)|      for all n and j ≥ 1.
//! ```
//!
//! It says nothing where no harmonic meets the band, and much where one does: there every mass swings along.

use std::f64::consts::{FRAC_2_PI, PI};

use vibrochain_lattice::ImpulseResponse;

/// Harmonics looked at. The first ones that meet the band carry most; others would only cost time.
const HARMONICS: usize = 8;

/// What rounding can make of a sum of impulses that cancel, relative to their moduli, with a lot to spare.
const ROUNDING: f64 = 1e-12;

/// L_j for j = 1, 2, …, of which the first `count` are in reach of the band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Radiation {
    limits: [f64; HARMONICS],
    count: usize,
    omega: f64,
}

impl Radiation {
    /// The limits for orbits without force of one impact site of a ring; `None` where all modes are slower than the orbit, so that
    /// nothing is radiated.
    pub(crate) fn of(response: &ImpulseResponse) -> Option<Self> {
        // A wave in a ring stands, with a crest opposite to where it is driven.
        Self::heard(response, [0, response.sites() / 2].map(|site| response.shapes().evens(site, 0)))
    }

    /// The same of impacts of one mass, or of several that are alike, as masses hear them: of each what its modes have of the kernel, see
    /// [`ImpulseResponse::jet_of`].
    pub(crate) fn heard<const N: usize>(
        response: &ImpulseResponse,
        masses: [impl Iterator<Item = f64>; N],
    ) -> Option<Self> {
        let (omega, top) = (response.omega(), response.frequencies().last().copied().unwrap_or_default());
        if top < omega {
            return None;
        }
        let count = HARMONICS.min((top / omega).ceil() as usize);
        let harmonics = std::array::from_fn(|j| (j + 1) as f64 * omega);
        let swings: [[f64; HARMONICS]; N] = response.driven(masses, harmonics);
        let most = |j: usize| swings.iter().fold(0.0, |most: f64, swing| most.max(swing[j].abs()));
        let limits = std::array::from_fn(|j| FRAC_2_PI * response.period() / most(j));
        Some(Self { limits, count, omega })
    }

    /// Whether an orbit with impacts at these times, of these impulses, can be physical, as far as this bound goes.
    pub(crate) fn allows(&self, impacts: impl Iterator<Item = (f64, f64)> + Clone) -> bool {
        let total = impacts.clone().map(|(_, impulse)| impulse.abs()).sum();
        // e^{ijωt} of each impact, from j to j + 1 by one product.
        let mut sums = [[0.0; 2]; HARMONICS];
        for (time, impulse) in impacts {
            let (sin, cos) = (self.omega * time).sin_cos();
            let mut wave = [impulse, 0.0];
            for sum in &mut sums[..self.count] {
                wave = [wave[0] * cos - wave[1] * sin, wave[1] * cos + wave[0] * sin];
                (sum[0], sum[1]) = (sum[0] + wave[0], sum[1] + wave[1]);
            }
        }
        self.admits(total, sums.iter().map(|[re, im]| re * re + im * im))
    }

    /// The same for impulses at 0 and half a period later: P̂_j = |P₀ + (−1)ʲP₁|.
    pub(crate) fn allows_at_halves(&self, [first, second]: [f64; 2]) -> bool {
        let [odd, even] = [first - second, first + second].map(|sum| sum * sum);
        self.admits(first.abs() + second.abs(), [odd, even].into_iter().cycle())
    }

    /// Whether P̂_j², of impulses whose moduli add up to `total`, are within the limits.
    fn admits(&self, total: f64, squares: impl Iterator<Item = f64>) -> bool {
        let limits = self.limits.iter().take(self.count).map(|limit| limit + ROUNDING * total);
        squares.zip(limits).all(|(square, limit)| square <= limit * limit)
    }

    /// Whether a double-sided orbit whose φ lies between the turns `from` and `to` (parts of a period) can be physical, if the mean
    /// of its half impulses is at least `mean` and half their difference at least `difference`:
    /// P̂_j² = 16 (mean² sin² jωφ/2 + difference² cos² jωφ/2).
    pub(crate) fn allows_between(&self, from: f64, to: f64, mean: f64, difference: f64) -> bool {
        (1..).zip(&self.limits[..self.count]).all(|(j, limit): (u32, &f64)| {
            let [from, to] = [from, to].map(|turns| f64::from(j) * turns);
            let [(sin, cos), (sin_to, cos_to)] = [from, to].map(|turns| (PI * turns).sin_cos());
            // The sine vanishes at whole jφ/T, the cosine half-way, and each has one crest in between.
            let least = |shift: f64, one: f64, other: f64| {
                if (from + shift).floor() == (to + shift).floor() { one.abs().min(other.abs()) } else { 0.0 }
            };
            let [a, b] = [mean * least(0.0, sin, sin_to), difference * least(0.5, cos, cos_to)];
            16.0 * (a * a + b * b) * (1.0 - 2e-9) <= limit * limit
        })
    }
}

#[cfg(test)]
mod tests;
