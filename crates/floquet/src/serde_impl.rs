//! Values as files have them, where a derive does not say it.

use std::fmt::Display;

use nalgebra::Complex;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::zeros::SecularError;

/// As `[re, im]`.
pub(crate) fn complex<S: Serializer>(z: &Complex<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    [z.re, z.im].serialize(serializer)
}

pub(crate) fn read_complex<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Complex<f64>, D::Error> {
    <[f64; 2]>::deserialize(deserializer).map(|[re, im]| Complex::new(re, im))
}

pub(crate) fn complexes<S: Serializer>(values: &[Complex<f64>], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(values.iter().map(|z| [z.re, z.im]))
}

/// What an error says.
pub(crate) fn message<S: Serializer>(error: &impl Display, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(error)
}

pub(crate) fn doubt<S: Serializer>(doubt: &Option<SecularError>, serializer: S) -> Result<S::Ok, S::Error> {
    doubt.map(|doubt| doubt.to_string()).serialize(serializer)
}
