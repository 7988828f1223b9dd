//! Values as `mapgen --json` tells them, where a derive does not say it.

use std::fmt::Display;

use nalgebra::Complex;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use vibrochain_breather::Orbit;

/// As `[re, im]`.
pub(crate) fn complex<S: Serializer>(z: &Complex<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    [z.re, z.im].serialize(serializer)
}

pub(crate) fn read_complex<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Complex<f64>, D::Error> {
    <[f64; 2]>::deserialize(deserializer).map(|[re, im]| Complex::new(re, im))
}

/// In words.
pub(crate) fn text<S: Serializer>(value: &impl Display, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(value)
}

pub(crate) fn texts<S: Serializer>(values: &[impl Display], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(values.iter().map(ToString::to_string))
}

pub(crate) fn side<S: Serializer>(above: &bool, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(if *above { "above" } else { "below" })
}

/// What a point of a branch tells of its orbit.
pub(crate) fn of_branch<S: Serializer>(orbit: &Orbit, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct OfBranch {
        period: f64,
        phi: Option<f64>,
        psi: Option<f64>,
        impulses: Vec<f64>,
    }
    let (period, phi, psi, impulses) = (orbit.period(), orbit.phi(), orbit.psi(), orbit.impulses());
    OfBranch { period, phi, psi, impulses }.serialize(serializer)
}

/// What a point of a curve tells of its orbit.
pub(crate) fn of_curve<S: Serializer>(orbit: &Orbit, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct OfCurve {
        impulses: Vec<f64>,
        phi: Option<f64>,
        psi: Option<f64>,
    }
    OfCurve { impulses: orbit.impulses(), phi: orbit.phi(), psi: orbit.psi() }.serialize(serializer)
}
