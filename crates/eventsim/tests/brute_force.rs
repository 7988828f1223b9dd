//! Random hot chains against a scan of the exact modal flow: no impact missing, none invented.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

mod support;

use support::{Random, scan};
use vibrochain_eventsim::{EventKind, Limits, Simulation, Time};
use vibrochain_lattice::{Force, Harmonic, Model, Point};

/// Impacts compared.
fn compare(model: &Model, seed: u64, speed: f64, periods: f64, samples: u32) -> usize {
    let (u, v) = Random(seed).state(model, speed);
    let psi = 0.3 * model.period();
    let truth = scan(model, psi, &u, &v, periods, samples);
    let mut simulation = Simulation::new(model, psi, &u, &v).unwrap();
    let (_, events) = simulation.collect(&Limits::until(Time::new(model, 0, periods)));
    assert!(events.iter().all(|e| e.kind == EventKind::Impact), "seed {seed}: the scan knows no rest");
    for (event, impact) in events.iter().zip(&truth) {
        let time = event.time.to_f64();
        assert!(
            event.contact == impact.site && event.barrier == impact.barrier && (time - impact.time).abs() < 1e-8,
            "{model:?} seed {seed}: {event:?} for {impact:?}"
        );
        assert!((event.velocity_before - impact.before).abs() < 1e-6, "{event:?} for {impact:?}");
    }
    assert_eq!(events.len(), truth.len(), "{model:?} seed {seed}");
    events.len()
}

fn model(sites: usize, g1: f64, g2: f64, amplitude: f64, restitution: f64) -> Model {
    let ring = Point::ring(sites).gamma1(g1).gamma2(g2);
    ring.omega(1.5).asymmetry(0.4).amplitude(amplitude).restitution(restitution).model().unwrap()
}

#[test]
fn small_rings_at_a_hundred_thousand_samples_a_period() {
    let mut compared = 0;
    for (i, (sites, g1, g2, amplitude, e)) in [
        (1, 0.2, 0.1, 0.5, 0.9),
        (2, 0.2, 0.1, 0.0, 1.0),
        (2, 0.0, 0.6, 0.3, 0.95),
        (3, 0.3, 0.0, 0.2, 1.0),
        (5, 0.0, 0.4, 0.0, 1.0),
        (6, 1.2, 2.0, 0.0, 1.0),
        (9, 0.2, 0.1, 0.6, 0.9),
    ]
    .into_iter()
    .enumerate()
    {
        for seed in 1..=3 {
            compared += compare(&model(sites, g1, g2, amplitude, e), seed + 17 * i as u64, 2.5, 2.0, 100_000);
        }
    }
    assert!(compared > 300, "{compared} impacts are no test");
}

#[test]
fn forces_of_several_harmonics() {
    let mut compared = 0;
    for (i, (sites, terms, e)) in [
        (1, vec![(1, 0.5, 0.0), (3, -0.17, 0.0), (5, 0.1, 0.0)], 0.9),
        (5, vec![(1, 0.4, 1.0), (7, 0.9, -0.5)], 1.0),
        (8, vec![(3, -2.0, 0.3)], 0.95),
    ]
    .into_iter()
    .enumerate()
    {
        let harmonic = |(number, amplitude, phase)| Harmonic { number, amplitude, phase };
        let force = Force::new(&terms.into_iter().map(harmonic).collect::<Vec<_>>()).unwrap();
        let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1);
        let model = ring.omega(1.5).asymmetry(0.4).under(&force).restitution(e).model().unwrap();
        for seed in 1..=3 {
            compared += compare(&model, seed + 29 * i as u64, 2.5, 2.0, 100_000);
        }
    }
    assert!(compared > 60, "{compared} impacts are no test");
}

#[test]
fn a_ring_of_seven_at_a_million_samples_a_period() {
    assert!(compare(&model(7, 0.2, 0.1, 0.0, 1.0), 5, 2.0, 1.0, 1_000_000) > 5);
}

#[test]
fn rings_large_enough_for_restarts_in_parts() {
    let mut compared = 0;
    for (sites, g2, amplitude, e) in [(48, 0.1, 0.0, 1.0), (61, 0.4, 0.2, 0.9), (96, 0.02, 0.3, 1.0)] {
        let model = model(sites, 0.2, g2, amplitude, e);
        compared += compare(&model, sites as u64, 1.8, 1.2, 100_000);
        let (u, v) = Random(3).state(&model, 1.8);
        let mut simulation = Simulation::new(&model, 0.0, &u, &v).unwrap();
        let work = simulation.run(&Limits::until(Time::new(&model, 2, 0.0)), |_| {}).work;
        assert!(work.restarts > work.windows, "not in parts: {work:?}");
    }
    assert!(compared > 200, "{compared} impacts are no test");
}
