//! One zero of the determinant, as it is known.

use nalgebra::Complex;

use crate::zeros::{Nu, modulus};

type C = Complex<f64>;

/// One zero in its own plane, of z or of ν = ½(z + 1/z).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Zero {
    /// z, or the one of modulus 1 or more of two that belong to ν.
    pub(crate) z: C,
    /// ν by its distances from ±1; nothing in the plane of z.
    pub(crate) nu: Nu,
    /// Error in its plane.
    pub(crate) error: f64,
    /// The part of it that rounding makes, for which equations as they are count.
    pub(crate) rounding: f64,
    /// It has been told from all others, or together with the few next to it from the rest. Of others it is known alone that as many
    /// are within the errors.
    pub(crate) settled: bool,
    /// Its own null vectors have told it from all others, whatever their sum is.
    pub(crate) alone: bool,
    /// No zero of another group is within the errors.
    pub(crate) apart: bool,
    /// It is one of several that structure keeps on the circle together.
    pub(crate) held: bool,
}

impl Zero {
    pub(crate) fn new(z: C, settled: bool) -> Self {
        Self { z, nu: Nu::default(), error: 0.0, rounding: 0.0, settled, alone: true, apart: true, held: false }
    }

    /// That of ν, from one of its two multipliers and the errors of this one, all and of rounding alone.
    pub(crate) fn of_pair(z: C, [error, rounding]: [f64; 2], settled: bool) -> Self {
        // ν ∓ 1 = (z ∓ 1)²/2z
        let [below, above] = [z - 1.0, z + 1.0].map(|root| root * root / (z * 2.0));
        let nu = Nu { below: below.re, above: above.re, im: above.im };
        let inverse = z.inv();
        let slope = 0.5 * modulus((z - 1.0) * (z + 1.0)) * inverse.norm_sqr();
        let of = |error: f64| {
            error * slope + 0.5 * error * error * inverse.norm_sqr() + 2.0 * f64::EPSILON * modulus(nu.complex())
        };
        Self { nu, error: of(error), rounding: of(rounding), ..Self::new(z, settled) }
    }
}
