//! Verdicts on words of several sites under a force or with losses, on lattices too large for a matrix: multipliers outside a circle are
//! counted by the turns of the secular function, and settled by the impacts' equations. The count says whether they are all.

use nalgebra::Complex;
use vibrochain_breather::{Condition, Finder};

use crate::analyser::{Analyser, Failure};
use crate::by_secular::check;
use crate::monodromy::MAX_DIMENSION;
use crate::saltation::saltations;
use crate::secular::{SecularError, excess};
use crate::verdict::{Question, Verdict};

/// Growth from which on multipliers are counted first, and where a count along the unit circle would take too long: waves are within the
/// reciprocal of their number of it, all else seldom is.
const COARSE: f64 = 1e-3;

/// Terms that a count along the unit circle may sum up: some seconds.
const MOST_TERMS: f64 = 4e10;

/// From circle to circle the distance to the unit circle grows by this.
const RISE: f64 = 4.0;

/// Circles, at most: the last one has a radius of 10¹⁰ and more.
const MOST_CIRCLES: usize = 30;

/// Circles with what is outside them.
type Circles = Vec<(f64, usize)>;

impl Analyser {
    /// The verdict; multipliers within the circle are only counted.
    pub(crate) fn by_turns(
        &mut self,
        question: Question<'_>,
        finder: &mut Finder,
    ) -> Result<(Verdict, Vec<Complex<f64>>), Failure> {
        let Question { orbit, tolerance, .. } = question;
        let _ = saltations(orbit)?;
        let condition = finder.condition(orbit)?;
        self.circle.set(finder.prepared(orbit)?, &condition)?;
        let allowed = tolerance.allowed().max(0.0);
        // The product of all multipliers is known: one is not farther inside than their mean.
        let e = orbit.model().restitution();
        let least = (2.0 * orbit.impacts().len() as f64 * e.ln() / self.circle.zeros() as f64).exp_m1();
        let lossy = orbit.model().loss() > 0.0;
        let affordable = self.circle.terms() <= MOST_TERMS;
        let mut distances = vec![allowed.max(COARSE)];
        if lossy && affordable && allowed < COARSE {
            distances.push(allowed);
        }
        for &distance in &distances {
            let turns = self.circle.turns(1.0 + distance)?;
            if turns.outside > 0 {
                let (leading, growth, error) =
                    self.outermost(distance, turns.starts, turns.outside, &condition, question, finder)?;
                check(growth, error, question)?;
                return Ok((Verdict::of_growth(leading, growth, error, tolerance), Vec::new()));
            }
        }
        let most = distances.last().copied().unwrap_or(COARSE);
        if most > allowed && 2 * orbit.model().chain().sites() <= MAX_DIMENSION {
            return Err(SecularError::Tangency.into());
        }
        Ok((Verdict::none_outside(least, most, tolerance), Vec::new()))
    }

    /// The outermost multiplier with its growth and error, of those outside a circle.
    fn outermost(
        &mut self,
        distance: f64,
        mut starts: Vec<Complex<f64>>,
        outside: usize,
        condition: &Condition,
        question: Question<'_>,
        finder: &mut Finder,
    ) -> Result<(Complex<f64>, f64, f64), Failure> {
        let mut circles: Circles = vec![(distance, outside)];
        let mut next = (distance * RISE).max(self.circle.spacing());
        while circles.last().is_some_and(|(_, outside)| *outside > 0) {
            if circles.len() > MOST_CIRCLES {
                return Err(SecularError::Tangency.into());
            }
            // One that goes through a multiplier is not counted along.
            if let Ok(turns) = self.circle.turns(1.0 + next) {
                circles.push((next, turns.outside));
                starts.extend(turns.starts);
                next *= RISE;
            } else {
                next *= 1.1;
            }
        }
        let prepared = finder.prepared(question.orbit)?;
        self.forced.settle_distinct(prepared, condition, starts.into_iter());
        let (values, errors) = self.forced.multipliers();
        let all = || values.iter().zip(errors).map(|(value, error)| (*value, excess(*value), *error));
        let (mut found, mut wanted) = (0, 0);
        // Those of the outermost circle that has any are enough.
        for &(distance, outside) in circles.iter().rev().filter(|(_, outside)| *outside > 0) {
            let beyond = all().filter(|(_, growth, error)| *growth > distance + error);
            (found, wanted) = (beyond.clone().map(|(value, ..)| if value.im == 0.0 { 1 } else { 2 }).sum(), outside);
            let leading = beyond.max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((leading, growth, error)) = leading.filter(|_| found == wanted) {
                // Another one that may lead is as good.
                let error = all().map(|(_, other, reach)| other + reach - growth).fold(error, f64::max);
                return Ok((leading, growth, error));
            }
        }
        Err(SecularError::Incomplete { found, wanted }.into())
    }
}
