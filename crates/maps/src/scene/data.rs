//! One deserialiser for all scenes: TOML has the place of each value, JSON, as manifests are, the key of what is wrong instead.

use std::fmt;
use std::ops::Range;

use serde::de::value::{MapDeserializer, SeqDeserializer};
use serde::de::{Deserialize, Deserializer, Error, IntoDeserializer, Visitor};
use serde::forward_to_deserialize_any;
use serde_json::{Map, Value};
use serde_spanned::de::{SpannedDeserializer, is_spanned};
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use crate::error::MapError;
use crate::numbers::plain;
use crate::scene::source::{SHOWN, Source};
use crate::text::clipped;

/// TOML with the places of its values.
pub(crate) type Places<'a> = Spanned<DeValue<'a>>;

/// A value to be read, or a key. We match on its kind ourselves: by the readers of `toml` and `serde_json` every table would be compiled
/// three times.
#[derive(Clone)]
struct Data<'de> {
    key: &'de str,
    /// Of a key itself, none.
    value: Option<&'de Value>,
    /// Of JSON, none.
    toml: Option<&'de Places<'de>>,
    /// JSON has no places: those that are asked for are all 0.
    place: Range<usize>,
}

/// What is wrong, and the place of the innermost value that is.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Wrong(String, Option<Range<usize>>);

impl Error for Wrong {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self(plain(&message.to_string()), None)
    }
}

impl<'a> Source<'a> {
    /// Its text, TOML, as data and with places.
    pub(crate) fn parsed(&self) -> Result<(Value, Places<'a>), MapError> {
        let unreadable = |error: toml::de::Error| self.unreadable(&error);
        let table = DeTable::parse(self.text).map_err(unreadable)?;
        let places = Spanned::new(table.span(), DeValue::Table(table.into_inner()));
        Ok((Value::deserialize(ValueDeserializer::from(places.clone())).map_err(unreadable)?, places))
    }

    /// The tables of a scene, or an error that points at what is wrong.
    pub(crate) fn tables<'de, T: Deserialize<'de>>(
        &self,
        scene: &'de Value,
        toml: Option<&'de Places<'de>>,
    ) -> Result<T, MapError> {
        let read = T::deserialize(Data::new("scene", scene, toml));
        read.map_err(|Wrong(message, place)| self.error(place.unwrap_or(0..0), message))
    }
}

impl<'de> Data<'de> {
    fn new(key: &'de str, value: &'de Value, toml: Option<&'de Places<'de>>) -> Self {
        Self { key, value: Some(value), toml, place: toml.map_or(0..0, Spanned::span) }
    }

    /// Outside of what is generic, so that it is compiled once.
    fn items(&self, items: &'de [Value]) -> SeqDeserializer<impl Iterator<Item = Self>, Wrong> {
        let toml = |at: usize| self.toml.and_then(|toml| toml.get_ref().get(at));
        SeqDeserializer::new(items.iter().enumerate().map(move |(at, value)| Self::new(self.key, value, toml(at))))
    }

    fn entries(
        &self,
        entries: &'de Map<String, Value>,
    ) -> MapDeserializer<'de, impl Iterator<Item = (Self, Self)>, Wrong> {
        // What is null in a manifest is absent in a scene.
        let entries = entries.iter().filter(|(_, value)| self.toml.is_some() || !value.is_null());
        MapDeserializer::new(entries.map(|(key, value)| {
            let given = self.toml.and_then(|toml| toml.get_ref().as_table()?.get_key_value(key.as_str()));
            // The reader of TOML gives a date as a table with one key, which stands nowhere in the text.
            let place = given.map_or_else(|| self.place.clone(), |(key, _)| key.span());
            (Self { key, value: None, toml: None, place }, Self::new(key, value, given.map(|(_, value)| value)))
        }))
    }

    fn visit<V: Visitor<'de>>(&self, visitor: V) -> Result<V::Value, Wrong> {
        match self.value {
            None => visitor.visit_borrowed_str(self.key),
            Some(Value::Array(items)) => {
                let mut items = self.items(items);
                let read = visitor.visit_seq(&mut items)?;
                items.end().map(|()| read)
            }
            Some(Value::Object(entries)) => visitor.visit_map(self.entries(entries)),
            Some(Value::String(text)) => visitor.visit_borrowed_str(text),
            Some(Value::Bool(flag)) => visitor.visit_bool(*flag),
            Some(Value::Number(number)) => number.deserialize_any(visitor).map_err(Wrong::custom),
            // JSON has neither infinities nor NaN.
            Some(Value::Null) => match self.toml.and_then(|toml| toml.get_ref().as_float()?.as_str().parse().ok()) {
                Some(number) => visitor.visit_f64(number),
                None => visitor.visit_unit(),
            },
        }
    }

    /// An error at this value unless it is at one within; in JSON with the key and what stands there: `asymmetry = "x" is not a number`.
    fn placed(&self, Wrong(message, place): Wrong) -> Wrong {
        let what = message.rfind(" is not ").filter(|_| place.is_none() && self.toml.is_none());
        let told = self.value.zip(what).map(|(value, at)| {
            let (value, what) = (value.to_string(), &message[at..]);
            let such = if what == " is not a number" { ": give one such as 0.2 or 1e-3" } else { "" };
            format!("{} = {}{what}{such}", self.key, clipped(&value, SHOWN))
        });
        Wrong(told.unwrap_or(message), place.or_else(|| Some(self.place.clone())))
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
        self.visit(visitor).map_err(|wrong| self.placed(wrong))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Wrong> {
        visitor.visit_newtype_struct(self.clone()).map_err(|wrong| self.placed(wrong))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        match (is_spanned(name), self.place.clone()) {
            (true, place) => visitor.visit_map(SpannedDeserializer::new(self, place)),
            (false, _) => self.deserialize_any(visitor),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map enum identifier ignored_any
    }
}
