//! Values in words, one line each; numbers in the fewest digits that read back the same.

use std::fmt::{Display, Formatter, Result};

use crate::error::Short;
use crate::force::{Force, Harmonic};
use crate::parameter::Parameter;
use crate::params::{Barrier, Chain, Model};

/// The name in files.
impl Display for Barrier {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.pad(self.name())
    }
}

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

impl Display for Chain {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let masses = if self.sites() == 1 { "mass" } else { "masses" };
        let (gamma1, gamma2) = (Short(self.gamma1()), Short(self.gamma2()));
        write!(f, "{} {masses}, gamma1 = {gamma1}, gamma2 = {gamma2}", self.sites())
    }
}

impl Display for Model {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{}, omega = {}, asymmetry = {}, ", self.chain(), Short(self.omega()), Short(self.asymmetry()))?;
        match self.force().cosine_amplitude() {
            Some(amplitude) => write!(f, "amplitude = {}", Short(amplitude))?,
            None => write!(f, "force = {}", self.force())?,
        }
        write!(f, ", restitution = {}", Short(self.restitution()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_one_line_of_words() {
        let chain = Chain::new(1, 0.2, 1e-9).unwrap();
        let plain = Model::forced(chain, 1.5, 0.1 + 0.2, 0.0, 1.0).unwrap();
        let words = "1 mass, gamma1 = 0.2, gamma2 = 1e-9, omega = 1.5, asymmetry = 0.30000000000000004";
        assert_eq!(plain.to_string(), format!("{words}, amplitude = 0, restitution = 1"));
        let terms =
            [(5, -0.03, 0.5), (1, 0.1, 0.0)].map(|(number, amplitude, phase)| Harmonic { number, amplitude, phase });
        let force = Force::new(&terms).unwrap();
        let model = Model::with_force(chain, 1.5, 0.1 + 0.2, &force, 0.9).unwrap();
        assert_eq!(model.to_string(), format!("{words}, force = 1:0.1:0,5:-0.03:0.5, restitution = 0.9"));
        assert_eq!(format!("{} {:>6}", Parameter::Gamma1, Barrier::Upper), "gamma1  upper");
    }
}
