//! Motions that a load presses against a stop: measured from where they would rest, contacts that are differences, forces that touch zero.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use vibrochain_eventsim::{EventKind, Limits, Outcome, Simulation};
use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape, Structure};
use vibrochain_testkit::Random;

use crate::made::{contact, harmonic, started, until};

/// One mass above a stop.
#[derive(Debug, Clone, Copy)]
struct Pressed {
    mass: f64,
    stiffness: f64,
    damping: f64,
    still: f64,
    stop: f64,
    restitution: f64,
}

impl Pressed {
    fn started(&self, omega: f64, place: f64) -> Simulation {
        let &Self { mass, stiffness, damping, still, stop, restitution } = self;
        let part = mass.sqrt().recip();
        let shape = ModeShape { contacts: vec![part], coordinates: vec![part], still: still * part };
        let decay = 0.5 * damping / mass;
        let mode = LinearMode::oscillator(decay, stiffness / mass - decay * decay, &shape, &[]);
        let stop = Contact { lower: Some(stop), upper: None, restitution };
        let rate = mode.rate;
        let modal = ModalStructure::new(vec![stop], vec![], vec![mode]).unwrap();
        // At rest: of a damped mode q′ = 0 takes ξ₂ = δξ₁/κ.
        let first = place / part;
        Simulation::of_modes(modal, omega, 0.0, &[[first, decay * first / rate]]).unwrap()
    }

    /// The same motion with the stop moved in the place of the static load, by which places are less.
    fn moved(&self) -> (Self, f64) {
        let by = self.still / self.stiffness;
        (Self { still: 0.0, stop: self.stop - by, ..*self }, by)
    }
}

/// When it comes to rest, and after how many impacts.
fn rest(mut simulation: Simulation, periods: u64) -> (Option<f64>, u64, Outcome) {
    let limits = until(&simulation, periods, 0.0);
    let mut at = None;
    let report = simulation.run(&limits, |event| {
        if event.kind == EventKind::Stick {
            at = at.or(Some(event.time.to_f64()));
        }
    });
    (at, report.work.impacts, report.outcome)
}

/// Bounces about a static position below the stop take 2 arctan(v/(Ω²d))Ω⁻¹ each, with e of the velocity before: summed in 40 digits.
#[test]
fn a_mass_that_a_static_load_presses_comes_to_rest_where_the_sum_of_its_bounces_says() {
    let pressed = Pressed { mass: 1e-3, stiffness: 100.0, damping: 0.0, still: -0.00981, stop: 0.0, restitution: 0.9 };
    let exact = 0.870_279_607_715_797_7;
    // Whatever the unit in which time is told.
    for omega in [1.0, 0.05, 30.0, 3e3, 1e5] {
        let periods = (0.9 * omega / TAU).ceil() as u64;
        let (at, impacts, outcome) = rest(pressed.started(omega, 1.0), periods);
        assert_eq!(outcome, Outcome::TimeReached, "{omega}");
        assert!((at.unwrap() - exact).abs() < 1e-14 && impacts > 100, "{omega}: {at:?} {exact}");
    }
}

/// None ends in a cascade, and each comes to rest when its twin does.
#[test]
fn preloaded_masses_come_to_rest_as_those_with_a_shifted_stop_do() {
    let mut random = Random(52);
    let (mut rests, mut damped, mut worst) = (0, 0, 0.0_f64);
    for _ in 0..300 {
        let (mass, stiffness) = (random.log(1e-3, 10.0), random.log(0.1, 1e3));
        let rate = (stiffness / mass).sqrt();
        let is_damped = random.chance(0.3);
        let damping = if is_damped { mass * rate * random.log(1e-3, 0.2) } else { 0.0 };
        // Where the load would hold it below the stop, against a start of 1 above it.
        let depth = random.log(1e-6, 1.0);
        let stop = if random.chance(0.5) { 0.0 } else { random.between(-2.0, 2.0) };
        let still = stiffness * (stop - depth);
        let restitution = random.between(0.3, 0.95);
        let pressed = Pressed { mass, stiffness, damping, still, stop, restitution };
        let place = stop + random.between(0.2, 1.0);
        // Times of all bounces are below this.
        let omega = TAU * rate / 3e3;
        let (at, _, outcome) = rest(pressed.started(omega, place), 1);
        let (twin, by) = pressed.moved();
        let (other, _, _) = rest(twin.started(omega, place - by), 1);
        assert_eq!(outcome, Outcome::TimeReached, "{pressed:?}");
        let (Some(at), Some(other)) = (at, other) else { panic!("{pressed:?}: {at:?} {other:?}") };
        // The twin's own stop is rounded, by so much of the depth.
        let known = 1e-13 + 8.0 * f64::EPSILON * (still / stiffness).abs().max(stop.abs()) / depth;
        worst = worst.max((at - other).abs() / at);
        assert!((at - other).abs() <= known * at, "{pressed:?}: {at} {other} {known:e}");
        rests += 1;
        damped += usize::from(is_damped);
    }
    println!("{rests} rests, {damped} damped, {worst:e}");
    assert!(rests == 300 && damped > 50, "{rests} {damped}");
}

