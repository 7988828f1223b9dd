//! Cost of a period against the size of the ring: one impacting mass, and hot rings in which every mass hits.
//!
//! `cargo run --release -p vibrochain-eventsim --example cost`

use std::time::Instant;

use vibrochain_eventsim::{Limits, Simulation, Time};
use vibrochain_lattice::{Chain, ImpulseResponse, Model, Spectrum};

/// Half impulses of the double-sided breather at γ₁ = 0.2, γ₂ = 0.1, ω = 1.5, a = 0.4 (21 masses; a longer ring
/// changes them below 1e-6).
const IMPULSES: [f64; 2] = [0.973_939_432_174_328_2, 0.640_169_940_982_344_7];

/// Measurements of each case.
const REPEATS: u64 = 8;

type Failure = Box<dyn std::error::Error>;

/// State just after the impact at t = 0.
fn breather(model: &Model) -> Result<(Vec<f64>, Vec<f64>), Failure> {
    let [p1, p2] = IMPULSES;
    let sites = model.chain().sites();
    let response = ImpulseResponse::new(&Spectrum::new(*model.chain()), model.omega())?;
    let (mut half, mut zero) = (vec![0.0; sites], vec![0.0; sites]);
    response.profile(0.5 * model.period(), &mut half);
    response.profile(0.0, &mut zero);
    let fold = |n: usize| n.min(sites - n);
    let u = (0..sites).map(|n| 2.0 * p1 * half[fold(n)] - 2.0 * p2 * zero[fold(n)]);
    // On a ring of another length the breather's mass misses its barrier by a rounding of the impulses.
    let u = u.map(|u| u.clamp(model.asymmetry() - 1.0, model.asymmetry() + 1.0)).collect();
    let mut v = vec![0.0; sites];
    v[0] = -p2;
    Ok((u, v))
}

/// Masses at the middle of the gap with random velocities: about one impact a mass and period.
fn hot(model: &Model) -> (Vec<f64>, Vec<f64>) {
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let sites = model.chain().sites();
    let u = (0..sites).map(|_| model.asymmetry() + random() - 0.5).collect();
    let v = (0..sites).map(|_| 2.6 * random() - 1.3).collect();
    (u, v)
}

fn main() -> Result<(), Failure> {
    println!("sites  start     µs/period  impacts/period  windows  restarts  bounds/mass  watched  steps/impact");
    for sites in [21, 100, 1000, 10_000] {
        let model = Model::conservative(Chain::new(sites, 0.2, 0.1)?, 1.5, 0.4)?;
        for (name, (u, v)) in [("breather", breather(&model)?), ("hot", hot(&model))] {
            let periods = (500_000 / sites as u64 / if name == "hot" { 20 } else { 2 }).max(5);
            let mut simulation = Simulation::new(&model, 0.0, &u, &v)?;
            let mut report = simulation.run(&Limits::until(Time::new(&model, 5, 0.0)), |_| {});
            let before = report.work;
            // The least of several measurements is the one least disturbed by the machine's other work.
            let mut time = f64::INFINITY;
            for i in 1..=REPEATS {
                let end = Limits::until(Time::new(&model, 5 + i * periods, 0.0));
                let start = Instant::now();
                report = simulation.run(&end, |_| {});
                time = time.min(start.elapsed().as_secs_f64() * 1e6 / periods as f64);
            }
            let per = |after: u64, before: u64| (after - before) as f64 / (REPEATS * periods) as f64;
            let work = report.work;
            let impacts = per(work.impacts, before.impacts);
            println!(
                "{sites:5}  {name:8} {time:10.2} {impacts:15.2} {:8.2} {:9.2} {:12.2} {:8.2} {:13.2}",
                per(work.windows, before.windows),
                per(work.restarts, before.restarts),
                per(work.bounds, before.bounds) / sites as f64,
                per(work.watched, before.watched),
                per(work.refinements, before.refinements) / impacts,
            );
        }
    }
    Ok(())
}
