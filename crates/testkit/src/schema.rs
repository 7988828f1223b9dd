//! JSON held against the schemas that the program prints.
//!
//! The words of JSON Schema that these schemas use, and no others: one that is not known here stops the test, so that nothing goes
//! unchecked. (The tests of the Python package ask a full library the same questions.)

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use regex_lite::Regex;
use serde_json::{Map, Value};

/// A schema.
#[derive(Debug, Clone)]
pub struct Schema {
    root: Value,
}

/// The properties of an object that a schema has looked at, for `unevaluatedProperties`.
type Seen<'a> = BTreeSet<&'a str>;

impl Schema {
    /// That of `mapgen schema NAME`; asked for once in a process.
    #[must_use]
    pub fn named(name: &str) -> &'static Self {
        static SCHEMAS: Mutex<BTreeMap<String, &'static Schema>> = Mutex::new(BTreeMap::new());
        let mut schemas = SCHEMAS.lock().unwrap_or_else(PoisonError::into_inner);
        schemas.entry(name.to_owned()).or_insert_with(|| {
            let output = Command::new(assert_cmd::cargo::cargo_bin("mapgen")).args(["schema", name]).output().unwrap();
            assert!(output.status.success(), "no schema of {name}: {output:?}");
            Box::leak(Box::new(Self::of(serde_json::from_slice(&output.stdout).unwrap())))
        })
    }

    /// That which a value names in its first key, as `urn:vibrochain:orbit:1`; plans name none.
    ///
    /// # Errors
    /// That it names none.
    pub fn of_value(value: &Value) -> Result<&'static Self, String> {
        let first = value.as_object().and_then(|entries| entries.iter().next());
        match first.map(|(key, value)| (key.as_str(), value.as_str())) {
            Some(("schema", Some(id))) => {
                let name = id.strip_prefix("urn:vibrochain:").and_then(|rest| rest.split(':').next());
                name.map(Self::named).ok_or_else(|| format!("{id} is no schema of ours"))
            }
            Some(("program", _)) => Ok(Self::named("plan")),
            _ => Err("no schema is named".to_owned()),
        }
    }

    /// From its text as a value.
    #[must_use]
    pub fn of(root: Value) -> Self {
        Self { root }
    }

    /// The schema itself.
    #[must_use]
    pub fn value(&self) -> &Value {
        &self.root
    }

    /// Whether a value has this form.
    ///
    /// # Errors
    /// The first thing that is wrong, and where.
    pub fn check(&self, value: &Value) -> Result<(), String> {
        self.against(&self.root, value, "").map(drop)
    }

    fn against<'a>(&self, schema: &Value, value: &'a Value, path: &str) -> Result<Seen<'a>, String> {
        let rules = match schema {
            Value::Bool(true) => return Ok(Seen::new()),
            Value::Bool(false) => return Err(format!("{path} may not be there")),
            Value::Object(rules) => rules,
            other => panic!("{other} is no schema"),
        };
        let mut seen = Seen::new();
        let wrong = |what: &str| Err(format!("{path}: {what}"));
        for (word, rule) in rules {
            let holds = match word.as_str() {
                "$schema" | "$id" | "$defs" | "title" | "description" => true,
                // What `if` decides, and what asks for all that was seen, come with or after the rest.
                "then" | "else" | "unevaluatedProperties" => true,
                "$ref" => {
                    seen.extend(self.against(self.definition(rule.as_str().unwrap()), value, path)?);
                    true
                }
                "if" => {
                    let branch = match self.against(rule, value, path) {
                        Ok(more) => {
                            seen.extend(more);
                            "then"
                        }
                        Err(_) => "else",
                    };
                    if let Some(rule) = rules.get(branch) {
                        seen.extend(self.against(rule, value, path)?);
                    }
                    true
                }
                "anyOf" | "oneOf" => {
                    let tried: Vec<_> = list(rule).iter().map(|rule| self.against(rule, value, path)).collect();
                    let fit = tried.iter().filter(|one| one.is_ok()).count();
                    if fit == 0 || (word == "oneOf" && fit > 1) {
                        let complaints: Vec<_> = tried.into_iter().filter_map(Result::err).collect();
                        return Err(format!("{path}: {fit} of {word} fit: {}", complaints.join("; ")));
                    }
                    seen.extend(tried.into_iter().flatten().flatten());
                    true
                }
                "not" => self.against(rule, value, path).is_err(),
                "enum" => list(rule).contains(value),
                "const" => rule == value,
                "type" => match rule {
                    Value::String(name) => is_of(name, value),
                    names => list(names).iter().any(|name| is_of(name.as_str().unwrap(), value)),
                },
                _ => match value {
                    Value::Object(entries) => self.of_object(word, rule, rules, entries, path, &mut seen)?,
                    Value::Array(items) => self.of_array(word, rule, items, path)?,
                    Value::String(text) => of_text(word, rule, text),
                    Value::Number(number) => of_number(word, rule, number.as_f64().unwrap()),
                    Value::Null | Value::Bool(_) => is_known(word),
                },
            };
            if !holds {
                let shown: String = value.to_string().chars().take(100).collect();
                return wrong(&format!("{shown} breaks {word} {rule}"));
            }
        }
        if let (Some(rule), Value::Object(entries)) = (rules.get("unevaluatedProperties"), value) {
            assert_eq!(*rule, Value::Bool(false), "nothing else is asked for");
            if let Some(key) = entries.keys().find(|key| !seen.contains(key.as_str())) {
                return wrong(&format!("`{key}` is unknown"));
            }
        }
        Ok(seen)
    }

    fn definition(&self, pointer: &str) -> &Value {
        let part = pointer.strip_prefix('#').unwrap_or_else(|| panic!("{pointer} points elsewhere"));
        self.root.pointer(part).unwrap_or_else(|| panic!("{pointer} points nowhere"))
    }

    fn of_object<'a>(
        &self,
        word: &str,
        rule: &Value,
        rules: &Map<String, Value>,
        entries: &'a Map<String, Value>,
        path: &str,
        seen: &mut Seen<'a>,
    ) -> Result<bool, String> {
        let lacks = |keys: &Value| list(keys).iter().any(|key| !entries.contains_key(key.as_str().unwrap()));
        match word {
            "required" => Ok(!lacks(rule)),
            "dependentRequired" => {
                let mut pairs = rule.as_object().unwrap().iter();
                Ok(!pairs.any(|(key, others)| entries.contains_key(key) && lacks(others)))
            }
            "properties" => {
                for (key, rule) in rule.as_object().unwrap() {
                    if let Some((key, value)) = entries.get_key_value(key) {
                        self.against(rule, value, &format!("{path}.{key}"))?;
                        seen.insert(key);
                    }
                }
                Ok(true)
            }
            "additionalProperties" => {
                let known = rules.get("properties").and_then(Value::as_object);
                for (key, value) in
                    entries.iter().filter(|(key, _)| !known.is_some_and(|known| known.contains_key(*key)))
                {
                    self.against(rule, value, &format!("{path}.{key}"))?;
                    seen.insert(key);
                }
                Ok(true)
            }
            "propertyNames" => {
                for key in entries.keys() {
                    self.against(rule, &key.as_str().into(), &format!("{path}.{key}"))?;
                }
                Ok(true)
            }
            word => Ok(is_known(word)),
        }
    }

    fn of_array(&self, word: &str, rule: &Value, items: &[Value], path: &str) -> Result<bool, String> {
        match word {
            "items" => {
                for (i, item) in items.iter().enumerate() {
                    self.against(rule, item, &format!("{path}[{i}]"))?;
                }
                Ok(true)
            }
            "minItems" => Ok(items.len() as u64 >= rule.as_u64().unwrap()),
            "maxItems" => Ok(items.len() as u64 <= rule.as_u64().unwrap()),
            "uniqueItems" => {
                let texts: BTreeSet<String> = items.iter().map(Value::to_string).collect();
                Ok(rule == false || texts.len() == items.len())
            }
            word => Ok(is_known(word)),
        }
    }
}

