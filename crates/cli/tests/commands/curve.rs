//! `mapgen curve` as its users meet it.

use std::fs;

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use tempfile::tempdir;
use vibrochain_testkit::{mapgen, written};

const MODEL: &str = "--family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .165 --restitution .25";
const PLANE: &str = "--free amplitude --from .1 --to .3 --and restitution --and-from .2 --and-to .4 --tolerance 1e-4";

fn curve(event: &str, flags: &str) -> Command {
    let mut command = mapgen(&["curve"]);
    command.args(["--event", event]).args(flags.split(' ')).args(MODEL.split(' '));
    command
}

/// The period doubling of docs/errata.md, found by another command.
const PERIOD_DOUBLING: f64 = 0.158908086489247;

#[test]
fn text_for_people() {
    curve("period-doubling", PLANE)
        .assert()
        .success()
        .stdout(contains("period-doubling of single-sided breathers, 21 masses").and(contains("curve 1: ")))
        .stdout(contains("amplitude = 0.15150076945").and(contains("  fold")))
        .stdout(contains("end: amplitude = ").and(contains("restitution = 0.2, at the edge of the window")))
        .stdout(contains("eigenvalue problems"));
}

#[test]
fn json_and_table_tell_the_same_points() {
    let dir = tempdir().unwrap();
    let csv = dir.path().join("points.csv");
    let output = curve("period-doubling", PLANE).arg("--csv").arg(&csv).arg("--json").assert().success();
    let answer = written(&output.get_output().stdout);
    let points = answer["curves"][0]["points"].as_array().unwrap();
    let table = fs::read_to_string(&csv).unwrap();
    let mut lines = table.lines();
    let header = "curve,event,amplitude,restitution,error,special,special_error,angle,physical,impulses,phi,psi";
    assert_eq!(lines.next().unwrap(), header);
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert!(rows.len() == points.len() && rows.len() > 15, "{} {}", rows.len(), points.len());
    for (row, point) in rows.iter().zip(points) {
        let told = [2, 3].map(|i| row[i].parse::<f64>().unwrap());
        assert_eq!(told, [0, 1].map(|i| point["values"][i].as_f64().unwrap()));
        assert!(row[4].parse::<f64>().unwrap() < 1e-11, "{row:?}");
    }
    assert_eq!(rows.iter().filter(|row| row[5] == "fold").count(), 1);
    // One of them is where the curve was taken up: the point that another command finds.
    let nearest = rows.iter().filter(|row| row[3] == "0.25").map(|row| row[2].parse::<f64>().unwrap());
    assert!(nearest.map(|value| (value - PERIOD_DOUBLING).abs()).fold(1.0, f64::min) < 1e-12);
}

#[test]
fn a_picture_and_what_no_picture_can_be() {
    let dir = tempdir().unwrap();
    let picture = dir.path().join("curve.svg");
    curve("fold", PLANE).arg("--plot").arg(&picture).assert().success();
    let drawn = fs::read_to_string(&picture).unwrap();
    assert!(drawn.starts_with("<svg") && drawn.contains("curve 1") && drawn.contains("restitution e"));
    curve("fold", PLANE).args(["--plot", "curve.gif"]).assert().code(2);
}

#[test]
fn wrong_requests_say_what_to_do() {
    curve("fold", "--free amplitude --and amplitude")
        .assert()
        .code(2)
        .stderr(contains("--free and --and are both amplitude: give two parameters"));
    curve("fold", "--free amplitude --and restitution --and-from .3")
        .assert()
        .code(2)
        .stderr(contains("--and-from 0.3 is above restitution = 0.25, where the search starts"));
    curve("fold", "--free amplitude --and restitution --and-to 2").assert().code(2).stderr(contains("--and-to"));
    curve("fold", "--free amplitude --and restitution --tolerance .5")
        .assert()
        .code(2)
        .stderr(contains("a tolerance of 0.5 is out of range"));
    curve("neimark-sacker", "--free amplitude --from .164 --to .166 --and restitution")
        .assert()
        .success()
        .stdout(contains("no neimark-sacker along amplitude: nothing to follow").and(contains("searched to")));
}
