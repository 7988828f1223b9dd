//! How a single frequency w spreads along the ring: u_n ∝ λ^n with γ₂(λ + 1/λ) = γ₁ + 2γ₂ − w²
//! (the paper's f_j for w = jω, with the root chosen so that nothing cancels or overflows).
//!
//! The modal sum of [`crate::ImpulseResponse`] keeps absolute accuracy only; far from site 0, where the motion is
//! many orders smaller, [`far_field`] keeps full RELATIVE accuracy by summing harmonics, each with its own λ^n.

use crate::model::chain::Chain;
use crate::modes::spectrum::Spectrum;

/// Behaviour of a frequency along the infinite chain.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub enum Decay {
    /// Outside the band: the amplitude falls by λ from site to site, |λ| < 1 (λ < 0 above the band, where
    /// neighbours move against each other).
    Evanescent(f64),
    /// Inside the band: a wave of this wavenumber, 0 ≤ κ ≤ π.
    Propagating(f64),
}

/// The decay factor λ, or the wavenumber, of frequency `w` ≥ 0.
///
/// ```
/// use vibrochain_lattice::{Chain, Decay, decay};
/// let chain = Chain::new(21, 0.2, 0.1)?;
/// // Above the band and weakly coupled: λ ≈ γ₂/(γ₁ + 2γ₂ − w²).
/// assert!(matches!(decay(&chain, 3.0), Decay::Evanescent(l) if l < 0.0 && l > -0.012));
/// assert!(matches!(decay(&chain, 0.6), Decay::Propagating(_)));
/// # Ok::<(), vibrochain_lattice::ParameterError>(())
/// ```
pub fn decay(chain: &Chain, w: f64) -> Decay {
    let g2 = chain.gamma2();
    let (below, above) = band_distances(chain, w);
    if below > 0.0 || above < 0.0 {
        // λ = 2γ₂/(b ± √(b²−4γ₂²)), the sign that adds: smooth as γ₂ → 0.
        let root = (below * above).sqrt();
        let b = 0.5 * (below + above);
        Decay::Evanescent(2.0 * g2 / (b + root.copysign(b)))
    } else {
        // cos κ = b/(2γ₂), taken through the half angle so that the band's edges keep their digits.
        Decay::Propagating(2.0 * (-below).sqrt().atan2(above.sqrt()))
    }
}

/// γ₁ − w² and γ₁ + 4γ₂ − w², each with one rounding of the square.
fn band_distances(chain: &Chain, w: f64) -> (f64, f64) {
    let below = (-w).mul_add(w, chain.gamma1());
    (below, (-w).mul_add(w, chain.gamma1() + 4.0 * chain.gamma2()))
}

/// Amplitude of site `n` under the force cos(wt) on site 0 of the ring.
///
/// Infinite (or very large) where w meets a mode.
pub fn harmonic_response(chain: &Chain, w: f64, n: usize) -> f64 {
    let sites = chain.sites();
    let n = chain.distance(0, n);
    let (below, above) = band_distances(chain, w);
    if sites == 1 || chain.gamma2() == 0.0 {
        return if n == 0 { 1.0 / below } else { 0.0 };
    }
    match decay(chain, w) {
        Decay::Evanescent(factor) => {
            let root = (below * above).sqrt().copysign(below);
            // Powers of |λ| < 1 only: a large ring underflows to the infinite chain, it never overflows.
            (power(factor, n) + power(factor, sites - n)) / ((1.0 - power(factor, sites)) * root)
        }
        Decay::Propagating(k) => {
            let middle = 0.5 * sites as f64;
            -(k * (n as f64 - middle)).cos() / (2.0 * chain.gamma2() * k.sin() * (k * middle).sin())
        }
    }
}

pub(crate) fn power(factor: f64, n: usize) -> f64 {
    // A count beyond i32 would underflow or be 1 all the same.
    factor.powi(i32::try_from(n).unwrap_or(i32::MAX))
}

/// K_n(t) at a site n ≥ 1 by harmonics, (1/T) Σ_j g_n(jω) cos jωt, in full relative accuracy: beyond the band the
/// terms fall like (γ₂/j²ω²)^n, so a few suffice where the field is small. Harmonics are added until the rest is
/// below rounding, at most `max_terms`; the second value is the number used.
///
/// For γ₁ = 0 the mean (j = 0) is left out, as in [`crate::ImpulseResponse::value`].
pub fn far_field(spectrum: &Spectrum, omega: f64, site: usize, t: f64, max_terms: u64) -> (f64, u64) {
    far_motion(spectrum, omega, site, &[(t, 1.0)], max_terms)
}

