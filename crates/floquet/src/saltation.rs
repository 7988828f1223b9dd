//! How a small perturbation goes through an impact (paper, sec. III; `errata` for Δ and Γ).
//!
//! The perturbed mass hits a little earlier or later; to first order the displacement and velocity perturbations of the
//! impacting mass, rows (u, v), are multiplied by
//!
//! ```text
//! S = [[−e, 0], [κ, −e]],     κ = (1+e) v̈/v⁻ ,
//! ```
//!
//! with v̈ the full acceleration at the impact, force included, and v⁻ the velocity just before it. Other masses are
//! not touched. κ grows without bound towards grazing, v⁻ → 0.

use vibrochain_breather::{Impact, Orbit};

use crate::error::FloquetError;

/// The saltation matrix of one impact.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
pub struct Saltation {
    /// The mass that hits.
    pub site: usize,
    /// Time of the impact.
    pub time: f64,
    /// Coefficient e of restitution.
    pub restitution: f64,
    /// κ = (1+e) v̈/v⁻, the velocity perturbation per displacement perturbation.
    pub kappa: f64,
}

impl Saltation {
    /// Saltation of an impact with coefficient `restitution`.
    ///
    /// ```
    /// use vibrochain_breather::{Family, breathers};
    /// use vibrochain_floquet::Saltation;
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(1, 0.2, 0.0)?, 1.5, 0.0)?;
    /// let orbit = &breathers(&model, Family::DoubleSided)?.orbits[0];
    /// let saltation = Saltation::of(&orbit.impacts()[0], 1.0);
    /// // On the upper barrier of one mass v̈ = −γ₁.
    /// assert!((saltation.kappa + 2.0 * 0.2 / orbit.impacts()[0].velocity_before).abs() < 1e-14);
    /// # Ok::<(), vibrochain_breather::BreatherError>(())
    /// ```
    pub fn of(impact: &Impact, restitution: f64) -> Self {
        let kappa = (1.0 + restitution) * impact.acceleration / impact.velocity_before;
        Self { site: impact.site, time: impact.time, restitution, kappa }
    }

    /// κ' = κ/(1+e)² = v̈/((1+e)v⁻): what the matrix from impact to impact has on its diagonal. All of `map_paths` and `stripes` has
    /// this scaling, and has it from here.
    pub(crate) fn reduced(impact: &Impact, restitution: f64) -> f64 {
        impact.acceleration / ((1.0 + restitution) * impact.velocity_before)
    }

    /// The matrix, rows and columns (displacement, velocity) of the impacting mass.
    pub fn matrix(&self) -> [[f64; 2]; 2] {
        [[-self.restitution, 0.0], [self.kappa, -self.restitution]]
    }
}

/// The saltations of an orbit's impacts, in order of time.
///
/// # Errors
/// [`FloquetError::Grazing`] where one is not finite; [`FloquetError::Breather`] of other structures than lattices.
pub fn saltations(orbit: &Orbit) -> Result<impl Iterator<Item = Saltation> + '_, FloquetError> {
    let e = orbit.lattice()?.model().restitution();
    for (index, impact) in orbit.impacts().iter().enumerate() {
        if !Saltation::of(impact, e).kappa.is_finite() {
            return Err(FloquetError::Grazing { impact: index, velocity: impact.velocity_before });
        }
    }
    Ok(orbit.impacts().iter().map(move |impact| Saltation::of(impact, e)))
}
