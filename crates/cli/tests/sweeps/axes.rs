//! Sweeps over any number of axes, and what they would cost.

use vibrochain_testkit::{SCENE, TestDir, undisturbed};

const MODEL: &str = "[model]\nsites = 5\ngamma1 = 0.2\n";

const COMPUTE: &str = "[compute]\nfamilies = [\"double-sided\", \"single-sided\"]\n";

const OMEGA: &str = r#"{ parameter = "omega", from = 0.5, to = 2.5, points = 5 }"#;
const GAMMA2: &str = r#"{ parameter = "gamma2", values = [0.3, 0, 0.1] }"#;
const ASYMMETRY: &str = r#"{ parameter = "asymmetry", from = 0.01, to = 0.64, points = 4, spacing = "log" }"#;

/// Columns and rows of the table of a sweep.
fn table(sweep: &str, model: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let dir = TestDir::with_scene(&format!("{MODEL}{model}[sweep]\n{sweep}\n{COMPUTE}"));
    dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
    let mut reader = csv::Reader::from_path(dir.path("map.csv")).unwrap();
    let words = |record: &csv::StringRecord| record.iter().map(str::to_owned).collect::<Vec<_>>();
    let columns = words(reader.headers().unwrap());
    (columns, reader.records().map(|record| words(&record.unwrap())).collect())
}

#[test]
fn every_axis_has_a_column_and_x_is_the_fastest() {
    let (columns, rows) = table(&format!("x = {OMEGA}\ny = {GAMMA2}\naxes = [{ASYMMETRY}]"), "");
    assert_eq!(columns[..4], ["gamma2", "omega", "asymmetry", "class"]);
    assert_eq!(rows.len(), 60);
    let [omega, gamma2] = [[0.5, 1.0, 1.5, 2.0, 2.5].as_slice(), &[0.3, 0.0, 0.1]];
    for (number, row) in rows.iter().enumerate() {
        let value = |column: usize| row[column].parse::<f64>().unwrap();
        // 0.01, 0.04, 0.16, 0.64: each four times the one before.
        let asymmetry = 0.01 * 4f64.powi((number / 15) as i32);
        assert_eq!((value(1), value(0)), (omega[number % 5], gamma2[number / 5 % 3]));
        assert!((value(2) / asymmetry - 1.0).abs() < 1e-14);
    }
    // The list of axes says the same, and each cell is that of a smaller sweep.
    assert_eq!(table(&format!("axes = [{OMEGA}, {GAMMA2}, {ASYMMETRY}]"), ""), (columns, rows.clone()));
    let (columns, plane) = table(&format!("x = {OMEGA}\ny = {GAMMA2}"), "asymmetry = 0.64\n");
    assert_eq!(columns[..3], ["gamma2", "omega", "class"]);
    for (cell, row) in plane.iter().zip(&rows[45..]) {
        assert_eq!((&cell[..2], &cell[2..]), (&row[..2], &row[3..]));
    }
}

#[test]
fn one_axis_and_six_are_sweeps_as_well() {
    let (columns, rows) = table(&format!("x = {OMEGA}"), "gamma2 = 0.1\nasymmetry = 0.4\n");
    assert_eq!((columns[0].as_str(), rows.len()), ("gamma2", 5));
    let pair = |name: &str, low: f64, high: f64| format!("{{ parameter = \"{name}\", values = [{high}, {low}] }}");
    let axes = [
        pair("omega", 1.0, 1.5),
        pair("asymmetry", 0.1, 0.4),
        pair("gamma2", 0.05, 0.1),
        pair("gamma1", 0.2, 0.3),
        pair("amplitude", 0.05, 0.1),
        pair("restitution", 0.8, 0.9),
    ];
    let text = format!("[model]\nsites = 5\n[sweep]\naxes = [{}]\n{COMPUTE}", axes.join(",\n"));
    let dir = TestDir::with_scene(&text);
    dir.run("sweep scene.toml --out map.csv").with(0, &["64 cells (2 × 2 × 2 × 2 × 2 × 2)"]);
    let table = String::from_utf8(dir.read("map.csv")).unwrap();
    assert!(table.starts_with("gamma2,omega,restitution,amplitude,gamma1,asymmetry,class,"));
    assert!(table.lines().nth(1).unwrap().starts_with("0.1,1.5,0.9,0.1,0.3,0.4,"));
    assert!(table.lines().nth(64).unwrap().starts_with("0.05,1,0.8,0.05,0.2,0.1,"));
    assert_eq!(dir.json("map.manifest.json")["sweep"]["axes"][3]["values"], serde_json::json!([0.9, 0.8]));
}