fn list(rule: &Value) -> &[Value] {
    rule.as_array().unwrap_or_else(|| panic!("{rule} is no list"))
}

fn is_of(name: &str, value: &Value) -> bool {
    match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        name => panic!("{name} is no type"),
    }
}

fn of_text(word: &str, rule: &Value, text: &str) -> bool {
    match word {
        "pattern" => Regex::new(rule.as_str().unwrap()).unwrap().is_match(text),
        word => is_known(word),
    }
}

fn of_number(word: &str, rule: &Value, number: f64) -> bool {
    let limit = || rule.as_f64().unwrap();
    match word {
        "minimum" => number >= limit(),
        "maximum" => number <= limit(),
        "exclusiveMinimum" => number > limit(),
        "exclusiveMaximum" => number < limit(),
        "multipleOf" => number % limit() == 0.0,
        word => is_known(word),
    }
}

/// A word that asks nothing of values of this type; one that is not known is a mistake in the schema, or here.
fn is_known(word: &str) -> bool {
    const KNOWN: [&str; 15] = [
        "required",
        "dependentRequired",
        "properties",
        "additionalProperties",
        "propertyNames",
        "items",
        "minItems",
        "maxItems",
        "uniqueItems",
        "pattern",
        "minimum",
        "maximum",
        "exclusiveMinimum",
        "exclusiveMaximum",
        "multipleOf",
    ];
    assert!(KNOWN.contains(&word), "`{word}` of JSON Schema is not known here");
    true
}

