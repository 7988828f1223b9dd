//! Tangent vectors of a structure's runs against neighbouring runs, and against dense matrices, saltation by saltation.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use vibrochain_eventsim::{EventKind, Limits, Outcome, Simulation, TangentError};
use vibrochain_lattice::{Complex, Contact, ModalStructure, Structure};
use vibrochain_testkit::{Random, structures};

type Modes = Vec<[f64; 2]>;

/// Structures of any damping, pressed and driven, with contacts that chatter, rest and let go; a state of each.
fn structure(random: &mut Random) -> (ModalStructure, f64, Modes) {
    let made = random.structure();
    let n = made.size();
    let contacts = (made.contacts.iter())
        .map(|w| {
            let upper = random.between(0.1, 0.8);
            let lower = random.chance(0.5).then(|| -random.between(0.2, 1.0));
            (w.clone(), Contact { lower, upper: Some(upper), restitution: random.between(0.0, 0.9) })
        })
        .collect();
    let load = DVector::from_fn(n, |_, _| Complex::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0)));
    let structure = Structure {
        mass: made.mass.clone(),
        damping: made.damping.clone() * 0.5,
        stiffness: made.stiffness.clone(),
        contacts,
        static_load: DVector::from_fn(n, |_, _| random.between(-1.0, 1.0)),
        loads: vec![(1, load)],
        modes: None,
    };
    let v = DVector::from_fn(n, |_, _| random.between(-0.5, 0.5));
    let modal = structure.modal().unwrap();
    let modes = structure.project(&modal, &DVector::zeros(n), &v).unwrap();
    (modal, random.between(0.3, 1.2), modes)
}

/// Where a run ends, and the kinds of its events.
fn after(structure: &ModalStructure, omega: f64, modes: &Modes, part: f64) -> Option<(Modes, Vec<(usize, EventKind)>)> {
    let mut simulation = Simulation::of_modes(structure.clone(), omega, 0.3, modes).ok()?;
    let (report, events) = simulation.collect(&Limits::until(simulation.time_of(0, part)));
    let events = events.iter().map(|event| (event.contact, event.kind)).collect();
    (report.outcome == Outcome::TimeReached).then(|| (simulation.state().modes, events))
}

#[test]
fn tangents_are_the_difference_of_neighbouring_runs() {
    let mut random = Random(53);
    let (mut compared, mut rested, mut worst) = (0, 0, 0.0_f64);
    for _ in 0..300 {
        let (structure, omega, modes) = structure(&mut random);
        let direction: Modes = modes.iter().map(|_| [random.between(-1.0, 1.0), random.between(-1.0, 1.0)]).collect();
        let part = random.between(0.3, 1.7);
        let Some((_, events)) = after(&structure, omega, &modes, part) else { continue };
        let shifted = |h: f64| -> Option<Modes> {
            let moved = modes.iter().zip(&direction).map(|(xi, d)| [xi[0] + h * d[0], xi[1] + h * d[1]]).collect();
            // Where neighbours have other events, as beside a graze, their difference is none.
            after(&structure, omega, &moved, part).filter(|(_, other)| *other == events).map(|(end, _)| end)
        };
        let difference = |h: f64| -> Option<Vec<f64>> {
            let (one, other) = (shifted(-h)?, shifted(h)?);
            Some(one.iter().flatten().zip(other.iter().flatten()).map(|(a, b)| (b - a) / (2.0 * h)).collect())
        };
        let (Some(fine), Some(coarse)) = (difference(1e-6), difference(2e-6)) else { continue };
        let mut simulation = Simulation::of_modes(structure.clone(), omega, 0.3, &modes).unwrap();
        let lists = [0, 1].map(|j| direction.iter().map(|xi| xi[j]).collect::<Vec<f64>>());
        let mut tangents = simulation.tangents_along(&[lists]).unwrap();
        let limits = Limits::until(simulation.time_of(0, part));
        let report = simulation.run_with(&mut tangents, &limits, |_| {}).unwrap();
        if tangents.has_grazed() {
            continue;
        }
        let [first, second] = tangents.vector(0).unwrap();
        let exact = first.iter().zip(&second).flat_map(|(a, b)| [a, b]);
        // Vectors that have grown far are made orthonormal on the way.
        let length = tangents.growth()[0].exp();
        let size = fine.iter().fold(0.1, |most: f64, x| most.max(x.abs()));
        for (i, exact) in exact.map(|x| x * length).enumerate() {
            let expected = (4.0 * fine[i] - coarse[i]) / 3.0;
            let allowed = 0.2 * (fine[i] - coarse[i]).abs() + 3e-7 * size;
            worst = worst.max((exact - expected).abs() / size);
            assert!((exact - expected).abs() <= allowed, "{i}: {exact} {expected} {allowed:e} {events:?}");
        }
        compared += 1;
        rested += usize::from(report.work.sticks > 0);
    }
    println!("{compared} runs, {rested} with rests, {worst:e}");
    assert!(compared >= 200 && rested >= 80, "{compared} {rested}");
}

