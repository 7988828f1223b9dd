//! Lists of one mass next to the resonances of its spring with the load, against numbers of many digits.

use std::sync::Arc;

use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};

use crate::search::orbit_list::OrbitList;
use crate::structures::model::LoadedStructure;

/// A mass on a spring of stiffness 1 between two stops.
fn mass(omega: f64, load: f64) -> LoadedStructure {
    let shape = ModeShape { contacts: vec![1.0], coordinates: Vec::new(), still: 0.0 };
    let mode = LinearMode::oscillator(0.0, 1.0, &shape, &[Complex::new(load, 0.0)]);
    let stops = Contact { lower: Some(-0.6), upper: Some(0.5), restitution: 0.8 };
    LoadedStructure::new(Arc::new(ModalStructure::new(vec![stops], vec![1], vec![mode]).unwrap()), omega).unwrap()
}

/// Parts of the period of φ and ψ.
fn places(found: &OrbitList) -> Vec<[f64; 2]> {
    let part = |time: Option<f64>, period: f64| time.unwrap() / period;
    found.orbits.iter().map(|orbit| [part(orbit.phi(), orbit.period()), part(orbit.psi(), orbit.period())]).collect()
}

/// However close the load is to the frequency of the mass, there are the same two orbits: their digits at 1e-8 are of an integration of 40 digits,
/// and all others move with the distance.
#[test]
fn the_orbits_of_a_mass_next_to_the_frequency_of_its_load() {
    let known = [-1.118194507670, 1.305054853839, 4.505499769813];
    for off in [1e-3, 1e-5, 1e-8, 1e-10, 1e-12, 1e-13, -1e-13, -1e-12, -1e-8, -1e-6, -1e-3] {
        let found = mass(1.0 + off, 0.6).orbits(&"0+,0-".parse().unwrap(), 1).unwrap();
        assert!(found.completeness.is_established() && found.orbits.len() == 2, "{off} {found:?}");
        let orbit = &found.orbits[1];
        let numbers = [orbit.impulses()[0], orbit.impulses()[1], orbit.phi().unwrap()];
        let room = if off == 1e-8 { 2e-12 } else { 12.0 * (off - 1e-8f64).abs() };
        for (number, known) in numbers.iter().zip(known) {
            assert!((number - known).abs() < room, "{off} {number} {known}");
        }
        let errors = found.contacts().nth(1).unwrap().impact_errors();
        assert!(errors.iter().all(|error| error.impulse < 1e-8), "{off} {:?}", orbit.impacts());
    }
}

/// Where the load has half the frequency of the mass, Δ vanishes with its numerators about T/4, T/2 and 3T/4: pairs of zeros of F lie as close as the
/// square of the distance, far apart in ψ.
#[test]
fn pairs_that_the_time_between_the_impacts_hardly_tells_apart() {
    let known = [
        (
            0.5005,
            [
                [0.1841587, 0.6496],
                [0.2497478, 0.6189],
                [0.2497537, 0.1358],
                [0.5, 0.1846],
                [0.5, 0.8199],
                [0.7502463, 0.3856],
                [0.7502522, 0.8687],
                [0.8158475, 0.3504],
            ],
        ),
        (
            0.50005,
            [
                [0.1846428, 0.6493],
                [0.2499747, 0.6168],
                [0.2499753, 0.1337],
                [0.5, 0.1826],
                [0.5, 0.8179],
                [0.7500247, 0.3837],
                [0.7500253, 0.8668],
                [0.8153578, 0.3506],
            ],
        ),
    ];
    for (omega, known) in known {
        let found = mass(omega, 1.0).orbits(&"0+,0-".parse().unwrap(), 1).unwrap();
        let places = places(&found);
        assert!(found.completeness.is_established() && places.len() == 8, "{omega} {found:?}");
        for (place, known) in places.iter().zip(known) {
            assert!(
                (place[0] - known[0]).abs() < 6e-8 && (place[1] - known[1]).abs() < 6e-5,
                "{omega} {place:?} {known:?}"
            );
        }
    }
    // As the distance goes to 0 they come to rest, and all eight stay.
    let [_, (_, rest)] = known;
    for off in [1e-7, 1e-9, 1e-11, 1e-13, -1e-6, -1e-10] {
        let found = mass(0.5 * (1.0 + off), 1.0).orbits(&"0+,0-".parse().unwrap(), 1).unwrap();
        let places = places(&found);
        assert!(found.completeness.is_established() && places.len() == 8, "{off} {found:?}");
        for known in rest {
            let near = |place: &&[f64; 2]| (place[0] - known[0]).abs() < 1e-4 && (place[1] - known[1]).abs() < 1e-3;
            assert_eq!(places.iter().filter(near).count(), 1, "{off} {places:?} {known:?}");
        }
    }
}
