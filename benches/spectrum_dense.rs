//! Eigenvalues of dense matrices by nalgebra and by faer against their size: where `floquet` changes over.
#![allow(missing_docs, reason = "criterion's macros define undocumented items")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a benchmark stops at the first surprise")]

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::MatRef;
use nalgebra::{DMatrix, Schur};
use vibrochain::breather::{Family, breathers};
use vibrochain::floquet::even_monodromy;
use vibrochain::lattice::{Chain, Model};

fn eigenvalues(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("eigenvalues");
    for sites in [9, 19, 29, 39, 49, 79] {
        let model = Model::forced(Chain::new(sites, 0.2, 0.1).unwrap(), 1.5, 0.4, 0.1, 0.9).unwrap();
        let orbit = &breathers(&model, Family::DoubleSided).unwrap().orbits[0];
        let matrix = even_monodromy(orbit).unwrap();
        let n = matrix.size();
        group.bench_function(BenchmarkId::new("nalgebra", n), |bencher| {
            bencher.iter(|| {
                let dense = DMatrix::from_column_slice(n, n, black_box(matrix.entries()));
                Schur::try_new(dense, f64::EPSILON, 60 * n).unwrap().complex_eigenvalues()
            });
        });
        group.bench_function(BenchmarkId::new("faer", n), |bencher| {
            bencher.iter(|| MatRef::from_row_major_slice(black_box(matrix.entries()), n, n).eigenvalues().unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, eigenvalues);
criterion_main!(benches);
