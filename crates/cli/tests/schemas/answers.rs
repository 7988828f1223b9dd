//! What the program writes, held against its schemas: each answer has its form, and nothing near it has.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use vibrochain_lattice::Parameter;
use vibrochain_testkit::{Schema, TestDir, written};

use super::forms::{SCENES, properties};

/// Answers of which each has something that the others have not.
const ORBITS: [&str; 12] = [
    "--family double-sided --sites 6 --gamma1 .2 --gamma2 .15 --asymmetry .4 --omega 1.6",
    "--family double-sided --sites 6 --gamma1 .2 --gamma2 .15 --asymmetry .4 --omega .42",
    "--family single-sided --sites 5 --gamma1 .2 --gamma2 .1 --omega .45 --asymmetry .4",
    "--family double-sided --sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --force 1:.1:0,3:-.033:0,5:.02:.5 --restitution .9",
    "--family double-sided --sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 --restitution .9 --damping .01 --coupling-damping .005",
    "--family period-doubled --sites 7 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .1582 --restitution .25",
    "--word 0+3-,0-3+ --sites 21 --gamma1 .2 --gamma2 .05 --omega 1.5 --asymmetry .2",
    "--word 0+2+,0-2- --sites 5 --gamma1 .2 --gamma2 .2 --omega 1.1 --asymmetry .3 --amplitude .3 --restitution .8",
    "--word 0-1-3- --sites 9 --gamma1 .3 --gamma2 .25 --omega 1 --asymmetry .3 --amplitude .3 --restitution .8",
    "--word 0:0+0:1-,0:0-0:1+ --sites 4 --ends free --layers 2 --gamma3 .3 --gamma1 .2 --gamma2 .1 --omega .8 --asymmetry .2",
    "--family single-sided --sites 5001 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4",
    "--family single-sided --sites 20001 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .165 --restitution .25",
];

const DOUBLING: &str = "--family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .165 --restitution .25";

