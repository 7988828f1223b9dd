//! The numbers of a structure by name, as axes, flags and tables have them.

use std::fmt;
use std::str::FromStr;

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
}

/// Those that need no number of a contact, by the names of a chain, too.
const NAMED: [(&str, Setting); 11] = [
    ("omega", Setting::Omega),
    ("load", Setting::Load),
    ("static", Setting::Static),
    ("damping", Setting::Damping),
    ("coupling_damping", Setting::CouplingDamping),
    ("gamma1", Setting::Gamma1),
    ("gamma2", Setting::Gamma2),
    ("asymmetry", Setting::Asymmetry),
    ("restitution", Setting::RestitutionOfAll),
    ("amplitude", Setting::Load),
    ("static_force", Setting::Static),
];

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lower(contact) => write!(f, "contact.{contact}.lower"),
            Self::Upper(contact) => write!(f, "contact.{contact}.upper"),
            Self::Restitution(contact) => write!(f, "contact.{contact}.restitution"),
            named => f.write_str(NAMED.iter().find(|(_, setting)| setting == named).map_or("", |(name, _)| name)),
        }
    }
}

impl FromStr for Setting {
    type Err = String;

    /// ```
    /// use vibrochain_maps::structure::Setting;
    /// assert_eq!("contact.0.upper".parse(), Ok(Setting::Upper(0)));
    /// assert!("contact.0.gap".parse::<Setting>().unwrap_err().contains("contact.N.upper"));
    /// ```
    fn from_str(text: &str) -> Result<Self, String> {
        let unknown = || {
            format!(
                "`{text}` is no number of a structure: give omega, load, static, damping, asymmetry, restitution, contact.N.lower, \
                 contact.N.upper or contact.N.restitution; of a chain also gamma1, gamma2, coupling_damping"
            )
        };
        if let Some((_, setting)) = NAMED.iter().find(|(name, _)| *name == text) {
            return Ok(*setting);
        }
        let mut parts = text.split('.');
        let (Some("contact"), Some(number), Some(what), None) =
            (parts.next(), parts.next(), parts.next(), parts.next())
        else {
            return Err(unknown());
        };
        let contact = number.parse().map_err(|_| unknown())?;
        match what {
            "lower" => Ok(Self::Lower(contact)),
            "upper" => Ok(Self::Upper(contact)),
            "restitution" => Ok(Self::Restitution(contact)),
            _ => Err(unknown()),
        }
    }
}
