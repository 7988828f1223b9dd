//! A leading multiplier of two instants that residues know to few digits, next to coincident poles, from the secular function itself as
//! a product of sums.

use crate::map_paths::modes::Modes;
use crate::map_paths::reversible::double_sided::{Saltations, settle};
use crate::map_paths::reversible::verdict::{Reason, Secular, SecularVerdict, Standing};
use crate::zeros::Nu;

/// A verdict whose leading multiplier close poles leave imprecise, with that multiplier from f itself, if that knows it better: in ρ, both
/// halves of a period being alike, with ρ² = (1 + ν)/2.
pub(crate) fn settled(verdict: &SecularVerdict, saltations: &Saltations, modes: &Modes, period: f64) -> SecularVerdict {
    let Some(leading) = verdict.leading.filter(|_| verdict.outcome == Standing::Unstable) else { return *verdict };
    let start = (leading + leading.inv()) * 0.5;
    let Some((rho, error)) = settle(modes, saltations, period, ((start + 1.0) * 0.5).sqrt()) else { return *verdict };
    let mut nu = rho * rho * 2.0 - 1.0;
    if verdict.reason == Reason::RealRoot {
        nu.im = 0.0;
    }
    // The slope of the way back is 4ρ.
    let (nu, reach) = (Nu::of(nu), 4.0 * error * rho.norm().max(1.0));
    let growth = nu.growth();
    let growth_error = nu.growth_error(growth, reach);
    let same = (growth - verdict.growth).abs() <= verdict.growth_error && growth_error < growth;
    if same && growth_error < verdict.growth_error {
        let [leading, _] = nu.multipliers();
        SecularVerdict { leading: Some(leading), growth, growth_error, ..*verdict }
    } else {
        *verdict
    }
}

impl Secular {
    /// A verdict of its own whose leading multiplier is imprecise, with that multiplier from f itself, where there are two instants;
    /// `period` is that of the orbit.
    pub(crate) fn settled(&self, verdict: SecularVerdict, period: f64) -> SecularVerdict {
        let modes = self.residues.modes();
        let settle = |saltations| settled(&verdict, saltations, modes, period);
        self.residues.saltations().map_or(verdict, settle)
    }
}
