//! Cells per second of the paper's maps, conservative and forced: N = 5, 10, 20, 40, with and without stability, 1 and 2
//! threads. The floor beside them: sines, cosines and divisions that no conservative cell could do without.
#![allow(missing_docs, reason = "criterion's macros define undocumented items")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a benchmark stops at the first surprise")]

use std::f64::consts::PI;
use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use vibrochain::lattice::{Chain, Spectrum, Stop};
use vibrochain_maps::scene::Scene;
use vibrochain_maps::sweep::{Ended, sweep};
use vibrochain_testkit::paper_map;

fn maps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("map");
    group.sample_size(10);
    for (sites, forced) in [6, 11, 21, 41].into_iter().flat_map(|sites| [(sites, false), (sites, true)]) {
        for stability in [false, true] {
            for threads in [1, 2] {
                let text = paper_map(sites, forced, [100, 48], stability);
                let scene = Scene::parse(Path::new("bench"), &text).unwrap();
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let model = if forced { "forced" } else { "conservative" };
                let work = if stability { "stability" } else { "existence" };
                group.throughput(Throughput::Elements(scene.cells()));
                group.bench_function(format!("{model}/N={}/{work}/threads={threads}", sites - 1), |bencher| {
                    bencher.iter(|| {
                        let ended = sweep(
                            &scene,
                            &pool,
                            &Stop::default(),
                            |_| {},
                            |_, cells| {
                                black_box(cells);
                                Ok::<(), ()>(())
                            },
                        );
                        assert!(matches!(ended, Ended::Complete(_)));
                    });
                });
            }
        }
    }
    group.finish();
}

/// One sine and cosine a mode that feels the impacts and one division for its kernel, one division for every two such
/// modes, as in the residues.
fn floor(criterion: &mut Criterion) {
    const CELLS: u64 = 1000;
    let mut group = criterion.benchmark_group("floor");
    for sites in [6, 11, 21, 41] {
        let spectrum = Spectrum::new(Chain::new(sites, 0.2, 0.1).unwrap());
        let frequencies: Vec<f64> = spectrum.frequencies().to_vec();
        let (mut sines, mut cosines) = (frequencies.clone(), frequencies.clone());
        group.throughput(Throughput::Elements(CELLS));
        group.bench_function(format!("N={}", sites - 1), |bencher| {
            bencher.iter(|| {
                let mut total = 0.0;
                for cell in 0..CELLS {
                    let half_period = PI / (0.4 + 2.6 * cell as f64 / CELLS as f64);
                    for ((frequency, sine), cosine) in frequencies.iter().zip(&mut sines).zip(&mut cosines) {
                        (*sine, *cosine) = (black_box(*frequency) * half_period).sin_cos();
                    }
                    for (k, (sine, cosine)) in sines.iter().zip(&cosines).enumerate() {
                        total += cosine / sine;
                        total += cosines[..k].iter().map(|other| 1.0 / (cosine - other)).sum::<f64>();
                    }
                }
                black_box(total)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, floor, maps);
criterion_main!(benches);
