//! `mapgen branch` as its users meet it.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;
use tempfile::tempdir;
use vibrochain_testkit::{mapgen, written};

const DOUBLING: &str = "--family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .165 --restitution .25";
const FIGURE_9: &str = "--family double-sided --sites 21 --gamma1 .1 --gamma2 .05 --omega 1.33 --asymmetry 0 --amplitude 1.5 --restitution .6";
const SHORT_RING: &str = "--family double-sided --sites 6 --gamma1 .2 --gamma2 .1 --omega 1.2 --asymmetry .4";

/// The points of docs/errata.md, found by another command, and the ends of a doubled orbit.
const FOLD: f64 = 0.1579274572665355;
const PERIOD_DOUBLING: f64 = 0.158908086489247;
const PITCHFORK: f64 = 0.524585314447926;

fn branch(flags: &str, model: &str) -> Command {
    let mut command = mapgen(&["branch"]);
    command.args(flags.split(' ')).args(model.split(' '));
    command
}

fn answer(flags: &str, model: &str) -> Value {
    let output = branch(flags, model).arg("--json").assert().success().get_output().stdout.clone();
    written(&output)
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap()
}

fn close(value: &Value, expected: f64, error: f64) -> bool {
    (value.as_f64().unwrap() - expected).abs() < error
}

/// The events of a branch in JSON, by name, with their values.
fn events(branch: &Value) -> Vec<(&str, f64)> {
    list(&branch["events"]).iter().map(|one| (one["event"].as_str().unwrap(), one["value"].as_f64().unwrap())).collect()
}

#[test]
fn text_for_people() {
    branch("--free amplitude --to .17 --switch", DOUBLING)
        .assert()
        .success()
        .stdout(
            contains("single-sided breathers, 21 masses (N = 20), gamma1 = 0.2").and(contains("from solution 1 of 2")),
        )
        .stdout(contains("amplitude = 0.157927457266535").and(contains("fold: multiplier 1\n")))
        .stdout(contains("period-doubling: multiplier -1").and(contains("neimark-sacker: multiplier -0.967033")))
        .stdout(contains("branch 2, period-doubled, leaves branch 1 at amplitude = 0.1589080864892"))
        .stdout(contains("grazing: site 4 touches the lower barrier at t = 1.2505"))
        .stdout(contains("end: searched to amplitude = 0.17").and(contains("eigenvalue problems")));
}

#[test]
fn events_of_orbits_that_are_not_physical_are_counted_or_listed() {
    let lines = |text: &str, what: &str| text.lines().filter(|line| line.contains(what)).count();
    let text = |flags: &str| {
        let output = branch(&format!("--free amplitude --to .17 --switch{flags}"), DOUBLING);
        String::from_utf8({ output }.assert().success().get_output().stdout.clone()).unwrap()
    };
    let (few, all) = (text(""), text(" --all"));
    let hidden = few.split("and ").nth(1).unwrap().split(' ').next().unwrap().parse::<usize>().unwrap();
    assert!(few.contains("of orbits that are not physical (--all lists them)") && hidden > 0);
    assert_eq!((lines(&few, "; not physical"), lines(&all, "; not physical")), (0, hidden));
    assert_eq!(lines(&all, "(--all lists them)"), 0);
}

