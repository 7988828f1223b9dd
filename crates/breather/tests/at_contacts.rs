//! What contacts know of a lattice's orbit follows from the orbit's data, whether it was found so or is worked out later.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{ContactOrbit, Family, breathers};
use vibrochain_lattice::{Complex, Stop};
use vibrochain_testkit::{Random, Ranges};

/// To the last bit: an orbit that comes back from a file is told no other multipliers.
#[test]
fn an_orbit_made_again_from_its_data_is_known_alike() {
    let (mut random, stop, z) = (Random(31), Stop::default(), Complex::new(0.3, 0.7));
    let mut seen = [0; 3];
    for round in 0..150 {
        let model = random.model(&Ranges::FORCED);
        let which = round % 3;
        let family = [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled][which];
        let Ok(found) = breathers(&model, family) else { continue };
        for orbit in &found.orbits {
            if orbit.residual() > 1e-14 {
                // Next to a resonance it is refined.
                continue;
            }
            let found = orbit.at_contacts(&stop).unwrap();
            let again = ContactOrbit::of_orbit(orbit, &stop).unwrap();
            assert_eq!(found.impacts(), again.impacts(), "{model}");
            assert_eq!(found.error_origins(), again.error_origins(), "{model}");
            let [one, other] = [found, again.into()].map(|known| known.bloch_equations().0.matrix(z));
            assert_eq!(one, other, "{model}");
            seen[which] += 1;
        }
    }
    assert!(seen.iter().all(|count| *count > 40), "{seen:?}");
}
