//! Edges: tangency, several events at one instant, cascades that end and that do not, extremes of scale, bad input.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

mod support;

use proptest::prelude::*;
use support::Random;
use vibrochain_eventsim::{Event, EventKind, Limits, Outcome, Simulation, StateError, Time};
use vibrochain_lattice::{Barrier, Model, Point};

fn forced(sites: usize, g1: f64, g2: f64, omega: f64, a: f64, amplitude: f64, e: f64) -> Model {
    let ring = Point::ring(sites).gamma1(g1).gamma2(g2);
    ring.omega(omega).asymmetry(a).amplitude(amplitude).restitution(e).model().unwrap()
}

fn until(model: &Model, periods: f64) -> Limits {
    Limits::until(Time::new(model, 0, periods))
}

fn kinds(events: &[Event]) -> Vec<EventKind> {
    events.iter().map(|e| e.kind).collect()
}

#[test]
fn a_graze_makes_at_most_one_event_a_pass_and_moves_nothing() {
    // u = 1.4 sin: tangent to the upper barrier to rounding, once a period of 2π, forever.
    let model = forced(1, 1.0, 0.0, 1.0, 0.4, 0.0, 0.5);
    for ulps in -4..=4 {
        let start = [0.0];
        let speed = [1.4 * (1.0 + f64::from(ulps) * f64::EPSILON)];
        let mut simulation = Simulation::new(&model, 0.0, &start, &speed).unwrap();
        let (_, events) = simulation.collect(&until(&model, 0.45));
        let upper = events.iter().filter(|e| e.barrier == Barrier::Upper).count();
        assert!(upper <= 1, "{ulps}: {events:?}");
        for event in events {
            // √(2·1.4·Δ) for Δ of a few units in the last place.
            assert!(event.velocity_before.abs() < 1e-7, "{event:?}");
            assert!((event.time.to_f64() - std::f64::consts::FRAC_PI_2).abs() < 1e-7);
        }
    }
    // Started at rest on the barrier it leaves without an event.
    let mut simulation = Simulation::new(&model, 0.0, &[1.4], &[0.0]).unwrap();
    assert_eq!(simulation.collect(&until(&model, 0.3)).1, []);
    assert!(simulation.state().displacement[0] < 1.4);
}

#[test]
fn three_masses_hit_at_once_and_others_do_not() {
    let model = forced(12, 0.2, 0.1, 1.0, 0.4, 0.0, 0.8);
    let (mut u, mut v) = ([0.0; 12], [0.0; 12]);
    for n in [1, 5, 9] {
        (u[n], v[n]) = (1.0, 1.0);
    }
    let (_, events) = Simulation::new(&model, 0.0, &u, &v).unwrap().collect(&until(&model, 0.2));
    assert_eq!(events.iter().map(|e| e.contact).collect::<Vec<_>>(), [1, 5, 9]);
    assert!(events.iter().all(|e| e.time == events[0].time && e.velocity_before == events[0].velocity_before));
    // The same on a ring large enough to restart in parts, far apart and side by side.
    let model = forced(240, 0.2, 0.1, 1.0, 0.4, 0.0, 0.8);
    for places in [[10, 11, 12], [0, 80, 160], [239, 0, 1]] {
        let (mut u, mut v) = (vec![0.0; 240], vec![0.0; 240]);
        for n in places {
            (u[n], v[n]) = (1.4, 1.0);
        }
        let (_, events) = Simulation::new(&model, 0.0, &u, &v).unwrap().collect(&until(&model, 0.01));
        let mut sorted = places;
        sorted.sort_unstable();
        assert_eq!(events.iter().map(|e| e.contact).collect::<Vec<_>>(), sorted);
        assert!(events.iter().all(|e| e.time.to_f64() == 0.0 && e.velocity_after == -0.8));
    }
}

