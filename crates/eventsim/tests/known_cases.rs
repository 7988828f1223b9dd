//! Cases with known answers, to 1e-12: tangencies, simultaneous impacts, starts on a barrier, chatter, rest, release.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use approx::assert_abs_diff_eq;
use vibrochain_eventsim::{Event, EventKind, Limits, Outcome, Simulation, Time};
use vibrochain_lattice::{Barrier, Model, Point};

fn model(sites: usize, omega: f64, amplitude: f64, restitution: f64) -> Model {
    let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1);
    ring.omega(omega).asymmetry(0.4).amplitude(amplitude).restitution(restitution).model().unwrap()
}

fn events(model: &Model, u: &[f64], v: &[f64], periods: f64) -> Vec<Event> {
    let mut simulation = Simulation::new(model, 0.0, u, v).unwrap();
    let (report, events) = simulation.collect(&Limits::until(Time::new(model, 0, periods)));
    assert_eq!(report.outcome, Outcome::TimeReached);
    assert!(events.windows(2).all(|e| e[0].time.to_f64() <= e[1].time.to_f64()), "out of order: {events:?}");
    events
}

/// `v` such that a uniform motion from u = 0 peaks `excess` beyond the upper barrier.
fn speed_for_peak(excess: f64) -> f64 {
    0.2_f64.sqrt() * (1.4 + excess)
}

#[test]
fn a_peak_a_millionth_over_the_barrier_is_an_impact_of_all_masses_at_once() {
    let model = model(21, 1.5, 0.0, 1.0);
    assert_abs_diff_eq!(speed_for_peak(1e-6), 0.626_099_480_913_536_5, epsilon = 1e-15);
    let found = events(&model, &[0.0; 21], &[0.626_099_480_913_536_5; 21], 1.0);
    assert_eq!(found.len(), 21);
    for (site, event) in found.iter().enumerate() {
        assert_eq!((event.contact, event.barrier, event.kind), (site, Barrier::Upper, EventKind::Impact));
        // The barrier is met at 4.8e-4 radians from the peak: rounding of u grows by 1e3.
        assert_abs_diff_eq!(event.time.to_f64(), 3.509_734_753_896_905, epsilon = 1e-12);
        assert_abs_diff_eq!(event.velocity_before, 7.483_316_109e-4, epsilon = 1e-12);
        assert_eq!(event.velocity_after, -event.velocity_before);
    }
}

#[test]
fn a_peak_just_below_the_barrier_is_none() {
    let model = model(21, 1.5, 0.0, 1.0);
    for excess in [-1e-13, -1e-10, -1e-6] {
        assert_eq!(events(&model, &[0.0; 21], &[speed_for_peak(excess); 21], 1.0), []);
    }
    let found = events(&model, &[0.0; 21], &[speed_for_peak(1e-13); 21], 1.0);
    assert_eq!(found.len(), 21);
}

#[test]
fn impacts_a_picosecond_apart_are_told_apart() {
    let model = model(21, 1.5, 0.0, 1.0);
    let (mut u, mut v) = ([0.1; 21], [0.0; 21]);
    (u[3], v[3]) = (0.5, 0.9);
    (u[11], v[11]) = (0.5 - 0.9e-12, 0.9);
    let found = events(&model, &u, &v, 0.5);
    assert_eq!((found[0].contact, found[1].contact), (3, 11));
    let (first, second) = (found[0].time.to_f64(), found[1].time.to_f64());
    assert_abs_diff_eq!(first, 1.300_487_074_325_697_7, epsilon = 1e-12);
    assert_abs_diff_eq!(second - first, 1.509_35e-12, epsilon = 1e-14);
}

