//! `mapgen stripes`, the modes that `mapgen orbit` tells of, and the columns of collisions on a map.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
#[cfg(unix)]
use vibrochain_testkit::signal;
use vibrochain_testkit::{TestDir, mapgen, written};

const SCENE: &str = r#"
[model]
sites = 6
gamma1 = 0.2
asymmetry = 0.4
[sweep]
x = { parameter = "omega", from = 1.1, to = 2.3, points = 150 }
y = { parameter = "gamma2", from = 0.1, to = 0.3, points = 40 }
[compute]
families = ["double-sided", "single-sided"]
stability = true
"#;

/// Rows of a table, by column.
fn table(path: &Path) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} of {row:?}"))
}

/// The numbers of a printed row: cells, five shares, cuts, two shares of cuts.
fn printed(text: &str, family: &str, row: &str) -> Vec<f64> {
    let lines = text.lines().skip_while(|line| !line.starts_with(family)).skip(1);
    let line = lines.take_while(|line| !line.is_empty()).find(|line| line.trim_start().starts_with(row));
    let words = line.unwrap_or_else(|| panic!("no {row} in\n{text}")).split_whitespace();
    words.filter_map(|word| word.parse().ok()).collect()
}

fn output(assert: assert_cmd::assert::Assert) -> String {
    String::from_utf8(assert.success().get_output().stdout.clone()).unwrap()
}

fn stripes(dir: &TestDir, scene: &Path, out: &str, flags: &[&str]) -> assert_cmd::assert::Assert {
    mapgen(&["stripes"]).arg(scene).arg("--plot").arg(dir.path(out)).args(flags).assert()
}

#[test]
fn sums_of_two_modes_run_along_the_stripes_and_differences_do_not() {
    let dir = TestDir::new();
    let scene = dir.scene(SCENE);
    let csv = dir.path("lines.csv");
    let text = output(stripes(&dir, &scene, "stripes.svg", &["--csv", csv.to_str().unwrap()]));
    assert_eq!(dir.names("."), ["lines.csv", "lines.manifest.json", "scene.toml", "stripes.svg"]);
    assert!(text.starts_with("6 masses (N = 5): share of cells within one cell of a line"));
    for mechanism in ["neimark-sacker", "period-doubling"] {
        let row = printed(&text, "double-sided", mechanism);
        assert_eq!(row.len(), 9);
        assert!(row[0] > 50.0 && row[1] > 90.0 && row[2] == 0.0 && row[3] < 60.0 && row[7] > 95.0, "{text}");
        // Carried on, a cut has met at least what it met before; no such breather has a mode that grows by itself.
        assert!(row[5] == 0.0 && row[8] >= row[7], "{text}");
    }
    assert!(printed(&text, "double-sided", "stable")[1] < 20.0, "{text}");

    let lines = table(&csv);
    assert!(lines.len() > 150);
    for row in &lines {
        assert_eq!((row["sum"].as_str(), row["signature_product"].as_str()), ("true", "-1"));
        let (k, l, j) = (number(row, "mode1"), number(row, "mode2"), number(row, "harmonic"));
        assert!(k <= l && l <= 2.0 && j >= 1.0 && (k < l || j % 2.0 == 1.0));
        // Between the sums of the bare modes below and above: γ₁ = 0.2 and 4γ₂ sin²(πk/6).
        let bare = |k: f64| (0.2 + 4.0 * number(row, "gamma2") * (std::f64::consts::PI * k / 6.0).sin().powi(2)).sqrt();
        let sum = j * number(row, "omega");
        assert!(bare(k) + bare(l) < sum && sum < bare(k + 1.0) + bare(l + 1.0), "{row:?}");
    }
    let pairs: std::collections::BTreeSet<_> =
        lines.iter().map(|row| (row["mode1"].as_str(), row["mode2"].as_str())).collect();
    assert!([("0", "1"), ("0", "2"), ("1", "1"), ("1", "2"), ("2", "2")].iter().all(|pair| pairs.contains(pair)));
    let svg = fs::read_to_string(dir.path("stripes.svg")).unwrap();
    assert!(svg.contains("1,2,1") && svg.contains("two modes meet"));
}

