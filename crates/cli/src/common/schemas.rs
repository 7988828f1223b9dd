//! The form of every JSON that is written or read, as a JSON Schema (draft 2020-12).
//!
//! Each is a file in `schemas`; what several have in common is in `parts.json` and goes into each that asks for it, so that what
//! is printed needs nothing else. Parameters of the model come from their table, words from their types. The number at the end of an identifier rises when a key goes, or changes its meaning.

use std::path::Path;

use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value, json};
use vibrochain_breather::Family;
use vibrochain_floquet::{Event, Mechanism};
use vibrochain_lattice::{Barrier, Ends, Parameter, Part, Range, Row};
use vibrochain_maps::cell::{Class, Status};
use vibrochain_maps::scene::damped_keys;

use crate::common::error::CliError;
use vibrochain_maps::text::clipped;

/// What answers name in their first key, `schema`.
pub(crate) const ORBIT: &str = "urn:vibrochain:orbit:1";
pub(crate) const LOCATE: &str = "urn:vibrochain:locate:1";
pub(crate) const BRANCH: &str = "urn:vibrochain:branch:1";
pub(crate) const CURVE: &str = "urn:vibrochain:curve:1";
pub(crate) const CURVES: &str = "urn:vibrochain:curves:1";
pub(crate) const SIMULATE: &str = "urn:vibrochain:simulate:1";
pub(crate) const WORDS: &str = "urn:vibrochain:words:1";
pub(crate) const FATE: &str = "urn:vibrochain:fate:1";
pub(crate) const TABLE: &str = "urn:vibrochain:table:1";
pub(crate) const STRUCTURE_BRANCH: &str = "urn:vibrochain:structure-branch:1";
pub(crate) const STRUCTURE_CURVE: &str = "urn:vibrochain:structure-curve:1";
pub(crate) const STRUCTURE_RUN: &str = "urn:vibrochain:structure-run:1";
pub(crate) const STATE: &str = "urn:vibrochain:state:1";

/// Names, and the files.
const SCHEMAS: [(&str, &str); 18] = [
    ("orbit", include_str!("../../schemas/orbit.json")),
    ("structure", include_str!("../../schemas/structure.json")),
    ("structure-run", include_str!("../../schemas/structure-run.json")),
    ("structure-branch", include_str!("../../schemas/structure-branch.json")),
    ("structure-curve", include_str!("../../schemas/structure-curve.json")),
    ("locate", include_str!("../../schemas/locate.json")),
    ("branch", include_str!("../../schemas/branch.json")),
    ("curve", include_str!("../../schemas/curve.json")),
    ("curves", include_str!("../../schemas/curves.json")),
    ("words", include_str!("../../schemas/words.json")),
    ("simulate", include_str!("../../schemas/simulate.json")),
    ("fate", include_str!("../../schemas/fate.json")),
    ("manifest", include_str!("../../schemas/manifest.json")),
    ("table", include_str!("../../schemas/table.json")),
    ("scene", include_str!("../../schemas/scene.json")),
    ("state", include_str!("../../schemas/state.json")),
    ("near", include_str!("../../schemas/near.json")),
    ("plan", include_str!("../../schemas/plan.json")),
];

const PARTS: &str = include_str!("../../schemas/parts.json");

/// Characters shown of an identifier that is none of ours.
const MOST_TOLD: usize = 80;

/// Where a schema has its parts, and how others point there.
const DEFINITIONS: &str = "$defs";
const POINTER: &str = "#/$defs/";

/// The names that `mapgen schema` takes.
#[must_use]
pub fn names() -> [&'static str; SCHEMAS.len()] {
    SCHEMAS.map(|(name, _)| name)
}

/// The schema of that name, with all parts that it asks for.
#[must_use]
pub fn schema(name: &str) -> Option<Value> {
    let (_, text) = SCHEMAS.into_iter().find(|(known, _)| *known == name)?;
    let mut schema: Value = serde_json::from_str(text).ok()?;
    let parts = parts()?;
    let mut here = match schema.as_object_mut()?.remove(DEFINITIONS) {
        Some(Value::Object(own)) => own,
        _ => Map::new(),
    };
    let mut wanted = Vec::new();
    pointers(&schema, &mut wanted);
    here.values().for_each(|part| pointers(part, &mut wanted));
    while let Some(part) = wanted.pop() {
        if !here.contains_key(&part) {
            let value = parts.get(&part)?.clone();
            pointers(&value, &mut wanted);
            here.insert(part, value);
        }
    }
    if !here.is_empty() {
        here.sort_keys();
        schema[DEFINITIONS] = here.into();
    }
    Some(schema)
}

