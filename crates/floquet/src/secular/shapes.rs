//! Eigenvectors from the secular form: what a perturbation of known multiplier z looks like, at the cost of a few passes
//! over the modes.
//!
//! Its value y_i = (u, v) at the site just before impact i solves y_i = Σ_j G(t_i−t_j)D_j y_j (see [`super::forced`]): a null
//! vector of a 2n×2n matrix. Mode k just before the first impact is then what all past impacts made of it,
//!
//! ```text
//! (x_k, ẋ_k) = b_k Σ_j [ p/(z−p) e^{iΩ(t₁−t_j)} wṽ + conj. ] D_j y_j .
//! ```

use nalgebra::Complex;
use vibrochain_breather::Orbit;
use vibrochain_lattice::{ImpulseResponse, RingTransform};

use super::doubt::Doubt;
use super::forced::MOST_IMPACTS;

type C = Complex<f64>;

/// The perturbation of a multiplier in normalised even modes (u_site = Σ b_k x_k), just before the first impact.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalShape {
    /// μ
    pub multiplier: Complex<f64>,
    /// x_k, k = 0 … ⌊M/2⌋, scaled so that Σ|x_k|² + |ẋ_k|²/ω² = 1.
    pub displacement: Vec<Complex<f64>>,
    /// ẋ_k
    pub velocity: Vec<Complex<f64>>,
}

