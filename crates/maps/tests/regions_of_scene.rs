//! The regions of a map of the paper, with borders as crude as cells give them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::path::Path;

use fastrand::Rng;
use vibrochain_maps::cell::{Class, Worker};
use vibrochain_maps::regions::{Regions, Subdivision, Window};
use vibrochain_maps::scene::Scene;

type Place = [f64; 2];

/// The place between two points of different class where it changes.
fn change(class: &mut impl FnMut(Place) -> Option<Class>, mut from: Place, mut to: Place) -> Place {
    let first = class(from);
    for _ in 0..32 {
        let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
        if class(middle) == first { from = middle } else { to = middle }
    }
    to
}

/// Borders through the changes along rows and columns of a grid: in each mesh of it two changes are joined, more meet in the middle.
fn contours(class: &mut impl FnMut(Place) -> Option<Class>, columns: usize, rows: usize) -> Vec<Vec<Place>> {
    let place = |i: usize, j: usize| [i as f64 / columns as f64, j as f64 / rows as f64];
    let corners: Vec<Vec<Option<Class>>> =
        (0..=rows).map(|j| (0..=columns).map(|i| class(place(i, j))).collect()).collect();
    let mut borders = Vec::new();
    for j in 0..rows {
        for i in 0..columns {
            let around = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let mut met = Vec::new();
            for k in 0..4 {
                // From the lower left end, so that both neighbours find the same.
                let (one, two) = (around[k].min(around[(k + 1) % 4]), around[k].max(around[(k + 1) % 4]));
                if corners[one.1][one.0] != corners[two.1][two.0] {
                    met.push(change(class, place(one.0, one.1), place(two.0, two.1)));
                }
            }
            match met.as_slice() {
                [] => {}
                [one, two] => borders.push(vec![*one, *two]),
                more => {
                    let middle = [0, 1].map(|k| more.iter().map(|place| place[k]).sum::<f64>() / more.len() as f64);
                    borders.extend(more.iter().map(|place| vec![*place, middle]));
                }
            }
        }
    }
    borders
}

/// Regions from contours of cells: how many of `points` random points have another class than their region, and the regions.
fn wrong(scene: &Scene, points: usize) -> (usize, Regions<Option<Class>>) {
    let window = Window::of(scene).unwrap();
    let mut worker = Worker::new(scene.base.sites());
    let mut class = |part: Place| {
        let model = scene.at(&window.point(part)).model().unwrap();
        worker.cell(&model, &scene.task).class
    };
    let borders = contours(&mut class, 130, 90);
    assert!(borders.len() > 200, "{}", borders.len());
    let points_of = |border: Vec<Place>| border.into_iter().map(|part| window.point(part)).collect();
    let borders: Vec<Vec<Place>> = borders.into_iter().map(points_of).collect();
    let subdivision = Subdivision::new(window, &borders, 1e-6).unwrap();
    let regions = subdivision.classified(
        2000,
        || Worker::new(scene.base.sites()),
        |worker, point| worker.cell(&scene.at(&point).model().unwrap(), &scene.task).class,
    );

    let mut random = Rng::with_seed(6);
    let (mut wrong, mut count) = (0, [0_u32; Class::ALL.len()]);
    for _ in 0..points {
        let part = [random.f64(), random.f64()];
        let found = class(part);
        wrong += usize::from(regions.at(window.point(part)) != Some(&found));
        if let Some(class) = found {
            count[class as usize] += 1;
        }
    }
    let mut held = 0;
    for area in regions.areas() {
        let share = area.class.map_or(0.0, |class| f64::from(count[class as usize]) / points as f64);
        // Four standard deviations of a count.
        let spread = 4.0 * (share * (1.0 - share) / points as f64).sqrt();
        assert!((area.share - share).abs() <= area.error + spread + 1e-3, "{area:?} {share}");
        held += usize::from(share > 0.0);
    }
    assert!(held >= 3, "{held}");
    (wrong, regions)
}

fn scene(stability: bool) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/conservative-n5.toml");
    let mut scene = Scene::read(&path).unwrap();
    scene.task.stability = stability;
    scene
}

#[test]
fn regions_of_existence_are_what_cells_are() {
    let (wrong, regions) = wrong(&scene(false), 5000);
    // Chords across meshes of a hundredth of the window are that crude.
    assert!(wrong <= 25, "{wrong}");
    let unexplained: f64 = regions.unexplained().iter().map(|face| face.share).sum();
    let most = regions.areas()[0].share;
    assert!(most > 0.5 && regions.regions().len() < 30, "{most} {unexplained} {}", regions.regions().len());
}

#[test]
fn stripes_that_cells_have_missed_are_told_as_unexplained() {
    let (wrong, regions) = wrong(&scene(true), 5000);
    assert!(wrong <= 100, "{wrong}");
    // Stripes run through the large region of stable double-sided breathers, and most of their length is in no mesh's corner.
    let face = &regions.unexplained()[0];
    let classes = [Class::StableDouble, Class::UnstableDouble];
    assert!(face.share > 0.5);
    assert!(classes.iter().all(|wanted| face.points.iter().any(|(_, found)| *found == Some(*wanted))));
    // Stability costs more borders than existence.
    assert!(regions.regions().len() > 20);
}
