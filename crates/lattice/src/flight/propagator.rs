//! Exact free flight of a whole lattice: exp(At) is made of four kernels (docs/guide/stability.md), never a general matrix
//! exponential.

use crate::modes::row::LineShapes;
use crate::modes::spectrum::Spectrum;
use crate::simd::small::sine_over;

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
    along: LineShapes,
    across: LineShapes,
    /// Kernels of cos Ωt, sin Ωt/Ω and −Ω sin Ωt on the torus of images, [distance across][distance along].
    kernels: Vec<[f64; 3]>,
}

impl Propagator {
    /// The flow over `time` (any sign). Costs O(M²) for a ring.
    pub fn new(spectrum: &Spectrum, time: f64) -> Self {
        let [along, across] = spectrum.chain().lines().map(LineShapes::new);
        let modes = along.line().modes();
        let modal: Vec<[f64; 3]> = (spectrum.frequencies().iter().zip(spectrum.weights()))
            .map(|(&f, w)| [(f * time).cos(), sine_over(f, time), -f * (f * time).sin()].map(|x| w * x))
            .collect();
        let mut kernels = Vec::with_capacity(along.circle() * across.circle());
        let mut rows = vec![[0.0; 3]; modes];
        for layer in 0..across.circle() {
            for (k, row) in rows.iter_mut().enumerate() {
                let of_layers = modal.iter().skip(k).step_by(modes);
                *row = sum(of_layers.enumerate().map(|(l, modal)| (modal, across.cosine(l, layer))));
            }
            let entry = |n| sum(rows.iter().enumerate().map(|(k, row)| (row, along.cosine(k, n))));
            kernels.extend((0..along.circle()).map(entry));
        }
        Self { along, across, kernels }
    }

    /// Number of masses.
    pub fn sites(&self) -> usize {
        self.along.line().masses * self.across.line().masses
    }

    /// The entry of exp(At) that takes (displacement, velocity) of site `from` to those of site `to`:
    /// `[[u←u, u←v], [v←u, v←v]]`.
    pub fn block(&self, to: usize, from: usize) -> [[f64; 2]; 2] {
        let length = self.along.line().masses;
        let mut sum = [0.0; 3];
        for (n, share) in self.along.images(to % length, from % length).into_iter().flatten() {
            for (layer, of_layer) in self.across.images(to / length, from / length).into_iter().flatten() {
                let kernel = &self.kernels[layer * self.along.circle() + n];
                sum.iter_mut().zip(kernel).for_each(|(sum, kernel)| *sum += share * of_layer * kernel);
            }
        }
        let [cos, sin_over, minus_sin_times] = sum;
        [[cos, sin_over], [minus_sin_times, cos]]
    }

    /// Carries displacements `u` and velocities `v` (M entries each) forward into `u_out`, `v_out`. Costs O(M²).
    pub fn apply(&self, u: &[f64], v: &[f64], u_out: &mut [f64], v_out: &mut [f64]) {
        let sites = self.sites();
        for (n, (u_n, v_n)) in u_out.iter_mut().zip(v_out.iter_mut()).enumerate().take(sites) {
            (*u_n, *v_n) = (0.0, 0.0);
            for (m, (u_m, v_m)) in u.iter().zip(v).enumerate().take(sites) {
                let [of_u, of_v] = self.block(n, m);
                *u_n += of_u[0] * u_m + of_u[1] * v_m;
                *v_n += of_v[0] * u_m + of_v[1] * v_m;
            }
        }
    }
}

fn sum<'a>(terms: impl Iterator<Item = (&'a [f64; 3], f64)>) -> [f64; 3] {
    terms.fold([0.0; 3], |sum, (term, factor)| std::array::from_fn(|i| sum[i] + term[i] * factor))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::chain::Chain;
    use crate::modes::row::Ends;

    /// Classical fourth-order Runge–Kutta with small steps: shares nothing with the closed form.
    fn integrate(chain: &Chain, u: &mut [f64], v: &mut [f64], time: f64) {
        let (m, steps) = (chain.sites(), 4000);
        let h = time / f64::from(steps);
        let (length, layers) = (chain.length(), chain.layers());
        // Whose displacement stands for the neighbour's beyond an end.
        let beyond = |ends: Ends, own: f64, far: f64| match ends {
            Ends::Closed => far,
            Ends::Free => own,
            Ends::Fixed => 0.0,
        };
        let force = |u: &[f64]| -> Vec<f64> {
            let pull = |n: usize| {
                let (i, l, own) = (n % length, n / length, u[n]);
                let at = |i: usize, l: usize| u[i + l * length];
                let left = if i > 0 { at(i - 1, l) } else { beyond(chain.ends(), own, at(length - 1, l)) };
                let right = if i + 1 < length { at(i + 1, l) } else { beyond(chain.ends(), own, at(0, l)) };
                let below = if l > 0 { at(i, l - 1) } else { beyond(chain.layer_ends(), own, at(i, layers - 1)) };
                let above = if l + 1 < layers { at(i, l + 1) } else { beyond(chain.layer_ends(), own, at(i, 0)) };
                chain.gamma1() * own
                    + chain.gamma2() * (2.0 * own - left - right)
                    + chain.gamma3() * (2.0 * own - below - above)
            };
            (0..m).map(|n| -pull(n)).collect()
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
        let ring = |sites, g1, g2| Chain::new(sites, g1, g2).unwrap();
        for chain in [
            ring(1, 0.2, 0.1),
            ring(2, 0.2, 0.1),
            ring(3, 0.0, 1.0),
            ring(6, 0.3, 0.7),
            ring(7, 0.3, 0.0),
            ring(1, 0.0, 0.4).with_ends(Ends::Fixed),
            ring(5, 0.0, 0.4).with_ends(Ends::Fixed),
            ring(5, 0.0, 0.4).with_ends(Ends::Free),
            ring(3, 0.1, 0.4).with_layers(3, 0.3, Ends::Closed).unwrap(),
            ring(3, 0.1, 0.4).with_ends(Ends::Free).with_layers(2, 0.3, Ends::Free).unwrap(),
            ring(2, 0.0, 0.4).with_ends(Ends::Fixed).with_layers(4, 0.3, Ends::Fixed).unwrap(),
        ] {
            let sites = chain.sites();
            let mut u: Vec<f64> = (0..sites).map(|n| (n as f64 * 1.7).sin()).collect();
            let mut v: Vec<f64> = (0..sites).map(|n| (n as f64 * 0.6 + 1.0).cos()).collect();
            let flow = Propagator::new(&Spectrum::new(chain), 2.3);
            let (mut u1, mut v1) = (vec![0.0; sites], vec![0.0; sites]);
            flow.apply(&u, &v, &mut u1, &mut v1);
            integrate(&chain, &mut u, &mut v, 2.3);
            for n in 0..sites {
                assert!((u[n] - u1[n]).abs() < 1e-12 && (v[n] - v1[n]).abs() < 1e-12, "{chain:?} {n}");
            }
        }
    }
}
