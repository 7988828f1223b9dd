//! Orbits of any linear structure against tests/data/structures.json and dense state matrices: exponentials, saltations, brackets.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use serde_json::Value;
use vibrochain_breather::{Completeness, ContactMotion, Hit, LoadedStructure, Orbit, Word, admissibility};
use vibrochain_floquet::{Analyser, BlochProblem, Complex, Tolerance, Verdict, stability};
use vibrochain_lattice::{Barrier, Contact, LinearMode, ModalStructure, ModeShape, Structure};
use vibrochain_testkit::{Random, Structure as Dense, structures};

/// A case of the table as the library has it, with its barriers.
struct Case {
    dense: Dense,
    modal: Arc<ModalStructure>,
    force_periods: u32,
    sides: Vec<Barrier>,
    radius: f64,
    physical: bool,
    word: Word,
}

fn modal(dense: &Dense, contacts: &[Contact]) -> ModalStructure {
    let structure = Structure {
        mass: dense.mass.clone(),
        damping: dense.damping.clone(),
        stiffness: dense.stiffness.clone(),
        contacts: dense.contacts.iter().cloned().zip(contacts.iter().copied()).collect(),
        static_load: dense.static_load.clone(),
        loads: vec![(1, dense.load.map(|load| Complex::new(load, 0.0)))],
        modes: None,
    };
    structure.modal().unwrap()
}

fn cases() -> Vec<Case> {
    let table: Value = serde_json::from_str(include_str!("data/structures.json")).unwrap();
    let cases = table["cases"].as_array().unwrap();
    let case = |(dense, value): (Dense, &Value)| {
        let contact = |contact: &Value| Contact {
            lower: contact["lower"].as_f64(),
            upper: contact["upper"].as_f64(),
            restitution: contact["restitution"].as_f64().unwrap(),
        };
        let contacts: Vec<Contact> = value["contacts"].as_array().unwrap().iter().map(contact).collect();
        let side = |impact: &Value| if impact["side"] == "upper" { Barrier::Upper } else { Barrier::Lower };
        let sides: Vec<Barrier> = value["impacts"].as_array().unwrap().iter().map(side).collect();
        let letter = |(impact, side): (&vibrochain_testkit::StructureImpact, &Barrier)| {
            format!("{}{}", impact.contact, if *side == Barrier::Upper { '+' } else { '-' })
        };
        // Impacts of one instant without a comma between them.
        let mut text = String::new();
        for (n, (impact, side)) in dense.impacts.iter().zip(&sides).enumerate() {
            if n > 0 && impact.time > dense.impacts[n - 1].time {
                text.push(',');
            }
            text.push_str(&letter((impact, side)));
        }
        let word = text.parse().unwrap();
        Case {
            modal: Arc::new(modal(&dense, &contacts)),
            force_periods: value["force_periods"].as_u64().unwrap() as u32,
            sides,
            radius: value["spectral_radius"].as_f64().unwrap(),
            physical: value["physical"].as_bool().unwrap(),
            word,
            dense,
        }
    };
    structures().into_iter().zip(cases).map(case).collect()
}

impl Case {
    fn model(&self) -> LoadedStructure {
        LoadedStructure::new(self.modal.clone(), self.dense.omega).unwrap()
    }

    fn refined(&self) -> Orbit {
        let impacts = self.dense.impacts.iter().zip(&self.sides);
        let impacts: Vec<_> =
            impacts.map(|(impact, side)| Hit::new(impact.contact, *side, impact.time, impact.impulse)).collect();
        self.model().orbit_near(self.force_periods, self.dense.psi, &impacts).unwrap()
    }

