//! Verdicts from the secular form: what it says of an orbit, its own error and those that the orbit's data bring along,
//! held against the tolerance.

use nalgebra::Complex;
use vibrochain_breather::{Finder, Prepared, Sketch};
use vibrochain_lattice::Model;

use crate::analyser::{Analyser, Failure};
use crate::dense::{Dense, WORTH_A_MATRIX};
use crate::error::FloquetError;
use crate::saltation::saltations;
use crate::secular::{
    ForcedSecular, Leading, MOST_IMPACTS, Meetings, Nu, SecularError, SecularVerdict, Standing, excess, meetings,
};
use crate::verdict::{Mechanism, Question, Tolerance, Verdict};

/// Errors of the leading multiplier beyond this part of it are left to a dense solver: next to coincident poles that has smaller
/// ones. (Estimates are cautious there, by two to three digits.)
const WORST: f64 = 1e-10;

/// As [`WORST`], for a sweep, whose cells are not worth as much.
const WORST_OF_SWEEP: f64 = 1e-9;

/// Modes of a map's cell up to which a dense matrix is done as soon as the impacts' equations are; of 21 it takes twice as long.
const SOON_DONE: usize = 16;

/// Passes of one mode that multipliers of elastic impacts may cost which are to be told apart: seconds.
const BUDGET: usize = 250_000_000;

/// Room for what estimated errors leave out where an answer hangs on them.
const ROOM: f64 = 4.0;

impl Analyser {
    pub(crate) fn reversible(&mut self, question: Question<'_>, finder: &mut Finder) -> Result<Verdict, Failure> {
        let orbit = question.orbit;
        let _ = saltations(orbit)?;
        let ratio_error = ratio_error(question, finder)?;
        let ratio = self.secular.residues.take_over(finder.prepared(orbit)?, ratio_error)?;
        if !question.thorough && self.secular.residues.all_positive(ratio) {
            return Ok(Verdict::on_circle(None));
        }
        if question.thorough {
            // All multipliers of a large ring take as much room again.
            finder.give_back();
        }
        self.secular.residues.complete(ratio)?;
        let found = self.secular.verdict();
        let modes = orbit.model().chain().even_modes();
        let imprecise = |growth, error| !question.thorough && check(growth, error, question).is_err();
        let found = found.map(|verdict| match imprecise(verdict.growth, verdict.growth_error) {
            // Of more modes the impacts' equations know it better.
            true if modes <= SOON_DONE => self.secular.settled(verdict, orbit.period()),
            _ => verdict,
        });
        let doubtful = |growth, error| modes > SOON_DONE && imprecise(growth, error);
        let open = match &found {
            Ok(verdict) => verdict.outcome == Standing::Marginal || doubtful(verdict.growth, verdict.growth_error),
            Err(SecularError::Imprecise { growth, growth_error }) if doubtful(*growth, *growth_error) => true,
            // A dense matrix knows of other ways, unless it would take too long.
            Err(_) => modes > WORTH_A_MATRIX,
        };
        if open && let Ok(verdict) = self.told_apart(question, finder) {
            return Ok(verdict);
        }
        let found = found?;
        if found.outcome == Standing::Unstable {
            check(found.growth, found.growth_error, question)?;
        }
        Ok(told(&found, question.tolerance))
    }

