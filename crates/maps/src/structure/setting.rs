//! The numbers of a structure by name, as axes, flags and tables have them.

use std::fmt;
use std::str::FromStr;

use vibrochain_lattice::{DampedParameter, Parameter, Row};

use crate::hints::said;

/// One number that can be varied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Setting {
    /// ω
    Omega,
    /// What all loads that change are multiplied by; of a chain the amplitude of the force on each mass.
    Load,
    /// What the static load is multiplied by.
    Static,
    /// What all dashpots are multiplied by; of a chain the dashpot of each mass.
    Damping,
    /// Of a chain, the dashpot between neighbours.
    CouplingDamping,
    /// Of a chain, γ₁.
    Gamma1,
    /// Of a chain, γ₂.
    Gamma2,
    /// The middle of the gap of every contact that has two barriers.
    Asymmetry,
    /// The coefficient of restitution of every contact.
    RestitutionOfAll,
    /// The lower barrier of a contact.
    Lower(usize),
    /// Its upper barrier.
    Upper(usize),
    /// Its coefficient of restitution.
    Restitution(usize),
    /// An entry of a matrix, and the one across the diagonal.
    Entry(Matrix, usize, usize),
    /// The load of a coordinate, of the first harmonic there is.
    LoadOf(usize),
    /// The static load of a coordinate.
    StaticOf(usize),
}

/// A matrix of a structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Matrix {
    /// M
    Mass,
    /// K
    Stiffness,
    /// C
    Damping,
}

impl Matrix {
    const ALL: [(&'static str, Self); 3] =
        [("mass", Self::Mass), ("stiffness", Self::Stiffness), ("damping", Self::Damping)];

    pub(crate) fn name(self) -> &'static str {
        Self::ALL.into_iter().find(|(_, matrix)| *matrix == self).map_or("", |(name, _)| name)
    }
}

/// Those that need no number of a contact: by the names of structures, and as the parameters of chains that they are.
const NAMED: [(Setting, &str, &Row); 9] = [
    (Setting::Omega, "omega", Parameter::Omega.row()),
    (Setting::Load, "load", Parameter::Amplitude.row()),
    (Setting::Static, "static", DampedParameter::StaticForce.row()),
    (Setting::Damping, "damping", Parameter::Damping.row()),
    (Setting::CouplingDamping, "coupling_damping", Parameter::CouplingDamping.row()),
    (Setting::Gamma1, "gamma1", Parameter::Gamma1.row()),
    (Setting::Gamma2, "gamma2", Parameter::Gamma2.row()),
    (Setting::Asymmetry, "asymmetry", Parameter::Asymmetry.row()),
    (Setting::RestitutionOfAll, "restitution", Parameter::Restitution.row()),
];

impl Setting {
    /// Its row in the table of parameters; `None` where the table has none, as of numbers of a contact.
    pub(super) fn row(self) -> Option<&'static Row> {
        NAMED.into_iter().find(|(setting, ..)| *setting == self).map(|(.., row)| row)
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lower(contact) => write!(f, "contact.{contact}.lower"),
            Self::Upper(contact) => write!(f, "contact.{contact}.upper"),
            Self::Restitution(contact) => write!(f, "contact.{contact}.restitution"),
            Self::Entry(matrix, row, column) => write!(f, "{}.{row}.{column}", matrix.name()),
            Self::LoadOf(coordinate) => write!(f, "load.{coordinate}"),
            Self::StaticOf(coordinate) => write!(f, "static.{coordinate}"),
            named => f.write_str(NAMED.iter().find(|(setting, ..)| setting == named).map_or("", |(_, name, _)| name)),
        }
    }
}

impl FromStr for Setting {
    type Err = String;

    /// ```
    /// use vibrochain_maps::structure::Setting;
    /// use vibrochain_maps::structure::setting::Matrix;
    /// assert_eq!("contact.0.upper".parse(), Ok(Setting::Upper(0)));
    /// assert_eq!("stiffness.1.2".parse(), Ok(Setting::Entry(Matrix::Stiffness, 1, 2)));
    /// assert_eq!("masses.3".parse::<Setting>()?.to_string(), "mass.3.3");
    /// assert!("contact.0.gap".parse::<Setting>().unwrap_err().contains("contact.N.upper"));
    /// # Ok::<(), String>(())
    /// ```
    fn from_str(text: &str) -> Result<Self, String> {
        let unknown = || {
            let said = said(text).map_or(String::new(), |said| format!("{said}; "));
            format!(
                "`{text}` is no number of a structure: {said}give omega, load, static, damping, asymmetry, restitution, contact.N.lower, \
                 contact.N.upper or contact.N.restitution; of matrices also masses.I, mass.I.J, stiffness.I.J, damping.I.J, load.I, static.I; \
                 of a chain also gamma1, gamma2, coupling_damping"
            )
        };
        if let Some((setting, ..)) = NAMED.iter().find(|(_, name, row)| *name == text || row.name == text) {
            return Ok(*setting);
        }
        let number = |text: &str| text.parse().map_err(|_| unknown());
        let matrix = |name: &str| Matrix::ALL.into_iter().find(|(known, _)| *known == name).map(|(_, matrix)| matrix);
        match text.split('.').collect::<Vec<_>>()[..] {
            ["contact", contact, "lower"] => Ok(Self::Lower(number(contact)?)),
            ["contact", contact, "upper"] => Ok(Self::Upper(number(contact)?)),
            ["contact", contact, "restitution"] => Ok(Self::Restitution(number(contact)?)),
            ["load", coordinate] => Ok(Self::LoadOf(number(coordinate)?)),
            ["static", coordinate] => Ok(Self::StaticOf(number(coordinate)?)),
            ["masses", place] => number(place).map(|place| Self::Entry(Matrix::Mass, place, place)),
            [name, row, column] => Ok(Self::Entry(matrix(name).ok_or_else(unknown)?, number(row)?, number(column)?)),
            _ => Err(unknown()),
        }
    }
}
