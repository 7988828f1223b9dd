//! Whether an orbit surely has a real multiplier beyond some modulus, as [`crate::spectrum::is_surely_beyond`] tells it: a map asks so of orbits that
//! are no better than one it has. Of two that are born in a fold one has such a multiplier; a sign takes a small part of what a verdict
//! takes.

use nalgebra::Complex;
use vibrochain_breather::Prepared;
use vibrochain_breather::linear::determinant_and_condition;

use crate::map_paths::one_contact::impact_matrix::ImpactMatrix;
use crate::map_paths::one_contact::verdict::ForcedSecular;
use crate::spectrum::SURE;

impl ForcedSecular {
    /// A real multiplier is surely beyond `reach` or −`reach`, which is more than 1. No says nothing.
    pub(crate) fn is_beyond(&mut self, prepared: Prepared<'_>, reach: f64) -> bool {
        let matrix = self.matrix_for(prepared);
        reach > 1.0 && [reach, -reach].into_iter().any(|z| matrix.is_surely_negative(z))
    }
}

impl ImpactMatrix {
    /// det K̂ at real z has this sign beyond its errors.
    fn is_surely_negative(&mut self, z: f64) -> bool {
        let z = Complex::new(z, 0.0);
        let of_poles = self.modes.iter().map(|mode| mode.error).fold(0.0, f64::max) / self.nearest_poles(z);
        if self.fill(z).is_none() {
            return false;
        }
        let (value, condition) = determinant_and_condition(&mut self.entries, &mut self.moduli, 2 * self.impacts);
        value.re < 0.0 && condition * (16.0 * f64::EPSILON + of_poles) < SURE
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_breather::{Family, Finder, Found};
    use vibrochain_lattice::{Chain, Model};
    use vibrochain_testkit::Random;

    use crate::analyser::Analyser;
    use crate::verdict::Tolerance;

    /// Against the eigenvalues of a matrix.
    #[test]
    fn a_yes_is_a_real_multiplier_beyond_and_is_said_wherever_one_is_alone_there() {
        let mut random = Random(31);
        let (mut finder, mut found) = (Finder::new(1), Found::default());
        let (mut analyser, mut dense) = (Analyser::default(), Analyser::dense());
        let (mut yes, mut no, mut missed, mut turned) = (0, 0, 0, 0);
        for _ in 0..400 {
            let sites = random.of(&[2, 3, 6, 11, 21]);
            let chain = Chain::new(sites, 0.2, random.of(&[1e-4, 0.1, 0.3]) * random.between(0.1, 1.0)).unwrap();
            let (asymmetry, e) = (random.between(0.0, 0.8), random.of(&[1.0, 0.99, 0.9, 0.6]));
            let model =
                Model::forced(chain, random.between(0.4, 3.0), asymmetry, random.between(0.02, 0.3), e).unwrap();
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
