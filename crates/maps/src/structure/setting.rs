//! The numbers of a structure by name, as axes, flags and tables have them.

use std::fmt;
use std::str::FromStr;

/// One number that can be varied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Setting {
    /// ω
    Omega,
    /// What all loads that change are multiplied by.
    Load,
    /// What the static load is multiplied by.
    Static,
    /// What all dashpots are multiplied by.
    Damping,
    /// The lower barrier of a contact.
    Lower(usize),
    /// Its upper barrier.
    Upper(usize),
    /// Its coefficient of restitution.
    Restitution(usize),
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Omega => f.write_str("omega"),
            Self::Load => f.write_str("load"),
            Self::Static => f.write_str("static"),
            Self::Damping => f.write_str("damping"),
            Self::Lower(contact) => write!(f, "contact.{contact}.lower"),
            Self::Upper(contact) => write!(f, "contact.{contact}.upper"),
            Self::Restitution(contact) => write!(f, "contact.{contact}.restitution"),
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
                "`{text}` is no number of a structure: give omega, load, static, damping, contact.N.lower, contact.N.upper or \
                 contact.N.restitution"
            )
        };
        match text {
            "omega" => return Ok(Self::Omega),
            "load" => return Ok(Self::Load),
            "static" => return Ok(Self::Static),
            "damping" => return Ok(Self::Damping),
            _ => {}
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
