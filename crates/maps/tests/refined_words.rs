//! Refined maps of impact words against all cells of the finest grid: no region bounded by loss of stability alone is missing.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::path::Path;

use rayon::ThreadPoolBuilder;
use vibrochain_lattice::Stop;
use vibrochain_maps::cell::{Cell, Class};
use vibrochain_maps::scene::Scene;
use vibrochain_maps::sweep::{Ended, Job, refined, sweep};

/// Columns and rows of the finest grid.
const SIZE: [usize; 2] = [160, 120];

fn scene(model: &str, word: &str) -> Scene {
    let text = format!(
        "[model]\ngamma1 = 0.2\nasymmetry = 0.2\n{model}\n[sweep]\n\
         x = {{ parameter = \"omega\", from = 0.7, to = 2.5, points = 20 }}\n\
         y = {{ parameter = \"gamma2\", from = 0.002, to = 0.2, points = 15 }}\n\
         refine = {{ depth = 3 }}\n[compute]\nfamilies = [{word}]\nstability = true\n"
    );
    Scene::parse(Path::new("scene.toml"), &text).unwrap()
}

/// The classes of all cells, by rows, from leaves and one by one; and how many leaves there are.
fn classes(scene: &Scene) -> ([Vec<Option<Class>>; 2], usize) {
    let (pool, stop) = (ThreadPoolBuilder::new().num_threads(2).build().unwrap(), Stop::default());
    let (mut leaves, mut painted) = (0, vec![None; SIZE[0] * SIZE[1]]);
    let paint = |some: &[(u64, Cell)]| {
        for (_, cell) in some {
            let extent = cell.extent.unwrap();
            leaves += 1;
            for row in extent.row..extent.row + extent.size {
                let first = row as usize * SIZE[0] + extent.column as usize;
                painted[first..first + extent.size as usize].fill(cell.class);
            }
        }
        Ok::<_, ()>(())
    };
    let parts = std::iter::once(0..scene.cells()).collect::<Vec<_>>();
    assert!(matches!(refined(&Job { scene, pool: &pool, stop: &stop }, &parts, |_| {}, paint), Ended::Complete(_)));
    let mut all = Vec::new();
    let keep = |_, cells: &[Cell]| {
        all.extend(cells.iter().map(|cell| cell.class));
        Ok::<_, ()>(())
    };
    assert!(matches!(sweep(&scene.finest(), &pool, &stop, |_| {}, keep), Ended::Complete(_)));
    ([painted, all], leaves)
}

fn neighbours(cell: usize) -> impl Iterator<Item = usize> {
    let (column, row) = (cell % SIZE[0], cell / SIZE[0]);
    let (columns, rows) =
        (column.saturating_sub(1)..=(column + 1).min(SIZE[0] - 1), row.saturating_sub(1)..=(row + 1).min(SIZE[1] - 1));
    rows.flat_map(move |row| columns.clone().map(move |column| row * SIZE[0] + column))
}

/// Cells of one class that touch each other, and the classes round them.
struct Region {
    class: Option<Class>,
    cells: Vec<usize>,
    round: Vec<Option<Class>>,
}

fn regions(all: &[Option<Class>]) -> Vec<Region> {
    let (mut seen, mut found) = (vec![false; all.len()], Vec::new());
    for start in 0..all.len() {
        if std::mem::replace(&mut seen[start], true) {
            continue;
        }
        let (mut cells, mut round, mut next) = (vec![start], Vec::new(), 0);
        while let Some(&cell) = cells.get(next) {
            next += 1;
            for other in neighbours(cell) {
                if all[other] != all[start] {
                    round.push(all[other]);
                } else if !std::mem::replace(&mut seen[other], true) {
                    cells.push(other);
                }
            }
        }
        found.push(Region { class: all[start], cells, round });
    }
    found
}

#[test]
fn every_stripe_and_band_of_the_full_map_is_in_the_refined_one() {
    let (mut thin, mut leaves, mut cells) = (0, 0, 0);
    for (model, word) in [
        ("sites = 6", "\"0+1+,0-1-\""),
        ("sites = 10", "\"0+3+,0-3-\""),
        ("sites = 21", "\"0+1+,0-1-\""),
        ("sites = 5\nends = \"free\"", "\"0+1+,0-1-\""),
        ("sites = 8\nends = \"free\"", "\"3-4-\""),
        ("sites = 4\nlayers = 2\ngamma3 = 0.05", "\"0:0+0:1+,0:0-0:1-\""),
        ("sites = 6", "\"double-sided\", \"0+1+,0-1-\""),
    ] {
        let ([painted, all], count) = classes(&scene(model, word));
        (leaves, cells) = (leaves + count, cells + all.len());
        for Region { class, cells: region, round } in regions(&all) {
            // A thin band of existence has no stripe at its edge.
            if class.is_none()
                || class == Some(Class::None)
                || round.contains(&Some(Class::None))
                || round.contains(&None)
            {
                continue;
            }
            assert!(region.iter().any(|&cell| painted[cell] == class), "{model} {word}: {class:?} {region:?}");
            thin += usize::from(region.len() < 64);
        }
    }
    // Smaller than a cell of the grid, and there; and it is worth it.
    println!("{thin} thin regions, {leaves} leaves for {cells} cells");
    assert!(thin > 50 && leaves < cells / 3, "{thin} {leaves} {cells}");
}
