//! Cells per second of the paper's maps, conservative and forced: N = 5, 10, 20, 40, with and without stability, 1 and 2
//! threads.
#![allow(missing_docs, reason = "criterion's macros define undocumented items")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a benchmark stops at the first surprise")]

use std::hint::black_box;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use vibrochain_cli::scene::Scene;
use vibrochain_cli::sweep::{Ended, sweep};

/// The paper's map on a coarser grid.
fn scene(sites: usize, forced: bool, stability: bool) -> Scene {
    let forcing = if forced { "forcing = { amplitude = 0.1, restitution = 0.9 }" } else { "" };
    let text = format!(
        r#"
        [model]
        sites = {sites}
        gamma1 = 0.2
        asymmetry = 0.4
        {forcing}
        [sweep]
        x = {{ parameter = "omega",  from = 0.4, to = 3.0, points = 100 }}
        y = {{ parameter = "gamma2", from = 0.0, to = 0.3, points = 48 }}
        [compute]
        families = ["double-sided", "single-sided"]
        stability = {stability}
        "#
    );
    Scene::parse(Path::new("bench"), &text).unwrap()
}

fn maps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("map");
    group.sample_size(10);
    for (sites, forced) in [6, 11, 21, 41].into_iter().flat_map(|sites| [(sites, false), (sites, true)]) {
        for stability in [false, true] {
            for threads in [1, 2] {
                let scene = scene(sites, forced, stability);
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let model = if forced { "forced" } else { "conservative" };
                let work = if stability { "stability" } else { "existence" };
                group.throughput(Throughput::Elements(scene.cells() as u64));
                group.bench_function(format!("{model}/N={}/{work}/threads={threads}", sites - 1), |bencher| {
                    bencher.iter(|| {
                        let ended = sweep(
                            &scene,
                            &pool,
                            &AtomicBool::new(false),
                            || {},
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

criterion_group!(benches, maps);
criterion_main!(benches);
