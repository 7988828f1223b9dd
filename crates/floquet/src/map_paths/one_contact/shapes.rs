//! Eigenvectors from the secular form: what a perturbation of known multiplier z looks like, at the cost of a few passes
//! over the modes.
//!
//! What impact j does to it, h_j = D_jy_j, is a null vector of K̂(z) (see [`crate::map_paths::one_contact::impact_matrix`]). Mode k just before the first impact is
//! then what all past impacts made of it,
//!
//! ```text
//! (x_k, ẋ_k) = b_k Σ_j [ p/(z−p) e^{iΩ(t₁−t_j)} wṽ + conj. ] h_j .
//! ```

use nalgebra::Complex;
use vibrochain_breather::Prepared;
use vibrochain_lattice::{Chain, Shapes};

use crate::map_paths::one_contact::impact_matrix::{FeltMode, ImpactMatrix};
use crate::zeros::SecularError;

type C = Complex<f64>;

/// What a multiplier may leave of K̂, as a part of its largest entry.
const MOST_DEFECT: f64 = 1e-4;

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
    /// [`SecularError::NotReversible`] for impacts at several sites; [`SecularError::Coincident`] if the multiplier is a pole e^{±iΩT}
    /// itself: then its mode does not feel the impacts; [`SecularError::Certificate`] if the number is no multiplier: what it leaves
    /// of the impacts' equations is told.
    ///
    /// ```
    /// use vibrochain_breather::{Family, Finder, Found};
    /// use vibrochain_floquet::{Complex, ModalShape, Secular};
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 0.8, 0.4)?;
    /// let (mut finder, mut found, mut secular) = (Finder::new(21), Found::default(), Secular::default());
    /// finder.find(&model, Family::SingleSided, &mut found)?;
    /// secular.replace(finder.prepared(&found.orbits[0])?)?;
    /// let leading = secular.verdict()?.leading.unwrap();
    /// let shape = ModalShape::new(finder.prepared(&found.orbits[0])?, leading)?;
    /// // The instability sits on the breather.
    /// let (displacement, _) = shape.at_sites(21, 0);
    /// assert!(displacement[0].norm() > 2.0 * displacement[10].norm());
    /// assert!(ModalShape::new(finder.prepared(&found.orbits[0])?, Complex::new(2.0, 0.0)).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(prepared: Prepared<'_>, multiplier: C) -> Result<Self, SecularError> {
        if prepared.orbit().impact_site().is_none() {
            return Err(SecularError::NotReversible);
        }
        let mut matrix = ImpactMatrix::default();
        matrix.set(prepared);
        let (z, omega) = (multiplier, prepared.response().omega());
        let at_pole = |(mode, one): (usize, &FeltMode)| one.distances(z).is_none().then_some(mode);
        if let Some(mode) = matrix.modes.iter().enumerate().find_map(at_pole) {
            return Err(SecularError::Coincident { mode });
        }
        let singular = matrix.null_vectors(z).ok_or(SecularError::Incomplete { found: 0, wanted: 1 })?;
        // Not a number is no multiplier, either.
        if singular.defect.is_nan() || singular.defect > MOST_DEFECT {
            return Err(SecularError::Certificate { defect: singular.defect, allowed: MOST_DEFECT });
        }
        let mut displacement = Vec::with_capacity(matrix.modes.len());
        let mut velocity = displacement.clone();
        for (k, (mode, waves)) in matrix.modes.iter().zip(matrix.waves.chunks_exact(matrix.impacts)).enumerate() {
            let [(plus, _), (minus, _)] = mode.distances(z).ok_or(SecularError::Coincident { mode: k })?;
            let (mut x, mut v) = (C::default(), C::default());
            for (wave, hit) in waves.iter().zip(matrix.right.chunks_exact(2)) {
                let (a, b) = (mode.pole * plus * wave.conj(), mode.pole.conj() * minus * wave);
                let (even, odd) = ((a + b) * 0.5, (a - b) * C::new(0.0, 0.5));
                // sin Ωτ/Ω is what a rigid mode has: odd/Ω stays finite with Ω, but not by this formula.
                x += even * hit[0] - odd * hit[1] / mode.ratio;
                v += odd * hit[0] * mode.ratio + even * hit[1];
            }
            let b = mode.weight.sqrt();
            displacement.push(x * b);
            velocity.push(v * b);
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
        let mut shapes = Shapes::new(&Chain::alone(sites));
        let mut at = |modes: &[C]| {
            let mut values = vec![C::default(); sites.max(1)];
            shapes.add_all(home, modes.iter().enumerate().map(|(k, x)| x * amplitude(k)), &mut values);
            values
        };
        (at(&self.displacement), at(&self.velocity))
    }
}
