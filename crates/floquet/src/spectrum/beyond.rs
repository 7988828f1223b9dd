//! Whether an orbit surely has a real multiplier beyond some modulus: one sign, or two, and no multiplier worked out.
//!
//! M is real and of even size, so that det(z−M) is positive far out on the real axis, on either side, and so is det(z−R) beyond all poles.
//! Hence f(±r) < 0 there leaves an odd number of real multipliers beyond ±r.

use nalgebra::Complex;
use vibrochain_breather::BlochEquations;

use super::starts::NEGLIGIBLE;
use crate::linear::determinant_and_condition;
use crate::zeros::modulus;

/// Relative errors of the determinant up to this, as far as they are told by its condition, leave no doubt about its sign: what entries
/// lose where their own terms cancel, far from the poles a digit or two, has room.
pub(crate) const SURE: f64 = 1e-7;

/// How far beyond a spectral radius another is looked for that is surely larger: no poles are near there, and no verdict's error is as
/// large.
pub(crate) const BEYOND: f64 = 1.05;

/// A real multiplier is surely beyond `reach` or −`reach`, and all poles are not. No says nothing.
pub(crate) fn is_surely_beyond(equations: &BlochEquations, reach: f64) -> bool {
    let modes = equations.kernel().modes();
    let poles = || modes.iter().flat_map(|mode| mode.poles().into_iter().zip(mode.pole_errors()));
    if equations.left_out() > NEGLIGIBLE || poles().any(|(pole, _)| modulus(pole) >= reach) {
        return false;
    }
    let shapes = modes.iter().map(|mode| mode.shape_error).fold(0.0, f64::max);
    let (mut matrix, mut sizes) = (Vec::new(), Vec::new());
    [reach, -reach].into_iter().any(|z| {
        let z = Complex::new(z, 0.0);
        let of_poles = poles().map(|(pole, error)| error / modulus(z - pole)).fold(0.0, f64::max);
        equations.fill(z, &mut matrix, None);
        let (value, condition) = determinant_and_condition(&mut matrix, &mut sizes, equations.size());
        value.re < 0.0 && condition * (16.0 * f64::EPSILON + of_poles + shapes) < SURE
    })
}

#[cfg(test)]
mod tests {
    use vibrochain_testkit::Random;

    use super::super::random_equations;
    use super::super::solve::zeros;
    use super::*;

    /// Against all multipliers.
    #[test]
    fn a_yes_is_a_real_multiplier_beyond_and_is_said_wherever_one_is_alone_there() {
        let mut random = Random(67);
        let (mut yes, mut turned, mut no, mut missed) = (0, 0, 0, 0);
        for _ in 0..600 {
            let equations = random_equations(&mut random, 1.5);
            let all = zeros(&equations, false, &[]);
            if !all.certified {
                continue;
            }
            let real = |sign: f64, reach: f64| {
                all.list.iter().filter(|zero| zero.z.im.abs() <= zero.error && sign * zero.z.re > reach).count()
            };
            for reach in [1.0, 1.3, 4.0] {
                let told = is_surely_beyond(&equations, reach);
                assert!(!told || real(1.0, reach) + real(-1.0, reach) > 0, "{reach} {equations:?}");
                if told {
                    yes += 1;
                    turned += usize::from(real(1.0, reach) == 0);
                } else if real(1.0, reach) % 2 == 1 || real(-1.0, reach) % 2 == 1 {
                    missed += 1;
                } else {
                    no += 1;
                }
            }
        }
        assert!(yes > 300 && turned > 50 && no > 300 && 20 * missed < yes, "{yes} {turned} {no} {missed}");
    }
}
