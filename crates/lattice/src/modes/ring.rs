//! cos(2πj/M): the shape of every mode of a ring.

use std::sync::Arc;

/// Table of cos(2πj/M), j = 0 … M−1, each right to the last digit or so: arguments are folded into the first
/// octant in integers, so that no digit is lost for j near M. Copies share it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RingCosines {
    table: Arc<[f64]>,
    /// 1 − cos(2πj/M) of a small ring.
    defects: Arc<[f64]>,
}

/// Up to so many masses what could be worked out again is kept: sweeps are of small rings, and large ones have better use of memory.
pub(crate) const KEPT: usize = 4096;

impl RingCosines {
    /// The table for a ring of `sites` masses.
    pub(crate) fn new(sites: usize) -> Self {
        let kept = if sites <= KEPT { sites } else { 0 };
        let defects = (0..kept).map(|j| defect(j, sites)).collect();
        Self { table: (0..sites).map(|j| cos_turn(j, sites)).collect(), defects }
    }

    /// Number M of masses.
    pub(crate) fn sites(&self) -> usize {
        self.table.len()
    }

    /// cos(2πkn/M), the displacement of site `n` in mode `k` relative to site 0.
    pub(crate) fn shape(&self, k: usize, n: usize) -> f64 {
        self.table[self.turns(k, n)]
    }

    /// kn modulo M: of [`crate::MAX_SITES`] masses the product fits.
    fn turns(&self, k: usize, n: usize) -> usize {
        (k as u64 * n as u64 % self.table.len() as u64) as usize
    }

    /// 1 − cos(2πkn/M) to its own last digits.
    pub(crate) fn defect(&self, k: usize, n: usize) -> f64 {
        let j = self.turns(k, n);
        self.defects.get(j).copied().unwrap_or_else(|| defect(j, self.sites()))
    }

    /// cos(2πkn/M) − cos(2πkm/M) to its own last digits.
    pub(crate) fn defect_between(&self, k: usize, n: usize, m: usize) -> f64 {
        // = 2 sin(πk(m+n)/M) sin(πk(m−n)/M)
        let half = |turns: usize| {
            let (turns, sites) = ((k as u64 * turns as u64 % (2 * self.sites() as u64)) as usize, self.sites());
            cos_turn((4 * turns + 6 * sites) % (8 * sites), 8 * sites)
        };
        let sign = if m < n { -1.0 } else { 1.0 };
        2.0 * sign * half(m + n) * half(m.abs_diff(n))
    }

    /// sin(2πkn/M), the displacement of site `n` in the other mode of the frequency of mode `k`, which has a node at site 0.
    pub(crate) fn sine(&self, k: usize, n: usize) -> f64 {
        let sites = self.sites();
        // sin x = cos(x − π/2)
        cos_turn((4 * self.turns(k, n) + 3 * sites) % (4 * sites), 4 * sites)
    }

    /// cos(2πkn/M) for k = 0, 1, 2, …: the amplitudes at site `n` of all modes, without a multiplication a step.
    pub(crate) fn shapes(&self, n: usize) -> impl Iterator<Item = f64> + '_ {
        self.all_turns(n).map(|j| self.table[j])
    }

    /// The same of 1 − cos(2πkn/M).
    pub(crate) fn defects(&self, n: usize) -> impl Iterator<Item = f64> + '_ {
        self.all_turns(n).map(|j| self.defects.get(j).copied().unwrap_or_else(|| defect(j, self.sites())))
    }

    /// kn modulo M for k = 0, 1, 2, ….
    fn all_turns(&self, n: usize) -> impl Iterator<Item = usize> + use<> {
        let sites = self.table.len();
        let step = n % sites;
        std::iter::successors(Some(0), move |index| {
            let next = index + step;
            Some(if next >= sites { next - sites } else { next })
        })
    }
}

/// 1 − cos(2πj/m) for j < m.
fn defect(j: usize, m: usize) -> f64 {
    let half = (std::f64::consts::PI * j.min(m - j) as f64 / m as f64).sin();
    2.0 * half * half
}

/// cos(2πj/m) for j < m; beyond the first octant the complement is smaller, hence exact to more digits.
fn cos_turn(j: usize, m: usize) -> f64 {
    let j = j.min(m - j);
    let (turn, size) = (std::f64::consts::TAU, m as f64);
    if 8 * j <= m {
        (turn * j as f64 / size).cos()
    } else if 8 * j <= 3 * m {
        (turn * (size - 4.0 * j as f64) / (4.0 * size)).sin()
    } else {
        -(turn * (m - 2 * j) as f64 / (2.0 * size)).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_library_cosine() {
        for m in [1, 2, 3, 4, 5, 7, 8, 21, 100, 1001] {
            let ring = RingCosines::new(m);
            for j in 0..m {
                let expected = (std::f64::consts::TAU * j as f64 / m as f64).cos();
                assert!((ring.shape(1, j) - expected).abs() < 2e-15, "{j}/{m}");
                assert!((ring.defect(1, j) - (1.0 - expected)).abs() < 2e-15, "{j}/{m}");
                for (k, n) in [(1, 0), (3, 2), (2, j / 2)] {
                    let plain = ring.shape(k, n) - ring.shape(k, j);
                    assert!((ring.defect_between(k, n, j) - plain).abs() < 2e-15, "{k} {n} {j}/{m}");
                }
                let expected = (std::f64::consts::TAU * j as f64 / m as f64).sin();
                assert!((ring.sine(1, j) - expected).abs() < 2e-15, "{j}/{m}");
            }
        }
        let ring = RingCosines::new(21);
        for n in [0, 1, 5, 20] {
            assert!(ring.shapes(n).take(11).enumerate().all(|(k, shape)| shape == ring.shape(k, n)));
            assert!(ring.defects(n).take(11).enumerate().all(|(k, defect)| defect == ring.defect(k, n)));
        }
        assert_eq!(RingCosines::new(4).shape(1, 1), 0.0);
        assert_eq!(RingCosines::new(12).shape(2, 3), -1.0);
        assert_eq!((ring.sine(0, 3), ring.sine(7, 0), RingCosines::new(4).sine(2, 3)), (0.0, 0.0, 0.0));
    }
}
