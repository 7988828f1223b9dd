//! Forces of several harmonics.

use std::fs;

use predicates::str::contains;
use vibrochain_testkit::{TestDir, mapgen};

use crate::asked::{POINT, SCENE, forced, orbit_json, sweep};

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
    let dir = TestDir::new();
    let with = |force: &str| {
        SCENE.replace("sites = 11", &format!("sites = 11\nforcing = {{ restitution = 0.9 }}\nforce = {force}"))
    };
    let table = |scene: &str, flags: &[&str]| {
        sweep(&dir, &dir.scene(scene), flags).success();
        fs::read(dir.path("map.csv")).unwrap()
    };
    // A plain cosine in a list gives the same table.
    let plain = table(&forced(), &[]);
    assert!(plain == table(&with("[{ harmonic = 1, amplitude = 0.1 }]"), &[]));
    let few = |scene: &str| scene.replace("points = 40", "points = 8").replace("points = 30", "points = 6");
    let square = few(&with("[{ harmonic = 1, amplitude = 0.1 }, { harmonic = 3, amplitude = -0.03, phase = 0.5 }]"));
    let picture = dir.path("map.svg");
    let one = table(&square, &["--threads", "1", "--svg", picture.to_str().unwrap()]);
    assert!(one == table(&square, &["--threads", "2"]) && one != table(&few(&forced()), &[]));
    assert!(String::from_utf8(one).unwrap().contains("-double,"));
    assert!(fs::read_to_string(picture).unwrap().contains("force 1:0.1:0,3:-0.03:0.5"));
    table(&square, &[]);
    let manifest = dir.json("map.manifest.json");
    assert_eq!(manifest["model"]["force"][1]["phase"], 0.5);
    assert!(manifest["model"].get("amplitude").is_none());
    // An amplitude on an axis has nothing to act on.
    let swept = square.replace(r#""gamma2", from = 0.0"#, r#""amplitude", from = 0.05"#);
    let swept = swept.replace("asymmetry = 0.4", "asymmetry = 0.4\ngamma2 = 0.1");
    sweep(&dir, &dir.scene(&swept), &[]).code(2).stderr(contains("amplitude and force are both given"));
}
