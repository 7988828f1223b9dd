//! Any number of impacts a period at one site, with or without force and losses: all multipliers.
//!
//! A perturbation is the sum of what its past impacts made of it. With D_i = S_i − 1 and the periodic propagator
//! G(τ) = Σ_n BᵀR(τ+nT)B z^{−n} over past impacts, det(z−M)/det(z−R) = det(1 − [G(t_i−t_j)D_j]). For each mode
//! R(τ) = e^{iΩτ}wṽ + conj., w = (1, iΩ)ᵀ, ṽ = ½(1, −i/Ω), so that the sum over n is a geometric series with poles at
//! p = e^{iΩT} and p̄. D⁻¹ = −(1+κ'E)/(1+e), and p/(z−p) = ½(z+p)/(z−p) − ½, give the symmetric form
//!
//! ```text
//! f(z) = (1+e)^{2n} det K̂(z),
//! K̂_ij = Σ b² ½(z+p)/(z−p) e^{iΩ(t_i−t_j)} wṽ + conj. ± ½R₀(t_i−t_j) (i ≷ j),   + q/2 + κ'_i E on the diagonal,
//! ```
//!
//! κ' = v̈/((1+e)v⁻), E the entry (velocity, displacement). The pole p_k belongs to one dyad, hence it is simple:
//!
//! ```text
//! f = 1 + Σ ρ_k/(z−p_k) + conj.,   ρ_k = (1+e)^{2n} b_k² p_k Ṽᵀ adj K̂(p_k) W,   W = (e^{iΩt_i}w)_i,  Ṽ = (e^{−iΩt_i}ṽ)_i,
//! ```
//!
//! the own dyad left out of K̂(p_k) (any multiple of it drops out of Ṽᵀ adj K̂ W, a bordered determinant). At z = p_k the
//! other modes' factors are −(i/2)cot(a_k∓a_l), a = ΩT/2. Certificates: f(0) = Πμ = e^{2n} and, for one or two impacts,
//! the trace.

use nalgebra::Complex;
use vibrochain_breather::Orbit;
use vibrochain_lattice::ImpulseResponse;
use wide::f64x4;

use super::aberth::Aberth;
use super::doubt::Doubt;
use super::forced_large::{ForcedLarge, LARGE};
use super::linear::{determinant, determinant_and_condition};
use super::rational::Rational;
use vibrochain_breather::lanes::{Lane, ONE, ZERO, all, fill, four, total};

type C = Complex<f64>;

/// Multipliers of orbits whose impacts are all at one site, from their secular function. Also the work space.
///
/// ```
/// use vibrochain_breather::{Family, Finder, Found};
/// use vibrochain_floquet::SecularMultipliers;
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4, 0.1, 0.9)?;
/// let (mut finder, mut found) = (Finder::new(21), Found::default());
/// finder.find(&model, Family::DoubleSided, &mut found)?;
/// let mut secular = SecularMultipliers::default();
/// secular.set(&found.orbits[0], finder.response())?;
/// let (multipliers, _) = secular.multipliers()?;
/// let radius = multipliers.iter().map(|mu| mu.norm()).fold(0.0, f64::max);
/// assert!(multipliers.len() == 22 && (radius - 1.0016290236374028).abs() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct SecularMultipliers {
    pub(super) form: Rational,
    count: usize,
    residues: Vec<C>,
    angles: Vec<f64>,
    /// t_i, κ'_i
    pub(super) times: Vec<f64>,
    pub(super) kappas: Vec<f64>,
    modes: Modes,
    matrix: Vec<C>,
    sizes: Vec<f64>,
    shared: Vec<f64>,
    sums: Vec<[f64x4; 6]>,
    pub(super) aberth: Aberth,
    pub(super) large: ForcedLarge,
    /// Number of multipliers that are 1: two without force.
    pub(super) trivial: usize,
}