#[test]
fn stripes_of_single_sided_breathers_on_a_short_ring_are_of_a_mode_and_the_internal_one() {
    let dir = TestDir::new();
    let axes = SCENE.replace("from = 1.1, to = 2.3, points = 150", "from = 0.6, to = 0.8, points = 120");
    let scene = dir.scene(&axes.replace("from = 0.1, to = 0.3", "from = 0.2, to = 0.3"));
    let csv = dir.path("lines.csv");
    let text = output(stripes(&dir, &scene, "stripes.svg", &["--csv", csv.to_str().unwrap()]));
    let row = printed(&text, "single-sided", "neimark-sacker");
    assert!(row[0] > 200.0 && row[7] > 80.0 && row[8] >= row[7], "{text}");
    let stable = printed(&text, "single-sided", "stable");
    assert!(stable[0] > 500.0 && stable[1] < 15.0 && stable[5] < 1.0, "{text}");
    let lines = table(&csv);
    let of = |k: &str, l: &str, j: &str| {
        lines.iter().filter(|row| row["mode1"] == k && row["mode2"] == l && row["harmonic"] == j).count()
    };
    // Four modes of the ring leave three, one of which is the breather's place: 3 is the internal mode.
    assert!(of("2", "3", "2") > 30, "{lines:?}");
    assert!(lines.iter().all(|row| row["mode1"] != "1" && row["mode2"] != "1"));
    let svg = fs::read_to_string(dir.path("stripes.svg")).unwrap();
    assert!(svg.contains("2,3,2") && svg.contains("3: the internal mode"));
}

#[test]
fn a_finished_table_gives_the_same_as_computing_the_map() {
    let dir = TestDir::new();
    let scene = dir.scene(&SCENE.replace("points = 150", "points = 50"));
    let map = dir.path("map.csv");
    mapgen(&["sweep", "--quiet"]).arg(&scene).arg("--out").arg(&map).assert().success();
    let computed = output(stripes(&dir, &scene, "a.png", &[]));
    let read = output(stripes(&dir, &scene, "b.png", &["--map", map.to_str().unwrap()]));
    assert_eq!(computed, read);
    assert_eq!(fs::read(dir.path("a.png")).unwrap(), fs::read(dir.path("b.png")).unwrap());
}

#[test]
fn a_symmetric_gap_has_no_stripes_of_double_sided_breathers_at_odd_harmonics() {
    let dir = TestDir::new();
    let scene = dir.scene(&SCENE.replace("asymmetry = 0.4", "asymmetry = 0.0"));
    let csv = dir.path("lines.csv");
    let text = output(stripes(&dir, &scene, "stripes.png", &["--csv", csv.to_str().unwrap()]));
    // ω is above the band: only j = 1 could be met.
    assert!(table(&csv).is_empty(), "{text}");
    assert!(!text.contains("neimark-sacker") && !text.contains("period-doubling"), "{text}");
}

