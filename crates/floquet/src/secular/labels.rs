//! Which mode a multiplier comes from, and which sign it has.

use std::collections::HashMap;

use nalgebra::Complex;
use vibrochain_breather::{Finder, Orbit};

use super::residues::Residues;
use crate::error::FloquetError;
use crate::multipliers::odd_multipliers;

/// Farther from the unit circle than this a multiplier is off it.
const ON_CIRCLE: f64 = 1e-10;

/// What is known of a multiplier beyond its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MultiplierLabel {
    /// The mode k whose e^{±iΩ_kT} is next to it by angle; `None` for the trivial pair and for impacts at several sites.
    pub mode: Option<usize>,
    /// Krein signature, +1 (as of free modes) or −1, of a multiplier of a conservative orbit on the unit circle: only two of
    /// opposite signature can leave it together. `None` otherwise, and where rounding has eaten it.
    pub signature: Option<i8>,
}

/// Labels for multipliers as [`crate::Analyser::stability`] returns them, in O(M log M).
///
/// # Errors
/// [`FloquetError::Breather`], which an orbit that exists has already passed.
///
/// ```
/// use vibrochain_breather::{Family, Finder, breathers};
/// use vibrochain_floquet::{Tolerance, multiplier_labels, stability};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.02)?, 1.1, 0.4)?;
/// let orbit = &breathers(&model, Family::DoubleSided)?.orbits[0];
/// let multipliers = stability(orbit, Tolerance::Rounding)?.multipliers;
/// let labels = multiplier_labels(orbit, &mut Finder::new(21), &multipliers)?;
/// // All signatures of this stable orbit are alike; the trivial pair has none.
/// assert_eq!(labels.iter().filter(|label| label.signature == Some(1)).count(), 40);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn multiplier_labels(
    orbit: &Orbit,
    finder: &mut Finder,
    multipliers: &[Complex<f64>],
) -> Result<Vec<MultiplierLabel>, FloquetError> {
    let Some(odd) = odd_multipliers(orbit) else { return Ok(vec![MultiplierLabel::default(); multipliers.len()]) };
    let bits = |z: &Complex<f64>| (z.re.to_bits(), z.im.to_bits());
    let odd: HashMap<(u64, u64), usize> = odd.iter().enumerate().map(|(i, z)| (bits(z), i / 2 + 1)).collect();
    let response = finder.response_to(orbit)?;
    let halves = response.cos_half().iter().zip(response.sin_half());
    let mut angles: Vec<(f64, usize)> =
        halves.enumerate().map(|(k, (c, s))| (2.0 * s.abs().atan2(c.abs()), k)).collect();
    angles.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let nearest = |angle: f64| {
        let above = angles.partition_point(|(other, _)| *other < angle);
        let sides = [above.checked_sub(1), Some(above)].into_iter().flatten().filter_map(|i| angles.get(i));
        sides.min_by(|a, b| (a.0 - angle).abs().total_cmp(&(b.0 - angle).abs())).map(|(_, mode)| *mode)
    };
    let conservative = orbit.model().is_conservative();
    let mut form = Residues::default();
    let known = conservative && form.set(orbit, response).is_ok();
    let mut scratch = Vec::new();
    let label = |z: &Complex<f64>| {
        if conservative && *z == Complex::new(1.0, 0.0) {
            return MultiplierLabel::default();
        }
        if let Some(&mode) = odd.get(&bits(z)) {
            return MultiplierLabel { mode: Some(mode), signature: conservative.then_some(1) };
        }
        let on_circle = z.im != 0.0 && (z.norm() - 1.0).abs() < ON_CIRCLE;
        let signature = (known && on_circle).then(|| form.signature(z.re, &mut scratch)).flatten();
        MultiplierLabel { mode: nearest(z.im.atan2(z.re).abs()), signature }
    };
    Ok(multipliers.iter().map(label).collect())
}
