//! Cells of shipped maps: the same class, number of orbits, spectral radius and margin.

use std::fs;
use std::path::Path;

use vibrochain_lattice::Stop;
use vibrochain_maps::cell::{Cell, Status};
use vibrochain_maps::grid::{Files, Grid};
use vibrochain_maps::scene::Scene;
use vibrochain_maps::structure::StructureScene;

/// All cells of a scene, with the classes that pictures and summaries name.
fn cells<S: Grid>(text: &str) -> Vec<Cell> {
    let scene = S::parse(Path::new("scene.toml"), text, &Files::new()).unwrap();
    let (stop, mut cells) = (Stop::default(), Vec::new());
    scene.compute(&mut scene.worker(&stop), 0..scene.cells(), &stop, &mut cells).unwrap();
    cells.iter().map(|cell| scene.shown(cell)).collect()
}

/// The scene with so many points along each axis.
fn coarse(text: &str, points: usize) -> String {
    let line = |line: &str| match line.split_once("points = ") {
        Some((head, tail)) => {
            format!("{head}points = {points}{}", tail.trim_start_matches(|c: char| c.is_ascii_digit()))
        }
        None => line.to_owned(),
    };
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn cells_of_shipped_maps_are_those_of_structures() {
    let (mut live, mut stable) = (0, 0);
    for (name, points) in [
        ("conservative-n10", 23),
        ("forced-n20", 15),
        ("structures/damped-n20", 15),
        ("restitution-n20", 13),
        ("single-sided", 141),
    ] {
        let text = fs::read_to_string(format!("scenes/{name}.toml")).unwrap();
        let text = coarse(&text, points);
        // A key that lattices do not have makes it a structure.
        let as_structure = text.replace("[model]\n", "[model]\nstatic_force = 0\n");
        let (chain, other) = (cells::<Scene>(&text), cells::<StructureScene>(&as_structure));
        assert_eq!(chain.len(), other.len());
        for (number, (one, two)) in chain.iter().zip(&other).enumerate() {
            let told = format!("{name} {number}: {one:?} {two:?}");
            assert_eq!((one.status, two.status), (Status::Ok, Status::Ok), "{told}");
            let parts = |cell: &Cell| cell.class.map(|class| class.parts().map(|(_, stable)| stable));
            assert_eq!((parts(one), one.solutions), (parts(two), two.solutions), "{told}");
            // A structure's classes are those of the first word and the second.
            assert!(name == "single-sided" || one.class == two.class, "{told}");
            for [a, b] in [[one.spectral_radius, two.spectral_radius], [one.margin, two.margin]] {
                assert_eq!(a.is_some(), b.is_some(), "{told}");
                assert!(a.zip(b).is_none_or(|(a, b)| (a - b).abs() < 1e-11 * (1.0 + a.abs())), "{told}");
            }
            live += usize::from(one.solutions > 0);
            stable += usize::from(parts(one) == Some(Some(Some(true))));
        }
    }
    assert!(live > 700 && stable > 400, "{live} {stable}");
}
