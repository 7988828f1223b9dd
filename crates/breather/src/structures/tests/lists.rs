//! What lists of orbits promise: each orbit once, none that repeats sooner, each one an orbit; without loads instants half a period apart.

use std::sync::Arc;

use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};
use vibrochain_testkit::Random;

use super::{model, orbits};
use crate::error::NoBreather;
use crate::search::completeness::{Completeness, Proof};
use crate::structures::flight::ContactMotion;
use crate::structures::model::LoadedStructure;
use crate::structures::orbit::ContactOrbit;

/// Times of a period at which motions are compared.
const TIMES: usize = 24;

/// Places of both contacts at so many times of the load, begun at phase 0: the same for one orbit, however its impacts are numbered.
fn track(orbit: &ContactOrbit) -> Vec<f64> {
    let motion = ContactMotion::new(orbit).unwrap();
    let place = |k: usize, contact: usize| {
        let time = orbit.period() * k as f64 / TIMES as f64 - orbit.psi().unwrap_or(0.0);
        let time = time.rem_euclid(orbit.period());
        let i = orbit.impacts().partition_point(|impact| impact.time <= time) - 1;
        motion.contact(contact, i, time - orbit.impacts()[i].time)[0]
    };
    (0..TIMES).flat_map(|k| [place(k, 0), place(k, 1)]).collect()
}

/// How far two tracks are apart when one of them begins so many periods of the load later.
fn apart(one: &[f64], other: &[f64], later: usize, periods: usize) -> f64 {
    let shift = 2 * TIMES * later / periods;
    let pairs = one.iter().zip(other.iter().cycle().skip(shift));
    let size = one.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / size
}

#[test]
fn an_orbit_begun_with_its_other_impact_is_the_same() {
    let mut checked = 0;
    orbits(&mut Random(12), 200, |orbit, _| {
        let [_, second] = orbit.impacts() else { return };
        let is_known = orbit.impact_errors().iter().all(|error| error.time + error.impulse < 1e-9);
        if second.time == 0.0 || !is_known {
            return;
        }
        let turned = orbit.begun_with(1).unwrap();
        assert!(turned.violation() < 1e-13 && turned.impacts()[0].time == 0.0);
        assert!(apart(&track(orbit), &track(&turned), 0, 1) < 1e-10);
        assert_eq!(turned.begun_at(orbit), Some(1));
        checked += 1;
    });
    assert!(checked > 60, "{checked}");
}

#[test]
fn no_orbit_is_listed_twice_nor_one_that_repeats_sooner() {
    let mut random = Random(83);
    let (mut lists, mut pairs, mut doubled) = (0, 0, 0);
    for _ in 0..120 {
        let model = model(&mut random);
        for (word, periods) in [("0+", 1), ("0+,0+", 1), ("0+,0+", 2), ("1-,1+", 1), ("0+,1-", 2), ("1-,1+,1+", 1)] {
            let Ok(found) = model.orbits(&word.parse().unwrap(), periods) else { continue };
            let tracks: Vec<Vec<f64>> = found.contacts().map(track).collect();
            for (n, own) in tracks.iter().enumerate() {
                for (m, other) in tracks[..n].iter().enumerate() {
                    for later in 0..periods as usize {
                        let away = apart(own, other, later, periods as usize);
                        assert!(
                            away > 1e-6,
                            "{word} {periods}: {n} and {m} are one, {later} later\n{:?}",
                            found.orbits
                        );
                        pairs += 1;
                    }
                }
                // After every part of its periods it is somewhere else.
                if periods == 2 {
                    assert!(apart(own, own, 1, 2) > 1e-6, "{word}: {n} has one period");
                    doubled += 1;
                }
            }
            lists += usize::from(tracks.len() > 1);
        }
    }
    assert!(lists > 100 && pairs > 300 && doubled > 40, "{lists} {pairs} {doubled}");
}

/// One mass between stops at −1 and .7, of frequency 1, by what is known by hand. Above twice its frequency the only impact a period that meets the
/// stop pulls; two impacts alike are the one of twice the frequency; a load far below what an impact loses has no phase.
#[test]
fn an_empty_list_says_why() {
    let model = |omega: f64, restitution: f64, load: f64| {
        let shape = ModeShape { contacts: vec![1.0], coordinates: Vec::new(), still: 0.0 };
        let (loads, harmonics) = if load > 0.0 { (vec![Complex::new(load, 0.0)], vec![1]) } else { Default::default() };
        let mode = LinearMode::oscillator(0.0, 1.0, &shape, &loads);
        let stop = Contact { lower: Some(-1.0), upper: Some(0.7), restitution };
        let structure = ModalStructure::new(vec![stop], harmonics, vec![mode]).unwrap();
        LoadedStructure::new(Arc::new(structure), omega).unwrap()
    };
    let (word, twice) = ("0+".parse().unwrap(), "0+,0+".parse().unwrap());
    let proved = Completeness::All(Proof::ClosedForm);
    for (omega, pushes) in [(1.5, true), (2.5, false)] {
        let model = model(omega, 1.0, 0.0);
        let [all, candidates] = [model.orbits(&word, 1).unwrap(), model.candidates(&word, 1).unwrap()];
        assert_eq!((all.orbits.len(), all.completeness), (1, proved), "{omega}");
        // What pulls has been found, and is left out.
        assert_eq!((candidates.orbits.len(), candidates.completeness), (usize::from(pushes), proved), "{omega}");
    }
    let repeated = model(1.5, 1.0, 0.0).orbits(&twice, 1).unwrap();
    assert!(repeated.orbits.is_empty() && repeated.completeness.is_established(), "{repeated:?}");
    assert_eq!(repeated.completeness.reason(), Some(NoBreather::RepeatsSooner), "{repeated:?}");
    let weak = model(1.5, 0.8, 1e-6).orbits(&word, 1).unwrap();
    let none = Completeness::None { reason: NoBreather::NoPhase, by: Some(Proof::ClosedForm) };
    assert_eq!((weak.orbits.len(), weak.completeness), (0, none));
}

