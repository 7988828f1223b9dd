//! What enclosures of a function of one variable and its derivative say on an interval.

use vibrochain_lattice::simd::lanes::{LANES, Lane};
use wide::f64x4;

use crate::roots::dual::Dual;
use crate::roots::taylor::Taylor;

/// How far function and derivative stay away from 0 on an interval: neither has a zero there where this is positive.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clearance {
    pub(crate) function: f64,
    /// Of use only where the function may vanish.
    pub(crate) derivative: f64,
    /// A number of the sign that the function surely has at either end; 0 where that is not known.
    pub(crate) ends: [f64; 2],
    /// Function and derivative at the centre.
    pub(crate) centre: (f64, f64),
}

impl Clearance {
    /// Those of four enclosures.
    pub(crate) fn of(enclosed: &Dual<Taylor<1, f64x4>>) -> [Self; LANES] {
        let [functions, derivatives] =
            [enclosed.function, enclosed.derivative].map(|enclosure| enclosure.clearance().to_array());
        let (ends, doubt) = enclosed.function.ends();
        let (ends, doubt) = (ends.map(f64x4::to_array), doubt.to_array());
        let (value, slope) = enclosed.at_centre();
        let (value, slope) = (value.to_array(), slope.to_array());
        std::array::from_fn(|i| Self {
            function: functions[i],
            derivative: derivatives[i],
            ends: ends.map(|end| sure(end[i], doubt[i])),
            centre: (value[i], slope[i]),
        })
    }

    /// Of a function that has no zero there.
    pub(crate) fn away(function: f64) -> Self {
        Self { function, derivative: 0.0, ends: [0.0; 2], centre: (function, 0.0) }
    }
}

/// A value that may be wrong by `doubt`, or 0 if that leaves its sign open.
fn sure(value: f64, doubt: f64) -> f64 {
    if value.abs() > doubt { value } else { 0.0 }
}

/// Of functions that know nothing of four intervals at a time.
pub(crate) fn one_by_one(centres: Lane, radii: Lane, enclose: impl Fn(f64, f64) -> Dual) -> [Clearance; LANES] {
    std::array::from_fn(|i| {
        let enclosed = enclose(centres[i], radii[i]);
        let Dual { function, derivative } = enclosed;
        let (ends, doubt) = function.ends();
        let ends = ends.map(|end| sure(end, doubt));
        let [function, derivative] = [function.clearance(), derivative.clearance()];
        Clearance { function, derivative, ends, centre: enclosed.at_centre() }
    })
}
