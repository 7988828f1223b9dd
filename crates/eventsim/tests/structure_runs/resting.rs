//! Contacts that chatter, rest and let go.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use vibrochain_eventsim::{EventKind, Limits, Outcome, Simulation};
use vibrochain_lattice::{Barrier, Complex, Contact, LinearMode, ModalStructure, ModeShape, Structure};

use crate::made::{balanced, contact, energy, harmonic, started, until};

/// A contact that is a combination of coordinates rests under a static load, with dashpots, until the load lets it go: against Runge and
/// Kutta on the same motion, its acceleration along the contact taken off.
#[test]
fn contacts_at_rest_move_as_their_constraint_says_and_leave_when_their_force_vanishes() {
    let n = 3;
    let structure = Structure {
        mass: DMatrix::from_row_slice(n, n, &[1.0, 0.1, 0.0, 0.1, 1.4, 0.0, 0.0, 0.0, 0.7]),
        damping: DMatrix::from_row_slice(n, n, &[0.3, -0.1, 0.0, -0.1, 0.1, 0.0, 0.0, 0.0, 0.02]),
        stiffness: DMatrix::from_row_slice(n, n, &[1.0, -0.3, 0.0, -0.3, 0.9, -0.2, 0.0, -0.2, 0.6]),
        contacts: vec![
            contact(&[1.0, -0.5, 0.0], None, Some(0.0), 0.0),
            contact(&[0.0, 0.6, 1.0], None, Some(0.0), 0.4),
        ],
        static_load: DVector::from_vec(vec![0.5, 0.1, 0.45]),
        loads: harmonic(&DVector::from_vec(vec![0.6, -0.2, 0.2])),
        modes: None,
    };
    let (omega, psi) = (0.7, 0.2);
    // Contact 0 comes back and pushes the other one, which rests, into its barrier: without a word about the order that is the end.
    let mut alone = started(&structure, omega, psi, &DVector::zeros(n), &DVector::zeros(n));
    let report = alone.run(&until(&alone, 1, 0.0), |_| {});
    assert_eq!(report.outcome, Outcome::Simultaneous { first: 0, second: 1 });
    // At rest with both contacts on their barriers.
    let mut simulation = started(&structure, omega, psi, &DVector::zeros(n), &DVector::zeros(n)).in_sequence();
    let (report, events) = simulation.collect(&until(&simulation, 1, 0.0));
    assert_eq!(report.outcome, Outcome::TimeReached);
    let held: Vec<_> = events.iter().take(2).map(|event| (event.kind, event.contact, event.time.to_f64())).collect();
    assert_eq!(held, [(EventKind::Stick, 0, 0.0), (EventKind::Stick, 1, 0.0)]);
    let release = events.iter().find(|event| event.kind == EventKind::Release).unwrap();

    let inverse = structure.mass.clone().try_inverse().unwrap();
    let w = DMatrix::from_columns(&[structure.contacts[0].0.clone(), structure.contacts[1].0.clone()]);
    let mobility = (w.transpose() * &inverse * &w).try_inverse().unwrap();
    let forces = |t: f64, y: &DVector<f64>| {
        let push = structure.loads[0].1.map(|f| f.re) * (omega * (t + psi)).cos() + &structure.static_load;
        let free = &inverse * (push - &structure.stiffness * y.rows(0, n) - &structure.damping * y.rows(n, n));
        let force = -&mobility * w.transpose() * &free;
        (free + &inverse * &w * &force, force)
    };
    let field = |t: f64, y: &DVector<f64>| {
        let (acceleration, _) = forces(t, y);
        DVector::from_fn(2 * n, |i, _| if i < n { y[n + i] } else { acceleration[i - n] })
    };
    let (mut y, mut t, h) = (DVector::zeros(2 * n), 0.0, 1e-3);
    let step = |t: f64, y: &DVector<f64>, h: f64| {
        let a = field(t, y);
        let b = field(t + 0.5 * h, &(y + &a * (0.5 * h)));
        let c = field(t + 0.5 * h, &(y + &b * (0.5 * h)));
        let d = field(t + h, &(y + &c * h));
        y + (a + b * 2.0 + c * 2.0 + d) * (h / 6.0)
    };
    let pulls = |t: f64, y: &DVector<f64>| forces(t, y).1.max();
    assert!(pulls(0.0, &y) < 0.0);
    loop {
        let next = step(t, &y, h);
        if pulls(t + h, &next) >= 0.0 {
            break;
        }
        (y, t) = (next, t + h);
        assert!(t < 5.0);
    }
    let (mut low, mut high) = (0.0, h);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if pulls(t + middle, &step(t, &y, middle)) < 0.0 { low = middle } else { high = middle }
    }
    assert!((release.time.to_f64() - t - low).abs() < 1e-11, "{release:?} {}", t + low);
    // And where it is half way there.
    let mut again = started(&structure, omega, psi, &DVector::zeros(n), &DVector::zeros(n));
    let half = 0.5 * (t + low);
    again.run(&until(&again, 0, half * omega / TAU), |_| {});
    let (mut y, steps) = (DVector::zeros(2 * n), 2000);
    for i in 0..steps {
        let h = half / f64::from(steps);
        y = step(f64::from(i) * h, &y, h);
    }
    let (state, contacts) = (again.state(), again.contacts());
    for i in 0..n {
        assert!((state.displacement[i] - y[i]).abs() < 1e-12 && (state.velocity[i] - y[n + i]).abs() < 1e-12);
    }
    let (_, force) = forces(half, &y);
    for contact in 0..2 {
        assert!((contacts[contact].force - force[contact]).abs() < 1e-11);
        assert!(contacts[contact].resting == Some(Barrier::Upper) && contacts[contact].place == 0.0);
    }
}