/// Contacts are on their barriers at impacts, where Newton's law holds from one flight to the next, and the motion repeats: by the flights, which
/// know nothing of the equations. Candidates are those of all that push.
#[test]
fn what_is_listed_are_orbits() {
    let mut random = Random(89);
    let (mut impacts, mut pulled) = (0, 0);
    let check = |orbit: &ContactOrbit| {
        let motion = ContactMotion::new(orbit).unwrap();
        let n = orbit.impacts().len();
        for i in 0..n {
            let (before, impact) = ((i + n - 1) % n, orbit.impacts()[i]);
            let contact = impact.site;
            let ([from, arrives, _], [to, leaves, _]) =
                (motion.contact(contact, before, motion.until_next(before)), motion.contact(contact, i, 0.0));
            let stop = orbit.model().barrier(contact, impact.barrier).unwrap();
            let e = orbit.model().structure().contacts()[contact].restitution;
            let size = 1.0 + arrives.abs();
            assert!((from - stop).abs() < 1e-8 * size && (to - stop).abs() < 1e-8 * size, "{i}: {from} {to} {stop}");
            assert!((leaves + e * arrives).abs() < 1e-8 * size, "{i} {leaves} {arrives}");
        }
        n
    };
    for _ in 0..60 {
        let model = model(&mut random);
        for word in ["0+", "1-,1+", "0+,1-", "0+,0+"] {
            let word = word.parse().unwrap();
            let Ok(found) = model.orbits(&word, 1) else { continue };
            impacts += found.contacts().map(check).sum::<usize>();
            let pushes = |orbit: &&ContactOrbit| {
                orbit.impacts().iter().all(|impact| impact.barrier.sign() * impact.impulse < 0.0)
            };
            let candidates = model.candidates(&word, 1).unwrap();
            let pushing: Vec<_> = found.contacts().filter(pushes).collect();
            assert_eq!(candidates.contacts().filter(pushes).collect::<Vec<_>>(), pushing);
            pulled += found.orbits.len() - pushing.len();
        }
    }
    assert!(impacts > 200 && pulled > 30, "{impacts} {pulled}");
}

