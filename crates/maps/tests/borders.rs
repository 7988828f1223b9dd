//! Borders of whole windows, held against cells at random points, which know nothing of them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use fastrand::Rng;
use vibrochain_breather::Family;
use vibrochain_floquet::{StripeEnd, StripeFinder, StripeLine};
use vibrochain_lattice::Stop;
use vibrochain_maps::borders::{BorderKind, BorderRequest, Borders, Stage};
use vibrochain_maps::cell::{Class, Worker};
use vibrochain_maps::regions::{Regions, Subdivision, Window};
use vibrochain_maps::scene::Scene;

const TOLERANCE: f64 = 1e-6;

/// A scene over frequency and coupling.
fn scene(sites: usize, model: &str, families: &str, points: [usize; 2]) -> Scene {
    let [columns, rows] = points;
    let text = format!(
        "[model]\nsites = {sites}\ngamma1 = 0.2\nasymmetry = 0.4\n{model}\n[sweep]\n\
         x = {{ parameter = \"omega\", from = 0.4, to = 3.0, points = {columns} }}\n\
         y = {{ parameter = \"gamma2\", from = 0.0, to = 0.3, points = {rows} }}\n\
         [compute]\nfamilies = [{families}]\nstability = true\n"
    );
    Scene::parse(Path::new("scene.toml"), &text).unwrap()
}

const BOTH: &str = "\"double-sided\", \"single-sided\"";

/// Places that are asked at the end.
const PLACES: usize = 20_000;

fn borders(scene: &Scene) -> (Borders, Regions<Option<Class>>) {
    searched(scene, PLACES)
}

fn searched(scene: &Scene, places: usize) -> (Borders, Regions<Option<Class>>) {
    let stop = Stop::default();
    let asked = BorderRequest { tolerance: TOLERANCE, places, special: false, stop: &stop, told: &|_, _, _, _| {} };
    Borders::of_scene(scene, &asked).unwrap()
}

/// The regions between borders, to what is known of their points.
fn fine(scene: &Scene, found: &Borders) -> Regions<Option<Class>> {
    let subdivision = Subdivision::new(Window::of(scene).unwrap(), &found.lines(), 1e-8).unwrap();
    let worker = || Worker::new(scene.base.sites());
    subdivision
        .classified(PLACES, worker, |worker, point| worker.cell(&scene.at(&point).model().unwrap(), &scene.task).class)
}

/// Random points whose class is another one than that of their region, though it is the same all around them as far as `near`,
/// a part of the window; and how many were compared.
fn exceptions(scene: &Scene, regions: &Regions<Option<Class>>, near: f64, points: usize) -> (Vec<[f64; 2]>, usize) {
    let window = Window::of(scene).unwrap();
    let mut worker = Worker::new(scene.base.sites());
    let mut class = |part: [f64; 2]| -> Option<Class> {
        let inside = part.map(|part| part.clamp(0.0, 1.0));
        worker.cell(&scene.at(&window.point(inside)).model().unwrap(), &scene.task).class
    };
    let mut random = Rng::with_seed(11);
    let (mut differing, mut compared) = (Vec::new(), 0);
    for _ in 0..points {
        let part = [random.f64(), random.f64()];
        let Some(own) = class(part) else { continue };
        compared += 1;
        let told = regions.at(window.point(part)).copied().flatten();
        if told == Some(own) {
            continue;
        }
        let aside = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
        if !aside.iter().any(|[x, y]| class([part[0] + near * x, part[1] + near * y]) == told) {
            differing.push(window.point(part));
        }
    }
    (differing, compared)
}

fn count(found: &Borders, kind: BorderKind) -> usize {
    found.borders.iter().filter(|border| border.kind == kind).count()
}

