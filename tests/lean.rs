//! A map pays only for what it asks: allocations of a cell in steady state, which `cargo test --test lean -- --nocapture` prints.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::hint::black_box;
use std::path::Path;

use allocation_counter::measure;
use vibrochain_maps::cell::Worker;
use vibrochain_maps::scene::Scene;
use vibrochain_testkit::paper_map;

/// A kind of map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Kind {
    forced: bool,
    stability: bool,
}

const KINDS: [Kind; 4] = [
    Kind { forced: false, stability: false },
    Kind { forced: false, stability: true },
    Kind { forced: true, stability: false },
    Kind { forced: true, stability: true },
];

impl Kind {
    fn name(self) -> String {
        let model = if self.forced { "forced" } else { "conservative" };
        format!("{model}, {}", if self.stability { "stability" } else { "existence" })
    }

    /// The paper's map on a coarser grid.
    fn scene(self) -> Scene {
        let text = paper_map(21, self.forced, [40, 24], self.stability);
        Scene::parse(Path::new("lean"), &text).unwrap()
    }

    /// Computes every cell of the scene.
    fn compute(scene: &Scene, worker: &mut Worker) {
        for cell in 0..scene.cells() {
            black_box(worker.cell(&scene.point(cell).model().unwrap(), &scene.task));
        }
    }

    /// Allocations a cell once the work space has seen the whole map; twice, since the motions of the last two orbits take turns in two
    /// work spaces, each of which must have held the largest.
    fn allocations(self) -> f64 {
        let scene = self.scene();
        let mut worker = Worker::new(scene.base.sites());
        Self::compute(&scene, &mut worker);
        Self::compute(&scene, &mut worker);
        measure(|| Self::compute(&scene, &mut worker)).count_total as f64 / scene.cells() as f64
    }
}

#[test]
fn conservative_existence_allocates_nothing_and_no_cell_more_than_is_told() {
    // Measured: 0, 2.917, 35.559 and 57.431. The eigenvalue solver, the search among orbits of a structure, and J(z) of every orbit under a force take
    // their work space anew for each: four percent of a forced map's instructions.
    for (kind, most) in KINDS.into_iter().zip([0.0, 3.0, 36.0, 59.0]) {
        let allocations = kind.allocations();
        println!("{}: {allocations:.3} allocations a cell", kind.name());
        assert!(allocations <= most, "{}: {allocations} allocations a cell, at most {most}", kind.name());
    }
}