/// Without loads and losses half a period between two impacts is on each list once, and that orbit is its own mirror image in time.
#[test]
fn half_periods_are_listed_without_loads() {
    let mut random = Random(97);
    let (mut halves, mut others) = (0, 0);
    for _ in 0..60 {
        let count = 1 + random.below(4);
        let modes = (0..count).map(|_| {
            let contacts = vec![random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
            let shape = ModeShape { contacts, coordinates: Vec::new(), still: 0.0 };
            LinearMode::oscillator(0.0, random.log(0.1, 9.0), &shape, &[])
        });
        let modes = modes.collect();
        let stops = Contact { lower: Some(-random.log(0.1, 1.0)), upper: Some(random.log(0.1, 1.0)), restitution: 1.0 };
        let structure = Arc::new(ModalStructure::new(vec![stops; 2], Vec::new(), modes).unwrap());
        let model = LoadedStructure::new(structure, random.between(0.5, 3.0)).unwrap();
        for word in ["0-,0+", "0+,1-"] {
            let Ok(found) = model.orbits(&word.parse().unwrap(), 1) else { continue };
            let half = 0.5 * model.period();
            let is_half = |orbit: &&ContactOrbit| (orbit.impacts()[1].time - half).abs() < 1e-9 * half;
            assert_eq!(found.contacts().filter(is_half).count(), 1, "{word} {found:?}");
            halves += 1;
            for orbit in found.contacts() {
                let motion = ContactMotion::new(orbit).unwrap();
                // Reversed in time about its impacts it is the same motion.
                let whole = motion.until_next(0);
                for (contact, part) in [(0, 0.2), (1, 0.2), (0, 0.7), (1, 0.7)] {
                    if is_half(&orbit) {
                        let there = motion.contact(contact, 0, part * whole);
                        let back = motion.contact(contact, 1, (1.0 - part) * whole);
                        let size = 1.0 + there[0].abs() + there[1].abs();
                        assert!((there[0] - back[0]).abs() < 1e-8 * size && (there[1] + back[1]).abs() < 1e-8 * size);
                    }
                }
                others += usize::from(!is_half(&orbit));
            }
        }
    }
    assert!(halves > 60 && others > 10, "{halves} {others}");
}

/// What differs between two halves of a period is that of the impacts; of one impact there are no halves, and nothing is across.
#[test]
fn halves_of_an_orbit_differ_as_its_impacts_do() {
    let (mut single, mut double, mut by_time) = (0, 0, 0);
    orbits(&mut Random(101), 60, |orbit, _| {
        assert!(!orbit.is_across(orbit), "{orbit:?}");
        match orbit.impacts() {
            [_] => {
                assert!(orbit.unevenness().is_empty());
                single += 1;
            }
            [first, second] => {
                let [one, other] = [first, second].map(|impact| impact.impulse.abs());
                let flights = [second.time, orbit.period() - second.time];
                // Impulses on barriers that are not as far away differ by that.
                let alike = orbit.is_centred() || first.barrier == second.barrier;
                let impulses = alike.then_some((other - one) / one.max(other));
                let uneven = impulses.into_iter().chain([(flights[1] - flights[0]) / orbit.period()]);
                let told = orbit.unevenness();
                assert_eq!(told.len(), if alike { 2 } else { 1 });
                for (told, right) in told.into_iter().zip(uneven) {
                    assert!((told - right).abs() < 1e-14, "{told} {right}");
                }
                by_time += usize::from(!alike);
                double += 1;
            }
            _ => {}
        }
    });
    assert!(single > 10 && double > 10 && by_time > 5, "{single} {double} {by_time}");
}

/// One contact between two stops, without loads and losses: where K′ of the sampled kernel changes its sign there is an orbit, and nowhere else.
#[test]
fn between_two_stops_without_losses_every_zero_of_the_kernel_has_an_orbit() {
    const SAMPLES: usize = 4000;
    let mut random = Random(97);
    let (mut halves, mut others, mut rigid) = (0, 0, 0);
    for _ in 0..150 {
        let mode = |random: &mut Random, frequency: f64| {
            let shape = ModeShape { contacts: vec![random.between(-1.0, 1.0)], coordinates: Vec::new(), still: 0.0 };
            LinearMode::oscillator(0.0, frequency * frequency, &shape, &[])
        };
        let mut modes: Vec<_> = (0..1 + random.below(6)).map(|_| random.log(0.3, 4.0)).collect();
        let is_rigid = random.chance(0.2);
        modes.extend(is_rigid.then_some(0.0));
        let modes = modes.into_iter().map(|frequency| mode(&mut random, frequency)).collect();
        let stop = Contact { lower: Some(-random.log(0.3, 2.0)), upper: Some(random.log(0.3, 2.0)), restitution: 1.0 };
        let structure = Arc::new(ModalStructure::new(vec![stop], Vec::new(), modes).unwrap());
        let model = LoadedStructure::new(structure.clone(), random.log(0.3, 3.0)).unwrap();
        let Ok(found) = model.orbits(&"0+,0-".parse().unwrap(), 1) else { continue };
        if !found.completeness.is_established() {
            continue;
        }
        let period = model.period();
        let at = |i: usize| period * (i as f64 + 0.5) / SAMPLES as f64;
        let held_by_nothing = structure.modes().iter().filter(|mode| mode.is_rigid());
        let weight: f64 = held_by_nothing.map(|mode| mode.rows[0][0].powi(2)).sum();
        let slope = |t: f64| regular(&structure, period, t) + weight * (0.5 - t / period);
        let values: Vec<f64> = (0..SAMPLES).map(|i| slope(at(i))).collect();
        let mut changes = 0;
        for (i, pair) in values.windows(2).enumerate() {
            if pair[0] * pair[1] < 0.0 {
                let here = |orbit: &&ContactOrbit| (at(i)..at(i + 1)).contains(&orbit.phi().unwrap());
                assert_eq!(found.contacts().filter(here).count(), 1, "{i} {found:?}");
                changes += 1;
            }
        }
        // Two zeros between two samples may be missed here.
        assert!(found.orbits.len() == changes || found.orbits.len() == changes + 2, "{changes} {found:?}");
        let is_half = |orbit: &&ContactOrbit| (orbit.phi().unwrap() - 0.5 * period).abs() < 1e-12 * period;
        assert_eq!(found.contacts().filter(is_half).count(), 1);
        halves += 1;
        others += changes - 1;
        rigid += usize::from(is_rigid);
    }
    assert!(halves > 100 && others > 100 && rigid > 15, "{halves} {others} {rigid}");
}

/// K′ of the modes that something holds, by the sum over all past impulses.
fn regular(structure: &ModalStructure, period: f64, t: f64) -> f64 {
    let mode = |mode: &LinearMode| {
        let z = Complex::from_polar(1.0, mode.rate * period);
        mode.rows[0][0].powi(2) * (Complex::from_polar(1.0, mode.rate * t) / (1.0 - z)).re
    };
    structure.modes().iter().filter(|mode| !mode.is_rigid()).map(mode).sum()
}
