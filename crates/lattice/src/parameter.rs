//! The real parameters of the model by name, to be varied one at a time.

use crate::error::ParameterError;
use crate::params::{Chain, Model};

/// A real parameter of the model, which a sweep can vary or a search can solve for.
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

impl Model {
    /// The value of one parameter.
    pub fn get(&self, parameter: Parameter) -> f64 {
        match parameter {
            Parameter::Gamma1 => self.chain().gamma1(),
            Parameter::Gamma2 => self.chain().gamma2(),
            Parameter::Omega => self.omega(),
            Parameter::Asymmetry => self.asymmetry(),
            Parameter::Amplitude => self.amplitude(),
            Parameter::Restitution => self.restitution(),
        }
    }

    /// The same model with one parameter changed.
    ///
    /// # Errors
    /// [`ParameterError`] for a value out of range.
    ///
    /// ```
    /// use vibrochain_lattice::{Chain, Model, Parameter};
    /// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4, 0.1, 0.9)?;
    /// let softer = model.with(Parameter::Gamma2, 0.05)?;
    /// assert_eq!((softer.chain().gamma2(), softer.get(Parameter::Omega)), (0.05, 1.5));
    /// assert!(model.with(Parameter::Restitution, 1.1).is_err());
    /// # Ok::<(), vibrochain_lattice::ParameterError>(())
    /// ```
    pub fn with(&self, parameter: Parameter, value: f64) -> Result<Self, ParameterError> {
        let or = |which: Parameter| if which == parameter { value } else { self.get(which) };
        let chain = Chain::new(self.chain().sites(), or(Parameter::Gamma1), or(Parameter::Gamma2))?;
        let (amplitude, restitution) = (or(Parameter::Amplitude), or(Parameter::Restitution));
        Self::forced(chain, or(Parameter::Omega), or(Parameter::Asymmetry), amplitude, restitution)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_changes_one_value_and_get_reads_it() {
        let model = Model::forced(Chain::new(5, 0.2, 0.1).unwrap(), 1.5, 0.4, 0.3, 0.9).unwrap();
        for parameter in Parameter::ALL {
            let changed = model.with(parameter, 0.77).unwrap();
            for other in Parameter::ALL {
                let expected = if other == parameter { 0.77 } else { model.get(other) };
                assert_eq!(changed.get(other), expected, "{parameter:?} {other:?}");
            }
            assert_eq!(Parameter::from_name(parameter.name()), Some(parameter));
            assert!(model.with(parameter, -1.0).is_err());
        }
    }
}
