//! Orbits: what is told of them, and why there are none.

use std::fs;

use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;
use vibrochain_testkit::{TestDir, mapgen, written};

use crate::asked::{POINT, SCENE, orbit_json};

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
    // Next to the resonance of the force solutions crowd.
    let mut crowded = POINT;
    crowded[7] = "0.4472136";
    let crowded = [&crowded[..], &["--amplitude", ".1", "--restitution", ".9"]].concat();
    let value = orbit_json("period-doubled", &crowded);
    assert!(value["completeness"]["established"] == true && value["exhausted"] == 0, "{value}");
    // No proof is known of four impacts under a force.
    let long = [&POINT[..], &["--amplitude", ".1", "--restitution", ".9", "--word", "0+,0-,1+,1-", "--json"]].concat();
    let output = mapgen(&[]).arg("orbit").args(long).assert().success();
    let value = written(&output.get_output().stdout);
    assert_eq!(value["completeness"], serde_json::json!({ "established": false, "by": null }));
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
        let value = orbit_json("double-sided", &point);
        let solutions = value["solutions"].as_array().unwrap().clone();
        assert!(solutions.len() == 1 && solutions.iter().all(|solution| solution["physical"] == true), "{omega}");
        solutions.iter().map(|solution| solution["margin"].as_f64().unwrap()).collect::<Vec<_>>()
    };
    // Between its barriers the mass flies straight: only the clock tells one frequency from the other.
    for (usual, enormous) in margins("1e6").iter().zip(margins("1e50")) {
        assert!((usual - enormous).abs() < 1e-9, "{usual} {enormous}");
    }
}

/// Multipliers of so many masses are not worked out under a force: the orbits are told, and why their stability is not.
#[test]
fn a_stability_that_cannot_be_told_is_refused_not_half_answered() {
    let mut point = POINT;
    (point[1], point[7], point[9]) = ("20001", "1.07", "0.8");
    let run = mapgen(&[])
        .args(["orbit", "--json", "--family", "single-sided", "--amplitude", ".165", "--restitution", ".25"])
        .args(point)
        .assert()
        .code(1)
        .stderr(contains("use fewer masses"));
    let value = written(&run.get_output().stdout);
    let first = &value["solutions"][0];
    assert!(first["stability"].is_null() && first["stability_error"].as_str().unwrap().contains("20001"));
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
    let dir = TestDir::new();
    for name in ["orbit.png", "orbit.svg"] {
        let path = dir.path(name);
        mapgen(&[]).args(["orbit", "--family", "double-sided", "--plot"]).arg(&path).args(POINT).assert().success();
        assert!(fs::metadata(path).unwrap().len() > 5000);
    }
    assert!(fs::read_to_string(dir.path("orbit.svg")).unwrap().contains("impacting mass"));
}

#[test]
fn two_masses_have_two_springs_and_one_needs_none() {
    let dir = TestDir::new();
    let of = |chain: &str| dir.run(&format!("orbit --family double-sided {chain} --omega 1.5 --asymmetry .4"));
    let two = "a ring of two masses has two springs of gamma2 between them";
    of("--sites 2 --gamma1 .2 --gamma2 .1").with(0, &[two]);
    for chain in [
        "--sites 2 --gamma1 .2 --gamma2 .1 --ends free",
        "--sites 2 --gamma1 .2 --gamma2 0",
        "--sites 3 --gamma1 .2 --gamma2 .1",
    ] {
        assert_eq!(of(chain).with(0, &[]).err, "", "{chain}");
    }
    dir.scene(&SCENE.replace("sites = 11", "sites = 2"));
    dir.run("sweep scene.toml --out map.csv").with(0, &[two]);
    // A mass alone has no neighbour: the coupling means nothing.
    let answers = ["0", "1"].map(|gamma2| {
        let mut answer: Vec<String> = Vec::new();
        for family in ["double-sided", "single-sided"] {
            for force in ["", " --amplitude .3 --restitution .9"] {
                let line = format!(
                    "orbit --family {family} --sites 1 --gamma1 0 --gamma2 {gamma2} --omega 1.5 --asymmetry .4{force}"
                );
                answer.push(dir.run(&line).with(0, &[]).out.replace("gamma2 = 1", "gamma2 = 0").replace(',', " "));
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
