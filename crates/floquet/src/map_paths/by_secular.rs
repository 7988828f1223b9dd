//! Verdicts from the secular form: what it says of an orbit, its own error and those that the orbit's data bring along,
//! held against the tolerance.

use nalgebra::Complex;
use vibrochain_breather::{Finder, MapBreather, MapOrbit, ReversibleOrbit};
use vibrochain_lattice::Model;

use crate::analyser::Analyser;
use crate::error::FloquetError;
use crate::map_paths::reversible::verdict::stable;
use crate::map_paths::{Reason, Secular, SecularVerdict, Standing};
use crate::saltation::saltations;
use crate::sizes::{MOST_DENSE, is_affordable, most_refined};
use crate::spectrum::{SpectralFunction, origins};
use crate::verdict::{Mechanism, Question, Tolerance, Verdict};
use crate::zeros::{Nu, excess};

/// A leading multiplier whose error is beyond this part of it is left to the impacts' equations: next to coincident poles they know it
/// better. (Estimates are cautious there, by two to three digits.)
const WORST: f64 = 1e-10;

/// As [`WORST`], for a sweep, whose cells are not worth as much.
const WORST_OF_SWEEP: f64 = 1e-9;

/// Other multipliers are first worked out to this part of the leading excess, which takes most of them one step.
const CLOSE: f64 = 1e-3;

/// Room for what estimated errors leave out where an answer hangs on them.
const ROOM: f64 = 4.0;

impl Analyser {
    /// The verdict from residues; `None` where these leave it open, or have larger errors than other ways.
    pub(crate) fn reversible(
        &mut self,
        question: Question<'_>,
        finder: &mut Finder,
    ) -> Result<Option<Verdict>, FloquetError> {
        let orbit = question.orbit;
        let _ = saltations(&orbit)?;
        let ratio_error = ratio_error(question, finder)?;
        let Some(ratio) = self.secular.residues.take_over(finder.prepared(orbit.orbit())?, ratio_error) else {
            return Ok(None);
        };
        if !question.thorough && self.secular.residues.all_positive(ratio) {
            return Ok(Some(Verdict::on_circle(None)));
        }
        if question.thorough {
            // All multipliers of a large ring take as much room again.
            finder.give_back();
        }
        if self.secular.residues.complete(ratio).is_err() {
            return Ok(None);
        }
        let Ok(mut found) = self.secular.verdict() else { return Ok(None) };
        let (modes, worst) =
            (orbit.model().chain().even_modes(), if question.thorough { WORST } else { WORST_OF_SWEEP });
        let is_precise = |found: &SecularVerdict| is_precise(found.excess, found.excess_error, modes, worst);
        if !question.thorough && !is_precise(&found) {
            found = self.secular.refined(found, orbit.period());
        }
        if found.outcome == Standing::Undecided {
            if is_affordable(orbit) {
                return Ok(None);
            }
            if let Some(verdict) = self.refined_leading(question, finder)? {
                return Ok(Some(verdict));
            }
        }
        let is_open = found.outcome == Standing::Unstable && !is_precise(&found);
        Ok((!is_open).then(|| told(&found, question.tolerance)))
    }

