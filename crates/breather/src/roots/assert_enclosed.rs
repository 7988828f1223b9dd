//! What tests of enclosures demand of each of them.

use vibrochain_lattice::simd::lanes::LANES;

use crate::roots::interval::Enclosed;

/// Demands that what is enclosed on an interval is what the function has there, as far as a range goes; returns at how many places it was shown to be
/// away from 0.
pub(crate) fn assert_enclosed(f: &impl Enclosed, centre: f64, radius: f64, [least, most]: [f64; 2]) -> usize {
    let (clearance, (value, slope)) = (f.clearances([centre; LANES], [radius; LANES])[1], f.at(centre));
    let mut away = 0;
    for k in -20..=20 {
        let (near, rise) = f.at((centre + radius * f64::from(k) / 20.0).clamp(least, most));
        if clearance.function > 0.0 {
            assert!(near.abs() >= clearance.function * (1.0 - 1e-9) && near * value > 0.0);
            away += 1;
        } else if clearance.derivative > 0.0 {
            assert!(rise * slope > 0.0);
        }
    }
    away
}
