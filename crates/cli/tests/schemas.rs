//! The form of every JSON, as `mapgen schema` prints it, against what is written and read.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use vibrochain_lattice::Parameter;
use vibrochain_testkit::{Desk, Schema, written};

const NAMES: [&str; 18] = [
    "orbit",
    "structure",
    "structure-run",
    "structure-branch",
    "structure-curve",
    "locate",
    "branch",
    "curve",
    "curves",
    "words",
    "simulate",
    "fate",
    "manifest",
    "table",
    "scene",
    "state",
    "near",
    "plan",
];

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Answers of which each has something that the others have not.
const ORBITS: [&str; 10] = [
    "--family double-sided --sites 6 --gamma1 .2 --gamma2 .15 --asymmetry .4 --omega 1.6",
    "--family double-sided --sites 6 --gamma1 .2 --gamma2 .15 --asymmetry .4 --omega .42",
    "--family single-sided --sites 5 --gamma1 .2 --gamma2 .1 --omega .45 --asymmetry .4",
    "--family double-sided --sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --force 1:.1:0,3:-.033:0,5:.02:.5 --restitution .9",
    "--family period-doubled --sites 7 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .1582 --restitution .25",
    "--word 0+3-,0-3+ --sites 21 --gamma1 .2 --gamma2 .05 --omega 1.5 --asymmetry .2",
    "--word 0+2+,0-2- --sites 5 --gamma1 .2 --gamma2 .2 --omega 1.1 --asymmetry .3 --amplitude .3 --restitution .8",
    "--word 0:0+0:1-,0:0-0:1+ --sites 4 --ends free --layers 2 --gamma3 .3 --gamma1 .2 --gamma2 .1 --omega .8 --asymmetry .2",
    "--family single-sided --sites 5001 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4",
    "--family single-sided --sites 21 --gamma1 2.3e-308 --gamma2 .1 --omega .92 --asymmetry .7 --amplitude .05 --restitution .9",
];

const DOUBLING: &str = "--family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .165 --restitution .25";

