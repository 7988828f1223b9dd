//! What must hold whatever happens: energy, symmetry, periodicity, independence of sampling.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

mod support;

use support::{Random, breather, half_impulses};
use vibrochain_eventsim::{Event, Limits, Outcome, Simulation, Time};
use vibrochain_lattice::{Barrier, Chain, Ends, Model, Point};

fn conservative(sites: usize) -> Model {
    Model::conservative(Chain::new(sites, 0.2, 0.1).unwrap(), 1.5, 0.4).unwrap()
}

/// Demands that the energy stays over so many impacts.
fn keeps_the_energy(model: &Model, u: &[f64], v: &[f64], impacts: u64) {
    let mut simulation = Simulation::new(model, 0.0, u, v).unwrap();
    let energy = simulation.energy().unwrap();
    let report = simulation.run(&Limits::impacts(impacts), |_| {});
    assert_eq!(report.outcome, Outcome::ImpactsReached);
    let drift = (simulation.energy().unwrap() / energy - 1.0).abs();
    println!("{}: {drift:e}", model.chain());
    assert!(drift <= 1e-11, "{}: {drift:e}", model.chain());
}

fn a_hot_ring_keeps_the_energy(impacts: u64) {
    for sites in [1, 2, 21, 64] {
        let model = conservative(sites);
        let (u, v) = Random(sites as u64).state(&model, 2.0);
        keeps_the_energy(&model, &u, &v, impacts);
    }
}

/// Ends and layers, too: rounding is lost at every impact of a mass beside them.
fn hot_lattices_keep_the_energy(impacts: u64) {
    let row = |sites, ends| Chain::new(sites, 0.2, 0.1).unwrap().with_ends(ends);
    for chain in [
        row(1, Ends::Fixed),
        row(2, Ends::Free),
        row(21, Ends::Free),
        row(21, Ends::Fixed),
        row(64, Ends::Free),
        row(1, Ends::Closed).with_layers(2, 0.07, Ends::Free).unwrap(),
        row(7, Ends::Free).with_layers(3, 0.07, Ends::Closed).unwrap(),
        row(7, Ends::Fixed).with_layers(2, 0.07, Ends::Free).unwrap(),
    ] {
        let model = Model::conservative(chain, 1.5, 0.4).unwrap();
        let (u, v) = Random(chain.sites() as u64).state(&model, 2.0);
        keeps_the_energy(&model, &u, &v, impacts);
    }
}

fn the_breather_keeps_its_energy(impacts: u64) {
    let model = conservative(21);
    let (u, v) = breather(&model);
    keeps_the_energy(&model, &u, &v, impacts);
}

#[test]
fn a_hundred_thousand_impacts_of_a_hot_ring_keep_the_energy() {
    a_hot_ring_keeps_the_energy(100_000);
}

#[test]
fn a_hundred_thousand_impacts_of_the_breather_keep_its_energy() {
    the_breather_keeps_its_energy(100_000);
}

