//! `mapgen curves` as its users meet it.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;
use tempfile::tempdir;
use vibrochain_testkit::{mapgen, written};

/// Double-sided breathers of a ring of three above their band.
const SCENE: &str = "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
    x = { parameter = \"omega\", from = 0.6, to = 2.0, points = 60 }\n\
    y = { parameter = \"gamma2\", from = 0.0, to = 0.2, points = 40 }\n\
    [compute]\nfamilies = [\"double-sided\"]\nstability = true\n";

fn curves(scene: &Path) -> Command {
    let mut command = mapgen(&["curves"]);
    command.arg(scene);
    command
}

#[test]
fn text_tables_json_and_pictures_tell_the_same() {
    let dir = tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    fs::write(at("scene.toml"), SCENE).unwrap();
    curves(&at("scene.toml"))
        .arg("--csv")
        .arg(at("borders.csv"))
        .arg("--plot")
        .arg(at("map.svg"))
        .assert()
        .success()
        .stdout(contains("double-sided: 1 grazing").and(contains("1 stripe, two edges each")))
        .stdout(contains("share of the window").and(contains("stable-double")))
        .stdout(contains("without a border").not());
    let drawn = fs::read_to_string(at("map.svg")).unwrap();
    assert!(drawn.starts_with("<svg") && drawn.contains("<path") && drawn.contains("stable double-sided"));

    let output = curves(&at("scene.toml")).arg("--json").arg("--points").arg(at("points.csv")).assert().success();
    let answer = written(&output.get_output().stdout);
    let told = answer["borders"].as_array().unwrap();
    let table = fs::read_to_string(at("borders.csv")).unwrap();
    let mut lines = table.lines();
    assert_eq!(lines.next().unwrap(), "border,family,event,omega,gamma2,error,stripe,half_width");
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let points: Vec<&Value> = told.iter().flat_map(|border| border["points"].as_array().unwrap()).collect();
    // What is special on them are points more.
    let special: usize = told.iter().map(|border| border["special"].as_array().unwrap().len()).sum();
    assert!(rows.len() <= points.len() && points.len() <= rows.len() + special && rows.len() > 300);
    let areas = answer["areas"].as_array().unwrap();
    let whole: f64 = areas.iter().map(|area| area["share"].as_f64().unwrap()).sum();
    assert!((whole - 1.0).abs() < 1e-9 && areas.len() == 3, "{areas:?}");
    assert!(areas.iter().all(|area| area["error"].as_f64().unwrap() < 1e-4), "{areas:?}");
    let listed = fs::read_to_string(at("points.csv")).unwrap();
    assert_eq!(listed.lines().next().unwrap(), "border,family,event,special,omega,gamma2,error");
    assert_eq!(listed.lines().count(), special + 1);
}

#[test]
fn threads_change_nothing() {
    let dir = tempdir().unwrap();
    let scene = dir.path().join("scene.toml");
    fs::write(&scene, SCENE).unwrap();
    let table = |threads: &str| {
        let csv = dir.path().join(format!("{threads}.csv"));
        curves(&scene).args(["--threads", threads, "--tolerance", "1e-4", "--csv"]).arg(&csv).assert().success();
        fs::read(csv).unwrap()
    };
    assert_eq!(table("1"), table("3"));
}

#[test]
fn what_cannot_be_asked_is_refused() {
    let dir = tempdir().unwrap();
    let scene = dir.path().join("scene.toml");
    fs::write(&scene, SCENE).unwrap();
    curves(&scene).args(["--tolerance", ".5"]).assert().code(2).stderr(contains("give a part of the window"));
    curves(&scene).args(["--plot", "map.gif"]).assert().code(2).stderr(contains("--plot map.gif"));
    curves(&scene).arg("--csv").arg(&scene).assert().code(2).stderr(contains("the scene"));
    curves(&dir.path().join("none.toml")).assert().code(2);
    let line = SCENE.replace("y = { parameter = \"gamma2\", from = 0.0, to = 0.2, points = 40 }\n", "");
    fs::write(&scene, line.replace("asymmetry = 0.4", "asymmetry = 0.4\ngamma2 = 0.1")).unwrap();
    curves(&scene).assert().code(2).stderr(contains("give x and y"));
}
