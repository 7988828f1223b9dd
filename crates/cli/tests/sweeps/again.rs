//! A manifest is a scene: it makes the same table once more, bit by bit, and the same manifest.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::Value;
use vibrochain_testkit::{Random, Schema, TestDir};

/// The scene with so many values at most along each axis.
fn small(text: &str, most: u64) -> String {
    let mut scene: toml::Table = text.parse().unwrap();
    let sweep = scene["sweep"].as_table_mut().unwrap();
    let axes = sweep.iter_mut().flat_map(|(_, axis)| match axis {
        toml::Value::Array(axes) => axes.iter_mut().collect(),
        axis => vec![axis],
    });
    for axis in axes {
        if let Some(points) = axis.get_mut("points") {
            *points = points.as_integer().unwrap().min(most as i64).into();
        }
    }
    toml::to_string(&scene).unwrap()
}

/// What a manifest tells of a run and not of the table.
const OF_THE_RUN: [&str; 3] = ["scene", "threads", "wall_seconds"];

/// The table of a scene, once more of its manifest, and of the scene as JSON; and the manifest.
fn thrice(text: &str) -> Value {
    let dir = TestDir::with_scene(text);
    let scene: Value = toml::from_str(text).unwrap();
    Schema::named("scene").check(&scene).unwrap();
    fs::write(dir.path("scene.json"), scene.to_string()).unwrap();
    dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
    let told = |name: &str| {
        let mut manifest = dir.json(name);
        OF_THE_RUN.iter().for_each(|key| drop(manifest.as_object_mut().unwrap().remove(*key)));
        manifest
    };
    let (table, manifest) = (dir.read("map.csv"), told("map.manifest.json"));
    for (scene, threads) in [("map.manifest.json", 1), ("scene.json", 2), ("again.manifest.json", 2)] {
        // The last one is the manifest of a manifest.
        let out = if scene == "again.manifest.json" { "last" } else { "again" };
        dir.run(&format!("sweep {scene} --out {out}.csv --threads {threads} --quiet")).with(0, &[]);
        assert!(dir.read(&format!("{out}.csv")) == table, "{scene} of {text}");
        assert_eq!(told(&format!("{out}.manifest.json")), manifest, "{scene} of {text}");
    }
    manifest
}

#[test]
fn every_scene_that_comes_with_the_program_comes_back_from_its_manifest() {
    let (mut scenes, mut kinds) = (0, BTreeSet::new());
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            let text = fs::read_to_string(&path).unwrap();
            let manifest = thrice(&small(&text, 5));
            let file = path.file_stem().unwrap().to_string_lossy().into_owned();
            kinds.insert(file.split('-').next().unwrap().to_owned());
            assert!(manifest["cells"].as_u64().unwrap() >= 5, "{file}");
            scenes += 1;
        }
    }
    assert!(scenes >= 14 && kinds.len() >= 6, "{scenes} {kinds:?}");
}

/// Everything that a scene may have, with numbers of all digits: axes of each kind, up to three, lists, logarithms, words, thresholds,
/// layers, ends, harmonics, collisions.
#[test]
fn scenes_at_random_come_back_from_their_manifests() {
    let mut random = Random(17);
    let mut had = BTreeSet::new();
    for number in 0..30 {
        let text = scene(&mut random, number);
        let manifest = thrice(&text);
        let written = manifest.to_string();
        for key in [
            "\"values\"",
            "\"spacing\"",
            "\"axes\"",
            "\"layers\"",
            "\"ends\"",
            "\"force\"",
            "\"phase\"",
            "\"collisions\"",
            "0+2+,0-2-",
            "double-sided-symmetric",
            "\"threshold\":0.",
            "\"threshold\":null",
            "\"title\":null",
        ] {
            if written.contains(key) {
                had.insert(key);
            }
        }
    }
    assert_eq!(had.len(), 13, "{had:?}");
}

/// A scene of some cells: which kind of lattice, force, axes and task goes by its number.
fn scene(random: &mut Random, number: usize) -> String {
    let layered = number % 5 == 3;
    let forced = number % 3;
    let mut model = String::from("sites = 5\n");
    if layered {
        model += "layers = 2\n";
    }
    if number % 4 == 1 {
        model += "ends = \"free\"\n";
    }
    if forced > 0 {
        model += &format!("restitution = {:?}\n", random.between(0.3, 0.99));
    }
    if forced == 2 {
        let (one, three, phase) = (random.between(0.05, 0.3), random.between(-0.05, 0.05), random.between(-3.0, 3.0));
        model += &format!(
            "force = [{{ harmonic = 1, amplitude = {one:?} }}, {{ harmonic = 3, amplitude = {three:?}, phase = {phase:?} }}]\n"
        );
    }
    // What may vary, and its range; by turns it is fixed or an axis.
    let mut ranges = vec![("omega", 0.7, 2.5), ("asymmetry", 0.05, 0.9), ("gamma2", 1e-3, 0.2), ("gamma1", 0.1, 0.5)];
    if forced == 1 {
        ranges.push(("amplitude", 0.05, 0.5));
    }
    if layered {
        ranges.push(("gamma3", 0.01, 0.1));
    }
    let count = 1 + number % 3;
    ranges.rotate_left(number % 4);
    let mut axes = Vec::new();
    for (i, (name, low, high)) in ranges.into_iter().enumerate() {
        let (a, b) = (random.between(low, 0.5 * (low + high)), random.between(0.5 * (low + high), high));
        if i >= count {
            model += &format!("{name} = {a:?}\n");
            continue;
        }
        let values = match (number + i) % 3 {
            0 => format!("from = {a:?}, to = {b:?}, points = 3"),
            1 => format!("from = {a:?}, to = {b:?}, points = 3, spacing = \"log\""),
            _ => format!("values = [{b:?}, {a:?}]"),
        };
        axes.push(format!("{{ parameter = \"{name}\", {values} }}"));
    }
    let sweep = match axes.as_slice() {
        [x] => format!("x = {x}\n"),
        [x, y] => format!("x = {x}\ny = {y}\n"),
        [x, y, rest @ ..] => format!("x = {x}\ny = {y}\naxes = [{}]\n", rest.join(", ")),
        [] => String::new(),
    };
    let task = match (number % 7, forced) {
        (2, _) => "families = [\"0+2+,0-2-\", \"single-sided\"]\nstability = true\n".to_owned(),
        (4, 0) => "families = [\"double-sided-symmetric\"]\nstability = true\ncollisions = true\n".to_owned(),
        (5, _) => "families = [\"double-sided\"]\n".to_owned(),
        (6, _) => {
            format!("families = [\"double-sided\"]\nstability = true\nthreshold = {:?}\n", random.between(1e-3, 0.1))
        }
        _ => "families = [\"single-sided\", \"double-sided\"]\nstability = true\n".to_owned(),
    };
    let title = if number.is_multiple_of(2) { format!("title = \"scene {number}, 'γ₁'\"\n") } else { String::new() };
    format!("{title}[model]\n{model}[sweep]\n{sweep}[compute]\n{task}")
}