    /// The verdict on a large ring that errors of residues leave open, where the impacts' equations say that a multiplier is outside the
    /// circle: those that may lead are refined, as far as another one may be beyond them.
    fn refined_leading(
        &mut self,
        question: Question<'_>,
        finder: &mut Finder,
    ) -> Result<Option<Verdict>, FloquetError> {
        let orbit = question.orbit;
        let Ok(all) = self.secular.all_nu() else { return Ok(None) };
        let refined_at_most = most_refined(orbit.model().chain().even_modes());
        let mut open: Vec<(f64, Complex<f64>)> = all
            .map(|(nu, error)| (nu.excess() + nu.excess_error(nu.excess(), error), nu.multipliers()[0]))
            .filter(|(most, value)| *most > 0.0 && value.im >= 0.0)
            .collect();
        open.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        // Of those that are left with the errors they have the first one tells how far outside they may be.
        open.truncate(refined_at_most + 1);
        open.shrink_to_fit();
        // The finder's modes have done their part: their memory is free for what follows.
        finder.give_back();
        let known = finder.at_contacts(&orbit)?;
        let errors = known.error_origins().to_vec();
        let equations = known.into_bloch_equations();
        let data = origins(&equations, &errors);
        let function = SpectralFunction::taking(equations, true);
        let settled = |start: Complex<f64>| function.refine(start, &data).map(|refined| (refined.z, refined.error));
        // The one that seems to lead comes first: of most others a step says then that they do not.
        let seeming = open.iter().take(refined_at_most).enumerate();
        let first = seeming.max_by(|(_, (_, a)), (_, (_, b))| excess(*a).total_cmp(&excess(*b)));
        let mut leading = first.and_then(|(_, (_, value))| settled(*value));
        let first = first.map(|(number, _)| number).filter(|_| leading.is_some());
        // How far outside one may be that could not be refined.
        let mut unrefined: f64 = 0.0;
        for (number, (most, value)) in open.iter().enumerate() {
            let surely = leading.map_or(0.0, |(z, error)| excess(z) - ROOM * error);
            if surely >= *most || number == refined_at_most {
                unrefined = unrefined.max(*most);
                break;
            }
            if Some(number) == first {
                continue;
            }
            let step = (surely > 0.0).then(|| function.refine_to(CLOSE * surely, *value, &data)).flatten();
            if step.is_some_and(|step| excess(step.z) + ROOM * step.error <= surely) {
                continue;
            }
            let refined = settled(step.map_or(*value, |step| step.z));
            if refined.is_none() {
                unrefined = unrefined.max(*most);
            }
            let farther = |(z, _): &(Complex<f64>, f64)| leading.is_none_or(|(other, _)| excess(*z) > excess(other));
            leading = refined.filter(farther).or(leading);
        }
        let told = leading.filter(|(z, error)| excess(*z) > ROOM * error);
        Ok(told.map(|(z, error)| {
            let error = error.max(unrefined - excess(z));
            Verdict::of_excess(z, excess(z), error, question.tolerance)
        }))
    }

    /// The verdict on a structure's orbit; `None` where its errors leave it open, matter to it, or are larger than those of other ways.
    pub(crate) fn structure_reversible(
        &mut self,
        orbit: &ReversibleOrbit<'_>,
        tolerance: Tolerance,
    ) -> Option<Verdict> {
        let ratio = self.secular.residues.take_over_structure(orbit)?;
        let found = self.secular.found(ratio, (orbit.period, orbit.modes.len()))?;
        Some(told(&found, tolerance)).filter(|verdict| !verdict.hangs_on_rounding(true, tolerance))
    }

    /// The same with all multipliers of the modes that the contact feels but the trivial pair; `None`, too, next to ±1, and where two pairs may have
    /// met.
    pub(crate) fn structure_multipliers(
        &mut self,
        orbit: &ReversibleOrbit<'_>,
        tolerance: Tolerance,
    ) -> Option<(Verdict, Vec<Complex<f64>>)> {
        let verdict = self.structure_reversible(orbit, tolerance)?;
        let mut multipliers = Vec::with_capacity(2 * orbit.modes.len());
        // A screen of signs may have spared the rest.
        for (nu, error) in self.all_nu_of(orbit)? {
            let excess = nu.excess();
            if nu.excess_error(excess, error) > WORST * (1.0 + excess) {
                return None;
            }
            multipliers.extend(nu.multipliers());
        }
        let are_all = self.secular.roots.touching.is_empty() && multipliers.len() + 2 == 2 * orbit.modes.len();
        are_all.then_some((verdict, multipliers))
    }

    /// ν = ½(μ + 1/μ) of the pairs of a structure's orbit; `None` where their residues do not tell.
    pub(crate) fn structure_half_sums(&mut self, orbit: &ReversibleOrbit<'_>) -> Option<Vec<Complex<f64>>> {
        Some(self.all_nu_of(orbit)?.map(|(nu, _)| nu.complex()).collect())
    }

    /// The same with bounds of their errors.
    fn all_nu_of(&mut self, orbit: &ReversibleOrbit<'_>) -> Option<impl Iterator<Item = (Nu, f64)> + '_> {
        let ratio = self.secular.residues.take_over_structure(orbit)?;
        self.secular.residues.complete(ratio).ok()?;
        self.secular.all_nu().ok()
    }

    /// The verdict on a [`MapOrbit`], as [`Analyser::verdict`] has it of the orbit; `None` where only the orbit can tell: where residues leave it
    /// open, and next to the border of stability.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use vibrochain_breather::{Finder, MapSearch, LoadedStructure};
    /// use vibrochain_floquet::{Analyser, Tolerance};
    /// use vibrochain_lattice::{Contact, LinearMode, ModalStructure, ModeShape};
    /// let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
    /// let mode = LinearMode::oscillator(0.0, 1.0, &shape, &[]);
    /// let stop = Contact { lower: Some(-1.0), upper: Some(0.7), restitution: 1.0 };
    /// let structure = Arc::new(ModalStructure::new(vec![stop], vec![], vec![mode])?);
    /// let model = LoadedStructure::new(structure, 1.5)?;
    /// let MapSearch::One(orbit) = Finder::default().map_orbit(&model, &"0+,0-".parse()?, 1) else { panic!() };
    /// // The pair 1, 1 is all there is.
    /// assert!(Analyser::default().map_orbit_verdict(&orbit, Tolerance::Rounding).unwrap().stable);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn map_orbit_verdict(&mut self, orbit: &MapOrbit, tolerance: Tolerance) -> Option<Verdict> {
        self.structure_reversible(&orbit.reversible()?, tolerance)
    }