    /// Whether it is the orbit of the table, whichever impact it begins with.
    fn is_it(&self, orbit: &Orbit) -> bool {
        let (n, period) = (orbit.impacts().len(), orbit.period());
        n == self.dense.impacts.len()
            && (0..n).any(|turn| {
                let begins = self.dense.impacts[turn].time;
                (0..n).all(|i| {
                    let (found, told) = (&orbit.impacts()[i], &self.dense.impacts[(i + turn) % n]);
                    let apart = (found.time - (told.time - begins)).rem_euclid(period);
                    found.site == told.contact
                        && apart.min(period - apart) < 1e-9
                        && (found.impulse - told.impulse).abs() < 1e-9 * (1.0 + told.impulse.abs())
                })
            })
    }
}

#[test]
fn orbits_of_the_table_are_orbits() {
    let cases = cases();
    let mut worst: f64 = 0.0;
    for case in &cases {
        let orbit = case.refined();
        assert!(orbit.residual() < 1e-11, "{}: {:e}", case.dense.name, orbit.residual());
        for (found, told) in orbit.impacts().iter().zip(&case.dense.impacts) {
            let off =
                (found.time - told.time).abs().max((found.impulse - told.impulse).abs() / (1.0 + told.impulse.abs()));
            assert!(off < 1e-10, "{}: {off:e}", case.dense.name);
            worst = worst.max(off);
        }
        let before = case.dense.before();
        for (found, told) in orbit.impacts().iter().zip(&before) {
            let scale = 1.0 + told.acceleration.abs();
            assert!((found.velocity_before - told.velocity).abs() < 1e-9, "{}", case.dense.name);
            let off = (found.acceleration - told.acceleration).abs();
            assert!(off < 1e-8 * scale, "{}: {off:e} {found:?} {told:?}", case.dense.name);
        }
        let physical = admissibility(&orbit).unwrap();
        assert_eq!(physical.is_physical(), case.physical, "{}: {physical:?}", case.dense.name);
    }
    println!("{worst:e}");
    assert!(cases.len() == 24 && cases.iter().filter(|case| !case.physical).count() >= 4);
}

#[test]
fn multipliers_of_the_table_are_those_of_the_monodromy_matrix() {
    let mut compared = 0;
    for case in cases() {
        let orbit = case.refined();
        let stability = stability(&orbit, Tolerance::Rounding).unwrap();
        let alone = vibrochain_floquet::stability(&orbit, Tolerance::Rounding).map(|known| known.verdict).unwrap();
        let off = (alone.spectral_radius - stability.verdict.spectral_radius).abs();
        assert!(off <= 2.0 * (alone.resolution + stability.verdict.resolution), "{}: {alone:?}", case.dense.name);
        assert_eq!(alone.stable, stability.verdict.stable, "{}", case.dense.name);
        let trivial = orbit.is_conservative();
        let allowed = if trivial { 1e-6 } else { 1e-8 };
        let radius = stability.multipliers[0].norm();
        assert!(
            (radius - case.radius).abs() < allowed * (1.0 + radius),
            "{}: {radius} {}",
            case.dense.name,
            case.radius
        );
        let mut open: Vec<_> = case.dense.monodromy().complex_eigenvalues().iter().copied().collect();
        assert_eq!(stability.multipliers.len(), open.len(), "{}", case.dense.name);
        for z in &stability.multipliers {
            let distance = |w: &Complex<f64>| (w - z).norm();
            let nearest = (0..open.len()).min_by(|&i, &j| distance(&open[i]).total_cmp(&distance(&open[j]))).unwrap();
            let off = distance(&open.swap_remove(nearest));
            assert!(off < (if trivial { 1e-6 } else { 1e-8 }) * (1.0 + radius), "{}: {z} {off:e}", case.dense.name);
            compared += 1;
        }
    }
    assert!(compared > 150, "{compared}");
}

