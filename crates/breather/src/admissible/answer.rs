//! Is an orbit physical? Every impact must meet its barrier from inside, and between impacts every mass must stay
//! strictly inside the gap, for the whole period: decided by bounds, not by samples.
//!
//! The distance of a mass to a barrier is smallest at a turning point, v̇_n = 0 (impacts of the mass itself aside, where
//! it is 0 by definition). The smallest distance of all is the margin. The turning points of the mass that is hit count
//! like all others, by the nearer barrier: where it bounces lower than the middle of the gap, the margin is at most the
//! height of its bounce. How it is found is in `watch`.

use vibrochain_lattice::{Barrier, Layout};

use crate::admissible::gap::Closest;

/// What keeps a solution from being an orbit of the real chain.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "kind", rename_all = "kebab-case")
)]
pub enum Obstruction {
    /// An impact whose mass moves away from its barrier before it: the barrier would have to pull.
    WrongSign {
        /// Index of the impact.
        impact: usize,
        /// The mass.
        site: usize,
        /// Its time.
        time: f64,
        /// The velocity before it.
        velocity_before: f64,
    },
    /// A mass beyond a barrier between impacts; the place where it is farthest out.
    Crossing {
        /// The mass.
        site: usize,
        /// The barrier.
        barrier: Barrier,
        /// When, within the period.
        time: f64,
        /// By how much; 0 where it just touches.
        excess: f64,
    },
    /// A mass that does not leave its barrier after an impact that takes all its velocity: it begins to rest there.
    Sticking {
        /// Index of the impact.
        impact: usize,
        /// The mass.
        site: usize,
        /// Its time.
        time: f64,
        /// The acceleration after it, which presses the mass to its barrier.
        acceleration_after: f64,
    },
}

impl Obstruction {
    /// The mass.
    #[must_use]
    pub fn site(&self) -> usize {
        match *self {
            Self::WrongSign { site, .. } | Self::Crossing { site, .. } | Self::Sticking { site, .. } => site,
        }
    }

    /// When, within the period.
    #[must_use]
    pub fn time(&self) -> f64 {
        match *self {
            Self::WrongSign { time, .. } | Self::Crossing { time, .. } | Self::Sticking { time, .. } => time,
        }
    }

    /// In words, with its mass as words of this lattice name it.
    #[must_use]
    pub fn told(&self, layout: &Layout) -> String {
        match *self {
            Self::WrongSign { impact, site, time, velocity_before } => format!(
                "impact {impact} (site {}, t = {time}) has the wrong sign: the mass would leave its barrier at velocity {velocity_before} before being hit",
                layout.name(site)
            ),
            Self::Crossing { site, barrier, time, excess } if excess <= 0.0 => {
                format!("site {} touches the {barrier} barrier at t = {time}", layout.name(site))
            }
            Self::Crossing { site, barrier, time, excess } => {
                format!("site {} is {excess} beyond the {barrier} barrier at t = {time}", layout.name(site))
            }
            Self::Sticking { impact, site, time, acceleration_after } => format!(
                "site {} begins to rest at its barrier after impact {impact} (t = {time}): the acceleration {acceleration_after} presses it there",
                layout.name(site)
            ),
        }
    }
}

impl std::fmt::Display for Obstruction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.told(&Layout::ONE_ROW))
    }
}

/// The answer.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
pub struct Admissibility {
    /// Smallest distance left between any mass and a barrier at a turning point, the top of a bounce included; negative if
    /// a mass crosses. `None` if an impact has the wrong sign or begins a rest, which makes distances moot, and of a mass alone that flies
    /// from barrier to barrier without turning.
    pub margin: Option<f64>,
    /// What is in the way, if anything.
    pub obstruction: Option<Obstruction>,
    /// Where that smallest distance is.
    pub closest: Option<Approach>,
}

/// Where and when a mass comes closest to a barrier.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Approach {
    /// The mass.
    pub site: usize,
    /// The barrier.
    pub barrier: Barrier,
    /// When, within the period.
    pub time: f64,
}

impl Admissibility {
    /// What is in the way of impacts that cannot be.
    pub(crate) fn barred(by: Obstruction) -> Self {
        Self { margin: None, obstruction: Some(by), closest: None }
    }

    /// By the closest approach of all, along an orbit of a period.
    pub(crate) fn of(Closest { distance, site, barrier, time }: Closest, period: f64) -> Self {
        // A flight may reach beyond the period.
        let time = time.rem_euclid(period);
        let found = distance.is_finite();
        // From 0, so that a touch is 0 beyond its barrier and not −0.
        let crossing = Obstruction::Crossing { site, barrier, time, excess: 0.0 - distance };
        Self {
            margin: found.then_some(distance),
            obstruction: (distance <= 0.0).then_some(crossing),
            closest: found.then_some(Approach { site, barrier, time }),
        }
    }

    /// Nothing is in the way.
    pub fn is_physical(&self) -> bool {
        self.obstruction.is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_touch_is_called_one_and_no_number_is_minus_zero() {
        let crossing = |excess| Obstruction::Crossing { site: 3, barrier: Barrier::Upper, time: 1.5, excess };
        assert_eq!(crossing(0.0 - 0.0).to_string(), "site 3 touches the upper barrier at t = 1.5");
        assert_eq!(crossing(0.25).to_string(), "site 3 is 0.25 beyond the upper barrier at t = 1.5");
    }
}