    /// The verdict on a breather of which there is only a sketch, as [`Analyser::verdict`] has it of the orbit; `None` where only the
    /// orbit can tell: next to where its errors matter or to the border of stability, and how its symmetry breaks.
    ///
    /// ```
    /// use vibrochain_breather::{Family, Finder, Sketched};
    /// use vibrochain_floquet::{Analyser, Tolerance};
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 0.8, 0.4)?;
    /// let mut finder = Finder::new(21);
    /// let Sketched::One(sketch) = finder.sketch(&model, Family::SingleSided) else { panic!() };
    /// let verdict = Analyser::default().sketch_verdict(&model, &sketch, Tolerance::Rounding).unwrap();
    /// assert!(!verdict.stable && (verdict.spectral_radius - 2.797574412183362).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sketch_verdict(&mut self, model: &Model, sketch: &Sketch<'_>, tolerance: Tolerance) -> Option<Verdict> {
        let ratio = match *sketch.impulses() {
            _ if self.dense_only => return None,
            [_] => None,
            [first, second] if !sketch.is_delicate() => {
                Some((second / first, rounding_of_ratio([first, second].into_iter())))
            }
            _ => return None,
        };
        self.secular.residues.take_over_ring(sketch.response());
        if self.secular.residues.all_positive(ratio) {
            return Some(Verdict::on_circle(None));
        }
        self.secular.residues.complete(ratio).ok()?;
        let mut found = self.secular.verdict().ok().filter(|verdict| verdict.outcome != Standing::Marginal)?;
        let modes = model.chain().even_modes();
        let is_precise = |found: &SecularVerdict| {
            found.outcome == Standing::Stable || is_precise(found.growth, found.growth_error, modes, WORST_OF_SWEEP)
        };
        if modes <= SOON_DONE && !is_precise(&found) {
            found = self.secular.settled(found, sketch.response().period());
        }
        let (verdict, precise) = (told(&found, tolerance), is_precise(&found));
        // Of an orbit without asymmetry this may be a pitchfork.
        let open = verdict.mechanism == Some(Mechanism::PlusOne) && model.asymmetry() == 0.0;
        Some(verdict).filter(|_| precise && !open)
    }

    /// A verdict that hangs on the errors of residues next to coincident poles: the multipliers are settled by the impacts' equations,
    /// which know nothing of these.
    fn told_apart(&mut self, question: Question<'_>, finder: &mut Finder) -> Result<Verdict, Failure> {
        let orbit = question.orbit;
        let condition = finder.condition(orbit)?;
        let both = |(nu, error): (Nu, f64)| {
            let growth = nu.growth();
            let relative = nu.growth_error(growth, error) / (1.0 + growth) + 4.0 * f64::EPSILON;
            nu.multipliers().map(|mu| (mu, relative * mu.norm()))
        };
        self.forced.adopt(orbit, &condition, self.secular.all_nu()?.flat_map(both), None);
        elastic(&mut self.forced, finder.prepared(orbit)?, question)
    }

    /// The verdict on a matrix's eigenvalues after the impacts' equations have settled those that matter: next to a resonance errors of the
    /// matrix say next to nothing. `None` where the equations know no better.
    pub(crate) fn settled_from_matrix(
        &mut self,
        Question { orbit, tolerance, .. }: Question<'_>,
        finder: &mut Finder,
        by_matrix: &Verdict,
    ) -> Result<Option<Verdict>, FloquetError> {
        if orbit.is_reversible() || orbit.impact_site().is_none() || orbit.impacts().len() > MOST_IMPACTS {
            return Ok(None);
        }
        let condition = finder.condition(orbit)?;
        let Dense { values, reach, rounding, .. } = &self.dense;
        self.forced.adopt(orbit, &condition, values.iter().map(|value| (*value, *reach)), Some(*rounding));
        let prepared = finder.prepared(orbit)?;
        self.forced.settle_apart(prepared);
        let settled = if orbit.model().loss() == 0.0 {
            Some(told_from_circle(&mut self.forced, prepared).verdict(&self.forced, tolerance))
        } else {
            let leading = self.forced.leading(prepared);
            leading.map(|Leading { place, growth, error }| {
                settle(self.forced.multipliers().0, place, growth, error, tolerance)
            })
        };
        Ok(settled.filter(|verdict| verdict.resolution < by_matrix.resolution))
    }

    pub(crate) fn not_reversible(&mut self, question: Question<'_>, finder: &mut Finder) -> Result<Verdict, Failure> {
        let Question { orbit, tolerance, thorough } = question;
        let _ = saltations(orbit)?;
        let careful = thorough || finder.is_delicate(orbit)?;
        self.forced.solve(finder.prepared(orbit)?)?;
        if careful {
            let condition = finder.condition(orbit)?;
            self.forced.add_errors_of(finder.prepared(orbit)?, &condition)?;
        }
        let prepared = finder.prepared(orbit)?;
        if orbit.model().loss() == 0.0 {
            return elastic(&mut self.forced, prepared, question);
        }
        let leading = self.forced.leading(prepared);
        let Some(Leading { place, growth, error }) = leading else { return Err(SecularError::NotReversible.into()) };
        check(growth, error, question)?;
        Ok(settle(self.forced.multipliers().0, place, growth, error, tolerance))
    }
}

/// Error of the ratio of the impulses at the two instants of a reversible orbit, relative: all that the form takes from the orbit.
pub(crate) fn ratio_error(question: Question<'_>, finder: &mut Finder) -> Result<f64, FloquetError> {
    let impacts = question.orbit.impacts();
    Ok(if question.orbit.instants().nth(1).is_none() {
        0.0
    } else if question.thorough || finder.is_delicate(question.orbit)? {
        let condition = finder.condition(question.orbit)?;
        let relative = impacts.iter().zip(&condition.impacts).map(|(i, error)| error.impulse / i.impulse);
        relative.map(f64::abs).sum()
    } else {
        rounding_of_ratio(impacts.iter().map(|impact| impact.impulse))
    })
}

/// What rounding of impulses makes of the ratio of any two of them, relative.
fn rounding_of_ratio(impulses: impl Iterator<Item = f64>) -> f64 {
    let extremes = |(least, most): (f64, f64), impulse: f64| (least.min(impulse.abs()), most.max(impulse.abs()));
    let (least, most) = impulses.fold((f64::INFINITY, 0.0), extremes);
    4.0 * f64::EPSILON * most / least
}

