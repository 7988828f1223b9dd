//! Which mode a multiplier is next to.

use nalgebra::Complex;
use vibrochain_breather::{Finder, Orbit};

use crate::all_multipliers::{Spared, partition_point_from};
use crate::error::FloquetError;
use crate::multipliers::participating_modes;

/// The mode next to a multiplier of one orbit. Multipliers by rising or falling argument cost a step each.
///
/// ```
/// use vibrochain_breather::{Family, Finder, breathers};
/// use vibrochain_floquet::{ModeLabels, Tolerance, stability};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.02)?, 1.1, 0.4)?;
/// let orbit = &breathers(&model, Family::DoubleSided)?.orbits[0];
/// let mut labels = ModeLabels::new(orbit, &mut Finder::new(21))?;
/// let multipliers = stability(orbit, Tolerance::Rounding)?.multipliers;
/// assert_eq!(multipliers.iter().filter(|z| labels.mode(**z).is_none()).count(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct ModeLabels {
    conservative: bool,
    spared: Spared,
    /// Half-way around the circle, the modes that feel the impacts.
    angles: Vec<(f64, usize)>,
    /// Where the last one was among both.
    last: [usize; 2],
}

impl ModeLabels {
    /// The modes of an orbit.
    ///
    /// # Errors
    /// [`FloquetError::Breather`] of an orbit next to a resonance; the search for it has passed the same check.
    pub fn new(orbit: &Orbit, finder: &mut Finder) -> Result<Self, FloquetError> {
        let orbit = orbit.lattice()?;
        let conservative = orbit.is_conservative();
        let Some(site) = orbit.impact_site().filter(|_| !orbit.model().is_damped()) else {
            return Ok(Self { conservative, spared: Spared::default(), angles: Vec::new(), last: [0; 2] });
        };
        let response = finder.prepared(orbit.orbit())?.response();
        let (cos, sin) = (response.cos_half(), response.sin_half());
        let angle = |k: usize| 2.0 * sin[k].abs().atan2(cos[k].abs());
        let mut angles: Vec<(f64, usize)> =
            participating_modes(orbit.model().chain(), site).into_iter().map(|(k, _)| (angle(k), k)).collect();
        angles.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Self { conservative, spared: Spared::of(orbit), angles, last: [0; 2] })
    }

    /// For a multiplier as [`crate::Analyser::stability`] returns it, the mode k whose e^{±iΩ_kT} is next by angle; `None` for the trivial
    /// pair of a conservative orbit, for impacts at several sites and with dashpots, where multipliers leave the circle.
    pub fn mode(&mut self, z: Complex<f64>) -> Option<usize> {
        let Self { conservative, spared, angles, last: [of_spared, of_felt] } = self;
        if *conservative && z == Complex::new(1.0, 0.0) {
            return None;
        }
        let angle = z.arg().abs();
        if let Some(mode) = spared.number(z, angle, of_spared) {
            return Some(mode);
        }
        *of_felt = partition_point_from(angles, *of_felt, |(other, _)| *other < angle);
        let sides = [of_felt.checked_sub(1), Some(*of_felt)].into_iter().flatten().filter_map(|i| angles.get(i));
        sides.min_by(|a, b| (a.0 - angle).abs().total_cmp(&(b.0 - angle).abs())).map(|(_, mode)| *mode)
    }
}
