//! Orbits of two sites that hit in turns: what one does the other does half a period later, `0+3-,0-3+` and `0-,3-`.
//!
//! Half a period's flight L, its impacts S before it, and the reflection R that exchanges the sites leave the orbit as it is: N = RLS,
//! M = N². R is 1 on modes even about the middle between the two sites, weights b²(1+C), and −1 on odd ones, weights b²(1−C); below
//! η = ±1, and C as in [`super::foreign`].
//!
//! One impact in half a period: N is the monodromy matrix of one site that is hit, with weights ½b²(1+ηC) and phases φ = ΩT/2, for odd modes
//! ΩT/2 + π, in place of ΩT. All of [`super::single_sided`] holds.
//!
//! Two, impulses P₀ and P₁: with S̄ the mean of both saltations N is (L₊S̄ L₊D; −L₋D −L₋S̄) in sums and differences of the sites, what
//! [`super::double_sided`] has with L₊ = L₋ in those of both halves of the period. So in ρ = ½(w + 1/w), w the multipliers of N,
//!
//! ```text
//! f(ρ) = f₊(ρ)f₋(−ρ) − δ² g̃₊(ρ)g̃₋(−ρ),     F = f/(ρ−1),
//! K = p + χq,   Λ = (p + Xq)(p + q/X),      p = Σb²(c+C)/x,   q = Σb²(1+Cc)/x:     f(1) = 0,
//! ```
//!
//! with poles ηc, whose residues are those of [`super::double_sided`] with the other parity's modes in the sums at −c, times η(1+ηc)/2c.

use vibrochain_breather::lanes::Lane;

use super::double_sided::{Saltations, residue, sums};
use super::modes::{Mode, Modes};
use super::pole::Pole;

impl Mode {
    /// With the phase ΩT/2, turned by π for an odd mode, in place of ΩT.
    fn turned(&self, eta: f64, period: f64) -> Self {
        let (cosine, sine) = (eta * self.cos, eta * self.sin);
        // Of both halves the larger one is a root, the other one follows from sin φ.
        let large = (0.5 * (1.0 + cosine.abs())).sqrt();
        let small = 0.5 * sine / large;
        let (cos, sin) = if cosine > 0.0 { (large, small) } else { (small.abs(), large.copysign(sine)) };
        // A rigid mode has no frequency to divide by.
        let sin_over = if cosine > 0.0 && eta > 0.0 { 0.5 * self.sin_over / large } else { sin / self.frequency };
        let phase = 0.5 * self.frequency * period;
        let relative = 4.0 + if phase > 1e-3 { (phase * cos / sin).abs() } else { 1.0 };
        let shift = 2.0 * (phase * cos * sin).abs() + 4.0 * (cos * cos).min(sin * sin);
        let (inverse, sin_times) = (1.0 / sin_over, self.frequency * sin);
        Self { cos, sin, sin_over, inverse, sin_times, relative, shift, ..*self }
    }
}

/// The modes of N for one impact in half a period; `squares` and `signed` are 1 and the C on a ring.
pub(super) fn modes(all: &Modes, [squares, signed]: [&[f64]; 2], period: f64, turned: &mut Modes) {
    let parity = |k: usize| [1.0, -1.0].map(|eta| (eta, 0.5 * (squares[k] + eta * signed[k])));
    let halves = all.list().iter().enumerate().flat_map(|(k, mode)| parity(k).map(|(eta, part)| (k, mode, eta, part)));
    turned.collect(halves.filter(|(.., part)| !Modes::is_spared(*part)).map(|(k, mode, eta, part)| {
        let mode = mode.turned(eta, period);
        (k, Mode { weight: part * mode.weight, ..mode })
    }));
}

/// Residues of F in ρ for two impacts in half a period, and Σ R ρ_k as the trace wants it; `parities` are all modes, even and odd.
pub(super) fn double_sided(
    parities: [&Modes; 2],
    saltations: &Saltations,
    period: f64,
    masked: &mut Vec<Lane>,
    poles: &mut Vec<Pole>,
) -> f64 {
    poles.clear();
    let [even, odd] = parities;
    let mut trace = 1.0;
    for (eta, modes, others) in [(1.0, even, odd), (-1.0, odd, even)] {
        masked.clear();
        masked.extend(others.groups().iter().map(|group| group.weight));
        let (mut mean, mut coupling) = (0.0, 0.0);
        for (k, (mode, other)) in modes.list().iter().zip(others.list()).enumerate() {
            mean += mode.weight * mode.cos;
            coupling += mode.weight * mode.sin_over;
            if mode.weight == 0.0 {
                continue;
            }
            masked.as_flattened_mut()[k] = 0.0;
            let (own, mirror) = sums(modes, masked, mode);
            masked.as_flattened_mut()[k] = other.weight;
            let (value, error) = residue(mode, other.weight, saltations, &own.total(), &mirror.total());
            let scale = eta * (1.0 + eta * mode.cos) / (2.0 * mode.cos);
            // The error of c.
            let slope = (mode.frequency * period * mode.sin / mode.cos).abs() + 4.0;
            let error = scale.abs() * (error + f64::EPSILON * slope * value.abs());
            let turned = mode.turned(eta, period);
            poles.push(Pole::new(k, turned.cos, turned.sin, turned.shift, scale * value, error));
        }
        trace += eta * (2.0 * mean - saltations.half_kappa() * coupling);
    }
    trace
}
