//! Cost of the event-driven simulation per period, against the size of the ring, with one impacting mass and with many;
//! and its error against run time beside an adaptive Runge–Kutta method with root finding on the same orbit.
#![allow(missing_docs, reason = "criterion's macros define undocumented items")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a benchmark stops at the first surprise")]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use vibrochain::breather::{Family, Motion, Orbit, breathers};
use vibrochain::eventsim::{Limits, Simulation, Time};
use vibrochain::lattice::{Chain, Model};
use vibrochain_cli::accuracy::steppers::{End, dop853};

fn model(sites: usize) -> Model {
    Model::conservative(Chain::new(sites, 0.2, 0.1).unwrap(), 1.5, 0.4).unwrap()
}

/// The double-sided breather half-way to its first impact, with a perturbation of 1e-6 that is even about it.
fn on_breather(sites: usize, perturbation: f64) -> (Orbit, f64, Vec<f64>, Vec<f64>) {
    let orbit = breathers(&model(sites), Family::DoubleSided).unwrap().orbits[0].clone();
    let start = -0.25 * orbit.period();
    let mut motion = Motion::of(&orbit).unwrap();
    motion.at(0, start);
    let u = (0..sites).map(|n| motion.site(n).displacement + perturbation * (n.min(sites - n) as f64).cos());
    (orbit.clone(), start, u.collect(), (0..sites).map(|n| motion.site(n).velocity).collect())
}

/// A hot ring: every mass moves and hits, 26 impacts a period on 21 masses.
fn hot(sites: usize) -> (Vec<f64>, Vec<f64>) {
    let wave = |n: usize, k: f64| (n as f64 * k).sin();
    ((0..sites).map(|n| 0.4 + 0.5 * wave(n, 1.3)).collect(), (0..sites).map(|n| 1.2 * wave(n, 2.1)).collect())
}

fn cost_per_period(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("simulation/period");
    group.sample_size(10);
    for sites in [21, 100, 1000, 10_000] {
        let model = model(sites);
        let (_, _, u, v) = on_breather(sites, 1e-6);
        for (name, (u, v)) in [("breather", (u, v)), ("hot", hot(sites))] {
            let mut simulation = Simulation::new(&model, 0.0, &u, &v).unwrap();
            let mut periods = 0;
            group.bench_function(BenchmarkId::new(name, sites), |bencher| {
                bencher.iter(|| {
                    periods += 1;
                    simulation.run(&Limits::until(Time::new(&model, periods, 0.0)), |_| {})
                });
            });
        }
    }
    group.finish();
}

/// 100 periods of the N = 20 breather: time by criterion, error of the last impact printed once.
fn work_precision(criterion: &mut Criterion) {
    let (sites, periods) = (21, 100);
    let (orbit, start, u, v) = on_breather(sites, 0.0);
    let expected = (periods as f64 - 0.5) * orbit.period() - start;
    let start_state: Vec<f64> = u.iter().chain(&v).copied().collect();
    let mut group = criterion.benchmark_group("simulation/100-periods");
    group.sample_size(10);
    let ours = || {
        let model = model(sites);
        let mut simulation = Simulation::new(&model, 0.0, &u, &v).unwrap();
        let mut last = 0.0;
        simulation.run(&Limits::impacts(2 * periods), |event| last = event.time.to_f64());
        last
    };
    println!("events: error of the last impact {:.1e}", (ours() - expected).abs());
    group.bench_function("events", |bencher| bencher.iter(ours));
    for tolerance in [1e-6, 1e-8, 1e-10, 1e-12] {
        let theirs = || dop853(&model(sites), &start_state, End::Impacts(2 * periods), tolerance).unwrap().last_impact;
        println!("DOP853 at {tolerance:e}: error of the last impact {:.1e}", (theirs() - expected).abs());
        group.bench_function(BenchmarkId::new("DOP853", tolerance), |bencher| bencher.iter(theirs));
    }
    group.finish();
}

criterion_group!(benches, cost_per_period, work_precision);
criterion_main!(benches);
