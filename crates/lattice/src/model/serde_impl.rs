//! Validated values as files have them. What is read goes through the same checks as what comes from code.

use std::collections::BTreeMap;

use serde::de::Error;
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::check;
use crate::model::chain::{Chain, Layout};
use crate::model::force::{Force, Harmonic};
use crate::model::parameter::{Parameter, Part};
use crate::model::params::Model;
use crate::model::point::Point;
use crate::modes::row::Ends;

/// Parts of a point, as files have them: what a ring does not have is not written, nor parameters that are not among these.
///
/// Of a scene that is all but what it sweeps; of an answer, the whole model.
#[derive(Debug)]
pub struct PointPart<'a> {
    /// The point.
    pub point: &'a Point,
    /// The parameters that are written, in this order: before its ends and layers, and behind them.
    pub parameters: [Vec<Parameter>; 2],
}

impl<'a> PointPart<'a> {
    /// The parameters of some parts.
    fn of(point: &'a Point, [before, behind]: [&[Part]; 2]) -> Self {
        let of = |parts: &[Part]| {
            parts.iter().flat_map(|part| Parameter::ALL.into_iter().filter(|one| one.row().part == *part)).collect()
        };
        Self { point, parameters: [of(before), of(behind)] }
    }

    fn write<M: SerializeMap>(&self, map: &mut M, parameters: &[Parameter]) -> Result<(), M::Error> {
        for &parameter in parameters {
            match &self.point.force {
                Some(force) if parameter == Parameter::Amplitude => map.serialize_entry("force", force)?,
                _ if self.point.tells(parameter) => {
                    map.serialize_entry(parameter.name(), &self.point.get(parameter))?
                }
                _ => {}
            }
        }
        Ok(())
    }
}

impl Serialize for PointPart<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (Layout { length, ends, layers, layer_ends }, [before, behind]) = (self.point.layout, &self.parameters);
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("sites", &length)?;
        self.write(&mut map, before)?;
        if ends != Ends::Closed {
            map.serialize_entry("ends", &ends)?;
        }
        if layers > 1 {
            map.serialize_entry("layers", &layers)?;
            map.serialize_entry("layer_ends", &layer_ends)?;
        }
        self.write(&mut map, behind)?;
        map.end()
    }
}

/// A model, or a lattice alone, as it is read. Keys that are none of these are parameters, or unknown.
#[derive(Deserialize)]
struct Told {
    sites: usize,
    #[serde(default)]
    ends: Ends,
    layers: Option<usize>,
    layer_ends: Option<Ends>,
    /// Instead of an amplitude.
    force: Option<Force>,
    #[serde(flatten)]
    values: BTreeMap<Parameter, f64>,
}

impl Told {
    /// The point that it tells, of whose parameters these must be there unless they have a default.
    fn point<E: Error>(self, parameters: impl Iterator<Item = Parameter>) -> Result<Point, E> {
        let (layers, layer_ends) = (self.layers.unwrap_or(1), self.layer_ends.unwrap_or(Ends::Free));
        let mut point = Point::of(Layout { length: self.sites, ends: self.ends, layers, layer_ends });
        for parameter in parameters {
            let value = self.values.get(&parameter).copied().or(parameter.row().default);
            point.set(parameter, value.ok_or_else(|| E::missing_field(parameter.name()))?);
        }
        let both = self.force.and(self.values.get(&Parameter::Amplitude));
        let either = "either an amplitude or a force, which has amplitudes of its own";
        check(both.is_none(), "amplitude", point.get(Parameter::Amplitude), either).map_err(E::custom)?;
        Ok(self.force.map_or(point, |force| point.under(&force)))
    }
}

impl Serialize for Chain {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        PointPart::of(&self.point(), [&[Part::Lattice], &[Part::Layers]]).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Chain {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let told = Told::deserialize(deserializer)?;
        let other = told.values.keys().find(|parameter| !parameter.is_of_lattice()).map(|parameter| parameter.name());
        if let Some(other) = other.or(told.force.map(|_| "force")) {
            return Err(D::Error::custom(format!("a lattice has no {other}")));
        }
        let point = told.point::<D::Error>(Parameter::told().filter(|parameter| parameter.is_of_lattice()))?;
        point.chain().map_err(D::Error::custom)
    }
}

impl Serialize for Model {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let parts: [&[Part]; 2] = [&[Part::Lattice, Part::Motion], &[Part::Layers, Part::Driving, Part::Dashpots]];
        PointPart::of(&self.point(), parts).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Model {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let point = Told::deserialize(deserializer)?.point::<D::Error>(Parameter::told())?;
        point.model().map_err(D::Error::custom)
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
