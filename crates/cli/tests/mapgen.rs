//! The program as its users meet it.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::fs;
use std::path::Path;

use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;
use vibrochain_testkit::{Desk, mapgen, written};

const SCENE: &str = r#"
[model]
sites = 11
gamma1 = 0.2
asymmetry = 0.4
[sweep]
x = { parameter = "omega", from = 0.4, to = 3.0, points = 40 }
y = { parameter = "gamma2", from = 0.0, to = 0.3, points = 30 }
[compute]
families = ["double-sided", "single-sided"]
stability = true
"#;

fn sweep(desk: &Desk, scene: &Path, flags: &[&str]) -> assert_cmd::assert::Assert {
    mapgen(&["sweep"]).arg(scene).arg("--out").arg(desk.path("map.csv")).args(flags).assert()
}

#[test]
fn a_sweep_writes_table_manifest_and_pictures_and_nothing_else() {
    let desk = Desk::new();
    let scene = desk.scene(SCENE);
    let (png, svg) = (desk.path("map.png"), desk.path("map.svg"));
    let flags = ["--png", png.to_str().unwrap(), "--svg", svg.to_str().unwrap()];
    sweep(&desk, &scene, &flags).success().stdout("").stderr(contains("1200 cells").and(contains("worst residual")));
    assert_eq!(desk.names("."), ["map.csv", "map.manifest.json", "map.png", "map.svg", "scene.toml"]);

    let mut table = csv::Reader::from_path(desk.path("map.csv")).unwrap();
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

    let manifest = desk.json("map.manifest.json");
    assert_eq!((&manifest["cells"], &manifest["model"]["sites"]), (&1200.into(), &11.into()));
    assert_eq!(manifest["sweep"]["x"]["parameter"], "omega");
    assert!(manifest["wall_seconds"].as_f64().unwrap() > 0.0 && manifest["version"].is_string());
    let counted: u64 = manifest["classes"].as_object().unwrap().values().map(|count| count.as_u64().unwrap()).sum();
    assert_eq!(counted, 1200);

    assert!(fs::read(png).unwrap().starts_with(b"\x89PNG"));
    let svg = fs::read_to_string(svg).unwrap();
    assert!(svg.contains("γ₂") && svg.contains("stable double-sided") && svg.contains("pixelated"));
}

/// The scene with the paper's force.
fn forced() -> String {
    SCENE.replace("sites = 11", "sites = 11\nforcing = { amplitude = 0.1, restitution = 0.9 }")
}

/// What a manifest says of its scene is the scene; and its model may be pasted into one.
#[test]
fn a_manifest_is_a_scene() {
    let desk = Desk::new();
    let harmonics = "force = [{ harmonic = 1, amplitude = 0.1 }, { harmonic = 3, amplitude = 0.02, phase = 1.0 }]";
    let small = |text: &str| text.replace("points = 40", "points = 7").replace("points = 30", "points = 3");
    let harmonics = format!("sites = 11\n{harmonics}\nrestitution = 0.9");
    let third = SCENE.replace(
        "points = 30 }",
        "points = 30, spacing = 'linear' }\naxes = [{ parameter = 'amplitude', values = [0.1, 0.2] }]",
    );
    let third = third.replace("asymmetry = 0.4", "asymmetry = 0.4\nrestitution = 0.8");
    for text in [SCENE.to_owned(), forced(), SCENE.replace("sites = 11", &harmonics), third] {
        sweep(&desk, &desk.scene(&small(&text)), &["--threshold", "1e-3"]).success();
        let manifest = desk.path("map.manifest.json");
        let (table, first) = (fs::read(desk.path("map.csv")).unwrap(), fs::read(&manifest).unwrap());
        fs::write(desk.path("again.json"), first).unwrap();
        mapgen(&["sweep"]).arg(desk.path("again.json")).arg("--out").arg(desk.path("again.csv")).assert().success();
        assert_eq!(fs::read(desk.path("again.csv")).unwrap(), table, "{text}");
        // The model alone, as `key = value`.
        let manifest = written(fs::read(manifest).unwrap());
        let line = |(key, value): (&String, &Value)| format!("{key} = {}\n", value.to_string().replace("\":", "\"="));
        let model: String = manifest["model"].as_object().unwrap().iter().map(line).collect();
        let text = small(&text);
        let sweep_part = &text[text.find("[sweep]").unwrap()..];
        sweep(&desk, &desk.scene(&format!("[model]\n{model}{sweep_part}")), &["--threshold", "1e-3"]).success();
        assert_eq!(fs::read(desk.path("map.csv")).unwrap(), table, "{model}");
    }
}

#[test]
fn threads_do_not_change_a_byte() {
    let desk = Desk::new();
    let scene = desk.scene(&forced());
    let tables = ["1", "2", "3"].map(|threads| {
        sweep(&desk, &scene, &["--threads", threads]).success();
        fs::read(desk.path("map.csv")).unwrap()
    });
    assert!(tables[0].len() > 1200 * 20 && tables[0] == tables[1] && tables[1] == tables[2]);
}

