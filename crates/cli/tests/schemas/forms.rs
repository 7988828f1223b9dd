//! The form of every JSON, as `mapgen schema` prints it, against what is written and read.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use vibrochain_lattice::Parameter;
use vibrochain_testkit::{Schema, TestDir, written};

use super::answers::{places, with};

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

/// All kinds of axes; all that a model may have.
pub(crate) const SCENES: [&str; 3] = [
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

/// All keys that a schema knows.
pub(crate) fn properties(schema: &Value, keys: &mut BTreeSet<String>) {
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
pub(crate) fn words<'a>(schema: &'a Value, found: &mut BTreeSet<&'a str>) {
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
    let (dir, schema) = (TestDir::new(), Schema::named("scene").value());
    let (mut taken, mut refused) = (0, 0);
    for parameter in Parameter::ALL.map(Parameter::name) {
        let rule = Schema::of(schema["$defs"][parameter].clone());
        for value in [-1.0, 0.0, 1e-101, 1e-100, 0.5, 1.0, 1.0 + f64::EPSILON, 1.5, 1e100, 2e100] {
            let mut model = json!({
                "sites": 1, "layers": 2, "gamma1": 0.2, "gamma2": 0.1, "gamma3": 0.05, "omega": 1.5, "asymmetry": 0.4,
                "amplitude": 0.1, "restitution": 0.9,
            });
            model[parameter] = value.into();
            fs::write(dir.path("model.json"), json!({ "model": model }).to_string()).unwrap();
            let ran = dir.run("orbit --family single-sided --scene model.json");
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
    let dir = TestDir::new();
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
                fs::write(dir.path("scene.json"), scene.to_string()).unwrap();
                dir.run("sweep scene.json --out map.csv").with(2, &["scene.json"]);
                refused += 1;
            }
        }
    }
    assert!(refused > 80, "{refused}");
}

/// What is read is taken if it has its form, and refused if it has not.
#[test]
fn states_and_orbits_to_begin_with_are_read_as_their_schemas_say() {
    let dir = TestDir::new();
    let model = "--sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";
    let answer = written(&dir.run(&format!("orbit --json --family double-sided {model}")).out);
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
            fs::write(dir.path("given.json"), value.to_string()).unwrap();
            let ran = dir.run(&line);
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
    let dir = TestDir::new();
    let list = dir.run("schema").with(0, &[]);
    let names: Vec<&str> = list.out.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(names, NAMES);
    // The page on JSON has all of them, and no other.
    let page = fs::read_to_string(repository().join("docs/data.md")).unwrap();
    let (_, rows) = page.split_once("| schema | of |\n|---|---|\n").unwrap();
    let rows = rows.lines().take_while(|line| line.starts_with('|'));
    let told: BTreeSet<&str> = rows.flat_map(|row| quoted(row.split('|').nth(1).unwrap())).collect();
    assert_eq!(told, BTreeSet::from(NAMES));
    for name in NAMES {
        let printed: Value = serde_json::from_str(&dir.run(&format!("schema {name}")).with(0, &[]).out).unwrap();
        assert_eq!(printed["$schema"], "https://json-schema.org/draft/2020-12/schema");
        assert_eq!(printed["$id"], format!("urn:vibrochain:{name}:1"));
    }
    dir.run("schema orbits").with(
        2,
        &[
            "orbits",
            "orbit, structure, structure-run, structure-branch, structure-curve, locate, branch, curve, curves, words, simulate, fate, manifest, table, scene, state, near, plan",
        ],
    );
    dir.run("schema orbit curve").with(2, &["curve"]);
    dir.shell("mapgen schema orbit | head -n 1").with(0, &[]);
    // Of a file that says to be something else, both are told.
    fs::write(dir.path("other.json"), r#"{"schema":"urn:vibrochain:curve:1","curves":[]}"#).unwrap();
    let model = "--sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";
    dir.run(&format!("orbit --near other.json {model}")).with(2, &["urn:vibrochain:curve:1", "urn:vibrochain:orbit:1"]);
}

/// Tests of the program take JSON through what holds it against its schema.
#[test]
fn no_test_reads_json_past_its_schema() {
    let (mut read, mut folders) = (0, vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            // These read schemas, and those of damaged requests their own states.
            let own = ["schemas", "mutations"].iter().any(|name| path.ends_with(name));
            if path.is_dir() && !own {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                assert!(
                    !text.contains("serde_json::from_"),
                    "{} reads JSON as it comes: take `written`",
                    path.display()
                );
                read += text.matches("written(").count() + text.matches(".json(").count();
            }
        }
    }
    assert!(read > 30, "{read}");
}
