//! Verdicts from the secular form: what it says of an orbit, its own error and those that the orbit's data bring along,
//! held against the tolerance.

use nalgebra::Complex;
use vibrochain_breather::{Finder, Orbit};
use vibrochain_lattice::ImpulseResponse;

use crate::analyser::{Analyser, Failure};
use crate::saltation::saltations;
use crate::secular::{Doubt, ForcedSecular, Leading, MOST_SETTLED, Outcome, excess, meetings};
use crate::verdict::{Tolerance, Verdict};

/// Errors of the leading multiplier beyond this part of it are left to a dense solver: next to coincident poles that has smaller
/// ones. (Estimates are cautious there, by two to three digits.)
const WORST: f64 = 1e-10;

/// As [`WORST`], for a sweep, whose cells are not worth as much.
const WORST_OF_SWEEP: f64 = 1e-9;

/// Number of modes beyond which no matrix is set up for a few digits more: it would take minutes.
const WORTH_A_MATRIX: usize = 1000;

/// Room for what estimated errors leave out where an answer hangs on them.
const ROOM: f64 = 4.0;

impl Analyser {
    pub(crate) fn reversible(
        &mut self,
        orbit: &Orbit,
        finder: &mut Finder,
        tolerance: Tolerance,
        thorough: bool,
    ) -> Result<Verdict, Failure> {
        let _ = saltations(orbit)?;
        // All that the form takes from the orbit is the ratio of its impulses.
        let ratio_error = if orbit.impacts().len() < 2 {
            0.0
        } else if thorough || finder.is_delicate(orbit)? {
            let condition = finder.condition(orbit)?;
            let relative = orbit.impacts().iter().zip(&condition.impacts).map(|(i, error)| error.impulse / i.impulse);
            relative.map(f64::abs).sum()
        } else {
            let sizes = orbit.impacts().iter().map(|impact| impact.impulse.abs());
            let (least, most) =
                sizes.fold((f64::INFINITY, 0.0_f64), |(least, most), size| (least.min(size), most.max(size)));
            4.0 * f64::EPSILON * most / least
        };
        let response = finder.response_to(orbit)?;
        self.secular.set_within(orbit, response, ratio_error)?;
        let found = self.secular.verdict()?;
        Ok(match (found.outcome, found.leading) {
            (Outcome::Unstable, Some(leading)) => {
                check(found.growth, found.growth_error, thorough, orbit)?;
                Verdict::of_growth(leading, found.growth, found.growth_error, tolerance)
            }
            (Outcome::Marginal, Some(leading)) => {
                Verdict::unsettled(leading, found.growth, found.growth_error, tolerance)
            }
            _ => Verdict::on_circle(None),
        })
    }

    pub(crate) fn not_reversible(
        &mut self,
        orbit: &Orbit,
        finder: &mut Finder,
        tolerance: Tolerance,
        thorough: bool,
    ) -> Result<Verdict, Failure> {
        let _ = saltations(orbit)?;
        let careful = thorough || finder.is_delicate(orbit)?;
        self.forced.solve(orbit, finder.response_to(orbit)?)?;
        if careful {
            let condition = finder.condition(orbit)?;
            self.forced.add_errors_of(orbit, &condition, finder.response())?;
        }
        let response = finder.response();
        if orbit.model().loss() == 0.0 {
            return elastic(&mut self.forced, orbit, response, tolerance, thorough);
        }
        let leading = self.forced.leading(orbit, response);
        let Some(Leading { place, growth, error }) = leading else { return Err(Doubt::NotReversible.into()) };
        check(growth, error, thorough, orbit)?;
        Ok(settle(self.forced.multipliers().0, place, growth, error, tolerance))
    }
}

/// An error that a dense solver would beat is a doubt.
fn check(growth: f64, error: f64, thorough: bool, orbit: &Orbit) -> Result<(), Failure> {
    if orbit.model().chain().even_modes() > WORTH_A_MATRIX {
        return Ok(());
    }
    // Not a number is a doubt, too.
    let precise = error <= if thorough { WORST } else { WORST_OF_SWEEP } * (2.0 + growth);
    if precise { Ok(()) } else { Err(Doubt::Imprecise { growth, growth_error: error }.into()) }
}

/// The verdict on a leading multiplier.
fn settle(values: &[Complex<f64>], place: usize, growth: f64, error: f64, tolerance: Tolerance) -> Verdict {
    let leading = values.get(place).copied().unwrap_or(Complex::new(1.0, 0.0));
    let leading = if leading.im.abs() <= error { Complex::new(leading.re, 0.0) } else { leading };
    Verdict::of_growth(leading, growth, error, tolerance)
}

/// Elastic impacts: a multiplier comes with 1/μ̄, so that one next to the circle that has no other near lies on it exactly.
fn elastic(
    forced: &mut ForcedSecular,
    orbit: &Orbit,
    response: &ImpulseResponse,
    tolerance: Tolerance,
    thorough: bool,
) -> Result<Verdict, Failure> {
    let mut settled = 0;
    loop {
        let (values, errors) = forced.multipliers();
        let met = meetings(values, errors, ROOM);
        let outside = values.iter().zip(errors).enumerate().map(|(place, (z, error))| (place, excess(*z), *error));
        let leading = outside.filter(|(_, growth, error)| *growth > ROOM * error).max_by(|a, b| a.1.total_cmp(&b.1));
        // Those that matter first get the errors they deserve.
        let matter = met.iter().copied().chain(leading.map(|(place, ..)| place));
        let open: Vec<usize> = matter.filter(|place| forced.is_open(*place)).take(MOST_SETTLED).collect();
        if !open.is_empty() && settled < MOST_SETTLED {
            settled += open.len();
            for place in open {
                if forced.is_open(place) {
                    forced.settle(place, orbit, response, true);
                }
            }
            continue;
        }
        // A pair that may have met is a question of matrices and their eigenvectors.
        if !met.is_empty() {
            return Err(Doubt::Tangency.into());
        }
        let (values, _) = forced.multipliers();
        return match leading {
            Some((place, growth, error)) => {
                check(growth, error, thorough, orbit)?;
                Ok(settle(values, place, growth, error, tolerance))
            }
            None => Ok(Verdict::on_circle(values.first().copied())),
        };
    }
}
