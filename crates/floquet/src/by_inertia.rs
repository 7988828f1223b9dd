//! Verdicts on words of several sites on rings too large for a matrix, from the inertia of their secular matrix.

use nalgebra::Complex;
use vibrochain_breather::Finder;

use crate::analyser::{Analyser, Failure};
use crate::by_secular::{check, told};
use crate::saltation::saltations;
use crate::verdict::{Question, Verdict};

impl Analyser {
    /// The verdict; multipliers are only counted.
    pub(crate) fn by_inertia(
        &mut self,
        question: Question<'_>,
        finder: &mut Finder,
    ) -> Result<(Verdict, Vec<Complex<f64>>), Failure> {
        let orbit = question.orbit;
        let _ = saltations(orbit)?;
        let condition = finder.condition(orbit)?;
        self.inertia.set(finder.prepared(orbit)?, &condition);
        let verdict = told(&self.inertia.verdict()?, question.tolerance);
        check(verdict.growth(), verdict.resolution, question)?;
        Ok((verdict, Vec::new()))
    }
}
