//! How runs end, what they may be given, and that they repeat.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use vibrochain_eventsim::{Event, Outcome, Simulation, StateError};
use vibrochain_lattice::{Barrier, Complex, Contact, LinearMode, ModalStructure, ModeShape, Structure};
use vibrochain_testkit::Random;

use crate::dense::Dense;
use crate::made::{contact, harmonic, pressed, started, until};

#[test]
fn a_run_is_the_same_to_the_bit_however_often_it_is_looked_at() {
    let (q, v) = (DVector::from_vec(vec![0.1, 0.2, -0.1]), DVector::from_vec(vec![0.5, -0.2, 0.4]));
    let mut whole = started(&pressed(), 0.6, 0.3, &q, &v);
    let mut parts = whole.clone();
    let (_, expected) = whole.collect(&until(&whole, 5, 0.0));
    let mut events = Vec::new();
    for part in 1..=500 {
        parts.run(&until(&parts, 0, 0.01 * f64::from(part)), |event| events.push(*event));
        let _ = parts.state();
    }
    assert!(expected.len() > 20 && events == expected, "{} {}", events.len(), expected.len());
    assert_eq!(whole.state().modes, parts.state().modes);
}

/// A structure of micrometres and tenths of milliseconds does what one of metres and seconds does: to the bit, as units are powers of two,
/// and that of time one of four, whose root is in complex shapes.
#[test]
fn units_do_not_matter() {
    let (length, time) = (2f64.powi(-20), 2f64.powi(-14));
    let large = pressed();
    let mut small = large.clone();
    small.stiffness /= time * time;
    small.damping /= time;
    small.static_load *= length / (time * time);
    small.loads.iter_mut().for_each(|(_, load)| *load *= Complex::new(length / (time * time), 0.0));
    for (_, contact) in &mut small.contacts {
        contact.lower = contact.lower.map(|lower| lower * length);
        contact.upper = contact.upper.map(|upper| upper * length);
    }
    let (q, v) = (DVector::from_vec(vec![0.1, 0.2, -0.1]), DVector::from_vec(vec![0.5, -0.2, 0.4]));
    let run = |structure: &Structure, length: f64, time: f64| {
        let mut simulation = started(structure, 0.6 / time, 0.3 * time, &(&q * length), &(&v * (length / time)));
        simulation.collect(&until(&simulation, 4, 0.0)).1
    };
    let (large, small) = (run(&large, 1.0, 1.0), run(&small, length, time));
    assert!(large.len() > 20);
    let told = |events: &[Event], length: f64, time: f64| {
        let of = |event: &Event| {
            (event.kind, event.contact, event.time.offset() / time, event.velocity_before * time / length)
        };
        events.iter().map(of).collect::<Vec<_>>()
    };
    assert_eq!(told(&large, 1.0, 1.0), told(&small, length, time));
}

#[test]
fn a_mode_that_feeds_itself_and_meets_no_stop_ends_the_run() {
    let shape = |at: f64| ModeShape { contacts: vec![at], coordinates: vec![at], still: 0.0 };
    let stop = Contact { lower: None, upper: Some(1.0), restitution: 0.5 };
    let modes =
        vec![LinearMode::oscillator(0.0, 1.0, &shape(1.0), &[]), LinearMode::oscillator(-0.1, 1.0, &shape(0.0), &[])];
    let structure = ModalStructure::new(vec![stop], vec![], modes).unwrap();
    let mut simulation = Simulation::of_modes(structure, 1.0, 0.0, &[[0.5, 0.0], [1.0, 0.0]]).unwrap();
    let report = simulation.run(&until(&simulation, 1_000_000, 0.0), |_| {});
    assert_eq!(report.outcome, Outcome::Diverged { mode: 1 });
    // 1e4 times its start, looked at once a turn.
    assert!((report.time.to_f64() - 1e4f64.ln() / 0.1).abs() < 2.0 * TAU, "{report:?}");
}

#[test]
fn a_mode_that_feeds_itself_and_is_stopped_goes_on() {
    // The start is tiny, and the stops are seen by little of the mode: both walls hold it, beyond 1e4 times its start.
    let shape = ModeShape { contacts: vec![1e-3], coordinates: vec![1e-3], still: 0.0 };
    let stops = Contact { lower: Some(-1.0), upper: Some(1.0), restitution: 0.5 };
    let modes = vec![LinearMode::oscillator(-0.1, 1.0, &shape, &[])];
    let structure = ModalStructure::new(vec![stops], vec![], modes).unwrap();
    let mut simulation = Simulation::of_modes(structure, 1.0, 0.0, &[[1e-6, 0.0]]).unwrap();
    let report = simulation.run(&until(&simulation, 500, 0.0), |_| {});
    assert_eq!(report.outcome, Outcome::TimeReached);
    assert!(report.work.impacts > 500, "{report:?}");
}

