//! A leading multiplier of two instants that residues know to few digits, next to coincident poles, from the secular function itself as
//! a product of sums.

use nalgebra::Complex;

use super::double_sided::{Saltations, settle};
use super::growth::Nu;
use super::modes::Modes;
use super::verdict::{Reason, Secular, SecularVerdict, Standing};

type C = Complex<f64>;

/// From ν to ρ and back, where both halves of a period are alike: ρ² = (1 + ν)/2.
pub(super) const BY_ROOT: [fn(C) -> C; 2] = [|nu| ((nu + 1.0) * 0.5).sqrt(), |rho| rho * rho * 2.0 - 1.0];

/// A verdict whose leading multiplier close poles leave imprecise, with that multiplier from f itself, if that knows it better. `ways`
/// lead from ν to ρ and back.
pub(super) fn settled(
    verdict: &SecularVerdict,
    saltations: &Saltations,
    parities: [&Modes; 2],
    period: f64,
    ways: [fn(C) -> C; 2],
) -> SecularVerdict {
    let Some(leading) = verdict.leading.filter(|_| verdict.outcome == Standing::Unstable) else { return *verdict };
    let start = (leading + leading.inv()) * 0.5;
    let Some((rho, error)) = settle(parities, saltations, period, ways[0](start)) else { return *verdict };
    let mut nu = ways[1](rho);
    if verdict.reason == Reason::RealRoot {
        nu.im = 0.0;
    }
    // The slope of the way back is 1, or 4ρ.
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
        let settle = |saltations| settled(&verdict, saltations, [modes; 2], period, BY_ROOT);
        self.residues.saltations().map_or(verdict, settle)
    }
}
