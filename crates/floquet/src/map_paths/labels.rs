//! Which mode a multiplier is next to.

use nalgebra::Complex;
use vibrochain_breather::{Finder, Orbit};

use crate::all_multipliers::{Spared, partition_point_from};
use crate::error::FloquetError;
use crate::multipliers::participating_modes;

/// For multipliers as [`crate::Analyser::stability`] returns them, the mode k whose e^{±iΩ_kT} is next by angle, in
/// O(M log M); `None` for the trivial pair of a conservative orbit and for impacts at several sites.
///
/// # Errors
/// [`FloquetError::Breather`], which an orbit that exists has already passed.
///
/// ```
/// use vibrochain_breather::{Family, Finder, breathers};
/// use vibrochain_floquet::{Tolerance, multiplier_modes, stability};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.02)?, 1.1, 0.4)?;
/// let orbit = &breathers(&model, Family::DoubleSided)?.orbits[0];
/// let multipliers = stability(orbit, Tolerance::Rounding)?.multipliers;
/// let modes = multiplier_modes(orbit, &mut Finder::new(21), &multipliers)?;
/// assert_eq!(modes.iter().filter(|mode| mode.is_none()).count(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn multiplier_modes(
    orbit: &Orbit,
    finder: &mut Finder,
    multipliers: &[Complex<f64>],
) -> Result<Vec<Option<usize>>, FloquetError> {
    let mut labels = ModeLabels::new(orbit, finder)?;
    Ok(multipliers.iter().map(|z| labels.mode(*z)).collect())
}

/// The modes of an orbit, for [`multiplier_modes`] one by one. Multipliers by rising or falling argument cost a step each.
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
    /// As [`multiplier_modes`].
    pub fn new(orbit: &Orbit, finder: &mut Finder) -> Result<Self, FloquetError> {
        let conservative = orbit.model().is_conservative();
        let Some(site) = orbit.impact_site() else {
            return Ok(Self { conservative, spared: Spared::default(), angles: Vec::new(), last: [0; 2] });
        };
        let response = finder.prepared(orbit)?.response();
        let (cos, sin) = (response.cos_half(), response.sin_half());
        let angle = |k: usize| 2.0 * sin[k].abs().atan2(cos[k].abs());
        let mut angles: Vec<(f64, usize)> =
            participating_modes(orbit.model().chain(), site).into_iter().map(|(k, _)| (angle(k), k)).collect();
        angles.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Self { conservative, spared: Spared::of(orbit), angles, last: [0; 2] })
    }

    /// That of one multiplier.
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