/// What the program writes: the name of its schema, and the value.
fn answers(desk: &Desk) -> Vec<(&'static str, Value)> {
    let mut answers = Vec::new();
    let told = |line: &str| written(&desk.run(line).out);
    answers.extend(ORBITS.map(|line| ("orbit", told(&format!("orbit --json {line}")))));
    for line in [
        format!("--event period-doubling --free amplitude {DOUBLING}"),
        format!("--event grazing --free omega --from .9 --to 1.1 {DOUBLING}"),
        "--event grazing --free omega --from 1.3 --to 1.6 --word 0+3+,0-3- --sites 8 --gamma1 .2 --gamma2 .05 --omega 1.5 --asymmetry .2"
            .to_owned(),
    ] {
        answers.push(("locate", told(&format!("locate --json {line}"))));
    }
    let words = "--sites-used 2 --reach 2 --all --sites 5 --gamma1 .2 --gamma2 .05 --omega 1.5 --asymmetry .2";
    answers.push(("words", told(&format!("words --json {words}"))));
    answers.push(("simulate", told(&format!("simulate --json --periods 3.5 {}", ORBITS[3]))));
    answers.push(("branch", told(&format!("branch --json --free amplitude --to .17 --switch {DOUBLING} --csv b.csv"))));
    answers.push(("table", desk.json("b.manifest.json")));
    let plane = "--free amplitude --from .1 --to .3 --and restitution --and-from .2 --and-to .4 --tolerance 1e-3";
    answers.push(("curve", told(&format!("curve --json --event period-doubling {plane} {DOUBLING} --csv c.csv"))));
    answers.push(("table", desk.json("c.manifest.json")));
    desk.scene(
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
    desk.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
    answers.push(("manifest", desk.json("map.manifest.json")));
    let refined = "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\nrefine = { depth = 1 }\n\
        x = { parameter = \"omega\", from = 0.8, to = 1.2, points = 4 }\n\
        y = { parameter = \"gamma2\", from = 0.1, to = 0.2, points = 3 }\n[compute]\nfamilies = [\"single-sided\"]\n";
    std::fs::write(desk.path("refined.toml"), refined).unwrap();
    desk.run("sweep refined.toml --out refined.csv --quiet").with(0, &[]);
    answers.push(("manifest", desk.json("refined.manifest.json")));
    desk.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    answers.push(("plan", desk.json("parts/plan.json")));
    for text in SCENES {
        desk.scene(text);
        desk.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
        answers.push(("manifest", desk.json("map.manifest.json")));
    }
    // Of stable breathers that a thousandth does not drive away: no words of other motions, whose list is as long as it comes.
    answers.push(("fate", told("fate scene.toml --starts 1 --periods 80 --json --csv f.csv")));
    answers.push(("table", desk.json("f.manifest.json")));
    // Of a structure, likewise.
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/structures");
    let line = format!("fate {}/two-masses.toml --starts 1 --periods 80 --json", scenes.display());
    answers.push(("fate", told(&line)));
    answers
}

/// What is written of structures, whose scenes stand there as they are: what these may hold is told where they are read.
fn of_structures(desk: &Desk) -> Vec<(&'static str, Value)> {
    let mut answers = Vec::new();
    fs::write(desk.path("k.mtx"), "%%MatrixMarket matrix array real general\n1 1\n1\n").unwrap();
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
    for text in [one.to_owned(), damped.to_owned(), swept.replace("amplitude = 0.1", "amplitude = 0.1\nomega = 1.4")] {
        desk.scene(&text);
        desk.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
        answers.push(("manifest", desk.json("map.manifest.json")));
        desk.run("fate scene.toml --starts 1 --periods 20 --out f.csv").with(0, &[]);
        answers.push(("table", desk.json("f.manifest.json")));
    }
    desk.scene(one);
    desk.run("sweep scene.toml --out shares --shard 0/1 --quiet").with(0, &[]);
    answers.push(("plan", desk.json("shares/plan.json")));
    answers
}

/// All kinds of axes; all that a model may have.
const SCENES: [&str; 3] = [
    "title = 'three axes'\n[model]\nsites = 4\nends = 'free'\nlayers = 2\nlayer_ends = 'free'\ngamma1 = 0.2\ngamma3 = 0.05\n\
     forcing = { amplitude = 0.1, restitution = 0.9 }\n[sweep]\nx = { parameter = 'omega', from = 1.1, to = 1.7, points = 3 }\n\
     y = { parameter = 'gamma2', from = 0.01, to = 0.1, points = 2, spacing = 'log' }\n\
     axes = [{ parameter = 'asymmetry', values = [0.4, 0.1] }]\n\
     [compute]\nfamilies = ['0:0+0:1+,0:0-0:1-']\nstability = true\nthreshold = 0.01\n",
    "[model]\nsites = 5\ngamma1 = 0.2\ngamma2 = 0.1\nasymmetry = 0.3\nrestitution = 0.9\n\
     force = [{ harmonic = 1, amplitude = 0.1 }, { harmonic = 3, amplitude = -0.02, phase = 1.0 }]\n\
     [sweep]\naxes = [{ parameter = 'omega', values = [1.1, 1.7] }]\n[compute]\nfamilies = ['double-sided', 'single-sided']\n",
    "[model]\nsites = 5\ngamma1 = 0.2\ngamma2 = 0.1\nasymmetry = 0.3\n[sweep]\nx = { parameter = 'omega', values = [1.1, 1.7] }\n\
     [compute]\nfamilies = ['double-sided-symmetric']\nstability = true\ncollisions = true\nimpulse = true\n",
];

/// Every place of a value: the keys and indices that lead there.
fn places(value: &Value) -> Vec<String> {
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
const MAY_BE_MISSING: [&str; 15] = [
    "refine",
    "refinement",
    // Of one layer, of a ring, of a word, of what was searched.
    "layer",
    "ends",
    "intervals",
    "boxes",
    "starts",
    "ended",
    "phases",
    "doubt",
    // Of scenes, whose defaults they are; and what is swept is not fixed.
    "spacing",
    "y",
    "axes",
    "collisions",
    "phase",
];

/// Text that may be anything.
const PROSE: [&str; 17] = [
    "obstruction",
    "reason",
    "message",
    "stability_error",
    "multipliers_note",
    "doubt",
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
    let desk = Desk::new();
    let answers = answers(&desk);
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
            // A key less. A count of zero cells is not told, and what is swept is not in the model.
            let told_if_any = ["classes", "statuses", "model"].contains(&of) || place == "/compute/impulse";
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
    let of_structures = of_structures(&desk);
    for (name, value) in &of_structures {
        Schema::named(name).check(value).unwrap_or_else(|error| panic!("{name}: {error}"));
        seen.extend(places(value).iter().filter_map(|place| Some(place.rsplit_once('/')?.1.to_owned())));
    }
    assert_eq!(of_structures.len(), 7);
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
fn with(value: &Value, place: &str, change: impl FnOnce(&mut Value)) -> Value {
    let mut value = value.clone();
    change(value.pointer_mut(place).unwrap());
    value
}

/// All keys that a schema knows.
fn properties(schema: &Value, keys: &mut BTreeSet<String>) {
    match schema {
        Value::Object(rules) => {
            for (word, rule) in rules {
                if let ("properties", Some(properties)) = (word.as_str(), rule.as_object()) {
                    keys.extend(properties.iter().filter(|(_, rule)| **rule != false).map(|(key, _)| key.clone()));
                }
                properties(rule, keys);
            }
        }
        Value::Array(rules) => rules.iter().for_each(|rule| properties(rule, keys)),
        _ => {}
    }
}

/// All words that a schema and the schemas within it use.
fn words<'a>(schema: &'a Value, found: &mut BTreeSet<&'a str>) {
    for (word, rule) in schema.as_object().into_iter().flatten() {
        found.insert(word);
        match (word.as_str(), rule) {
            ("properties" | "$defs", Value::Object(named)) => named.values().for_each(|rule| words(rule, found)),
            ("anyOf" | "oneOf", Value::Array(rules)) => rules.iter().for_each(|rule| words(rule, found)),
            ("enum" | "const" | "required" | "dependentRequired", _) => {}
            _ => words(rule, found),
        }
    }
}

/// A validator passes over a word that it does not know: one that is misspelt would go unchecked.
#[test]
fn schemas_use_words_of_json_schema_alone() {
    const KNOWN: [&str; 31] = [
        "$defs",
        "$id",
        "$ref",
        "$schema",
        "additionalProperties",
        "anyOf",
        "const",
        "dependentRequired",
        "description",
        "else",
        "enum",
        "exclusiveMaximum",
        "exclusiveMinimum",
        "if",
        "items",
        "maxItems",
        "maximum",
        "minItems",
        "minimum",
        "multipleOf",
        "not",
        "oneOf",
        "pattern",
        "properties",
        "propertyNames",
        "required",
        "then",
        "title",
        "type",
        "unevaluatedProperties",
        "uniqueItems",
    ];
    let mut found = BTreeSet::new();
    NAMES.iter().for_each(|name| words(Schema::named(name).value(), &mut found));
    assert!(found.iter().all(|word| KNOWN.contains(word)) && found.len() > 25, "{found:?}");
    let misspelt = json!({ "properties": { "a": { "anyOf": [{ "maximun": 1 }] } } });
    found.clear();
    words(&misspelt, &mut found);
    assert_eq!(found, BTreeSet::from(["anyOf", "maximun", "properties"]));
}

/// A value is refused by the program where its range in the schema ends, and nowhere else.
#[test]
fn ranges_of_parameters_are_those_of_the_program() {
    let (desk, schema) = (Desk::new(), Schema::named("scene").value());
    let (mut taken, mut refused) = (0, 0);
    for parameter in Parameter::ALL.map(Parameter::name) {
        let rule = Schema::of(schema["$defs"][parameter].clone());
        for value in [-1.0, 0.0, 1e-101, 1e-100, 0.5, 1.0, 1.0 + f64::EPSILON, 1.5, 1e100, 2e100] {
            let mut model = json!({
                "sites": 1, "layers": 2, "gamma1": 0.2, "gamma2": 0.1, "gamma3": 0.05, "omega": 1.5, "asymmetry": 0.4,
                "amplitude": 0.1, "restitution": 0.9,
            });
            model[parameter] = value.into();
            fs::write(desk.path("model.json"), json!({ "model": model }).to_string()).unwrap();
            let ran = desk.run("orbit --family single-sided --scene model.json");
            let is_refused = ran.err.contains(&format!("{parameter} = ")) && ran.err.contains("is out of range: give");
            assert_eq!(rule.check(&value.into()).is_err(), is_refused, "{parameter} = {value}: {}", ran.err);
            *(if is_refused { &mut refused } else { &mut taken }) += 1;
        }
    }
    assert!(taken >= 20 && refused >= 14, "{taken} {refused}");
}

/// What is between backquotes.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// docs/scenes.md, which a test holds against the reader of scenes, has the keys of the schema; its examples and all scenes that
/// come with the program have its form.
#[test]
fn scenes_have_their_form() {
    let schema = Schema::named("scene");
    let document = fs::read_to_string(repository().join("docs/scenes.md")).unwrap();
    for (heading, place) in [
        ("## The file\n", "/properties"),
        ("## `[model]`\n", "/$defs/model-of-scene/properties"),
        ("### `forcing`\n", "/$defs/model-of-scene/properties/forcing/properties"),
        ("### `force`\n", "/$defs/force/items/properties"),
        ("## `[sweep]`\n", "/$defs/sweep/properties"),
        ("### An axis\n", "/$defs/axis/properties"),
        ("## `[compute]`\n", "/$defs/compute/properties"),
    ] {
        let section = document.split(heading).nth(1).unwrap().split("\n#").next().unwrap();
        let rows = section.lines().filter(|line| line.starts_with("| `"));
        let told: BTreeSet<&str> = rows.map(|row| quoted(row).next().unwrap()).collect();
        let known = schema.value().pointer(place).unwrap().as_object().unwrap();
        assert_eq!(known.keys().map(String::as_str).collect::<BTreeSet<_>>(), told, "{heading}");
    }
    let mut texts: Vec<String> =
        document.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap().to_owned()).collect();
    let files = fs::read_dir(repository().join("scenes")).unwrap().map(|entry| entry.unwrap().path());
    texts.extend(files.filter(|path| path.is_file()).map(|path| fs::read_to_string(path).unwrap()));
    texts.extend(SCENES.map(str::to_owned));
    assert!(texts.len() > 15, "{}", texts.len());
    for text in &texts {
        let scene: Value = toml::from_str(text).unwrap();
        schema.check(&scene).unwrap_or_else(|error| panic!("{error} in {text}"));
    }
    // Whatever is wrong in its form, schema and program refuse both.
    let desk = Desk::new();
    let mut refused = 0;
    for text in SCENES {
        let scene: Value = toml::from_str(text).unwrap();
        for place in places(&scene) {
            let mut wrong = vec![with(&scene, &place, |here| *here = json!({ "zzz": [] }))];
            if scene.pointer(&place).unwrap().is_object() {
                wrong.push(with(&scene, &place, |here| here["zzz"] = 1.into()));
            }
            for scene in wrong {
                assert!(schema.check(&scene).is_err(), "{place}: {scene}");
                fs::write(desk.path("scene.json"), scene.to_string()).unwrap();
                desk.run("sweep scene.json --out map.csv").with(2, &["scene.json"]);
                refused += 1;
            }
        }
    }
    assert!(refused > 80, "{refused}");
}

/// What is read is taken if it has its form, and refused if it has not.
#[test]
fn states_and_orbits_to_begin_with_are_read_as_their_schemas_say() {
    let desk = Desk::new();
    let model = "--sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";
    let answer = written(&desk.run(&format!("orbit --json --family double-sided {model}")).out);
    let impacts = json!([
        { "site": 0, "barrier": "upper", "time": 0, "impulse": -3.4 },
        { "site": 0, "layer": 0, "barrier": "lower", "time": 2.1, "impulse": 3.0 },
    ]);
    let state = json!({ "schema": "urn:vibrochain:state:1", "psi": 0.1, "displacement": [0.1, 0, 0, 0, 0], "velocity": [0, 0, 0, 0, 0.5] });
    let orbit = |name: &str| format!("orbit --json --near {name} {model}");
    let (mut taken, mut refused) = (0, 0);
    for (schema, value, line) in [
        ("state", state, format!("simulate --state given.json --periods 1 {model}")),
        ("near", json!({ "impacts": impacts, "psi": null }), orbit("given.json")),
        ("near", answer, orbit("given.json")),
    ] {
        let mut tries = vec![value.clone(), json!([]), json!({}), json!({ "schema": "urn:vibrochain:curve:1" })];
        for place in places(&value) {
            let (parent, key) = place.rsplit_once('/').unwrap_or_default();
            for wrong in [json!({ "zzz": 1 }), json!("zzz"), json!(true), json!(null), json!(-1), json!([])] {
                tries.push(with(&value, &place, |here| *here = wrong));
            }
            if !place.is_empty() && key.parse::<usize>().is_err() {
                tries.push(with(&value, parent, |parent| drop(parent.as_object_mut().unwrap().shift_remove(key))));
            }
        }
        for value in tries {
            let form = Schema::named(schema).check(&value);
            fs::write(desk.path("given.json"), value.to_string()).unwrap();
            let ran = desk.run(&line);
            // What has its form may still be no orbit of this model: a sum of masses, a time beyond the period.
            let said =
                ["starts at", "cannot be", "does not", "converge", "out of range", "masses", "no orbit", "times"];
            match &form {
                Ok(()) => {
                    let of_values = ran.code == Some(0) || said.iter().any(|words| ran.err.contains(words));
                    assert!(of_values, "{schema} takes {value}, the program says {ran:?}");
                    taken += 1;
                }
                Err(error) => {
                    assert_eq!(ran.code, Some(2), "{schema} says {error} of {value}, the program takes it");
                    refused += 1;
                }
            }
        }
    }
    assert!(taken > 100 && refused > 100, "{taken} {refused}");
}

#[test]
fn schemas_are_listed_and_printed_and_other_names_refused() {
    let desk = Desk::new();
    let list = desk.run("schema").with(0, &[]);
    let names: Vec<&str> = list.out.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(names, NAMES);
    // The page on JSON has all of them, and no other.
    let page = fs::read_to_string(repository().join("docs/data.md")).unwrap();
    let (_, rows) = page.split_once("| schema | of |\n|---|---|\n").unwrap();
    let rows = rows.lines().take_while(|line| line.starts_with('|'));
    let told: BTreeSet<&str> = rows.flat_map(|row| quoted(row.split('|').nth(1).unwrap())).collect();
    assert_eq!(told, BTreeSet::from(NAMES));
    for name in NAMES {
        let printed: Value = serde_json::from_str(&desk.run(&format!("schema {name}")).with(0, &[]).out).unwrap();
        assert_eq!(printed["$schema"], "https://json-schema.org/draft/2020-12/schema");
        assert_eq!(printed["$id"], format!("urn:vibrochain:{name}:1"));
    }
    desk.run("schema orbits").with(
        2,
        &[
            "orbits",
            "orbit, structure, structure-run, structure-branch, structure-curve, locate, branch, curve, curves, words, simulate, fate, manifest, table, scene, state, near, plan",
        ],
    );
    desk.run("schema orbit curve").with(2, &["curve"]);
    desk.shell("mapgen schema orbit | head -n 1").with(0, &[]);
    // Of a file that says to be something else, both are told.
    fs::write(desk.path("other.json"), r#"{"schema":"urn:vibrochain:curve:1","curves":[]}"#).unwrap();
    let model = "--sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";
    desk.run(&format!("orbit --near other.json {model}"))
        .with(2, &["urn:vibrochain:curve:1", "urn:vibrochain:orbit:1"]);
}

/// Tests of the program take JSON through what holds it against its schema.
#[test]
fn no_test_reads_json_past_its_schema() {
    let mut read = 0;
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")).unwrap() {
        let path = entry.unwrap().path();
        // This one reads schemas, and the one of damaged requests its own states.
        let own = ["schemas.rs", "mutations.rs"].iter().any(|name| path.ends_with(name));
        if path.extension().is_none_or(|end| end != "rs") || own {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        assert!(!text.contains("serde_json::from_"), "{} reads JSON as it comes: take `written`", path.display());
        read += text.matches("written(").count() + text.matches(".json(").count();
    }
    assert!(read > 30, "{read}");
}