/// What the secular function says, held against the tolerance.
pub(crate) fn told(found: &SecularVerdict, tolerance: Tolerance) -> Verdict {
    match (found.outcome, found.leading) {
        (Standing::Unstable, Some(leading)) => Verdict::of_growth(leading, found.growth, found.growth_error, tolerance),
        (Standing::Marginal, Some(leading)) => Verdict::unsettled(leading, found.growth, found.growth_error, tolerance),
        _ => Verdict::on_circle(None),
    }
}

/// An error that a dense solver would beat is a doubt.
pub(crate) fn check(growth: f64, error: f64, question: Question<'_>) -> Result<(), Failure> {
    let worst = if question.thorough { WORST } else { WORST_OF_SWEEP };
    if is_precise(growth, error, question.orbit.model().chain().even_modes(), worst) {
        Ok(())
    } else {
        Err(SecularError::Imprecise { growth, growth_error: error }.into())
    }
}

/// Not a number is not.
fn is_precise(growth: f64, error: f64, modes: usize, worst: f64) -> bool {
    modes > WORTH_A_MATRIX || error <= worst * (2.0 + growth)
}

/// The verdict on a leading multiplier.
fn settle(values: &[Complex<f64>], place: usize, growth: f64, error: f64, tolerance: Tolerance) -> Verdict {
    let leading = values.get(place).copied().unwrap_or(Complex::new(1.0, 0.0));
    let leading = if leading.im.abs() <= error { Complex::new(leading.re, 0.0) } else { leading };
    Verdict::of_growth(leading, growth, error, tolerance)
}

/// What is known of the multipliers of elastic impacts: place, growth and error of the one that is surely the farthest outside the
/// circle, and the places of those that may have met and left it, if they could be farther outside.
struct Elastic {
    leading: Option<(usize, f64, f64)>,
    met: Vec<usize>,
}

impl Elastic {
    /// The verdict; those that may have met count as far outside as they can be.
    fn verdict(&self, forced: &ForcedSecular, tolerance: Tolerance) -> Verdict {
        let (values, errors) = forced.multipliers();
        let growth = self.leading.map_or(0.0, |(_, growth, _)| growth);
        let farthest = self.met.iter().map(|&place| excess(values[place]).max(0.0) + ROOM * errors[place] - growth);
        let open = farthest.fold(0.0, f64::max);
        match (self.leading, self.met.first()) {
            (Some((place, growth, error)), _) => settle(values, place, growth, error.max(open), tolerance),
            (None, Some(&place)) => Verdict::unsettled(values[place], excess(values[place]).max(0.0), open, tolerance),
            (None, None) => Verdict::on_circle(values.first().copied()),
        }
    }
}

/// The verdict on elastic impacts, where no pair may have met and the error is of use: else a doubt.
fn elastic(forced: &mut ForcedSecular, prepared: Prepared<'_>, question: Question<'_>) -> Result<Verdict, Failure> {
    let told = told_from_circle(forced, prepared);
    // A pair that may have met is a question of matrices and their eigenvectors.
    if !told.met.is_empty() {
        return Err(SecularError::Tangency.into());
    }
    if let Some((_, growth, error)) = told.leading {
        check(growth, error, question)?;
    }
    Ok(told.verdict(forced, question.tolerance))
}

/// Elastic impacts: a multiplier comes with 1/μ̄, so that one next to the circle that has no other near lies on it exactly.
fn told_from_circle(forced: &mut ForcedSecular, prepared: Prepared<'_>) -> Elastic {
    let most = BUDGET / prepared.orbit().model().chain().even_modes();
    let mut settled = 0;
    loop {
        let (values, errors) = forced.multipliers();
        let outside = values.iter().zip(errors).enumerate().map(|(place, (z, error))| (place, excess(*z), *error));
        let leading = outside.filter(|(_, growth, error)| *growth > ROOM * error).max_by(|a, b| a.1.total_cmp(&b.1));
        // Those that matter first get the errors they deserve.
        if let Some((place, ..)) = leading.filter(|(place, ..)| forced.is_open(*place) && settled < most) {
            settled += 1;
            forced.settle(place, prepared, true);
            continue;
        }
        let Meetings { places: mut met, pairs } = meetings(values, errors, ROOM);
        // What cannot be farther outside than the leading one does not matter.
        let rivals =
            |place: usize| leading.is_none_or(|(_, growth, _)| excess(values[place]) + ROOM * errors[place] > growth);
        met.retain(|place| rivals(*place));
        // To settle a multiplier, and its mirror image, parts two pairs at most: of more than that some would be left.
        let left = most.saturating_sub(settled);
        if pairs.iter().filter(|(one, other)| rivals(*one) || rivals(*other)).count() > 2 * left {
            return Elastic { leading, met };
        }
        let open: Vec<usize> = met.iter().copied().filter(|place| forced.is_open(*place)).take(left).collect();
        if !open.is_empty() && settled < most {
            settled += open.len();
            for place in open {
                if forced.is_open(place) {
                    forced.settle(place, prepared, true);
                }
            }
            continue;
        }
        return Elastic { leading, met };
    }
}