#[test]
fn a_scene_that_leaves_asymmetric_orbits_out_says_where_they_could_be() {
    // A point with a pair of stable orbits of φ ≠ T/2, and one that every mode is slower than.
    let text = |family: &str| {
        format!(
            "[model]\nsites = 6\ngamma1 = 0.2790465016543734\ngamma2 = 0.13606569615937517\nasymmetry = 0\n[sweep]\n\
             x = {{ parameter = \"omega\", values = [0.3456359754617771, 1.5] }}\n\
             [compute]\nfamilies = [\"{family}\"]\nstability = true\n"
        )
    };
    let rows = |family: &str| {
        let dir = TestDir::with_scene(&text(family));
        dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
        assert_eq!(dir.json("map.manifest.json")["compute"]["families"], serde_json::json!([family]));
        let table = String::from_utf8(dir.read("map.csv")).unwrap();
        table.lines().skip(1).map(str::to_owned).collect::<Vec<_>>()
    };
    let (all, symmetric) = (rows("double-sided"), rows("double-sided-symmetric"));
    assert!(all[0].contains(",stable-double,") && all[0].ends_with(",2,ok"), "{all:?}");
    assert!(symmetric[0].contains(",none,") && symmetric[0].ends_with(",0,incomplete"), "{symmetric:?}");
    assert!(all[1] == symmetric[1] && all[1].ends_with(",1,ok"), "{all:?} {symmetric:?}");
}

