//! Exact free flight of a whole lattice: exp(At) is made of four kernels (docs/guide/stability.md), never a general matrix
//! exponential.

use crate::kernel::turn::oscillator_flight;
use crate::modes::row::LineShapes;
use crate::modes::spectrum::Spectrum;

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
    /// Kernels of what each mode's displacement and velocity become ([`oscillator_flight`], row by row) on the torus of images, [distance
    /// across][distance along].
    kernels: Vec<[f64; 4]>,
}

impl Propagator {
    /// The flow over `time` (any sign). Costs O(M²) for a ring.
    pub fn new(spectrum: &Spectrum, time: f64) -> Self {
        Self::with_dashpots(spectrum, [0.0; 2], time)
    }

    /// The same with dashpots c and c₂.
    pub fn with_dashpots(spectrum: &Spectrum, dashpots: [f64; 2], time: f64) -> Self {
        let [along, across] = spectrum.chain().lines().map(LineShapes::new);
        let modes = along.line().modes();
        let modes_of = spectrum.frequencies().iter().zip(spectrum.decays(dashpots)).zip(spectrum.weights());
        let modal: Vec<[f64; 4]> = modes_of
            .map(|((&frequency, decay), weight)| {
                let [[a, b], [c, d]] = oscillator_flight(frequency, decay, time);
                [a, b, c, d].map(|x| weight * x)
            })
            .collect();
        let mut kernels = Vec::with_capacity(along.circle() * across.circle());
        let mut rows = vec![[0.0; 4]; modes];
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
        let mut sum = [0.0; 4];
        for (n, share) in self.along.images(to % length, from % length).into_iter().flatten() {
            for (layer, of_layer) in self.across.images(to / length, from / length).into_iter().flatten() {
                let kernel = &self.kernels[layer * self.along.circle() + n];
                sum.iter_mut().zip(kernel).for_each(|(sum, kernel)| *sum += share * of_layer * kernel);
            }
        }
        let [a, b, c, d] = sum;
        [[a, b], [c, d]]
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

fn sum<'a>(terms: impl Iterator<Item = (&'a [f64; 4], f64)>) -> [f64; 4] {
    terms.fold([0.0; 4], |sum, (term, factor)| std::array::from_fn(|i| sum[i] + term[i] * factor))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::chain::Chain;
    use crate::modes::row::Ends;

    /// Classical fourth-order Runge–Kutta with small steps: shares nothing with the closed form.
    fn integrate(chain: &Chain, dashpots: [f64; 2], u: &mut [f64], v: &mut [f64], time: f64) {
        let (m, steps) = (chain.sites(), 4000);
        let h = time / f64::from(steps);
        let (length, layers) = (chain.length(), chain.layers());
        // Whose displacement stands for the neighbour's beyond an end.
        let beyond = |ends: Ends, own: f64, far: f64| match ends {
            Ends::Closed => far,
            Ends::Free => own,
            Ends::Fixed => 0.0,
        };
        let pulls = |u: &[f64], [ground, along, across]: [f64; 3]| -> Vec<f64> {
            let pull = |n: usize| {
                let (i, l, own) = (n % length, n / length, u[n]);
                let at = |i: usize, l: usize| u[i + l * length];
                let left = if i > 0 { at(i - 1, l) } else { beyond(chain.ends(), own, at(length - 1, l)) };
                let right = if i + 1 < length { at(i + 1, l) } else { beyond(chain.ends(), own, at(0, l)) };
                let below = if l > 0 { at(i, l - 1) } else { beyond(chain.layer_ends(), own, at(i, layers - 1)) };
                let above = if l + 1 < layers { at(i, l + 1) } else { beyond(chain.layer_ends(), own, at(i, 0)) };
                ground * own + along * (2.0 * own - left - right) + across * (2.0 * own - below - above)
            };
            (0..m).map(pull).collect()
        };
        let force = |u: &[f64], v: &[f64]| -> Vec<f64> {
            let springs = pulls(u, [chain.gamma1(), chain.gamma2(), chain.gamma3()]);
            let lost = pulls(v, [dashpots[0], dashpots[1], 0.0]);
            springs.iter().zip(&lost).map(|(spring, lost)| -spring - lost).collect()
        };
        let add = |x: &[f64], k: &[f64], c: f64| -> Vec<f64> { x.iter().zip(k).map(|(x, k)| x + c * k).collect() };
        for _ in 0..steps {
            let (k1, l1) = (v.to_vec(), force(u, v));
            let v2 = add(v, &l1, h / 2.0);
            let (k2, l2) = (v2.clone(), force(&add(u, &k1, h / 2.0), &v2));
            let v3 = add(v, &l2, h / 2.0);
            let (k3, l3) = (v3.clone(), force(&add(u, &k2, h / 2.0), &v3));
            let v4 = add(v, &l3, h);
            let (k4, l4) = (v4.clone(), force(&add(u, &k3, h), &v4));
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
            // Without dashpots, with weak ones, with some that grow, critical ones and overdamped.
            for dashpots in
                [[0.0; 2], [0.05, 0.0], [0.0, 0.3], [-0.1, 0.02], [2.0 * chain.gamma1().sqrt(), 0.0], [3.0, 2.0]]
            {
                let sites = chain.sites();
                let mut u: Vec<f64> = (0..sites).map(|n| (n as f64 * 1.7).sin()).collect();
                let mut v: Vec<f64> = (0..sites).map(|n| (n as f64 * 0.6 + 1.0).cos()).collect();
                let flow = Propagator::with_dashpots(&Spectrum::new(chain), dashpots, 2.3);
                let (mut u1, mut v1) = (vec![0.0; sites], vec![0.0; sites]);
                flow.apply(&u, &v, &mut u1, &mut v1);
                integrate(&chain, dashpots, &mut u, &mut v, 2.3);
                for n in 0..sites {
                    let near = (u[n] - u1[n]).abs() < 1e-11 && (v[n] - v1[n]).abs() < 1e-11;
                    assert!(near, "{chain:?} {dashpots:?} {n}");
                }
            }
        }
    }
}