/// The same of a load that swings: slowly, so that it presses for many bounces.
#[test]
fn masses_that_a_slow_load_presses_end_in_no_cascade() {
    let mut random = Random(7);
    let mut sticks = 0;
    for _ in 0..100 {
        let rate = random.log(10.0, 1e3);
        let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
        let load = [Complex::new(rate * rate * random.log(1e-4, 1.0), 0.0)];
        let mode = LinearMode::oscillator(0.0, rate * rate, &shape, &load);
        let stop = Contact { lower: None, upper: Some(0.0), restitution: random.between(0.3, 0.9) };
        let modal = ModalStructure::new(vec![stop], vec![1], vec![mode]).unwrap();
        let mut simulation = Simulation::of_modes(modal, 1.0, 0.0, &[[-random.between(0.1, 1.0), 0.0]]).unwrap();
        let (report, events) = simulation.collect(&until(&simulation, 2, 0.0));
        assert_eq!(report.outcome, Outcome::TimeReached);
        sticks += usize::from(events.iter().any(|event| event.kind == EventKind::Stick));
    }
    assert!(sticks >= 95, "{sticks}");
}

/// Masses m₁ and m₂ on springs of one rate Ω: their distance is an oscillator by itself, whatever their common motion is, which is large.
#[test]
fn a_difference_of_coordinates_chatters_as_the_distance_by_itself() {
    let (exact, mut compared) = (0.870_279_607_715_797_7, 0);
    for (masses, common) in [([1e-3, 1e-3], 0.0), ([1e-3, 2.7e-3], 0.0), ([1e-3, 2.7e-3], 100.0), ([0.3, 0.11], 1e4)] {
        let square = 1e5;
        let structure = Structure {
            mass: DMatrix::from_diagonal(&DVector::from_column_slice(&masses)),
            stiffness: DMatrix::from_diagonal(&DVector::from_column_slice(&masses.map(|mass| square * mass))),
            contacts: vec![contact(&[1.0, -1.0], Some(0.0), None, 0.9)],
            static_load: DVector::from_vec(vec![-9.81 * masses[0], 0.0]),
            ..Structure::default()
        };
        let q = DVector::from_vec(vec![common + 1.0, common]);
        let simulation = started(&structure, 1.0, 0.0, &q, &DVector::zeros(2));
        let (at, _, outcome) = rest(simulation, 1);
        assert_eq!(outcome, Outcome::TimeReached, "{masses:?} {common}");
        let off = (at.unwrap() - exact).abs();
        // The modes know the distance from where the load would hold it, 9.81e-5, to the rounding of the places that it is of.
        let known = 4.0 * f64::EPSILON * (1.0 + common) / 9.81e-5;
        assert!(off < known, "{masses:?} {common}: {off:e} {known:e}");
        compared += 1;
    }
    assert_eq!(compared, 4);
}

