//! Masses that start exactly on a barrier, at rest: they leave, or rest there, as what pulls or presses them says; the first
//! derivative that does not vanish decides, however high.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_eventsim::{Event, EventKind, Limits, Outcome, Simulation, Time};
use vibrochain_lattice::{Barrier, Chain, Model, Point, Propagator, Spectrum};

fn run(model: &Model, psi: f64, u: &[f64], v: &[f64], periods: f64) -> (Simulation, Vec<Event>) {
    let mut simulation = Simulation::new(model, psi, u, v).unwrap();
    let (report, events) = simulation.collect(&Limits::until(Time::new(model, 0, periods)));
    // Some hundred impacts at most, of a few steps each: one such start took three thousand million.
    assert!(report.work.refinements < 50_000, "{:?}", report.work);
    assert_eq!(report.outcome, Outcome::TimeReached, "{u:?} {v:?} {events:?}");
    (simulation, events)
}

/// One mass on either barrier, with or without loss: where the spring's and the force's pull together point, by hand.
#[test]
fn the_force_on_it_decides() {
    let mut seen = [0; 3];
    for e in [0.3, 1.0] {
        for barrier in [Barrier::Lower, Barrier::Upper] {
            for (amplitude, phase) in [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.05, 0.0), (0.05, 0.5), (0.5, 0.25)] {
                let ring = Point::ring(1).gamma1(0.2).gamma2(0.0);
                let model = ring.omega(1.0).asymmetry(0.2).amplitude(amplitude).restitution(e).model().unwrap();
                let (u, psi) = (model.barrier(barrier), phase * model.period());
                let outward = barrier.sign() * (amplitude * psi.cos() - 0.2 * u);
                let (simulation, events) = run(&model, psi, &[u], &[0.0], 1e-3);
                if outward > 0.0 {
                    assert_eq!(events.len(), 1);
                    let event = events[0];
                    assert_eq!((event.kind, event.barrier, event.time.to_f64()), (EventKind::Stick, barrier, 0.0));
                    assert_eq!(
                        (simulation.state().displacement[0], simulation.contact(0).unwrap().resting),
                        (u, Some(barrier))
                    );
                    seen[0] += 1;
                } else {
                    // It leaves without an event, and is as far away as its acceleration takes it.
                    assert!(events.is_empty(), "{events:?}");
                    let t = simulation.time().to_f64();
                    let left = barrier.sign() * (u - simulation.state().displacement[0]);
                    assert!((left / (-0.5 * outward * t * t) - 1.0).abs() < 0.05, "{left} {outward}");
                    seen[1] += 1;
                }
            }
        }
    }
    // Spring and force in balance: the next derivative, −Aω sin ωψ, decides.
    let model = Point::ring(1).gamma1(0.2).gamma2(0.0).omega(1.0).amplitude(0.5).restitution(0.9).model().unwrap();
    for (psi, pressed) in [(0.4_f64.acos(), false), (-(0.4_f64.acos()), true)] {
        let (simulation, events) = run(&model, psi, &[1.0], &[0.0], 1e-3);
        assert_eq!(simulation.contact(0).unwrap().resting.is_some(), pressed, "{psi} {events:?}");
        seen[2] += 1;
    }
    assert_eq!(seen, [4, 20, 2]);
}

/// Nothing holds a ring whose masses all lie on one barrier, and nothing moves it.
#[test]
fn in_balance_for_ever_it_rests_for_ever() {
    let model = Point::ring(7).gamma1(0.0).gamma2(0.1).omega(1.0).asymmetry(0.3).restitution(0.8).model().unwrap();
    let u = [model.barrier(Barrier::Lower); 7];
    let (simulation, events) = run(&model, 0.0, &u, &[0.0; 7], 20.0);
    assert!(events.len() == 7 && events.iter().all(|e| e.kind == EventKind::Stick && e.time.to_f64() == 0.0));
    assert_eq!(simulation.state().displacement, u);
}

/// The same ring with one mass on its way inward: it pulls the others after it, the m-th neighbour with the derivative of
/// order 2m + 1. As long as none comes back the ring moves as if there were no barriers.
#[test]
fn a_far_neighbour_that_leaves_takes_it_along() {
    let mut compared = 0;
    for sites in [1, 2, 3, 5, 8, 9, 13, 20, 41, 90] {
        for barrier in [Barrier::Lower, Barrier::Upper] {
            let ring = Point::ring(sites).gamma1(0.0).gamma2(0.1);
            let model = ring.omega(1.0).asymmetry(0.3).restitution(0.8).model().unwrap();
            let (u, mut v) = (vec![model.barrier(barrier); sites], vec![0.0; sites]);
            v[sites / 2] = -0.1 * barrier.sign();
            for periods in [0.05, 0.4] {
                let (simulation, events) = run(&model, 0.0, &u, &v, periods);
                assert!(events.iter().all(|e| e.kind != EventKind::Impact), "{sites}: {events:?}");
                compared += assert_flies_freely(model.chain(), &simulation, &u, &v);
            }
        }
    }
    assert!(compared > 300, "{compared}");
}

/// Compares a run that has met no barrier since it left this state with the free flow; the number of masses compared.
fn assert_flies_freely(chain: &Chain, simulation: &Simulation, u: &[f64], v: &[f64]) -> usize {
    let sites = u.len();
    let flow = Propagator::new(&Spectrum::new(*chain), simulation.time().to_f64());
    let (mut u_free, mut v_free) = (vec![0.0; sites], vec![0.0; sites]);
    flow.apply(u, v, &mut u_free, &mut v_free);
    let state = simulation.state();
    for n in 0..sites {
        let errors = [state.displacement[n] - u_free[n], state.velocity[n] - v_free[n]];
        assert!(errors.iter().all(|error| error.abs() < 1e-14), "{sites} {n} {errors:?}");
    }
    sites
}

/// An impact at t = 0 restarts a part of a large ring before any time has passed; the masses at its ends go on moving.
#[test]
fn an_impact_at_the_very_start_leaves_the_rest_of_a_moving_ring_alone() {
    let mut compared = 0;
    for (sites, hit) in [(1, 0), (5, 2), (63, 0), (64, 63), (90, 40), (200, 0), (200, 100)] {
        let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1);
        let model = ring.omega(1.0).asymmetry(0.3).restitution(0.8).model().unwrap();
        let wave = |n: usize, shift: f64| 0.2 * (0.7 * n as f64 + shift).sin();
        let mut u: Vec<f64> = (0..sites).map(|n| wave(n, 0.0)).collect();
        let mut v: Vec<f64> = (0..sites).map(|n| wave(n, 1.3)).collect();
        (u[hit], v[hit]) = (model.barrier(Barrier::Upper), 0.5);
        let (simulation, events) = run(&model, 0.0, &u, &v, 0.1);
        assert!(events.len() == 1 && events[0].time.to_f64() == 0.0 && events[0].contact == hit, "{events:?}");
        v[hit] = -0.8 * 0.5;
        compared += assert_flies_freely(model.chain(), &simulation, &u, &v);
    }
    assert!(compared > 600, "{compared}");
}
