//! The matrix from impact to impact: all that the multipliers of an orbit are, whatever its word.
//!
//! A perturbation is the sum of what its past impacts made of it. With D_i = S_i − 1 and the periodic propagator between the sites that
//! impacts i and j hit, G_ij(τ) = Σ_n B_iᵀR(τ+nT)B_j z^{−n} over past impacts, det(z−M)/det(z−R) = det(1 − [G_ij(t_i−t_j)D_j]). For a mode
//! of shape φ, normalised so that Σ b²φ_iφ_j over all modes is 1 for i = j and 0 for other sites, R(τ) = e^{iΩτ}wṽ + conj.,
//! w = (1, iΩ)ᵀ, ṽ = ½(1, −i/Ω), so that the sum over n is a geometric series with poles at p = e^{iΩT} and p̄. D⁻¹ = −(1+κ'E)/(1+e)
//! leaves
//!
//! ```text
//! f(z) = det(z−M)/det(z−R) = (1+e)^{2n} det K̂(z),
//! K̂_ij = Σ b²φ_iφ_j [p/(z−p) or z/(z−p)] e^{iΩ(t_i−t_j)} wṽ + conj.,    p for i ≤ j, z for i > j,    + ½(1+q) + κ'_iE for i = j
//!      = Σ b²φ_iφ_j ½(z+p)/(z−p) e^{iΩ(t_i−t_j)} wṽ + conj. ± ½R_ij(t_i−t_j) (i ≷ j),                  + q/2 + κ'_iE for i = j,
//! ```
//!
//! q = (1−e)/(1+e), κ' = κ/(1+e)² = v̈/((1+e)v⁻) ([`Saltation::reduced`]), E the entry (velocity, displacement), velocities in units of ω.
//! A null vector of K̂(z) is D_jy_j, what the impacts do to the perturbation y_j that belongs to the multiplier z.
//!
//! Of one site all modes of one frequency are one, of weight Σφ² ([`crate::map_paths::modes::Modes::set_felt`]). Of several sites on a ring the shape of
//! mode k is cos(2πk(n_i−n_1)/M); each of its doublets has a second mode, sin(2πk(n_i−n_1)/M). On other lattices the products φ_iφ_j of a
//! mode, or their sum over a doublet, are known ([`Shapes::even`]); their pivoted Cholesky factors are as good as shapes.
//!
//! Other files have the same determinant, worked out in ways that are faster or know more digits where they apply:
//!
//! | file | f for |
//! |---|---|
//! | `multipliers`, `fast_sums` | impacts at one site, by poles and residues; K̂(p_k) from real sums |
//! | `crate::spectrum` | any impacts between the contacts of any structure |
//! | `single_sided`, `double_sided` | reversible orbits in ν = ½(z + 1/z), the trivial pair divided out |
//! | `crate::symmetry` | half a period of a symmetric orbit, at real z |
//! | `crate::stripes` | the same as sums over the waves that impacts reflect |

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_breather::{Impact, Prepared};
use vibrochain_lattice::Shapes;

use crate::map_paths::modes::{Mode, Modes};
use crate::saltation::Saltation;

type C = Complex<f64>;

/// K̂ of one orbit; also the work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct ImpactMatrix {
    pub(crate) impacts: usize,
    pub(crate) half_loss: f64,
    /// κ'_i/ω
    pub(crate) kappas: Vec<f64>,
    /// Longest time since the first impact.
    pub(crate) longest: f64,
    pub(crate) modes: Vec<FeltMode>,
    felt: Modes,
    /// φ_i e^{iΩ(t_i−t_1)}: [mode][impact]
    pub(crate) waves: Vec<C>,
    /// K̂ as last worked out, by rows.
    pub(crate) entries: Vec<C>,
    pub(crate) scales: Vec<f64>,
    pub(crate) moduli: Vec<f64>,
    pub(crate) left: Vec<C>,
    pub(crate) right: Vec<C>,
}

/// A mode that the impacts feel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FeltMode {
    pub(crate) pole: C,
    pub(crate) weight: f64,
    pub(crate) frequency: f64,
    /// Ω/ω
    pub(crate) ratio: f64,
    /// Of the pole.
    pub(crate) error: f64,
    /// Of φ_i, against the largest.
    pub(crate) shape_error: f64,
}

