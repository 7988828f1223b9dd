//! Any number of impacts a period at one site, with or without force and losses: all multipliers.
//!
//! f(z) = det(z−M)/det(z−R) = (1+e)^{2n} det J(z) ([`vibrochain_breather::BlochEquations`]). With q = (1−e)/(1+e), κ' = κ/(1+e)² = v̈/((1+e)v⁻)
//! ([`Saltation::reduced`]), E the entry (velocity, displacement), velocities in units of ω, Σb² = 1, w = (1, iΩ)ᵀ, ṽ = ½(1, −i/Ω), J is, but for
//! the order of its rows,
//!
//! ```text
//! K̂_ij = Σ b² ½(z+p)/(z−p) e^{iΩ(t_i−t_j)} wṽ + conj. ± ½R_ij(t_i−t_j) (i ≷ j),      + q/2 + κ'_iE for i = j,
//! ```
//!
//! and the pole p_k = e^{iΩT} belongs to one dyad, hence it is simple:
//!
//! ```text
//! f = 1 + Σ ρ_k/(z−p_k) + conj.,   ρ_k = (1+e)^{2n} b_k² p_k Ṽᵀ adj K̂(p_k) W,   W = (e^{iΩt_i}w)_i,  Ṽ = (e^{−iΩt_i}ṽ)_i,
//! ```
//!
//! the own dyad left out of K̂(p_k) (any multiple of it drops out of Ṽᵀ adj K̂ W, a bordered determinant; [`crate::map_paths::one_contact::other_modes`] has the
//! rest). Certificates: f(0) = Πμ = e^{2n} and, for one or two impacts, the trace.

use nalgebra::Complex;
use vibrochain_breather::linear::{determinant, determinant_and_condition};
use vibrochain_breather::{Orbit, Prepared};
use vibrochain_lattice::simd::lanes::{LANES, all, fill};

use crate::map_paths::fast_sums::large_general::{self, ForcedLarge};
use crate::map_paths::modes::{Mode, Modes};
use crate::map_paths::one_contact::four_poles;
use crate::map_paths::one_contact::other_modes::{OtherModes, PoleSums};
use crate::saltation::Saltation;
use crate::sizes::LARGE;
use crate::zeros::Rational;
use crate::zeros::SecularError;
use crate::zeros::modulus;
use crate::zeros::{Aberth, Start};

type C = Complex<f64>;

/// Multipliers of orbits whose impacts are all at one site, from their secular function. Also the work space.
///
/// ```
/// use vibrochain_breather::{Family, Finder, OrbitList};
/// use vibrochain_floquet::SecularMultipliers;
/// use vibrochain_lattice::Point;
/// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
/// let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model()?;
/// let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
/// finder.find(&model, Family::DoubleSided, &mut found)?;
/// let mut secular = SecularMultipliers::default();
/// secular.replace(finder.prepared(&found.orbits[0])?)?;
/// let (multipliers, _) = secular.multipliers()?;
/// let radius = multipliers.iter().map(|mu| mu.norm()).fold(0.0, f64::max);
/// assert!(multipliers.len() == 22 && (radius - 1.0016290236374028).abs() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct SecularMultipliers {
    pub(crate) form: Rational,
    count: usize,
    residues: Vec<C>,
    angles: Vec<f64>,
    /// t_i, κ'_i
    pub(crate) times: Vec<f64>,
    pub(crate) kappas: Vec<f64>,
    felt: Modes,
    modes: OtherModes,
    matrix: Vec<C>,
    sizes: Vec<f64>,
    shared: Vec<f64>,
    pub(crate) aberth: Aberth,
    pub(crate) large: ForcedLarge,
    /// Some poles are so close together that steps of the iteration say little of what is left between them.
    crowded: bool,
    /// Number of multipliers that are 1: two without force.
    pub(crate) trivial: usize,
}

/// The most impacts a period: elimination has room for two rows each without allocating. On 101 masses residues took 20 µs for one impact and
/// 35 for two. Sums are kept for each pair of impacts, 28 of 8 and 3160 of ten times as many, and rows are eliminated in their cube.
const MOST_IMPACTS: usize = 8;

impl SecularMultipliers {
    /// Takes over an orbit. After an error there is nothing of it, nor of the one before.
    ///
    /// # Errors
    /// [`SecularError::NotReversible`] for impacts at several sites, or more than 8; [`SecularError::Coincident`] where two poles coincide
    /// (γ₂ → 0, a rigid mode, Ω_k ± Ω_l = jω); [`SecularError::Certificate`].
    pub fn replace(&mut self, prepared: Prepared<'_>) -> Result<(), SecularError> {
        let orbit = prepared.orbit();
        let n = orbit.impacts().len();
        if orbit.impact_site().is_none() || n == 0 || n > MOST_IMPACTS {
            return Err(SecularError::NotReversible);
        }
        self.take_over(orbit);
        self.assemble(prepared)
    }

