//! Validated values as files have them. What is read goes through the same checks as what comes from code.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::{ParameterError, check};
use crate::model::force::{Force, Harmonic};
use crate::model::params::{Chain, Model};
use crate::modes::row::Ends;

/// A lattice; what a ring does not have is not written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlainChain {
    sites: usize,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ends: Option<Ends>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    layers: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    layer_ends: Option<Ends>,
    gamma1: f64,
    gamma2: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    gamma3: Option<f64>,
}

impl From<Chain> for PlainChain {
    fn from(chain: Chain) -> Self {
        let layered = chain.layers() > 1;
        Self {
            sites: chain.length(),
            ends: (chain.ends() != Ends::Closed).then_some(chain.ends()),
            layers: layered.then_some(chain.layers()),
            layer_ends: layered.then_some(chain.layer_ends()),
            gamma1: chain.gamma1(),
            gamma2: chain.gamma2(),
            gamma3: layered.then_some(chain.gamma3()),
        }
    }
}

impl PlainChain {
    fn checked(self) -> Result<Chain, ParameterError> {
        let (layers, gamma3) = (self.layers.unwrap_or(1), self.gamma3.unwrap_or(0.0));
        Chain::new(self.sites, self.gamma1, self.gamma2)?.with_ends(self.ends.unwrap_or_default()).with_layers(
            layers,
            gamma3,
            self.layer_ends.unwrap_or(Ends::Free),
        )
    }
}

impl Serialize for Chain {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        PlainChain::from(*self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Chain {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        PlainChain::deserialize(deserializer)?.checked().map_err(D::Error::custom)
    }
}

/// The parameters in `mapgen orbit --json`; the table `[model]` of a scene.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlainModel {
    sites: usize,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ends: Option<Ends>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    layers: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    layer_ends: Option<Ends>,
    gamma1: f64,
    gamma2: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    gamma3: Option<f64>,
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
        let amplitude = self.force().cosine_amplitude();
        let PlainChain { sites, ends, layers, layer_ends, gamma1, gamma2, gamma3 } = (*self.chain()).into();
        PlainModel {
            sites,
            ends,
            layers,
            layer_ends,
            gamma1,
            gamma2,
            gamma3,
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
        let plain = PlainModel::deserialize(deserializer)?;
        let PlainModel { sites, ends, layers, layer_ends, gamma1, gamma2, gamma3, .. } = plain;
        let PlainModel { omega, asymmetry, amplitude, force, restitution, .. } = plain;
        let chain = PlainChain { sites, ends, layers, layer_ends, gamma1, gamma2, gamma3 };
        let (both, given) = (amplitude.is_some() && force.is_some(), amplitude.unwrap_or(0.0));
        let either = "either an amplitude or a force, which has amplitudes of its own";
        check(!both, "amplitude", given, either)
            .and_then(|()| chain.checked())
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