/// What the program writes: the name of its schema, and the value.
fn answers(dir: &TestDir) -> Vec<(&'static str, Value)> {
    let mut answers = Vec::new();
    let told = |line: &str| written(&dir.run(line).out);
    answers.extend(ORBITS.map(|line| ("orbit", told(&format!("orbit --json {line}")))));
    for line in [
        format!("--event period-doubling --free amplitude {DOUBLING}"),
        format!("--event grazing --free omega --from .9 --to 1.1 {DOUBLING}"),
        "--event grazing --free omega --from 1.3 --to 1.6 --word 0+3+,0-3- --sites 8 --gamma1 .2 --gamma2 .05 --omega 1.5 --asymmetry .2"
            .to_owned(),
    ] {
        answers.push(("locate", told(&format!("locate --json {line}"))));
    }
    let words = "--sites-used 2 --reach 2 --families double-sided --all --sites 5 --gamma1 .2 --gamma2 .05 --omega 1.5 --asymmetry .2";
    answers.push(("words", told(&format!("words --json {words}"))));
    answers.push(("simulate", told(&format!("simulate --json --periods 3.5 {}", ORBITS[3]))));
    answers.push(("branch", told(&format!("branch --json --free amplitude --to .17 --switch {DOUBLING} --csv b.csv"))));
    answers.push(("table", dir.json("b.manifest.json")));
    let plane = "--free amplitude --from .1 --to .3 --and restitution --and-from .2 --and-to .4 --tolerance 1e-3";
    answers.push(("curve", told(&format!("curve --json --event period-doubling {plane} {DOUBLING} --csv c.csv"))));
    answers.push(("table", dir.json("c.manifest.json")));
    dir.scene(
        "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
         x = { parameter = \"omega\", from = 0.6, to = 2.0, points = 30 }\n\
         y = { parameter = \"gamma2\", from = 0.0, to = 0.2, points = 20 }\n\
         [compute]\nfamilies = [\"double-sided\"]\nstability = true\n",
    );
    // The second harmonic all but on a mode: a matrix answers, and why.
    answers.push((
        "orbit",
        told("orbit --sites 21 --gamma1 0.2 --gamma2 0.1 --omega 0.31026359316869373 --asymmetry 0.4 --family double-sided --json"),
    ));
    answers.push(("curves", told("curves scene.toml --json")));
    dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
    answers.push(("manifest", dir.json("map.manifest.json")));
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    answers.push(("plan", dir.json("parts/plan.json")));
    for text in SCENES {
        dir.scene(text);
        dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
        answers.push(("manifest", dir.json("map.manifest.json")));
    }
    // Of stable breathers that a thousandth does not drive away: no words of other motions, whose list is as long as it comes.
    answers.push(("fate", told("fate scene.toml --starts 1 --periods 80 --json --csv f.csv")));
    answers.push(("table", dir.json("f.manifest.json")));
    // Of a structure, likewise.
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/structures");
    let line = format!("fate {}/two-masses.toml --starts 1 --periods 80 --json", scenes.display());
    answers.push(("fate", told(&line)));
    answers
}

/// Answers about structures. Each contains its scene as it was given; the schema of scenes, not this one, says what a scene may hold.
fn of_structures(dir: &TestDir) -> Vec<(&'static str, Value)> {
    let mut answers = Vec::new();
    fs::write(dir.path("k.mtx"), "%%MatrixMarket matrix array real general\n1 1\n1\n").unwrap();
    let one = "omega = 2.3\nword = \"0+\"\nforce_periods = 1\n[structure]\nmasses = [1]\nstiffness = \"k.mtx\"\ndamping = [[0.1]]\n\
        [[contact]]\nweights = [1]\nupper = 0.1\nrestitution = 0.8\n[force]\nload = [1]\n[sweep]\n\
        x = { parameter = \"omega\", from = 2.3, to = 2.5, points = 3 }\n\
        y = { parameter = \"load\", from = 1, to = 1.1, points = 2 }\n\
        [compute]\nfamilies = [\"0+\"]\nstability = true\nthreshold = 0.01\n";
    let damped = "[model]\nsites = 2\nends = \"fixed-free\"\ngamma1 = 0.2\ngamma2 = 0.1\nasymmetry = 0.4\namplitude = 0.1\n\
        restitution = 0.9\n[sweep]\nx = { parameter = \"omega\", from = 1.3, to = 1.5, points = 3 }\n\
        [compute]\nfamilies = [\"single-sided\"]\n";
    let swept = damped
        .replace("\"fixed-free\"", "\"free\"")
        .replace("\"omega\", from = 1.3, to = 1.5", "\"damping\", from = 0, to = 0.1");
    for text in [
        one.to_owned(),
        damped.to_owned(),
        swept.replace("amplitude = 0.1", "amplitude = 0.1\nstatic_force = 0\nomega = 1.4"),
    ] {
        dir.scene(&text);
        dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
        answers.push(("manifest", dir.json("map.manifest.json")));
        dir.run("fate scene.toml --starts 1 --periods 20 --in-sequence --out f.csv").with(0, &[]);
        answers.push(("table", dir.json("f.manifest.json")));
    }
    // Of a light tip in front of its stop, of which one mode is kept or all.
    for modes in ["", "modes = 1\n"] {
        let tip = format!(
            "omega = 1\n[structure]\nmasses = [1, 0.02]\nstiffness = [[9, -8], [-8, 8]]\n{modes}[[contact]]\nweights = [0, 1]\nupper = 0.3\n\
             restitution = 0.7\n[force]\nload = [0.2, 0]\n[sweep]\nx = {{ parameter = \"omega\", from = 0.3, to = 3, points = 40 }}\n\
             [compute]\nfamilies = [\"0+\"]\n"
        );
        dir.scene(&tip);
        dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
        answers.push(("manifest", dir.json("map.manifest.json")));
    }
    dir.scene(one);
    dir.run("sweep scene.toml --out shares --shard 0/1 --quiet").with(0, &[]);
    answers.push(("plan", dir.json("shares/plan.json")));
    answers
}

/// Every place of a value: the keys and indices that lead there.
pub(crate) fn places(value: &Value) -> Vec<String> {
    let mut found = vec![String::new()];
    let below: Vec<(String, &Value)> = match value {
        Value::Object(entries) => entries.iter().map(|(key, value)| (key.clone(), value)).collect(),
        // Entries of a list are of one kind: the first, and the last.
        Value::Array(items) => {
            let ends = BTreeSet::from([0, items.len().saturating_sub(1)]);
            ends.into_iter().filter_map(|i| Some((i.to_string(), items.get(i)?))).collect()
        }
        _ => Vec::new(),
    };
    for (key, value) in below {
        found.extend(places(value).into_iter().map(|rest| format!("/{key}{rest}")));
    }
    found
}

/// Keys without which an answer is one, too.
const MAY_BE_MISSING: [&str; 12] = [
    // Of one layer, of a ring, of a word, of what was searched.
    "layer",
    "ends",
    "intervals",
    "boxes",
    "starts",
    "ended",
    "phases",
    // Of scenes, whose defaults they are; and what is swept is not fixed.
    "spacing",
    "y",
    "axes",
    "collisions",
    "phase",
];

/// Text that may be anything.
const PROSE: [&str; 17] = [
    "touches",
    "obstruction",
    "reason",
    "message",
    "stability_error",
    "multipliers_note",
    "ends",
    "version",
    "revision",
    "scene",
    "title",
    "target",
    "scene_file",
    "threshold",
    "heading",
    "name",
    // Names of a structure's axes.
    "axes",
];

#[test]
fn answers_have_their_form_and_nothing_near_them_has() {
    let dir = TestDir::new();
    let answers = answers(&dir);
    let (mut refused, mut seen) = (0, BTreeSet::new());
    for (name, value) in &answers {
        let schema = Schema::named(name);
        schema.check(value).unwrap_or_else(|error| panic!("{name}: {error}"));
        let parameters: BTreeSet<&str> = Parameter::ALL.into_iter().map(Parameter::name).collect();
        for place in places(value) {
            let (parent, key) = place.rsplit_once('/').unwrap_or_default();
            let here = value.pointer(&place).unwrap();
            seen.insert(key.to_owned());
            let in_list = key.parse::<usize>().is_ok();
            let of = parent.split('/').rfind(|part| part.parse::<usize>().is_err()).unwrap_or_default();
            let mut wrong = Vec::new();
            // A key more.
            if here.is_object() {
                wrong.push(("a key more", with(value, &place, |here| here["zzz"] = 1.into())));
            }
            // A key less. A count of zero cells is not told, nor a dashpot of 0, and what is swept is not in the model.
            let is_dashpot = of == "parameters" && key.ends_with("damping");
            let told_if_any =
                is_dashpot || ["classes", "statuses", "model"].contains(&of) || place == "/compute/impulse";
            if !place.is_empty() && !in_list && !told_if_any && !MAY_BE_MISSING.contains(&key) {
                let less = with(value, parent, |parent| drop(parent.as_object_mut().unwrap().shift_remove(key)));
                wrong.push(("a key less", less));
            }
            // Another type.
            wrong.push(("an object", with(value, &place, |here| *here = json!({ "zzz": [] }))));
            wrong.push(("a list", with(value, &place, |here| *here = json!([{ "zzz": 1 }]))));
            if !here.is_boolean() {
                wrong.push(("a truth", with(value, &place, |here| *here = true.into())));
            }
            if here.is_number() || here.is_boolean() {
                wrong.push(("a word", with(value, &place, |here| *here = "zzz".into())));
            }
            if here.is_string() {
                wrong.push(("a number", with(value, &place, |here| *here = 7.into())));
                let prose = PROSE.contains(&key) || in_list && PROSE.contains(&of);
                if !prose {
                    wrong.push(("another word", with(value, &place, |here| *here = "zzz".into())));
                }
            }
            if here.as_u64().is_some() && !parameters.contains(key) && !["x", "y"].contains(&of) {
                // A count below zero; of numbers that are whole by chance nothing is said.
                let count =
                    !["values", "sides", "points", "range", "leading", "multipliers", "unresolved"].contains(&of);
                let whole = ["sites", "site", "layers", "solution", "evaluations", "spectra", "cells", "generation"];
                if count && whole.contains(&key) {
                    wrong.push(("below zero", with(value, &place, |here| *here = (-1).into())));
                    wrong.push(("a half", with(value, &place, |here| *here = 1.5.into())));
                }
            }
            for (what, changed) in wrong {
                assert!(schema.check(&changed).is_err(), "{name}{place}: {what} is taken");
                refused += 1;
            }
        }
    }
    assert!(answers.len() >= 20 && refused > 5000, "{} {refused}", answers.len());
    let of_structures = of_structures(&dir);
    for (name, value) in &of_structures {
        Schema::named(name).check(value).unwrap_or_else(|error| panic!("{name}: {error}"));
        seen.extend(places(value).iter().filter_map(|place| Some(place.rsplit_once('/')?.1.to_owned())));
    }
    assert_eq!(of_structures.len(), 9);
    // Every key of a schema was in an answer, but for what the borders of a good window lack, and a table of scenes alone.
    for name in
        ["orbit", "locate", "branch", "curve", "curves", "words", "simulate", "manifest", "table", "plan", "fate"]
    {
        let mut keys = BTreeSet::new();
        properties(Schema::named(name).value(), &mut keys);
        let unseen: Vec<_> = keys.iter().filter(|key| !seen.contains(*key)).collect();
        let allowed: &[&str] = match name {
            "curves" => &["at", "between"],
            "manifest" | "table" | "fate" => &["forcing"],
            _ => &[],
        };
        assert!(keys.len() > 10 && unseen == allowed, "{name}: {unseen:?} of {} keys unseen", keys.len());
    }
}

/// `value` with a change at a place.
pub(crate) fn with(value: &Value, place: &str, change: impl FnOnce(&mut Value)) -> Value {
    let mut value = value.clone();
    change(value.pointer_mut(place).unwrap());
    value
}
