//! Scenes that are data already: the scene in a JSON file is read as it is, with the key of what is wrong where a text has its line.

use std::fmt;

use serde::de::value::{MapDeserializer, SeqDeserializer};
use serde::de::{Deserializer, Error, IntoDeserializer, Visitor};
use serde::forward_to_deserialize_any;
use serde_json::Value;
use serde_spanned::de::{SpannedDeserializer, is_spanned};

use crate::numbers::plain;

/// A value to be read, with its key. It has no places: those that are asked for are all 0.
#[derive(Clone, Copy)]
pub(super) struct Data<'de> {
    key: &'de str,
    value: &'de Value,
}

/// What is wrong with a value; and whether its key is told.
#[derive(Debug)]
pub(super) struct Wrong(String, bool);

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Wrong {}

impl Error for Wrong {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self(plain(&message.to_string()), false)
    }
}

impl<'de> Data<'de> {
    pub(super) fn new(value: &'de Value) -> Self {
        Self { key: "scene", value }
    }

    /// What is wrong, with the key and what stands there: `asymmetry = "x" is not a number`.
    fn told(self, wrong: Wrong) -> Wrong {
        let what = wrong.0.rfind(" is not ").filter(|_| !wrong.1).map(|at| &wrong.0[at..]);
        let such = if what == Some(" is not a number") { ": give one such as 0.2 or 1e-3" } else { "" };
        Wrong(what.map_or(wrong.0.clone(), |what| format!("{} = {}{what}{such}", self.key, self.value)), true)
    }
}

impl<'de> IntoDeserializer<'de, Wrong> for Data<'de> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for Data<'de> {
    type Error = Wrong;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        let read = match self.value {
            Value::Array(items) => {
                visitor.visit_seq(SeqDeserializer::new(items.iter().map(|value| Data { value, ..self })))
            }
            Value::Object(entries) => {
                // What is null in a manifest is absent in a scene.
                let entries = entries.iter().filter(|(_, value)| !value.is_null());
                visitor.visit_map(MapDeserializer::new(entries.map(|(key, value)| (key.as_str(), Data { key, value }))))
            }
            plain => plain.deserialize_any(visitor).map_err(Wrong::custom),
        };
        read.map_err(|wrong| self.told(wrong))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        visitor.visit_some(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        match is_spanned(name) {
            true => visitor.visit_map(SpannedDeserializer::new(self, 0..0)),
            false => self.deserialize_any(visitor),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct newtype_struct seq tuple
        tuple_struct map enum identifier ignored_any
    }
}