/// A stable breather, which a perturbation of rounding does not carry away.
#[test]
fn a_hundred_thousand_periods_of_the_breather_keep_its_energy_to_twelve_digits() {
    let model = conservative(21);
    let (u, v) = breather(&model);
    let mut simulation = Simulation::new(&model, 0.0, &u, &v).unwrap();
    let energy = simulation.energy().unwrap();
    let mut worst = 0.0_f64;
    for part in 1..=10 {
        let report = simulation.run(&Limits::until(Time::new(&model, 10_000 * part, 0.0)), |_| {});
        assert_eq!(report.outcome, Outcome::TimeReached);
        // (The impact at the very end may be yet to come.)
        assert!(report.work.impacts.abs_diff(20_000 * part) <= 1, "{report:?}");
        worst = worst.max((simulation.energy().unwrap() / energy - 1.0).abs());
    }
    println!("{worst:e}");
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
#[ignore = "some seconds: cargo test --workspace --test invariants -- --ignored slow"]
fn slow_a_million_impacts_of_a_hot_ring_keep_the_energy() {
    a_hot_ring_keeps_the_energy(1_000_000);
}

#[test]
fn thirty_thousand_impacts_of_hot_lattices_keep_the_energy() {
    hot_lattices_keep_the_energy(30_000);
}

#[test]
#[ignore = "some seconds: cargo test --workspace --test invariants -- --ignored slow"]
fn slow_a_million_impacts_of_hot_lattices_keep_the_energy() {
    hot_lattices_keep_the_energy(1_000_000);
}

#[test]
#[ignore = "some seconds: cargo test --workspace --test invariants -- --ignored slow"]
fn slow_a_million_impacts_of_the_breather_keep_its_energy() {
    the_breather_keeps_its_energy(1_000_000);
}

#[test]
fn the_breather_of_the_paper_closes_after_one_period() {
    let model = conservative(21);
    let [p1, p2] = half_impulses(&model);
    assert!((p1 - 0.973_939_432_174_328_2).abs() < 1e-14 && (p2 - 0.640_169_940_982_344_7).abs() < 1e-14);
    let (u, v) = breather(&model);
    let mut simulation = Simulation::new(&model, 0.0, &u, &v).unwrap();
    let (_, lower) = simulation.collect(&Limits::until(Time::new(&model, 0, 0.75)));
    assert_eq!(lower.len(), 1);
    assert_eq!((lower[0].contact, lower[0].barrier), (0, Barrier::Lower));
    assert!((lower[0].time.to_f64() - 0.5 * model.period()).abs() < 1e-13);
    assert!((lower[0].velocity_before + p1).abs() < 1e-13);
    // To just before the second impact on the upper barrier, where the state is that at 0 with v₀ reversed.
    let (_, events) = simulation.collect(&Limits { impacts: 1, ..Limits::until(Time::new(&model, 1, 0.25)) });
    assert!((events[0].time.to_f64() - model.period()).abs() < 1e-13);
    assert!((events[0].velocity_before - p2).abs() < 1e-13);
    let state = simulation.state();
    let error = state.displacement.iter().zip(&u).chain(state.velocity.iter().zip(&v));
    let error = error.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    assert!(error <= 1e-12, "{error:e}");
}

#[test]
fn impact_times_of_the_breather_are_right_after_a_hundred_periods() {
    let model = conservative(21);
    let (u, v) = breather(&model);
    let mut simulation = Simulation::new(&model, 0.0, &u, &v).unwrap();
    let (_, events) = simulation.collect(&Limits::until(Time::new(&model, 100, 0.25)));
    assert_eq!(events.len(), 200);
    let error = |(i, event): (usize, &Event)| {
        let half = (i + 1) as u64;
        let expected = Time::new(&model, half / 2, 0.5 * (half % 2) as f64);
        let whole = event.time.periods() as f64 - expected.periods() as f64;
        (whole * model.period() + (event.time.offset() - expected.offset())).abs()
    };
    let worst = events.iter().enumerate().map(error).fold(0.0, f64::max);
    println!("{worst:e}");
    assert!(worst <= 1e-12, "{worst:e}");
}

/// Runs a mirror-symmetric state and compares every mass with its image, to the bit.
fn stays_symmetric(model: &Model, seed: u64, periods: u64) -> u64 {
    let sites = model.chain().sites();
    let (mut u, mut v) = Random(seed).state(model, 2.0);
    for n in 1..sites {
        (u[n], v[n]) = (u[n.min(sites - n)], v[n.min(sites - n)]);
    }
    let mut simulation = Simulation::new(model, 0.1, &u, &v).unwrap();
    let mut work = simulation.work();
    for i in 0..periods {
        work = simulation.run(&Limits::until(Time::new(model, i, 0.37)), |_| {}).work;
        let state = simulation.state();
        for n in 1..sites {
            assert_eq!(state.displacement[n].to_bits(), state.displacement[sites - n].to_bits(), "{sites} {n} at {i}");
            assert_eq!(state.velocity[n].to_bits(), state.velocity[sites - n].to_bits(), "{sites} {n} at {i}");
        }
    }
    assert!(work.impacts > periods, "no test: {work:?}");
    work.restarts
}

#[test]
fn a_mirror_symmetric_ring_stays_so_to_the_bit() {
    for (sites, amplitude, e) in [(2, 0.0, 1.0), (9, 0.0, 1.0), (12, 0.8, 0.6), (21, 0.0, 1.0)] {
        let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1);
        let model = ring.omega(0.9).asymmetry(0.3).amplitude(amplitude).restitution(e).model().unwrap();
        stays_symmetric(&model, 11, 200);
    }
    for (sites, amplitude, e) in [(80, 0.0, 1.0), (131, 0.5, 0.8)] {
        let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1);
        let model = ring.omega(0.9).asymmetry(0.3).amplitude(amplitude).restitution(e).model().unwrap();
        assert!(stays_symmetric(&model, 7, 40) > 100, "no restart in parts");
    }
}