/// Tables hold what JSON holds: the same branches, points and events in the same numbers.
#[test]
fn a_table_has_a_row_for_each_station() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("branch.csv");
    let flags = format!("--free amplitude --to .17 --switch --csv {}", path.display());
    let json = answer(&flags, DOUBLING);
    let mut table = csv::Reader::from_path(&path).unwrap();
    let header: Vec<String> = table.headers().unwrap().iter().map(str::to_owned).collect();
    let columns = "branch,generation,event,value,error,impulse,impulses,phi,psi,period,margin,physical,stable,mechanism,spectral_radius";
    assert_eq!(header.join(","), columns);
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    let number = |row: &csv::StringRecord, name: &str| {
        let field = &row[header.iter().position(|column| column == name).unwrap()];
        (!field.is_empty()).then(|| field.parse::<f64>().unwrap())
    };
    for (i, branch) in list(&json["branches"]).iter().enumerate() {
        let of_it: Vec<_> = rows.iter().filter(|row| row[0] == (i + 1).to_string()).collect();
        let (points, others): (Vec<_>, Vec<_>) = of_it.into_iter().partition(|row| row[2].is_empty());
        let values = |name: &str| points.iter().map(|row| number(row, name)).collect::<Vec<_>>();
        let told = |name: &str| list(&branch["points"]).iter().map(|point| point[name].as_f64()).collect::<Vec<_>>();
        assert!(points.len() > 50 && values("value") == told("value") && values("margin") == told("margin"));
        assert!(values("value").iter().all(Option::is_some));
        let of_json = |point: &Value| point["stability"]["spectral_radius"].as_f64();
        assert_eq!(values("spectral_radius"), list(&branch["points"]).iter().map(of_json).collect::<Vec<_>>());
        let found: Vec<(&str, f64)> = others.iter().map(|row| (&row[2], number(row, "value").unwrap())).collect();
        assert_eq!(found, events(branch));
        assert!(!found.is_empty() && others.iter().all(|row| number(row, "error").is_none_or(|error| error < 1e-9)));
    }
    // Impulses in one column, the strongest in another; and both ways of the branch pass stable and unstable orbits.
    for row in &rows {
        let impulses: Vec<f64> = row[6].split(' ').map(|one| one.parse().unwrap()).collect();
        let largest = impulses.iter().fold(0.0_f64, |most, one| most.max(one.abs()));
        assert_eq!(number(row, "impulse").unwrap().abs(), largest);
        assert!(impulses.len() == if &row[0] == "1" { 1 } else { 2 });
    }
    let judged: BTreeSet<&str> = rows.iter().map(|row| &row[12]).collect();
    assert!(judged.contains("true") && judged.contains("false"), "{judged:?}");
}

#[test]
fn json_tells_branches_origins_and_ends() {
    let json = answer("--free amplitude --to .17 --switch", DOUBLING);
    assert_eq!((&json["free"], &json["family"]), (&"amplitude".into(), &"single-sided".into()));
    assert_eq!((&json["solution"], &json["range"]), (&1.into(), &serde_json::json!([0.0825, 0.17])));
    let [first, doubled] = list(&json["branches"]) else { panic!("two branches") };
    let physical: Vec<&str> = events(first).into_iter().map(|(name, _)| name).collect();
    assert_eq!(physical.iter().filter(|name| **name == "fold").count(), 1, "{physical:?}");
    let at = |name: &str| list(&first["events"]).iter().find(|one| one["event"] == name).unwrap();
    assert!(close(&at("fold")["value"], FOLD, 1e-12) && at("fold")["error"].as_f64().unwrap() < 1e-12);
    assert!(close(&at("period-doubling")["value"], PERIOD_DOUBLING, 1e-12));
    assert!(first["origin"].is_null() && first["generation"] == 0 && doubled["generation"] == 1);
    assert!(doubled["origin"]["branch"] == 1 && doubled["origin"]["event"] == "period-doubling");
    assert!(close(&doubled["origin"]["value"], PERIOD_DOUBLING, 1e-12) && doubled["force_periods"] == 2);
    assert!(first["ends"].as_array().unwrap().len() == 2 && list(&doubled["ends"]).len() == 1);
    assert!(list(&first["ends"]).iter().all(|end| end["reason"] == "range" && close(&end["value"], 0.17, 1e-15)));
    // Round the fold: the upper half has the larger impulse, and one orbit is stable where the other is not.
    let ways: Vec<&Value> = list(&first["points"]).iter().filter(|point| close(&point["value"], 0.17, 1e-12)).collect();
    assert!(ways.len() == 2 && ways[0]["stability"]["stable"] != ways[1]["stability"]["stable"]);
    assert!(first["unresolved"] == serde_json::json!([]));
}

