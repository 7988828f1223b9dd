//! Orbits, runs and lines are what the program prints.

use std::fs;

use serde_json::{Map, Value, json};
use vibrochain_testkit::written;

use crate::served::{Served, scene};

pub(crate) const MODEL: &str = "--sites 6 --gamma1 0.2 --gamma2 0.15 --omega 1.6 --asymmetry 0.4";
const FORCED: &str =
    "--sites 5 --gamma1 0.2 --gamma2 0.1 --omega 1.5 --asymmetry 0.4 --amplitude 0.1 --restitution 0.9";
pub(crate) const HARMONICS: &str =
    "--sites 5 --gamma1 0.2 --gamma2 0.1 --omega 1.5 --asymmetry 0.4 --force 1:0.1:0,3:-0.033:0 --restitution 0.9";
const LAYERS: &str =
    "--sites 6 --ends free --layers 2 --gamma1 0.2 --gamma2 0.05 --gamma3 0.05 --omega 1.5 --asymmetry 0.2";

/// The model that flags give, as the page has it.
pub(crate) fn model(flags: &str) -> Map<String, Value> {
    let words: Vec<&str> = flags.split(' ').collect();
    let pair = |pair: &[&str]| {
        let value = match pair[0] {
            "--force" => {
                json!([{ "harmonic": 1, "amplitude": 0.1, "phase": 0.0 }, { "harmonic": 3, "amplitude": -0.033 }])
            }
            "--sites" | "--layers" => pair[1].parse::<u64>().unwrap().into(),
            _ => pair[1].parse::<f64>().map_or_else(|_| pair[1].into(), Value::from),
        };
        (pair[0][2..].to_owned(), value)
    };
    words.chunks(2).map(pair).collect()
}

#[test]
fn an_orbit_is_what_mapgen_orbit_prints() {
    let served = Served::new("");
    let mut solutions = 0;
    for (flags, which) in [
        (MODEL, "double-sided"),
        (MODEL, "single-sided"),
        (FORCED, "double-sided"),
        (HARMONICS, "double-sided"),
        (FORCED, "period-doubled"),
        (LAYERS, "0:0+0:1+,0:0-0:1-"),
        (MODEL, "0+3+,0-3-"),
    ] {
        let asked = json!({ "model": model(flags), "which": which, "samples": 16 });
        let answer = served.post("orbit", &asked);
        assert_eq!(answer.code, 200, "{answer:?}");
        let answer = answer.json();
        let flag = if which.contains('+') { "--word" } else { "--family" };
        let printed = served.dir.run(&format!("orbit {flag} {which} {flags} --json --trajectory own.csv --samples 16"));
        assert_eq!(answer["answer"], written(&printed.out), "{flags} {which}");
        assert_eq!(answer["files"]["orbit.csv"].as_str().unwrap().as_bytes(), served.dir.read("own.csv"));
        // And so does the line that it says.
        let line = answer["command"].as_str().unwrap();
        let again = served.dir.shell(line).with(0, &[]);
        assert_eq!(again.out, printed.out, "{line}");
        assert_eq!(answer["python"].as_array().unwrap().len(), answer["answer"]["solutions"].as_array().unwrap().len());
        solutions += answer["python"].as_array().unwrap().len();
    }
    assert!(solutions >= 8, "{solutions}");
}

#[test]
fn a_run_is_what_mapgen_simulate_prints() {
    let served = Served::new("");
    for (perturb, direction) in [(0.0, "random"), (1e-3, "random"), (1e-4, "unstable")] {
        let asked = json!({
            "model": model(FORCED), "which": "double-sided", "samples": 8, "solution": 1,
            "perturb": perturb, "direction": direction, "seed": 5, "periods": 12.5,
        });
        let answer = served.post("simulate", &asked);
        assert_eq!(answer.code, 200, "{answer:?}");
        let answer = answer.json();
        let pushed = if perturb == 0.0 {
            String::new()
        } else {
            format!("--perturb {perturb} --direction {direction} --seed 5 ")
        };
        let line = format!(
            "simulate --family double-sided {FORCED} --solution 1 {pushed}--periods 12.5 --samples 8 --json --trajectory a.csv --impacts b.csv"
        );
        let printed = served.dir.run(&line).with(0, &[]);
        assert_eq!(answer["answer"], written(&printed.out));
        for (own, name) in [("a.csv", "run.csv"), ("b.csv", "impacts.csv")] {
            assert_eq!(answer["files"][name].as_str().unwrap().as_bytes(), served.dir.read(own));
        }
        let again = served.dir.shell(answer["command"].as_str().unwrap()).with(0, &[]);
        assert_eq!(again.out, printed.out);
    }
    let endless = json!({
        "model": model(FORCED), "which": "double-sided", "samples": 64, "solution": 1,
        "perturb": 0.0, "direction": "random", "seed": 1, "periods": 1e9,
    });
    assert!(served.post("simulate", &endless).refused(400).contains("periods = 1000000000 is too many"));
    let stable = json!({
        "model": model("--sites 6 --gamma1 0.2 --gamma2 0.01 --omega 2.5 --asymmetry 0.4"), "which": "double-sided", "samples": 4,
        "solution": 1, "perturb": 1e-3, "direction": "unstable", "seed": 1, "periods": 3.0,
    });
    assert!(served.post("simulate", &stable).refused(400).contains("this breather is stable"));
}

#[test]
fn lines_pictures_and_tables_are_those_of_the_program() {
    let served = Served::new("");
    let mut scene = scene();
    for (axis, points) in [("x", 30), ("y", 20)] {
        scene["sweep"][axis]["points"] = points.into();
    }
    fs::write(served.dir.path("own.json"), scene.to_string()).unwrap();
    let sweep = served.post("sweep", &json!({ "scene": scene })).json();
    served.dir.run("sweep own.json --out own.csv --svg own.svg --quiet").with(0, &[]);
    assert_eq!(sweep["files"]["map.csv"].as_str().unwrap().as_bytes(), served.dir.read("own.csv"));
    assert_eq!(sweep["files"]["map.svg"].as_str().unwrap().as_bytes(), served.dir.read("own.svg"));

    let margin = served.post("sweep", &json!({ "scene": scene, "color": "margin" })).json();
    served.dir.run("sweep own.json --out own.csv --svg margin.svg --color margin --quiet").with(0, &[]);
    assert_eq!(margin["files"]["map.svg"].as_str().unwrap().as_bytes(), served.dir.read("margin.svg"));
    assert!(served.post("sweep", &json!({ "scene": scene, "color": "hue" })).refused(400).contains("hue"));

    let texts = served.post("texts", &json!({ "scene": scene })).json();
    fs::write(served.dir.path("view.toml"), texts["scene"].as_str().unwrap()).unwrap();
    served.dir.shell(texts["command"].as_str().unwrap()).with(0, &[]);
    assert_eq!(served.dir.read("map.csv"), served.dir.read("own.csv"));
    assert!(texts["python"].as_str().unwrap().contains("vc.sweep(\"view.toml\")"));

    let curves = served.post("curves", &json!({ "scene": scene, "tolerance": 1e-3, "places": 0 })).json();
    let printed = served.dir.run("curves own.json --json --tolerance 1e-3 --places 0");
    assert_eq!(curves["answer"], written(&printed.out));
    assert!(curves["answer"]["borders"].as_array().unwrap().len() > 3);

    scene["sweep"]["x"]["points"] = 100_000.into();
    assert!(served.post("sweep", &json!({ "scene": scene })).refused(400).contains("points = 100000 is out of range"));
}
