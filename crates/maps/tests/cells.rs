//! A cell held against all verdicts of its physical orbits, none passed over.

use std::path::Path;

use vibrochain_breather::{Family, Finder, OrbitList, Scope};
use vibrochain_floquet::{Analyser, Tolerance, Verdict};
use vibrochain_lattice::{Chain, Model};
use vibrochain_maps::cell::{Cell, Class, Status, Task, Worker};
use vibrochain_maps::scene::Scene;

type Known = (Family, Verdict, Option<f64>);

/// Stable before in doubt before unstable, double-sided, which is asked for first, before single-sided, the smaller spectral radius by more than
/// both may be off, the first one.
fn is_better(a: &Known, b: &Known) -> bool {
    let rank = |(family, verdict, _): &Known| {
        (!verdict.stable, !verdict.stable && !verdict.undecided, *family == Family::SingleSided)
    };
    let least = |(_, verdict, _): &Known| verdict.spectral_radius - verdict.resolution;
    let most = |(_, verdict, _): &Known| verdict.spectral_radius + verdict.resolution;
    rank(a) < rank(b) || rank(a) == rank(b) && most(a) < least(b)
}

#[test]
fn a_cell_is_what_all_verdicts_make_it() {
    let mut random = fastrand::Rng::with_seed(47);
    let (mut finder, mut found, mut analyser) = (Finder::new(1), OrbitList::default(), Analyser::default());
    let (mut several, mut single, mut stable) = (0, 0, 0);
    for _ in 0..1500 {
        let sites = [2, 5, 11, 21][random.usize(..4)];
        let gamma2 = [1e-3, 0.05, 0.3][random.usize(..3)] * (0.1 + 0.9 * random.f64());
        let Ok(chain) = Chain::new(sites, 0.2, gamma2) else { continue };
        let (asymmetry, e) = ([0.0, 0.2, 0.4][random.usize(..3)], [0.99, 0.9, 0.6][random.usize(..3)]);
        let (omega, force) = (0.4 + 2.6 * random.f64(), 0.02 + 0.28 * random.f64());
        let Ok(model) = chain.point().omega(omega).asymmetry(asymmetry).amplitude(force).restitution(e).model() else {
            continue;
        };
        let tolerance = if random.bool() { Tolerance::Rounding } else { Tolerance::Excess(0.01) };
        let families = vec![Family::DoubleSided, Family::SingleSided];
        let mut all = Vec::new();
        for &family in &families {
            if finder.search(&model, family, Scope::Candidates, &mut found).is_err() {
                continue;
            }
            for orbit in &found.orbits {
                let admissibility = finder.quick_admissibility(orbit).unwrap();
                if admissibility.is_physical() {
                    let Ok(verdict) = analyser.verdict(orbit, &mut finder, tolerance) else { continue };
                    all.push((family, verdict, admissibility.margin));
                }
            }
        }
        let task = Task {
            families,
            words: Vec::new(),
            symmetric: false,
            stability: true,
            tolerance,
            collisions: false,
            impulse: false,
        };
        let cell = Worker::new(sites).cell(&model, &task);
        assert_eq!(cell.solutions as usize, all.len(), "{model:?}");
        let Some((family, verdict, margin)) =
            all.iter().reduce(|best, next| if is_better(next, best) { next } else { best })
        else {
            assert_eq!(cell.class, Some(Class::None));
            continue;
        };
        if cell.status != Status::Ok {
            continue;
        }
        let expected = match (*family == Family::SingleSided, verdict.stable) {
            (true, true) => Class::StableSingle,
            (true, false) => Class::UnstableSingle,
            (false, true) => Class::StableDouble,
            (false, false) => Class::UnstableDouble,
        };
        assert_eq!((cell.class, cell.mechanism), (Some(expected), verdict.mechanism), "{model:?}");
        assert_eq!((cell.spectral_radius, cell.margin), (Some(verdict.spectral_radius), *margin), "{model:?}");
        several += usize::from(all.len() > 1);
        single += usize::from(*family == Family::SingleSided);
        stable += usize::from(verdict.stable);
    }
    assert!(several > 100 && single > 20 && stable > 20, "{several} {single} {stable}");
}