#[test]
fn without_a_loss_many_impacts_a_period_are_too_many() {
    let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: -1.0 };
    let run = |restitution: f64, speed: f64, periods: u64| {
        let table = Contact { lower: Some(0.0), upper: None, restitution };
        let modes = vec![LinearMode::oscillator(0.0, 0.0, &shape, &[])];
        let ball = ModalStructure::new(vec![table], vec![], modes).unwrap();
        let mut simulation = Simulation::of_modes(ball, 1.0, 0.0, &[[0.0, speed]]).unwrap();
        simulation.run(&until(&simulation, periods, 0.0), |_| {}).outcome
    };
    let cascade = Outcome::Cascade { contact: 0, barrier: Barrier::Lower, bounces: 100_000 };
    // Flights of twice the speed: 3·10⁵ a period, and 3·10⁴; with a loss it comes to rest.
    assert_eq!(run(1.0, 1e-5, 1), cascade);
    assert_eq!(run(1.0, 1e-4, 5), Outcome::TimeReached);
    assert_eq!(run(0.999, 1e-5, 1), Outcome::TimeReached);
}

#[test]
fn states_are_projected_and_told_back_whatever_the_damping() {
    let mut random = Random(5);
    let mut kinds = [0; 3];
    for _ in 0..60 {
        let made = random.structure();
        let n = made.size();
        let structure = Structure {
            mass: made.mass.clone(),
            damping: made.damping.clone(),
            stiffness: made.stiffness.clone(),
            contacts: vec![(made.contacts[0].clone(), Contact { lower: None, upper: Some(1e3), restitution: 1.0 })],
            static_load: made.static_load.clone(),
            loads: harmonic(&made.load),
            modes: None,
        };
        let (q, v) = (
            DVector::from_fn(n, |_, _| random.between(-1.0, 1.0)),
            DVector::from_fn(n, |_, _| random.between(-1.0, 1.0)),
        );
        let simulation = started(&structure, made.omega, made.psi, &q, &v);
        for mode in simulation.structure().unwrap().modes() {
            kinds[usize::from(mode.is_real)
                + 2 * usize::from(!mode.is_real && mode.turn == vibrochain_lattice::Turn::Hyperbolic)] += 1;
        }
        let state = simulation.state();
        for i in 0..n {
            assert!(
                (state.displacement[i] - q[i]).abs() < 1e-10 && (state.velocity[i] - v[i]).abs() < 1e-9,
                "{i} {state:?} {q} {v}"
            );
        }
    }
    assert!(kinds[0] > 100 && kinds[2] > 5, "{kinds:?}");
}

/// Next to a resonance, at it, and of a rigid mode: against the exponential with the loads in it.
#[test]
fn resonances_and_rigid_modes_under_loads_have_no_limit() {
    let mut compared = 0;
    for detuning in [0.0, 1e-12, 1e-6, 1e-3, 0.02, 0.3] {
        for (stiffness, damping) in [
            (1.0, 0.0),
            (1.0, 1e-9),
            (0.0, 0.0),
            (0.0, 0.5),
            (0.0, 40.0),
            (1.0, 2.0),
            (1e-8, 0.0),
            (1.0, 2.0 + 1e-9),
            (1.0, -0.3),
        ] {
            let structure = Structure {
                mass: DMatrix::identity(1, 1),
                damping: DMatrix::from_element(1, 1, damping),
                stiffness: DMatrix::from_element(1, 1, stiffness),
                contacts: vec![contact(&[1.0], Some(-1e3), None, 1.0)],
                static_load: DVector::from_element(1, 0.2),
                loads: vec![(1, DVector::from_element(1, Complex::new(0.7, 0.3)))],
                modes: None,
            };
            let omega = 1.0 + detuning;
            let (q, v) = (DVector::from_element(1, 0.4), DVector::from_element(1, -0.3));
            let mut simulation = started(&structure, omega, 0.4, &q, &v);
            let dense = Dense::new(&structure, omega, 0.4, &q, &v);
            for part in [0.0, 0.001, 0.3, 1.7] {
                simulation.run(&until(&simulation, 0, part), |_| {});
                let exact = (&dense.generator * simulation.time().to_f64()).exp() * &dense.state;
                let state = simulation.state();
                let case = format!("{detuning} {stiffness} {damping} {part}");
                assert!(
                    (state.displacement[0] - exact[0]).abs() < 3e-13 * (1.0 + exact[0].abs()),
                    "{case}: {state:?} {exact}"
                );
                assert!(
                    (state.velocity[0] - exact[1]).abs() < 3e-13 * (1.0 + exact[1].abs()),
                    "{case}: {state:?} {exact}"
                );
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 6 * 9 * 4);
}

#[test]
fn states_that_cannot_be_are_refused() {
    let structure = pressed().modal().unwrap();
    let still = structure.still();
    let make =
        |omega: f64, psi: f64, xi: &[[f64; 2]]| Simulation::of_modes(structure.clone(), omega, psi, xi).unwrap_err();
    assert!(matches!(make(1.0, 0.0, &still[..2]), StateError::Modes { given: 2, wanted: 3 }));
    assert_eq!(make(0.0, 0.0, &still).to_string(), "omega is 0: give a frequency above 0");
    assert_eq!(make(1.0, f64::NAN, &still).to_string(), "psi is NaN: give a finite number");
    let far: Vec<[f64; 2]> = still.iter().map(|xi| [xi[0] + 10.0, xi[1]]).collect();
    assert!(matches!(make(1.0, 0.0, &far), StateError::OutsideGap { .. }));
}
