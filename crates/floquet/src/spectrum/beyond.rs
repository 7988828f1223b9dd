//! Whether an orbit surely has a real multiplier beyond some modulus: one sign, or two, and no multiplier worked out.
//!
//! M is real and of even size, so that det(z−M) is positive far out on the real axis, on either side, and so is det(z−R) beyond all poles.
//! Hence f(±r) < 0 there leaves an odd number of real multipliers beyond ±r.

use vibrochain_breather::BlochEquations;
use vibrochain_breather::linear::determinant_and_condition;

use super::starts::NEGLIGIBLE;
use crate::zeros::modulus;

/// Relative errors of the determinant up to this, as far as they are told by its condition, leave no doubt about its sign: what entries
/// lose where their own terms cancel, far from the poles a digit or two, has room.
const SURE: f64 = 1e-7;

/// How far beyond a spectral radius another is looked for that is surely larger: no poles are near there, and no verdict's error is as
/// large.
pub(crate) const BEYOND: f64 = 1.05;

/// A real multiplier is surely beyond `reach` or −`reach`, and all poles are not. No says nothing.
pub(crate) fn is_surely_beyond(equations: &BlochEquations, reach: f64) -> bool {
    let modes = equations.kernel().modes();
    if equations.left_out() > NEGLIGIBLE
        || modes.iter().flat_map(|mode| mode.poles()).any(|pole| modulus(pole) >= reach)
    {
        return false;
    }
    let of_shapes = || (0..modes.len()).map(|k| equations.kernel().shape_error(k)).fold(0.0, f64::max);
    let of_poles = |z: f64| {
        let poles = modes.iter().flat_map(|mode| mode.poles().into_iter().zip(mode.pole_errors()));
        poles.map(|(pole, error)| error / modulus(pole - z)).fold(0.0, f64::max)
    };
    let (mut matrix, mut sizes) = (Vec::new(), Vec::new());
    [reach, -reach].into_iter().any(|z| {
        equations.fill_real(z, &mut matrix);
        let (value, condition) = determinant_and_condition(&mut matrix, &mut sizes, equations.size());
        value < 0.0 && condition * (16.0 * f64::EPSILON + of_poles(z) + of_shapes()) < SURE
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Complex;
    use vibrochain_breather::{Family, Finder, LinearImpact, OrbitList};
    use vibrochain_lattice::{BlochKernel, Chain};
    use vibrochain_testkit::Random;

    use super::super::clusters::zeros;
    use super::super::random_equations;
    use super::*;
    use crate::analyser::Analyser;
    use crate::verdict::Tolerance;

    /// Modes below, at, little and far above critical damping: J at a real point and its determinant are those of complex numbers.
    #[test]
    fn a_real_point_is_one_of_the_plane() {
        let mut kernel = BlochKernel::new(4.0, 2);
        for (frequency, damping) in [(1.3, 0.1), (0.8, 1.0), (0.3, 1.05), (2.0, 3.0)] {
            kernel.push_oscillator(frequency, damping, &[0.7, -0.4]);
        }
        let impact = |contact: usize, time: f64, acceleration_before: f64| LinearImpact {
            contact,
            time,
            impulse: 0.6,
            restitution: 0.8,
            acceleration_before,
        };
        let equations = BlochEquations::new(kernel, vec![impact(0, 0.0, 0.3), impact(1, 1.7, -0.2)]);
        let (mut real, mut complex, mut sizes, mut checked) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for z in [1.05, -1.05, 3.0, -0.98, 40.0] {
            equations.fill_real(z, &mut real);
            equations.fill(Complex::new(z, 0.0), &mut complex, None);
            for (real, complex) in real.iter().zip(&complex) {
                assert!((complex - real).norm() < 1e-14 * (1.0 + real.abs()), "{z}: {real} {complex}");
                checked += 1;
            }
            let (one, condition) = determinant_and_condition(&mut real, &mut sizes, 4);
            let (other, known) = determinant_and_condition(&mut complex, &mut sizes, 4);
            assert!((other - one).norm() < 1e-14 * condition * one.abs() && (condition / known - 1.0).abs() < 1e-10);
        }
        assert_eq!(checked, 5 * 16);
    }

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

    /// Against the eigenvalues of a matrix.
    #[test]
    fn orbits_of_a_chain_that_are_surely_beyond_have_such_an_eigenvalue() {
        let mut random = Random(31);
        let (mut finder, mut found) = (Finder::new(1), OrbitList::default());
        let (mut analyser, mut dense) = (Analyser::default(), Analyser::dense());
        let (mut yes, mut no, mut missed, mut turned) = (0, 0, 0, 0);
        for _ in 0..400 {
            let sites = random.of(&[2, 3, 6, 11, 21]);
            let chain = Chain::new(sites, 0.2, random.of(&[1e-4, 0.1, 0.3]) * random.between(0.1, 1.0)).unwrap();
            let (asymmetry, e) = (random.between(0.0, 0.8), random.of(&[1.0, 0.99, 0.9, 0.6]));
            let point = chain.point().omega(random.between(0.4, 3.0)).asymmetry(asymmetry);
            let model = point.amplitude(random.between(0.02, 0.3)).restitution(e).model().unwrap();
            for family in [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled] {
                if finder.find(&model, family, &mut found).is_err() {
                    continue;
                }
                for orbit in &found.orbits {
                    let Ok(stability) = dense.stability(orbit, &mut finder, Tolerance::Rounding) else { continue };
                    let real = || stability.multipliers.iter().filter(|mu| mu.im == 0.0).map(|mu| mu.re);
                    for reach in [1.0, 1.3, stability.verdict.spectral_radius.max(1.0)] {
                        let told = analyser.surely_exceeds(orbit, &mut finder, reach).unwrap();
                        let beyond = |by: f64, sign: f64| real().filter(|mu| sign * mu > by * reach).count();
                        assert!(!told || beyond(1.04, 1.0) + beyond(1.04, -1.0) > 0, "{model:?} {family:?} {reach}");
                        let odd = |sign: f64| beyond(1.04, sign) == beyond(1.06, sign) && beyond(1.05, sign) % 2 == 1;
                        if told {
                            yes += 1;
                            turned += usize::from(beyond(1.04, 1.0) == 0);
                        } else if odd(1.0) || odd(-1.0) {
                            missed += 1;
                        } else {
                            no += 1;
                        }
                    }
                }
            }
        }
        assert!(yes > 300 && turned > 30 && no > 300 && 20 * missed < yes, "{yes} {turned} {no} {missed}");
    }
}
