//! Modes that nothing damps, as impacts at one contact feel them: by a frequency and a weight each, and by nothing else.

use super::linear_mode::LinearMode;
use crate::kernel::turn::Turn;

/// A mode that nothing damps, as impacts at one contact feel it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactMode {
    /// Ω; 0 of a mode that nothing holds.
    pub frequency: f64,
    /// φ² at the contact as a part of its sum over all modes, the inverse of the effective mass.
    pub weight: f64,
    /// A bound of the relative error of Ω.
    pub frequency_error: f64,
    /// The same of the weight.
    pub weight_error: f64,
}

impl ContactMode {
    /// Before weights are held against their sum. `None` of a mode that is damped, grows or has no real shape.
    fn of(mode: &LinearMode, contact: usize) -> Option<Self> {
        if !mode.is_real || mode.decay != 0.0 || mode.turn == Turn::Hyperbolic {
            return None;
        }
        let (shape, given) = (mode.rows[contact][0], mode.columns[contact][1]);
        let errors = (mode.errors.rows[contact] / shape).abs() + (mode.errors.columns[contact] / given).abs();
        let rate_error = mode.errors.poles / mode.rate;
        // A mode that nothing holds stands still by its structure.
        let (frequency, frequency_error) = if mode.is_rigid() { (0.0, 0.0) } else { (mode.rate, rate_error) };
        Some(Self { frequency, weight: shape * given * mode.rate, frequency_error, weight_error: errors + rate_error })
    }
}

/// Modes as one contact feels them; `None` unless all go on for ever.
pub(super) fn of_contact(modes: &[LinearMode], contact: usize) -> Option<Vec<ContactMode>> {
    let mut list: Vec<ContactMode> = Vec::with_capacity(modes.len());
    for mode in modes {
        list.push(ContactMode::of(mode, contact)?);
    }
    let sum: f64 = list.iter().map(|mode| mode.weight).sum();
    let error = list.iter().map(|mode| mode.weight * mode.weight_error).sum::<f64>() / sum;
    for mode in &mut list {
        mode.weight /= sum;
        mode.weight_error += error;
    }
    Some(list)
}