#[test]
fn a_mass_pressed_from_the_start_rests_and_is_let_go() {
    // One mass, force 0.3 cos t at its upper barrier 1, spring 0.1: pressed while 0.3 cos t > 0.1.
    let model = forced(1, 0.1, 0.0, 1.0, 0.0, 0.3, 0.6);
    let mut simulation = Simulation::new(&model, 0.0, &[1.0], &[0.0]).unwrap();
    let (_, events) = simulation.collect(&until(&model, 0.1));
    assert_eq!(kinds(&events), [EventKind::Stick]);
    assert_eq!((events[0].time.to_f64(), simulation.contact(0).unwrap().resting), (0.0, Some(Barrier::Upper)));
    let (_, events) = simulation.collect(&until(&model, 0.25));
    assert_eq!(kinds(&events), [EventKind::Release]);
    assert!((events[0].time.to_f64() - (1.0 / 3.0_f64).acos()).abs() < 1e-14);
    assert_eq!(simulation.contact(0).unwrap().resting, None);
    // Away from the barrier like −s³/6 of the force's slope.
    let (start, now) = (events[0].time.to_f64(), simulation.time().to_f64());
    let s = now - start;
    let slope = 0.3 * start.sin();
    let state = simulation.state();
    assert!((1.0 - state.displacement[0] - slope * s.powi(3) / 6.0).abs() < 0.1 * s.powi(4));
}

#[test]
fn phases_are_shifts_of_time() {
    let model = forced(3, 0.2, 0.1, 0.7, 0.2, 0.5, 0.7);
    let (u, v) = Random(5).state(&model, 1.0);
    let mut simulation = Simulation::new(&model, 1.1, &u, &v).unwrap();
    let (_, all) = simulation.collect(&until(&model, 3.0));
    let mut first = Simulation::new(&model, 1.1, &u, &v).unwrap();
    first.run(&until(&model, 0.77), |_| {});
    let (state, t) = (first.state(), first.time().to_f64());
    let mut second =
        Simulation::new(&model, 1.1 + t + 4.0 * model.period(), &state.displacement, &state.velocity).unwrap();
    let (_, rest) = second.collect(&until(&model, 2.23));
    let late: Vec<_> = all.iter().filter(|e| e.time.to_f64() > t).collect();
    assert!(late.len() == rest.len() && !rest.is_empty());
    for (a, b) in late.iter().zip(&rest) {
        assert!(a.contact == b.contact && (a.time.to_f64() - t - b.time.to_f64()).abs() < 1e-10);
    }
}

#[test]
fn a_neighbour_hits_at_the_instant_of_a_release() {
    // Mass 0 rests on its upper barrier until the force lets go; mass 1 is placed so that it hits its own at about
    // that instant, before, at and after it.
    let model = forced(2, 0.1, 0.05, 1.0, 0.0, 0.4, 0.9);
    // With mass 1 hitting at 1 when mass 0 lets go at 1: 0.4 cos t = 0.1.
    let release = (0.25_f64).acos();
    for shift in [-1e-9, -1e-15, 0.0, 1e-15, 1e-9] {
        // Mass 1 backwards from (1, v) at the release, mass 0 held: x'' = −0.2 x + 0.1 + 0.4 cos t, solved by steps.
        let (mut x, mut v, steps) = (1.0_f64, 0.8_f64, 20_000_u32);
        let h = (release + shift) / f64::from(steps);
        let acceleration = |t: f64, x: f64| -0.2 * x + 0.1 + 0.4 * t.cos();
        for i in 0..steps {
            let t = release + shift - h * f64::from(i);
            let a = acceleration(t, x);
            let middle = acceleration(t - 0.5 * h, x - 0.5 * h * v);
            let end = acceleration(t - h, x - h * v + 0.5 * h * h * middle);
            (x, v) = (x - h * v + h * h / 6.0 * (a + 2.0 * middle), v - h / 6.0 * (a + 4.0 * middle + end));
        }
        let mut simulation = Simulation::new(&model, 0.0, &[1.0, x], &[0.0, v]).unwrap();
        let (report, events) = simulation.collect(&until(&model, 0.25));
        assert_eq!(report.outcome, Outcome::TimeReached);
        let releases = events.iter().filter(|e| e.kind == EventKind::Release).count();
        let impacts = events.iter().filter(|e| e.kind == EventKind::Impact && e.contact == 1).count();
        assert_eq!((releases, impacts), (1, 1), "{shift:e}: {events:#?}");
        let at = events.iter().find(|e| e.kind == EventKind::Release).unwrap().time.to_f64();
        assert!((at - release).abs() < 1e-8, "{shift:e}: {at}");
    }
}