#[test]
fn wrong_requests() {
    let dir = TestDir::new();
    let swap = SCENE.replace("\"omega\"", "\"ω\"").replace("\"gamma2\"", "\"omega\"").replace("\"ω\"", "\"gamma2\"");
    let list = r#"values = [0.1, 0.2]"#;
    for (scene, message) in [
        (
            SCENE.replace("sites = 6", "sites = 6\nforcing = { amplitude = 0.1, restitution = 0.9 }"),
            "give a scene without force and with elastic impacts",
        ),
        (swap, "give a scene with x = omega and y = gamma2"),
        (
            SCENE.replace(r#""gamma2", from = 0.1"#, r#""gamma1", from = 0.1"#).replace("gamma1 = 0.2", "gamma2 = 0.2"),
            "give a scene with x = omega and y = gamma2",
        ),
        (SCENE.replace("from = 0.1, to = 0.3, points = 40", list), "give both axes by from, to and points"),
        (SCENE.replace("stability = true", ""), "set stability = true in [compute]"),
        (SCENE.replace("sites = 6", "sites = 0"), "sites = 0 is out of range"),
    ] {
        let scene = dir.scene(&scene);
        stripes(&dir, &scene, "x.png", &[]).code(2).stdout("").stderr(contains(message));
        assert_eq!(dir.names("."), ["scene.toml"], "{message}");
    }
    let scene = dir.scene(SCENE);
    stripes(&dir, &scene, "x.gif", &[]).code(2).stderr(contains("end the name in .png, .svg or .pdf"));
    stripes(&dir, &dir.path("missing.toml"), "x.png", &[]).code(2).stderr(contains("cannot read scene"));
    mapgen(&["stripes"]).arg(&scene).assert().success().stdout(contains("share of cells within one cell of a line"));
    stripes(&dir, &scene, "scene.toml.png", &["--csv", dir.path("scene.toml.png").to_str().unwrap()])
        .code(2)
        .stderr(contains("are the same file"));
    assert_eq!(dir.names("."), ["scene.toml"]);
}

/// On a coarse map one cell below the first is at no frequency at all: the memory that lines take does not depend on that.
#[cfg(unix)]
#[test]
fn a_map_that_begins_less_than_a_cell_above_zero_takes_no_more_memory() {
    let dir = TestDir::new();
    for (points, from) in [(4, "0.4"), (7, "0.4"), (3, "1e-9")] {
        let scene = dir.scene(&format!(
            "[model]\nsites = 21\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
             x = {{ parameter = \"omega\", from = {from}, to = 3.0, points = {points} }}\n\
             y = {{ parameter = \"gamma2\", from = 0.0, to = 0.3, points = 2 }}\n\
             [compute]\nfamilies = [\"double-sided\", \"single-sided\"]\nstability = true\n"
        ));
        // Kilobytes of address space, most of it the threads' own.
        let limited = "ulimit -v 1500000 && exec \"$0\" \"$@\"";
        let mut command = Command::new("sh");
        let program = assert_cmd::cargo::cargo_bin("mapgen");
        command.args(["-c", limited]).arg(program).arg("stripes").arg(scene).arg("--out").arg(dir.path("x.svg"));
        let text = output(command.env("RAYON_NUM_THREADS", "2").assert());
        let row = printed(&text, "double-sided", "stable");
        assert!(row[0] >= 2.0 && row[3] > 50.0, "{text}");
    }
}

#[test]
fn maps_that_would_not_fit_are_refused_with_the_limit() {
    let dir = TestDir::new();
    let large = SCENE.replace("points = 150", "points = 1000000").replace("points = 40", "points = 1000000");
    let long = SCENE.replace("sites = 6", "sites = 1000000");
    for (text, message) in [
        (large, "the map has 1000000000000 cells and is held whole: give at most 10000000"),
        (
            long,
            "every pair of the modes of 1000000 masses in every one of 6000 cells is too much: give at most 25817 sites",
        ),
    ] {
        let scene = dir.scene(&text);
        stripes(&dir, &scene, "x.png", &[]).code(2).stdout("").stderr(contains(message));
        assert_eq!(dir.names("."), ["scene.toml"]);
    }
}

#[test]
fn tables_of_another_scene_are_refused() {
    let dir = TestDir::new();
    let small = SCENE.replace("points = 150", "points = 5").replace("points = 40", "points = 4");
    let scene = dir.scene(&small);
    let map = dir.path("map.csv");
    mapgen(&["sweep", "--quiet"]).arg(&scene).arg("--out").arg(&map).assert().success();
    let good = fs::read_to_string(&map).unwrap();
    let flags = ["--map", map.to_str().unwrap()];
    let cut: String = good.lines().take(10).map(|line| format!("{line}\n")).collect();
    let more = format!("{good}{}\n", good.lines().last().unwrap());
    for (text, message) in [
        (good.replace("mechanism", "cause"), "its columns are not those of this scene, gamma2,omega,class,"),
        (good.replacen("0.1,1.1,", "0.1,1.2,", 1), "row 1: it is of the cell at 1.2 and not at 1.1"),
        (good.replacen("stable-double", "steady-double", 1), "its class is `steady-double`"),
        (cut, "it has 9 rows for 20 cells"),
        (more, "it has more rows than its 20 cells"),
        (String::new(), "it is empty"),
        (good.replacen(",,", ",", 1), "row 1: its mechanism is `1`"),
    ] {
        assert_ne!(text, good);
        fs::write(&map, text).unwrap();
        stripes(&dir, &scene, "x.png", &flags).code(2).stdout("").stderr(contains("--map").and(contains(message)));
        assert_eq!(dir.names("."), ["map.csv", "map.manifest.json", "scene.toml"], "{message}");
    }
    stripes(&dir, &scene, "x.png", &["--map", "no.csv"]).code(2).stderr(contains("cannot be read as a table"));
}

#[test]
fn a_map_names_the_modes_that_have_collided() {
    let dir = TestDir::new();
    let scene = dir.scene(&SCENE.replace("stability = true", "stability = true\ncollisions = true"));
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
        let scene = dir.scene(&SCENE.replacen(from, to, 1));
        let assert = mapgen(&["sweep"]).arg(&scene).arg("--out").arg(dir.path("no.csv")).assert();
        assert.code(2).stderr(contains(message).and(contains("scene.toml:")));
    };
    wrong("stability = true", "collisions = true", "collisions need stability = true");
    wrong("stability = true", "stability = true\ncollisions = 1", "integer `1` is not true or false");
    let forced = "[compute]\ncollisions = true";
    let text = SCENE.replace("sites = 6", "sites = 6\nforcing = { amplitude = 0.1, restitution = 0.9 }");
    let scene = dir.scene(&text.replace("[compute]", forced));
    let assert = mapgen(&["sweep"]).arg(&scene).arg("--out").arg(dir.path("no.csv")).assert();
    assert.code(2).stderr(contains("collisions are told of conservative orbits only"));
}

/// Of a row with free ends and of two layers: lines run along the stripes, cells name the pair, and an orbit lists its modes.
#[test]
fn rows_and_layers_have_stripes_too() {
    for (lattice, name, own) in
        [("ends = \"free\"", "6 masses, free ends", 5), ("layers = 2\ngamma3 = 0.05", "6 masses × 2 layers", 7)]
    {
        let dir = TestDir::new();
        let text = SCENE.replace("sites = 6", &format!("sites = 6\n{lattice}"));
        let scene = dir.scene(&text.replace("points = 150", "points = 300").replace("points = 40", "points = 12"));
        let csv = dir.path("lines.csv");
        let text = output(stripes(&dir, &scene, "stripes.svg", &["--csv", csv.to_str().unwrap()]));
        assert!(text.starts_with(&format!("{name}: share of cells within one cell of a line")), "{text}");
        let (unstable, stable) =
            (printed(&text, "double-sided", "neimark-sacker"), printed(&text, "double-sided", "stable"));
        // Nearly every cut through a stripe meets a sum, and few stable cells do.
        assert!(
            unstable[0] > 50.0
                && unstable[7] > 90.0
                && unstable[1] > 1.25 * unstable[3]
                && stable[1] < 0.5 * unstable[1],
            "{unstable:?} {stable:?}"
        );
        let lines = table(&csv);
        assert!(lines.iter().all(|line| number(line, "mode2") <= f64::from(own)) && lines.len() > 100);

        let scene = dir.scene(
            &fs::read_to_string(&scene).unwrap().replace("stability = true", "stability = true\ncollisions = true"),
        );
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
    let scene = dir.scene(&SCENE.replace("points = 40", "points = 4"));
    let (widths, lines) = (dir.path("widths.csv"), dir.path("lines.csv"));
    let flags = ["--widths", widths.to_str().unwrap(), "--csv", lines.to_str().unwrap()];
    let text = output(stripes(&dir, &scene, "stripes.png", &flags));
    let (stripes, lines) = (table(&widths), table(&lines));
    assert!(stripes.len() > 15, "{stripes:?}");
    // The summary is that of the table.
    let of: Vec<_> = stripes.iter().filter(|row| row["family"] == "double-sided").collect();
    let whole = of.iter().filter(|row| row["lower_end"] == "edge" && row["upper_end"] == "edge");
    let mut whole: Vec<f64> = whole.map(|row| number(row, "width")).collect();
    whole.sort_by(f64::total_cmp);
    let growth = of.iter().map(|row| number(row, "growth")).fold(0.0, f64::max);
    let rows: BTreeSet<&str> = of.iter().map(|row| row["gamma2"].as_str()).collect();
    let told = printed(&text, "stripes", "double-sided");
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
    let (mut checked, mut drawn) = (0, 0);
    for row in &stripes {
        let [centre, lower, upper, width] = ["centre", "lower", "upper", "width"].map(|column| number(row, column));
        assert!(
            lower <= centre && centre <= upper && (upper - lower - width).abs() < 1e-12 && row["resolved"] == "true"
        );
        if row["family"] != "double-sided" || row["lower_end"] != "edge" || row["upper_end"] != "edge" {
            continue;
        }
        // One step of the map wide, a line is drawn through it.
        let key = ["family", "gamma2", "mode1", "mode2", "harmonic"];
        drawn += usize::from(lines.iter().any(|line| {
            key.iter().all(|column| line[*column] == row[*column])
                && (number(line, "omega") - centre).abs() < 0.01 + width
        }));
        let (inside, growth) = stable(row, centre);
        assert!(!inside && growth <= number(row, "growth") * (1.0 + 1e-6), "{row:?} {growth}");
        assert!(!stable(row, lower + 0.01 * width).0 && !stable(row, upper - 0.01 * width).0, "{row:?}");
        if centre > 1.4 {
            assert!(stable(row, lower - 0.01 * width).0 && stable(row, upper + 0.01 * width).0, "{row:?}");
            checked += 1;
        }
    }
    assert!(checked > 5 && drawn > 12, "{checked} {drawn}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_table_of_widths_leaves_no_file() {
    let dir =
        TestDir::with_scene(&SCENE.replace("points = 40", "points = 4000").replace("points = 150", "points = 20"));
    let child = dir.start("stripes scene.toml --out map.png --csv lines.csv --widths widths.csv");
    // Lines take a second, widths two minutes.
    std::thread::sleep(std::time::Duration::from_secs(3));
    signal(child, "TERM").with(130, &["interrupted"]);
    assert_eq!(dir.names("."), ["scene.toml"]);
}
