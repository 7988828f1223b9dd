//! Impacts are those of the table of orbits, of a dense search that shares no code, and of the chain.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use vibrochain_eventsim::{Event, EventKind, Limits, Outcome, Simulation, Time};
use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape, Point, Structure};
use vibrochain_testkit::{Random, structures};

use crate::dense::Dense;
use crate::made::{contact, energy, harmonic, started, until};

#[test]
fn orbits_of_the_table_repeat_their_impacts_for_ten_periods() {
    let mut compared = 0;
    for case in structures().iter().filter(|case| case.physical) {
        let structure = case.linear();
        let n = case.size();
        let start = &case.states()[0];
        let mut simulation =
            started(&structure, case.omega, case.psi, &start.rows(0, n).into_owned(), &start.rows(n, n).into_owned());
        let force_periods = (case.period * case.omega / TAU).round() as u64;
        let half_way = 0.5 * (1.0 + case.impacts.last().unwrap().time / case.period) * force_periods as f64;
        let (report, events) = simulation.collect(&until(&simulation, 9 * force_periods, half_way));
        assert_eq!(report.outcome, Outcome::TimeReached, "{}", case.name);
        assert_eq!(events.len(), 10 * case.impacts.len(), "{}", case.name);
        let radius = case.multipliers.iter().map(|mu| mu.norm()).fold(1.0, f64::max);
        for (number, event) in events.iter().enumerate() {
            let (period, impact) = (number / case.impacts.len(), &case.impacts[number % case.impacts.len()]);
            let tolerance = 1e-9 * radius.powi(period as i32 + 1);
            let time = period as f64 * case.period + impact.time;
            assert_eq!((event.kind, event.contact), (EventKind::Impact, impact.contact), "{}", case.name);
            assert!((event.time.to_f64() - time).abs() < tolerance, "{}: {event:?} {time}", case.name);
            assert!((event.impulse - impact.impulse).abs() < tolerance, "{}: {event:?} {impact:?}", case.name);
            compared += 1;
        }
    }
    assert!(compared >= 300, "{compared}");
}

#[test]
fn random_structures_hit_where_exponentials_and_bisection_hit() {
    let mut random = Random(37);
    let (mut compared, mut complex) = (0, 0);
    for _ in 0..40 {
        let (omega, psi) = (random.between(0.4, 2.0), random.between(0.0, 3.0));
        let made = random.structure();
        let n = made.size();
        let contacts = (made.contacts.iter())
            .map(|w| {
                let limits = (random.between(-1.0, -0.2), random.between(0.2, 1.0));
                let lower = (random.between(0.0, 1.0) < 0.7).then_some(limits.0);
                (w.clone(), Contact { lower, upper: Some(limits.1), restitution: random.between(0.5, 1.0) })
            })
            .collect();
        let load = DVector::from_fn(n, |_, _| Complex::new(random.between(-2.0, 2.0), random.between(-1.0, 1.0)));
        let structure = Structure {
            mass: made.mass.clone(),
            damping: made.damping.clone(),
            stiffness: made.stiffness.clone(),
            contacts,
            static_load: made.static_load.clone(),
            loads: vec![(1, load)],
            modes: None,
        };
        let q = DVector::zeros(n);
        let v = DVector::from_fn(n, |_, _| random.between(-1.0, 1.0));
        let mut simulation = started(&structure, omega, psi, &q, &v);
        complex += usize::from(!simulation.structure().unwrap().modes()[0].is_real);
        let (_, events) = simulation.collect(&Limits { impacts: 12, ..until(&simulation, 4, 0.0) });
        let reach = events.last().map_or(0.0, |event| event.time.to_f64());
        let dense = Dense::new(&structure, omega, psi, &q, &v).impacts(reach + 1e-6, 2e-3);
        for (event, (contact, time, velocity)) in events.iter().zip(&dense) {
            // Slow impacts are where errors grow.
            if event.kind != EventKind::Impact || event.velocity_before.abs() < 0.05 {
                break;
            }
            assert_eq!(event.contact, *contact, "{event:?} {time}");
            assert!((event.time.to_f64() - time).abs() < 1e-9, "{event:?} {time}");
            assert!((event.velocity_before - velocity).abs() < 1e-9, "{event:?} {velocity}");
            compared += 1;
        }
    }
    assert!(compared >= 150 && complex >= 30, "{compared} {complex}");
}