#[test]
fn elastic_and_pressed_is_an_outcome() {
    let model = forced(4, 0.2, 0.1, 0.4, 0.4, 1.5, 1.0);
    let mut u = [0.0; 4];
    let mut v = [0.0; 4];
    (u[2], v[2]) = (1.4, -1e-9);
    let mut simulation = Simulation::new(&model, 0.0, &u, &v).unwrap();
    let limits = Limits { bounces: 1000, ..until(&model, 1.0) };
    let report = simulation.run(&limits, |_| {});
    assert_eq!(report.outcome, Outcome::Cascade { contact: 2, barrier: Barrier::Upper, bounces: 1000 });
    assert_eq!(report.work.impacts, 1000);
    // Without a speed to bounce with it rests, elastic or not.
    v[2] = 0.0;
    let mut simulation = Simulation::new(&model, 0.0, &u, &v).unwrap();
    let (report, events) = simulation.collect(&until(&model, 0.01));
    assert_eq!((report.outcome, kinds(&events)), (Outcome::TimeReached, vec![EventKind::Stick]));
}

#[test]
fn a_cascade_with_little_loss_ends_at_its_limit() {
    for e in [0.1, 0.5, 0.9, 0.99] {
        let model = forced(1, 1e-3, 0.0, 1e-3, 0.0, 1.0, e);
        // A nearly constant force 1: flights of 2v/α with α = 1 − 1e-3 and a little less as the force turns.
        let mut simulation = Simulation::new(&model, 0.0, &[1.0], &[-1e-3]).unwrap();
        let (_, events) = simulation.collect(&until(&model, 1e-3));
        let last = events.last().unwrap();
        assert_eq!(last.kind, EventKind::Stick, "{e}");
        let expected = 2e-3 / (1.0 - 1e-3) / (1.0 - e);
        assert!((last.time.to_f64() / expected - 1.0).abs() < 1e-3, "{e}: {}", last.time.to_f64());
        let impacts: Vec<_> = events.iter().filter(|e| e.kind == EventKind::Impact).collect();
        for pair in impacts.windows(2) {
            assert!((pair[1].velocity_before / -pair[0].velocity_after - 1.0).abs() < 1e-5);
        }
    }
}

#[test]
fn limits_end_runs_and_runs_continue() {
    let model = forced(5, 0.2, 0.1, 1.0, 0.4, 0.0, 1.0);
    let (u, v) = Random(2).state(&model, 2.0);
    let mut whole = Simulation::new(&model, 0.0, &u, &v).unwrap();
    let (_, all) = whole.collect(&Limits::impacts(20));
    assert_eq!(all.len(), 20);
    let mut parts = Simulation::new(&model, 0.0, &u, &v).unwrap();
    let mut collected = Vec::new();
    while collected.len() < 20 {
        let (report, events) = parts.collect(&Limits::impacts(3));
        assert_eq!(report.outcome, Outcome::ImpactsReached);
        collected.extend(events);
    }
    assert_eq!(all[..], collected[..20]);
    let report = parts.run(&Limits { flights: 5, ..Limits::default() }, |_| {});
    assert_eq!(report.outcome, Outcome::WorkLimit);
    let before = parts.time();
    let report = parts.run(&Limits::until(Time::new(&model, 0, 0.0)), |_| {});
    assert_eq!((report.outcome, report.time), (Outcome::TimeReached, before));
}

#[test]
fn uniform_motion_without_springs_is_straight() {
    // γ₁ = 0 on one mass: a billiard.
    let model = forced(1, 0.0, 1.0, 1.0, 0.4, 0.0, 1.0);
    let (_, events) = Simulation::new(&model, 0.0, &[0.4], &[0.5]).unwrap().collect(&until(&model, 5.0));
    for (i, event) in events.iter().enumerate() {
        assert!((event.time.to_f64() - (2.0 + 4.0 * i as f64)).abs() < 1e-13, "{event:?}");
        assert_eq!(event.velocity_before.abs(), 0.5);
    }
    assert_eq!(events.len(), 8);
}