#[test]
fn a_ball_on_a_table_bounces_geometrically_to_its_limit() {
    // Gravity alone, from the table with v: bounces take 2v/g, e of that, …; t∞ = 2v/(g(1−e)).
    let (g, v) = (9.81, 1.3);
    for e in [0.0, 0.1, 0.5, 0.9, 0.99] {
        let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: -g };
        let table = Contact { lower: Some(0.0), upper: None, restitution: e };
        let ball =
            ModalStructure::new(vec![table], vec![], vec![LinearMode::oscillator(0.0, 0.0, &shape, &[])]).unwrap();
        let mut simulation = balanced(Simulation::of_modes(ball, 0.05, 0.0, &[[0.0, v]]).unwrap());
        let start = energy(&simulation);
        let (_, events) = simulation.collect(&until(&simulation, 1, 0.0));
        let mut time = 0.0;
        let impacts: Vec<_> = events.iter().filter(|event| event.kind == EventKind::Impact).collect();
        for (i, event) in impacts.iter().enumerate() {
            time += 2.0 * v * e.powi(i as i32) / g;
            assert!((event.time.to_f64() - time).abs() < 1e-13 * (1.0 + 0.01 / (1.0 - e)), "{e} {i} {event:?} {time}");
            assert!((event.velocity_before / (-v * e.powi(i as i32)) - 1.0).abs() < 1e-6, "{e} {i} {event:?}");
        }
        let stick = events.last().unwrap();
        assert_eq!(stick.kind, EventKind::Stick);
        let limit = 2.0 * v / (g * (1.0 - e));
        assert!((stick.time.to_f64() / limit - 1.0).abs() < 1e-13, "{e} {stick:?} {limit}");
        assert!((simulation.contact(0).unwrap().force - g).abs() < 1e-13);
        let balance = simulation.balance().unwrap();
        assert!((balance.impacts - start).abs() < 1e-13 && balance.work.abs() < 1e-13, "{e} {balance:?} {start}");
    }
}

/// A ball on a table that shakes as B cos ωt: parabolas against the table, its rest and its release where −g is the table's acceleration.
#[test]
fn a_ball_on_a_shaken_table_follows_its_parabolas() {
    let (g, omega, e) = (9.81, 5.0, 0.6);
    // Seen from the table: x″ = −g + Bω² cos ωt.
    for shake in [0.7, 1.2, 3.0] {
        let amplitude = shake * g / (omega * omega);
        let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: -g };
        let table = Contact { lower: Some(0.0), upper: None, restitution: e };
        let load = [Complex::new(amplitude * omega * omega, 0.0)];
        let mode = LinearMode::oscillator(0.0, 0.0, &shape, &load);
        let ball = ModalStructure::new(vec![table], vec![1], vec![mode]).unwrap();
        let (x, v) = (0.3, 0.4);
        let mut simulation = Simulation::of_modes(ball, omega, 0.0, &[[x, v]]).unwrap();
        let (_, events) = simulation.collect(&until(&simulation, 6, 0.0));
        let place = |t: f64| amplitude * (omega * t).cos();
        let speed = |t: f64| -amplitude * omega * (omega * t).sin();
        let (mut start, mut y, mut w, mut compared) = (0.0, place(0.0) + x, speed(0.0) + v, 0);
        for event in events.iter().take_while(|event| event.kind == EventKind::Impact && event.velocity_before < -1e-3)
        {
            let height = |t: f64| y + (w - 0.5 * g * (t - start)) * (t - start) - place(t);
            let mut low = start + 1e-6;
            while height(low + 1e-5) > 0.0 {
                low += 1e-5;
            }
            let mut high = low + 1e-5;
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if height(middle) > 0.0 { low = middle } else { high = middle }
            }
            let before = w - g * (low - start) - speed(low);
            // What rounding has left grows from bounce to bounce.
            let fine = 1e-14 * 2f64.powi(compared) / before.abs().min(1.0);
            assert!((event.time.to_f64() - low).abs() < fine, "{shake}: {event:?} {low}");
            assert!((event.velocity_before - before).abs() < 100.0 * fine, "{shake}: {event:?} {before}");
            (start, y, w) = (low, place(low), speed(low) - e * before);
            compared += 1;
        }
        assert!(compared >= 5, "{compared}");
        let releases: Vec<_> = events.iter().filter(|event| event.kind == EventKind::Release).collect();
        assert_eq!(releases.is_empty(), shake < 1.0 || shake == 3.0, "{shake} {releases:?}");
        for release in releases {
            let part = release.time.part() * TAU;
            assert!((part - (TAU - (1.0 / shake).acos())).abs() < 1e-13, "{release:?}");
        }
    }
}

#[test]
fn without_a_loss_a_contact_that_is_pressed_bounces_for_ever() {
    let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: -1.0 };
    let table = Contact { lower: Some(0.0), upper: None, restitution: 1.0 };
    let ball = ModalStructure::new(vec![table], vec![], vec![LinearMode::oscillator(0.0, 0.0, &shape, &[])]).unwrap();
    let mut simulation = Simulation::of_modes(ball, 1.0, 0.0, &[[0.0, 1e-7]]).unwrap();
    let report = simulation.run(&until(&simulation, 1, 0.0), |_| {});
    let cascade = Outcome::Cascade { contact: 0, barrier: Barrier::Lower, bounces: 100_000 };
    assert_eq!(report.outcome, cascade);
    assert!((report.time.to_f64() - 100_000.0 * 2e-7).abs() < 1e-12, "{report:?}");
    // It goes on where it is asked to.
    let report = simulation.run(&Limits { impacts: 10, ..until(&simulation, 1, 0.0) }, |_| {});
    assert_eq!(report.outcome, Outcome::ImpactsReached);
}
