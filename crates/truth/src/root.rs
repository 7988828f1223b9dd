//! A root of a function of one complex variable by Newton's method with difference quotients.

use crate::complex::{Complex, shifted};
use crate::error::TruthError;
use crate::real::Real;

const MAX_STEPS: usize = 400;

/// Steps until they no longer shrink, for a root to `bits` digits of a function that is evaluated in `work` digits. Returns the point, log₂
/// of the last step and their number.
pub(crate) fn newton(
    start: &Complex,
    bits: usize,
    work: usize,
    value: impl Fn(&Complex) -> Option<Complex>,
) -> Result<(Complex, f64, usize), TruthError> {
    let mut point = start.clone();
    let mut previous = f64::INFINITY;
    for iteration in 1..=MAX_STEPS {
        let size = point.log2_abs().max(start.log2_abs() - 8.0);
        let h = difference(size, work);
        let (here, plus, minus) = (value(&point), value(&shifted(&point, &h)), value(&shifted(&point, &-&h)));
        let (Some(here), Some(plus), Some(minus)) = (here, plus, minus) else {
            return Err(TruthError::Singular { what: "Newton's method met a pole exactly; move the start" });
        };
        if here.is_zero() {
            return Ok((point, f64::NEG_INFINITY, iteration));
        }
        let step = here.scale(&(h * 2.0)) / (plus - minus);
        if !step.is_finite() {
            break;
        }
        point = point - &step;
        let moved = step.log2_abs();
        let floor = size - work as f64;
        // Next to a double root the steps halve at first: only small ones can have come to rest.
        if moved <= floor || (moved < size - 0.5 * bits as f64 && moved > previous - 1.0) {
            return Ok((point, moved, iteration));
        }
        previous = moved;
    }
    let moved = (&point - start).abs().to_f64();
    Err(TruthError::NotConverged { iterations: MAX_STEPS, last_step: previous * 2f64.log10(), moved })
}

/// Step of a difference quotient at a point of modulus 2^`size`: its error, the square of it, and rounding balance.
pub(crate) fn difference(size: f64, work: usize) -> Real {
    Real::one(work).times_power_of_two(size.round() as i32 - work as i32 / 3)
}
