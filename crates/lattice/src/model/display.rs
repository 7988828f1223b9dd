//! Values in words, one line each; numbers in the fewest digits that read back the same.

use std::fmt::{Display, Formatter, Result};
use std::str::FromStr;

use crate::error::Short;
use crate::model::chain::{Chain, Layout};
use crate::model::force::{Force, Harmonic};
use crate::model::parameter::Parameter;
use crate::model::params::Model;
use crate::model::point::Point;
use crate::modes::row::Ends;

/// The name in files.
impl Display for Parameter {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.pad(self.name())
    }
}

/// As the flag `--force` of `mapgen` takes it: number:amplitude:phase.
impl Display for Force {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        for (i, Harmonic { number, amplitude, phase }) in self.harmonics().iter().enumerate() {
            let comma = if i == 0 { "" } else { "," };
            write!(f, "{comma}{number}:{}:{}", Short(*amplitude), Short(*phase))?;
        }
        Ok(())
    }
}

/// As [`Force`] is written; the phase may be left out.
///
/// ```
/// use vibrochain_lattice::Force;
/// let force: Force = "1:0.1:0,3:-0.03".parse().unwrap();
/// assert_eq!(force.to_string(), "1:0.1:0,3:-0.03:0");
/// assert!("1:0.1:0,2:0.03".parse::<Force>().unwrap_err().contains("harmonic = 2"));
/// ```
impl FromStr for Force {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let harmonics = text.split(',').map(harmonic).collect::<std::result::Result<Vec<_>, _>>()?;
        Self::new(&harmonics).map_err(|error| error.to_string())
    }
}

fn harmonic(text: &str) -> std::result::Result<Harmonic, String> {
    let wrong = |what: &str| format!("`{text}` has {what}: give number:amplitude:phase, as in 1:0.1:0,3:0.03:1.57");
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let (number, amplitude, phase) = match parts[..] {
        [number, amplitude] => (number, amplitude, "0"),
        [number, amplitude, phase] => (number, amplitude, phase),
        _ => return Err(wrong("not two or three parts")),
    };
    Ok(Harmonic {
        number: number.parse().map_err(|_| wrong("no whole number in front"))?,
        amplitude: amplitude.parse().map_err(|_| wrong("an amplitude that is no number"))?,
        phase: phase.parse().map_err(|_| wrong("a phase that is no number"))?,
    })
}

/// "21 masses (N = 20)", "12 masses, free ends", "11 masses × 2 layers".
impl Display for Layout {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{} {}", self.length, if self.length == 1 { "mass" } else { "masses" })?;
        // The paper's letter, of what it treats.
        if self.is_ring() && self.length > 1 {
            write!(f, " (N = {})", self.length - 1)?;
        }
        if self.layers > 1 {
            write!(f, " × {} layers", self.layers)?;
        }
        if self.ends != Ends::Closed {
            write!(f, ", {} ends", self.ends)?;
        }
        // The first and last of two layers are neighbours anyway, if by one spring only.
        let closed = self.layers > 1 && self.layer_ends != Ends::Free;
        if closed { write!(f, ", {} layers", self.layer_ends) } else { Ok(()) }
    }
}

impl Display for Chain {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{}", self.layout())?;
        values(f, &self.point(), Parameter::is_of_lattice)
    }
}

impl Display for Model {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{}", self.chain().layout())?;
        values(f, &self.point(), |_| true)
    }
}

/// ", gamma1 = 0.2, gamma2 = 0.1": each that is worth a word.
fn values(f: &mut Formatter<'_>, point: &Point, wanted: impl Fn(Parameter) -> bool) -> Result {
    for parameter in Parameter::told().filter(|parameter| wanted(*parameter)) {
        match &point.force {
            Some(force) if parameter == Parameter::Amplitude => write!(f, ", force = {force}")?,
            _ if point.tells(parameter) => write!(f, ", {parameter} = {}", Short(point.get(parameter)))?,
            _ => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Barrier;

    #[test]
    fn values_are_one_line_of_words() {
        let chain = Chain::new(1, 0.2, 1e-9).unwrap();
        let plain = chain.point().omega(1.5).asymmetry(0.1 + 0.2).model().unwrap();
        let words = "1 mass, gamma1 = 0.2, gamma2 = 1e-9, omega = 1.5, asymmetry = 0.30000000000000004";
        assert_eq!(plain.to_string(), format!("{words}, amplitude = 0, restitution = 1"));
        let ring = Chain::new(21, 0.2, 0.1).unwrap();
        assert_eq!(ring.to_string(), "21 masses (N = 20), gamma1 = 0.2, gamma2 = 0.1");
        let layered = Chain::new(4, 0.2, 0.1).unwrap().with_ends(Ends::Fixed).with_layers(2, 0.3, Ends::Free).unwrap();
        let expected = "4 masses × 2 layers, fixed ends, gamma1 = 0.2, gamma2 = 0.1, gamma3 = 0.3";
        assert_eq!(layered.to_string(), expected);
        let terms =
            [(5, -0.03, 0.5), (1, 0.1, 0.0)].map(|(number, amplitude, phase)| Harmonic { number, amplitude, phase });
        let force = Force::new(&terms).unwrap();
        let model = chain.point().omega(1.5).asymmetry(0.1 + 0.2).under(&force).restitution(0.9).model().unwrap();
        assert_eq!(model.to_string(), format!("{words}, force = 1:0.1:0,5:-0.03:0.5, restitution = 0.9"));
        assert_eq!(format!("{} {:>6}", Parameter::Gamma1, Barrier::Upper), "gamma1  upper");
    }
}