#[test]
fn a_period_of_an_orbit_has_the_multipliers_of_the_dense_matrix() {
    let (mut compared, mut complex) = (0, 0);
    for case in structures().iter().filter(|case| case.physical) {
        let structure = case.linear();
        let (n, modal) = (case.size(), structure.modal().unwrap());
        let start = &case.states()[0];
        let modes = structure.project(&modal, &start.rows(0, n).into_owned(), &start.rows(n, n).into_owned()).unwrap();
        let size = 2 * modal.modes().len();
        let count = modal.modes().len();
        let unit = |i: usize| {
            [0, 1].map(|j| (0..count).map(|k| f64::from(u8::from(j * count + k == i))).collect::<Vec<f64>>())
        };
        let mut simulation = Simulation::of_modes(modal.clone(), case.omega, case.psi, &modes).unwrap();
        let mut tangents = simulation.tangents_along(&(0..size).map(unit).collect::<Vec<_>>()).unwrap();
        // From the first impact, which is passed, to just before its next one.
        let periods = case.period * case.omega / TAU;
        let after_last = 0.5 * (case.period - case.impacts.last().unwrap().time) * case.omega / TAU;
        let end = |part: f64| Limits::until(simulation.time_of(0, part));
        let (from, to) = (end(periods - after_last), end(2.0 * periods - after_last));
        simulation.run(&from, |_| {});
        let report = simulation.run_with(&mut tangents, &to, |_| {}).unwrap();
        assert_eq!(report.outcome, Outcome::TimeReached);
        if tangents.growth().iter().any(|log| *log != 0.0) || tangents.has_grazed() {
            continue;
        }
        let columns: Vec<DVector<f64>> =
            (0..size).map(|i| DVector::from_vec(tangents.vector(i).unwrap().concat())).collect();
        let sorted = |matrix: &DMatrix<f64>| {
            let mut moduli: Vec<f64> = matrix.complex_eigenvalues().iter().map(|z| z.norm()).collect();
            moduli.sort_by(|a, b| b.total_cmp(a));
            moduli
        };
        let (told, dense) = (sorted(&DMatrix::from_columns(&columns)), sorted(&case.monodromy()));
        // Pairs that meet at 1 are known to the root of the rounding.
        for (a, b) in told.iter().zip(&dense) {
            let known = if (b - 1.0).abs() < 1e-4 { 1e-4 } else { 1e-6 };
            assert!((a - b).abs() < known * (1.0 + b), "{}: {told:?} {dense:?}", case.name);
        }
        compared += 1;
        complex += usize::from(!modal.modes()[0].is_real);
    }
    assert!(compared >= 10 && complex >= 3, "{compared} {complex}");
}

#[test]
fn a_run_with_tangents_is_the_same_to_the_bit_and_those_of_another_structure_are_refused() {
    let mut random = Random(5);
    let (structure, omega, modes) = structure(&mut random);
    let mut alone = Simulation::of_modes(structure.clone(), omega, 0.3, &modes).unwrap();
    let mut with = alone.clone();
    let limits = Limits::until(alone.time_of(3, 0.4));
    let (_, events) = alone.collect(&limits);
    let mut tangents = alone.tangents(2, 9).unwrap();
    let mut seen = Vec::new();
    with.run_with(&mut tangents, &limits, |event| seen.push(*event)).unwrap();
    assert!(!events.is_empty());
    assert_eq!((events, alone.state()), (seen, with.state()));
    let other = structure
        .clone()
        .with_contacts(structure.contacts().iter().map(|contact| Contact { restitution: 0.95, ..*contact }).collect());
    let mut others = Simulation::of_modes(other.unwrap(), omega, 0.3, &modes).unwrap().tangents(1, 9).unwrap();
    assert_eq!(with.run_with(&mut others, &limits, |_| {}), Err(TangentError::OtherModel));
    let most = 2 * structure.modes().len();
    assert_eq!(alone.tangents(most + 1, 1).err(), Some(TangentError::Count { count: most + 1, most }));
    assert!(matches!(alone.tangents_along(&[[vec![0.0], vec![0.0]]]), Err(TangentError::Entries { .. })));
}

/// Two masses alike that hit at one instant: no linear map goes through that where a dashpot between them lets the impulse at one change the
/// acceleration of the other, though neither place nor velocity. With a spring between them alone there is one.
#[test]
fn contacts_that_a_dashpot_couples_have_no_tangents_through_one_instant() {
    let at = |weights: [f64; 2]| {
        let stop = Contact { lower: None, upper: Some(0.3), restitution: 0.7 };
        (DVector::from_column_slice(&weights), stop)
    };
    for (dashpot, spring, has_grazed) in [(0.0, 0.0, false), (0.0, 0.2, false), (0.03, 0.2, true), (0.01, 0.5, true)] {
        let coupled = |own: f64, shared: f64| DMatrix::from_row_slice(2, 2, &[own, -shared, -shared, own]);
        let structure = Structure {
            mass: DMatrix::identity(2, 2),
            damping: coupled(0.05, dashpot),
            stiffness: coupled(1.0, spring),
            contacts: vec![at([1.0, 0.0]), at([0.0, 1.0])],
            ..Structure::default()
        };
        let modal = structure.modal().unwrap();
        // On their barriers, moving outward.
        let [place, velocity] = [0.3, 1.0].map(|x| DVector::from_element(2, x));
        let modes = structure.project(&modal, &place, &velocity).unwrap();
        let mut simulation = Simulation::of_modes(modal.clone(), 1.0, 0.0, &modes).unwrap();
        let mut tangents = simulation.tangents(1, 3).unwrap();
        let limits = Limits { impacts: 2, ..Limits::until(simulation.time_of(0, 0.5)) };
        let mut times = Vec::new();
        simulation.run_with(&mut tangents, &limits, |event| times.push(event.time)).unwrap();
        assert!(times.len() == 2 && times[0] == times[1], "{times:?}");
        assert_eq!(tangents.has_grazed(), has_grazed, "{dashpot} {spring}");
    }
}
