//! Orbits without force and losses that are their own mirror images in time, with impacts at one contact: at one instant, or at two that are half
//! a period apart.

use vibrochain_lattice::ContactMode;

use super::orbit::ContactOrbit;

/// Instants are half a period apart where they miss it by no more than this part of the period: rounding, unless the orbit is next to others of
/// its word that are no mirror images of themselves.
const HALF: f64 = 1e-10;

/// All that the multipliers of such an orbit depend on, but for those of modes that the contact does not feel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReversibleOrbit<'a> {
    /// The modes that the contact feels.
    pub modes: &'a [ContactMode],
    /// The orbit's period.
    pub period: f64,
    /// Of two instants the impulse at the second one over that at the first, and a bound of its relative error.
    pub ratio: Option<(f64, f64)>,
}

impl ContactOrbit {
    /// What the multipliers of an orbit depend on that is its own mirror image in time and has all impacts at one contact; `None` of others,
    /// and where the impulses have no bound of their errors.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use vibrochain_breather::LoadedStructure;
    /// use vibrochain_lattice::{Contact, LinearMode, ModalStructure, ModeShape};
    /// let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
    /// let mode = LinearMode::oscillator(0.0, 1.0, &shape, &[]);
    /// let stop = Contact { lower: Some(-1.0), upper: Some(0.7), restitution: 1.0 };
    /// let structure = Arc::new(ModalStructure::new(vec![stop], vec![], vec![mode])?);
    /// let found = LoadedStructure::new(structure, 1.5)?.orbits(&"0+,0-".parse()?, 1)?;
    /// let (ratio, error) = found.orbits[0].contacts().unwrap().reversible().unwrap().ratio.unwrap();
    /// assert!(ratio < 0.0 && error < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn reversible(&self) -> Option<ReversibleOrbit<'_>> {
        let modes = self.response().kernel.felt.of_one.as_deref().filter(|_| self.is_reversible())?;
        let ratio = match self.impacts() {
            [first, second] => {
                let [one, two] = [first.impulse, second.impulse];
                let moved = self.error_origins().iter().map(|origin| origin[1].impulse / two - origin[0].impulse / one);
                let error = moved.map(f64::abs).sum::<f64>() + 4.0 * f64::EPSILON;
                let ratio = two / one;
                if ratio == 0.0 || !(ratio * error).is_finite() {
                    return None;
                }
                Some((ratio, error))
            }
            _ => None,
        };
        Some(ReversibleOrbit { modes, period: self.period(), ratio })
    }

    /// Whether it is its own mirror image in time and has all impacts at one contact.
    pub(super) fn is_reversible(&self) -> bool {
        let period = self.period();
        let are_halves = match self.impacts() {
            [_] => true,
            [_, second] => {
                let off = (second.time - 0.5 * period).abs();
                off <= 4.0 * f64::EPSILON * period || off <= self.impact_errors()[1].time && off <= HALF * period
            }
            _ => false,
        };
        are_halves && self.response().kernel.felt.of_one.is_some() && self.is_conservative()
    }
}