#[test]
fn words_of_the_table_are_found_without_a_start() {
    let (mut found_count, mut short, mut missed) = (0, 0, Vec::new());
    for case in cases() {
        let Ok(found) = case.model().orbits(&case.word, case.force_periods) else {
            missed.push(format!("{} {}", case.dense.name, case.word));
            continue;
        };
        let is_found = found.orbits.iter().any(|orbit| case.is_it(orbit));
        let (name, word, known) = (&case.dense.name, &case.word, found.completeness);
        println!("{name} {word}: {} orbits, {known:?}, {is_found}", found.orbits.len());
        if case.word.instants().len() <= 2 {
            short += 1;
            assert!(is_found, "{name}: {known:?}");
        } else if !is_found {
            missed.push(format!("{} {}", case.dense.name, case.word));
        }
        found_count += usize::from(is_found);
    }
    println!("{missed:?}");
    assert!(short >= 18 && found_count >= 20, "{short} {found_count}");
}

/// Contacts and coordinates at any time against exponentials of the state matrix.
#[test]
fn motion_between_impacts_is_that_of_the_state_matrix() {
    let mut checked = 0;
    for case in cases().iter().filter(|case| case.dense.size() <= 5) {
        let orbit = case.refined();
        let motion = ContactMotion::new(orbit.contacts().unwrap()).unwrap();
        for i in 0..orbit.impacts().len() {
            for part in [0.2, 0.5, 0.9] {
                let s = part * motion.until_next(i);
                let all = motion.coordinates(i, s).unwrap();
                for (contact, weights) in case.dense.contacts.iter().enumerate() {
                    let [place, velocity, acceleration] = motion.contact(contact, i, s);
                    let sum = |n: usize| weights.iter().zip(&all).map(|(w, x)| w * x[n]).sum::<f64>();
                    assert!((place - sum(0)).abs() < 1e-12 && (velocity - sum(1)).abs() < 1e-12, "{}", case.dense.name);
                    let h = 1e-5;
                    let [ahead, behind] = [s + h, s - h].map(|s| motion.contact(contact, i, s));
                    let scale = 1.0 + velocity.abs() + acceleration.abs();
                    assert!(
                        ((ahead[0] - behind[0]) / (2.0 * h) - velocity).abs() < 1e-7 * scale,
                        "{}",
                        case.dense.name
                    );
                    let off = ((ahead[1] - behind[1]) / (2.0 * h) - acceleration).abs();
                    assert!(off < 1e-5 * scale, "{} {off:e}", case.dense.name);
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 60, "{checked}");
}

/// Orbits of random structures, their multipliers by the dense matrix.
#[test]
fn random_structures_have_the_multipliers_of_their_matrices() {
    let mut random = Random(37);
    let (mut compared, mut beyond) = (0, 0);
    for _ in 0..150 {
        let dense = random.structure();
        // Every contact as often as it is hit, at the places where it is: barriers that the orbit meets.
        let sides: Vec<Barrier> = dense
            .impacts
            .iter()
            .map(|impact| if impact.impulse < 0.0 { Barrier::Upper } else { Barrier::Lower })
            .collect();
        let first = |contact: usize, side: Barrier| {
            let hits =
                dense.impacts.iter().zip(&sides).filter(|(impact, own)| impact.contact == contact && **own == side);
            let mut stops = hits.map(|(impact, _)| impact.stop);
            (stops.next(), stops.next())
        };
        let restitutions = (0..dense.contacts.len()).map(|contact| {
            let mut hits = dense.impacts.iter().filter(|impact| impact.contact == contact);
            hits.next().map(|impact| impact.restitution)
        });
        let sound = |(contact, restitution): (usize, Option<f64>)| {
            let (lower, upper) = (first(contact, Barrier::Lower), first(contact, Barrier::Upper));
            // One place and one restitution of each.
            if lower.1.is_some() || upper.1.is_some() {
                return None;
            }
            if lower.0.is_some() && upper.0.is_some() {
                return None;
            }
            let far = if lower.0.is_none() && upper.0.is_none() { Some(1e3) } else { upper.0 };
            Some(Contact { lower: lower.0, upper: far, restitution: restitution.unwrap_or(1.0) })
        };
        let contacts: Option<Vec<Contact>> = restitutions.enumerate().map(sound).collect();
        let Some(contacts) = contacts else { continue };
        let modal = Arc::new(modal(&dense, &contacts));
        let model = LoadedStructure::new(modal, dense.omega).unwrap();
        let impacts: Vec<_> =
            dense.impacts.iter().zip(&sides).map(|(i, side)| Hit::new(i.contact, *side, i.time, i.impulse)).collect();
        let orbit = model.orbit_near(1, dense.psi, &impacts).unwrap();
        let stability = stability(&orbit, Tolerance::Rounding).unwrap();
        let mut open: Vec<_> = dense.monodromy().complex_eigenvalues().iter().copied().collect();
        let radius = stability.multipliers[0].norm();
        for reach in [1.0, 0.9 * radius, 1.1 * radius] {
            let known = BlochProblem::of(orbit.contacts().unwrap());
            let (is_beyond, verdict) =
                (known.surely_exceeds(reach), known.verdict(&mut Analyser::default(), Tolerance::Rounding).unwrap());
            let real = |sign: f64| open.iter().filter(|mu| mu.im == 0.0 && sign * mu.re > reach).count();
            assert_eq!(verdict.stable, stability.verdict.stable, "{dense:?}");
            assert!(!is_beyond || real(1.0) + real(-1.0) > 0, "{reach} {dense:?}");
            beyond += usize::from(is_beyond);
        }
        for z in &stability.multipliers {
            let distance = |w: &Complex<f64>| (w - z).norm();
            let nearest = (0..open.len()).min_by(|&i, &j| distance(&open[i]).total_cmp(&distance(&open[j]))).unwrap();
            let off = distance(&open.swap_remove(nearest));
            assert!(off < 1e-8 * (1.0 + radius), "{z} {off:e} {dense:?}");
        }
        compared += 1;
    }
    assert!(compared > 40 && beyond > 20, "{compared} {beyond}");
}

/// Newton's method from many starts finds no orbit of two or three impacts that a complete list lacks.
#[test]
fn complete_lists_of_two_and_three_impacts_lack_nothing_that_starts_lead_to() {
    let mut random = Random(73);
    let (mut complete, mut led, mut listed) = ([0; 2], [0; 2], [0; 2]);
    for case in cases() {
        let model = case.model();
        let contacts = model.structure().contacts();
        let is_forced = case.dense.load.iter().any(|load| *load != 0.0);
        for round in 0..6 {
            let letter = |random: &mut Random| {
                let contact = random.below(contacts.len().min(3));
                let (upper, lower) = (contacts[contact].upper.is_some(), contacts[contact].lower.is_some());
                let side = if upper && (!lower || random.chance(0.5)) { Barrier::Upper } else { Barrier::Lower };
                (contact, side)
            };
            let n = 2 + round % 2;
            let letters: Vec<_> = (0..n).map(|_| letter(&mut random)).collect();
            let name = |(contact, side): &(usize, Barrier)| {
                format!("{contact}{}", if *side == Barrier::Upper { '+' } else { '-' })
            };
            let word: Word = letters.iter().map(name).collect::<Vec<_>>().join(",").parse().unwrap();
            let periods = 1 + random.below(2) as u32;
            let Ok(found) = model.orbits(&word, periods) else { continue };
            let is_proof =
                matches!(found.completeness, Completeness::Open { .. }) || found.completeness.is_established();
            if !is_proof {
                continue;
            }
            println!("{} {word}/{periods}: {} orbits, {:?}", case.dense.name, found.orbits.len(), found.completeness);
            complete[n - 2] += usize::from(found.completeness.is_established());
            listed[n - 2] += found.orbits.len();
            for _ in 0..60 * (n - 1) {
                let period = model.period() * f64::from(periods);
                let mut times: Vec<f64> = (1..n).map(|_| random.between(0.0, period)).chain([0.0]).collect();
                times.sort_by(f64::total_cmp);
                let size = random.log(0.01, 10.0);
                let start =
                    letters.iter().zip(&times).map(|(&(c, side), time)| Hit::new(c, side, *time, -side.sign() * size));
                let start: Vec<_> = start.collect();
                let psi = if is_forced { random.between(0.0, model.period()) } else { 0.0 };
                let Ok(orbit) = model.orbit_near(periods, psi, &start) else { continue };
                let impacts = orbit.impacts();
                let apart = |orbit: &Orbit, i: usize| {
                    orbit.impacts().get(i + 1).map_or(period, |next| next.time) - orbit.impacts()[i].time
                };
                let pulls = impacts.iter().any(|impact| impact.barrier.sign() * impact.impulse > -1e-7);
                // Without a load an impact of no impulse obeys its law wherever it is.
                let lacks_one = impacts
                    .iter()
                    .zip(orbit.contacts().unwrap().impact_errors())
                    .any(|(one, off)| one.impulse.abs() <= off.impulse);
                if (0..n).any(|i| apart(&orbit, i) < 1e-3 * period) || n == 3 && pulls || lacks_one {
                    continue;
                }
                led[n - 2] += 1;
                let near = |a: f64, b: f64| (a - b).abs() < 1e-6 * (1.0 + a.abs());
                let alike = |other: &Orbit, turn: usize| {
                    (0..n).all(|i| {
                        let j = (i + turn) % n;
                        letters[i] == letters[j]
                            && near(impacts[i].impulse, other.impacts()[j].impulse)
                            && near(apart(&orbit, i), apart(other, j))
                    })
                };
                // An orbit of a part of the period is not listed.
                assert!(
                    !found.completeness.is_established()
                        || alike(&orbit, 1)
                        || found.orbits.iter().any(|other| (0..n).any(|turn| alike(other, turn))),
                    "{} {word} over {periods}: {impacts:?} not in {:?}",
                    case.dense.name,
                    found.orbits.iter().map(|orbit| orbit.impacts().to_vec()).collect::<Vec<_>>()
                );
            }
        }
    }
    println!("{complete:?} lists, {listed:?} orbits, {led:?} starts led to one");
    assert!(complete[0] > 25 && led[0] > 200 && complete[1] > 25 && led[1] > 20, "{complete:?} {listed:?} {led:?}");
}

/// 300 modes over six decades of frequency and ten contacts: most have died out within a period, and none is lost.
#[test]
fn many_modes_and_contacts() {
    let mut random = Random(300);
    let mode = |k: usize| {
        let frequency = 10f64.powf(6.0 * k as f64 / 299.0);
        let shapes = (0..10).map(|_| random.between(-1.0, 1.0) / (1.0 + k as f64).sqrt()).collect();
        let shape = ModeShape { contacts: shapes, coordinates: Vec::new(), still: 0.0 };
        let square = frequency * frequency * (1.0 - 0.02 * 0.02);
        let load = Complex::new(0.3 / (1.0 + k as f64).powi(2), 0.0);
        LinearMode::oscillator(0.02 * frequency, square, &shape, &[load])
    };
    let modes = (0..300).map(mode).collect();
    let contacts = (0..10).map(|_| Contact { lower: Some(-2.0), upper: Some(0.2), restitution: 0.7 }).collect();
    let model = LoadedStructure::new(Arc::new(ModalStructure::new(contacts, vec![1], modes).unwrap()), 1.1).unwrap();
    let mut checked = 0;
    for text in ["0+", "3+", "7-"] {
        for orbit in model.orbits(&text.parse().unwrap(), 1).unwrap().orbits.iter().take(2) {
            assert!(orbit.residual() < 1e-11, "{text}: {:e}", orbit.residual());
            let stability = stability(orbit, Tolerance::Rounding).unwrap();
            assert_eq!(stability.multipliers.len(), 600, "{text}");
            assert!(stability.multipliers.iter().all(|z| z.re.is_finite() && z.im.is_finite()), "{text}");
            let dead = stability.multipliers.iter().filter(|z| z.norm() < 1e-12).count();
            // e^{−0.02·f·T} is below 1e-13 from f = 262 on.
            assert!((300..600).contains(&dead), "{text}: {dead}");
            let alone = vibrochain_floquet::stability(orbit, Tolerance::Rounding).map(|known| known.verdict).unwrap();
            let off = (alone.spectral_radius - stability.multipliers[0].norm()).abs();
            assert!(off <= 2.0 * alone.resolution + 1e-15, "{text}: {off:e}");
            checked += 1;
        }
    }
    assert!(checked >= 4, "{checked}");
}

/// Two bodies that nothing holds, as a gear pair, are one in their distance: two rigid modes, of which the contact sees one combination.
#[test]
fn two_free_bodies_have_the_orbits_of_their_distance() {
    let orbits = |structure: &Structure, word: &str| {
        let model = LoadedStructure::new(Arc::new(structure.modal().unwrap()), 3.0).unwrap();
        model.orbits(&word.parse().unwrap(), 1).unwrap().orbits
    };
    let contact = Contact { lower: Some(-0.05), upper: Some(0.07), restitution: 0.7 };
    let (mut compared, mut physical) = (0, 0);
    for (masses, damping) in [([1.0, 1.0], 0.1), ([1.0, 3.0], 0.1), ([0.7, 1.9], 0.0), ([500.0, 3000.0], 0.3)] {
        let reduced = masses[0] * masses[1] / (masses[0] + masses[1]);
        let of = |mass: &[f64], weights: &[f64], load: &[f64], still: &[f64]| Structure {
            mass: DMatrix::from_diagonal(&DVector::from_column_slice(mass)),
            damping: DMatrix::from_diagonal(&DVector::from_column_slice(mass)) * damping,
            stiffness: DMatrix::zeros(mass.len(), mass.len()),
            contacts: vec![(DVector::from_column_slice(weights), contact)],
            static_load: DVector::from_column_slice(still) * reduced,
            loads: vec![(1, DVector::from_column_slice(load).map(|load| Complex::new(load * reduced, 0.0)))],
            modes: None,
        };
        let both = of(&masses, &[1.0, -1.0], &[0.4 * masses[0] / reduced, 0.0], &[0.05, -0.05]);
        let distance = of(&[reduced], &[1.0], &[0.4], &[0.05]);
        for word in ["0+", "0-", "0+,0-", "0-,0-"] {
            let (found, wanted) = (orbits(&both, word), orbits(&distance, word));
            assert_eq!(found.len(), wanted.len(), "{masses:?} {damping} {word}");
            for (one, other) in found.iter().zip(&wanted) {
                for (a, b) in one.impacts().iter().zip(other.impacts()) {
                    let far = (a.impulse - b.impulse).abs() / reduced + (a.time - b.time).abs();
                    assert!(far < 1e-10, "{masses:?} {damping} {word}: {a:?} {b:?}");
                }
                let is_physical = |orbit: &Orbit| admissibility(orbit).unwrap().is_physical();
                assert_eq!(is_physical(one), is_physical(other), "{masses:?} {damping} {word}");
                physical += u32::from(is_physical(one));
                let [all, own] = [one, other].map(|orbit| stability(orbit, Tolerance::Rounding).unwrap());
                for multiplier in &own.multipliers {
                    let near = all.multipliers.iter().map(|z| (z - multiplier).norm()).fold(f64::INFINITY, f64::min);
                    assert!(
                        near < 1e-7 * (1.0 + multiplier.norm()),
                        "{masses:?} {damping} {word}: {multiplier} {all:?}"
                    );
                }
                // Where both stand together is neutral: next to dashpots that is told as undecided.
                let is_bounded = |verdict: &Verdict| verdict.stable || verdict.undecided;
                assert_eq!(is_bounded(&all.verdict), is_bounded(&own.verdict), "{masses:?} {damping} {word}");
                compared += 1;
            }
        }
    }
    assert!(compared > 16 && physical > 4, "{compared} {physical}");
}
