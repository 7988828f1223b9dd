//! What an orbit says of its impacts, worked out in one pass over the modes where one site of a small ring is hit, against its motion at
//! the same instant, mass by mass.

use vibrochain_breather::{Family, Finder, Motion, OrbitList};
use vibrochain_lattice::{Chain, Model};

#[test]
fn accelerations_at_impacts_are_those_of_the_motion() {
    let mut random = fastrand::Rng::with_seed(5);
    let (mut finder, mut found) = (Finder::new(1), OrbitList::default());
    let mut compared = [0; 2];
    for _ in 0..1500 {
        let sites = [1, 2, 3, 4, 5, 6, 11, 21, 40][random.usize(0..9)];
        let gamma1 = [1e-3, 0.2, 0.2, 40.0][random.usize(0..4)];
        let gamma2 = [0.0, 1e-9, 0.1, 0.3, 5.0][random.usize(0..5)] * random.f64();
        let chain = Chain::new(sites, gamma1, gamma2).unwrap();
        let (omega, asymmetry) = (0.3 + 3.0 * random.f64(), 0.9 * random.f64());
        let forced = random.bool();
        let model = match forced {
            true => chain.point().omega(omega).asymmetry(asymmetry).amplitude(0.1).restitution(0.9).model(),
            false => Model::conservative(chain, omega, asymmetry),
        };
        let model = model.unwrap();
        for family in [Family::DoubleSided, Family::SingleSided] {
            if finder.find(&model, family, &mut found).is_err() {
                continue;
            }
            for orbit in &found.orbits {
                let mut motion = Motion::of(orbit).unwrap();
                for impact in orbit.impacts() {
                    let now = motion.at(impact.site, impact.time);
                    let largest = motion.modes().iter().flatten().fold(1.0, |most: f64, part| most.max(part.abs()));
                    let size = largest * (1.0 + gamma1 + 4.0 * gamma2) * sites as f64;
                    let off = [
                        impact.acceleration - now.acceleration,
                        orbit.model().unwrap().barrier(impact.barrier) - now.displacement,
                        impact.velocity_after - now.velocity,
                    ];
                    assert!(off.iter().all(|off| off.abs() < 1e-13 * size), "{off:?} {size} {impact:?} {model:?}");
                    compared[usize::from(forced)] += 1;
                }
            }
        }
    }
    assert!(compared.iter().all(|&count| count > 500), "{compared:?}");
}