    /// Times and saltations.
    pub(crate) fn take_over(&mut self, orbit: &Orbit) {
        let e = orbit.model().restitution();
        self.trivial = if orbit.model().is_conservative() { 2 } else { 0 };
        self.times.clear();
        self.times.extend(orbit.impacts().iter().map(|impact| impact.time));
        self.kappas.clear();
        self.kappas.extend(orbit.impacts().iter().map(|impact| Saltation::reduced(impact, e)));
    }

    /// Residues of the orbit for the times and saltations taken over.
    pub(crate) fn assemble(&mut self, prepared: Prepared<'_>) -> Result<(), SecularError> {
        let (model, response) = (prepared.orbit().model(), prepared.response());
        let (e, q) = (model.restitution(), model.loss());
        let n = self.times.len();
        let omega = response.omega();
        self.felt.set_felt(prepared);
        self.count = self.felt.count();
        self.modes.set(&self.felt, omega, &self.times);
        let border = 2 * n + 1;
        self.modes.shared(q, &self.kappas, (&self.felt, omega), &mut self.shared);
        let large = self.is_large();
        let by_cauchy = if large { large_general::sums(&self.felt, omega, &self.modes, n)? } else { Vec::new() };
        let scale = (1.0 + e).powi(2 * n as i32);
        self.residues.clear();
        self.angles.clear();
        for lanes in [&mut self.form.residue_error, &mut self.form.pole_error] {
            fill(lanes, (0..self.count).map(|_| 0.0), 0.0);
        }
        let mut size_of_residues = 0.0;
        let mut total_error = 0.0;
        let mut four = None;
        self.crowded = false;
        for k in 0..self.count {
            if k % LANES == 0 && !large {
                let group = self.felt.groups()[k / LANES].four();
                let sums = self.modes.sums(&group, n);
                let turn = self.modes.turn(k / LANES);
                let bordered = four_poles::bordered(&sums, &self.shared, group.frequency / all(omega), turn);
                four = Some((sums, bordered));
            }
            let mode = self.felt.mode(k);
            let Mode { cos: ck, sin: sk, frequency: fk, .. } = mode;
            // The phase carries a relative error of 2ε; differences of poles make it count.
            let phase = fk * response.period();
            let of_one;
            let (sums, quick) = match &four {
                Some((sums, bordered)) => {
                    of_one = sums.one(k)?;
                    (&of_one, bordered.as_ref())
                }
                None => (&by_cauchy[k], None),
            };
            // Far from ±1 and from other poles nothing much cancels in the determinant; else its own condition tells. (Of large rings
            // that is true of nearly all residues, and their errors are those of nearly all others as well.)
            let others = f64::EPSILON * (16.0 + 2.0 * phase / sums.nearest);
            self.crowded |= sums.nearest <= CLOSE;
            let apart = (sk * ck).abs() > SOFT && sums.nearest > CLOSE;
            let (bordered, relative) = match quick {
                Some(four) if apart => (four.one(k % LANES), others),
                _ => {
                    let Self { matrix, sizes, times, shared, .. } = &mut *self;
                    border_up(matrix, (shared, sums), times, (fk, omega));
                    if large || apart {
                        (determinant(matrix, border), others)
                    } else {
                        let (bordered, condition) = determinant_and_condition(matrix, sizes, border);
                        (bordered, others * condition.max(1.0))
                    }
                }
            };
            // Ṽᵀ adj K̂ W = −det [[K̂, W], [Ṽᵀ, 0]]
            let pole = mode.pole();
            let residue = -bordered * pole * (scale * mode.weight);
            let modulus = residue.norm_sqr().sqrt();
            size_of_residues += modulus;
            let error = modulus * (relative + self.felt.blur(k));
            total_error += error;
            self.form.residue_error.as_flattened_mut()[k] = error;
            self.form.pole_error.as_flattened_mut()[k] = modulus * f64::EPSILON * (2.0 + 2.0 * phase);
            self.residues.push(residue);
            self.angles.push(pole.im.atan2(pole.re).abs());
        }
        let residues = &self.residues;
        let poles = |k: usize| self.felt.mode(k).pole();
        fill(&mut self.form.pole_re, (0..self.count).map(|k| poles(k).re), 1e100);
        fill(&mut self.form.pole_im, (0..self.count).map(|k| poles(k).im), 0.0);
        fill(&mut self.form.residue_re, residues.iter().map(|r| r.re), 0.0);
        fill(&mut self.form.residue_im, residues.iter().map(|r| r.im), 0.0);
        if large {
            self.large.set(&self.felt, response.period(), residues, self.form.residue_error.as_flattened());
        }
        // f(0) = e^{2n}
        let product: f64 = (0..self.count).map(|k| 2.0 * (residues[k] * poles(k).conj()).re).sum();
        let defect = (1.0 - product - e.powi(2 * n as i32)).abs();
        let allowed = 16.0 * (total_error + 16.0 * f64::EPSILON * (1.0 + size_of_residues));
        if defect <= allowed && allowed < 1.0 + size_of_residues {
            Ok(())
        } else {
            Err(SecularError::Certificate { defect, allowed })
        }
    }