/// The fast path of conservative cells, from map breathers, against the general one, from orbits. Residuals are sums in another order.
#[test]
fn a_cell_from_map_breathers_is_that_from_orbits() {
    let mut random = fastrand::Rng::with_seed(53);
    let (mut fast, mut general) = (Worker::new(1), Worker::new(1));
    let mut seen: [usize; Class::ALL.len()] = Default::default();
    let mut mechanisms = std::collections::HashSet::new();
    let mut other_sums = 0;
    for _ in 0..20_000 {
        let sites = [1, 2, 3, 6, 7, 11, 20, 21, 41, 120][random.usize(..10)];
        let gamma1 = [0.2, 0.2, 0.0, 3.0][random.usize(..4)];
        let gamma2 = [1e-9, 1e-3, 0.1, 0.3, 2.0][random.usize(..5)] * random.f64();
        let Ok(chain) = Chain::new(sites, gamma1, gamma2) else { continue };
        let asymmetry = [0.0, 0.1, 0.4, 0.7][random.usize(..4)];
        let model = Model::conservative(chain, 0.2 + 2.8 * random.f64(), asymmetry).unwrap();
        let task = Task {
            families: match random.u8(..4) {
                0 => vec![Family::SingleSided],
                1 => vec![Family::SingleSided, Family::DoubleSided],
                _ => vec![Family::DoubleSided, Family::SingleSided],
            },
            words: Vec::new(),
            symmetric: random.bool(),
            stability: random.u8(..8) > 0,
            tolerance: [Tolerance::Rounding, Tolerance::Rounding, Tolerance::Excess(0.01)][random.usize(..3)],
            collisions: false,
            impulse: random.bool(),
        };
        let (cell, expected) = (fast.cell(&model, &task), general.examine(&model, &task, |_, _| {}));
        // Next to a resonance both are as large as the orbit's own error.
        assert!((cell.residual - expected.residual).abs() < 1e-13 + expected.residual, "{model:?}");
        // (If all were the same to the bit, the fast path would not have been taken.)
        other_sums += usize::from(cell.residual != expected.residual);
        assert_eq!(Cell { residual: expected.residual, ..cell }, expected, "{model:?} {task:?}");
        if let Some(class) = cell.class {
            seen[Class::ALL.iter().position(|one| *one == class).unwrap()] += 1;
        }
        mechanisms.extend(cell.mechanism);
    }
    println!("{other_sums} other sums");
    assert!(other_sums > 1000, "{other_sums}");
    // All classes but those of other words, and all mechanisms.
    assert!(seen[..7].iter().all(|&count| count > 30) && mechanisms.len() == 4, "{seen:?} {mechanisms:?}");
}

#[test]
fn a_walk_shows_the_points_and_models_of_its_cells() {
    let text = "[model]\nsites = 5\ngamma1 = 0.2\n[sweep]\naxes = [\n\
                { parameter = \"omega\", from = 0.4, to = 3.0, points = 7 },\n\
                { parameter = \"gamma2\", from = 0.0, to = 0.3, points = 5 },\n\
                { parameter = \"asymmetry\", values = [0.1, 0.4] },\n]\n\
                [compute]\nfamilies = [\"double-sided\"]\n";
    let scene = Scene::parse(Path::new("scene.toml"), text).unwrap();
    let mut walked = 0;
    for (from, to) in [(0, 70), (3, 4), (5, 23), (7, 14), (69, 70), (12, 12)] {
        let mut shown = Vec::new();
        scene.walk(from..to, |point| {
            shown.push(*point);
            true
        });
        assert_eq!(shown, (from..to).map(|cell| scene.point(cell)).collect::<Vec<_>>());
        let mut models = Vec::new();
        scene.walk_models(from..to, |model| {
            models.push(*model);
            true
        });
        assert_eq!(models, shown.iter().map(|point| point.model().unwrap()).collect::<Vec<_>>());
        walked += shown.len();
    }
    assert_eq!(walked, 70 + 1 + 18 + 7 + 1);
    let mut left = 3;
    scene.walk(0..70, |_| {
        left -= 1;
        left > 0
    });
    assert_eq!(left, 0);
}
