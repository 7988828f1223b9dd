//! What can be wrong with a request to this layer.

use thiserror::Error;

/// A parameter outside its range.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{name} = {value} is out of range: give {requirement}")]
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
        if frequency * crate::spectrum::RESONANCE_TOLERANCE >= 0.5 * omega {
            return format!(
                "omega = {omega:e} is too small against mode {mode} (frequency {frequency:e}): its harmonics there are \
                 closer than rounding; raise omega, or lower gamma1 and gamma2"
            );
        }
        format!(
            "resonance: harmonic {harmonic} of omega = {omega} meets mode {mode} (frequency {frequency}), {distance:e} \
             away; move omega, gamma1 or gamma2 off it"
        )
    }
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
