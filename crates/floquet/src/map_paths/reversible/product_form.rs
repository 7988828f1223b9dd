//! A leading multiplier of two instants that residues know to few digits, next to coincident poles, from the secular function itself as
//! a product of sums.

use crate::map_paths::reversible::double_sided::refine;
use crate::map_paths::reversible::verdict::{Reason, Secular, SecularVerdict, Standing};
use crate::zeros::Nu;

impl Secular {
    /// The verdict on an orbit of this period. Close poles can leave the leading multiplier imprecise; it is then taken from f itself, if f
    /// gives more digits. f is solved in ρ, ρ² = (1 + ν)/2, the variable of half a period.
    pub(crate) fn refined(&self, verdict: SecularVerdict, period: f64) -> SecularVerdict {
        self.by_product(&verdict, period).unwrap_or(verdict)
    }

    fn by_product(&self, verdict: &SecularVerdict, period: f64) -> Option<SecularVerdict> {
        let leading = verdict.leading.filter(|_| verdict.outcome == Standing::Unstable)?;
        let start = (leading + leading.inv()) * 0.5;
        let form = &self.residues;
        let (rho, error) = refine(form.modes(), form.saltations()?, period, ((start + 1.0) * 0.5).sqrt())?;
        let mut nu = rho * rho * 2.0 - 1.0;
        if verdict.reason == Reason::RealRoot {
            nu.im = 0.0;
        }
        // The slope of the way back is 4ρ.
        let (nu, reach) = (Nu::of(nu), 4.0 * error * rho.norm().max(1.0));
        let excess = nu.excess();
        let excess_error = nu.excess_error(excess, reach);
        let same = (excess - verdict.excess).abs() <= verdict.excess_error && excess_error < excess;
        let [leading, _] = nu.multipliers();
        let better = SecularVerdict { leading: Some(leading), excess, excess_error, ..*verdict };
        (same && excess_error < verdict.excess_error).then_some(better)
    }
}