#[test]
fn a_diagram_is_the_same_from_whichever_of_its_orbits_it_starts() {
    // The symmetric orbit, and the two of the pair that it sheds.
    for (solution, symmetric) in [(2, 0), (1, 1), (4, 1)] {
        let flags = format!("--free restitution --from .4 --to .8 --switch --generations 4 --solution {solution}");
        let json = answer(&flags, FIGURE_9);
        let branches = list(&json["branches"]);
        assert_eq!(branches.len(), 2, "solution {solution}");
        for (i, branch) in branches.iter().enumerate() {
            let points = list(&branch["points"]);
            let halved = |point: &Value| close(&point["phi"], 0.5 * point["period"].as_f64().unwrap(), 1e-9);
            let reach = points.iter().map(|point| point["value"].as_f64().unwrap()).fold(f64::INFINITY, f64::min);
            if i == symmetric {
                assert!(points.iter().all(halved) && reach == 0.4, "solution {solution}");
            } else {
                assert!(points.iter().filter(|point| halved(point)).count() <= 1 && reach > PITCHFORK - 1e-12);
            }
        }
        let origin = &branches[1]["origin"];
        assert!(origin["event"] == "pitchfork" && close(&origin["value"], PITCHFORK, 1e-11), "{origin}");
    }
}

/// Period doublings of two arms, joined by one doubled orbit: it ends where the other arm doubles, and is followed once.
#[test]
fn a_doubled_orbit_ends_at_another_doubling() {
    let model = "--family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega .9 --asymmetry .4 --amplitude .1 --restitution .9";
    let json = answer("--free omega --from .89 --to 1.1 --switch --events period-doubling,grazing", model);
    let origins: Vec<f64> = events(&json["branches"][0])
        .into_iter()
        .filter(|(name, _)| *name == "period-doubling")
        .map(|(_, value)| value)
        .collect();
    let doubled = list(&json["branches"]).iter().filter(|branch| branch["family"] == "period-doubled");
    let mut joined = Vec::new();
    for branch in doubled {
        let end = &list(&branch["ends"])[0];
        if end["reason"] == "period-doubling" {
            assert!(end["message"].as_str().unwrap().ends_with("on orbits of half its period"));
            joined.push((branch["origin"]["value"].as_f64().unwrap(), end["value"].as_f64().unwrap()));
        }
    }
    assert!(joined.len() >= 2, "{joined:?}");
    for (i, (from, to)) in joined.iter().enumerate() {
        let other = origins.iter().map(|value| (value - to).abs()).fold(f64::INFINITY, f64::min);
        assert!(other < 1e-10, "{from} to {to}: {origins:?}");
        let again = joined[i + 1..].iter().any(|(start, end)| (start - to).abs() < 1e-8 && (end - from).abs() < 1e-8);
        assert!(!again, "{joined:?}");
    }
}

#[test]
fn words_and_orbits_of_files_are_followed() {
    let word = "--word 0+3+,0-3- --sites 8 --gamma1 .2 --gamma2 .05 --omega 1.5 --asymmetry .2";
    let json = answer("--free omega --from 1.3 --to 1.6 --events grazing,fold", word);
    let missing = || contains("stripes thinner than the step may be missing");
    branch("--free omega --from 1.4", word).assert().success().stdout(missing().not());
    let forced = format!("{word} --amplitude .1 --restitution 1");
    branch("--free omega --from 1.45 --to 1.55", &forced).assert().success().stdout(missing().not());
    assert!(
        (&json["family"], &json["word"]) == (&"word".into(), &"0+3+,0-3-".into())
            && list(&json["branches"][0]["points"]).len() > 10
    );
    // The same breather by its file.
    let folder = tempdir().unwrap();
    let near = folder.path().join("near.json");
    let mut orbit = mapgen(&["orbit", "--json"]);
    let output = orbit.args(word.split(' ')).assert().success().get_output().stdout.clone();
    fs::write(&near, output).unwrap();
    let model = word.replacen("--word 0+3+,0-3-", &format!("--near {}", near.display()), 1);
    let again = answer("--free omega --from 1.3 --to 1.6 --events grazing,fold", &model);
    let ends = |json: &Value| {
        let points = list(&json["branches"][0]["points"]);
        [&points[0], &points[points.len() - 1]].map(|point| point["impulses"][0].as_f64().unwrap())
    };
    let ([a, b], [c, d]) = (ends(&json), ends(&again));
    assert!((a - c).abs() < 1e-9 && (b - d).abs() < 1e-9 && (a - b).abs() > 1e-2, "{a} {b} {c} {d}");
}

