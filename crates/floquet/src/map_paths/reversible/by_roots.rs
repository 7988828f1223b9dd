//! The verdict from all roots: where signs and searches from the lowest points leave some open, and for large rings, where with the known ones
//! nearby divided out all of them cost less than a search for those off the axis alone would.
//!
//! Among thousands of poles some always meet so closely that their residues are as good as lost. The roots are those of F as
//! it has been worked out, complete; what errors of the residues could make of them is told apart: a pair that may have met
//! makes the orbit undecided, the sign of a residue that is not known forbids to call it stable.

use nalgebra::Complex;

use crate::map_paths::reversible::root::Touching;
use crate::map_paths::reversible::verdict::{
    LeadingRoot, Reason, Secular, SecularVerdict, Standing, WORST, assemble, most,
};
use crate::zeros::SecularError;

impl Secular {
    /// The verdict from all roots. `unknown` is a mode the sign of whose residue is lost, `undecided` what is next to ±1.
    pub(crate) fn judge_all_roots(
        &mut self,
        unknown: Option<usize>,
        mut undecided: Option<LeadingRoot>,
    ) -> Result<SecularVerdict, SecularError> {
        let mut leading: Option<LeadingRoot> = None;
        for (nu, error) in self.all_nu()? {
            let excess = nu.excess();
            if excess == 0.0 || nu.im < 0.0 {
                continue;
            }
            let error = nu.excess_error(excess, error);
            let reason = if nu.im == 0.0 { Reason::RealRoot } else { Reason::ComplexPair };
            let this = LeadingRoot { nu, excess, error, reason };
            if error < excess {
                leading = most(leading, this);
            } else {
                undecided = most(undecided, LeadingRoot { reason: Reason::Tangency, excess: excess + error, ..this });
            }
        }
        let Self { residues: form, roots, .. } = self;
        for &Touching { gap, t, reach } in &roots.touching {
            let nu = form.nu(gap, Complex::new(t, reach));
            let excess = nu.excess();
            undecided = most(undecided, LeadingRoot { nu, excess, error: excess, reason: Reason::Tangency });
        }
        let worst = if form.neighbourhoods.is_empty() { WORST } else { f64::INFINITY };
        let verdict = assemble(leading, undecided, worst)?;
        match unknown {
            Some(mode) if verdict.outcome == Standing::Stable => Err(SecularError::ResidueSign { mode }),
            _ => Ok(verdict),
        }
    }
}
