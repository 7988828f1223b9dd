//! How much the impulse response can be trusted: its first-order response to relative changes of its data.
//!
//! Ω_k, ω and t come rounded, so that no evaluation can be better than the condition of the sum it evaluates. A mode's
//! term cos x/(2Ω sin y), y = ΩT/2, x = Ω(t−T/2), answers to a relative change of y with y cot y, which next to a
//! resonance is Ω/|Ω−jω|, and to one of x with x tan x.

use super::{ImpulseResponse, KernelJet};
use crate::simd::small::{cubic_defect, sinc};

impl ImpulseResponse {
    /// Largest first-order changes of the dynamic parts of K₀, K₀′, K₀″ and K₀‴ at 0 ≤ `t` ≤ T when every frequency, the
    /// period and the time change by a relative unit each, with the worst signs. Times the unit of rounding they bound
    /// what rounding of the data and of a few operations does; divided by |K₀| they are its condition number.
    ///
    /// ```
    /// use vibrochain_lattice::{Chain, ImpulseResponse, Spectrum};
    /// // 1e-6 from a resonance six digits are gone, and predicted to be.
    /// let spectrum = Spectrum::new(Chain::new(1, 1.0, 0.0)?);
    /// let response = ImpulseResponse::new(&spectrum, 0.5 * (1.0 + 1e-6))?;
    /// let condition = response.sensitivity(0.0).value / response.dynamic_at_impulse().abs();
    /// assert!(condition > 0.9e6 && condition < 4e6);
    /// # Ok::<(), vibrochain_lattice::LatticeError>(())
    /// ```
    pub fn sensitivity(&self, t: f64) -> KernelJet {
        self.sensitivity_at(0, t)
    }

    /// 2|y cot y|: relative change of the amplitude of mode `k` when frequency and period change by a relative unit each;
    /// Ω/|Ω−jω| and more next to a resonance. 0 for soft modes, y < 1, whose terms are regular.
    fn mode_detuning(&self, k: usize) -> f64 {
        let y = 0.5 * self.frequencies()[k] * self.period();
        if y < 1.0 { 0.0 } else { 2.0 * y * (self.cos_half()[k] / self.sin_half()[k]).abs() }
    }

    /// As [`ImpulseResponse::sensitivity`], for K_n and its derivatives at the site `site`.
    pub fn sensitivity_at(&self, site: usize, t: f64) -> KernelJet {
        let t = self.fold(t);
        let offset = t - 0.5 * self.period();
        let mut sum = KernelJet::default();
        for (k, (&frequency, &weight)) in self.frequencies().iter().zip(self.weights()).enumerate() {
            let weight = weight * self.shapes().even(k, site, 0).abs();
            let y = 0.5 * frequency * self.period();
            if y < 1.0 {
                // All terms are of one sign or regular in y: a few units each, and what a change of t and T does.
                let xi = (offset / self.period()).abs();
                let swing = 2.0 * (t / self.period()).max(0.5);
                let scale = weight / sinc(y);
                sum.value += scale * self.period() * (cubic_defect(y) + 2.0 * xi * xi + xi * swing);
                sum.slope += scale * (4.0 * xi + swing);
                sum.curvature += scale * 4.0 / self.period();
                sum.third += scale * frequency * frequency * (4.0 * xi + swing);
            } else {
                let (sine, x) = (self.sin_half()[k].abs(), frequency * offset);
                let (sin, cos) = x.sin_cos();
                let (sin, cos) = (sin.abs(), cos.abs());
                // t, T and Ω enter x = Ω(t−T/2).
                let (amplitude, swing) = (2.0 + self.mode_detuning(k), 2.0 * frequency * t.max(0.5 * self.period()));
                let (even, odd) = (amplitude * cos + swing * sin, amplitude * sin + swing * cos);
                let scale = weight * 0.5 / sine;
                sum.value += scale * (even + 2.0 * sine / y) / frequency;
                sum.slope += scale * odd;
                sum.curvature += scale * frequency * even;
                sum.third += scale * frequency * frequency * odd;
            }
        }
        sum
    }

    /// As [`ImpulseResponse::sensitivity_at`], for the value K_n(t) with its static part (for γ₁ = 0 without the uniform
    /// one, as in [`ImpulseResponse::value`]).
    pub fn value_sensitivity(&self, site: usize, t: f64) -> f64 {
        let still = |k: usize| 3.0 * self.weights()[k] * self.mode_static(k) * self.shapes().even(k, site, 0).abs();
        self.sensitivity_at(site, t).value + (0..self.modes()).map(still).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::chain::Chain;
    use crate::modes::spectrum::Spectrum;

    /// The estimate covers the change that a perturbed stiffness causes, and is not wildly larger than the worst one.
    #[test]
    fn covers_what_perturbed_data_do() {
        let h = 1e-9;
        let (mut checked, mut largest) = (0, 0.0_f64);
        for (sites, omega) in [(1, 0.3), (5, 1.5), (8, 0.21), (21, 0.447), (21, 12.0)] {
            let at = |g1: f64, omega: f64| {
                ImpulseResponse::new(&Spectrum::new(Chain::new(sites, g1, 0.1).unwrap()), omega).unwrap()
            };
            let plain = at(0.2, omega);
            for fraction in [0.0, 0.13, 0.5, 0.77] {
                let bound = plain.sensitivity(fraction * plain.period());
                let mut worst = KernelJet::default();
                // All frequencies of one mass move with γ₁; ω moves T, with t or without it; t moves alone.
                let t = fraction * plain.period();
                let jet = |r: &ImpulseResponse, t: f64| r.jet_from_half(t - 0.5 * r.period());
                let (stiffer, faster) = (at(0.2 * (1.0 + 2.0 * h), omega), at(0.2, omega * (1.0 + h)));
                for (other, t) in [(&stiffer, t), (&faster, t / (1.0 + h)), (&faster, t), (&plain, t * (1.0 + h))] {
                    if t > other.period() {
                        continue;
                    }
                    let (a, b) = (jet(&plain, fraction * plain.period()), jet(other, t));
                    worst.value = worst.value.max((a.value - b.value).abs() / h);
                    worst.slope = worst.slope.max((a.slope - b.slope).abs() / h);
                    worst.curvature = worst.curvature.max((a.curvature - b.curvature).abs() / h);
                    worst.third = worst.third.max((a.third - b.third).abs() / h);
                }
                let slack = 1.01;
                assert!(worst.value <= bound.value * slack, "{sites} {omega} {fraction} {worst:?} {bound:?}");
                assert!(worst.slope <= bound.slope * slack + 1e-6, "{sites} {omega} {fraction} {worst:?} {bound:?}");
                assert!(worst.curvature <= bound.curvature * slack, "{sites} {omega} {fraction} {worst:?} {bound:?}");
                assert!(worst.third <= bound.third * slack + 1e-6, "{sites} {omega} {fraction} {worst:?} {bound:?}");
                checked += 1;
                largest = largest.max(bound.value / worst.value);
            }
        }
        println!("{checked} checked, at most {largest} times as large");
        assert!(checked == 20 && largest < 100.0, "{checked} {largest}");
    }
}
