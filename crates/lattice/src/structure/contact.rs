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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contact_knows_its_barriers_and_how_far_a_place_is_inside() {
        let both = Contact { lower: Some(-1.5), upper: Some(0.5), restitution: 0.8 };
        assert_eq!([Barrier::Lower, Barrier::Upper].map(|barrier| both.barrier(barrier)), [Some(-1.5), Some(0.5)]);
        assert_eq!([-2.0, -1.0, 0.0, 0.25, 0.75].map(|place| both.room(place)), [-0.5, 0.5, 0.5, 0.25, -0.25]);
        let (floor, ceiling) = (Contact { upper: None, ..both }, Contact { lower: None, ..both });
        assert_eq!([floor.room(3.0), ceiling.room(-3.0)], [4.5, 3.5]);
        assert_eq!([both.reach(), floor.reach(), ceiling.reach()], [1.5, 1.5, 0.5]);
        assert_eq!([floor.barrier(Barrier::Upper), ceiling.barrier(Barrier::Lower)], [None, None]);
        let free = Contact { lower: None, ..floor };
        assert!(free.room(1e9) == f64::INFINITY && free.reach() == 0.0);
    }

    #[test]
    fn what_cannot_be_a_contact_is_refused_by_its_number() {
        let both = Contact { lower: Some(-1.5), upper: Some(0.5), restitution: 0.8 };
        let free = Contact { lower: None, upper: None, restitution: 0.0 };
        let widest = Contact { lower: Some(-MAX_MAGNITUDE), upper: Some(MAX_MAGNITUDE), restitution: 1.0 };
        assert!([both, free, widest].iter().all(|contact| contact.check(3).is_ok()));
        let far = 2.0 * MAX_MAGNITUDE;
        let wrong = [
            (Contact { lower: Some(f64::NAN), ..both }, "lower of contact 3"),
            (Contact { lower: Some(-far), ..both }, "lower of contact 3"),
            (Contact { upper: Some(far), ..both }, "upper of contact 3"),
            (Contact { restitution: -0.1, ..both }, "restitution of contact 3"),
            (Contact { restitution: 1.1, ..both }, "restitution of contact 3"),
            (Contact { restitution: f64::NAN, ..both }, "restitution of contact 3"),
        ];
        for (contact, expected) in wrong {
            assert!(
                matches!(contact.check(3), Err(StructureError::Range { what, .. }) if what == expected),
                "{contact:?}"
            );
        }
        for upper in [-1.5, -2.0] {
            let crossed = Contact { upper: Some(upper), ..both };
            assert_eq!(crossed.check(3), Err(StructureError::Barriers { contact: 3, lower: -1.5, upper }));
        }
    }
}