/// Σ P K_n(t) over impulses (t, P) at site 0, t the time since each, as [`far_field`]: harmonic by harmonic, for one that the
/// impulses do not excite together may be by far the largest of each alone.
pub fn far_motion(spectrum: &Spectrum, omega: f64, site: usize, impulses: &[(f64, f64)], max_terms: u64) -> (f64, u64) {
    let chain = spectrum.chain();
    let (_, top) = spectrum.band();
    let part = |w: f64| impulses.iter().map(|(t, impulse)| impulse * (w * t).cos()).sum::<f64>();
    let size: f64 = impulses.iter().map(|(_, impulse)| impulse.abs()).sum();
    let mean = if chain.gamma1() > 0.0 { part(0.0) * harmonic_response(chain, 0.0, site) } else { 0.0 };
    let (mut sum, mut j) = (0.0, 1);
    while j < max_terms {
        let w = j as f64 * omega;
        let response = harmonic_response(chain, w, site);
        sum += 2.0 * response * part(w);
        // Above the band |g_n| falls at least like w^(−2n−2), n ≥ 1: the tail is below j·|g_n| of this term.
        if w > 2.0 * top && j as f64 * response.abs() * size <= f64::EPSILON * (sum + mean).abs() {
            break;
        }
        j += 1;
    }
    ((sum + mean) * omega / std::f64::consts::TAU, j)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::impulse::ImpulseResponse;

    #[test]
    fn response_solves_the_ring() {
        for (sites, w) in [(1, 0.9), (2, 0.9), (2, 0.5), (3, 0.1), (5, 0.6), (8, 0.7), (21, 3.0), (21, 0.0)] {
            let chain = Chain::new(sites, 0.2, 0.1).unwrap();
            let g = |n: usize| harmonic_response(&chain, w, n % sites);
            for n in 0..sites {
                let left = (0.2 - w * w) * g(n) + 0.1 * (2.0 * g(n) - g(n + 1) - g(n + sites - 1));
                let right = f64::from(u8::from(n == 0));
                assert!((left - right).abs() < 1e-13, "{sites} {w} {n}: {left}");
            }
        }
    }

    #[test]
    fn far_field_meets_the_modal_form_and_goes_on_below_it() {
        let spectrum = Spectrum::new(Chain::new(41, 0.2, 0.1).unwrap());
        let response = ImpulseResponse::new(&spectrum, 1.5).unwrap();
        for n in [2, 4, 7] {
            let (value, terms) = far_field(&spectrum, 1.5, n, 1.1, 100_000);
            assert!((value - response.value(n, 1.1)).abs() < 2e-15, "{n}");
            assert!(n < 4 || terms < 2000);
        }
        // Where the static part is absent (γ₁ large against γ₂) the field falls below anything a sum could hold.
        let weak = Spectrum::new(Chain::new(41, 0.2, 1e-12).unwrap());
        let (value, _) = far_field(&weak, 1.5, 20, 1.1, 1000);
        assert!(value != 0.0 && value.abs() < 1e-200);
    }

    #[test]
    fn what_impulses_do_not_excite_together_leaves_no_rounding_behind() {
        // Equal and opposite, half a period apart: odd harmonics alone, of which the first decays by far the slowest.
        let (chain, omega) = (Chain::new(101, 0.2, 0.1).unwrap(), 1.5);
        let spectrum = Spectrum::new(chain);
        let half = std::f64::consts::PI / omega;
        for n in [5, 20, 50] {
            let (value, _) = far_motion(&spectrum, omega, n, &[(0.0, 1.0), (half, -1.0)], 100_000);
            let first = 2.0 * omega / std::f64::consts::PI * harmonic_response(&chain, omega, n);
            let third = 2.0 * omega / std::f64::consts::PI * harmonic_response(&chain, 3.0 * omega, n);
            assert!((value / (first + third) - 1.0).abs() < 1e-3, "{n}: {value:e} {first:e}");
            // Static displacements of either impulse alone are larger by many orders.
            let (alone, _) = far_field(&spectrum, omega, n, 0.0, 100_000);
            assert!(n < 20 || alone.abs() > 1e12 * value.abs(), "{n}: {alone:e}");
        }
    }

    #[test]
    fn decay_is_smooth_towards_zero_coupling_and_exact_at_the_edges() {
        let Decay::Evanescent(l) = decay(&Chain::new(9, 0.2, 1e-300).unwrap(), 1.5) else { panic!("not evanescent") };
        assert!((l / (1e-300 / (0.2 - 2.25)) - 1.0).abs() < 1e-14);
        let chain = Chain::new(9, 0.25, 0.1).unwrap();
        assert_eq!(decay(&chain, 0.5), Decay::Propagating(0.0));
    }
}
