//! Krein signatures from J(z), against the form on eigenvectors of dense monodromy matrices.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::sync::Arc;

use faer::MatRef;
use nalgebra::{DMatrix, DVector};
use vibrochain_breather::{BlochEquations, Finder, LoadedStructure, OrbitList, Scope};
use vibrochain_floquet::{Analyser, Complex, Course, Event, Signature, Tolerance, diagram, full_monodromy, signature};
use vibrochain_lattice::{Barrier, Model, Parameter, Point};
use vibrochain_testkit::{Random, Ranges, Structure, StructureImpact, Values};

/// Multipliers nearer than this to others, or to the real axis, have eigenvectors with too few digits.
const ALONE: f64 = 1e-4;

/// What was held against the form: pairs of either sign, and multipliers off the circle.
#[derive(Debug, Default)]
struct Held {
    signed: [usize; 2],
    off: usize,
}

impl Held {
    /// The signatures of an orbit, whose monodromy matrix acts on (q, q′) with masses `mass` and is hit at `contacts`.
    fn check(
        &mut self,
        equations: &BlochEquations,
        (matrix, mass, contacts): (&DMatrix<f64>, &DMatrix<f64>, &[DVector<f64>]),
        about: &str,
    ) {
        let (size, half) = (matrix.nrows(), matrix.nrows() / 2);
        let eigen = MatRef::from_column_major_slice(matrix.as_slice(), size, size).eigen().unwrap();
        let value = |i: usize| {
            let z = eigen.S().column_vector()[i];
            Complex::new(z.re, z.im)
        };
        for i in (0..size).filter(|&i| value(i).im > ALONE) {
            let vector = |from: usize| {
                DVector::from_fn(half, |n, _| {
                    let z = eigen.U()[(from + n, i)];
                    Complex::new(z.re, z.im)
                })
            };
            let (q, momentum) = (vector(0), mass.map(|x| Complex::new(x, 0.0)) * vector(half));
            let multiplier = value(i);
            let apart = (0..size).filter(|&j| j != i).map(|j| (value(j) - multiplier).norm());
            let reached = contacts.iter().map(|w| w.map(|x| Complex::new(x, 0.0)).dot(&q).norm());
            if apart.fold(f64::INFINITY, f64::min) < ALONE || reached.fold(0.0, f64::max) < 1e-6 * q.norm() {
                continue;
            }
            let form = q.dotc(&momentum).im / (q.norm() * momentum.norm());
            let excess = multiplier.norm() - 1.0;
            if excess.abs() > ALONE {
                assert_eq!(signature(equations, multiplier), None, "{about} {multiplier}");
                self.off += 1;
            } else if excess.abs() < 1e-9 && form.abs() > ALONE {
                let expected = if form > 0.0 { Signature::Positive } else { Signature::Negative };
                assert_eq!(signature(equations, multiplier), Some(expected), "{about} {multiplier} {form:e}");
                assert_eq!(signature(equations, multiplier.conj()), Some(expected), "{about} {multiplier}");
                self.signed[usize::from(form > 0.0)] += 1;
            }
        }
    }
}