#[test]
fn bad_states_are_refused_with_the_reason() {
    let model = forced(3, 0.2, 0.1, 1.0, 0.4, 0.0, 1.0);
    let new = |u: &[f64], v: &[f64], psi: f64| Simulation::new(&model, psi, u, v).map(|_| ());
    assert!(matches!(new(&[0.0; 2], &[0.0; 3], 0.0), Err(StateError::Length { name: "displacement", found: 2, .. })));
    assert!(matches!(new(&[0.0; 3], &[0.0; 4], 0.0), Err(StateError::Length { name: "velocity", .. })));
    assert!(
        matches!(new(&[0.0, f64::NAN, 0.0], &[0.0; 3], 0.0), Err(StateError::Range { what, .. }) if what == "displacement of site 1")
    );
    assert!(matches!(new(&[0.0; 3], &[0.0; 3], f64::INFINITY), Err(StateError::Range { what, .. }) if what == "psi"));
    assert!(matches!(new(&[0.0; 3], &[0.0, 0.0, 1e300], 0.0), Err(StateError::TooFast { name: "velocity", .. })));
    let outside = new(&[0.0, 0.0, -0.7], &[0.0; 3], 0.0).unwrap_err();
    assert!(matches!(outside, StateError::OutsideGap { contact: 2, barrier: Barrier::Lower, .. }));
    assert!(outside.to_string().contains("lower barrier"), "{outside}");
    assert_eq!(new(&[1.4 + 2e-16, -0.6, 0.0], &[0.0; 3], -1e9), Ok(()));
    let model = forced(1, 0.0, 1e-300, 1e-100, 0.0, 1e100, 1.0);
    let error = Simulation::new(&model, 0.0, &[0.0], &[0.0]).map(|_| ()).unwrap_err();
    assert!(matches!(error, StateError::TooFast { name: "amplitude", .. }));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the parameters: an outcome, finite numbers, masses within their gap, events in order.
    #[test]
    fn any_model_runs_to_an_outcome(
        sites in prop_oneof![1_usize..8, 40_usize..90],
        (g1, g2) in (prop_oneof![Just(0.0), -9.0..9.0_f64], -9.0..9.0_f64),
        (omega, amplitude) in (-6.0..6.0_f64, prop_oneof![Just(None), (-4.0..3.0_f64).prop_map(Some)]),
        (asymmetry, e) in (0.0..0.99_f64, prop_oneof![Just(1.0), 0.01..1.0_f64]),
        (seed, speed, on_barrier) in (1_u64..1000, -12.0..2.0_f64, any::<bool>()),
    ) {
        let g1 = if g1 == 0.0 { 0.0 } else { 10f64.powf(g1) };
        let g2 = 10f64.powf(g2);
        // The coupling of a single mass cancels.
        let scale = (if sites == 1 { g1 } else { g1 + 4.0 * g2 }).sqrt().max(10f64.powf(omega));
        let amplitude = amplitude.map_or(0.0, |a| 10f64.powf(a) * scale * scale);
        let model = forced(sites, g1, g2, 10f64.powf(omega), asymmetry, amplitude, e);
        let (mut u, v) = Random(seed).state(&model, 10f64.powf(speed) * scale);
        if on_barrier {
            u[0] = model.barrier(Barrier::Lower);
        }
        let mut simulation = Simulation::new(&model, 0.1 * model.period(), &u, &v).unwrap();
        let limits = Limits { impacts: 300, flights: 3000, ..until(&model, 1.7) };
        let (_, events) = simulation.collect(&limits);
        let state = simulation.state();
        prop_assert!(state.displacement.iter().all(|u| (u - asymmetry).abs() <= 1.0 + 1e-15));
        prop_assert!(state.velocity.iter().all(|v| v.is_finite()));
        let times: Vec<f64> = events.iter().map(|e| e.time.to_f64()).collect();
        prop_assert!(times.windows(2).all(|t| t[0] <= t[1]), "{times:?}");
        for event in &events {
            let outward = event.barrier.sign() * event.velocity_before;
            prop_assert!(outward >= 0.0 && event.velocity_after == 0.0 - e * event.velocity_before, "{event:?}");
        }
    }
}
