//! Points of the parameter space.

pub use vibrochain_lattice::Parameter;
use vibrochain_lattice::{Chain, Force, Layout, Model, ParameterError};

/// A point of the parameter space, not yet checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Where the masses stand.
    pub layout: Layout,
    /// Values in the order of [`Parameter::ALL`].
    pub values: [f64; Parameter::ALL.len()],
    /// A force that is not the plain cosine of the amplitude among the values, which is then Σ|A_j|.
    pub force: Option<Force>,
}

impl Point {
    /// The point of a layout with all values 0 and no force.
    pub fn of(layout: Layout) -> Self {
        Self { layout, values: [0.0; Parameter::ALL.len()], force: None }
    }

    /// Number of masses.
    pub fn sites(&self) -> usize {
        self.layout.length.saturating_mul(self.layout.layers)
    }

    /// Value of a parameter.
    pub fn get(&self, parameter: Parameter) -> f64 {
        self.values[parameter as usize]
    }

    /// The same point with one value changed.
    pub fn with(mut self, parameter: Parameter, value: f64) -> Self {
        self.set(parameter, value);
        self
    }

    /// Changes one value.
    pub fn set(&mut self, parameter: Parameter, value: f64) {
        self.values[parameter as usize] = value;
    }

    /// The same point under `force`.
    pub fn under(self, force: &Force) -> Self {
        let plain = force.cosine_amplitude().is_some();
        Self { force: (!plain).then_some(*force), ..self.with(Parameter::Amplitude, force.amplitude()) }
    }

    /// The model at this point.
    ///
    /// # Errors
    /// [`ParameterError`] for a value out of range.
    pub fn model(&self) -> Result<Model, ParameterError> {
        let [gamma1, gamma2, omega, asymmetry, amplitude, restitution, gamma3] = self.values;
        let chain = Chain::on(self.layout, gamma1, gamma2, gamma3)?;
        match &self.force {
            None => Model::forced(chain, omega, asymmetry, amplitude, restitution),
            Some(force) => Model::with_force(chain, omega, asymmetry, force, restitution),
        }
    }
}