/// Rings, rows and layers, hit at one mass or several; begun at rest, and under a force.
#[test]
fn signatures_of_lattices_are_those_of_the_form() {
    let mut random = Random(41);
    let (mut held, mut several, mut rows, mut forced) = (Held::default(), 0, 0, 0);
    let gamma2 = Values::Log(1e-2, 0.3);
    let ranges = Ranges { sites: [2, 9], gamma2, omega: Values::Even(0.6, 2.5), ..Ranges::CONSERVATIVE };
    for round in 0..400 {
        let (chain, model) = (random.lattice(&ranges), random.model(&ranges));
        let amplitude = if round % 4 == 3 { 0.1 } else { 0.0 };
        let model = model.point().on(&chain).amplitude(amplitude).restitution(1.0).model().unwrap();
        let word = match round % 2 {
            0 => random.word(&chain),
            _ => random.of(&["0+,0-", "0-", "0+1+,0-1-"]).parse().ok(),
        };
        let (Some(word), mut finder, mut found) = (word, Finder::new(chain.sites()), OrbitList::default()) else {
            continue;
        };
        if finder.find_word(&model, &word, Scope::All, &mut found).is_err() {
            continue;
        }
        for orbit in found.orbits.iter().take(2) {
            let condition = finder.condition(orbit).unwrap();
            let Ok(matrix) = full_monodromy(orbit) else { continue };
            if condition.resonance < 1e-3 || condition.grazing < 1e-3 || matrix.norm() > 1e4 {
                continue;
            }
            let sites = chain.sites();
            let unit = |&site: &usize| DVector::from_fn(sites, |n, _| f64::from(u8::from(n == site)));
            let contacts: Vec<DVector<f64>> = orbit.hit_sites().iter().map(unit).collect();
            let before = held.signed[0] + held.signed[1];
            let (equations, _) = finder.at_contacts(orbit).unwrap().bloch_equations();
            held.check(&equations, (&matrix, &DMatrix::identity(sites, sites), &contacts), &format!("{model} {word}"));
            let count = held.signed[0] + held.signed[1] - before;
            several += if contacts.len() > 1 { count } else { 0 };
            rows += if chain.is_ring() { 0 } else { count };
            forced += if amplitude > 0.0 { count } else { 0 };
        }
    }
    println!("{held:?} {several} {rows} {forced}");
    assert!(held.signed.iter().all(|count| *count > 300) && held.off > 20, "{held:?}");
    assert!(several > 300 && rows > 200 && forced > 100, "{several} {rows} {forced}");
}

/// Structures given as matrices, unequal masses and contacts with levers, some with a motion of the whole that nothing brings back.
#[test]
fn signatures_of_matrices_are_those_of_the_form() {
    let mut random = Random(43);
    let (mut held, mut several, mut rigid) = (Held::default(), 0, 0);
    for round in 0..150 {
        let size = 2 + random.below(5);
        let is_rigid = round % 5 == 4;
        let mass = DMatrix::from_diagonal(&DVector::from_fn(size, |_, _| random.between(0.5, 2.0)));
        let factor = DMatrix::from_fn(size, size, |_, _| random.between(-1.0, 1.0));
        let mut stiffness = &factor * factor.transpose() / size as f64;
        if is_rigid {
            // Springs between all pairs: each row sums up to 0.
            stiffness = DMatrix::from_fn(size, size, |i, j| if i == j { 0.0 } else { -stiffness[(i, j)].abs() });
            for i in 0..size {
                stiffness[(i, i)] = -stiffness.row(i).sum();
            }
        } else {
            stiffness += DMatrix::identity(size, size) * random.between(0.05, 0.5);
        }
        let contacts: Vec<_> = (0..2)
            .map(|c| {
                let lever = random.between(0.5, 2.0);
                DVector::from_fn(size, |n, _| if n == c { lever } else { 0.0 })
            })
            .collect();
        let omega = random.between(0.6, 3.0);
        let none = DMatrix::zeros(size, size);
        let mut dense = Structure::without_orbit([mass.clone(), none, stiffness], contacts.clone(), omega);
        let gap = random.between(-0.4, 0.4);
        dense.limits = vec![(Some(gap - 1.0), Some(gap + 1.0), 1.0); 2];
        let model = LoadedStructure::new(Arc::new(dense.linear().modal().unwrap()), omega).unwrap();
        let word = random.of(&["0+,0-", "0-", "0+1+,0-1-", "0+1-,0-1+"]);
        let Ok(found) = model.orbits(&word.parse().unwrap(), 1) else { continue };
        for orbit in &found.orbits {
            let impact = |impact: &vibrochain_breather::Impact| StructureImpact {
                contact: impact.site,
                time: impact.time,
                impulse: impact.impulse,
                restitution: 1.0,
                stop: gap + if impact.barrier == Barrier::Upper { 1.0 } else { -1.0 },
            };
            dense.impacts = orbit.impacts().iter().map(impact).collect();
            let matrix = dense.monodromy();
            if matrix.norm() > 1e4 {
                continue;
            }
            let before = held.signed[0] + held.signed[1];
            let hit = if word.contains('1') { 2 } else { 1 };
            let about = format!("{round} {word} {omega}");
            held.check(&orbit.contacts().unwrap().bloch_equations().0, (&matrix, &mass, &contacts[..hit]), &about);
            let count = held.signed[0] + held.signed[1] - before;
            several += if hit > 1 { count } else { 0 };
            rigid += if is_rigid { count } else { 0 };
        }
    }
    println!("{held:?} {several} {rigid}");
    assert!(held.signed.iter().all(|count| *count > 50) && held.off > 5, "{held:?}");
    assert!(several > 40 && rigid > 20, "{several} {rigid}");
}