/// What the sums K̂(p_k) need of every mode.
#[derive(Debug, Clone, Default)]
struct Modes {
    half_weight: Vec<Lane>,
    cos: Vec<Lane>,
    sin: Vec<Lane>,
    /// Ω/ω and its inverse.
    ratio: Vec<Lane>,
    inverse: Vec<Lane>,
    /// cos, sin of Ω(t_i−t_j) for i > j: [pair][group of modes]
    turn_cos: Vec<Lane>,
    turn_sin: Vec<Lane>,
}

/// The most impacts a period.
pub(crate) const MOST_IMPACTS: usize = 8;

impl SecularMultipliers {
    /// Takes over an orbit. `response` is that of the orbit's chain and frequency.
    ///
    /// # Errors
    /// [`Doubt::NotReversible`] for impacts at several sites, or more than 8; [`Doubt::Coincident`] where two poles coincide
    /// (γ₂ → 0, a rigid mode, Ω_k ± Ω_l = jω); [`Doubt::Certificate`].
    pub fn set(&mut self, orbit: &Orbit, response: &ImpulseResponse) -> Result<(), Doubt> {
        let impacts = orbit.impacts();
        let n = impacts.len();
        if orbit.impact_site().is_none() || n == 0 || n > MOST_IMPACTS {
            return Err(Doubt::NotReversible);
        }
        self.take_over(orbit);
        let e = orbit.model().restitution();
        self.assemble(e, orbit.model().loss(), response)
    }

    /// Times and saltations.
    pub(super) fn take_over(&mut self, orbit: &Orbit) {
        let e = orbit.model().restitution();
        self.trivial = if orbit.model().is_conservative() { 2 } else { 0 };
        self.times.clear();
        self.times.extend(orbit.impacts().iter().map(|impact| impact.time));
        self.kappas.clear();
        self.kappas.extend(orbit.impacts().iter().map(|i| i.acceleration / ((1.0 + e) * i.velocity_before)));
    }

