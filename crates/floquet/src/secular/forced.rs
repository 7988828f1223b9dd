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

use super::aberth::Aberth;
use super::doubt::Doubt;
use super::lanes::{Lane, fill};

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
    /// p and ρ
    pub(crate) pole_re: Vec<Lane>,
    pub(crate) pole_im: Vec<Lane>,
    pub(crate) residue_re: Vec<Lane>,
    pub(crate) residue_im: Vec<Lane>,
    count: usize,
    /// Relative error of the residues.
    pub(crate) blur: f64,
    residues: Vec<C>,
    angles: Vec<f64>,
    times: Vec<f64>,
    kappas: Vec<f64>,
    /// cos, sin of Ω_l(t_i−t_j) for i > j: [pair][mode]
    turns: Vec<(f64, f64)>,
    matrix: Vec<C>,
    aberth: Aberth,
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
        let (e, q) = (orbit.model().restitution(), orbit.model().loss());
        self.times.clear();
        self.times.extend(impacts.iter().map(|impact| impact.time));
        self.kappas.clear();
        self.kappas.extend(impacts.iter().map(|i| i.acceleration / ((1.0 + e) * i.velocity_before)));
        let (frequencies, weights) = (response.frequencies(), response.weights());
        let (cos, sin) = (response.cos_half(), response.sin_half());
        let omega = response.omega();
        self.count = frequencies.len();
        self.turns.clear();
        for i in 1..n {
            for j in 0..i {
                let elapsed = self.times[i] - self.times[j];
                self.turns.extend(frequencies.iter().map(|f| {
                    let (sin, cos) = (f * elapsed).sin_cos();
                    (cos, sin)
                }));
            }
        }
        // What all K̂ share: propagators over the times between impacts, losses, saltations. Velocities in units of ω.
        let size = 2 * n;
        let border = size + 1;
        let mut shared = [C::default(); 4 * MOST_IMPACTS * MOST_IMPACTS];
        for i in 0..n {
            for (a, entry) in [(0, 0.5 * q), (1, 0.5 * q)] {
                shared[(2 * i + a) * size + 2 * i + a] = C::new(entry, 0.0);
            }
            shared[(2 * i + 1) * size + 2 * i] = C::new(self.kappas[i] / omega, 0.0);
        }
        let mut pair = 0;
        for i in 1..n {
            for j in 0..i {
                let mut free = [0.0; 3];
                for (l, &(c, s)) in self.turns[pair * self.count..(pair + 1) * self.count].iter().enumerate() {
                    let (w, f) = (weights[l], frequencies[l]);
                    free[0] += w * c;
                    free[1] += w * s / f * omega;
                    free[2] -= w * s * f / omega;
                }
                let mut put = |i: usize, j: usize, m: [f64; 4]| {
                    for (entry, value) in [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter().zip(m) {
                        shared[(2 * i + entry.0) * size + 2 * j + entry.1] += C::new(value, 0.0);
                    }
                };
                let [c, up, down] = free.map(|x| 0.5 * x);
                put(i, j, [c, up, down, c]);
                // R₀(−τ), with the opposite sign.
                put(j, i, [-c, up, down, -c]);
                pair += 1;
            }
        }
        let scale = (1.0 + e).powi(size as i32);
        self.residues.clear();
        self.angles.clear();
        let mut size_of_residues = 0.0;
        for k in 0..self.count {
            let (ck, sk, fk) = (cos[k], sin[k], frequencies[k]);
            self.matrix.clear();
            self.matrix.resize(border * border, C::default());
            for (row, values) in shared[..size * size].chunks_exact(size).enumerate() {
                self.matrix[row * border..row * border + size].copy_from_slice(values);
            }
            // Sums over the other modes of b²(U, V), U, V = ½(cot(a_k−a_l) ± cot(a_k+a_l)): one for each pair of impacts, the
            // diagonal first.
            for l in 0..self.count {
                let (cl, sl, fl, w) = (cos[l], sin[l], frequencies[l], weights[l]);
                let (minus, plus) = (sk * cl - ck * sl, sk * cl + ck * sl);
                let cot_plus = (ck * cl - sk * sl) / plus;
                let cot_minus = if l == k { 0.0 } else { (ck * cl + sk * sl) / minus };
                if plus == 0.0 || (l != k && minus == 0.0) {
                    return Err(Doubt::Coincident { mode: k });
                }
                let (u, v) = (0.5 * w * (cot_minus + cot_plus), 0.5 * w * (cot_minus - cot_plus));
                let (ratio, inverse) = (fl / omega, omega / fl);
                for i in 0..n {
                    for j in 0..n {
                        let (c, s) = if i == j {
                            (1.0, 0.0)
                        } else {
                            let (high, low) = (i.max(j), i.min(j));
                            let (c, s) = self.turns[(high * (high - 1) / 2 + low) * self.count + l];
                            (c, if i > j { s } else { -s })
                        };
                        // −(i/2)(U cos + iV sin) and −½(V cos + iU sin) × (1/Ω, −Ω)
                        let even = C::new(v * s, -u * c);
                        let odd = C::new(-v * c, -u * s);
                        let at = |a: usize, b: usize| (2 * i + a) * border + 2 * j + b;
                        self.matrix[at(0, 0)] += even * 0.5;
                        self.matrix[at(1, 1)] += even * 0.5;
                        self.matrix[at(0, 1)] += odd * (0.5 * inverse);
                        self.matrix[at(1, 0)] -= odd * (0.5 * ratio);
                    }
                }
            }
            for i in 0..n {
                let phase = C::from_polar(1.0, fk * (self.times[i] - self.times[0]));
                self.matrix[2 * i * border + size] = phase;
                self.matrix[(2 * i + 1) * border + size] = phase * C::new(0.0, fk / omega);
                self.matrix[size * border + 2 * i] = phase.conj() * 0.5;
                self.matrix[size * border + 2 * i + 1] = phase.conj() * C::new(0.0, -0.5 * omega / fk);
            }
            // Ṽᵀ adj K̂ W = −det [[K̂, W], [Ṽᵀ, 0]]
            let bordered = determinant(&mut self.matrix, border);
            let pole = C::new((ck - sk) * (ck + sk), 2.0 * sk * ck);
            let residue = -bordered * pole * (scale * weights[k]);
            size_of_residues += residue.norm();
            self.residues.push(residue);
            self.angles.push(pole.im.atan2(pole.re).abs());
        }
        // Phases carry a relative error of 2ε; differences of poles make it count.
        let mut nearest = f64::INFINITY;
        for k in 0..self.count {
            nearest = nearest.min(2.0 * (sin[k] * cos[k]).abs());
            for l in 0..k {
                nearest = nearest.min((sin[k] * cos[l] - cos[k] * sin[l]).abs());
                nearest = nearest.min((sin[k] * cos[l] + cos[k] * sin[l]).abs());
            }
        }
        let turns = frequencies.iter().copied().fold(0.0, f64::max) / omega;
        self.blur = f64::EPSILON * (16.0 + 8.0 * turns / nearest);
        let residues = &self.residues;
        let poles = |k: usize| C::new((cos[k] - sin[k]) * (cos[k] + sin[k]), 2.0 * sin[k] * cos[k]);
        fill(&mut self.pole_re, (0..self.count).map(|k| poles(k).re), 1e100);
        fill(&mut self.pole_im, (0..self.count).map(|k| poles(k).im), 0.0);
        fill(&mut self.residue_re, residues.iter().map(|r| r.re), 0.0);
        fill(&mut self.residue_im, residues.iter().map(|r| r.im), 0.0);
        // f(0) = e^{2n}
        let product: f64 = (0..self.count).map(|k| 2.0 * (residues[k] * poles(k).conj()).re).sum();
        let defect = (1.0 - product - e.powi(size as i32)).abs();
        let allowed = 256.0 * self.blur * (1.0 + size_of_residues);
        if defect <= allowed && allowed < 1.0 + size_of_residues {
            Ok(())
        } else {
            Err(Doubt::Certificate { defect, allowed })
        }
    }

    /// Poles e^{iΩ_kT} of f in the order of the modes; each has its conjugate.
    pub fn poles(&self) -> impl Iterator<Item = Complex<f64>> + '_ {
        let (re, im) = (self.pole_re.as_flattened(), self.pole_im.as_flattened());
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

    /// All 2m multipliers of the even subspace, in no order, with estimates of their errors. A conservative orbit's trivial
    /// pair is among them.
    ///
    /// # Errors
    /// [`Doubt::Incomplete`] if the iteration does not settle; [`Doubt::Certificate`] if their sum is not the trace.
    pub fn multipliers(&mut self) -> Result<(&[Complex<f64>], &[f64]), Doubt> {
        let mut aberth = std::mem::take(&mut self.aberth);
        let outcome = aberth.solve(self, &self.angles);
        let trace = self.trace();
        self.aberth = aberth;
        outcome?;
        let sum: f64 = self.aberth.roots.iter().map(|z| z.re).sum();
        let size: f64 = self.aberth.roots.iter().map(|z| z.norm()).sum();
        let slack: f64 = self.aberth.errors.iter().sum();
        let defect = (sum - trace).abs();
        let allowed = 16.0 * (slack + self.blur * size);
        if defect <= allowed.max(1e-9 * size) {
            Ok((&self.aberth.roots, &self.aberth.errors))
        } else {
            Err(Doubt::Certificate { defect, allowed })
        }
    }
}

/// Determinant by elimination with partial pivoting; the matrix is used up.
fn determinant(matrix: &mut [C], size: usize) -> C {
    let mut product = C::new(1.0, 0.0);
    for column in 0..size {
        let (mut pivot, mut largest) = (column, 0.0);
        for row in column..size {
            let modulus = matrix[row * size + column].norm_sqr();
            if modulus > largest {
                (pivot, largest) = (row, modulus);
            }
        }
        if largest == 0.0 {
            return C::default();
        }
        if pivot != column {
            for j in column..size {
                matrix.swap(pivot * size + j, column * size + j);
            }
            product = -product;
        }
        let diagonal = matrix[column * size + column];
        product *= diagonal;
        let inverse = diagonal.inv();
        for row in column + 1..size {
            let factor = matrix[row * size + column] * inverse;
            for j in column + 1..size {
                let above = matrix[column * size + j];
                matrix[row * size + j] -= factor * above;
            }
        }
    }
    product
}