/// Steps differ with the range, events do not; stripes are 2e-4 wide there, and two of them overlap.
#[test]
fn events_do_not_depend_on_the_range() {
    let model = "--family double-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";
    let found = |from: &str, to: &str| {
        let json = answer(&format!("--free omega --from {from} --to {to}"), model);
        let all = events(&json["branches"][0]);
        let inside = all.into_iter().filter(|(_, value)| (1.41..1.58).contains(value));
        inside.map(|(name, value)| (name.to_owned(), value)).collect::<Vec<_>>()
    };
    let fine = found("1.4", "1.6");
    assert_eq!(fine.len(), 20);
    for (from, to) in [("1.4", "1.9"), ("1.2", "1.6"), (".9", "1.6"), (".7", "1.7"), (".7", "2.5")] {
        let other = found(from, to);
        let same = |(a, b): (&(String, f64), &(String, f64))| a.0 == b.0 && (a.1 - b.1).abs() < 1e-10;
        assert!(other.len() == fine.len() && fine.iter().zip(&other).all(same), "{from} to {to}: {other:?} {fine:?}");
    }
}

/// What is told apart by name is followed by name alone.
#[test]
fn only_the_events_asked_for() {
    let all = answer("--free omega --from .9 --to 1.6", SHORT_RING);
    let found = events(&all["branches"][0]);
    let kinds: BTreeSet<&str> = found.iter().map(|(name, _)| *name).collect();
    assert!(kinds.len() > 2, "{kinds:?}");
    for kind in kinds {
        let one = answer(&format!("--free omega --from .9 --to 1.6 --events {kind}"), SHORT_RING);
        let (of_all, of_one): (Vec<_>, _) =
            (found.iter().filter(|(name, _)| *name == kind).collect(), events(&one["branches"][0]));
        assert_eq!(of_all.len(), of_one.len(), "{kind}");
        let same = |(a, b): (&&(&str, f64), &(&str, f64))| a.0 == b.0 && (a.1 - b.1).abs() < 1e-10;
        assert!(of_all.iter().zip(&of_one).all(same), "{of_all:?} {of_one:?}");
    }
}

#[test]
fn excess_below_a_threshold_counts_as_stable() {
    let stable = |flags: &str| {
        let json = answer(flags, SHORT_RING);
        let points = list(&json["branches"][0]["points"]).to_vec();
        points.iter().filter(|point| point["stability"]["stable"] == true).count()
    };
    let (strict, all) =
        (stable("--free omega --from .98 --to 1.3"), stable("--free omega --from .98 --to 1.3 --threshold 100"));
    assert!(0 < strict && strict < all, "{strict} {all}");
}

#[test]
fn pictures_of_every_quantity() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let plot = |name: &str, more: &str| {
        let flags = format!("--free amplitude --to .17 --switch --plot {}{more}", path(name).display());
        branch(&flags, DOUBLING).assert().success();
        fs::read(path(name)).unwrap()
    };
    assert!(plot("two.png", "").starts_with(b"\x89PNG"));
    let svg = String::from_utf8(plot("all.svg", " --show impulse,phi,psi,margin,spectral-radius --all")).unwrap();
    for words in [
        "single-sided",
        "period-doubled",
        "unstable",
        "not physical",
        "fold",
        "grazing",
        "impulses |P|",
        "second impact φ/T",
        "phase of the force ψ/T",
    ] {
        assert!(svg.contains(words), "{words}");
    }
    assert!(svg.contains("largest |μ|") && svg.contains("smallest distance to a barrier") && !svg.contains("NaN"));
    // One picture is the same for whoever makes it.
    assert_eq!(plot("two.png", ""), plot("again.png", ""));
}

