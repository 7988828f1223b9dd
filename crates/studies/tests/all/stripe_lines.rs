//! `studies lines`: the lines on which two modes collide run along the stripes.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use predicates::str::contains;
use vibrochain_testkit::{STRIPES_SCENE, TestDir, output, printed_numbers, studies};

/// Rows of a table, by column.
fn table(path: &Path) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} of {row:?}"))
}

fn lines(scene: &Path, dir: &TestDir, picture: &str, out: &Path) -> assert_cmd::assert::Assert {
    studies(&["lines"]).arg(scene).arg("--plot").arg(dir.path(picture)).arg("--out").arg(out).assert()
}

#[test]
fn sums_of_two_modes_run_along_the_stripes_and_differences_do_not() {
    let dir = TestDir::new();
    let scene = dir.scene(STRIPES_SCENE);
    let csv = dir.path("lines.csv");
    let text = output(lines(&scene, &dir, "stripes.svg", &csv));
    assert_eq!(dir.names("."), ["lines.csv", "scene.toml", "stripes.svg"]);
    assert!(text.starts_with("6 masses (N = 5): share of cells within one cell of a line"));
    for mechanism in ["neimark-sacker", "period-doubling"] {
        let row = printed_numbers(&text, "double-sided", mechanism);
        assert_eq!(row.len(), 8);
        assert!(row[0] > 50.0 && row[1] > 90.0 && row[2] == 0.0 && row[3] < 60.0 && row[6] > 95.0, "{text}");
        // Carried on, a cut has met at least what it met before.
        assert!(row[7] >= row[6], "{text}");
    }
    assert!(printed_numbers(&text, "double-sided", "stable")[1] < 20.0, "{text}");

    let rows = table(&csv);
    assert!(rows.len() > 150);
    for row in &rows {
        assert_eq!(row["sum"], "true");
        let (k, l, j) = (number(row, "mode1"), number(row, "mode2"), number(row, "harmonic"));
        assert!(k <= l && l <= 2.0 && j >= 1.0 && (k < l || j % 2.0 == 1.0));
        // Between the sums of the bare modes below and above: γ₁ = 0.2 and 4γ₂ sin²(πk/6).
        let bare = |k: f64| (0.2 + 4.0 * number(row, "gamma2") * (std::f64::consts::PI * k / 6.0).sin().powi(2)).sqrt();
        let sum = j * number(row, "omega");
        assert!(bare(k) + bare(l) < sum && sum < bare(k + 1.0) + bare(l + 1.0), "{row:?}");
    }
    let pairs: BTreeSet<_> = rows.iter().map(|row| (row["mode1"].as_str(), row["mode2"].as_str())).collect();
    assert!([("0", "1"), ("0", "2"), ("1", "1"), ("1", "2"), ("2", "2")].iter().all(|pair| pairs.contains(pair)));
    let svg = fs::read_to_string(dir.path("stripes.svg")).unwrap();
    assert!(svg.contains("1,2,1") && svg.contains("Ωₖ + Ωₗ = jω"));
}

#[test]
fn stripes_of_single_sided_breathers_on_a_short_ring_are_of_a_mode_and_the_internal_one() {
    let dir = TestDir::new();
    let axes = STRIPES_SCENE.replace("from = 1.1, to = 2.3, points = 150", "from = 0.6, to = 0.8, points = 120");
    let scene = dir.scene(&axes.replace("from = 0.1, to = 0.3", "from = 0.2, to = 0.3"));
    let csv = dir.path("lines.csv");
    let text = output(lines(&scene, &dir, "stripes.svg", &csv));
    let row = printed_numbers(&text, "single-sided", "neimark-sacker");
    assert!(row[0] > 200.0 && row[6] > 80.0 && row[7] >= row[6], "{text}");
    let stable = printed_numbers(&text, "single-sided", "stable");
    assert!(stable[0] > 500.0 && stable[1] < 15.0, "{text}");
    let rows = table(&csv);
    let of = |k: &str, l: &str, j: &str| {
        rows.iter().filter(|row| row["mode1"] == k && row["mode2"] == l && row["harmonic"] == j).count()
    };
    // Four modes of the ring leave three, one of which is the breather's place: 3 is the internal mode.
    assert!(of("2", "3", "2") > 30, "{rows:?}");
    assert!(rows.iter().all(|row| row["mode1"] != "1" && row["mode2"] != "1"));
    let svg = fs::read_to_string(dir.path("stripes.svg")).unwrap();
    assert!(svg.contains("2,3,2") && svg.contains("internal"));
}

#[test]
fn a_symmetric_gap_has_no_stripes_of_double_sided_breathers_at_odd_harmonics() {
    let dir = TestDir::new();
    let scene = dir.scene(&STRIPES_SCENE.replace("asymmetry = 0.4", "asymmetry = 0.0"));
    let csv = dir.path("lines.csv");
    let text = output(lines(&scene, &dir, "stripes.png", &csv));
    // ω is above the band: only j = 1 could be met.
    assert!(table(&csv).is_empty(), "{text}");
    assert!(!text.contains("neimark-sacker") && !text.contains("period-doubling"), "{text}");
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
        let mut command = assert_cmd::Command::new("sh");
        let program = assert_cmd::cargo::cargo_bin("studies");
        command.args(["-c", limited]).arg(program).arg("lines").arg(scene).arg("--plot").arg(dir.path("x.svg"));
        let text = output(command.env("RAYON_NUM_THREADS", "2").assert());
        let row = printed_numbers(&text, "double-sided", "stable");
        assert!(row[0] >= 2.0 && row[3] > 50.0, "{text}");
    }
}

/// Of a row with free ends and of two layers.
#[test]
fn lines_of_rows_and_layers_run_along_the_stripes_too() {
    for (lattice, name, own) in
        [("ends = \"free\"", "6 masses, free ends", 5), ("layers = 2\ngamma3 = 0.05", "6 masses × 2 layers", 7)]
    {
        let dir = TestDir::new();
        let text = STRIPES_SCENE.replace("sites = 6", &format!("sites = 6\n{lattice}"));
        let scene = dir.scene(&text.replace("points = 150", "points = 300").replace("points = 40", "points = 12"));
        let csv = dir.path("lines.csv");
        let text = output(lines(&scene, &dir, "stripes.svg", &csv));
        assert!(text.starts_with(&format!("{name}: share of cells within one cell of a line")), "{text}");
        let (unstable, stable) = (
            printed_numbers(&text, "double-sided", "neimark-sacker"),
            printed_numbers(&text, "double-sided", "stable"),
        );
        // Nearly every cut through a stripe meets a sum, and few stable cells do.
        assert!(
            unstable[0] > 50.0
                && unstable[6] > 90.0
                && unstable[1] > 1.25 * unstable[3]
                && stable[1] < 0.5 * unstable[1],
            "{unstable:?} {stable:?}"
        );
        let rows = table(&csv);
        assert!(rows.iter().all(|line| number(line, "mode2") <= f64::from(own)) && rows.len() > 100);
    }
}

#[test]
fn a_map_without_stability_is_refused() {
    let dir = TestDir::new();
    let scene = dir.scene(&STRIPES_SCENE.replace("stability = true", ""));
    let told = contains("set stability = true in [compute]");
    lines(&scene, &dir, "x.png", &dir.path("x.csv")).code(2).stdout("").stderr(told);
    assert_eq!(dir.names("."), ["scene.toml"]);
}
