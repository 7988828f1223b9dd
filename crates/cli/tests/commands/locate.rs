//! `mapgen locate` as its users meet it.

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;
use vibrochain_testkit::{mapgen, written};

const DOUBLING: &str = "--family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .165 --restitution .25";
const FIGURE_9: &str =
    "--family double-sided --sites 21 --gamma1 .1 --gamma2 .05 --omega 1.33 --asymmetry 0 --amplitude 1.5";

fn locate(flags: &str, model: &str) -> Command {
    let mut command = mapgen(&["locate"]);
    command.args(flags.split(' ')).args(model.split(' '));
    command
}

fn answer(flags: &str, model: &str) -> Value {
    let output = locate(flags, model).arg("--json").assert().success().get_output().stdout.clone();
    written(&output)
}

#[test]
fn a_period_doubling_with_the_orbit_that_takes_over() {
    let json = answer("--event period-doubling --free amplitude", DOUBLING);
    let point = &json["points"][0];
    let close = |value: &Value, expected: f64, error: f64| (value.as_f64().unwrap() - expected).abs() < error;
    assert!(close(&point["value"], 0.158908086, 5e-10) && close(&point["evidence"]["multiplier"][0], -1.0, 1e-10));
    assert!(point["error"].as_f64().unwrap() < 1e-12 && point["physical"] == true);
    let branching = &point["branching"];
    assert!(branching["side"] == "below" && branching["orbits"].as_array().unwrap().len() == 1);
    let doubled = &branching["orbits"][0];
    assert!(doubled["family"] == "period-doubled" && doubled["stability"]["stable"] == true);
    assert!(doubled["impacts"].as_array().unwrap().len() == 2 && doubled["physical"] == true);
    // Below it the branch ends in the fold.
    assert!(json["ends"][0]["reason"] == "fold" && close(&json["ends"][0]["value"], 0.157927457267, 1e-12));
    assert_eq!((&json["free"], &json["event"]), (&"amplitude".into(), &"period-doubling".into()));
}

#[test]
fn text_for_people() {
    locate("--event pitchfork --free restitution --from .45 --to .65", &format!("{FIGURE_9} --restitution .5"))
        .assert()
        .success()
        .stdout(contains("restitution = 0.52458531444792"))
        .stdout(contains("the asymmetric pair exists above it"))
        .stdout(contains("down: searched to restitution = 0.45"));
}

#[test]
fn a_force_of_several_harmonics_is_listed_by_its_harmonics() {
    let model =
        "--family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --restitution .25";
    let flags = "--event grazing --free gamma2 --from .09 --to .11";
    let several = format!("{model} --force 1:.165,3:.002:1");
    let parameters = &answer(flags, &several)["parameters"];
    assert!(parameters.get("amplitude").is_none());
    let listed = serde_json::json!([
        { "harmonic": 1, "amplitude": 0.165, "phase": 0.0 },
        { "harmonic": 3, "amplitude": 0.002, "phase": 1.0 }
    ]);
    assert_eq!(parameters["force"], listed);
    locate(flags, &several).assert().success().stdout(contains("asymmetry = 0.8, force = 1:0.165:0,3:0.002:1, rest"));
    // A plain cosine, however it is given, by its amplitude.
    let parameters = &answer(flags, &format!("{model} --force 1:.165"))["parameters"];
    assert!(parameters["amplitude"] == 0.165 && parameters.get("force").is_none());
    // Free, the amplitude is told beside the force that it scales.
    let start = "force = 1:0.165:0,3:0.002:1, restitution = 0.25; from solution";
    locate("--event grazing --free amplitude --from .166 --to .168", &several)
        .assert()
        .success()
        .stdout(contains(start).and(contains("at amplitude = 0.167")));
}

