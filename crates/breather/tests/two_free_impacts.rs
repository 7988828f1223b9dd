//! Lists of two impacts without loads and losses, with proof: of chains as structures against the families' own search, and of any structure
//! against Newton's method from many starts.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::sync::Arc;

use vibrochain_breather::{Completeness, Family, Hit, LoadedStructure, Orbit, Proof, breathers};
use vibrochain_lattice::{Barrier, Contact, DMatrix, DVector, LinearMode, ModalStructure, ModeShape, Point, Structure};
use vibrochain_testkit::Random;

/// Times and impulses of an orbit's two impacts.
type Told = [f64; 3];

fn is_among(own: &Told, list: &[Told]) -> bool {
    list.iter().any(|other| (0..3).all(|i| (own[i] - other[i]).abs() < 1e-7 * (1.0 + own[i].abs())))
}

/// A ring of equal masses, the first of them between its barriers.
fn ring(sites: usize, [gamma1, gamma2, asymmetry]: [f64; 3]) -> ModalStructure {
    let mut stiffness = DMatrix::identity(sites, sites) * gamma1;
    for n in 0..sites {
        let next = (n + 1) % sites;
        for (i, j, sign) in [(n, n, 1.0), (next, next, 1.0), (n, next, -1.0), (next, n, -1.0)] {
            stiffness[(i, j)] += sign * gamma2;
        }
    }
    let contact = Contact { lower: Some(asymmetry - 1.0), upper: Some(asymmetry + 1.0), restitution: 1.0 };
    let first = DVector::from_fn(sites, |n, _| if n == 0 { 1.0 } else { 0.0 });
    let mass = DMatrix::identity(sites, sites);
    Structure { mass, stiffness, contacts: vec![(first, contact)], ..Structure::default() }.modal().unwrap()
}

#[test]
fn a_ring_has_the_orbits_of_its_family() {
    let mut random = Random(17);
    let (mut compared, mut uneven) = (0, 0);
    for _ in 0..150 {
        let (sites, omega) = (3 + random.below(6), random.between(0.3, 3.0));
        let [gamma1, gamma2] = [random.between(0.1, 1.0), random.log(1e-2, 0.3)];
        let asymmetry = random.between(0.0, 0.6);
        let model = Point::ring(sites).gamma1(gamma1).gamma2(gamma2).omega(omega).asymmetry(asymmetry).model().unwrap();
        let Ok(family) = breathers(&model, Family::DoubleSided) else { continue };
        if !matches!(family.completeness, Completeness::All(_)) {
            continue;
        }
        let structure = LoadedStructure::new(Arc::new(ring(sites, [gamma1, gamma2, asymmetry])), omega).unwrap();
        let Ok(found) = structure.orbits(&"0+,0-".parse().unwrap(), 1) else { continue };
        if !found.completeness.is_established() {
            continue;
        }
        let by_structure: Vec<Told> = (found.orbits.iter())
            .map(|orbit| [0, 1].map(|i| orbit.impacts()[i]))
            .map(|impacts| [impacts[1].time, impacts[0].impulse, impacts[1].impulse])
            .collect();
        let by_family: Vec<Told> = (family.orbits.iter())
            .map(|orbit| {
                let [a, b] = [0, 1].map(|i| orbit.impacts()[i]);
                // From the upper barrier on.
                let (upper, lower) = if a.barrier == Barrier::Upper { (a, b) } else { (b, a) };
                [(lower.time - upper.time).rem_euclid(orbit.period()), upper.impulse, lower.impulse]
            })
            .collect();
        for own in &by_family {
            assert!(is_among(own, &by_structure), "{sites} {omega}: {own:?} not in {by_structure:?}");
            uneven += usize::from((own[0] * omega - std::f64::consts::PI).abs() > 1e-6);
        }
        for own in &by_structure {
            assert!(is_among(own, &by_family), "{sites} {omega}: {own:?} not in {by_family:?}");
        }
        compared += usize::from(!by_family.is_empty());
    }
    assert!(compared > 60 && uneven > 20, "{compared} {uneven}");
}

#[test]
fn any_structure_has_all_orbits_that_starts_lead_to() {
    let mut random = Random(5);
    let (mut complete, mut led) = (0, 0);
    for round in 0..60 {
        let mut mode = || {
            let contacts = vec![random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
            let shape = ModeShape { contacts, coordinates: Vec::new(), still: random.between(-0.1, 0.1) };
            LinearMode::oscillator(0.0, random.log(0.1, 9.0), &shape, &[])
        };
        let modes = (0..1 + round % 4).map(|_| mode()).collect();
        let contact = || Contact { lower: Some(-0.3), upper: Some(0.2), restitution: 1.0 };
        let structure = ModalStructure::new(vec![contact(), contact()], vec![], modes).unwrap();
        let model = LoadedStructure::new(Arc::new(structure), random.between(0.5, 3.0)).unwrap();
        let letters =
            [(0, Barrier::Upper), random.of(&[(0, Barrier::Lower), (1, Barrier::Upper), (1, Barrier::Lower)])];
        let word = if letters[1].0 == 0 {
            "0+,0-"
        } else if letters[1].1 == Barrier::Upper {
            "0+,1+"
        } else {
            "0+,1-"
        };
        let Ok(found) = model.orbits(&word.parse().unwrap(), 1) else { continue };
        if let Completeness::Open { .. } = found.completeness {
            continue;
        }
        let proof = found.completeness.proof();
        assert!(matches!(proof, Some(Proof::Enclosures { .. })), "{:?}", found.completeness);
        complete += 1;
        let told = |orbit: &Orbit| {
            let impacts = orbit.impacts();
            [impacts[1].time, impacts[0].impulse, impacts[1].impulse]
        };
        let list: Vec<Told> = found.orbits.iter().map(told).collect();
        for _ in 0..200 {
            let impact = |i: usize, time: f64, size: f64| {
                Hit::new(letters[i].0, letters[i].1, time, -letters[i].1.sign() * size)
            };
            let hits = [
                impact(0, 0.0, random.log(0.01, 3.0)),
                impact(1, model.period() * random.between(0.01, 0.99), random.log(0.01, 3.0)),
            ];
            let Ok(orbit) = model.orbit_near(1, 0.0, &hits) else { continue };
            let own = told(&orbit);
            let apart = own[0] / model.period();
            if !(2e-4..1.0 - 2e-4).contains(&apart) || own[1].abs().min(own[2].abs()) < 1e-6 {
                continue;
            }
            led += 1;
            assert!(is_among(&own, &list), "{round} {word}: {own:?} not in {list:?}");
        }
    }
    assert!(complete > 50 && led > 1000, "{complete} {led}");
}