#[test]
fn regions_have_the_class_of_their_cells() {
    let scene = scene(6, "", BOTH, [100, 75]);
    let (found, _) = borders(&scene);
    let regions = fine(&scene, &found);
    assert!(found.unexplained.is_empty() && !found.interrupted, "{:?}", found.unexplained);
    let (differing, compared) = exceptions(&scene, &regions, 1e-8, 20_000);
    assert!(differing.is_empty() && compared > 19_900, "{compared}: {differing:?}");
    // What organises the map: each of these is there.
    for kind in [
        BorderKind::Grazing,
        BorderKind::Pitchfork,
        BorderKind::PeriodDoubling,
        BorderKind::NeimarkSacker,
        BorderKind::Resonance,
    ] {
        assert!(count(&found, kind) > 0, "{kind}");
    }
    assert_eq!(count(&found, BorderKind::Change), 0);
    // Next to a resonance, where impulses vanish, nothing tells how well a point is known.
    let points = found.borders.iter().flat_map(|border| &border.points);
    let (known, all) = points.fold((0, 0), |(known, all), point| (known + usize::from(point.error < 1e-6), all + 1));
    assert!(known > 6000 && 50 * known > 49 * all, "{known} of {all}");
}

#[test]
fn forced_borders_and_thresholds_are_those_of_cells() {
    let driven = "forcing = { amplitude = 0.1, restitution = 0.9 }";
    let strict = scene(6, driven, BOTH, [60, 45]);
    let mut patient = strict.clone();
    patient.task.tolerance = vibrochain_floquet::Tolerance::Excess(0.01);
    for (scene, kind) in [(strict, BorderKind::Fold), (patient, BorderKind::Threshold)] {
        let (found, _) = borders(&scene);
        let regions = fine(&scene, &found);
        assert!(count(&found, kind) > 0 && found.unexplained.is_empty(), "{kind}: {:?}", found.unexplained);
        let (differing, compared) = exceptions(&scene, &regions, 1e-7, 3000);
        assert!(differing.is_empty() && compared > 2900, "{kind} {compared}: {differing:?}");
    }
}

#[test]
fn stripes_of_rows_are_between_borders() {
    let scene = scene(11, "", "\"double-sided\"", [80, 60]);
    let (found, _) = borders(&scene);
    assert!(found.stripes() >= 15, "{}", found.stripes());
    let mut random = Rng::with_seed(5);
    let mut checked = 0;
    for _ in 0..3 {
        let gamma2 = 0.05 + 0.24 * random.f64();
        let model = scene.at(&[1.0, gamma2]).model().unwrap();
        let line = StripeLine { model, family: Family::DoubleSided, free: scene.axes[0].parameter };
        let row = StripeFinder::default().along(&line, (0.4, 3.0), 1000).unwrap();
        let crossings = crossings(&found, gamma2);
        for stripe in row.stripes.iter().filter(|stripe| stripe.ends == [StripeEnd::Edge; 2]) {
            for edge in stripe.edges {
                let nearest = crossings.iter().map(|x| (x - edge).abs()).fold(f64::INFINITY, f64::min);
                assert!(nearest < 2.0 * TOLERANCE * 2.6, "{:?} at γ₂ = {gamma2}: {edge}, {nearest}", stripe.pair);
                checked += 1;
            }
        }
    }
    assert!(checked > 60, "{checked}");
}

/// Where borders cross a row.
fn crossings(found: &Borders, row: f64) -> Vec<f64> {
    let lines = found.lines();
    let pairs = lines.iter().flat_map(|line| line.windows(2));
    let met = pairs.filter(|pair| (pair[0][1] > row) != (pair[1][1] > row));
    met.map(|pair| {
        let share = (row - pair[0][1]) / (pair[1][1] - pair[0][1]);
        pair[0][0] + share * (pair[1][0] - pair[0][0])
    })
    .collect()
}

