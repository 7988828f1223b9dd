//! Cost of the event-driven simulation per period, against the size of the ring, with one impacting mass and with many;
//! and its error against run time beside an adaptive Runge–Kutta method with root finding on the same orbit.
#![allow(missing_docs, reason = "criterion's macros define undocumented items")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a benchmark stops at the first surprise")]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use ode_solvers::dop_shared::OutputType;
use ode_solvers::{DVector, Dop853, System};
use vibrochain::breather::{Family, Motion, Orbit, breathers};
use vibrochain::eventsim::{Limits, Simulation, Time};
use vibrochain::lattice::{Chain, Model};

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

/// The ring as a general solver sees it.
struct Ring {
    sites: usize,
}

type State = DVector<f64>;

impl System<f64, State> for Ring {
    fn system(&self, _: f64, y: &State, dy: &mut State) {
        let m = self.sites;
        for n in 0..m {
            dy[n] = y[n + m];
            dy[n + m] = -0.2 * y[n] - 0.1 * (2.0 * y[n] - y[(n + 1) % m] - y[(n + m - 1) % m]);
        }
    }
}

/// Integrates to `time`; dense output every `step`, or the end alone.
fn integrate(sites: usize, from: &State, time: f64, step: Option<f64>, tolerance: f64) -> (Vec<f64>, Vec<State>) {
    let dx = step.unwrap_or(time);
    let mut solver = Dop853::new(Ring { sites }, 0.0, time, dx, from.clone(), tolerance, tolerance);
    if step.is_none() {
        solver.set_output(OutputType::Sparse);
    }
    solver.integrate().unwrap();
    (solver.x_out().clone(), solver.y_out().clone())
}

/// Event location the usual way: dense output, change of sign between outputs, Newton's method. Returns the time of the
/// last of `impacts` impacts.
fn runge_kutta(sites: usize, u: &[f64], v: &[f64], impacts: usize, tolerance: f64) -> f64 {
    let mut state = State::from_iterator(2 * sites, u.iter().chain(v).copied());
    let (period, mut now) = (std::f64::consts::TAU / 1.5, 0.0);
    for _ in 0..impacts {
        // Past the next impact for certain, and not past the one after it.
        let (times, states) = integrate(sites, &state, 0.6 * period, Some(period / 20.0), tolerance);
        // A mass that has just hit may still be outside by rounding: the first output is passed over.
        let outside = |y: &State| (0..sites).find(|&n| (y[n] - 0.4).abs() > 1.0);
        let (index, site) = states.iter().enumerate().skip(1).find_map(|(i, y)| outside(y).map(|n| (i, n))).unwrap();
        let mut t = times[index];
        let barrier = 0.4 + (states[index][site] - 0.4).signum();
        let mut hit = states[index].clone();
        for _ in 0..8 {
            let step = (hit[site] - barrier) / hit[site + sites];
            t -= step;
            if step.abs() < 1e-15 {
                break;
            }
            hit = integrate(sites, &state, t, None, tolerance).1.pop().unwrap();
        }
        hit[site] = barrier;
        hit[site + sites] *= -1.0;
        (state, now) = (hit, now + t);
    }
    now
}

/// 100 periods of the N = 20 breather: time by criterion, error of the last impact printed once.
fn work_precision(criterion: &mut Criterion) {
    let (sites, periods) = (21, 100);
    let (orbit, start, u, v) = on_breather(sites, 0.0);
    let expected = (periods as f64 - 0.5) * orbit.period() - start;
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
        let theirs = || runge_kutta(sites, &u, &v, 2 * periods as usize, tolerance);
        println!("DOP853 at {tolerance:e}: error of the last impact {:.1e}", (theirs() - expected).abs());
        group.bench_function(BenchmarkId::new("DOP853", tolerance), |bencher| bencher.iter(theirs));
    }
    group.finish();
}

criterion_group!(benches, cost_per_period, work_precision);
criterion_main!(benches);
