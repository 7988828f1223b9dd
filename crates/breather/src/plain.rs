//! Values as files have them, where a derive does not say it.

use serde::{Serialize, Serializer};
use smallvec::{Array, SmallVec};
use vibrochain_lattice::Model;

use crate::orbit::{Family, Impact, Orbit};

/// What `mapgen orbit --json` tells of a solution, with the parameters. It is written only: an orbit that is read is made from its
/// parameters and impacts, see [`Orbit::from_impulses`].
#[derive(Serialize)]
struct PlainOrbit<'a> {
    parameters: &'a Model,
    family: Family,
    force_periods: u32,
    period: f64,
    phi: Option<f64>,
    psi: Option<f64>,
    impacts: &'a [Impact],
    residual: f64,
}

impl Serialize for Orbit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        PlainOrbit {
            parameters: self.model(),
            family: self.family(),
            force_periods: self.force_periods(),
            period: self.period(),
            phi: self.phi(),
            psi: self.psi(),
            impacts: self.impacts(),
            residual: self.residual(),
        }
        .serialize(serializer)
    }
}

pub(crate) fn list<A, S>(list: &SmallVec<A>, serializer: S) -> Result<S::Ok, S::Error>
where
    A: Array<Item: Serialize>,
    S: Serializer,
{
    serializer.collect_seq(list)
}

pub(crate) fn lists<A, S>(lists: &[SmallVec<A>], serializer: S) -> Result<S::Ok, S::Error>
where
    A: Array<Item: Serialize>,
    S: Serializer,
{
    serializer.collect_seq(lists.iter().map(SmallVec::as_slice))
}