    /// Cauchy sums are faster than pairs of modes.
    pub(crate) fn is_large(&self) -> bool {
        self.count > LARGE
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

    /// tr M = Σ2 cos Ω_kT − 2ReΣρ_k on the modes that feel the impacts.
    pub fn trace(&self) -> f64 {
        self.poles().zip(&self.residues).map(|(p, r)| 2.0 * (p.re - r.re)).sum()
    }

    /// All 2m multipliers of the m modes that feel the impacts, in no order but that a conservative orbit's trivial pair comes first, with estimates of
    /// their errors.
    ///
    /// # Errors
    /// [`SecularError::Incomplete`] if the iteration does not settle; [`SecularError::Certificate`] if their sum is not the trace.
    pub fn multipliers(&mut self) -> Result<(&[Complex<f64>], &[f64]), SecularError> {
        if self.is_large() {
            self.large.solve(self.trivial)?;
            self.certify(&self.large.roots.values, &self.large.roots.errors)?;
            return Ok((&self.large.roots.values, &self.large.roots.errors));
        }
        if self.trivial > 0 || self.crowded || self.iterate(Start::Beside).is_err() || self.aberth.any_met() {
            self.iterate(Start::Between)?;
        }
        Ok((&self.aberth.roots, &self.aberth.errors))
    }

    fn iterate(&mut self, start: Start) -> Result<(), SecularError> {
        self.aberth.solve(&mut self.form, &self.angles, self.trivial, start)?;
        self.certify(&self.aberth.roots, &self.aberth.errors)
    }

    /// Holds the sum of all multipliers against the trace.
    fn certify(&self, roots: &[C], errors: &[f64]) -> Result<(), SecularError> {
        let sum: f64 = roots.iter().map(|z| z.re).sum();
        let size: f64 = roots.iter().map(|z| modulus(*z)).sum();
        let slack: f64 = errors.iter().sum();
        let defect = (sum - self.trace()).abs();
        let own: f64 = self.form.residue_error.iter().flatten().sum();
        let allowed = 16.0 * (slack + own + f64::EPSILON * size);
        if defect <= allowed.max(1e-9 * size) { Ok(()) } else { Err(SecularError::Certificate { defect, allowed }) }
    }
}

/// K̂ at the pole of a mode of frequency `fk`, its own dyad left out, with W beside and Ṽ below it.
fn border_up(matrix: &mut Vec<C>, (shared, sums): (&[f64], &PoleSums), times: &[f64], (fk, omega): (f64, f64)) {
    let n = times.len();
    let border = 2 * n + 1;
    matrix.clear();
    matrix.resize(border * border, C::default());
    for (row, values) in shared.chunks_exact(2 * n).enumerate() {
        for (entry, value) in matrix[row * border..].iter_mut().zip(values) {
            *entry = C::new(*value, 0.0);
        }
    }
    sums.add_to(matrix, n, border);
    for (i, time) in times.iter().enumerate() {
        let turn = C::from_polar(1.0, fk * (time - times[0]));
        matrix[2 * i * border + 2 * n] = turn;
        matrix[(2 * i + 1) * border + 2 * n] = turn * C::new(0.0, fk / omega);
        matrix[2 * n * border + 2 * i] = turn.conj() * 0.5;
        matrix[2 * n * border + 2 * i + 1] = turn.conj() * C::new(0.0, -0.5 * omega / fk);
    }
}

/// Below this |sin Ω_kT|/2, p and p̄ are so close that sums over modes may cancel to second order.
const SOFT: f64 = 0.05;

/// Poles this close make a residue worth its condition number.
const CLOSE: f64 = 1e-3;