impl ImpactMatrix {
    /// Takes over an orbit.
    pub(crate) fn set(&mut self, prepared: Prepared<'_>) {
        let (orbit, response) = (prepared.orbit(), prepared.response());
        let (impacts, omega) = (orbit.impacts(), response.omega());
        let e = orbit.model().restitution();
        self.impacts = impacts.len();
        self.half_loss = 0.5 * orbit.model().loss();
        self.kappas.clear();
        self.kappas.extend(impacts.iter().map(|impact| Saltation::reduced(impact, e) / omega));
        let (first, home) = impacts.first().map_or((0.0, 0), |impact| (impact.time, impact.site));
        self.longest = impacts.iter().map(|impact| impact.time - first).fold(0.0, f64::max);
        self.modes.clear();
        self.waves.clear();
        let shapes = response.shapes();
        let (at_one_site, ring) = (orbit.impact_site().is_some(), orbit.model().chain().is_ring());
        self.felt.set_felt(prepared);
        for (k, mode) in self.felt.list().iter().enumerate() {
            let &Mode { frequency, weight, .. } = mode;
            let mode = FeltMode {
                pole: mode.pole(),
                weight,
                frequency,
                ratio: frequency / omega,
                // The phase carries a relative error of 2ε.
                error: f64::EPSILON * (2.0 + 2.0 * frequency * response.period()),
                shape_error: 0.5 * self.felt.blur(k),
            };
            let turn = |time: f64| C::from_polar(1.0, frequency * (time - first));
            if at_one_site {
                self.modes.push(mode);
                self.waves.extend(impacts.iter().map(|impact| turn(impact.time)));
                continue;
            }
            if !ring {
                for shape in factors(shapes, k, impacts) {
                    let largest = shape.iter().fold(0.0_f64, |largest, phi| largest.max(phi.abs()));
                    self.modes.push(FeltMode { shape_error: 4.0 * f64::EPSILON / (largest * largest), ..mode });
                    self.waves.extend(impacts.iter().zip(shape).map(|(impact, phi)| turn(impact.time) * phi));
                }
                continue;
            }
            let wave = |shape: fn(&Shapes, usize, usize, usize) -> f64| {
                impacts.iter().map(move |impact| turn(impact.time) * shape(shapes, k, impact.site, home))
            };
            self.modes.push(mode);
            self.waves.extend(wave(Shapes::even));
            if wave(Shapes::odd).any(|wave| wave != C::default()) {
                self.modes.push(mode);
                self.waves.extend(wave(Shapes::odd));
            }
        }
    }

    /// ½(q ± 1): on the diagonal, by which factor the modes have there.
    pub(crate) fn even(&self, outside: bool) -> f64 {
        if outside { self.half_loss + 0.5 } else { self.half_loss - 0.5 }
    }

    /// Works out K̂(z); `None` at a pole.
    pub(crate) fn fill(&mut self, z: C) -> Option<()> {
        let n = self.impacts;
        let size = 2 * n;
        let outside = z.norm_sqr() >= 1.0;
        self.entries.clear();
        self.entries.resize(size * size, C::default());
        for (mode, waves) in self.modes.iter().zip(self.waves.chunks_exact(n)) {
            let [(plus, _), (minus, _)] = mode.distances(z)?;
            let (up, down) = (0.5 / mode.ratio, 0.5 * mode.ratio);
            for i in 0..n {
                for j in 0..n {
                    let factor = |pole: C| if i > j || (i == j && !outside) { z } else { pole };
                    let wave = waves[i] * waves[j].conj();
                    let forth = factor(mode.pole) * plus * wave * mode.weight;
                    let back = factor(mode.pole.conj()) * minus * wave.conj() * mode.weight;
                    let (even, odd) = ((forth + back) * 0.5, (forth - back) * C::new(0.0, 1.0));
                    let at = 2 * i * size + 2 * j;
                    self.entries[at] += even;
                    self.entries[at + size + 1] += even;
                    self.entries[at + 1] -= odd * up;
                    self.entries[at + size] += odd * down;
                }
            }
        }
        let even = self.even(outside);
        for (i, kappa) in self.kappas.iter().enumerate() {
            let at = 2 * i * size + 2 * i;
            self.entries[at] += even;
            self.entries[at + size + 1] += even;
            self.entries[at + size] += *kappa;
        }
        Some(())
    }

    /// |1 − p/z||1 − p̄/z| of the nearest pair of poles: about twice the distance to a pole on the circle.
    pub(crate) fn nearest_poles(&self, z: C) -> f64 {
        let distance = |mode: &FeltMode| ((z - mode.pole) * (z - mode.pole.conj())).norm_sqr();
        self.modes.iter().map(distance).fold(f64::INFINITY, f64::min).sqrt() / z.norm_sqr()
    }
}

/// Shapes at the impacts whose products are those of mode `k`, as many as it has that the impacts feel.
fn factors(shapes: &Shapes, k: usize, impacts: &[Impact]) -> SmallVec<[SmallVec<[f64; 4]>; 1]> {
    let product = |i: usize, j: usize| shapes.even(k, impacts[i].site, impacts[j].site);
    let mut found: SmallVec<[SmallVec<[f64; 4]>; 1]> = SmallVec::new();
    loop {
        let rest = |i: usize, j: usize| product(i, j) - found.iter().map(|phi| phi[i] * phi[j]).sum::<f64>();
        let pivot = (0..impacts.len()).map(|i| (i, rest(i, i))).max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((pivot, square)) = pivot.filter(|(_, square)| !Modes::is_spared(*square)) else { return found };
        let scale = square.sqrt().recip();
        let next = (0..impacts.len()).map(|i| rest(i, pivot) * scale).collect();
        found.push(next);
    }
}

impl FeltMode {
    /// 1/(z−p) and 1/(z−p̄) and their moduli, but at a pole.
    pub(crate) fn distances(&self, z: C) -> Option<[(C, f64); 2]> {
        let inverse = |pole: C| {
            let distance = z - pole;
            let square = distance.norm_sqr();
            (square > 0.0).then(|| (distance.conj() / square, square.sqrt().recip()))
        };
        Some([inverse(self.pole)?, inverse(self.pole.conj())?])
    }
}