    /// The verdict on a [`MapBreather`], as [`Analyser::verdict`] has it of the orbit; `None` where only the
    /// orbit can tell: next to where its errors matter or to the border of stability, and how its symmetry breaks.
    ///
    /// ```
    /// use vibrochain_breather::{Family, Finder, MapSearch};
    /// use vibrochain_floquet::{Analyser, Tolerance};
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 0.8, 0.4)?;
    /// let mut finder = Finder::new(21);
    /// let MapSearch::One(breather) = finder.map_breather(&model, Family::SingleSided) else { panic!() };
    /// let verdict = Analyser::default().map_verdict(&model, &breather, Tolerance::Rounding).unwrap();
    /// assert!(!verdict.stable && (verdict.spectral_radius - 2.797574412183362).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn map_verdict(&mut self, model: &Model, breather: &MapBreather<'_>, tolerance: Tolerance) -> Option<Verdict> {
        let ratio = match *breather.impulses() {
            _ if self.dense_only => return None,
            [_] => None,
            [first, second] if !breather.is_delicate() => {
                Some((second / first, rounding_of_ratio([first, second].into_iter())))
            }
            _ => return None,
        };
        self.secular.residues.take_over_ring(breather.response());
        let (period, modes) = (breather.response().period(), model.chain().even_modes());
        let found = self.secular.found(ratio, (period, modes))?;
        let verdict = told(&found, tolerance);
        // Of an orbit without asymmetry this may be a pitchfork.
        let open = verdict.mechanism == Some(Mechanism::PlusOne) && model.asymmetry() == 0.0;
        Some(verdict).filter(|verdict| !open && !verdict.hangs_on_rounding(true, tolerance))
    }
}

impl Secular {
    /// The verdict alone on the modes taken over, of impulses with this ratio, a period and so many modes: signs of residues first. `None` where
    /// residues leave it open, or have larger errors than other ways.
    fn found(&mut self, ratio: Option<(f64, f64)>, (period, modes): (f64, usize)) -> Option<SecularVerdict> {
        if self.residues.all_positive(ratio) {
            return Some(stable(Reason::EqualResidueSigns));
        }
        self.residues.complete(ratio).ok()?;
        let mut found = self.verdict().ok()?;
        let is_precise = |found: &SecularVerdict| {
            found.outcome != Standing::Unstable || is_precise(found.excess, found.excess_error, modes, WORST_OF_SWEEP)
        };
        if !is_precise(&found) {
            found = self.refined(found, period);
        }
        (found.outcome != Standing::Undecided && is_precise(&found)).then_some(found)
    }
}

/// Error of the ratio of the impulses at the two instants of a reversible orbit, relative: all that the form takes from the orbit.
fn ratio_error(question: Question<'_>, finder: &mut Finder) -> Result<f64, FloquetError> {
    let impacts = question.orbit.impacts();
    Ok(if question.orbit.instants().nth(1).is_none() {
        0.0
    } else if question.thorough || finder.is_delicate(&question.orbit)? {
        let condition = finder.condition(&question.orbit)?;
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
fn told(found: &SecularVerdict, tolerance: Tolerance) -> Verdict {
    match (found.outcome, found.leading) {
        (Standing::Unstable, Some(leading)) => Verdict::of_excess(leading, found.excess, found.excess_error, tolerance),
        (Standing::Undecided, Some(leading)) => {
            Verdict::unsettled(leading, found.excess, found.excess_error, tolerance)
        }
        _ => Verdict::on_circle(None),
    }
}

/// Whether no other way would have smaller errors, of the impacts' equations that say something. Not a number is not.
fn is_precise(excess: f64, error: f64, modes: usize, worst: f64) -> bool {
    2 * modes > MOST_DENSE || error <= worst * (2.0 + excess)
}