/// Three equal balls in a row whose relative velocities shrink by less than a bounce takes: they stay together after infinitely many impacts
/// in a finite time, which is summed in 60 digits.
#[test]
fn three_balls_that_collapse_do_so_when_the_sum_of_their_flights_says() {
    let cases = [(0.07, 2.229_963_178_392_880_6), (0.05, 2.0), (0.02, 1.868_629_280_128_551_6)];
    // Above it they separate again; next to it their velocities shrink by nearly one factor in two ways, and errors add up.
    let most = 7.0 - 48.0_f64.sqrt();
    for (restitution, exact) in cases {
        let structure = Structure {
            mass: DMatrix::identity(3, 3),
            stiffness: DMatrix::zeros(3, 3),
            contacts: vec![
                contact(&[-1.0, 1.0, 0.0], Some(0.0), None, restitution),
                contact(&[0.0, -1.0, 1.0], Some(0.0), None, restitution),
            ],
            ..Structure::default()
        };
        let (q, v) = (DVector::from_vec(vec![0.0, 0.5, 1.7]), DVector::from_vec(vec![1.0, 0.0, -0.3]));
        let mut simulation = started(&structure, 1.0, 0.0, &q, &v);
        let report = simulation.run(&until(&simulation, 1, 0.0), |_| {});
        let at = report.time.to_f64();
        assert!(matches!(report.outcome, Outcome::Simultaneous { .. }), "{restitution}: {report:?}");
        assert!((at - exact).abs() < 2e-15 / (most - restitution), "{restitution}: {at} {exact}");
        // In sequence they stay together, with the momentum that they had.
        let mut simulation = simulation.in_sequence();
        let report = simulation.run(&until(&simulation, 1, 0.0), |_| {});
        assert_eq!(report.outcome, Outcome::TimeReached, "{restitution}");
        let end = simulation.state();
        assert!(end.velocity.iter().all(|v| (v - 0.7 / 3.0).abs() < 1e-14), "{restitution}: {:?}", end.velocity);
    }
}

/// A load that presses with 1 + cos ω(t+ψ) touches 0 once a period: nothing is released. One that pulls by 1e-6 for a while releases once a period.
#[test]
fn a_force_that_touches_zero_releases_nothing() {
    let mut touched = 0;
    for (number, omega) in [0.3, 1.0, 1.7, 2.9].into_iter().enumerate() {
        for still in [1.0, 1.0 - 1e-6] {
            let structure = Structure {
                mass: DMatrix::identity(2, 2),
                stiffness: DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 2.0]),
                contacts: vec![contact(&[1.0, 0.0], None, Some(0.0), 0.5)],
                static_load: DVector::from_vec(vec![still, 0.1]),
                loads: harmonic(&DVector::from_vec(vec![1.0, 0.2])),
                ..Structure::default()
            };
            let psi = 0.37 * number as f64;
            let mut simulation = started(&structure, omega, psi, &DVector::zeros(2), &DVector::zeros(2));
            let (report, events) = simulation.collect(&until(&simulation, 20, 0.0));
            assert_eq!(report.outcome, Outcome::TimeReached);
            let kinds: Vec<EventKind> = events.iter().map(|event| event.kind).collect();
            if still == 1.0 {
                assert_eq!(kinds, [EventKind::Stick], "{omega}");
                touched += 20;
                continue;
            }
            let releases: Vec<_> = events.iter().filter(|event| event.kind == EventKind::Release).collect();
            assert_eq!(releases.len(), 20, "{omega}: {kinds:?}");
            for release in releases {
                let part = (release.time.offset() + psi) * omega;
                let off = part.rem_euclid(TAU) - (TAU / 2.0 - (still).acos());
                // cos is known to its rounding, where its slope is 1.4e-3.
                assert!(off.abs() < 1e-12, "{omega}: {off:e}");
            }
        }
    }
    assert_eq!(touched, 80);
}

/// A run that is cut in the middle of a bounce goes on as if it had not been.
#[test]
fn a_preloaded_run_goes_on_from_anywhere() {
    let pressed = Pressed { mass: 1e-3, stiffness: 100.0, damping: 0.0, still: -0.00981, stop: 0.0, restitution: 0.9 };
    let mut whole = pressed.started(1.0, 1.0);
    let mut cut = whole.clone();
    let end = until(&whole, 0, 0.13);
    let (_, events) = whole.collect(&end);
    let mut seen = Vec::new();
    loop {
        let report = cut.run(&Limits { impacts: 7, ..end }, |event| seen.push(*event));
        if report.outcome != Outcome::ImpactsReached {
            break;
        }
    }
    assert_eq!((events, whole.state()), (seen, cut.state()));
}
