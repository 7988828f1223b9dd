//! Maps: what a sweep writes, and what a scene may ask.

use std::fs;

use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;
use vibrochain_testkit::{TestDir, mapgen, written};

use crate::asked::{SCENE, forced, rows, sweep};

#[test]
fn a_sweep_writes_table_manifest_and_pictures_and_nothing_else() {
    let dir = TestDir::new();
    let scene = dir.scene(SCENE);
    let (png, svg) = (dir.path("map.png"), dir.path("map.svg"));
    let flags = ["--png", png.to_str().unwrap(), "--svg", svg.to_str().unwrap()];
    sweep(&dir, &scene, &flags).success().stdout("").stderr(contains("1200 cells").and(contains("worst residual")));
    assert_eq!(dir.names("."), ["map.csv", "map.manifest.json", "map.png", "map.svg", "scene.toml"]);

    let mut table = csv::Reader::from_path(dir.path("map.csv")).unwrap();
    let header: Vec<_> = table.headers().unwrap().iter().map(str::to_owned).collect();
    let columns = ["gamma2", "omega", "class", "mechanism", "spectral_radius", "margin", "solutions", "status"];
    assert_eq!(header, columns);
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 1200);
    for row in &rows {
        let (class, mechanism, radius, margin) = (&row[2], &row[3], &row[4], &row[5]);
        assert!(["none", "stable-double", "stable-single", "unstable-double", "unstable-single"].contains(&class));
        assert_eq!(mechanism.is_empty(), !class.starts_with("unstable"));
        assert_eq!(radius.is_empty(), class == "none");
        assert_eq!(margin.is_empty(), class == "none");
        assert!(margin.parse::<f64>().map_or(class == "none", |margin| margin > 0.0));
        assert_eq!(&row[7], "ok");
    }
    assert_eq!((&rows[0][0], &rows[0][1], &rows[1199][0], &rows[1199][1]), ("0", "0.4", "0.3", "3"));

    let manifest = dir.json("map.manifest.json");
    assert_eq!((&manifest["cells"], &manifest["model"]["sites"]), (&1200.into(), &11.into()));
    assert_eq!(manifest["sweep"]["x"]["parameter"], "omega");
    assert!(manifest["wall_seconds"].as_f64().unwrap() > 0.0 && manifest["version"].is_string());
    let counted: u64 = manifest["classes"].as_object().unwrap().values().map(|count| count.as_u64().unwrap()).sum();
    assert_eq!(counted, 1200);

    assert!(fs::read(png).unwrap().starts_with(b"\x89PNG"));
    let svg = fs::read_to_string(svg).unwrap();
    assert!(svg.contains("γ₂") && svg.contains("stable double-sided") && svg.contains("pixelated"));
}

/// What a manifest says of its scene is the scene; and its model may be pasted into one.
#[test]
fn a_manifest_is_a_scene() {
    let dir = TestDir::new();
    let harmonics = "force = [{ harmonic = 1, amplitude = 0.1 }, { harmonic = 3, amplitude = 0.02, phase = 1.0 }]";
    let small = |text: &str| text.replace("points = 40", "points = 7").replace("points = 30", "points = 3");
    let harmonics = format!("sites = 11\n{harmonics}\nrestitution = 0.9");
    let third = SCENE.replace(
        "points = 30 }",
        "points = 30, spacing = 'linear' }\naxes = [{ parameter = 'amplitude', values = [0.1, 0.2] }]",
    );
    let third = third.replace("asymmetry = 0.4", "asymmetry = 0.4\nrestitution = 0.8");
    for text in [SCENE.to_owned(), forced(), SCENE.replace("sites = 11", &harmonics), third] {
        sweep(&dir, &dir.scene(&small(&text)), &["--threshold", "1e-3"]).success();
        let manifest = dir.path("map.manifest.json");
        let (table, first) = (fs::read(dir.path("map.csv")).unwrap(), fs::read(&manifest).unwrap());
        fs::write(dir.path("again.json"), first).unwrap();
        mapgen(&["sweep"]).arg(dir.path("again.json")).arg("--out").arg(dir.path("again.csv")).assert().success();
        assert_eq!(fs::read(dir.path("again.csv")).unwrap(), table, "{text}");
        // The model alone, as `key = value`.
        let manifest = written(fs::read(manifest).unwrap());
        let line = |(key, value): (&String, &Value)| format!("{key} = {}\n", value.to_string().replace("\":", "\"="));
        let model: String = manifest["model"].as_object().unwrap().iter().map(line).collect();
        let text = small(&text);
        let sweep_part = &text[text.find("[sweep]").unwrap()..];
        sweep(&dir, &dir.scene(&format!("[model]\n{model}{sweep_part}")), &["--threshold", "1e-3"]).success();
        assert_eq!(fs::read(dir.path("map.csv")).unwrap(), table, "{model}");
    }
}

