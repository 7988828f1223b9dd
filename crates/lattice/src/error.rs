//! What can be wrong with a request to this layer.

use std::fmt;

use thiserror::Error;

/// Relative distance |Ω_k − jω|/Ω_k below which a harmonic counts as meeting a mode: 16 units in the last
/// place, the rounding of Ω_k, ω and their quotient together. Farther away an answer exists, with as many digits
/// lost as the distance is small.
pub const RESONANCE_TOLERANCE: f64 = 16.0 * f64::EPSILON;

/// A number as messages show it: in the fewest digits that read back the same, with an exponent where it would be a row of
/// zeros.
///
/// ```
/// use vibrochain_lattice::Short;
/// assert_eq!(format!("{} {} {} {}", Short(-0.4), Short(3.0), Short(1e300), Short(2e-9)), "-0.4 3 1e300 2e-9");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Short(pub f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = format!("{:?}", self.0);
        // A whole number comes with a fraction of zero.
        f.write_str(text.strip_suffix(".0").unwrap_or(&text))
    }
}

/// A parameter outside its range.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{name} = {} is out of range: give {requirement}", Short(*value))]
pub struct ParameterError {
    /// The parameter's name, as in the command line and the scene files.
    pub name: &'static str,
    /// The value as given.
    pub value: f64,
    /// What the value must be.
    pub requirement: &'static str,
}

/// A harmonic jω of a periodic motion meets a mode's frequency Ω_k: no periodic response exists.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[error("{}", self.describe())]
pub struct Resonance {
    /// The number j of the harmonic.
    pub harmonic: u64,
    /// The number k of the mode.
    pub mode: usize,
    /// The mode's frequency Ω_k.
    pub frequency: f64,
    /// The base frequency whose harmonic it is.
    pub omega: f64,
    /// Ω_k − jω, as far as it can be resolved.
    pub distance: f64,
}

impl Resonance {
    fn describe(&self) -> String {
        let Self { harmonic, mode, frequency, omega, distance } = self;
        if frequency * RESONANCE_TOLERANCE >= 0.5 * omega {
            return format!(
                "omega = {omega:e} is too small against mode {mode} (frequency {frequency:e}): its harmonics there are \
                 closer than rounding; raise omega, or lower gamma1 and gamma2"
            );
        }
        format!(
            "resonance: harmonic {harmonic} of omega = {} meets mode {mode} (frequency {}), {distance:e} away; move omega \
             or a stiffness off it",
            Short(*omega),
            Short(*frequency)
        )
    }
}

/// The largest stiffness and frequency, and (inverted) the smallest frequency: their squares and products
/// must stay within the range of `f64`.
pub const MAX_MAGNITUDE: f64 = 1e100;

pub(crate) fn check(ok: bool, name: &'static str, value: f64, requirement: &'static str) -> Result<(), ParameterError> {
    if ok { Ok(()) } else { Err(ParameterError { name, value, requirement }) }
}

/// Any failure of this crate.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LatticeError {
    /// A parameter is outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A harmonic meets a mode.
    #[error(transparent)]
    Resonance(#[from] Resonance),
}
