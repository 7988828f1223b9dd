//! K_n at any site and time, mode by mode.

use rustfft::num_complex::Complex;

use super::ImpulseResponse;
use crate::simd::small::{cubic_defect, long_sum, sinc};

impl ImpulseResponse {
    /// Static response of mode `k`, 1/(Ω_k²T), without its weight; 0 for a rigid mode.
    pub fn mode_static(&self, k: usize) -> f64 {
        self.statics[k]
    }

    /// Dynamic response of mode `k`, without its weight, at 0 ≤ `t` ≤ T.
    pub fn mode_dynamic(&self, k: usize, t: f64) -> f64 {
        // At the impulse and half-way it is known, and known better.
        if t == 0.0 || t == self.period {
            return self.at_impulse[k];
        }
        if t == 0.5 * self.period {
            return self.at_half[k];
        }
        let (frequency, y) = (self.frequencies[k], self.half_phase[k]);
        let offset = t - 0.5 * self.period;
        if y < 1.0 {
            // T [(y − sin y)/y³ − 2ξ² sinc²(x/2)] / (4 sinc y): the 1/y² of the static part is gone term by term.
            let xi = offset / self.period;
            let s = xi * sinc(0.5 * frequency * offset);
            self.period * (cubic_defect(y) - 2.0 * s * s) / (4.0 * sinc(y))
        } else {
            ((frequency * offset).cos() / self.sin_half[k] - 1.0 / y) / (2.0 * frequency)
        }
    }

    /// Velocity response of mode `k`, without its weight, at 0 < `t` < T; at the impulse itself the mean of both
    /// sides, 0.
    pub fn mode_slope(&self, k: usize, t: f64) -> f64 {
        if t <= 0.0 || t >= self.period {
            return 0.0;
        }
        let (frequency, y) = (self.frequencies[k], self.half_phase[k]);
        let offset = t - 0.5 * self.period;
        if offset == 0.0 {
            0.0
        } else if y < 1.0 {
            -offset / self.period * sinc(frequency * offset) / sinc(y)
        } else {
            -(frequency * offset).sin() / (2.0 * self.sin_half[k])
        }
    }

    /// K_n(t) for 0 ≤ `t` ≤ T (other times are folded into the period).
    ///
    /// For γ₁ = 0 the uniform mode's static part is infinite and left out: K_n is then defined up to a constant
    /// common to all sites, which cancels wherever the net impulse is zero.
    pub fn value(&self, site: usize, t: f64) -> f64 {
        let t = self.fold(t);
        let shape = |k| self.weights[k] * self.shapes.even(k, site, 0);
        long_sum(self.modes(), |k| [shape(k) * (self.mode_static(k) + self.mode_dynamic(k, t))])[0]
    }

    /// dK_n/dt; at the impulse itself (t = 0) the mean of both sides, 0.
    pub fn derivative(&self, site: usize, t: f64) -> f64 {
        let t = self.fold(t);
        long_sum(self.modes(), |k| [self.weights[k] * self.shapes.even(k, site, 0) * self.mode_slope(k, t)])[0]
    }

    /// K_n(t) at all sites n, of a ring at n = 0 … ⌊M/2⌋ (it is symmetric about site 0), written to `out`; one sine a mode
    /// for all of them, O(M log M) for a large ring. Entries of `out` beyond are left alone.
    pub fn profile(&self, t: f64, out: &mut [f64]) {
        let t = self.fold(t);
        let amplitude = |k: usize| Complex::new(self.weights[k] * (self.mode_static(k) + self.mode_dynamic(k, t)), 0.0);
        let amplitudes: Vec<_> = (0..self.modes()).map(amplitude).collect();
        let mut all = vec![Complex::default(); self.sites()];
        self.shapes.clone().add_all(0, amplitudes.into_iter(), &mut all);
        let distinct = if self.chain.is_ring() { self.modes() } else { self.sites() };
        out.iter_mut().take(distinct).zip(all).for_each(|(out, value)| *out = value.re);
    }

    pub(crate) fn fold(&self, t: f64) -> f64 {
        if (0.0..=self.period).contains(&t) { t } else { t.rem_euclid(self.period) }
    }

