//! Verdicts on words of several sites under a force or with losses, and on what symmetry leaves open without them, on lattices too large
//! for a matrix: multipliers outside a circle are counted by the turns of the secular function, and settled by the impacts' equations. The
//! count says whether they are all.

use nalgebra::Complex;
use vibrochain_breather::Finder;

use crate::analyser::{Analyser, Failure};
use crate::by_secular::check;
use crate::monodromy::MAX_DIMENSION;
use crate::saltation::saltations;
use crate::secular::{SecularError, excess};
use crate::verdict::{Question, Verdict};

/// Distances to the unit circle of the circles that are counted along come down from here, each this part of the one before: the larger
/// ones cost little, and what is outside them decides.
const FIRST: f64 = 1.0;
const FALL: f64 = 0.1;

/// The least of these. Waves are within the reciprocal of their number of the unit circle, all else seldom is.
const COARSE: f64 = 1e-3;

/// Distances in question where no more than rounding is allowed: the first one that no multiplier is too close to. On the unit circle itself
/// elastic impacts have most of theirs.
const FINE: [f64; 4] = [0.0, 1e-8, 1e-6, 1e-4];

/// Terms that a count along the unit circle may sum up, as estimated beforehand: of ten impacts those of some
/// 3000 masses, as many as a matrix is reduced of.
const MOST_TERMS: f64 = 1.2e12;

/// Circles that are laid beyond or between others to come nearer to multipliers that are missing.
const MOST_CIRCLES: usize = 30;

/// Circles are not laid closer to each other, nor to the unit circle.
const NEAREST: f64 = 1.0 + 1e-3;
const CLOSEST: f64 = 1e-9;

/// The distance of a circle to a larger one that counts for that of the unit circle, as a part of it.
const LEAST: f64 = 1e-2;

/// Circles by rising distance, with what is outside them.
type Circles = Vec<(f64, usize)>;

/// A multiplier with its growth and the error of that.
type Outermost = (Complex<f64>, f64, f64);

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
        self.forced.adopt(orbit, &condition, std::iter::empty(), None);
        // The product of all multipliers is known: one is not farther inside than their mean.
        let e = orbit.model().restitution();
        let least = (2.0 * orbit.impacts().len() as f64 * e.ln() / self.circle.zeros() as f64).exp_m1();
        let allowed = tolerance.allowed().max(0.0);
        let coarse = allowed.max(COARSE);
        let mut circles = Circles::new();
        let mut distance = FIRST.max(coarse);
        loop {
            let turns = self.circle.turns(1.0 + distance);
            if let Ok(turns) = turns {
                circles.insert(0, (distance, turns.outside));
                if turns.outside > 0 {
                    return self.outermost(circles, turns.starts, question, finder);
                }
            }
            if distance <= coarse {
                break;
            }
            distance = (distance * FALL).max(coarse);
        }
        if self.circle.terms() <= MOST_TERMS && allowed < coarse {
            let lossy = orbit.model().loss() > 0.0;
            for distance in FINE.into_iter().map(|fine| fine.max(allowed)).filter(|distance| lossy || *distance > 0.0) {
                let Ok(turns) = self.circle.turns(1.0 + distance) else { continue };
                circles.insert(0, (distance, turns.outside));
                if turns.outside > 0 {
                    return self.outermost(circles, turns.starts, question, finder);
                }
                break;
            }
        }
        let most = circles.first().map_or(f64::INFINITY, |(distance, _)| *distance);
        if most > allowed && (most.is_infinite() || 2 * orbit.model().chain().sites() <= MAX_DIMENSION) {
            return Err(SecularError::Tangency.into());
        }
        Ok((Verdict::none_outside(least, most, tolerance), Vec::new()))
    }

    /// The verdict on the outermost multiplier, one of those outside the first circle; none is outside the others, if there are any.
    fn outermost(
        &mut self,
        mut circles: Circles,
        mut starts: Vec<Complex<f64>>,
        question: Question<'_>,
        finder: &mut Finder,
    ) -> Result<(Verdict, Vec<Complex<f64>>), Failure> {
        let prepared = finder.prepared(question.orbit)?;
        let (mut found, mut wanted) = (0, 0);
        for _ in 0..MOST_CIRCLES {
            self.forced.settle_distinct(prepared, starts.drain(..));
            // Those of the outermost circle that has any are enough.
            let Some(last) = circles.iter().rposition(|(_, outside)| *outside > 0) else { break };
            let distance = circles[last].0;
            wanted = circles[last].1;
            let (values, errors) = self.forced.multipliers();
            let all = || values.iter().zip(errors).map(|(value, error)| (*value, excess(*value), *error));
            let beyond = || all().filter(|(_, growth, error)| *growth > distance + error);
            found = beyond().map(|(value, ..)| if value.im == 0.0 { 1 } else { 2 }).sum();
            let leading: Option<Outermost> = beyond().max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((leading, growth, error)) = leading.filter(|_| found == wanted) {
                // Another one that may lead is as good.
                let error = beyond().map(|(_, other, reach)| other + reach - growth).fold(error, f64::max);
                check(growth, error, question)?;
                return Ok((Verdict::of_growth(leading, growth, error, question.tolerance), Vec::new()));
            }
            // From nearer to them.
            let above = circles.get(last + 1).map(|(above, _)| *above);
            let nearer = above.map_or(distance / FALL, |above| (distance.max(LEAST * above) * above).sqrt());
            if above.is_some_and(|above| above < nearer * NEAREST || above < CLOSEST) {
                break;
            }
            let turns = self.circle.turns(1.0 + nearer)?;
            circles.insert(last + 1, (nearer, turns.outside));
            starts = turns.starts;
        }
        Err(SecularError::Incomplete { found, wanted }.into())
    }
}