    /// Residues for the times and saltations taken over.
    pub(super) fn assemble(&mut self, e: f64, q: f64, response: &ImpulseResponse) -> Result<(), Doubt> {
        let n = self.times.len();
        let (frequencies, weights) = (response.frequencies(), response.weights());
        let (cos, sin) = (response.cos_half(), response.sin_half());
        let omega = response.omega();
        self.count = frequencies.len();
        if self.is_large() {
            let data = (self.times.as_slice(), self.kappas.as_slice());
            let outcome = self.large.set(data, (e, q), response, &mut self.residues);
            fill(&mut self.form.pole_re, cos.iter().zip(sin).map(|(c, s)| (c - s) * (c + s)), 1e100);
            fill(&mut self.form.pole_im, cos.iter().zip(sin).map(|(c, s)| 2.0 * s * c), 0.0);
            fill(&mut self.form.residue_error, outcome?.into_iter(), 0.0);
            return Ok(());
        }
        self.modes.set(response, &self.times);
        let size = 2 * n;
        let border = size + 1;
        self.share(q, omega, frequencies, weights);
        let scale = (1.0 + e).powi(size as i32);
        self.residues.clear();
        self.angles.clear();
        for lanes in [&mut self.form.residue_error, &mut self.form.pole_error] {
            fill(lanes, (0..self.count).map(|_| 0.0), 0.0);
        }
        let mut size_of_residues = 0.0;
        let mut total_error = 0.0;
        for k in 0..self.count {
            let (ck, sk, fk) = (cos[k], sin[k], frequencies[k]);
            // The phase carries a relative error of 2ε; differences of poles make it count.
            let phase = fk * response.period();
            self.matrix.clear();
            self.matrix.resize(border * border, C::default());
            for (row, values) in self.shared.chunks_exact(size).enumerate() {
                for (entry, value) in self.matrix[row * border..].iter_mut().zip(values) {
                    *entry = C::new(*value, 0.0);
                }
            }
            let nearest = self.add_others(k, (ck, sk), n)?;
            for i in 0..n {
                let turn = C::from_polar(1.0, fk * (self.times[i] - self.times[0]));
                self.matrix[2 * i * border + size] = turn;
                self.matrix[(2 * i + 1) * border + size] = turn * C::new(0.0, fk / omega);
                self.matrix[size * border + 2 * i] = turn.conj() * 0.5;
                self.matrix[size * border + 2 * i + 1] = turn.conj() * C::new(0.0, -0.5 * omega / fk);
            }
            // Far from ±1 and from other poles nothing much cancels in the determinant; else its own condition tells.
            let others = f64::EPSILON * (16.0 + 2.0 * phase / nearest);
            let (bordered, relative) = if (sk * ck).abs() > SOFT && nearest > CLOSE {
                (determinant(&mut self.matrix, border), others)
            } else {
                let (bordered, condition) = determinant_and_condition(&mut self.matrix, &mut self.sizes, border);
                (bordered, others * condition.max(1.0))
            };
            // Ṽᵀ adj K̂ W = −det [[K̂, W], [Ṽᵀ, 0]]
            let pole = C::new((ck - sk) * (ck + sk), 2.0 * sk * ck);
            let residue = -bordered * pole * (scale * weights[k]);
            let modulus = residue.norm_sqr().sqrt();
            size_of_residues += modulus;
            let error = modulus * relative;
            total_error += error;
            self.form.residue_error.as_flattened_mut()[k] = error;
            self.form.pole_error.as_flattened_mut()[k] = modulus * f64::EPSILON * (2.0 + 2.0 * phase);
            self.residues.push(residue);
            self.angles.push(pole.im.atan2(pole.re).abs());
        }
        let residues = &self.residues;
        let poles = |k: usize| C::new((cos[k] - sin[k]) * (cos[k] + sin[k]), 2.0 * sin[k] * cos[k]);
        fill(&mut self.form.pole_re, (0..self.count).map(|k| poles(k).re), 1e100);
        fill(&mut self.form.pole_im, (0..self.count).map(|k| poles(k).im), 0.0);
        fill(&mut self.form.residue_re, residues.iter().map(|r| r.re), 0.0);
        fill(&mut self.form.residue_im, residues.iter().map(|r| r.im), 0.0);
        // f(0) = e^{2n}
        let product: f64 = (0..self.count).map(|k| 2.0 * (residues[k] * poles(k).conj()).re).sum();
        let defect = (1.0 - product - e.powi(size as i32)).abs();
        let allowed = 16.0 * (total_error + 16.0 * f64::EPSILON * (1.0 + size_of_residues));
        if defect <= allowed && allowed < 1.0 + size_of_residues {
            Ok(())
        } else {
            Err(Doubt::Certificate { defect, allowed })
        }
    }

    /// Cauchy sums are faster than pairs of modes.
    pub(super) fn is_large(&self) -> bool {
        self.count > LARGE
    }

    /// What all K̂ share: propagators over the times between impacts, losses, saltations. Velocities in units of ω.
    fn share(&mut self, q: f64, omega: f64, frequencies: &[f64], weights: &[f64]) {
        let n = self.times.len();
        let size = 2 * n;
        let shared = &mut self.shared;
        shared.clear();
        shared.resize(size * size, 0.0);
        for i in 0..n {
            shared[2 * i * size + 2 * i] = 0.5 * q;
            shared[(2 * i + 1) * size + 2 * i + 1] = 0.5 * q;
            shared[(2 * i + 1) * size + 2 * i] = self.kappas[i] / omega;
        }
        for (i, j, pair) in pairs(n) {
            let (cos, sin) = self.modes.turns(pair);
            let (mut c, mut up, mut down) = (0.0, 0.0, 0.0);
            for l in 0..self.count {
                let (w, f, turn) = (0.5 * weights[l], frequencies[l], sin.as_flattened()[l]);
                c += w * cos.as_flattened()[l];
                up += w * turn / f * omega;
                down -= w * turn * f / omega;
            }
            // R₀(−τ) comes with the opposite sign.
            for (row, column, sign) in [(i, j, 1.0), (j, i, -1.0)] {
                let at = 2 * row * size + 2 * column;
                (shared[at], shared[at + size + 1]) = (sign * c, sign * c);
                (shared[at + 1], shared[at + size]) = (up, down);
            }
        }
    }