#[test]
fn a_start_on_a_barrier_hits_only_if_it_moves_outward() {
    let model = model(21, 1.5, 0.0, 1.0);
    let (mut u, mut v) = ([0.0; 21], [0.0; 21]);
    (u[0], v[0]) = (1.4, 0.5);
    let found = events(&model, &u, &v, 1e-3);
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].contact, found[0].time.to_f64()), (0, 0.0));
    assert_eq!((found[0].velocity_before, found[0].velocity_after), (0.5, -0.5));
    v[0] = -0.5;
    assert_eq!(events(&model, &u, &v, 0.3), []);
    // From rest the springs pull it off, without an event.
    v[0] = 0.0;
    assert_eq!(events(&model, &u, &v, 0.3), []);
}

#[test]
fn impacts_accumulate_at_4e_minus_13() {
    let model = model(21, 0.4, 1.5, 0.5);
    let (mut u, mut v) = ([0.0; 21], [0.0; 21]);
    (u[0], v[0]) = (1.4, -1e-13);
    let found = events(&model, &u, &v, 1e-6);
    assert_eq!((found[0].kind, found[0].contact), (EventKind::Impact, 0));
    let first = found[0].time.to_f64();
    // Inward for 2v/α, α = 1.5 − (0.2 + 2·0.1)·1.4.
    assert_abs_diff_eq!(first / (2e-13 / 0.94), 1.0, epsilon = 1e-12);
    assert_abs_diff_eq!(first / 2.127_659_574_47e-13, 1.0, epsilon = 1e-11);
    let last = found.last().unwrap();
    assert_eq!((last.kind, last.barrier), (EventKind::Stick, Barrier::Upper));
    assert_abs_diff_eq!(last.time.to_f64() / (4e-13 / 0.94), 1.0, epsilon = 1e-12);
    assert_eq!(found.iter().filter(|e| e.kind == EventKind::Stick).count(), 1);
}

#[test]
fn a_forced_ring_of_five_sticks_and_lets_go() {
    let model = model(5, 0.4, 1.5, 0.3);
    let mut v = [0.0; 5];
    v[0] = 0.5;
    let found = events(&model, &[0.0; 5], &v, 0.75);
    let mut expected = vec![
        (EventKind::Stick, Barrier::Upper, 0, 3.357_911_538_886_231),
        (EventKind::Release, Barrier::Upper, 0, 3.449_886_578_017_085),
    ];
    let lower = [(0, 7.640_455_324_088_717), (2, 7.663_285_158_433_526), (3, 7.663_285_158_433_526)];
    let lower_late = [(1, 7.664_596_047_419_962), (4, 7.664_596_047_419_962)];
    for (site, time) in lower.into_iter().chain(lower_late) {
        expected.push((EventKind::Stick, Barrier::Lower, site, time));
    }
    let release = (std::f64::consts::TAU - (-0.08_f64).acos()) / 0.4;
    assert_abs_diff_eq!(release, 11.580_758_500_877_576, epsilon = 1e-13);
    expected.extend((0..5).map(|site| (EventKind::Release, Barrier::Lower, site, release)));
    let rests: Vec<_> = found.iter().filter(|e| e.kind != EventKind::Impact).collect();
    assert_eq!(rests.len(), expected.len(), "{rests:#?}");
    for (event, (kind, barrier, site, time)) in rests.iter().zip(expected) {
        assert_eq!((event.kind, event.barrier, event.contact), (kind, barrier, site));
        assert_abs_diff_eq!(event.time.to_f64(), time, epsilon = 1e-12);
        assert_eq!((event.velocity_before, event.velocity_after), (0.0, 0.0));
    }
    let first = |site: usize| found.iter().find(|e| e.contact == site).unwrap().time.to_f64();
    assert_abs_diff_eq!(first(0), 1.109_504_256_745_789, epsilon = 1e-12);
    for (site, time) in [(1, 1.397_255_256_585_395), (2, 1.407_888_459_145_674)] {
        assert_abs_diff_eq!(first(site), time, epsilon = 1e-12);
        assert_eq!(first(site), first(5 - site));
    }
    // Every cascade: each impact has e times the speed it came with.
    for event in found.iter().filter(|e| e.kind == EventKind::Impact) {
        assert_eq!(event.velocity_after, 0.0 - 0.3 * event.velocity_before);
    }
}
