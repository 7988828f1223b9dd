//! Which mode a multiplier is next to.

use std::collections::HashMap;

use nalgebra::Complex;
use vibrochain_breather::{Finder, Orbit};

use crate::error::FloquetError;
use crate::multipliers::{felt_modes, odd_multipliers, spared_modes};

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
    let spared = odd_multipliers(orbit).zip(spared_modes(orbit)).zip(orbit.impact_site());
    let Some(((values, modes), site)) = spared else { return Ok(vec![None; multipliers.len()]) };
    let bits = |z: &Complex<f64>| (z.re.to_bits(), z.im.to_bits());
    let spared: HashMap<(u64, u64), usize> =
        values.iter().enumerate().map(|(i, z)| (bits(z), modes[i / 2].0)).collect();
    let response = finder.prepared(orbit)?.response();
    let (cos, sin) = (response.cos_half(), response.sin_half());
    let angle = |k: usize| 2.0 * sin[k].abs().atan2(cos[k].abs());
    let mut angles: Vec<(f64, usize)> =
        felt_modes(orbit.model().chain(), site).into_iter().map(|(k, _)| (angle(k), k)).collect();
    angles.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let nearest = |angle: f64| {
        let above = angles.partition_point(|(other, _)| *other < angle);
        let sides = [above.checked_sub(1), Some(above)].into_iter().flatten().filter_map(|i| angles.get(i));
        sides.min_by(|a, b| (a.0 - angle).abs().total_cmp(&(b.0 - angle).abs())).map(|(_, mode)| *mode)
    };
    let conservative = orbit.model().is_conservative();
    let mode = |z: &Complex<f64>| {
        if conservative && *z == Complex::new(1.0, 0.0) {
            return None;
        }
        spared.get(&bits(z)).copied().or_else(|| nearest(z.im.atan2(z.re).abs()))
    };
    Ok(multipliers.iter().map(mode).collect())
}
