use std::time::Instant;
use vibrochain_breather::*;
use vibrochain_cli::cell::*;
use vibrochain_floquet::*;
use vibrochain_lattice::*;
fn main() {
    for sites in [6usize, 11, 21, 41] {
        for stability in [false, true] {
            for forced in [false, true] {
                let task = Task {
                    families: vec![Family::DoubleSided, Family::SingleSided],
                    stability,
                    tolerance: Tolerance::Rounding,
                };
                let mut w = Worker::new(sites);
                let (nx, ny) = if forced { (80, 30) } else { (200, 60) };
                let t = Instant::now();
                let mut counts = [0usize; 7];
                let mut worst = 0.0f64;
                let mut stat = [0; 6];
                for j in 0..ny {
                    let g2 = 0.3 * j as f64 / (ny - 1) as f64;
                    let chain = Chain::new(sites, 0.2, g2).unwrap();
                    for i in 0..nx {
                        let om = 0.4 + 2.6 * i as f64 / (nx - 1) as f64;
                        let m = if forced {
                            Model::forced(chain, om, 0.4, 0.1, 0.9)
                        } else {
                            Model::conservative(chain, om, 0.4)
                        }
                        .unwrap();
                        if std::env::var("V").is_ok() {
                            eprintln!("{g2} {om}");
                        }
                        let c = w.cell(&m, &task);
                        stat[c.status as usize] += 1;
                        if let Some(cl) = c.class {
                            counts[Class::ALL.iter().position(|x| *x == cl).unwrap()] += 1;
                        }
                        worst = worst.max(c.residual);
                    }
                }
                let dt = t.elapsed().as_secs_f64();
                println!(
                    "sites {sites} stab {stability} forced {forced}: {:.2} us/cell {:?} {:?} worst {:e}",
                    dt * 1e6 / (nx * ny) as f64,
                    counts,
                    stat,
                    worst
                );
            }
        }
    }
}
