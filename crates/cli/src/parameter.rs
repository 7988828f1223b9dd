//! Points of the parameter space.

pub use vibrochain_lattice::Parameter;
use vibrochain_lattice::{Chain, Model, ParameterError};

/// A point of the parameter space, not yet checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Number of masses.
    pub sites: usize,
    /// Values in the order of [`Parameter::ALL`].
    pub values: [f64; 6],
}

impl Point {
    /// Value of a parameter.
    pub fn get(&self, parameter: Parameter) -> f64 {
        self.values[parameter as usize]
    }

    /// The same point with one value changed.
    pub fn with(mut self, parameter: Parameter, value: f64) -> Self {
        self.values[parameter as usize] = value;
        self
    }

    /// The model at this point.
    ///
    /// # Errors
    /// [`ParameterError`] for a value out of range.
    pub fn model(&self) -> Result<Model, ParameterError> {
        let [gamma1, gamma2, omega, asymmetry, amplitude, restitution] = self.values;
        Model::forced(Chain::new(self.sites, gamma1, gamma2)?, omega, asymmetry, amplitude, restitution)
    }
}
