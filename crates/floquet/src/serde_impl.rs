//! Values as `mapgen --json` tells them, where a derive does not say it.

use std::fmt::Display;

use nalgebra::Complex;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use vibrochain_breather::{Orbit, StructureOrbit};

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

/// An orbit of which points of branches and curves tell.
pub trait Followed {
    /// 2π/ω, of as many periods of the force as it lasts.
    fn period(&self) -> f64;
    /// The time of the second of two impacts.
    fn phi(&self) -> Option<f64>;
    /// The phase of the force, as a time.
    fn psi(&self) -> Option<f64>;
    /// In the order of its impacts.
    fn impulses(&self) -> Vec<f64>;
}

impl Followed for Orbit {
    fn period(&self) -> f64 {
        self.period()
    }

    fn phi(&self) -> Option<f64> {
        self.phi()
    }

    fn psi(&self) -> Option<f64> {
        self.psi()
    }

    fn impulses(&self) -> Vec<f64> {
        self.impulses()
    }
}

impl Followed for StructureOrbit {
    fn period(&self) -> f64 {
        self.period()
    }

    fn phi(&self) -> Option<f64> {
        self.phi()
    }

    fn psi(&self) -> Option<f64> {
        self.psi()
    }

    fn impulses(&self) -> Vec<f64> {
        self.impulses()
    }
}

/// What a point of a branch tells of its orbit.
pub(crate) fn of_branch<S: Serializer>(orbit: &impl Followed, serializer: S) -> Result<S::Ok, S::Error> {
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
pub(crate) fn of_curve<S: Serializer>(orbit: &impl Followed, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct OfCurve {
        impulses: Vec<f64>,
        phi: Option<f64>,
        psi: Option<f64>,
    }
    OfCurve { impulses: orbit.impulses(), phi: orbit.phi(), psi: orbit.psi() }.serialize(serializer)
}
