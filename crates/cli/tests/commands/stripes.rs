//! `mapgen stripes`, and the columns of collisions on a map.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
#[cfg(unix)]
use vibrochain_testkit::signal;
use vibrochain_testkit::{STRIPES_SCENE, TestDir, mapgen, output, printed_numbers, written};

/// Rows of a table, by column.
fn table(path: &Path) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} of {row:?}"))
}

fn stripes(dir: &TestDir, scene: &Path, out: &str) -> assert_cmd::assert::Assert {
    mapgen(&["stripes"]).arg(scene).arg("--out").arg(dir.path(out)).assert()
}

#[test]
fn wrong_requests() {
    let dir = TestDir::new();
    let swap =
        STRIPES_SCENE.replace("\"omega\"", "\"ω\"").replace("\"gamma2\"", "\"omega\"").replace("\"ω\"", "\"gamma2\"");
    let list = r#"values = [0.1, 0.2]"#;
    for (scene, message) in [
        (
            STRIPES_SCENE.replace("sites = 6", "sites = 6\nforcing = { amplitude = 0.1, restitution = 0.9 }"),
            "give a scene without force and with elastic impacts",
        ),
        (swap, "give a scene with x = omega and y = gamma2"),
        (
            STRIPES_SCENE
                .replace(r#""gamma2", from = 0.1"#, r#""gamma1", from = 0.1"#)
                .replace("gamma1 = 0.2", "gamma2 = 0.2"),
            "give a scene with x = omega and y = gamma2",
        ),
        (STRIPES_SCENE.replace("from = 0.1, to = 0.3, points = 40", list), "give both axes by from, to and points"),
        (STRIPES_SCENE.replace("sites = 6", "sites = 0"), "sites = 0 is out of range"),
    ] {
        let scene = dir.scene(&scene);
        stripes(&dir, &scene, "x.csv").code(2).stdout("").stderr(contains(message));
        assert_eq!(dir.names("."), ["scene.toml"], "{message}");
    }
    let scene = dir.scene(STRIPES_SCENE);
    stripes(&dir, &scene, "x.png").code(2).stderr(contains("end the name in .csv"));
    stripes(&dir, &dir.path("missing.toml"), "x.csv").code(2).stderr(contains("cannot read scene"));
    mapgen(&["stripes"]).arg(&scene).arg("--out").arg(&scene).assert().code(2).stderr(contains("are the same file"));
    assert_eq!(dir.names("."), ["scene.toml"]);
}

#[test]
fn maps_that_would_take_hours_are_refused_with_the_limit() {
    let dir = TestDir::new();
    let large = STRIPES_SCENE.replace("points = 150", "points = 1000000").replace("points = 40", "points = 1000000");
    let long = STRIPES_SCENE.replace("sites = 6", "sites = 1000000");
    for (text, message) in [
        (
            large,
            "every pair of the modes of 6 masses at each of 2001799000000 points is too much: give fewer points or a shorter range",
        ),
        (
            long,
            "every pair of the modes of 1000000 masses at each of 83960 points is too much: give at most 6901 sites, or fewer points",
        ),
    ] {
        let scene = dir.scene(&text);
        stripes(&dir, &scene, "x.csv").code(2).stdout("").stderr(contains(message));
        assert_eq!(dir.names("."), ["scene.toml"]);
    }
}

#[test]
fn a_map_names_the_modes_that_have_collided() {
    let dir = TestDir::new();
    let scene = dir.scene(&STRIPES_SCENE.replace("stability = true", "stability = true\ncollisions = true"));
    let map = dir.path("map.csv");
    mapgen(&["sweep", "--quiet"]).arg(&scene).arg("--out").arg(&map).assert().success();
    let header = fs::read_to_string(&map).unwrap().lines().next().unwrap().to_owned();
    assert!(header.ends_with(",solutions,status,mode1,mode2,harmonic"), "{header}");
    let mut named = 0;
    for row in table(&map) {
        match row["mechanism"].as_str() {
            "" | "plus-one" => {
                assert!(row["mode1"].is_empty() && row["mode2"].is_empty() && row["harmonic"].is_empty())
            }
            mechanism if !row["mode1"].is_empty() => {
                assert_eq!(row["mode1"] == row["mode2"], mechanism == "period-doubling", "{row:?}");
                named += 1;
            }
            _ => {}
        }
    }
    assert!(named > 300, "{named}");
    let manifest = dir.json("map.manifest.json");
    assert_eq!(manifest["compute"]["collisions"], true);

    let wrong = |from: &str, to: &str, message: &str| {
        let scene = dir.scene(&STRIPES_SCENE.replacen(from, to, 1));
        let assert = mapgen(&["sweep"]).arg(&scene).arg("--out").arg(dir.path("no.csv")).assert();
        assert.code(2).stderr(contains(message).and(contains("scene.toml:")));
    };
    wrong("stability = true", "collisions = true", "collisions need stability = true");
    wrong("stability = true", "stability = true\ncollisions = 1", "integer `1` is not true or false");
    let forced = "[compute]\ncollisions = true";
    let text = STRIPES_SCENE.replace("sites = 6", "sites = 6\nforcing = { amplitude = 0.1, restitution = 0.9 }");
    let scene = dir.scene(&text.replace("[compute]", forced));
    let assert = mapgen(&["sweep"]).arg(&scene).arg("--out").arg(dir.path("no.csv")).assert();
    assert.code(2).stderr(contains("collisions are told of conservative orbits only"));
}

/// Of a row with free ends and of two layers: cells name the pair, and an orbit lists its modes.
#[test]
fn rows_and_layers_have_stripes_too() {
    for lattice in ["ends = \"free\"", "layers = 2\ngamma3 = 0.05"] {
        let dir = TestDir::new();
        let text = STRIPES_SCENE.replace("sites = 6", &format!("sites = 6\n{lattice}"));
        let text = text.replace("points = 150", "points = 300").replace("points = 40", "points = 12");
        let scene = dir.scene(&text.replace("stability = true", "stability = true\ncollisions = true"));
        let map = dir.path("map.csv");
        mapgen(&["sweep", "--quiet"]).arg(&scene).arg("--out").arg(&map).assert().success();
        let (mut named, mut beside) = (0_u32, 0_u32);
        for row in
            table(&map).iter().filter(|row| row["mechanism"] == "neimark-sacker" && row["class"].contains("double"))
        {
            beside += 1;
            named += u32::from(!row["mode1"].is_empty());
        }
        assert!(beside > 50 && f64::from(named) > 0.9 * f64::from(beside), "{named} of {beside}");
    }
    let line = "orbit --sites 3 --ends free --layers 2 --gamma3 .05 --gamma1 .2 --gamma2 .1 --omega 1.7 --asymmetry .4 --word 1+,1- --json";
    let assert = mapgen(&line.split_whitespace().collect::<Vec<_>>()).assert().success();
    let value = written(&assert.get_output().stdout);
    let modes = value["solutions"][0]["modes"].as_array().unwrap();
    // In the middle of a row of three the second mode has a node.
    let bare = [0.2, 0.3, 0.5, 0.6].map(f64::sqrt);
    assert_eq!(modes.len(), 4);
    for (k, mode) in modes.iter().enumerate() {
        assert_eq!(mode["mode"], k);
        assert!((mode["frequency"].as_f64().unwrap() - bare[k]).abs() < 1e-14);
        if let Some(dressed) = mode["dressed"].as_f64() {
            assert!(bare[k] < dressed && dressed < bare[k + 1] && mode["signature"].is_i64());
        }
    }
    assert!(modes.iter().filter(|mode| mode["dressed"].is_f64()).count() == 3);
}

#[test]
fn the_table_of_widths_says_where_stripes_begin_and_end() {
    let dir = TestDir::new();
    let scene = dir.scene(&STRIPES_SCENE.replace("points = 40", "points = 4"));
    let text = output(stripes(&dir, &scene, "widths.csv"));
    assert_eq!(dir.names("."), ["scene.toml", "widths.csv"]);
    let stripes = table(&dir.path("widths.csv"));
    assert!(stripes.len() > 15, "{stripes:?}");
    // The summary is that of the table.
    let of: Vec<_> = stripes.iter().filter(|row| row["family"] == "double-sided").collect();
    let whole = of.iter().filter(|row| row["lower_end"] == "edge" && row["upper_end"] == "edge");
    let mut whole: Vec<f64> = whole.map(|row| number(row, "width")).collect();
    whole.sort_by(f64::total_cmp);
    let growth = of.iter().map(|row| number(row, "growth")).fold(0.0, f64::max);
    let rows: BTreeSet<&str> = of.iter().map(|row| row["gamma2"].as_str()).collect();
    let told = printed_numbers(&text, "stripes", "double-sided");
    let cells = whole.iter().filter(|width| **width < 1.2 / 149.0).count();
    assert_eq!(told[..3], [rows.len(), of.len(), cells].map(|count| count as f64));
    for (told, value) in told[3..6].iter().zip([whole[0], whole[whole.len() - 1], growth]) {
        assert!((told / value - 1.0).abs() < 6e-3, "{told} {value}");
    }
    assert_eq!(told[6..], [0.0]);
    let stable = |row: &BTreeMap<String, String>, omega: f64| {
        let omega = omega.to_string();
        let flags = ["--family", &row["family"], "--sites", "6", "--gamma1", "0.2", "--asymmetry", "0.4"];
        let text = output(
            mapgen(&["orbit", "--json"]).args(flags).args(["--gamma2", &row["gamma2"], "--omega", &omega]).assert(),
        );
        let value = written(&text);
        let stability = &value["solutions"][0]["stability"];
        (stability["stable"].as_bool().unwrap(), stability["spectral_radius"].as_f64().unwrap().ln())
    };
    let mut checked = 0;
    for row in &stripes {
        let [centre, lower, upper, width] = ["centre", "lower", "upper", "width"].map(|column| number(row, column));
        assert!(
            lower <= centre && centre <= upper && (upper - lower - width).abs() < 1e-12 && row["resolved"] == "true"
        );
        if row["family"] != "double-sided" || row["lower_end"] != "edge" || row["upper_end"] != "edge" {
            continue;
        }
        let (inside, growth) = stable(row, centre);
        assert!(!inside && growth <= number(row, "growth") * (1.0 + 1e-6), "{row:?} {growth}");
        assert!(!stable(row, lower + 0.01 * width).0 && !stable(row, upper - 0.01 * width).0, "{row:?}");
        if centre > 1.4 {
            assert!(stable(row, lower - 0.01 * width).0 && stable(row, upper + 0.01 * width).0, "{row:?}");
            checked += 1;
        }
    }
    assert!(checked > 5, "{checked}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_table_of_widths_leaves_no_file() {
    let dir = TestDir::with_scene(
        &STRIPES_SCENE.replace("points = 40", "points = 4000").replace("points = 150", "points = 20"),
    );
    let child = dir.start("stripes scene.toml --out widths.csv");
    // They take two minutes.
    std::thread::sleep(std::time::Duration::from_secs(3));
    signal(child, "TERM").with(130, &["interrupted"]);
    assert_eq!(dir.names("."), ["scene.toml"]);
}
