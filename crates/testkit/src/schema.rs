//! JSON held against the schemas that the program prints.

use std::collections::BTreeMap;
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use boon::{Compiler, SchemaIndex, Schemas};
use serde_json::Value;

/// Where the schema stands while it is compiled, if it does not say it itself.
const PLACE: &str = "urn:vibrochain:unnamed";

/// A schema.
pub struct Schema {
    root: Value,
    compiled: Schemas,
    index: SchemaIndex,
}

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
    ///
    /// # Panics
    /// It is no schema.
    #[must_use]
    #[track_caller]
    pub fn of(root: Value) -> Self {
        let (mut compiled, mut compiler) = (Schemas::new(), Compiler::new());
        let place = root["$id"].as_str().unwrap_or(PLACE).to_owned();
        compiler.add_resource(&place, root.clone()).unwrap();
        let index = compiler.compile(&place, &mut compiled).unwrap_or_else(|error| panic!("{error:#} in {root}"));
        Self { root, compiled, index }
    }

    /// The schema itself.
    #[must_use]
    pub fn value(&self) -> &Value {
        &self.root
    }

    /// Whether a value has this form.
    ///
    /// # Errors
    /// All that is wrong, and where.
    pub fn check(&self, value: &Value) -> Result<(), String> {
        self.compiled.validate(value, self.index).map_err(|error| error.to_string())
    }
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
