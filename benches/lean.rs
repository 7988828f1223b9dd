//! What each kind of map costs a cell, N = 20: time, and allocations in steady state.
#![allow(missing_docs, reason = "criterion's macros define undocumented items")]
#![allow(clippy::unwrap_used, reason = "a benchmark stops at the first surprise")]

#[path = "../tests/support/lean.rs"]
mod lean;

use std::io::Write;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use lean::{KINDS, Kind};
use vibrochain_maps::cell::Worker;

fn cells(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("lean");
    group.sample_size(10);
    for kind in KINDS {
        let scene = kind.scene();
        let mut worker = Worker::new(scene.base.sites());
        group.throughput(Throughput::Elements(scene.cells()));
        group.bench_function(kind.name(), |bencher| bencher.iter(|| Kind::compute(&scene, &mut worker)));
        // A benchmark whose output is cut off (`| head`) has nothing left to say.
        let _ = writeln!(std::io::stdout(), "{}: {:.3} allocations a cell", kind.name(), kind.allocations());
    }
    group.finish();
}

criterion_group!(benches, cells);
criterion_main!(benches);
