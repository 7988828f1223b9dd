//! What is in the way of a candidate that is not physical, as a map has it.

use vibrochain_breather::{Obstruction, StructureOrbit};

use crate::absence::{AT_ONCE, Absence};

/// Which contact is in the way, and how soon after an impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstObstruction {
    /// Number of the contact.
    pub contact: usize,
    /// Since the impact before, of whichever contact, as a part of the orbit's period; 0 where it is at the impact itself.
    pub after: f64,
}

impl FirstObstruction {
    /// What is in the way of an orbit, in a word and in numbers.
    #[must_use]
    pub fn of(orbit: &StructureOrbit, obstruction: &Obstruction) -> (Absence, Self) {
        match *obstruction {
            Obstruction::WrongSign { site, .. } => (Absence::WrongSign, Self { contact: site, after: 0.0 }),
            Obstruction::Sticking { site, .. } => (Absence::Sticks, Self { contact: site, after: 0.0 }),
            Obstruction::Crossing { site, time, .. } => {
                let since = orbit.impacts().iter().map(|impact| (time - impact.time).rem_euclid(orbit.period()));
                let after = since.fold(orbit.period(), f64::min) / orbit.period();
                let reason = if after <= AT_ONCE { Absence::CrossesAtOnce } else { Absence::Crosses };
                (reason, Self { contact: site, after })
            }
        }
    }
}
