//! Simulations: from orbits and from states.

use std::fs;

use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use vibrochain_testkit::{TestDir, mapgen};

use crate::asked::{POINT, SMALL, rows};

#[test]
fn a_simulation_from_an_orbit_stays_on_it_and_writes_events_and_trajectory() {
    let dir = TestDir::new();
    let (impacts, trajectory, plot) = (dir.path("impacts.csv"), dir.path("trajectory.csv"), dir.path("run.png"));
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

#[test]
fn a_simulation_from_a_state_meets_sticking_and_stops_where_it_is_told() {
    let dir = TestDir::new();
    let (state, impacts) = (dir.path("state.json"), dir.path("impacts.csv"));
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
    let dir = TestDir::new();
    let (state, impacts) = (dir.path("state.json"), dir.path("impacts.csv"));
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
    let dir = TestDir::new();
    let state = dir.path("state.json");
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

#[cfg(unix)]
#[test]
fn an_interrupted_simulation_keeps_what_it_has_however_long_a_period_is() {
    let dir = TestDir::new();
    let (state, impacts) = (dir.path("state.json"), dir.path("impacts.csv"));
    fs::write(&state, r#"{"displacement":[0,0,0,0,0],"velocity":[1,1,1,1,1]}"#).unwrap();
    let mut arguments: Vec<_> = SMALL.to_vec();
    arguments[7] = "1e-50";
    let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin("mapgen"));
    command.arg("simulate").arg("--state").arg(&state).arg("--impacts").arg(&impacts).args(arguments);
    command.args(["--max-impacts", "9000000000000000000"]);
    let mut child = command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null()).spawn().unwrap();
    while dir.names(".").len() < 2 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert!(std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(dir.names("."), ["impacts.csv", "state.json"]);
    assert!(rows(&impacts).len() > 100);
}
