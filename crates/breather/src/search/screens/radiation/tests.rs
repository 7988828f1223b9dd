//! What is radiated, against Fourier coefficients of the motion.

use vibrochain_lattice::{Chain, Complex, ImpulseResponse, Model, Spectrum};
use vibrochain_testkit::Random;

use super::*;
use crate::motion::Motion;
use crate::orbit::Family;
use crate::search::finder::Finder;
use crate::search::orbit_list::OrbitList;

/// Times of a period at which a motion is looked at.
const TIMES: usize = 2048;

/// An orbit is excluded exactly where a coefficient of the mass that is hit, or of the one opposite, is larger than any motion within the gap has: by
/// sums over the motion. Halves and intervals of φ exclude nothing that this allows.
#[test]
fn orbits_are_excluded_by_the_coefficients_of_their_motion() {
    let mut random = Random(101);
    let (mut finder, mut found) = (Finder::new(1), OrbitList::default());
    let (mut allowed, mut excluded, mut between, mut excluded_between) = (0, 0, 0, 0);
    for _ in 0..150 {
        let gamma1 = random.of(&[0.0, 0.2, 0.2]);
        let chain = Chain::new(1 + random.below(12), gamma1, random.between(0.02, 0.3)).unwrap();
        let omega = random.between(0.15, 1.0) * (gamma1 + 4.0 * chain.gamma2()).sqrt();
        let Ok(model) = Model::conservative(chain, omega, random.between(0.0, 0.8)) else { continue };
        let Ok(response) = ImpulseResponse::new(&Spectrum::new(chain), omega) else { continue };
        let Some(radiation) = Radiation::of(&response) else { continue };
        for family in [Family::DoubleSided, Family::SingleSided] {
            if finder.find(&model, family, &mut found).is_err() {
                continue;
            }
            for orbit in &found.orbits {
                let impacts = || orbit.impacts().iter().map(|impact| (impact.time, impact.impulse));
                let mut motion = Motion::of(orbit).unwrap();
                let mut most = 0.0_f64;
                for site in [0, chain.sites() / 2] {
                    let at = |i: usize| orbit.period() * (i as f64 + 0.5) / TIMES as f64;
                    let track: Vec<f64> = (0..TIMES).map(|i| motion.at(site, at(i)).displacement).collect();
                    for j in 1..=radiation.count {
                        let wave = |(i, u): (usize, &f64)| Complex::from_polar(*u, -(j as f64) * omega * at(i));
                        let sum: Complex<f64> = track.iter().enumerate().map(wave).sum();
                        most = most.max(sum.norm() / TIMES as f64 / FRAC_2_PI);
                    }
                }
                // Sums over times tell corners of the motion to 1e-6.
                if (most - 1.0).abs() < 1e-4 * most {
                    continue;
                }
                let allows = radiation.allows(impacts());
                assert_eq!(allows, most < 1.0, "{most} {orbit:?}");
                *[&mut excluded, &mut allowed][usize::from(allows)] += 1;
                if let [(_, first), (time, second)] = impacts().collect::<Vec<_>>()[..] {
                    // Of impulses with opposite signs: half the sum of half impulses, half their difference.
                    let (mean, difference) = (0.25 * (first - second).abs(), 0.25 * (first + second).abs());
                    let turns = time / orbit.period();
                    for width in [0.0, 1e-3, 0.1] {
                        let (from, to) = ((turns - width).max(0.0), (turns + width).min(1.0));
                        let said = radiation.allows_between(from, to, mean, difference);
                        assert!(said || !allows, "{from} {to} {orbit:?}");
                        between += 1;
                        excluded_between += usize::from(!said && width == 0.0);
                    }
                    if (turns - 0.5).abs() < 1e-12 {
                        assert_eq!(radiation.allows_at_halves([first, second]), allows);
                    }
                }
            }
        }
    }
    assert!(allowed > 60 && excluded > 60, "{allowed} {excluded}");
    assert!(between > 200 && excluded_between > 30, "{between} {excluded_between}");
}
