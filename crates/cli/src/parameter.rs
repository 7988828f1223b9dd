//! The parameters of the model by name, and points of the parameter space.

use vibrochain_lattice::{Chain, Force, Model, ParameterError};

/// A real parameter of the model, which a sweep can vary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Parameter {
    /// γ₁
    Gamma1,
    /// γ₂
    Gamma2,
    /// ω
    Omega,
    /// a
    Asymmetry,
    /// A
    Amplitude,
    /// e
    Restitution,
}

impl Parameter {
    /// All of them, in the order of tables.
    pub const ALL: [Self; 6] =
        [Self::Gamma1, Self::Gamma2, Self::Omega, Self::Asymmetry, Self::Amplitude, Self::Restitution];

    /// The name in scenes, flags and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gamma1 => "gamma1",
            Self::Gamma2 => "gamma2",
            Self::Omega => "omega",
            Self::Asymmetry => "asymmetry",
            Self::Amplitude => "amplitude",
            Self::Restitution => "restitution",
        }
    }

    /// The letter on pictures.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Gamma1 => "γ₁",
            Self::Gamma2 => "γ₂",
            Self::Omega => "ω",
            Self::Asymmetry => "a",
            Self::Amplitude => "A",
            Self::Restitution => "e",
        }
    }

    /// What it is, on the axes of pictures.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Gamma1 => "on-site stiffness",
            Self::Gamma2 => "coupling stiffness",
            Self::Omega => "frequency",
            Self::Asymmetry => "asymmetry",
            Self::Amplitude => "force amplitude",
            Self::Restitution => "restitution",
        }
    }

    /// The parameter of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|parameter| parameter.name() == name)
    }
}

/// A point of the parameter space, not yet checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Number of masses.
    pub sites: usize,
    /// Values in the order of [`Parameter::ALL`].
    pub values: [f64; 6],
    /// A force that is not the plain cosine of the amplitude among the values, which is then Σ|A_j|.
    pub force: Option<Force>,
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
        let [gamma1, gamma2, omega, asymmetry, amplitude, restitution] = self.values;
        let chain = Chain::new(self.sites, gamma1, gamma2)?;
        match &self.force {
            None => Model::forced(chain, omega, asymmetry, amplitude, restitution),
            Some(force) => Model::with_force(chain, omega, asymmetry, force, restitution),
        }
    }
}
