//! Exact free flight of the whole ring: exp(At) is a circulant of four kernels (docs/guide/stability.md), never a general
//! matrix exponential.

use crate::ring::RingCosines;
use crate::small::sine_over;
use crate::spectrum::Spectrum;

/// The flow u, u̇ → u, u̇ over a fixed time, without force and without impacts.
///
/// ```
/// use vibrochain_lattice::{Chain, Propagator, Spectrum};
/// let flow = Propagator::new(&Spectrum::new(Chain::new(1, 1.0, 0.0)?), 0.5);
/// let (mut u, mut v) = ([0.0], [0.0]);
/// flow.apply(&[1.0], &[0.0], &mut u, &mut v);
/// assert!((u[0] - 0.5_f64.cos()).abs() < 1e-16 && (v[0] + 0.5_f64.sin()).abs() < 1e-16);
/// # Ok::<(), vibrochain_lattice::ParameterError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Propagator {
    /// Rows of the circulants of cos Ωt, sin Ωt/Ω and −Ω sin Ωt.
    cos: Vec<f64>,
    sin_over: Vec<f64>,
    minus_sin_times: Vec<f64>,
}

impl Propagator {
    /// The flow over `time` (any sign). Costs O(M²).
    pub fn new(spectrum: &Spectrum, time: f64) -> Self {
        let sites = spectrum.chain().sites();
        let ring = RingCosines::new(sites);
        let circulant = |of_frequency: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let modal: Vec<f64> = spectrum.frequencies().iter().map(|&f| of_frequency(f)).collect();
            let entry =
                |n| modal.iter().zip(spectrum.weights()).enumerate().map(|(k, (f, w))| w * f * ring.shape(k, n)).sum();
            (0..sites).map(entry).collect()
        };
        Self {
            cos: circulant(&|f| (f * time).cos()),
            sin_over: circulant(&|f| sine_over(f, time)),
            minus_sin_times: circulant(&|f| -f * (f * time).sin()),
        }
    }

    /// Number of masses.
    pub fn sites(&self) -> usize {
        self.cos.len()
    }

    /// The entry of exp(At) that takes (displacement, velocity) of a site to those of the site `distance` away:
    /// `[[u←u, u←v], [v←u, v←v]]`.
    pub fn block(&self, distance: usize) -> [[f64; 2]; 2] {
        let n = distance % self.sites();
        [[self.cos[n], self.sin_over[n]], [self.minus_sin_times[n], self.cos[n]]]
    }

    /// Carries displacements `u` and velocities `v` (M entries each) forward into `u_out`, `v_out`. Costs O(M²).
    pub fn apply(&self, u: &[f64], v: &[f64], u_out: &mut [f64], v_out: &mut [f64]) {
        let sites = self.sites();
        for (n, (u_n, v_n)) in u_out.iter_mut().zip(v_out.iter_mut()).enumerate().take(sites) {
            (*u_n, *v_n) = (0.0, 0.0);
            for (m, (u_m, v_m)) in u.iter().zip(v).enumerate().take(sites) {
                let d = n.abs_diff(m);
                *u_n += self.cos[d] * u_m + self.sin_over[d] * v_m;
                *v_n += self.minus_sin_times[d] * u_m + self.cos[d] * v_m;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Chain;

    /// Classical fourth-order Runge–Kutta with small steps: shares nothing with the closed form.
    fn integrate(chain: &Chain, u: &mut [f64], v: &mut [f64], time: f64) {
        let (m, steps) = (chain.sites(), 4000);
        let h = time / f64::from(steps);
        let force = |u: &[f64]| -> Vec<f64> {
            (0..m)
                .map(|n| -chain.gamma1() * u[n] - chain.gamma2() * (2.0 * u[n] - u[(n + 1) % m] - u[(n + m - 1) % m]))
                .collect()
        };
        let add = |x: &[f64], k: &[f64], c: f64| -> Vec<f64> { x.iter().zip(k).map(|(x, k)| x + c * k).collect() };
        for _ in 0..steps {
            let (k1, l1) = (v.to_vec(), force(u));
            let (k2, l2) = (add(v, &l1, h / 2.0), force(&add(u, &k1, h / 2.0)));
            let (k3, l3) = (add(v, &l2, h / 2.0), force(&add(u, &k2, h / 2.0)));
            let (k4, l4) = (add(v, &l3, h), force(&add(u, &k3, h)));
            for n in 0..m {
                u[n] += h / 6.0 * (k1[n] + 2.0 * k2[n] + 2.0 * k3[n] + k4[n]);
                v[n] += h / 6.0 * (l1[n] + 2.0 * l2[n] + 2.0 * l3[n] + l4[n]);
            }
        }
    }

    #[test]
    fn free_flight_matches_a_numerical_integration() {
        for (sites, g1, g2) in [(1, 0.2, 0.1), (2, 0.2, 0.1), (3, 0.0, 1.0), (6, 0.3, 0.7), (7, 0.3, 0.0)] {
            let chain = Chain::new(sites, g1, g2).unwrap();
            let mut u: Vec<f64> = (0..sites).map(|n| (n as f64 * 1.7).sin()).collect();
            let mut v: Vec<f64> = (0..sites).map(|n| (n as f64 * 0.6 + 1.0).cos()).collect();
            let flow = Propagator::new(&Spectrum::new(chain), 2.3);
            let (mut u1, mut v1) = (vec![0.0; sites], vec![0.0; sites]);
            flow.apply(&u, &v, &mut u1, &mut v1);
            integrate(&chain, &mut u, &mut v, 2.3);
            for n in 0..sites {
                assert!((u[n] - u1[n]).abs() < 1e-12 && (v[n] - v1[n]).abs() < 1e-12, "{sites} {n}");
            }
        }
    }
}