/// Each with what is wrong and what to do; no file is left behind.
#[test]
fn wrong_requests() {
    let folder = tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    let refused = |flags: &str, model: &str, code: i32, words: &str| {
        branch(flags, model).assert().code(code).stdout("").stderr(contains(words));
    };
    let wrong = |flags: &str, words: &str| refused(flags, DOUBLING, 2, words);
    wrong("--free amplitude --generations 2", "--switch");
    wrong("--free amplitude --show phi", "--plot <FILE>");
    wrong("--free amplitude --switch --generations -1", "negative: give a whole number");
    wrong(
        "--free amplitude --events torus",
        "possible values: grazing, pitchfork, period-doubling, neimark-sacker, fold",
    );
    wrong("--free amplitude --from .165 --to .16500000000001", "too short for a branch to be followed");
    wrong("--free amplitude --from .2 --to .3", "--from 0.2 is above amplitude = 0.165, where the search starts");
    wrong("--free amplitude --to .16", "--to 0.16 is below amplitude = 0.165, where the search starts");
    wrong("--free amplitude --from .17 --to .16", "--from 0.17 is not below --to 0.16");
    wrong("--free restitution --to 1.5", "--to: restitution = 1.5 is out of range");
    wrong("--free amplitude --solution 3", "there are 2, give 1 to 2");
    wrong("--free amplitude --threshold -1", "excess");
    // A table into a folder.
    wrong(&format!("--free amplitude --plot {}", file("branch.gif")), "end the name in .png, .svg or .pdf");
    let table = folder.path().display();
    wrong(&format!("--free amplitude --csv {table}"), "it is a folder; name a file");
    let both = file("both.png");
    wrong(&format!("--free amplitude --csv {both} --plot {both}"), "are the same file");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    let conservative = "--family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega .95 --asymmetry .4";
    refused("--free amplitude", conservative, 2, "a conservative orbit has no amplitude");
    refused("--free amplitude", &DOUBLING.replace(".165", ".15"), 3, "the force is too weak");
}

#[test]
fn a_resonance_has_no_orbit_to_start_from() {
    let model = "--family double-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega .7731533905021861 --asymmetry .4";
    branch("--free omega", model).assert().code(3).stderr(contains("resonance: harmonic 1").and(contains("mode 10")));
}

/// A branch that runs into a resonance ends there, and says which.
#[test]
fn a_resonance_on_the_way_is_an_end() {
    let model = "--family double-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1 --asymmetry .4";
    let json = answer("--free omega --from .7 --to 1.01 --events grazing", model);
    let ends = list(&json["branches"][0]["ends"]);
    // Mode 10 of 21: Ω² = γ₁ + 4γ₂ sin²(10π/21).
    let mode = (0.2 + 0.4 * (std::f64::consts::PI * 10.0 / 21.0).sin().powi(2)).sqrt();
    assert!(ends[0]["reason"] == "resonance" && close(&ends[0]["value"], mode, 1e-12), "{ends:?}");
    assert!(ends[0]["message"].as_str().unwrap().contains("harmonic 1 meets mode 10") && ends[1]["reason"] == "range");
}

#[test]
fn tables_go_to_standard_output() {
    let output = branch("--free amplitude --to .17 --events fold --csv -", DOUBLING);
    let text = String::from_utf8({ output }.assert().success().get_output().stdout.clone()).unwrap();
    assert!(text.starts_with("branch,generation,event,value") && text.contains(",fold,0.15792745726653"), "{text}");
    assert!(!Path::new("-").exists());
}
