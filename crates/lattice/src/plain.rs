//! Validated values as files have them. What is read goes through the same checks as what comes from code.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::check;
use crate::force::{Force, Harmonic};
use crate::params::{Chain, Model};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlainChain {
    sites: usize,
    gamma1: f64,
    gamma2: f64,
}

impl<'de> Deserialize<'de> for Chain {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let PlainChain { sites, gamma1, gamma2 } = PlainChain::deserialize(deserializer)?;
        Self::new(sites, gamma1, gamma2).map_err(D::Error::custom)
    }
}

/// The parameters in `mapgen orbit --json`; the table `[model]` of a scene.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlainModel {
    sites: usize,
    gamma1: f64,
    gamma2: f64,
    omega: f64,
    asymmetry: f64,
    /// Of a plain cosine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    amplitude: Option<f64>,
    /// Any other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    force: Option<Force>,
    #[serde(default = "elastic")]
    restitution: f64,
}

fn elastic() -> f64 {
    1.0
}

impl Serialize for Model {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (chain, amplitude) = (self.chain(), self.force().cosine_amplitude());
        PlainModel {
            sites: chain.sites(),
            gamma1: chain.gamma1(),
            gamma2: chain.gamma2(),
            omega: self.omega(),
            asymmetry: self.asymmetry(),
            amplitude,
            force: amplitude.is_none().then_some(*self.force()),
            restitution: self.restitution(),
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Model {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let PlainModel { sites, gamma1, gamma2, omega, asymmetry, amplitude, force, restitution } =
            PlainModel::deserialize(deserializer)?;
        let (both, given) = (amplitude.is_some() && force.is_some(), amplitude.unwrap_or(0.0));
        let either = "either an amplitude or a force, which has amplitudes of its own";
        check(!both, "amplitude", given, either)
            .and_then(|()| Chain::new(sites, gamma1, gamma2))
            .and_then(|chain| match force {
                None => Self::forced(chain, omega, asymmetry, given, restitution),
                Some(force) => Self::with_force(chain, omega, asymmetry, &force, restitution),
            })
            .map_err(D::Error::custom)
    }
}

impl Serialize for Force {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.harmonics().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Force {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::new(&Vec::<Harmonic>::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}
