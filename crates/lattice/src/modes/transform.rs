//! All sites of a ring from its modes at once: Σ_k q_k cos(2πkn/M) for every n in O(M log M).

use std::fmt;
use std::sync::Arc;

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

/// Number of sites from which a fast transform beats plain sums (and the rounding of which small rings are spared).
pub(crate) const LARGE_RING: usize = 512;

/// A fast cosine transform for rings of one size, with its work space.
#[derive(Clone)]
pub(crate) struct RingTransform {
    plan: Arc<dyn Fft<f64>>,
    values: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

impl fmt::Debug for RingTransform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RingTransform").field("sites", &self.plan.len()).finish()
    }
}

impl RingTransform {
    /// A transform for rings of `sites` masses.
    pub(crate) fn new(sites: usize) -> Self {
        let plan = FftPlanner::new().plan_fft_forward(sites);
        let scratch = vec![Complex::default(); plan.get_inplace_scratch_len()];
        Self { plan, values: Vec::new(), scratch }
    }

    /// Σ_k q_k cos(2πkn/M) for n = 0 … M−1 from the amplitudes q_k of the even modes k = 0 … ⌊M/2⌋; those that are missing
    /// count as 0. Two real sums fit in one complex one.
    pub(crate) fn sites(&mut self, modes: impl Iterator<Item = Complex<f64>>) -> &[Complex<f64>] {
        let sites = self.plan.len();
        self.values.clear();
        self.values.resize(sites, Complex::default());
        for (k, amplitude) in modes.take(sites / 2 + 1).enumerate() {
            // cos = ½(e^{i·} + e^{−i·}); the two meet for k = 0 and for the mode of opposite neighbours.
            self.values[k] += 0.5 * amplitude;
            self.values[(sites - k) % sites] += 0.5 * amplitude;
        }
        self.plan.process_with_scratch(&mut self.values, &mut self.scratch);
        &self.values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modes::ring::RingCosines;

    #[test]
    fn transforms_are_plain_sums() {
        for sites in [1, 2, 3, 8, 21, 601, 1000, 1009] {
            let cosines = RingCosines::new(sites);
            let amplitude = |k: usize| Complex::new((3.7 * k as f64).sin(), (k as f64).cos());
            let mut transform = RingTransform::new(sites);
            let values = transform.sites((0..=sites / 2).map(amplitude)).to_vec();
            assert_eq!(values.len(), sites);
            for (n, value) in values.iter().enumerate() {
                let plain: Complex<f64> = (0..=sites / 2).map(|k| amplitude(k) * cosines.shape(k, n)).sum();
                assert!((value - plain).norm() < 1e-14 * sites as f64, "{sites} {n}: {value} {plain}");
            }
        }
    }
}
