//! Cost of the event-driven simulation per period, against the size of the ring, with one impacting mass and with many.
//! Its error against run time beside other methods is a suite of `studies accuracy`.
#![allow(missing_docs, reason = "criterion's macros define undocumented items")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a benchmark stops at the first surprise")]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use vibrochain::breather::{Family, Motion, breathers};
use vibrochain::eventsim::{Limits, Simulation, Time};
use vibrochain::lattice::{Chain, Model};

fn model(sites: usize) -> Model {
    Model::conservative(Chain::new(sites, 0.2, 0.1).unwrap(), 1.5, 0.4).unwrap()
}

/// The double-sided breather half-way to its first impact, with a perturbation of 1e-6 that is even about it.
fn on_breather(sites: usize) -> (Vec<f64>, Vec<f64>) {
    let orbit = breathers(&model(sites), Family::DoubleSided).unwrap().orbits[0].clone();
    let mut motion = Motion::of(&orbit).unwrap();
    motion.at(0, -0.25 * orbit.period());
    let u = (0..sites).map(|n| motion.site(n).displacement + 1e-6 * (n.min(sites - n) as f64).cos());
    (u.collect(), (0..sites).map(|n| motion.site(n).velocity).collect())
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
        for (name, (u, v)) in [("breather", on_breather(sites)), ("hot", hot(sites))] {
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

criterion_group!(benches, cost_per_period);
criterion_main!(benches);