#[test]
fn threads_do_not_change_a_byte() {
    let dir = TestDir::new();
    let scene = dir.scene(&forced());
    let tables = ["1", "2", "3"].map(|threads| {
        sweep(&dir, &scene, &["--threads", threads]).success();
        fs::read(dir.path("map.csv")).unwrap()
    });
    assert!(tables[0].len() > 1200 * 20 && tables[0] == tables[1] && tables[1] == tables[2]);
}

#[test]
fn existence_alone_has_classes_without_a_word_on_stability() {
    let dir = TestDir::new();
    let scene = dir.scene(&SCENE.replace("stability = true", ""));
    sweep(&dir, &scene, &["--quiet"]).success().stderr("");
    let text = fs::read_to_string(dir.path("map.csv")).unwrap();
    assert!(text.contains(",double,,,") && text.contains(",single,,,") && !text.contains("stable"));
}

#[test]
fn other_axes_have_columns_of_their_own() {
    let dir = TestDir::new();
    let text = SCENE
        .replace("asymmetry = 0.4", "asymmetry = 0.4\ngamma2 = 0.1\nomega = 1.5\nforcing = {}")
        .replace(r#""omega", from = 0.4, to = 3.0"#, r#""restitution", from = 0.2, to = 1.0"#)
        .replace(r#""gamma2", from = 0.0"#, r#""amplitude", from = 0.05"#);
    let scene = dir.scene(&text);
    sweep(&dir, &scene, &[]).success();
    let text = fs::read_to_string(dir.path("map.csv")).unwrap();
    assert!(text.starts_with("gamma2,omega,amplitude,restitution,class,"));
    assert!(text.lines().nth(1).unwrap().starts_with("0.1,1.5,0.05,0.2,"));
}

#[test]
fn a_cell_on_a_resonance_is_marked_and_the_sweep_goes_on() {
    let dir = TestDir::new();
    // Ω₀ = 0.5 is met by ω = 0.5 and by its half.
    let text = SCENE
        .replace("gamma1 = 0.2", "gamma1 = 0.25")
        .replace("from = 0.4, to = 3.0, points = 40", "from = 0.25, to = 1.0, points = 4");
    let scene = dir.scene(&text);
    sweep(&dir, &scene, &[]).success().stderr(contains("status resonance"));
    let text = fs::read_to_string(dir.path("map.csv")).unwrap();
    assert!(text.lines().filter(|line| line.ends_with(",none,,,,0,resonance")).count() >= 60);
    assert!(text.lines().any(|line| line.ends_with(",ok")));
}

#[test]
fn a_threshold_makes_weak_excess_count_as_stable() {
    let dir = TestDir::new();
    let scene = dir.scene(&forced());
    let count = |flags: &[&str]| {
        sweep(&dir, &scene, flags).success();
        fs::read_to_string(dir.path("map.csv")).unwrap().matches(",stable-double,").count()
    };
    let (strict, paper) = (count(&[]), count(&["--threshold", "0.01"]));
    assert!(paper > strict + 50, "{strict} {paper}");
}

/// Every wrong scene is refused with exit code 2, at its line, with what would be right; no file appears.
#[test]
fn wrong_scenes() {
    let forcing = |inside: &str| format!("sites = 11\nforcing = {{ {inside} }}");
    let force =
        |list: &str, inside: &str| format!("sites = 11\nforce = [{list}]\nforcing = {{ {inside}restitution = 0.9 }}");
    let cases: Vec<(&str, String, &str)> = vec![
        ("sites = 11", "sites = 0".into(), "3:9: sites = 0 is out of range: give a whole number from 1"),
        ("sites = 11", "sites = -2".into(), "sites = -2 is out of range"),
        ("sites = 11", "sites = 2.5".into(), "floating point `2.5` is not a whole number"),
        ("sites = 11", "".into(), "the key `sites` is missing"),
        (
            "gamma1 = 0.2",
            "gama1 = 0.2".into(),
            "4:1: unknown key `gama1`: did you mean `gamma1`? known here are `sites`, `ends`",
        ),
        ("gamma1 = 0.2", "gamma1 = -0.2".into(), "4:10: gamma1 = -0.2 is out of range: give a finite number from 0"),
        ("gamma1 = 0.2", "gamma1 = nan".into(), "gamma1 = NaN is out of range"),
        ("gamma1 = 0.2", "gamma1 = 0".into(), "give a positive gamma1 or gamma2"),
        ("gamma1 = 0.2", "".into(), "2:1: gamma1 is missing: set it in [model], or sweep it"),
        ("gamma1 = 0.2", "gamma1 = 0.2\ngamma2 = 0.1".into(), "5:10: gamma2 is given twice"),
        ("asymmetry = 0.4", "asymmetry = 1.0".into(), "asymmetry = 1 is out of range: give a number from 0 up to"),
        ("asymmetry = 0.4", "asymmetry = \"0.4\"".into(), "string \"0.4\" is not a number"),
        ("sites = 11", forcing("amplitude = 0.1"), "4:25: restitution is missing: set it in [model]"),
        (
            "sites = 11",
            format!("{}\namplitude = 0.2", forcing("amplitude = 0.1, restitution = 0.5")),
            "amplitude is given twice, in [model] and in forcing",
        ),
        (
            "sites = 11",
            forcing("amplitude = 0.1, restitution = 1.5"),
            "restitution = 1.5 is out of range: give a number above 0",
        ),
        ("sites = 11", forcing("amplitude = inf, restitution = 0.5"), "amplitude = inf is out of range"),
        ("sites = 11", forcing("amplitude = 0.1, e = 0.5"), "unknown key `e`"),
        (
            "sites = 11",
            force("{ harmonic = 2, amplitude = 0.1 }", ""),
            "4:9: harmonic = 2 is out of range: give an odd",
        ),
        ("sites = 11", force("{ harmonic = -1, amplitude = 0.1 }", ""), "4:23: harmonic = -1 is out of range"),
        ("sites = 11", force("", ""), "number of harmonics = 0 is out of range: give 1 to 8"),
        (
            "sites = 11",
            force("{ harmonic = 1, amplitude = 0.1 }, { harmonic = 1, amplitude = 0.2 }", ""),
            "harmonic = 1 is out of range: give each harmonic of the force only once",
        ),
        ("sites = 11", force("{ harmonic = 1, phase = 0.1 }", ""), "the key `amplitude` is missing"),
        (
            "sites = 11",
            force("{ harmonic = 1, amplitude = 0.1 }", "amplitude = 0.2, "),
            "5:25: amplitude and force are both given",
        ),
        (r#""omega","#, r#""omga","#.into(), "`omga` cannot be swept: did you mean `omega`? give one of gamma1"),
        (r#""omega","#, r#""gamma2","#.into(), "gamma2 is swept twice"),
        ("from = 0.4, to = 3.0", "from = 3.0, to = 0.4".into(), "is not a range: give finite values with from < to"),
        (
            "from = 0.4, to = 3.0",
            "from = 0.0, to = 3.0".into(),
            "7:35: omega = 0 is out of range: give a positive number",
        ),
        ("from = 0.0, to = 0.3", "from = 0.0, to = 1e200".into(), "8:46: gamma2 ="),
        ("points = 40", "points = 1".into(), "points = 1 is out of range: give a whole number from 2"),
        ("points = 40", "pts = 40".into(), "unknown key `pts`"),
        (r#""single-sided""#, r#""one-sided""#.into(), "`one-sided` is not a family: give"),
        (r#""single-sided""#, r#""period-doubled""#.into(), "mapgen orbit --family period-doubled"),
        (r#""single-sided""#, r#""double-sided""#.into(), "double-sided is given twice"),
        (r#"["double-sided", "single-sided"]"#, "[]".into(), "families is empty"),
        ("stability = true", "stability = 1".into(), "integer `1` is not true or false"),
        ("stability = true", "threshold = 0.1".into(), "threshold needs stability = true"),
        ("stability = true", "stability = true\nthreshold = -1".into(), "threshold = -1 is out of range"),
        ("[compute]", "[compute".into(), "unclosed"),
        ("[compute]", "[computes]".into(), "unknown key `computes`: did you mean `compute`?"),
    ];
    for (from, to, message) in cases {
        let dir = TestDir::new();
        assert!(SCENE.contains(from));
        let scene = dir.scene(&SCENE.replacen(from, &to, 1));
        sweep(&dir, &scene, &[]).code(2).stdout("").stderr(contains(message).and(contains("scene.toml:")));
        assert_eq!(dir.names("."), ["scene.toml"], "{message}");
    }
}

#[test]
fn wrong_sweep_flags() {
    let dir = TestDir::new();
    let scene = dir.scene(SCENE);
    for (flags, message) in [
        (vec!["--threads", "0"], "out of range: give a whole number from 1 to 1024"),
        (vec!["--threads", "two"], "invalid value 'two' for '--threads <N>': not a whole number"),
        (vec!["--threshold", "-0.1"], "threshold = -0.1 is out of range"),
        (vec!["--threshold", "nan"], "threshold = NaN is out of range"),
        (vec!["--palette", "rainbow"], "possible values: colour, paper"),
        (vec!["--pgn", "x.png"], "unexpected argument '--pgn'"),
        (vec!["--png", "/"], "cannot write /"),
    ] {
        sweep(&dir, &scene, &flags).code(2).stderr(contains(message));
        assert_eq!(dir.names("."), ["scene.toml"]);
    }
    sweep(&dir, &dir.path("missing.toml"), &[]).code(2).stderr(contains("cannot read scene"));
    let twice = dir.scene(&format!("{SCENE}\nthreshold = 0.1"));
    sweep(&dir, &twice, &["--threshold", "0.1"]).code(2).stderr(contains("threshold is given twice"));
    mapgen(&[]).args(["sweep", "x.toml"]).assert().code(2).stderr(contains("--out"));
    mapgen(&[]).assert().code(2).stderr(contains("Usage"));
    mapgen(&[]).arg("--help").assert().success().stdout(contains("sweep").and(contains("orbit")));
}

#[test]
fn a_ring_that_nothing_holds_is_swept_with_a_force() {
    let dir = TestDir::new();
    let text = forced().replace("gamma1 = 0.2", "gamma1 = 0.0").replace("from = 0.0, to = 0.3", "from = 0.1, to = 0.3");
    sweep(&dir, &dir.scene(&text), &[]).success();
    let table = rows(&dir.path("map.csv"));
    assert!(table.iter().all(|row| &row[7] == "ok"));
    assert!(table.iter().filter(|row| &row[6] == "2").count() > 100);
}

/// The line on breathers that grow slowly counts what the table has, computed in one go or read back from chunks.
#[test]
fn a_forced_map_tells_how_much_of_it_grows_slowly() {
    let dir = TestDir::new();
    dir.scene(
        &SCENE
            .replace("[sweep]", "amplitude = 0.1\nrestitution = 0.9\n[sweep]")
            .replace("points = 40", "points = 9")
            .replace("points = 30", "points = 7"),
    );
    let whole = dir.run("sweep scene.toml --out map.csv").with(0, &[]).err;
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    let merged = dir.run("merge parts --out again.csv").with(0, &[]).err;
    let (mut unstable, mut slow) = (0, 0);
    for row in csv::Reader::from_path(dir.path("map.csv")).unwrap().records().map(Result::unwrap) {
        if row[2].starts_with("unstable") {
            unstable += 1;
            slow += u32::from(row[4].parse::<f64>().unwrap() < 1.01);
        }
    }
    assert!(slow > 0 && slow < unstable, "{slow} of {unstable}");
    let told = format!(
        "\n{slow} of the {unstable} unstable cells grow by less than 1 % a period: --threshold 0.01 calls them stable\n"
    );
    assert!(whole.contains(&told) && merged.contains(&told), "{told}{whole}{merged}");
    let lenient = dir.run("sweep scene.toml --out map.csv --threshold .01").with(0, &[]).err;
    assert!(!lenient.contains("calls them stable"), "{lenient}");
}
