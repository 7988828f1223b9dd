//! The shapes of a chain's modes: what the layers above know of its geometry.

use rustfft::num_complex::Complex;

use crate::ring::RingCosines;
use crate::transform::{LARGE_RING, RingTransform};

/// The shapes of a ring's modes: mode k swings evenly about any site one likes, with cos(2πkn/M) at the n-th site from there; its
/// partner of the same frequency, sin(2πkn/M), has a node there.
///
/// ```
/// use vibrochain_lattice::Shapes;
/// let shapes = Shapes::new(12);
/// assert_eq!((shapes.even(2, 8, 5), shapes.odd(3, 6, 5)), (-1.0, 1.0));
/// ```
#[derive(Debug, Clone)]
pub struct Shapes {
    cosines: RingCosines,
    /// For large rings, once all masses have been asked for.
    transform: Option<RingTransform>,
}

impl Shapes {
    /// The shapes of a ring of `sites` masses.
    pub fn new(sites: usize) -> Self {
        Self { cosines: RingCosines::new(sites), transform: None }
    }

    /// Number of masses.
    pub fn sites(&self) -> usize {
        self.cosines.sites()
    }

    /// All masses at once ([`Shapes::add_all`]) cost less than half of them one by one.
    pub fn is_large(&self) -> bool {
        self.sites() >= LARGE_RING
    }

    /// Displacement of `site` in mode `k` even about site `about`, which is displaced by 1.
    pub fn even(&self, k: usize, site: usize, about: usize) -> f64 {
        self.cosines.shape(k, site.abs_diff(about))
    }

    /// Displacement of `site` in the partner of mode `k`, odd about site `about`.
    pub fn odd(&self, k: usize, site: usize, about: usize) -> f64 {
        let sine = self.cosines.sine(k, site.abs_diff(about));
        if site < about { -sine } else { sine }
    }

    /// 1 − [`Shapes::even`] to its own last digits.
    pub fn drop(&self, k: usize, site: usize, about: usize) -> f64 {
        self.cosines.defect(k, site.abs_diff(about))
    }

    /// [`Shapes::even`] of all modes, without a multiplication a step.
    pub fn evens(&self, site: usize, about: usize) -> impl Iterator<Item = f64> + '_ {
        self.cosines.shapes(site.abs_diff(about))
    }

    /// Adds to every mass what the even modes about site `about` make of it, in O(M log M) for a large ring: Σ_k amplitude_k ·
    /// even(k, n, about) at each site n. Two real sums fit in one complex one.
    pub fn add_all(
        &mut self,
        about: usize,
        amplitudes: impl Iterator<Item = Complex<f64>> + Clone,
        out: &mut [Complex<f64>],
    ) {
        let sites = self.sites();
        if !self.is_large() {
            for (n, out) in out.iter_mut().enumerate().take(sites) {
                *out += amplitudes.clone().zip(self.evens(n, about)).map(|(x, shape)| x * shape).sum::<Complex<f64>>();
            }
            return;
        }
        let transform = self.transform.get_or_insert_with(|| RingTransform::new(sites));
        for (n, value) in transform.sites(amplitudes).iter().enumerate() {
            out[(n + about) % sites] += value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_masses_move_as_one_by_one_on_small_and_large_rings() {
        for sites in [1, 2, 7, 600, 601] {
            let mut shapes = Shapes::new(sites);
            let amplitude = |k: usize| Complex::new((3.7 * k as f64).sin(), (k as f64).cos());
            let about = sites / 3;
            let mut all = vec![Complex::new(1.0, 0.0); sites];
            shapes.add_all(about, (0..=sites / 2).map(amplitude), &mut all);
            for (n, value) in all.iter().enumerate() {
                let plain: Complex<f64> = (0..=sites / 2).map(|k| amplitude(k) * shapes.even(k, n, about)).sum();
                assert!((value - 1.0 - plain).norm() < 1e-14 * sites as f64, "{sites} {n}");
            }
        }
    }

    #[test]
    fn even_and_odd_make_a_running_wave() {
        let shapes = Shapes::new(9);
        for (k, site, about) in [(1, 2, 7), (3, 8, 1), (4, 0, 0)] {
            let turn = std::f64::consts::TAU * k as f64 * (site as f64 - about as f64) / 9.0;
            assert!((shapes.even(k, site, about) - turn.cos()).abs() < 2e-15);
            assert!((shapes.odd(k, site, about) - turn.sin()).abs() < 2e-15);
            assert!((shapes.drop(k, site, about) - (1.0 - turn.cos())).abs() < 2e-15);
            assert_eq!(shapes.evens(site, about).nth(k), Some(shapes.even(k, site, about)));
        }
    }
}