/// Parts of a ring over its end are restarted as those elsewhere.
#[test]
fn a_ring_has_no_end() {
    for (amplitude, e) in [(0.0, 1.0), (0.8, 0.5)] {
        let ring = Point::ring(101).gamma1(0.2).gamma2(0.1);
        let model = ring.omega(0.9).asymmetry(0.3).amplitude(amplitude).restitution(e).model().unwrap();
        let (u, v) = Random(12).state(&model, 1.5);
        let run = |turn: usize| {
            let turned = |from: &[f64]| (0..101).map(|n| from[(n + turn) % 101]).collect::<Vec<_>>();
            let mut simulation = Simulation::new(&model, 0.0, &turned(&u), &turned(&v)).unwrap();
            let (report, mut events) = simulation.collect(&Limits::until(Time::new(&model, 8, 0.0)));
            assert!(report.work.restarts > 2 * report.work.windows, "not in parts: {:?}", report.work);
            events.iter_mut().for_each(|event| event.contact = (event.contact + turn) % 101);
            events.sort_by(|a, b| a.time.to_f64().total_cmp(&b.time.to_f64()).then(a.contact.cmp(&b.contact)));
            events
        };
        let straight = run(0);
        assert!(straight.len() > 500, "{} events are no test", straight.len());
        for turn in [1, 50, 97] {
            assert_eq!(run(turn), straight, "turned by {turn}");
        }
    }
}

#[test]
fn looking_changes_nothing() {
    for sites in [7, 90] {
        let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1);
        let model = ring.omega(0.9).asymmetry(0.3).amplitude(0.7).restitution(0.8).model().unwrap();
        let (u, v) = Random(8).state(&model, 2.0);
        let run = |pieces: u32| -> (Vec<Event>, Vec<f64>) {
            let mut simulation = Simulation::new(&model, 0.0, &u, &v).unwrap();
            let mut events = Vec::new();
            for i in 1..=pieces {
                let until = Time::new(&model, 0, 5.0 * f64::from(i) / f64::from(pieces));
                simulation.run(&Limits::until(until), |event| events.push(*event));
                simulation.state();
            }
            (events, simulation.state().displacement)
        };
        assert_eq!(run(1), run(997));
    }
}

#[test]
fn time_runs_backwards_without_loss() {
    // Reversing all velocities of a conservative ring retraces its way, impacts included.
    for sites in [8, 70] {
        let model = conservative(sites);
        let (u, v) = Random(21).state(&model, 1.0);
        let mut forward = Simulation::new(&model, 0.0, &u, &v).unwrap();
        let (_, there) = forward.collect(&Limits::until(Time::new(&model, 1, 0.3)));
        let turned = forward.state();
        let back: Vec<f64> = turned.velocity.iter().map(|v| -v).collect();
        let mut backward = Simulation::new(&model, 0.0, &turned.displacement, &back).unwrap();
        let (_, again) = backward.collect(&Limits::until(Time::new(&model, 1, 0.3)));
        assert_eq!(there.len(), again.len());
        for (a, b) in there.iter().zip(again.iter().rev()) {
            assert_eq!((a.contact, a.barrier), (b.contact, b.barrier));
            assert!((a.time.to_f64() + b.time.to_f64() - 1.3 * model.period()).abs() < 1e-9);
        }
        let state = backward.state();
        for (a, b) in u.iter().zip(&state.displacement) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
}