/// What the program has written, held against the schema that it names.
///
/// # Errors
/// What is wrong with it.
pub fn checked(text: impl AsRef<[u8]>) -> Result<Value, String> {
    let value: Value = serde_json::from_slice(text.as_ref()).map_err(|error| format!("not JSON: {error}"))?;
    Schema::of_value(&value)?.check(&value)?;
    Ok(value)
}

/// What the program has written; it must have the form that it names.
#[must_use]
#[track_caller]
pub fn written(text: impl AsRef<[u8]>) -> Value {
    checked(text).unwrap_or_else(|error| panic!("{error}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// For each word a value that it takes, and one that it does not.
    #[test]
    fn every_word_takes_and_refuses() {
        let cases = [
            (json!({ "type": "integer" }), json!(3), json!(3.5)),
            (json!({ "type": ["number", "null"] }), json!(null), json!("1")),
            (json!({ "type": "object" }), json!({}), json!([])),
            (json!({ "type": "array" }), json!([]), json!({})),
            (json!({ "type": "boolean" }), json!(true), json!(1)),
            (json!({ "enum": [1, null] }), json!(null), json!(2)),
            (json!({ "const": "a" }), json!("a"), json!("b")),
            (json!({ "not": { "multipleOf": 2 } }), json!(3), json!(4)),
            (json!({ "minimum": 1 }), json!(1), json!(0.5)),
            (json!({ "maximum": 1 }), json!(1), json!(1.5)),
            (json!({ "exclusiveMinimum": 1 }), json!(1.5), json!(1)),
            (json!({ "exclusiveMaximum": 1 }), json!(0.5), json!(1)),
            (json!({ "pattern": "^[0-9]+$" }), json!("12"), json!("1a")),
            (json!({ "items": { "type": "null" } }), json!([null]), json!([null, 1])),
            (json!({ "minItems": 1 }), json!([1]), json!([])),
            (json!({ "maxItems": 1 }), json!([1]), json!([1, 2])),
            (json!({ "uniqueItems": true }), json!([1, 2]), json!([1, 1])),
            (json!({ "required": ["a"] }), json!({ "a": 1 }), json!({ "b": 1 })),
            (json!({ "dependentRequired": { "a": ["b"] } }), json!({ "b": 1 }), json!({ "a": 1 })),
            (json!({ "properties": { "a": { "type": "null" } } }), json!({ "a": null, "b": 1 }), json!({ "a": 1 })),
            (json!({ "properties": { "a": false } }), json!({ "b": 1 }), json!({ "a": 1 })),
            (
                json!({ "properties": { "a": true }, "additionalProperties": false }),
                json!({ "a": 1 }),
                json!({ "b": 1 }),
            ),
            (json!({ "additionalProperties": { "type": "null" } }), json!({ "a": null }), json!({ "a": 1 })),
            (json!({ "propertyNames": { "enum": ["a"] } }), json!({ "a": 1 }), json!({ "b": 1 })),
            (json!({ "anyOf": [{ "const": 1 }, { "minimum": 1 }] }), json!(1), json!(0)),
            (json!({ "oneOf": [{ "const": 1 }, { "minimum": 1 }] }), json!(2), json!(1)),
            (
                json!({ "if": { "required": ["a"] }, "then": { "required": ["b"] }, "else": { "required": ["c"] } }),
                json!({ "c": 1 }),
                json!({ "a": 1, "c": 1 }),
            ),
            (
                json!({ "$ref": "#/$defs/x", "$defs": { "x": { "properties": { "a": true } } }, "unevaluatedProperties": false }),
                json!({ "a": 1 }),
                json!({ "a": 1, "b": 1 }),
            ),
        ];
        for (schema, good, bad) in cases {
            let schema = Schema::of(schema);
            assert_eq!(schema.check(&good), Ok(()), "{}", schema.value());
            assert!(schema.check(&bad).is_err(), "{} takes {bad}", schema.value());
        }
    }

    #[test]
    #[should_panic(expected = "`minProperties` of JSON Schema is not known here")]
    fn a_word_that_is_not_known_stops_the_test() {
        let _ = Schema::of(json!({ "minProperties": 1 })).check(&json!({}));
    }
}
