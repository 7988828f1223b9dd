//! The real parameters of the model by name, to be varied one at a time.

use crate::error::ParameterError;
use crate::model::params::{Chain, Model};

/// A real parameter of the model, which a sweep can vary or a search can solve for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
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
    /// γ₃
    Gamma3,
}

impl Parameter {
    /// All of them, in the order of tables.
    pub const ALL: [Self; 7] =
        [Self::Gamma1, Self::Gamma2, Self::Omega, Self::Asymmetry, Self::Amplitude, Self::Restitution, Self::Gamma3];

    /// Those of a lattice of so many layers: γ₃ takes two.
    pub fn of(layers: usize) -> &'static [Self] {
        const ALL: [Parameter; 7] = Parameter::ALL;
        if layers > 1 { &ALL } else { ALL.split_at(6).0 }
    }

    /// The name in scenes, flags and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gamma1 => "gamma1",
            Self::Gamma2 => "gamma2",
            Self::Omega => "omega",
            Self::Asymmetry => "asymmetry",
            Self::Amplitude => "amplitude",
            Self::Restitution => "restitution",
            Self::Gamma3 => "gamma3",
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
            Self::Gamma3 => "γ₃",
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
            Self::Gamma3 => "coupling of layers",
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
            Parameter::Gamma3 => self.chain().gamma3(),
        }
    }

    /// The same model with one parameter changed. The amplitude of a force of several harmonics is Σ|A_j|: all of them are
    /// scaled alike.
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
        let [gamma1, gamma2, gamma3] = [Parameter::Gamma1, Parameter::Gamma2, Parameter::Gamma3].map(or);
        let chain = Chain::on(self.chain().layout(), gamma1, gamma2, gamma3)?;
        let force = match parameter {
            Parameter::Amplitude => self.force().scaled_to(value)?,
            _ => *self.force(),
        };
        Self::with_force(chain, or(Parameter::Omega), or(Parameter::Asymmetry), &force, or(Parameter::Restitution))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::force::{Force, Harmonic};
    use crate::modes::row::Ends;

    #[test]
    fn with_changes_one_value_and_get_reads_it() {
        let chain = Chain::new(5, 0.2, 0.1).unwrap();
        assert!(Model::conservative(chain, 1.5, 0.4).unwrap().with(Parameter::Gamma3, 0.1).is_err());
        let chain = chain.with_ends(Ends::Free).with_layers(3, 0.05, Ends::Closed).unwrap();
        let model = Model::forced(chain, 1.5, 0.4, 0.3, 0.9).unwrap();
        for parameter in Parameter::ALL {
            let changed = model.with(parameter, 0.77).unwrap();
            assert_eq!(changed.chain().layout(), chain.layout());
            for other in Parameter::ALL {
                let expected = if other == parameter { 0.77 } else { model.get(other) };
                assert_eq!(changed.get(other), expected, "{parameter:?} {other:?}");
            }
            assert_eq!(Parameter::from_name(parameter.name()), Some(parameter));
            assert!(model.with(parameter, -1.0).is_err());
        }
    }

    #[test]
    fn a_force_of_several_harmonics_keeps_its_shape() {
        let terms =
            [(1, 0.3, 0.5), (3, -0.1, 0.0)].map(|(number, amplitude, phase)| Harmonic { number, amplitude, phase });
        let force = Force::new(&terms).unwrap();
        let model = Model::with_force(Chain::new(5, 0.2, 0.1).unwrap(), 1.5, 0.4, &force, 0.9).unwrap();
        assert_eq!(*model.with(Parameter::Gamma2, 0.05).unwrap().force(), force);
        let twice = model.with(Parameter::Amplitude, 0.8).unwrap();
        for (harmonic, term) in twice.force().harmonics().iter().zip(terms) {
            assert_eq!((harmonic.number, harmonic.phase), (term.number, term.phase));
            assert!((harmonic.amplitude - 2.0 * term.amplitude).abs() < 1e-15);
        }
        assert!((twice.get(Parameter::Amplitude) - 0.8).abs() < 1e-15);
        assert!(model.with(Parameter::Amplitude, -0.1).is_err() && model.with(Parameter::Amplitude, f64::NAN).is_err());
        assert_eq!(model.with(Parameter::Amplitude, 0.0).unwrap().amplitude(), 0.0);
    }
}