    /// Adds the other modes' part of K̂(p_k): sums of b²(U, V), U, V = ½(cot(a_k−a_l) ± cot(a_k+a_l)), with
    /// −(i/2)(U cos + iV sin) and −½(V cos + iU sin) × (1/Ω, −Ω). Returns the smallest |sin(a_k±a_l)|.
    fn add_others(&mut self, k: usize, (ck, sk): (f64, f64), n: usize) -> Result<f64, Doubt> {
        let Modes { half_weight, cos, sin, ratio, inverse, turn_cos, turn_sin } = &self.modes;
        let groups = cos.len();
        let (ck, sk) = (all(ck), all(sk));
        let border = 2 * n + 1;
        let mut own = [ZERO; 3];
        let shared = &mut self.sums;
        shared.clear();
        shared.resize(n * (n - 1) / 2, [ZERO; 6]);
        let (mut coincident, mut nearest) = (ZERO, ONE);
        for g in 0..groups {
            let (c, s) = (four(cos[g]), four(sin[g]));
            let (a, b) = (sk * c, ck * s);
            let (minus, plus) = (a - b, a + b);
            let same = minus.simd_eq(ZERO);
            coincident += same.select(ONE, ZERO);
            nearest = nearest.min(same.select(ONE, minus.abs())).min(plus.abs());
            let (cc, ss) = (ck * c, sk * s);
            let cot_minus = same.select(ZERO, (cc + ss) / same.select(ONE, minus));
            let cot_plus = (cc - ss) / plus;
            let w = four(half_weight[g]);
            let (u, v) = (w * (cot_minus + cot_plus), w * (cot_minus - cot_plus));
            let (up, down) = (four(inverse[g]), four(ratio[g]));
            own[0] += u;
            own[1] += v * up;
            own[2] += v * down;
            for (pair, sums) in shared.iter_mut().enumerate() {
                let (c, s) = (four(turn_cos[pair * groups + g]), four(turn_sin[pair * groups + g]));
                let (uc, us, vc, vs) = (u * c, u * s, v * c, v * s);
                for (sum, term) in sums.iter_mut().zip([uc, vs, vc * up, us * up, vc * down, us * down]) {
                    *sum += term;
                }
            }
        }
        let nearest = nearest.to_array().into_iter().fold(f64::INFINITY, f64::min);
        // It meets itself once.
        if total(coincident) != 1.0 || nearest == 0.0 {
            return Err(Doubt::Coincident { mode: k });
        }
        let own = own.map(|sum| 0.5 * total(sum));
        let mut add = |i: usize, j: usize, [a, b, c]: [C; 3]| {
            let at = 2 * i * border + 2 * j;
            self.matrix[at] += a;
            self.matrix[at + border + 1] += a;
            self.matrix[at + 1] += b;
            self.matrix[at + border] += c;
        };
        for i in 0..n {
            add(i, i, [C::new(0.0, -own[0]), C::new(-own[1], 0.0), C::new(own[2], 0.0)]);
        }
        for (i, j, pair) in pairs(n) {
            let [uc, vs, vc_up, us_up, vc_down, us_down] = shared[pair].map(|sum| 0.5 * total(sum));
            for (i, j, sign) in [(i, j, 1.0), (j, i, -1.0)] {
                let even = C::new(sign * vs, -uc);
                add(i, j, [even, C::new(-vc_up, -sign * us_up), C::new(vc_down, sign * us_down)]);
            }
        }
        Ok(nearest)
    }

