//! The modes that `mapgen orbit` tells of, and which have collided.

use predicates::str::contains;
use serde_json::Value;
use vibrochain_testkit::{mapgen, written};

const POINT: &str = "--sites 6 --gamma1 .2 --gamma2 .15 --asymmetry .4 --omega";

fn orbit(family: &str, omega: &str, flags: &str) -> assert_cmd::assert::Assert {
    let line = format!("orbit --family {family} {POINT} {omega} {flags}");
    mapgen(&line.split_whitespace().collect::<Vec<_>>()).assert().success()
}

fn solution(family: &str, omega: &str) -> Value {
    let assert = orbit(family, omega, "--json");
    let value = written(&assert.get_output().stdout);
    value["solutions"][0].clone()
}

#[test]
fn an_orbit_tells_its_modes_and_which_have_collided() {
    let value = solution("double-sided", "1.6");
    let modes = value["modes"].as_array().unwrap();
    assert_eq!(modes.len(), 4);
    let mut sum = 0.0;
    for (k, mode) in modes.iter().enumerate() {
        let bare = |k: usize| (0.2 + 0.6 * (std::f64::consts::PI * k as f64 / 6.0).sin().powi(2)).sqrt();
        assert_eq!(mode["mode"], k);
        assert!((mode["frequency"].as_f64().unwrap() - bare(k)).abs() < 1e-14);
        // Below ω/2 = 0.8 the form is positive, above it negative.
        assert_eq!(mode["bare_signature"], if bare(k) < 0.8 { 1 } else { -1 });
        // With the breather on the ring modes 1 and 2 have collided, and of the last one it has taken the place.
        assert_eq!(mode["signature"], if k == 0 { 1.into() } else { Value::Null });
        match mode["dressed"].as_f64() {
            Some(dressed) => assert!(bare(k) < dressed && dressed < bare(k + 1)),
            None => assert_eq!(k, 3),
        }
        sum += mode["residue"].as_f64().unwrap();
    }
    assert!((sum - 1.0).abs() < 1e-12);
    assert_eq!(value["stability"]["mechanism"], "neimark-sacker");
    let collision = &value["collision"];
    assert_eq!((&collision["modes"], &collision["harmonic"]), (&serde_json::json!([1, 2]), &1.into()));
    let dressed = |k: usize| modes[k]["dressed"].as_f64().unwrap();
    assert!((collision["detuning"].as_f64().unwrap() - (dressed(1) + dressed(2) - 1.6)).abs() < 1e-12);
    let told = "signatures of modes: 0 +, 1–2 none; collided: modes 1 and 2, their frequencies sum to ω = 1.6 ";
    orbit("double-sided", "1.6", "").stdout(contains(told));

    let value = solution("double-sided", "1.46");
    assert_eq!(value["stability"]["mechanism"], "period-doubling");
    assert_eq!(value["collision"]["modes"], serde_json::json!([1, 1]));
    orbit("double-sided", "1.46", "").stdout(contains("collided: mode 1 with itself"));
}

#[test]
fn an_orbit_tells_of_the_internal_mode() {
    let line = |omega: &str, flags: &str| {
        let line = format!(
            "orbit --family single-sided --sites 6 --gamma1 .2 --gamma2 .2 --asymmetry .4 --omega {omega} {flags}"
        );
        mapgen(&line.split_whitespace().collect::<Vec<_>>()).assert().success()
    };
    let solution = |omega: &str| {
        let value = written(&line(omega, "--json").get_output().stdout);
        value["solutions"][0].clone()
    };
    // Stable; ω is between Ω₁ and Ω₂, so that no mode is.
    let value = solution(".69");
    let own = &value["internal_mode"];
    assert_eq!((&own["mode"], &own["signature"], &own["loss"]), (&3.into(), &(-1).into(), &0.0.into()));
    let turns = own["frequency"].as_f64().unwrap() / 0.69;
    assert!(value["modes"][1]["dressed"].is_null() && value["modes"][3]["dressed"].is_null());
    // Its multipliers e^{±iΩT} are there.
    let angle = |z: &Value| z[1].as_f64().unwrap().atan2(z[0].as_f64().unwrap()) / std::f64::consts::TAU;
    let multipliers = value["stability"]["multipliers"].as_array().unwrap();
    assert!(multipliers.iter().any(|z| (angle(z) - (turns - 1.0)).abs() < 1e-9), "{turns} {multipliers:?}");
    let value = solution(".66");
    assert_eq!(value["stability"]["mechanism"], "neimark-sacker");
    assert_eq!(value["collision"]["modes"], serde_json::json!([2, 3]));
    line(".66", "").stdout(contains("collided: mode 2 and the internal mode, their frequencies sum to 2ω = 1.32 "));
    line(".72", "").stdout(contains("collided: the internal mode with itself, their frequencies sum to ω = 0.72"));
    // Double-sided, above the band: it has none.
    assert!(self::solution("double-sided", "1.6")["internal_mode"].is_null());
}

/// The signature beside `dressed` is that of the dressed mode's multiplier: the breather has carried mode 4 past −1.
#[test]
fn a_mode_that_the_breather_has_carried_past_minus_one_has_the_signature_of_its_multiplier() {
    let line = "orbit --json --family single-sided --sites 15 --gamma1 0.5448393244032546 --gamma2 0.049273526372998165 --omega 1.6210549604807942 --asymmetry 0";
    let assert = mapgen(&line.split_whitespace().collect::<Vec<_>>()).assert().success();
    let value = written(&assert.get_output().stdout);
    let mode = &value["solutions"][0]["modes"][4];
    let phase = |frequency: &str| mode[frequency].as_f64().unwrap() * std::f64::consts::TAU / 1.6210549604807942;
    assert!((phase("frequency") - 3.134).abs() < 1e-3 && (phase("dressed") - 3.1805).abs() < 1e-3);
    assert_eq!((&mode["bare_signature"], &mode["signature"]), (&1.into(), &(-1).into()));
}

#[test]
fn modes_in_doubt_and_orbits_without_modes() {
    // 2Ω₀ = ω to the last digit: Ω₀ = 0.5.
    let line = "orbit --json --family double-sided --sites 6 --gamma1 .25 --gamma2 .15 --asymmetry .4 --omega 1";
    let assert = mapgen(&line.split_whitespace().collect::<Vec<_>>()).assert().success();
    let value = written(&assert.get_output().stdout);
    assert_eq!(value["solutions"][0]["modes"][0]["bare_signature"], Value::Null);
    // Stable: nothing has collided.
    let value = solution("double-sided", "2.5");
    assert!(value["modes"].is_array() && value["collision"].is_null() && value["stability"]["stable"] == true);
    // Above twice the band all signatures are alike.
    let (last, others) = value["modes"].as_array().unwrap().split_last().unwrap();
    assert!(others.len() == 3 && others.iter().all(|mode| mode["signature"] == 1 && mode["bare_signature"] == 1));
    assert!(last["signature"].is_null() && last["dressed"].is_null());
    // Losses: none of this is defined.
    let forced = orbit("double-sided", "1.6", "--json --amplitude .1 --restitution .9");
    let value = written(&forced.get_output().stdout);
    let solutions = value["solutions"].as_array().unwrap();
    assert!(!solutions.is_empty() && solutions.iter().all(|s| s["modes"].is_null() && s["collision"].is_null()));
}
