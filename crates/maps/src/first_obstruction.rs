//! What is in the way of a candidate that is not physical, as a map has it.

use vibrochain_breather::Obstruction;

use crate::absence::{AT_ONCE, Absence};

/// Which contact is in the way, and how soon after which impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstObstruction {
    /// Number of the contact.
    pub contact: u32,
    /// Number of the impact in the orbit's word, from 0: the one before, of whichever contact, or that at which it is.
    pub impact: u32,
    /// Since that impact, as a part of the orbit's period; 0 where it is at the impact itself.
    pub after: f64,
}

impl FirstObstruction {
    /// To be filled in.
    pub(crate) const EMPTY: Self = Self { contact: 0, impact: 0, after: 0.0 };

    /// What is in the way of an orbit, in a word and in numbers, by its period and the times of its impacts.
    #[must_use]
    pub fn of(period: f64, times: impl Iterator<Item = f64>, obstruction: &Obstruction) -> (Absence, Self) {
        let at = |site: usize, impact: usize, after: f64| Self { contact: site as u32, impact: impact as u32, after };
        match *obstruction {
            Obstruction::WrongSign { site, impact, .. } => (Absence::WrongSign, at(site, impact, 0.0)),
            Obstruction::Sticking { site, impact, .. } => (Absence::Sticks, at(site, impact, 0.0)),
            Obstruction::Crossing { site, time, .. } => {
                let since = times.map(|impact| (time - impact).rem_euclid(period));
                let (impact, since) =
                    since.enumerate().min_by(|one, other| one.1.total_cmp(&other.1)).unwrap_or((0, period));
                let after = since / period;
                let reason = if after <= AT_ONCE { Absence::CrossesAtOnce } else { Absence::Crosses };
                (reason, at(site, impact, after))
            }
        }
    }
}
