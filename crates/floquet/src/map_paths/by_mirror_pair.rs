//! Verdicts on orbits of two sites that a reflection exchanges, from the secular functions of their blocks.

use nalgebra::Complex;
use vibrochain_breather::Finder;

use crate::analyser::{Analyser, Answer, Failure};
use crate::map_paths::Pair;
use crate::map_paths::by_secular::{check, ratio_error, told};
use crate::saltation::saltations;
use crate::verdict::{Question, Verdict};

/// Errors of ν that a matrix does not beat by so much that it would be worth its time: of its own some 1e-14 times its norm.
const OF_A_MATRIX: f64 = 1e-12;

impl Analyser {
    /// Verdict and, if `thorough`, the non-trivial multipliers of the whole ring.
    pub(crate) fn by_partners(
        &mut self,
        pair: Pair,
        question: Question<'_>,
        finder: &mut Finder,
    ) -> Result<Answer, Failure> {
        let orbit = question.orbit;
        let _ = saltations(orbit)?;
        let ratio_error = if pair.is_symmetric { 0.0 } else { ratio_error(question, finder)? };
        self.partners.replace(finder.prepared(orbit)?, pair, ratio_error)?;
        let [own, other] = self.partners.verdicts()?.map(|verdict| told(&verdict, question.tolerance));
        let verdict = own.or_worse(other);
        // A small growth goes like the root of ν − 1, of whatever ν is.
        if !verdict.marginal && verdict.growth().min(1.0) * verdict.resolution > OF_A_MATRIX {
            check(verdict.growth(), verdict.resolution, question)?;
        }
        if !question.thorough {
            return Ok((verdict, Vec::new()));
        }
        let mut multipliers = self.partners.multipliers()?;
        let phases = self.partners.spared(orbit.model().chain()).map(|f| f * orbit.period());
        multipliers.extend(phases.flat_map(|phase| [phase, -phase]).map(|phase| Complex::from_polar(1.0, phase)));
        // Where none leads, one that is there.
        let leading = multipliers.first().filter(|_| verdict.growth() == 0.0).copied();
        Ok((Verdict { leading: leading.unwrap_or(verdict.leading), ..verdict }, multipliers))
    }
}