    /// Poles e^{iΩ_kT} of f in the order of the modes; each has its conjugate.
    pub fn poles(&self) -> impl Iterator<Item = Complex<f64>> + '_ {
        let (re, im) = (self.form.pole_re.as_flattened(), self.form.pole_im.as_flattened());
        re.iter().zip(im).take(self.count).map(|(re, im)| C::new(*re, *im))
    }

    /// Residues ρ_k of f.
    pub fn residues(&self) -> &[Complex<f64>] {
        &self.residues
    }

    /// tr M = Σ2 cos Ω_kT − 2ReΣρ_k on the even subspace.
    pub fn trace(&self) -> f64 {
        self.poles().zip(&self.residues).map(|(p, r)| 2.0 * (p.re - r.re)).sum()
    }

    /// All 2m multipliers of the even subspace, in no order but that a conservative orbit's trivial pair comes first, with estimates of
    /// their errors.
    ///
    /// # Errors
    /// [`Doubt::Incomplete`] if the iteration does not settle; [`Doubt::Certificate`] if their sum is not the trace.
    pub fn multipliers(&mut self) -> Result<(&[Complex<f64>], &[f64]), Doubt> {
        let trace = self.trace();
        let (roots, errors) = if self.is_large() {
            self.large.solve(self.trivial)?;
            (&self.large.roots.values, &self.large.roots.errors)
        } else {
            let mut aberth = std::mem::take(&mut self.aberth);
            let outcome = aberth.solve(&self.form, &self.angles, self.trivial);
            self.aberth = aberth;
            outcome?;
            (&self.aberth.roots, &self.aberth.errors)
        };
        let sum: f64 = roots.iter().map(|z| z.re).sum();
        let size: f64 = roots.iter().map(|z| z.norm()).sum();
        let slack: f64 = errors.iter().sum();
        let defect = (sum - trace).abs();
        let own: f64 = self.form.residue_error.iter().flatten().sum();
        let allowed = 16.0 * (slack + own + f64::EPSILON * size);
        if defect <= allowed.max(1e-9 * size) {
            Ok((roots, errors))
        } else {
            Err(Doubt::Certificate { defect, allowed })
        }
    }
}

/// Below this |sin Ω_kT|/2, p and p̄ are so close that sums over modes may cancel to second order.
const SOFT: f64 = 0.05;

/// Poles this close make a residue worth its condition number.
const CLOSE: f64 = 1e-3;

/// Pairs i > j of impacts and their numbers.
fn pairs(n: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    (1..n).flat_map(|i| (0..i).map(move |j| (i, j, i * (i - 1) / 2 + j)))
}

impl Modes {
    fn set(&mut self, response: &ImpulseResponse, times: &[f64]) {
        let frequencies = response.frequencies();
        let omega = response.omega();
        fill(&mut self.half_weight, response.weights().iter().map(|w| 0.5 * w), 0.0);
        // A mode that is none: no pole meets it.
        fill(&mut self.cos, response.cos_half().iter().copied(), 2.0);
        fill(&mut self.sin, response.sin_half().iter().copied(), 0.0);
        fill(&mut self.ratio, frequencies.iter().map(|f| f / omega), 0.0);
        fill(&mut self.inverse, frequencies.iter().map(|f| omega / f), 0.0);
        let groups = self.cos.len();
        let impacts = times.len();
        self.turn_cos.clear();
        self.turn_sin.clear();
        for (i, j, pair) in pairs(impacts) {
            self.turn_cos.resize((pair + 1) * groups, [0.0; 4]);
            self.turn_sin.resize((pair + 1) * groups, [0.0; 4]);
            let elapsed = times[i] - times[j];
            for (l, f) in frequencies.iter().enumerate() {
                let (sin, cos) = (f * elapsed).sin_cos();
                self.turn_cos.as_flattened_mut()[4 * pair * groups + l] = cos;
                self.turn_sin.as_flattened_mut()[4 * pair * groups + l] = sin;
            }
        }
    }

    fn turns(&self, pair: usize) -> (&[Lane], &[Lane]) {
        let groups = self.cos.len();
        let range = pair * groups..(pair + 1) * groups;
        (&self.turn_cos[range.clone()], &self.turn_sin[range])
    }
}