/// What several schemas have in common: the parts in the file with their words, and the parameters, which are keys of a model.
fn parts() -> Option<Map<String, Value>> {
    let mut parts: Map<String, Value> = serde_json::from_str(PARTS).ok()?;
    let words: [(&str, &[&str]); 8] = [
        ("parameter", &Parameter::ALL.map(Parameter::name)),
        ("ends", &Ends::ALL.map(Ends::name)),
        ("family", &Family::ALL.map(Family::name)),
        ("barrier", &Barrier::ALL.map(Barrier::name)),
        ("mechanism", &Mechanism::ALL.map(Mechanism::name)),
        ("event", &Event::ALL.map(Event::name)),
        ("class", &Class::ALL.map(Class::name)),
        ("status", &Status::ALL.map(Status::name)),
    ];
    for (part, words) in words {
        // Where there may be none, the file has null.
        parts.get_mut(part)?["enum"].as_array_mut()?.splice(0..0, words.iter().map(|word| Value::from(*word)));
    }
    let axis = &mut parts.get_mut("axis-of-dashpots")?["properties"]["parameter"];
    axis["enum"] = damped_keys().map(Value::from).collect();
    let damped = &mut parts.get_mut("scene-of-damped-chain")?["anyOf"][0]["properties"]["model"]["anyOf"];
    damped.as_array_mut()?.splice(0..0, damped_keys().map(|key| json!({ "required": [key] })));
    for parameter in Parameter::told() {
        let Row { name, meaning, range: Range { least, most, open, .. }, part, default, .. } = parameter.row();
        let limits = [
            ["minimum", "exclusiveMinimum"][usize::from(open[0])],
            ["maximum", "exclusiveMaximum"][usize::from(open[1])],
        ];
        let rule = json!({ "description": meaning, "type": "number", limits[0]: least, limits[1]: most });
        parts.insert((*name).to_owned(), rule);
        for model in ["parameters", "model-of-scene"] {
            parts.get_mut(model)?["properties"][*name] = json!({ "$ref": format!("{POINTER}{name}") });
        }
        let whole = parts.get_mut("parameters")?;
        // Instead of an amplitude there may be a force.
        if default.is_none() || *part == Part::Driving && parameter != Parameter::Amplitude {
            whole["required"].as_array_mut()?.push((*name).into());
        }
        if *part == Part::Layers {
            whole["dependentRequired"]["layers"].as_array_mut()?.push((*name).into());
            whole["dependentRequired"][*name] = json!(["layers"]);
        }
    }
    Some(parts)
}

/// Refuses a file that says to be something else than what is wanted.
///
/// # Errors
/// [`CliError::Request`] with both.
pub(crate) fn expect(path: &Path, told: Option<&str>, wanted: &str) -> Result<(), CliError> {
    match told {
        Some(told) if told != wanted => Err(CliError::Request(format!(
            "{} is of the form {}, wanted is {wanted} (`mapgen schema` lists them all)",
            path.display(),
            clipped(told, MOST_TOLD)
        ))),
        _ => Ok(()),
    }
}

/// A key that may be missing, but not be null.
pub(crate) fn text<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    String::deserialize(deserializer).map(Some)
}

/// The parts that a value points at.
fn pointers(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::Object(entries) => {
            let part = entries.get("$ref").and_then(Value::as_str).and_then(|pointer| pointer.strip_prefix(POINTER));
            found.extend(part.map(str::to_owned));
            entries.values().for_each(|value| pointers(value, found));
        }
        Value::Array(values) => values.iter().for_each(|value| pointers(value, found)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_schema_is_whole_and_every_part_is_asked_for() {
        let mut parts = parts().unwrap();
        for name in names() {
            let schema = schema(name).unwrap_or_else(|| panic!("{name}"));
            let mut wanted = Vec::new();
            pointers(&schema, &mut wanted);
            let here = schema.get(DEFINITIONS).map_or(0, |here| here.as_object().unwrap().len());
            wanted.sort();
            wanted.dedup();
            assert_eq!(wanted.len(), here, "{name}");
            wanted.iter().for_each(|part| drop(parts.remove(part)));
            let id = format!("urn:vibrochain:{name}:");
            let number =
                schema["$id"].as_str().and_then(|own| own.strip_prefix(&id)).and_then(|n| n.parse::<u32>().ok());
            assert!(number.is_some_and(|number| number > 0), "{name}: {}", schema["$id"]);
            // What names its schema names this one; what is begun with may be the answer to another question.
            if let Some(key) = schema["properties"].get("schema") {
                let own = if name == "near" { ORBIT.into() } else { schema["$id"].clone() };
                assert_eq!(key["const"], own, "{name}");
            }
        }
        assert!(parts.is_empty(), "nothing asks for {:?}", parts.keys());
    }
}