#[test]
fn axes_may_be_exchanged() {
    // Next to the bottom of the fan, between rows of a coarse look: thin stripes, steep one way and flat the other.
    let scene = |x: &str, y: &str| {
        let text = format!(
            "[model]\nsites = 21\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\nx = {{ parameter = {x}, points = 30 }}\n\
             y = {{ parameter = {y}, points = 20 }}\n[compute]\nfamilies = [\"double-sided\"]\nstability = true\n"
        );
        Scene::parse(Path::new("scene.toml"), &text).unwrap()
    };
    let ranges = ["\"omega\", from = 1.3, to = 1.35", "\"gamma2\", from = 0.03, to = 0.07"];
    let [one, other] = [[0, 1], [1, 0]].map(|[x, y]| borders(&scene(ranges[x], ranges[y])));
    assert!(one.0.stripes() >= 4 && one.0.unexplained.is_empty() && other.0.unexplained.is_empty());
    let area = |(_, regions): &(Borders, Regions<Option<Class>>), class: Class| {
        regions
            .areas()
            .iter()
            .find(|area| area.class == Some(class))
            .map_or((0.0, 0.0), |area| (area.share, area.error))
    };
    for class in [Class::StableDouble, Class::UnstableDouble] {
        let (a, b) = (area(&one, class), area(&other, class));
        assert!(a.0 > 0.01 && (a.0 - b.0).abs() <= a.1 + b.1, "{class:?}: {a:?} {b:?}");
    }
}

#[test]
fn a_search_that_is_stopped_says_so() {
    let scene = scene(6, "", BOTH, [60, 45]);
    for last in [Stage::Changes, Stage::Faces] {
        let flag = Arc::new(AtomicBool::new(false));
        let stop = Stop::from(&flag);
        let told = |_: &str, stage: Stage, done: usize, _: usize| {
            if stage == last && (done > 0 || stage == Stage::Faces) {
                flag.store(true, Ordering::Relaxed);
            }
        };
        let asked = BorderRequest { tolerance: TOLERANCE, places: PLACES, special: false, stop: &stop, told: &told };
        let (found, _) = Borders::of_scene(&scene, &asked).unwrap();
        assert!(found.interrupted && !found.borders.is_empty());
    }
}

#[test]
fn windows_without_borders_to_follow_are_refused() {
    let stop = Stop::default();
    let refused = |text: &str, tolerance: f64| {
        let scene = Scene::parse(Path::new("scene.toml"), text).unwrap();
        let asked = BorderRequest { tolerance, places: 1000, special: false, stop: &stop, told: &|_, _, _, _| {} };
        Borders::of_scene(&scene, &asked).unwrap_err().to_string()
    };
    let model = "[model]\nsites = 6\ngamma1 = 0.2\ngamma2 = 0.1\nasymmetry = 0.4\n[compute]\nfamilies = [\"double-sided\"]\n[sweep]\n";
    let line = format!("{model}axes = [{{ parameter = \"omega\", from = 1, to = 2, points = 5 }}]");
    assert!(refused(&line, 1e-6).contains("give x and y"));
    let model = model.replace("gamma2 = 0.1\n", "");
    let plane = format!(
        "{model}x = {{ parameter = \"omega\", from = 1, to = 2, points = 5 }}\n\
         y = {{ parameter = \"gamma2\", from = 0.01, to = 1, points = 5, spacing = \"log\" }}"
    );
    assert!(refused(&plane, 1e-6).contains("equally spaced"));
    let plane = plane.replace(", spacing = \"log\"", "");
    assert!(refused(&plane, 0.5).contains("give a part of the window"));
}

#[test]
#[ignore = "slow, a minute: cargo test --workspace --test borders -- --ignored slow"]
fn slow_a_hundred_thousand_points_have_the_class_of_their_region() {
    for sites in [6, 11, 21] {
        let scene = scene(sites, "", BOTH, [400, 300]);
        let (found, _) = searched(&scene, 400_000);
        let regions = fine(&scene, &found);
        let (differing, compared) = exceptions(&scene, &regions, 1e-8, 100_000);
        eprintln!("{sites}: {} borders, {compared} points, {differing:?}", found.borders.len());
        // A piece of 3 in 400 000 that lacks its border escapes one search in twenty, and holds one of these points at most.
        assert!(found.unexplained.is_empty() && differing.len() <= 2 && compared > 99_900, "{sites}: {differing:?}");
    }
}
