//! Verdicts on orbits of two sites that a reflection exchanges, from the secular functions of their blocks.

use nalgebra::Complex;
use vibrochain_breather::Finder;

use crate::analyser::{Analyser, Failure};
use crate::by_secular::{ratio_error, told};
use crate::saltation::saltations;
use crate::secular::Pair;
use crate::verdict::{Question, Verdict};

impl Analyser {
    /// Verdict and, if `thorough`, the non-trivial multipliers of the whole ring.
    pub(crate) fn by_partners(
        &mut self,
        pair: Pair,
        question: Question<'_>,
        finder: &mut Finder,
    ) -> Result<(Verdict, Vec<Complex<f64>>), Failure> {
        let orbit = question.orbit;
        let _ = saltations(orbit)?;
        let ratio_error = ratio_error(question, finder)?;
        self.partners.replace(finder.prepared(orbit)?, pair, ratio_error)?;
        let own = told(&self.partners.own.verdict()?, question)?;
        let other = told(&self.partners.other.verdict()?, question)?;
        let verdict = own.or_worse(other);
        if !question.thorough {
            return Ok((verdict, Vec::new()));
        }
        let mut multipliers = Vec::new();
        for block in [&mut self.partners.own, &mut self.partners.other] {
            multipliers.extend(block.all_nu()?.flat_map(|(nu, _)| nu.multipliers()));
        }
        let phases = self.partners.spared(orbit.model().chain().odd_modes()).map(|f| f * orbit.period());
        multipliers.extend(phases.flat_map(|phase| [phase, -phase]).map(|phase| Complex::from_polar(1.0, phase)));
        // Where none leads, one that is there.
        let leading = multipliers.first().filter(|_| verdict.growth() == 0.0).copied();
        Ok((Verdict { leading: leading.unwrap_or(verdict.leading), ..verdict }, multipliers))
    }
}
