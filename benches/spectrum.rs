//! Stability by the secular function against dense matrices, N = 5 … 40; and dense eigenvalues by nalgebra and by faer
//! against their size, where `floquet` changes over.
#![allow(missing_docs, reason = "criterion's macros define undocumented items")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a benchmark stops at the first surprise")]

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::MatRef;
use nalgebra::Schur;
use vibrochain::breather::{Family, Finder, OrbitList, breathers};
use vibrochain::floquet::{Analyser, ImpactSpectrum, Secular, Tolerance, even_monodromy};
use vibrochain::lattice::{Chain, Model, Point};

/// Orbits all over the paper's map, so that every path of the verdict takes its share.
fn conservative(sites: usize, family: Family) -> Vec<Model> {
    let mut models = Vec::new();
    let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
    for i in 0..16 {
        for j in 1..=8 {
            let (omega, g2) = (0.5 + 0.125 * f64::from(i), 0.0375 * f64::from(j));
            let model = Model::conservative(Chain::new(sites, 0.2, g2).unwrap(), omega, 0.4).unwrap();
            if finder.find_symmetric(&model, family, &mut found).is_ok() && !found.orbits.is_empty() {
                models.push(model);
            }
        }
    }
    models
}

fn verdicts(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("conservative");
    for sites in [6, 11, 21, 41] {
        for (name, family) in [("single", Family::SingleSided), ("double", Family::DoubleSided)] {
            let mut cases: Vec<_> = conservative(sites, family)
                .into_iter()
                .map(|model| {
                    let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
                    finder.find_symmetric(&model, family, &mut found).unwrap();
                    (found.orbits[0].clone(), finder)
                })
                .collect();
            group.throughput(criterion::Throughput::Elements(cases.len() as u64));
            let mut secular = Secular::default();
            group.bench_function(format!("residues/{name}/N={}", sites - 1), |bencher| {
                bencher.iter(|| {
                    for (orbit, finder) in &mut cases {
                        let _ = black_box(secular.replace(finder.prepared(orbit).unwrap()));
                    }
                });
            });
            group.bench_function(format!("verdict/{name}/N={}", sites - 1), |bencher| {
                bencher.iter(|| {
                    for (orbit, finder) in &mut cases {
                        if secular.replace(finder.prepared(orbit).unwrap()).is_ok() {
                            let _ = black_box(secular.verdict());
                        }
                    }
                });
            });
            group.bench_function(format!("all roots/{name}/N={}", sites - 1), |bencher| {
                bencher.iter(|| {
                    for (orbit, finder) in &mut cases {
                        if secular.replace(finder.prepared(orbit).unwrap()).is_ok() {
                            let _ = black_box(secular.roots());
                        }
                    }
                });
            });
            let mut analyser = Analyser::dense();
            let mut finder = Finder::new(sites);
            group.bench_function(format!("dense verdict/{name}/N={}", sites - 1), |bencher| {
                bencher.iter(|| {
                    for (orbit, _) in &cases {
                        let _ = black_box(analyser.verdict(orbit, &mut finder, Tolerance::Rounding));
                    }
                });
            });
        }
    }
    group.finish();
}

fn forced(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("forced");
    for sites in [6, 11, 21, 41] {
        for (name, family, omega) in [("n=1", Family::SingleSided, 0.92), ("n=2", Family::DoubleSided, 1.5)] {
            let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1);
            let model = ring.omega(omega).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
            let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
            finder.find(&model, family, &mut found).unwrap();
            let orbit = &found.orbits[0];
            group.bench_function(format!("all multipliers/{name}/N={}", sites - 1), |bencher| {
                bencher.iter(|| {
                    let known = finder.at_contacts(black_box(orbit)).unwrap();
                    ImpactSpectrum::new(&known.bloch_equations().0).multipliers.len()
                });
            });
            let (mut analyser, mut other) = (Analyser::default(), Finder::new(sites));
            group.bench_function(format!("verdict/{name}/N={}", sites - 1), |bencher| {
                bencher.iter(|| analyser.verdict(black_box(orbit), &mut other, Tolerance::Rounding).unwrap());
            });
            let mut analyser = Analyser::dense();
            let mut other = Finder::new(sites);
            group.bench_function(format!("dense verdict/{name}/N={}", sites - 1), |bencher| {
                bencher.iter(|| analyser.verdict(black_box(orbit), &mut other, Tolerance::Rounding).unwrap());
            });
        }
    }
    group.finish();
}

fn large_rings(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("large");
    group.sample_size(10);
    for sites in [21, 101, 1001, 10_001, 100_001] {
        // Without and with bands of opposite signature on top of each other.
        for (name, family, omega) in [
            ("single", Family::SingleSided, 0.8),
            ("double", Family::DoubleSided, 0.8),
            ("single, overlapping", Family::SingleSided, 0.6),
            ("double, overlapping", Family::DoubleSided, 0.6),
        ] {
            let model = Model::conservative(Chain::new(sites, 0.2, 0.1).unwrap(), omega, 0.4).unwrap();
            let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
            finder.find_symmetric(&model, family, &mut found).unwrap();
            let mut secular = Secular::default();
            group.bench_function(format!("all roots/{name}/{sites} sites"), |bencher| {
                bencher.iter(|| {
                    secular.replace(finder.prepared(black_box(&found.orbits[0])).unwrap()).unwrap();
                    secular.roots().unwrap().0.len()
                });
            });
        }
        if sites > 1001 {
            continue;
        }
        for (name, family, omega) in [("n=1", Family::SingleSided, 0.92), ("n=2", Family::DoubleSided, 1.5)] {
            let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1);
            let model = ring.omega(omega).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
            let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
            finder.find(&model, family, &mut found).unwrap();
            group.bench_function(format!("all multipliers/{name}/{sites} sites"), |bencher| {
                bencher.iter(|| {
                    let known = finder.at_contacts(black_box(&found.orbits[0])).unwrap();
                    ImpactSpectrum::new(&known.bloch_equations().0).multipliers.len()
                });
            });
        }
    }
    group.finish();
}

fn eigenvalues(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("eigenvalues");
    for sites in [9, 19, 29, 39, 49, 79] {
        let point = Point::ring(sites).gamma1(0.2).gamma2(0.1);
        let model = point.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
        let orbit = &breathers(&model, Family::DoubleSided).unwrap().orbits[0];
        let matrix = even_monodromy(orbit).unwrap();
        let n = matrix.nrows();
        group.bench_function(BenchmarkId::new("nalgebra", n), |bencher| {
            bencher.iter(|| {
                Schur::try_new(black_box(matrix.clone()), f64::EPSILON, 60 * n).unwrap().complex_eigenvalues()
            });
        });
        group.bench_function(BenchmarkId::new("faer", n), |bencher| {
            bencher.iter(|| MatRef::from_column_major_slice(black_box(matrix.as_slice()), n, n).eigenvalues().unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, verdicts, forced, large_rings, eigenvalues);
criterion_main!(benches);