#[test]
fn a_graze_that_hides_between_samples_is_found_and_one_that_misses_is_not() {
    // A slow swing of size 1 and a ripple of 1000 times its rate: the stop is 1e-6 below, or above, the highest crest.
    let (slow, fast, size) = (1.0, 1000.0, 1e-3);
    let shape = |at: f64| ModeShape { contacts: vec![at], coordinates: vec![at], still: 0.0 };
    let height = |t: f64| (slow * t).sin() + size * (fast * t + 0.3).sin();
    let crest = (0..2_000_000).map(|i| height(1.5 + f64::from(i) * 1e-7)).fold(0.0, f64::max);
    for (depth, hits) in [(1e-6, 1), (-1e-6, 0)] {
        let stop = Contact { lower: None, upper: Some(crest - depth), restitution: 0.5 };
        let modes = vec![
            LinearMode::oscillator(0.0, slow * slow, &shape(1.0), &[]),
            LinearMode::oscillator(0.0, fast * fast, &shape(1.0), &[]),
        ];
        let structure = ModalStructure::new(vec![stop], vec![], modes).unwrap();
        let xi = [[0.0, 1.0], [size * 0.3f64.sin(), size * 0.3f64.cos()]];
        let mut simulation = Simulation::of_modes(structure, 1.0, 0.0, &xi).unwrap();
        let (_, events) = simulation.collect(&Limits { impacts: 1, ..until(&simulation, 0, 0.5) });
        assert_eq!(events.len(), hits, "{events:?}");
        if let Some(event) = events.first() {
            assert!((height(event.time.to_f64()) - crest + depth).abs() < 1e-14, "{event:?}");
            assert!(event.velocity_before > 0.0);
        }
    }
}

/// The chain of events.rs: sticks and releases on both barriers.
#[test]
fn a_chain_given_as_a_structure_does_what_the_chain_does() {
    let ring = Point::ring(5).gamma1(0.2).gamma2(0.1);
    let model = ring.omega(0.4).asymmetry(0.4).amplitude(1.5).restitution(0.3).model().unwrap();
    let stiffness = DMatrix::from_fn(5, 5, |i, j| match (i + 5 - j) % 5 {
        0 => 0.4,
        1 | 4 => -0.1,
        _ => 0.0,
    });
    let at = |n: usize| {
        let limits = Contact { lower: Some(-0.6), upper: Some(1.4), restitution: 0.3 };
        (DVector::from_fn(5, |i, _| f64::from(u8::from(i == n))), limits)
    };
    let structure = Structure {
        mass: DMatrix::identity(5, 5),
        stiffness,
        contacts: (0..5).map(at).collect(),
        loads: harmonic(&DVector::from_element(5, 1.5)),
        ..Structure::default()
    };
    let v = DVector::from_vec(vec![0.5, 0.0, 0.0, 0.0, 0.0]);
    let mut simulation = started(&structure, 0.4, 0.0, &DVector::zeros(5), &v);
    let (_, events) = simulation.collect(&until(&simulation, 2, 0.0));
    let mut chain = Simulation::new(&model, 0.0, &[0.0; 5], v.as_slice()).unwrap();
    let (_, expected) = chain.collect(&Limits::until(Time::new(&model, 2, 0.0)));
    assert!(expected.iter().any(|event| event.kind == EventKind::Release));
    // Mirror images come in an order that rounding decides.
    let of = |kind: EventKind, site: usize| expected.iter().filter(move |e| e.kind == kind && e.contact == site);
    let mut compared = 0;
    for site in 0..5 {
        for kind in [EventKind::Impact, EventKind::Stick, EventKind::Release] {
            let mine: Vec<&Event> = events.iter().filter(|e| e.kind == kind && e.contact == site).collect();
            let first = of(kind, site).take_while(|e| e.velocity_before.abs() > 1e-4 || kind != EventKind::Impact);
            for (event, expected) in mine.iter().zip(first) {
                assert_eq!(event.barrier, expected.barrier);
                assert!((event.time.to_f64() - expected.time.to_f64()).abs() < 1e-12, "{event:?} {expected:?}");
                assert!((event.velocity_before - expected.velocity_before).abs() < 1e-11, "{event:?} {expected:?}");
                compared += 1;
            }
            assert!(kind == EventKind::Impact || mine.len() == of(kind, site).count(), "{kind} {site}");
        }
    }
    assert!(compared > 40, "{compared}");
    let (state, chain) = (simulation.state(), chain.state());
    for n in 0..5 {
        assert!(
            (state.displacement[n] - chain.displacement[n]).abs() < 1e-12
                && (state.velocity[n] - chain.velocity[n]).abs() < 1e-12
        );
    }
}