#[test]
fn existence_alone_has_classes_without_a_word_on_stability() {
    let desk = Desk::new();
    let scene = desk.scene(&SCENE.replace("stability = true", ""));
    sweep(&desk, &scene, &["--quiet"]).success().stderr("");
    let text = fs::read_to_string(desk.path("map.csv")).unwrap();
    assert!(text.contains(",double,,,") && text.contains(",single,,,") && !text.contains("stable"));
}

#[test]
fn other_axes_have_columns_of_their_own() {
    let desk = Desk::new();
    let text = SCENE
        .replace("asymmetry = 0.4", "asymmetry = 0.4\ngamma2 = 0.1\nomega = 1.5\nforcing = {}")
        .replace(r#""omega", from = 0.4, to = 3.0"#, r#""restitution", from = 0.2, to = 1.0"#)
        .replace(r#""gamma2", from = 0.0"#, r#""amplitude", from = 0.05"#);
    let scene = desk.scene(&text);
    sweep(&desk, &scene, &[]).success();
    let text = fs::read_to_string(desk.path("map.csv")).unwrap();
    assert!(text.starts_with("gamma2,omega,amplitude,restitution,class,"));
    assert!(text.lines().nth(1).unwrap().starts_with("0.1,1.5,0.05,0.2,"));
}

#[test]
fn a_cell_on_a_resonance_is_marked_and_the_sweep_goes_on() {
    let desk = Desk::new();
    // Ω₀ = 0.5 is met by ω = 0.5 and by its half.
    let text = SCENE
        .replace("gamma1 = 0.2", "gamma1 = 0.25")
        .replace("from = 0.4, to = 3.0, points = 40", "from = 0.25, to = 1.0, points = 4");
    let scene = desk.scene(&text);
    sweep(&desk, &scene, &[]).success().stderr(contains("status resonance"));
    let text = fs::read_to_string(desk.path("map.csv")).unwrap();
    assert!(text.lines().filter(|line| line.ends_with(",none,,,,0,resonance")).count() >= 60);
    assert!(text.lines().any(|line| line.ends_with(",ok")));
}

#[test]
fn a_threshold_makes_weak_growth_count_as_stable() {
    let desk = Desk::new();
    let scene = desk.scene(&forced());
    let count = |flags: &[&str]| {
        sweep(&desk, &scene, flags).success();
        fs::read_to_string(desk.path("map.csv")).unwrap().matches(",stable-double,").count()
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
        (r#""omega","#, r#""omga","#.into(), "`omga` cannot be swept: give one of gamma1"),
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
        let desk = Desk::new();
        assert!(SCENE.contains(from));
        let scene = desk.scene(&SCENE.replacen(from, &to, 1));
        sweep(&desk, &scene, &[]).code(2).stdout("").stderr(contains(message).and(contains("scene.toml:")));
        assert_eq!(desk.names("."), ["scene.toml"], "{message}");
    }
}

#[test]
fn wrong_sweep_flags() {
    let desk = Desk::new();
    let scene = desk.scene(SCENE);
    for (flags, message) in [
        (vec!["--threads", "0"], "out of range: give a whole number from 1 to 1024"),
        (vec!["--threads", "two"], "invalid value 'two' for '--threads <N>': not a whole number"),
        (vec!["--threshold", "-0.1"], "threshold = -0.1 is out of range"),
        (vec!["--threshold", "nan"], "threshold = NaN is out of range"),
        (vec!["--palette", "rainbow"], "possible values: colour, paper"),
        (vec!["--pgn", "x.png"], "unexpected argument '--pgn'"),
        (vec!["--png", "/"], "cannot write /"),
    ] {
        sweep(&desk, &scene, &flags).code(2).stderr(contains(message));
        assert_eq!(desk.names("."), ["scene.toml"]);
    }
    sweep(&desk, &desk.path("missing.toml"), &[]).code(2).stderr(contains("cannot read scene"));
    let twice = desk.scene(&format!("{SCENE}\nthreshold = 0.1"));
    sweep(&desk, &twice, &["--threshold", "0.1"]).code(2).stderr(contains("threshold is given twice"));
    mapgen(&[]).args(["sweep", "x.toml"]).assert().code(2).stderr(contains("--out"));
    mapgen(&[]).assert().code(2).stderr(contains("Usage"));
    mapgen(&[]).arg("--help").assert().success().stdout(contains("sweep").and(contains("orbit")));
}

const POINT: [&str; 10] = ["--sites", "21", "--gamma1", ".2", "--gamma2", ".1", "--omega", "1.5", "--asymmetry", ".4"];

#[test]
fn wrong_orbit_flags() {
    for (family, change, value, message) in [
        ("double-sided", 1, "0", "sites = 0 is out of range"),
        ("double-sided", 1, "-4", "sites = -4 is out of range"),
        ("double-sided", 3, "-1", "gamma1 = -1 is out of range"),
        ("double-sided", 5, "inf", "gamma2 = inf is out of range"),
        ("double-sided", 7, "0", "omega = 0 is out of range"),
        ("double-sided", 9, "1", "asymmetry = 1 is out of range"),
        ("double", 9, ".4", "possible values: double-sided, single-sided, period-doubled"),
    ] {
        let mut point = POINT;
        point[change] = value;
        mapgen(&[])
            .args(["orbit", "--family", family])
            .args(point)
            .assert()
            .code(2)
            .stdout("")
            .stderr(contains(message));
    }
    let alone = ["orbit", "--family", "double-sided", "--amplitude", ".1"];
    mapgen(&[]).args(alone).args(POINT).assert().code(2).stderr(contains("--restitution"));
    let picture = ["orbit", "--family", "double-sided", "--plot", "orbit.gif"];
    mapgen(&[]).args(picture).args(POINT).assert().code(2).stderr(contains("end the name in .png, .svg or .pdf"));
}

fn orbit_json(family: &str, flags: &[&str]) -> Value {
    let output = mapgen(&[]).args(["orbit", "--json", "--family", family]).args(flags).assert().success();
    written(&output.get_output().stdout)
}

#[test]
fn a_force_of_several_harmonics() {
    let flags = |force: &'static str| [&POINT[..], &["--force", force, "--restitution", ".9"]].concat();
    // A plain cosine is the same to the byte, however it is given.
    let plain = [&POINT[..], &["--amplitude", ".1", "--restitution", ".9"]].concat();
    assert_eq!(orbit_json("double-sided", &flags("3:0,1:.1:0")), orbit_json("double-sided", &plain));
    let value = orbit_json("double-sided", &flags("1:.1,5:.02:1.57,3:-.033:0"));
    assert!(value["parameters"].get("amplitude").is_none());
    assert_eq!(
        value["parameters"]["force"],
        serde_json::json!([
            { "harmonic": 1, "amplitude": 0.1, "phase": 0.0 },
            { "harmonic": 3, "amplitude": -0.033, "phase": 0.0 },
            { "harmonic": 5, "amplitude": 0.02, "phase": 1.57 }
        ])
    );
    let solutions = value["solutions"].as_array().unwrap();
    assert!(!solutions.is_empty());
    assert!(solutions.iter().all(|solution| solution["residual"].as_f64().unwrap() < 1e-13));
    let text = ["orbit", "--family", "single-sided"];
    mapgen(&[]).args(text).args(flags("1:.1,3:.01:1")).assert().success().stdout(contains("force = 1:0.1:0,3:0.01:1,"));

    for (force, message) in [
        ("1:.1,2:.1", "harmonic = 2 is out of range: give an odd number"),
        ("1:.1,1:.2:1", "harmonic = 1 is out of range: give each harmonic of the force only once"),
        ("1", "`1` has not two or three parts: give number:amplitude:phase"),
        ("1:x", "`1:x` has an amplitude that is no number"),
        ("1.5:.1", "`1.5:.1` has no whole number in front"),
        ("1:nan", "harmonic amplitude = NaN is out of range"),
        ("1:.1:1e9", "harmonic phase = 1000000000 is out of range"),
        ("", "has not two or three parts"),
    ] {
        mapgen(&[]).args(text).args(flags(force)).assert().code(2).stdout("").stderr(contains(message));
    }
    let both = [&flags("1:.1")[..], &["--amplitude", ".1"]].concat();
    mapgen(&[]).args(text).args(both).assert().code(2).stderr(contains("cannot be used with"));
    let alone = [&POINT[..], &["--force", "1:.1"]].concat();
    mapgen(&[]).args(text).args(alone).assert().code(2).stderr(contains("--restitution"));
    // 3ω on the uniform mode.
    let resonant = ["--sites", "5", "--gamma1", "2.25", "--gamma2", ".1", "--omega", ".5", "--asymmetry", ".4"];
    let resonant = [&resonant[..], &["--force", "1:.1,3:.01", "--restitution", ".9"]].concat();
    mapgen(&[]).args(text).args(resonant).assert().code(3).stderr(contains("harmonic 3 of omega = 0.5 meets mode 0"));
}

#[test]
fn a_run_under_several_harmonics_stays_on_its_orbit() {
    let flags = [&POINT[..], &["--force", "1:.3,3:-.1,5:.06", "--restitution", ".9", "--periods", "4"]].concat();
    let run = mapgen(&[]).args(["simulate", "--family", "double-sided"]).args(flags).assert().success();
    let text = String::from_utf8(run.get_output().stdout.clone()).unwrap();
    let distance = text.split("largest distance from the orbit at the end: ").nth(1).unwrap().trim();
    assert!(distance.parse::<f64>().unwrap() < 1e-12, "{text}");
}

#[test]
fn a_scene_with_several_harmonics() {
    let desk = Desk::new();
    let with = |force: &str| {
        SCENE.replace("sites = 11", &format!("sites = 11\nforcing = {{ restitution = 0.9 }}\nforce = {force}"))
    };
    let table = |scene: &str, flags: &[&str]| {
        sweep(&desk, &desk.scene(scene), flags).success();
        fs::read(desk.path("map.csv")).unwrap()
    };
    // A plain cosine in a list gives the same table.
    let plain = table(&forced(), &[]);
    assert!(plain == table(&with("[{ harmonic = 1, amplitude = 0.1 }]"), &[]));
    let few = |scene: &str| scene.replace("points = 40", "points = 8").replace("points = 30", "points = 6");
    let square = few(&with("[{ harmonic = 1, amplitude = 0.1 }, { harmonic = 3, amplitude = -0.03, phase = 0.5 }]"));
    let picture = desk.path("map.svg");
    let one = table(&square, &["--threads", "1", "--svg", picture.to_str().unwrap()]);
    assert!(one == table(&square, &["--threads", "2"]) && one != table(&few(&forced()), &[]));
    assert!(String::from_utf8(one).unwrap().contains("-double,"));
    assert!(fs::read_to_string(picture).unwrap().contains("force 1:0.1:0,3:-0.03:0.5"));
    table(&square, &[]);
    let manifest = desk.json("map.manifest.json");
    assert_eq!(manifest["model"]["force"][1]["phase"], 0.5);
    assert!(manifest["model"].get("amplitude").is_none());
    // An amplitude on an axis has nothing to act on.
    let swept = square.replace(r#""gamma2", from = 0.0"#, r#""amplitude", from = 0.05"#);
    let swept = swept.replace("asymmetry = 0.4", "asymmetry = 0.4\ngamma2 = 0.1");
    sweep(&desk, &desk.scene(&swept), &[]).code(2).stderr(contains("amplitude and force are both given"));
}

#[test]
fn orbit_as_json() {
    let flags = [&POINT[..], &["--amplitude", ".1", "--restitution", ".9"]].concat();
    let value = orbit_json("double-sided", &flags);
    assert_eq!(value["parameters"]["sites"], 21);
    let solutions = value["solutions"].as_array().unwrap();
    assert_eq!(solutions.len(), 2);
    let first = &solutions[0];
    assert!((first["phi"].as_f64().unwrap() - 2.0771604154348533).abs() < 1e-12);
    assert_eq!((&first["physical"], &first["obstruction"]), (&true.into(), &Value::Null));
    let impacts = first["impacts"].as_array().unwrap();
    assert_eq!((&impacts[0]["barrier"], &impacts[1]["barrier"]), (&"upper".into(), &"lower".into()));
    assert!((impacts[1]["impulse"].as_f64().unwrap() - 2.0 * 1.0044655320312839).abs() < 1e-12);
    let stability = &first["stability"];
    assert_eq!((&stability["stable"], &stability["mechanism"]), (&false.into(), &"neimark-sacker".into()));
    let multipliers = stability["multipliers"].as_array().unwrap();
    assert_eq!(multipliers.len(), 42);
    let moduli: Vec<f64> = multipliers.iter().map(|m| m[0].as_f64().unwrap().hypot(m[1].as_f64().unwrap())).collect();
    assert!(moduli.windows(2).all(|pair| pair[0] >= pair[1] - 1e-12));
}

#[test]
fn an_orbit_list_says_how_it_is_known_to_be_complete() {
    let closed = orbit_json("single-sided", &POINT);
    assert_eq!(closed["completeness"], serde_json::json!({ "established": true, "by": "closed-form" }));
    let cosine = [&POINT[..], &["--amplitude", ".1", "--restitution", ".9"]].concat();
    let several = [&POINT[..], &["--force", "1:.1,3:.01:1", "--restitution", ".9"]].concat();
    for (flags, by, count) in [(&cosine, "enclosures", "intervals"), (&several, "branch-and-prune", "boxes")] {
        let value = &orbit_json("double-sided", flags)["completeness"];
        assert!(value["established"] == true && value["by"] == by && value[count].as_u64().unwrap() > 10, "{value}");
    }
    let text = ["orbit", "--family", "double-sided"];
    mapgen(&[]).args(text).args(cosine).assert().success().stdout(contains("the list is complete, by enclosures on "));
    mapgen(&[])
        .args(text)
        .args(several)
        .assert()
        .success()
        .stdout(contains("the list is complete, by branch and prune"));
    // Next to the resonance of the force more solutions crowd than can be searched.
    let mut crowded = POINT;
    crowded[7] = "0.4472136";
    let crowded = [&crowded[..], &["--amplitude", ".1", "--restitution", ".9"]].concat();
    let value = orbit_json("period-doubled", &crowded);
    assert_eq!(value["completeness"], serde_json::json!({ "established": false, "by": null }));
    assert!(value["exhausted"].as_u64().unwrap() > 0);
}

#[test]
fn no_orbit_is_an_answer_and_a_resonance_is_not() {
    let value = orbit_json("period-doubled", &POINT);
    assert!(value["solutions"].as_array().unwrap().is_empty());
    assert!(value["reason"].as_str().unwrap().contains("force"));
    let weak = [&POINT[..], &["--amplitude", "1e-6", "--restitution", ".5"]].concat();
    assert!(orbit_json("single-sided", &weak)["reason"].as_str().unwrap().contains("at least"));
    let mut resonant = POINT;
    (resonant[3], resonant[7]) = ("0.25", "0.25");
    let asked = mapgen(&[]).args(["orbit", "--family", "double-sided"]).args(resonant).assert();
    asked.code(3).stderr(contains("harmonic 2").and(contains("mode 0")));
    // A frequency so low that its harmonics cannot be told apart is not called a resonance.
    resonant[7] = "1e-100";
    let asked = mapgen(&[]).args(["orbit", "--family", "double-sided"]).args(resonant).assert();
    asked.code(3).stderr(contains("too small against mode").and(contains("raise omega")));
}

#[test]
fn an_orbit_that_is_not_physical_says_where_when_and_by_how_much() {
    let mut point = POINT;
    point[7] = "0.42";
    let value = orbit_json("double-sided", &point);
    let obstruction = &value["solutions"][0]["obstruction"];
    assert_eq!(
        (&obstruction["kind"], &obstruction["site"], &obstruction["barrier"]),
        (&"crossing".into(), &0.into(), &"lower".into())
    );
    assert!((obstruction["excess"].as_f64().unwrap() - 2.0664391).abs() < 1e-6);
    assert!((obstruction["time"].as_f64().unwrap() - 10.781921).abs() < 1e-5);
    assert!(obstruction["message"].as_str().unwrap().contains("beyond the lower barrier at t = 10.78"));
    assert_eq!(value["solutions"][1]["obstruction"]["kind"], "wrong-sign");
    assert!(value["solutions"][0]["margin"].as_f64().unwrap() < -2.0);
}

/// Its polynomials overflowed, and intervals without a verdict were halved for ever.
#[test]
fn a_frequency_of_1e50_does_not_hang_the_check_of_an_orbit() {
    let margins = |omega: &'static str| {
        let mut point = POINT;
        point[7] = omega;
        let flags = [&point[..], &["--amplitude", ".05", "--restitution", "1"]].concat();
        let value = orbit_json("double-sided", &flags);
        let solutions = value["solutions"].as_array().unwrap().clone();
        assert!(solutions.len() == 2 && solutions.iter().all(|solution| solution["physical"] == true), "{omega}");
        solutions.iter().map(|solution| solution["margin"].as_f64().unwrap()).collect::<Vec<_>>()
    };
    // Between its barriers the mass flies straight: only the clock tells one frequency from the other.
    for (usual, enormous) in margins("1e6").iter().zip(margins("1e50")) {
        assert!((usual - enormous).abs() < 1e-9, "{usual} {enormous}");
    }
}

/// Squares of the matrix overflowed, and the answer said `"resolution": null`.
#[test]
fn a_monodromy_matrix_next_to_grazing_is_refused_not_half_answered() {
    let mut point = POINT;
    (point[3], point[7], point[9]) = ("2.3e-308", "0.92", "0.7");
    let run = mapgen(&[])
        .args(["orbit", "--json", "--family", "single-sided", "--amplitude", ".05", "--restitution", ".9"])
        .args(point)
        .assert()
        .code(1)
        .stderr(contains("beyond the range of numbers"));
    let value = written(&run.get_output().stdout);
    let first = &value["solutions"][0];
    assert!(first["stability"].is_null() && first["stability_error"].as_str().unwrap().contains("grazing"));
}

/// Masses without coupling: pairs that meet on the real axis were read as complex, with the root of a negative number.
#[test]
fn multipliers_of_uncoupled_masses_are_all_numbers() {
    for (sites, omega, asymmetry, amplitude) in [("8", ".42", "0.07824865504923947", "1e-30"), ("7", "0.051", "0", "0")]
    {
        let flags = ["--sites", sites, "--gamma1", ".2", "--gamma2", "0", "--omega", omega, "--asymmetry", asymmetry];
        let value =
            orbit_json("double-sided", &[&flags[..], &["--amplitude", amplitude, "--restitution", "1"]].concat());
        let solutions = value["solutions"].as_array().unwrap();
        assert!(!solutions.is_empty());
        for solution in solutions {
            let multipliers = solution["stability"]["multipliers"].as_array().unwrap();
            assert_eq!(multipliers.len(), 2 * sites.parse::<usize>().unwrap());
            assert!(multipliers.iter().all(|m| m[0].is_f64() && m[1].is_f64()), "{multipliers:?}");
        }
    }
}

#[test]
fn orbit_pictures() {
    let desk = Desk::new();
    for name in ["orbit.png", "orbit.svg"] {
        let path = desk.path(name);
        mapgen(&[]).args(["orbit", "--family", "double-sided", "--plot"]).arg(&path).args(POINT).assert().success();
        assert!(fs::metadata(path).unwrap().len() > 5000);
    }
    assert!(fs::read_to_string(desk.path("orbit.svg")).unwrap().contains("impacting mass"));
}

/// Rows of a CSV file.
fn rows(path: &Path) -> Vec<csv::StringRecord> {
    csv::Reader::from_path(path).unwrap().records().map(Result::unwrap).collect()
}

#[test]
fn a_simulation_from_an_orbit_stays_on_it_and_writes_events_and_trajectory() {
    let desk = Desk::new();
    let (impacts, trajectory, plot) = (desk.path("impacts.csv"), desk.path("trajectory.csv"), desk.path("run.png"));
    let simulate = mapgen(&[])
        .args(["simulate", "--family", "double-sided", "--periods", "10", "--samples", "16"])
        .args(POINT)
        .arg("--impacts")
        .arg(&impacts)
        .arg("--trajectory")
        .arg(&trajectory)
        .arg("--plot")
        .arg(&plot)
        .assert()
        .success();
    let text = String::from_utf8(simulate.get_output().stdout.clone()).unwrap();
    assert!(text.contains("10.000000 periods, 20 impacts\noutcome: it stays on the breather\n"), "{text}");
    let distance: f64 = text.lines().last().unwrap().rsplit(' ').next().unwrap().parse().unwrap();
    assert!(distance < 1e-12, "{text}");
    let header = "time,site,barrier,velocity_before,velocity_after,kind";
    assert!(fs::read_to_string(&impacts).unwrap().starts_with(header));
    let events = rows(&impacts);
    assert_eq!(events.len(), 20);
    let half = std::f64::consts::PI / 1.5;
    for (i, event) in events.iter().enumerate() {
        assert!((event[0].parse::<f64>().unwrap() - i as f64 * half).abs() < 1e-12);
        assert_eq!((&event[1], &event[2], &event[5]), ("0", ["upper", "lower"][i % 2], "impact"));
    }
    let samples = rows(&trajectory);
    assert_eq!((samples.len(), samples[0].len()), (161, 43));
    assert!(
        (samples[160][0].parse::<f64>().unwrap() - samples[0][0].parse::<f64>().unwrap() - 20.0 * half).abs() < 1e-12
    );
    assert!(fs::read(plot).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn perturbations_are_repeatable_and_an_unstable_one_grows() {
    let mut point = POINT;
    point[7] = "0.93";
    let end = |flags: &[&str]| {
        let run = mapgen(&[])
            .args(["simulate", "--family", "single-sided", "--perturb", "1e-8"])
            .args(point)
            .args(flags)
            .assert();
        let text = String::from_utf8(run.success().get_output().stdout.clone()).unwrap();
        text.lines().last().unwrap().rsplit(' ').next().unwrap().parse::<f64>().unwrap()
    };
    // 1.0045³⁰⁰⁰ would be 800 000.
    let unstable = end(&["--direction", "unstable", "--periods", "1000"]);
    assert!((5e-7..2e-6).contains(&unstable), "{unstable}");
    let random = end(&["--seed", "7", "--periods", "30"]);
    assert!(random > 1e-9 && random == end(&["--seed", "7", "--periods", "30"]));
    assert!(random != end(&["--seed", "8", "--periods", "30"]));
}

const SMALL: [&str; 10] = ["--sites", "5", "--gamma1", ".2", "--gamma2", ".1", "--omega", ".4", "--asymmetry", ".4"];

#[test]
fn a_simulation_from_a_state_meets_sticking_and_stops_where_it_is_told() {
    let desk = Desk::new();
    let (state, impacts) = (desk.path("state.json"), desk.path("impacts.csv"));
    fs::write(&state, r#"{"displacement":[0,0,0,0,0],"velocity":[0.5,0,0,0,0]}"#).unwrap();
    let run = |flags: &[&str]| {
        let mut command = mapgen(&[]);
        command.arg("simulate").arg("--state").arg(&state).args(SMALL).args([
            "--amplitude",
            "1.5",
            "--restitution",
            ".3",
        ]);
        command.arg("--impacts").arg(&impacts).args(flags).assert()
    };
    run(&["--periods", "1"]).success().stdout(contains("6 rests on a barrier"));
    let events = rows(&impacts);
    let stick = events.iter().find(|event| &event[5] == "stick").unwrap();
    assert!((stick[0].parse::<f64>().unwrap() - 3.357911538886231).abs() < 1e-8 && &stick[1] == "0");
    run(&["--periods", "1", "--max-impacts", "3"]).success().stdout(contains("number of impacts reached"));
    assert_eq!(rows(&impacts).len(), 3);
}

#[test]
fn a_cascade_without_end_is_told_and_what_was_simulated_is_kept() {
    let desk = Desk::new();
    let (state, impacts) = (desk.path("state.json"), desk.path("impacts.csv"));
    // Pressed against the upper barrier by the force, with elastic impacts.
    fs::write(&state, r#"{"displacement":[1.4],"velocity":[-1e-9]}"#).unwrap();
    let flags = ["--sites", "1", "--gamma1", ".2", "--gamma2", "0", "--omega", ".4", "--asymmetry", ".4"];
    let mut command = mapgen(&[]);
    command.arg("simulate").arg("--state").arg(&state).args(flags).args(["--amplitude", "1.5", "--restitution", "1"]);
    let run = command.arg("--impacts").arg(&impacts).args(["--periods", "1"]).assert();
    run.code(1).stderr(contains("cascade").and(contains("restitution below 1")));
    assert!(rows(&impacts).len() > 1000);
}

#[test]
fn wrong_simulations() {
    let desk = Desk::new();
    let state = desk.path("state.json");
    for (text, message) in [
        (r#"{"displacement":[0,0,0,0],"velocity":[0,0,0,0,0]}"#, "displacement"),
        (r#"{"displacement":[0,0,0,0,2],"velocity":[0,0,0,0,0]}"#, "site 4"),
        (r#"{"displacement":[0,0,0,0,0]}"#, "the key `velocity` is missing"),
        (r#"{"displacement":[0,0,0,0,0],"velocity":[0,0,0,0,0],"time":3}"#, "unknown key `time`"),
        (r#"{"displacement":[0,0,0,0,null],"velocity":[0,0,0,0,0]}"#, "one number a mass"),
        ("", "state.json"),
    ] {
        fs::write(&state, text).unwrap();
        mapgen(&[]).arg("simulate").arg("--state").arg(&state).args(SMALL).assert().code(2).stderr(contains(message));
    }
    for (flags, message) in [
        (vec![], "--family"),
        (vec!["--family", "single"], "possible values"),
        (vec!["--family", "double-sided", "--samples", "0"], "--samples 0 is out of range"),
        (vec!["--family", "double-sided", "--seed", "3"], "--perturb"),
        (vec!["--family", "double-sided", "--perturb", "inf"], "--perturb inf is out of range"),
        (vec!["--family", "double-sided", "--perturb", "5"], "beyond its upper barrier"),
        (vec!["--family", "double-sided", "--solution", "7"], "--solution 7 is out of range"),
        (vec!["--family", "double-sided", "--periods", "-1"], "--periods -1 is out of range: give a number from 0"),
        (vec!["--family", "double-sided", "--perturb", "1e-3", "--direction", "unstable"], "this breather is stable"),
        (vec!["--family", "double-sided", "--periods", "288230376151711744"], "give at most"),
        (vec!["--family", "double-sided", "--plot", "run.jpg"], "end the name in .png, .svg or .pdf"),
    ] {
        mapgen(&[]).arg("simulate").args(POINT).args(&flags).assert().code(2).stdout("").stderr(contains(message));
    }
    mapgen(&[])
        .args(["simulate", "--state", "missing.json"])
        .args(SMALL)
        .assert()
        .code(2)
        .stderr(contains("cannot read"));
}

#[test]
fn studies_are_named_where_they_went() {
    for line in ["figures --out figures", "errata", "accuracy --quick", "validate --help"] {
        let words = contains("are studies").and(contains("cargo run --locked --release -p vibrochain-studies"));
        mapgen(&line.split(' ').collect::<Vec<_>>()).assert().code(2).stdout("").stderr(words);
    }
}

#[test]
fn no_file_may_have_two_uses() {
    let desk = Desk::new();
    let scene = desk.scene(SCENE);
    let same = desk.path("map.csv");
    sweep(&desk, &scene, &["--png", same.to_str().unwrap()])
        .code(2)
        .stderr(contains("--out and --png are the same file"));
    let manifest = desk.path("map.manifest.json");
    sweep(&desk, &scene, &["--svg", manifest.to_str().unwrap()])
        .code(2)
        .stderr(contains("the manifest of --out and --svg"));
    let onto = mapgen(&[]).arg("sweep").arg(&scene).arg("--out").arg(&scene).assert();
    onto.code(2).stderr(contains("the scene and --out are the same file"));
    assert_eq!(desk.names("."), ["scene.toml"]);
    let table = desk.path("table.csv");
    let mut command = mapgen(&[]);
    command
        .args(["simulate", "--family", "double-sided"])
        .args(POINT)
        .arg("--impacts")
        .arg(&table)
        .arg("--trajectory")
        .arg(&table);
    command.assert().code(2).stderr(contains("--impacts and --trajectory are the same file"));
}

#[test]
fn nothing_to_plot_does_not_hide_the_answer() {
    let desk = Desk::new();
    let plot = desk.path("orbit.png");
    let run =
        mapgen(&[]).args(["orbit", "--family", "period-doubled", "--json", "--plot"]).arg(&plot).args(POINT).assert();
    run.success().stdout(contains("\"solutions\": []")).stderr(contains("nothing to plot"));
    assert!(desk.names(".").is_empty());
}

#[test]
fn a_ring_that_nothing_holds_is_swept_with_a_force() {
    let desk = Desk::new();
    let text = forced().replace("gamma1 = 0.2", "gamma1 = 0.0").replace("from = 0.0, to = 0.3", "from = 0.1, to = 0.3");
    sweep(&desk, &desk.scene(&text), &[]).success();
    let table = rows(&desk.path("map.csv"));
    assert!(table.iter().all(|row| &row[7] == "ok"));
    assert!(table.iter().filter(|row| &row[6] == "2").count() > 100);
}

#[cfg(unix)]
#[test]
fn an_interrupted_simulation_keeps_what_it_has_however_long_a_period_is() {
    let desk = Desk::new();
    let (state, impacts) = (desk.path("state.json"), desk.path("impacts.csv"));
    fs::write(&state, r#"{"displacement":[0,0,0,0,0],"velocity":[1,1,1,1,1]}"#).unwrap();
    let mut arguments: Vec<_> = SMALL.to_vec();
    arguments[7] = "1e-50";
    let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin("mapgen"));
    command.arg("simulate").arg("--state").arg(&state).arg("--impacts").arg(&impacts).args(arguments);
    command.args(["--max-impacts", "9000000000000000000"]);
    let mut child = command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null()).spawn().unwrap();
    while desk.names(".").len() < 2 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert!(std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(desk.names("."), ["impacts.csv", "state.json"]);
    assert!(rows(&impacts).len() > 100);
}

#[test]
fn two_masses_have_two_springs_and_one_needs_none() {
    let desk = Desk::new();
    let of = |chain: &str| desk.run(&format!("orbit --family double-sided {chain} --omega 1.5 --asymmetry .4"));
    let two = "a ring of two masses has two springs of gamma2 between them";
    of("--sites 2 --gamma1 .2 --gamma2 .1").with(0, &[two]);
    for chain in [
        "--sites 2 --gamma1 .2 --gamma2 .1 --ends free",
        "--sites 2 --gamma1 .2 --gamma2 0",
        "--sites 3 --gamma1 .2 --gamma2 .1",
    ] {
        assert_eq!(of(chain).with(0, &[]).err, "", "{chain}");
    }
    desk.scene(&SCENE.replace("sites = 11", "sites = 2"));
    desk.run("sweep scene.toml --out map.csv").with(0, &[two]);
    // A mass alone has no neighbour: the coupling means nothing.
    let answers = ["0", "1"].map(|gamma2| {
        let mut answer: Vec<String> = Vec::new();
        for family in ["double-sided", "single-sided"] {
            for force in ["", " --amplitude .3 --restitution .9"] {
                let line = format!(
                    "orbit --family {family} --sites 1 --gamma1 0 --gamma2 {gamma2} --omega 1.5 --asymmetry .4{force}"
                );
                answer.push(desk.run(&line).with(0, &[]).out.replace("gamma2 = 1", "gamma2 = 0").replace(',', " "));
            }
        }
        answer
    });
    for (one, other) in answers[0].iter().zip(&answers[1]) {
        let alike = |one: &str, other: &str| match (one.parse::<f64>(), other.parse::<f64>()) {
            (Ok(one), Ok(other)) => (one - other).abs() < 1e-9,
            _ => one == other || one.ends_with('i'),
        };
        assert!(
            one.split_whitespace().zip(other.split_whitespace()).all(|(one, other)| alike(one, other)),
            "{one}{other}"
        );
        assert_eq!(one.lines().count(), other.lines().count());
    }
    assert!(answers[0].iter().any(|answer| answer.contains("1 physical")), "{answers:?}");
    of("--sites 2 --gamma1 0 --gamma2 0").with(2, &["give a positive gamma1 or gamma2"]);
}

/// The line on breathers that grow slowly counts what the table has, computed in one go or read back from chunks.
#[test]
fn a_forced_map_tells_how_much_of_it_grows_slowly() {
    let desk = Desk::new();
    desk.scene(
        &SCENE
            .replace("[sweep]", "amplitude = 0.1\nrestitution = 0.9\n[sweep]")
            .replace("points = 40", "points = 9")
            .replace("points = 30", "points = 7"),
    );
    let whole = desk.run("sweep scene.toml --out map.csv").with(0, &[]).err;
    desk.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    let merged = desk.run("merge parts --out again.csv").with(0, &[]).err;
    let (mut unstable, mut slow) = (0, 0);
    for row in csv::Reader::from_path(desk.path("map.csv")).unwrap().records().map(Result::unwrap) {
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
    let lenient = desk.run("sweep scene.toml --out map.csv --threshold .01").with(0, &[]).err;
    assert!(!lenient.contains("calls them stable"), "{lenient}");
}