impl ModalShape {
    /// The shape of multiplier `multiplier` (an eigenvalue on the even subspace, to rounding) of an orbit whose impacts are
    /// all at one site. `response` is that of the orbit's chain and frequency.
    ///
    /// # Errors
    /// [`Doubt::NotReversible`] for impacts at several sites; [`Doubt::Coincident`] if the multiplier is a pole e^{±iΩT}
    /// itself: then its mode does not feel the impacts; [`Doubt::Certificate`] if the number is no multiplier: what it leaves
    /// of the impacts' equations is told.
    ///
    /// ```
    /// use vibrochain_breather::{Family, Finder, Found};
    /// use vibrochain_floquet::{Complex, ModalShape, Secular};
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 0.8, 0.4)?;
    /// let (mut finder, mut found, mut secular) = (Finder::new(21), Found::default(), Secular::default());
    /// finder.find(&model, Family::SingleSided, &mut found)?;
    /// secular.set(&found.orbits[0], finder.response())?;
    /// let leading = secular.verdict()?.leading.unwrap();
    /// let shape = ModalShape::new(&found.orbits[0], finder.response(), leading)?;
    /// // The instability sits on the breather.
    /// let (displacement, _) = shape.at_sites(21, 0);
    /// assert!(displacement[0].norm() > 2.0 * displacement[10].norm());
    /// assert!(ModalShape::new(&found.orbits[0], finder.response(), Complex::new(2.0, 0.0)).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(orbit: &Orbit, response: &ImpulseResponse, multiplier: C) -> Result<Self, Doubt> {
        let impacts = orbit.impacts();
        let n = impacts.len();
        if orbit.impact_site().is_none() || n == 0 || n > MOST_IMPACTS {
            return Err(Doubt::NotReversible);
        }
        let (frequencies, weights) = (response.frequencies(), response.weights());
        let (cos, sin) = (response.cos_half(), response.sin_half());
        let (e, omega, z) = (orbit.model().restitution(), response.omega(), multiplier);
        // Velocities in units of ω. Entry (u, v) of b² e^{iΩτ}/(1−p/z) wṽ + conj. for a mode; for τ ≤ 0 another p/z.
        let kernel = |k: usize, tau: f64, later: bool| -> Option<[C; 4]> {
            let f = frequencies[k];
            let pole = C::new((cos[k] - sin[k]) * (cos[k] + sin[k]), 2.0 * sin[k] * cos[k]);
            let turn = C::from_polar(1.0, f * tau);
            let part = |pole: C, turn: C| {
                let distance = z - pole;
                (distance.norm_sqr() > 0.0).then(|| turn * (if later { z } else { pole }) / distance)
            };
            let (a, b) = (part(pole, turn)?, part(pole.conj(), turn.conj())?);
            let (even, odd) = ((a + b) * 0.5, (a - b) * C::new(0.0, 0.5));
            // sin Ωτ/Ω is what a rigid mode has: odd/Ω stays finite with Ω, but not by this formula.
            Some([even, -odd * (omega / f), odd * (f / omega), even])
        };
        let kick = |j: usize, [u, v]: [C; 2]| {
            let kappa = (1.0 + e) * impacts[j].acceleration / (impacts[j].velocity_before * omega);
            [-u * (1.0 + e), u * kappa - v * (1.0 + e)]
        };
        let size = 2 * n;
        let mut matrix = vec![C::default(); size * size];
        for i in 0..n {
            for j in 0..n {
                let tau = impacts[i].time - impacts[j].time;
                let mut sum = [C::default(); 4];
                for (k, weight) in weights.iter().enumerate() {
                    let block = kernel(k, tau, i > j).ok_or(Doubt::Coincident { mode: k })?;
                    sum.iter_mut().zip(block).for_each(|(sum, entry)| *sum += entry * *weight);
                }
                for column in 0..2 {
                    let mut unit = [C::default(); 2];
                    unit[column] = C::new(1.0, 0.0);
                    let [u, v] = kick(j, unit);
                    matrix[2 * i * size + 2 * j + column] -= sum[0] * u + sum[1] * v;
                    matrix[(2 * i + 1) * size + 2 * j + column] -= sum[2] * u + sum[3] * v;
                }
            }
            for a in 0..2 {
                matrix[(2 * i + a) * size + 2 * i + a] += 1.0;
            }
        }
        let dense = nalgebra::DMatrix::from_row_slice(size, size, &matrix);
        let failed = Doubt::Incomplete { found: 0, wanted: 1 };
        let svd = nalgebra::SVD::try_new(dense, false, true, f64::EPSILON, 1000).ok_or(failed)?;
        let v_t = svd.v_t.ok_or(failed)?;
        let (least, defect) = svd.singular_values.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).ok_or(failed)?;
        let allowed = 1e-4 * svd.singular_values.iter().copied().fold(0.0, f64::max);
        // Not a number is no multiplier, either.
        if defect.is_nan() || *defect > allowed {
            return Err(Doubt::Certificate { defect: *defect, allowed });
        }
        let hits: Vec<[C; 2]> =
            (0..n).map(|j| kick(j, [v_t[(least, 2 * j)].conj(), v_t[(least, 2 * j + 1)].conj()])).collect();
        let modes = weights.len();
        let (mut displacement, mut velocity) = (vec![C::default(); modes], vec![C::default(); modes]);
        let first = impacts[0].time;
        for k in 0..modes {
            for (impact, [u, v]) in impacts.iter().zip(&hits) {
                let block = kernel(k, first - impact.time, false).ok_or(Doubt::Coincident { mode: k })?;
                displacement[k] += block[0] * u + block[1] * v;
                velocity[k] += block[2] * u + block[3] * v;
            }
            let b = weights[k].sqrt();
            displacement[k] *= b;
            velocity[k] *= b;
        }
        let norm: f64 = displacement.iter().chain(&velocity).map(|z| z.norm_sqr()).sum();
        let scale = if norm > 0.0 { norm.sqrt().recip() } else { 1.0 };
        displacement.iter_mut().for_each(|z| *z *= scale);
        velocity.iter_mut().for_each(|z| *z *= scale * omega);
        Ok(Self { multiplier, displacement, velocity })
    }

    /// Displacements and velocities of the M masses of a ring whose site `home` is hit, in O(M log M).
    pub fn at_sites(&self, sites: usize, home: usize) -> (Vec<Complex<f64>>, Vec<Complex<f64>>) {
        let m = sites as f64;
        let amplitude = |k: usize| (if k == 0 || 2 * k == sites { 1.0 / m } else { 2.0 / m }).sqrt();
        let mut transform = RingTransform::new(sites.max(1));
        let mut at = |modes: &[C]| {
            let mut values = transform.sites(modes.iter().enumerate().map(|(k, x)| x * amplitude(k))).to_vec();
            values.rotate_right(home % sites.max(1));
            values
        };
        (at(&self.displacement), at(&self.velocity))
    }
}
