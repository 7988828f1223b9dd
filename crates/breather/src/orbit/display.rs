//! Values in words, one line each; numbers in the fewest digits that read back the same.

use std::fmt::{Display, Formatter, Result};

use vibrochain_lattice::{Layout, Short};

use crate::admissible::answer::Admissibility;
use crate::orbit::{Hit, Impact, Orbit};
use crate::structures::condition::Condition;

impl Hit {
    /// In words, with its mass as words of this lattice name it: where, when, how strong.
    #[must_use]
    pub fn told(&self, layout: &Layout) -> String {
        let (site, time, impulse) = (layout.name(self.site), Short(self.time), Short(self.impulse));
        format!("site {site} on the {} barrier at t = {time}: impulse {impulse}", self.barrier)
    }
}

impl Impact {
    /// In words, with its mass as words of this lattice name it: as of a [`Hit`], and its velocities.
    #[must_use]
    pub fn told(&self, layout: &Layout) -> String {
        let (before, after) = (Short(self.velocity_before), Short(self.velocity_after));
        format!("{}, velocity {before} -> {after}", Hit::from(self).told(layout))
    }
}

impl Admissibility {
    /// In words, with masses as words of this lattice name them.
    #[must_use]
    pub fn told(&self, layout: &Layout) -> String {
        match (self.obstruction, self.margin) {
            (Some(obstruction), _) => format!("not physical: {}", obstruction.told(layout)),
            (None, Some(margin)) => format!("physical, margin {margin}"),
            (None, None) => "physical".to_owned(),
        }
    }
}

impl Display for Hit {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str(&self.told(&Layout::ONE_ROW))
    }
}

impl Display for Impact {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str(&self.told(&Layout::ONE_ROW))
    }
}

/// Period, phases and impulses.
impl Display for Orbit {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "period {}", Short(self.period()))?;
        for (name, value) in [("phi", self.phi()), ("psi", self.psi())] {
            if let Some(value) = value {
                write!(f, ", {name} {}", Short(value))?;
            }
        }
        for (i, impact) in self.impacts().iter().enumerate() {
            let lead = match (i, self.impacts().len()) {
                (0, 1) => " impulse",
                (0, _) => " impulses",
                _ => "",
            };
            write!(f, ",{lead} {}", Short(impact.impulse))?;
        }
        Ok(())
    }
}

impl Display for Admissibility {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str(&self.told(&Layout::ONE_ROW))
    }
}

/// The distances, and how well the equations are conditioned.
impl Display for Condition {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let Self { resonance, grazing, fold, .. } = self;
        write!(
            f,
            "distance to resonance {resonance:.1e}, to grazing {grazing:.1e}; reciprocal condition number {fold:.1e}"
        )
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::{Chain, Model};

    use super::*;
    use crate::Family;
    use crate::{admissibility, breathers};

    #[test]
    fn orbits_and_what_is_known_of_them_are_lines_of_words() {
        let model = |a: f64| Model::conservative(Chain::new(1, 0.0, 1.0).unwrap(), std::f64::consts::PI, a).unwrap();
        // Without a spring the mass flies evenly from barrier to barrier and back: 4 in the period of 2.
        let orbit = &breathers(&model(0.5), Family::DoubleSided).unwrap().orbits[0];
        assert_eq!(orbit.to_string(), "period 2, phi 1, impulses -4, 4");
        let impact = "site 0 on the lower barrier at t = 1: impulse 4";
        assert_eq!(orbit.impacts()[1].to_string(), format!("{impact}, velocity -2 -> 2"));
        assert_eq!(Hit::from(&orbit.impacts()[1]).to_string(), impact);
        assert_eq!(admissibility(orbit).unwrap().to_string(), "physical");
        let blocked = Admissibility { obstruction: None, margin: Some(0.25), closest: None };
        assert_eq!(blocked.to_string(), "physical, margin 0.25");
        let condition = Condition { resonance: 0.1, grazing: 2.0, fold: 1e-9, ..Condition::default() };
        assert_eq!(
            condition.to_string(),
            "distance to resonance 1.0e-1, to grazing 2.0e0; reciprocal condition number 1.0e-9"
        );
    }
}