/// Where energy is lost there is no form that is kept.
#[test]
fn losses_leave_no_signature() {
    let model = Point::ring(4).gamma1(0.3).gamma2(0.1).omega(1.4).asymmetry(0.2).amplitude(0.3).restitution(0.8);
    let (mut finder, mut found) = (Finder::new(4), OrbitList::default());
    finder.find(&model.model().unwrap(), vibrochain_breather::Family::DoubleSided, &mut found).unwrap();
    let (equations, _) = finder.at_contacts(&found.orbits[0]).unwrap().bloch_equations();
    let multipliers = vibrochain_floquet::ImpactSpectrum::new(&equations).multipliers;
    assert!(!multipliers.is_empty() && multipliers.iter().all(|mu| signature(&equations, *mu).is_none()));
}

/// Pairs of unlike signature pass each other where a symmetry of the orbit parts them: mirror images half a period later, of one mass and of two.
/// Each change of stability along the branch is an event, and nothing is left open.
#[test]
fn pairs_that_a_symmetry_parts_pass_each_other() {
    let (mut events, mut unstable) = (0, 0);
    for (sites, word, asymmetry, from, to) in
        [(21, "0+,0-", 0.0, 1.02, 1.6), (8, "0+2-,0-2+", 0.2, 1.1, 1.6), (8, "0+1+,0-1-", 0.2, 1.1, 1.6)]
    {
        let model = |omega: f64| -> Model {
            Point::ring(sites).gamma1(0.2).gamma2(0.1).omega(omega).asymmetry(asymmetry).model().unwrap()
        };
        let (word, mut finder, mut found) = (word.parse().unwrap(), Finder::new(sites), OrbitList::default());
        finder.find_word(&model(1.5), &word, Scope::All, &mut found).unwrap();
        let orbit = &found.orbits[0];
        let course = Course { from, to, ..Course::new(orbit, Parameter::Omega) };
        let answer = diagram(orbit, &course).unwrap();
        let branch = &answer.branches[0];
        assert_eq!((branch.unresolved.len(), branch.untold), (0, 0), "{word}: {:?}", branch.unresolved);
        assert!(answer.evaluations < 20_000, "{word}: {}", answer.evaluations);
        // Steps of a scan in which the stability changes hold an event.
        let mut analyser = Analyser::default();
        let mut stable = |omega: f64| {
            finder.find_word(&model(omega), &word, Scope::All, &mut found).unwrap();
            let verdict = analyser.verdict(&found.orbits[0], &mut finder, Tolerance::Rounding).unwrap();
            (!verdict.undecided).then_some(verdict.stable)
        };
        let places: Vec<f64> = (0..=500).map(|i| from + (to - from) * f64::from(i) / 500.0).collect();
        let seen: Vec<_> = places.iter().map(|omega| stable(*omega)).collect();
        let bifurcations: Vec<f64> =
            branch.events().filter(|event| event.event != Event::Grazing).map(|event| event.value).collect();
        for (step, ends) in places.windows(2).zip(seen.windows(2)) {
            if let [Some(before), Some(behind)] = ends {
                let inside = bifurcations.iter().filter(|value| (step[0]..=step[1]).contains(*value)).count();
                assert!(before == behind || inside > 0, "{word} {step:?}");
            }
        }
        events += bifurcations.len();
        unstable += seen.iter().filter(|stable| **stable == Some(false)).count();
    }
    assert!(events >= 30 && unstable > 20, "{events} {unstable}");
}