#[test]
fn contacts_that_share_coordinates_hit_at_one_instant_only_on_request() {
    // Three equal balls in a row, apart by 1: the middle one is hit from both sides at once. And a cradle: two at rest touch.
    let n = 3;
    let structure = Structure {
        mass: DMatrix::identity(n, n),
        stiffness: DMatrix::zeros(n, n),
        contacts: vec![
            contact(&[1.0, -1.0, 0.0], None, Some(0.5), 1.0),
            contact(&[0.0, 1.0, -1.0], None, Some(0.5), 1.0),
        ],
        ..Structure::default()
    };
    let meet = |q: [f64; 3], v: [f64; 3]| {
        started(&structure, 1.0, 0.0, &DVector::from_column_slice(&q), &DVector::from_column_slice(&v))
    };
    let mut both = meet([0.0; 3], [1.0, 0.0, -1.0]);
    let (report, events) = both.collect(&until(&both, 1, 0.0));
    assert_eq!(report.outcome, Outcome::Simultaneous { first: 0, second: 1 });
    assert!(events.is_empty() && (report.time.to_f64() - 0.5).abs() < 1e-15);
    let mut both = both.in_sequence();
    let (report, events) = both.collect(&until(&both, 1, 0.0));
    assert_eq!(report.outcome, Outcome::TimeReached);
    // In sequence velocities are exchanged: (1, 0, −1), (0, 1, −1), (0, −1, 1), (−1, 0, 1).
    assert_eq!(events.iter().map(|event| event.contact).collect::<Vec<_>>(), [0, 1, 0]);
    let end = both.state().velocity;
    assert!([-1.0, 0.0, 1.0].iter().zip(end).all(|(expected, v)| (v - expected).abs() < 1e-14));

    // The second pair touches without a force, and is pushed together by the first ball.
    let mut cradle = meet([-1.0, 0.5, 0.0], [2.0, 0.0, 0.0]);
    let (report, _) = cradle.collect(&until(&cradle, 1, 0.0));
    assert_eq!(report.outcome, Outcome::Simultaneous { first: 0, second: 1 });
    let mut cradle = cradle.in_sequence();
    cradle.run(&until(&cradle, 1, 0.0), |_| {});
    let end = cradle.state().velocity;
    assert!([0.0, 0.0, 2.0].iter().zip(&end).all(|(expected, v)| (v - expected).abs() < 1e-14), "{end:?}");
}

/// A mode of a million times the rate of the others, as matrices of finite elements have them: its own part of the motion is small.
#[test]
fn a_stiff_mode_costs_steps_and_no_digits() {
    let shape = |at: f64| ModeShape { contacts: vec![at], coordinates: vec![at], still: 0.0 };
    let stop = Contact { lower: Some(-0.7), upper: Some(0.3), restitution: 1.0 };
    let rates = [1.0, 2.7, 1e6];
    let modes = rates.map(|rate| LinearMode::oscillator(0.0, rate * rate, &shape(1.0), &[])).to_vec();
    let structure = ModalStructure::new(vec![stop], vec![], modes).unwrap();
    let mut simulation = Simulation::of_modes(structure, 1.0, 0.0, &[[0.1, 0.8], [-0.1, 0.2], [0.0, 0.0]]).unwrap();
    let start = energy(&simulation);
    let (report, events) = simulation.collect(&Limits::impacts(200));
    assert_eq!((report.outcome, events.len()), (Outcome::ImpactsReached, 200));
    assert!((energy(&simulation) / start - 1.0).abs() < 1e-12);
}
