//! Orbits that lose an impact, touch without one, and are gone through twice: the motion stays what it is.

use std::sync::Arc;

use vibrochain_lattice::{Barrier, Complex, Contact, LinearMode, ModalStructure, ModeShape};
use vibrochain_testkit::Random;

use super::*;
use crate::structures::flight::ContactMotion;

/// Two oscillators that nothing couples, each with a stop of its own, under one load.
fn apart(random: &mut Random) -> LoadedStructure {
    let mode = |random: &mut Random, k: usize| {
        let contacts = (0..2).map(|contact| f64::from(u8::from(contact == k))).collect();
        let shape = ModeShape { contacts, coordinates: Vec::new(), still: 0.0 };
        let load = Complex::from_polar(1.0, random.between(-3.0, 3.0));
        LinearMode::oscillator(0.1, random.between(0.5, 2.0), &shape, &[load])
    };
    let modes = (0..2).map(|k| mode(random, k)).collect();
    let contact = Contact { lower: None, upper: Some(random.between(0.0, 0.3)), restitution: 0.7 };
    let structure = ModalStructure::new(vec![contact; 2], vec![1], modes).unwrap();
    LoadedStructure::new(Arc::new(structure), random.between(1.7, 3.0)).unwrap()
}

/// What one contact does at a time since the first impact.
fn at(orbit: &ContactOrbit, contact: usize, time: f64) -> [f64; 3] {
    let time = time.rem_euclid(orbit.period());
    let i = orbit.impacts().partition_point(|impact| impact.time <= time) - 1;
    ContactMotion::new(orbit).unwrap().contact(contact, i, time - orbit.impacts()[i].time)
}

/// Whichever impact is lost, the contact that keeps its own goes on as before, at the same phase of the load.
#[test]
fn an_orbit_that_loses_an_impact_keeps_its_phase() {
    let mut random = Random(17);
    let (mut first, mut second) = (0, 0);
    for _ in 0..40 {
        let model = apart(&mut random);
        let Ok(found) = model.orbits(&"0+,1+".parse().unwrap(), 1) else { continue };
        for orbit in found.contacts() {
            for lost in [0, 1] {
                let begins = if lost == 0 { orbit.impacts()[1].time } else { 0.0 };
                let kept = orbit.impacts()[1 - lost];
                for simpler in [orbit.without_impact(lost).unwrap(), orbit.exchanged(Some(lost), &[]).unwrap()] {
                    let [only] = simpler.impacts() else { panic!("{simpler:?}") };
                    assert!(only.time == 0.0 && only.site == kept.site);
                    assert!((only.impulse - kept.impulse).abs() < 1e-12);
                    for part in [0.1, 0.37, 0.8] {
                        let time = part * orbit.period();
                        let [now, then] = [at(&simpler, kept.site, time), at(orbit, kept.site, begins + time)];
                        let off = now.iter().zip(then).map(|(now, then)| (now - then).abs()).fold(0.0, f64::max);
                        assert!(off < 1e-9, "{lost} {part}: {now:?} {then:?}");
                    }
                }
                *[&mut first, &mut second][lost] += usize::from(orbit.impacts()[1].time > 0.05 * orbit.period());
            }
        }
    }
    assert!(first > 20 && second > 20, "{first} {second}");
}

/// A contact that touches without an impulse changes nothing but the list of impacts, wherever it stands in it.
#[test]
fn a_touch_leaves_the_motion_as_it_is() {
    let mut random = Random(19);
    let (mut before, mut after) = (0, 0);
    for _ in 0..40 {
        let model = apart(&mut random);
        let Ok(found) = model.orbits(&"0+".parse().unwrap(), 1) else { continue };
        for orbit in found.contacts() {
            let time = random.between(-0.9, 0.9) * orbit.period();
            let touch = Hit::new(1, Barrier::Upper, time, 0.0);
            let richer = orbit.exchanged(None, &[touch]).unwrap();
            assert_eq!(richer.hits().iter().map(|hit| hit.site).collect::<Vec<_>>(), [0, 1]);
            let place = time.rem_euclid(orbit.period());
            assert!((richer.impacts()[1].time - place).abs() < 1e-12 && richer.psi() == orbit.psi());
            for part in [0.2, 0.6] {
                let [now, then] = [&richer, orbit].map(|one| at(one, 0, part * orbit.period()));
                assert!((now[0] - then[0]).abs() < 1e-12 && (now[1] - then[1]).abs() < 1e-12);
            }
            *[&mut before, &mut after][usize::from(time > 0.0)] += 1;
        }
    }
    assert!(before > 10 && after > 10, "{before} {after}");
}

/// Of an orbit gone through twice, whose two halves are moved apart by as much either way, the means are the orbit.
#[test]
fn the_means_of_two_halves_are_the_orbit_between_them() {
    let mut random = Random(23);
    let mut checked = 0;
    for _ in 0..40 {
        let model = apart(&mut random);
        for word in ["0+", "0+,1+"] {
            let Ok(found) = model.orbits(&word.parse().unwrap(), 1) else { continue };
            for orbit in found.contacts() {
                let twice = orbit.twice().unwrap();
                assert!(twice.force_periods() == 2 && twice.violation() < 1e-9);
                let (half, by) = (orbit.impacts().len(), 1e-3 * random.between(-1.0, 1.0));
                let moved = |(i, strike): (usize, Strike)| {
                    let sign = if i < half { 1.0 } else { -1.0 };
                    let time = strike.time + sign * by * orbit.period();
                    Strike { time, impulse: strike.impulse * (1.0 + sign * by), ..strike }
                };
                let strikes: Vec<Strike> = twice.strikes().enumerate().map(moved).collect();
                let begins = strikes[0].time;
                let strikes = strikes.iter().map(|one| Strike { time: one.time - begins, ..*one }).collect();
                let psi = orbit.psi().unwrap() + begins;
                let moved = ContactOrbit::assembled(&model, 2, psi, strikes).unwrap();
                let even = moved.evened().unwrap().unwrap();
                assert_eq!(even.force_periods(), 1);
                let lapse = crate::orbit::time_between(even.psi().unwrap(), orbit.psi().unwrap(), model.period());
                assert!(lapse < 1e-9 * model.period(), "{word} {by}: {lapse}");
                for (even, one) in even.impacts().iter().zip(orbit.impacts()) {
                    assert!((even.time - one.time).abs() < 1e-9 && (even.impulse - one.impulse).abs() < 1e-9);
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 60, "{checked}");
}