#[test]
fn wrong_axes() {
    let long = ["1e-3"; 3].join(", ");
    for (sweep, told) in [
        (String::new(), "[sweep] has no axis: give x and y"),
        (format!("y = {OMEGA}"), "y is given without x: x is the fastest axis"),
        (format!("x = {OMEGA}\naxes = [{OMEGA}]"), "omega is swept twice: give different parameters"),
        (r#"x = { parameter = "omega" }"#.into(), "omega has no values yet: give from, to and points, or values"),
        (r#"x = { parameter = "omega", from = 1, to = 2 }"#.into(), "omega has no values yet"),
        (r#"x = { parameter = "omega", values = [] }"#.into(), "values has 0 numbers: give 1 to 1000000"),
        (r#"x = { parameter = "omega", values = [1, 2, 1.0] }"#.into(), "7:44: 1 is listed twice"),
        (format!("x = {{ parameter = \"omega\", values = [{long}] }}"), "0.001 is listed twice"),
        (r#"x = { parameter = "omega", values = [1, nan] }"#.into(), "NaN is out of range: give finite values"),
        (r#"x = { parameter = "omega", values = [1, 0] }"#.into(), "7:41: omega = 0 is out of range: give a positive"),
        (r#"x = { parameter = "omega", values = [1, 2], points = 2 }"#.into(), "values is given as well"),
        (r#"x = { parameter = "omega", values = [1, 2], spacing = "log" }"#.into(), "values is given as well"),
        (
            r#"x = { parameter = "omega", from = 1, to = 2, points = 3, spacing = "logarithmic" }"#.into(),
            "`logarithmic` is not a spacing: give \"linear\" or \"log\"",
        ),
        (
            r#"x = { parameter = "gamma2", from = 0, to = 2, points = 3, spacing = "log" }"#.into(),
            "from = 0 has no logarithm: give a positive one",
        ),
        (
            ["omega", "amplitude", "restitution"]
                .iter()
                .map(|name| format!("{{ parameter = \"{name}\", from = 0.1, to = 0.2, points = 1000000 }}"))
                .collect::<Vec<_>>()
                .join(",\n")
                .replacen('{', "axes = [{", 1)
                + "]",
            "the axes have more than 1000000000000 cells together",
        ),
    ] {
        let dir = TestDir::with_scene(&format!("{MODEL}gamma2 = 0.1\nasymmetry = 0.4\n[sweep]\n{sweep}\n{COMPUTE}"));
        dir.run("sweep scene.toml --out map.csv").with(2, &[told, "scene.toml:"]);
        assert_eq!(dir.names("."), ["scene.toml"]);
    }
}

#[test]
fn pictures_have_axes_of_any_spacing_but_no_third() {
    let three = format!("{MODEL}[sweep]\nx = {OMEGA}\ny = {GAMMA2}\naxes = [{ASYMMETRY}]\n{COMPUTE}");
    let dir = TestDir::with_scene(&three);
    let told = "pictures have one or two axes, here are 3, omega, gamma2 and asymmetry";
    dir.run("sweep scene.toml --out map.csv --png map.png").with(2, &[told]);
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    dir.run("merge parts --out map.csv --svg map.svg").with(2, &[told]);
    assert_eq!(dir.names("."), ["parts", "scene.toml"]);

    let dir = TestDir::with_scene(&format!("{MODEL}omega = 1.5\n[sweep]\nx = {ASYMMETRY}\ny = {GAMMA2}\n{COMPUTE}"));
    dir.run("sweep scene.toml --out map.csv --svg map.svg --quiet").with(0, &[]);
    let svg = String::from_utf8(dir.read("map.svg")).unwrap();
    // Values of the list, in its order from the bottom up; decades of the logarithmic axis.
    let texts: Vec<String> = vibrochain_testkit::svg::texts(&svg).into_iter().map(|(_, text)| text).collect();
    for text in ["0.3", "0", "0.1", "0.01", "asymmetry a", "coupling stiffness γ₂"] {
        assert!(texts.iter().any(|one| one == text), "{text} not in {texts:?}");
    }
}

/// A thousand million cells.
fn enormous() -> String {
    let axis = |name: &str, from: f64, to: f64, points: u64| {
        format!("{{ parameter = \"{name}\", from = {from}, to = {to}, points = {points} }}")
    };
    let axes = [axis("omega", 0.5, 2.5, 100_000), axis("gamma2", 0.0, 0.3, 1000), axis("asymmetry", 0.1, 0.9, 10)];
    format!("{MODEL}[sweep]\naxes = [{}]\n{COMPUTE}", axes.join(", "))
}

#[test]
fn a_dry_run_tells_what_a_sweep_costs_and_writes_nothing() {
    let dir = TestDir::with_scene(&enormous());
    let ran = dir.run("sweep scene.toml --dry-run --threads 2").with(0, &[]);
    for told in [
        "cells    1000000000 (100000 × 1000 × 10)",
        "chunks   30518 of 32768 cells",
        "columns  gamma2, omega, asymmetry, class, mechanism, spectral_radius, margin, solutions, status",
        " on 2 threads, ",
        "GB for the table",
        "sample   ",
    ] {
        assert!(ran.out.contains(told), "no `{told}` in {}", ran.out);
    }
    let ran = dir.run("sweep scene.toml --dry-run --out map.csv --shard 5/1000 --threads 1").with(0, &[]);
    assert!(ran.out.contains("shard    5/1000: 31 chunks, 1015808 cells"), "{}", ran.out);
    assert_eq!(dir.names("."), ["scene.toml"]);
    // What it says of a table's size is near what the table has.
    let dir = TestDir::with_scene(SCENE);
    let ran = dir.run("sweep scene.toml --dry-run").with(0, &[]);
    let words = ran.out.split_once("disk     about ").unwrap().1;
    let told: f64 = words.split_once(" MB").unwrap().0.parse().unwrap();
    let bytes = undisturbed(SCENE).len() as f64;
    assert!((told * 1e6 / bytes - 1.0).abs() < 0.15, "{told} {bytes}");
}

/// Address space, of which memory is a part, is limited: what a table of a thousand million cells would take is not there.
#[cfg(target_os = "linux")]
#[test]
fn a_thousand_million_cells_are_begun_and_left_in_little_memory() {
    let dir = TestDir::with_scene(&enormous());
    let limited = |line: &str| format!("export MALLOC_ARENA_MAX=1; ulimit -v 160000; exec mapgen {line} --threads 2");
    dir.shell(&limited("sweep scene.toml --dry-run")).with(0, &[]);
    let timed = limited("sweep scene.toml --out map.csv").replace("exec mapgen", "timeout -s TERM 1 mapgen");
    // `timeout` answers 124 for what it had to stop.
    dir.shell(&timed).with(124, &[" of 30518 chunks are finished, in map.csv.parts; go on with: "]);
    assert!(dir.chunks("map.csv.parts") > 0);
    // Beside them the plan and the lock, and nothing half-written.
    assert_eq!(dir.chunks("map.csv.parts") + 2, dir.names("map.csv.parts").len());
}
