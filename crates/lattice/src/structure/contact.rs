//! A contact: a coordinate, or a combination of some, between two barriers.

use super::error::StructureError;
use crate::error::MAX_MAGNITUDE;
use crate::model::chain::Barrier;

/// Where a contact's g = wᵀq is stopped, in units of the coordinates, and its coefficient of restitution. One without barriers is free.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Contact {
    /// The lower barrier; `None`: there is none.
    pub lower: Option<f64>,
    /// The upper barrier; `None`: there is none.
    pub upper: Option<f64>,
    /// e of g′⁺ = −e g′⁻, from 0 (it stays) to 1 (nothing is lost).
    pub restitution: f64,
}

impl Contact {
    /// The place of a barrier.
    pub fn barrier(&self, barrier: Barrier) -> Option<f64> {
        match barrier {
            Barrier::Lower => self.lower,
            Barrier::Upper => self.upper,
        }
    }

    /// How far a place is inside both barriers; below 0 it is beyond one.
    pub fn room(&self, place: f64) -> f64 {
        let above = self.lower.map_or(f64::INFINITY, |lower| place - lower);
        above.min(self.upper.map_or(f64::INFINITY, |upper| upper - place))
    }

    /// The larger distance between a place and a barrier that is there: the scale of errors.
    pub fn reach(&self) -> f64 {
        self.lower.map_or(0.0, f64::abs).max(self.upper.map_or(0.0, f64::abs))
    }

    pub(super) fn check(&self, contact: usize) -> Result<(), StructureError> {
        let range = |what: &str, value: f64, requirement| StructureError::Range {
            what: format!("{what} of contact {contact}"),
            value,
            requirement,
        };
        for (what, value) in [("lower", self.lower), ("upper", self.upper)] {
            if let Some(value) = value.filter(|value| value.is_nan() || value.abs() > MAX_MAGNITUDE) {
                return Err(range(what, value, "a number between -1e100 and 1e100"));
            }
        }
        if !(0.0..=1.0).contains(&self.restitution) {
            return Err(range("restitution", self.restitution, "a number from 0 to 1"));
        }
        match (self.lower, self.upper) {
            (Some(lower), Some(upper)) if lower >= upper => Err(StructureError::Barriers { contact, lower, upper }),
            _ => Ok(()),
        }
    }
}