#[test]
fn no_event_is_an_answer_and_a_wrong_range_is_not() {
    locate("--event grazing --free amplitude --from .16 --to .17", DOUBLING)
        .assert()
        .success()
        .stdout(contains("no grazing between amplitude = 0.16 and 0.17"));
    let outside = "--from 0.2 is above amplitude = 0.165, where the search starts";
    locate("--event fold --free amplitude --from .2 --to .3", DOUBLING).assert().code(2).stderr(contains(outside));
    locate("--event fold --free restitution --to 1.5", DOUBLING)
        .assert()
        .code(2)
        .stderr(contains("--to: restitution = 1.5 is out of range"));
    locate("--event fold --free amplitude --solution 3", DOUBLING)
        .assert()
        .code(2)
        .stderr(contains("there are 2, give 1 to 2"));
    let conservative = "--family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega .95 --asymmetry .4";
    locate("--event fold --free amplitude", conservative)
        .assert()
        .code(2)
        .stderr(contains("a conservative orbit has no amplitude"));
    let weak = DOUBLING.replace(".165", ".15");
    locate("--event fold --free amplitude", &weak).assert().code(3).stderr(contains("the force is too weak"));
}

/// Ã = 1 − a, by hand: γ₁ = .6041, ω = 1.2617, A = .3323 give a = 1 − A/(ω² − γ₁).
#[test]
fn a_branch_ends_where_its_impulses_vanish() {
    let model = "--family period-doubled --sites 3 --gamma1 .604107764506297 --gamma2 .003467397390512541 --omega 1.261681402055873 --asymmetry .5410330960427941 --amplitude .3323792762769934 --restitution .3698";
    let flags = "--event period-doubling --free asymmetry --solution 2";
    let json = answer(flags, model);
    let end = &json["ends"][1];
    let touching = 1.0 - 0.3323792762769934 / (1.261681402055873_f64.powi(2) - 0.604107764506297);
    assert!(end["reason"] == "impulses-vanish" && (end["value"].as_f64().unwrap() - touching).abs() < 1e-12, "{end}");
    assert_eq!(json["unresolved"], serde_json::json!([]));
    locate(flags, model).assert().success().stdout(contains("up: the impulses vanish at asymmetry = 0.66349"));
}

/// Impacts all but elastic: rounding hides where a pair crosses the circle.
#[test]
fn what_rounding_hides_is_told_as_a_range() {
    let model = "--family double-sided --sites 6 --gamma1 .5155634975092167 --gamma2 .001196266818595037 --omega 1.2437879739461413 --asymmetry .8436503755841729 --amplitude 1.5999503171718452 --restitution .9999999998293126";
    let flags = "--event neimark-sacker --free gamma1 --solution 1";
    let json = answer(flags, model);
    let places = json["unresolved"].as_array().unwrap();
    assert!(!places.is_empty() && places.iter().all(|place| place[0].as_f64() < place[1].as_f64()), "{json}");
    locate(flags, model).assert().success().stdout(contains("rounding hides where, none is claimed"));
}

#[test]
fn help_says_what_can_be_found_and_freed() {
    let mut command = mapgen(&[]);
    let help = contains("neimark-sacker").and(contains("restitution")).and(contains("every event on it is an answer"));
    command.args(["locate", "--help"]).assert().success().stdout(help);
}

/// Seventy thousand orbits, none physical: each is given up at its first obstruction.
#[test]
fn many_orbits_to_start_from_are_looked_at_in_seconds() {
    let model = "--family double-sided --sites 3 --gamma1 3.236e11 --gamma2 373.5 --omega 2 --asymmetry .047";
    locate("--event fold --free gamma2", model)
        .timeout(std::time::Duration::from_secs(120))
        .assert()
        .code(3)
        .stderr(contains("orbits is physical; --solution K starts from one that is not"));
}

#[test]
fn events_are_counted_and_stand_along_the_parameter() {
    // Stripes of a conservative breather: many, on both sides of the start.
    let flags = "--event neimark-sacker --free omega --from 1.4 --to 1.6";
    let model = "--family double-sided --sites 11 --gamma1 .2 --gamma2 .1 --omega 1.455 --asymmetry .4";
    let points = answer(flags, model)["points"].as_array().unwrap().clone();
    let values: Vec<f64> = points.iter().map(|point| point["value"].as_f64().unwrap()).collect();
    assert!(values.len() > 1 && values.is_sorted(), "{values:?}");
    assert!(values[0] < 1.455 && values[values.len() - 1] > 1.455, "{values:?}");
    let told = format!("\n{} events, along the parameter\n", values.len());
    locate(flags, model).assert().success().stdout(contains(told));
}
