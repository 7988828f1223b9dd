//! What maps and orbits of structures cost: a cell of a damped ring beside one of a ring without dashpots, a cell of a beam's map of two modes, and
//! an orbit of a structure of 300 modes and 10 contacts with all its multipliers.
#![allow(missing_docs, reason = "criterion's macros define undocumented items")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a benchmark stops at the first surprise")]

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rayon::ThreadPool;
use vibrochain::breather::LoadedStructure;
use vibrochain::floquet::{Tolerance, stability};
use vibrochain::lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape, Stop};
use vibrochain_maps::grid::Grid;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::sweep::{Ended, sweep};

const AXES: &str = "[sweep]\nx = { parameter = \"omega\", from = 0.4, to = 3.0, points = 50 }\n\
    y = { parameter = \"gamma2\", from = 0.0, to = 0.3, points = 36 }\n\
    [compute]\nfamilies = [\"double-sided\", \"single-sided\"]\n";

/// Two modes of a cantilever with a stop at its tip, over frequency and gap.
const BEAM: &str = "omega = 3\n[structure]\nfrequencies = [1, 6.267]\nratios = [0.01, 0.01]\n\
    contact_shapes = [[2, -2]]\nload_shapes = [0.783, 0.434]\n[[contact]]\nupper = 0.3\nrestitution = 0.8\n\
    [sweep]\nx = { parameter = \"omega\", from = 0.5, to = 4, points = 50 }\n\
    y = { parameter = \"contact.0.upper\", from = 0.05, to = 1, points = 36 }\n[compute]\nfamilies = [\"0+\"]\n";

fn map<S: Grid>(scene: &S, pool: &ThreadPool) {
    let ended = sweep(
        scene,
        pool,
        &Stop::default(),
        |_| {},
        |_, cells| {
            black_box(cells);
            Ok::<(), ()>(())
        },
    );
    assert!(matches!(ended, Ended::Complete(_)));
}

fn maps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("structures");
    group.sample_size(10).throughput(Throughput::Elements(50 * 36));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let ring = "[model]\nsites = 21\ngamma1 = 0.2\nasymmetry = 0.4\namplitude = 0.1\nrestitution = 0.9\n";
    let undamped = Scene::parse(Path::new("bench"), &format!("{ring}{AXES}")).unwrap();
    group.bench_function("ring N=20, undamped", |bencher| bencher.iter(|| map(&undamped, &pool)));
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in
        [("ring N=20, damped", format!("{ring}damping = 0.01\n{AXES}")), ("beam of two modes", BEAM.to_owned())]
    {
        let file = folder.path().join("scene.toml");
        std::fs::write(&file, text).unwrap();
        let scene = StructureScene::read(&file).unwrap().unwrap();
        group.bench_function(name, |bencher| bencher.iter(|| map(&scene, &pool)));
    }
    group.finish();
}

/// Modes of a long beam, of which every contact sees another place.
fn long() -> ModalStructure {
    let mode = |k: usize| {
        let frequency = 0.5 + 0.02 * k as f64;
        let contacts = (0..10).map(|c| ((c as f64 + 1.3) * (k as f64 + 1.0) * 0.27).sin() * 0.08).collect();
        let shape = ModeShape { contacts, coordinates: Vec::new(), still: 0.0 };
        let load = Complex::new(if k < 5 { 0.5 } else { 0.0 }, 0.0);
        LinearMode::oscillator(0.01 * frequency, frequency * frequency * (1.0 - 1e-4), &shape, &[load])
    };
    let contact = Contact { lower: Some(-0.05), upper: Some(0.05), restitution: 0.8 };
    ModalStructure::new(vec![contact; 10], vec![1], (0..300).map(mode).collect()).unwrap()
}

fn orbit(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("structures");
    group.sample_size(10);
    let structure = Arc::new(long());
    let word = "0+,3-".parse().unwrap();
    group.bench_function("300 modes, 10 contacts: an orbit with its spectrum", |bencher| {
        bencher.iter(|| {
            let model = LoadedStructure::new(structure.clone(), 0.7).unwrap();
            let found = model.orbits(&word, 1).unwrap();
            let orbit = found.orbits.first().unwrap();
            black_box(stability(orbit, Tolerance::Rounding).unwrap())
        });
    });
    group.finish();
}

criterion_group!(benches, maps, orbit);
criterion_main!(benches);