    /// Σ weight·shape/(Ω_k² − w²) for each list of shapes ([`Shapes::evens`](crate::Shapes::evens) of site n about site i) and w of `frequencies`: how far a
    /// force cos wt at site i makes site n swing. Infinite where w meets a mode.
    pub fn driven<const N: usize, const J: usize>(
        &self,
        mut shapes: [impl Iterator<Item = f64>; N],
        frequencies: [f64; J],
    ) -> [[f64; J]; N] {
        let mut sums = [[0.0; J]; N];
        for (mode, weight) in self.frequencies().iter().zip(self.weights()) {
            let terms = frequencies.map(|w| weight / ((mode - w) * (mode + w)));
            for (sum, shape) in sums.iter_mut().zip(&mut shapes) {
                let shape = shape.next().unwrap_or_default();
                sum.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term * shape);
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::chain::Chain;
    use crate::modes::row::Ends;
    use crate::modes::spectrum::Spectrum;

    fn response(sites: usize, g1: f64, g2: f64, omega: f64) -> ImpulseResponse {
        ImpulseResponse::new(&Spectrum::new(Chain::new(sites, g1, g2).unwrap()), omega).unwrap()
    }

    /// Fourier series of the same, the way the paper sums it (with its static term), for J harmonics.
    fn series(r: &ImpulseResponse, n: usize, t: f64, terms: u32) -> f64 {
        let per_mode = |k: usize| {
            let square = r.frequencies[k].powi(2);
            let sum: f64 = (1..=terms)
                .map(|j| {
                    let w = f64::from(j) * r.omega;
                    2.0 * (w * t).cos() / (square - w * w)
                })
                .sum();
            (1.0 / square + sum) / r.period
        };
        (0..r.modes()).map(|k| r.weights[k] * r.shapes.even(k, n, 0) * per_mode(k)).sum()
    }

    #[test]
    fn closed_form_is_the_limit_of_the_series() {
        for (sites, g1, g2, omega) in
            [(1, 0.2, 0.1, 1.5), (2, 0.2, 0.1, 0.31), (5, 0.2, 0.1, 0.9), (6, 0.01, 3.0, 0.4), (21, 1e-3, 1e-3, 2.0)]
        {
            let r = response(sites, g1, g2, omega);
            for n in [0, 1, sites / 2] {
                for fraction in [0.07, 0.3, 0.5, 0.81] {
                    let t = fraction * r.period;
                    let expected = series(&r, n, t, 20_000);
                    assert!((r.value(n, t) - expected).abs() < 2e-8 * r.period, "{sites} {n} {fraction}");
                }
            }
        }
    }

    #[test]
    fn equation_of_motion_holds_between_impulses_and_the_velocity_jumps_by_one() {
        for sites in [1, 2, 3, 8, 21] {
            let (g1, g2, omega) = (0.2, 0.1, 0.83);
            let r = response(sites, g1, g2, omega);
            let (t, h) = (0.37 * r.period, 1e-3);
            for n in 0..sites {
                let k = |n: usize, t: f64| r.value(n % sites, t);
                let second = (k(n, t + h) - 2.0 * k(n, t) + k(n, t - h)) / (h * h);
                let force = -g1 * k(n, t) - g2 * (2.0 * k(n, t) - k(n + 1, t) - k(n + sites - 1, t));
                assert!((second - force).abs() < 1e-6, "{sites} {n}");
                let slope = (k(n, t + h) - k(n, t - h)) / (2.0 * h);
                assert!((slope - r.derivative(n, t)).abs() < 1e-6);
                let jump = r.derivative(n, 1e-13) - r.derivative(n, r.period - 1e-13);
                assert!((jump - f64::from(u8::from(n == 0))).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn many_sites_are_as_one() {
        for sites in [1, 2, 3, 8, 21] {
            let r = response(sites, 0.2, 0.1, 0.83);
            let times = [0.0, 0.3, 0.5 * r.period, r.period + 0.1, -0.4];
            let mut profile = vec![f64::NAN; sites / 2 + 1];
            for t in times {
                r.profile(t, &mut profile);
                for (n, value) in profile.iter().enumerate() {
                    assert!((value - r.value(n, t)).abs() < 1e-14, "{sites} {n} {t}");
                    assert!((value - r.value(sites - n, t)).abs() < 1e-14, "the ring is symmetric about site 0");
                }
            }
            // Times are folded into the period.
            assert!((r.value(1, times[3]) - r.value(1, 0.1)).abs() < 1e-14);
        }
    }

    #[test]
    fn soft_and_stiff_forms_meet_where_they_change_over() {
        // y crosses 1 at omega = π Ω for one mass.
        let omega = std::f64::consts::PI * 0.7;
        let above = response(1, 0.49, 0.0, omega * (1.0 - 1e-12));
        let below = response(1, 0.49, 0.0, omega * (1.0 + 1e-12));
        assert!(above.half_phase[0] >= 1.0 && below.half_phase[0] < 1.0);
        for fraction in [0.0, 0.2, 0.5, 0.9] {
            let t = fraction * above.period;
            assert!((above.mode_dynamic(0, t) - below.mode_dynamic(0, t)).abs() < 1e-11);
            assert!((above.mode_slope(0, t) - below.mode_slope(0, t)).abs() < 1e-11);
        }
    }

    #[test]
    fn rigid_mode_moves_in_straight_lines_between_impulses() {
        // γ₁ = 0, one free mass: the dynamic part is the Bernoulli parabola T/24 − (t−T/2)²/(2T).
        let spectrum = Spectrum::new(Chain::new(1, 0.0, 1.0).unwrap());
        let r = ImpulseResponse::new(&spectrum, 2.0).unwrap();
        assert_eq!(r.static_stiffness(), 0.0);
        assert!(r.uniform_static().is_none());
        for fraction in [0.0, 0.25, 0.6] {
            let offset = (fraction - 0.5) * r.period;
            let expected = r.period / 24.0 - offset * offset / (2.0 * r.period);
            assert!((r.mode_dynamic(0, fraction * r.period) - expected).abs() < 1e-15);
        }
        assert!((r.mode_slope(0, 0.25 * r.period) - 0.25).abs() < 1e-16);
    }

    /// Between walls Ω₀² = γ₁ + 4γ₂ sin²(π/2(M+1)); without them it is γ₁.
    #[test]
    fn what_a_net_impulse_holds_up_is_known_by_hand() {
        let (gamma1, gamma2, omega) = (0.2, 0.3, 1.7);
        for sites in [1, 2, 5, 40] {
            let chain = Chain::new(sites, gamma1, gamma2).unwrap();
            let half = 0.5 * std::f64::consts::PI / (sites as f64 + 1.0);
            let walled = (chain.with_ends(Ends::Fixed), gamma1 + 4.0 * gamma2 * half.sin().powi(2));
            for (chain, square) in [(chain, gamma1), walled] {
                let r = ImpulseResponse::new(&Spectrum::new(chain), omega).unwrap();
                let right = omega / (std::f64::consts::TAU * square * sites as f64);
                assert!((r.uniform_static().unwrap() - right).abs() < 1e-14 * right, "{sites} {square}");
            }
        }
    }
}
