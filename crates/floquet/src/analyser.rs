//! From an orbit to its multipliers and verdict, along the path that fits its structure:
//!
//! | orbit | path |
//! |---|---|
//! | conservative, mirror image of itself in time, impacts at one site | [`crate::Secular`]: real poles and residues in ν = ½(μ + 1/μ) |
//! | a verdict alone, as in maps, on a mirror image of itself in time of few masses, impacts at several sites or open above | eigenvalues of a matrix of half the size |
//! | all others, and whatever these leave open | `spectrum`: all zeros of the determinant of the impacts' equations |
//! | what that cannot count or leaves open, and words of many impacts on some thousand masses | a dense matrix |
//!
//! Every answer names its path, see [`Method`].

use std::sync::Arc;

use nalgebra::Complex;
use vibrochain_breather::{BreatherError, ContactOrbit, Finder, LatticeOrbit, Orbit};
use vibrochain_lattice::aside;

use crate::all_multipliers::{Multipliers, Spared};
use crate::error::FloquetError;
use crate::map_paths::Secular;
use crate::multipliers::unfelt_frequencies;
use crate::reference::dense::{Dense, uncoupled};
use crate::saltation::saltations;
use crate::sizes::{LARGE, MOST_DENSE, is_affordable, most_modes};
use crate::structures::{self, BlochProblem};
use crate::symmetry::{breaks_symmetry, is_symmetric};
use crate::verdict::{Mechanism, Method, Question, Tolerance, Verdict};

/// Multipliers and verdict of one orbit.
#[derive(Debug, Clone, PartialEq)]
pub struct Stability {
    /// The verdict; its [`Verdict::method`] is that of the multipliers, too.
    pub verdict: Verdict,
    /// The multipliers of the whole lattice, by falling modulus, then by argument; the trivial pair of a conservative
    /// orbit and the modes that feel no impact included.
    pub multipliers: Vec<Complex<f64>>,
}

/// Reusable work space for stability analyses.
///
/// ```
/// use vibrochain_breather::{Family, Finder, breathers};
/// use vibrochain_floquet::{Analyser, Method, Tolerance};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 0.8, 0.4)?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let verdict = Analyser::default().verdict(orbit, &mut Finder::new(21), Tolerance::Rounding)?;
/// assert!(!verdict.stable && (verdict.spectral_radius - 2.797574412183362).abs() < 1e-12);
/// assert_eq!(verdict.method, Method::Secular);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Analyser {
    pub(crate) dense_only: bool,
    pub(crate) dense: Dense,
    pub(crate) secular: Secular,
}

/// A verdict and, if they are asked for, the non-trivial multipliers of the space that feels impacts.
pub(crate) type Answer = (Verdict, Vec<Complex<f64>>);

impl Analyser {
    /// An analyser that takes the dense path whatever the orbit: the reference that the secular form is held against.
    pub fn dense() -> Self {
        Self { dense_only: true, ..Self::default() }
    }

    /// The verdict alone: no multiplier that does not decide it is worked out, nothing is sorted.
    ///
    /// # Errors
    /// [`FloquetError`].
    pub fn verdict(
        &mut self,
        orbit: &Orbit,
        finder: &mut Finder,
        tolerance: Tolerance,
    ) -> Result<Verdict, FloquetError> {
        if let Some(contacts) = by_contacts(orbit, finder)? {
            return BlochProblem::of(&contacts).quick_verdict(self, tolerance);
        }
        let lattice = orbit.lattice()?;
        self.decide(Question { orbit: lattice, tolerance, thorough: false }, finder).map(|(verdict, _)| verdict)
    }

    /// Whether the spectral radius is surely beyond `reach`, which is 1 at least, by a twentieth of it or more: a real multiplier is. An
    /// orbit without force or losses, or whose own errors could matter, is not asked, and no says nothing. Takes a small part of what
    /// [`Analyser::verdict`] does.
    ///
    /// # Errors
    /// [`FloquetError`].
    ///
    /// ```
    /// use vibrochain_breather::{Family, Finder, breathers};
    /// use vibrochain_floquet::Analyser;
    /// use vibrochain_lattice::Point;
    /// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    /// let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model()?;
    /// let found = breathers(&model, Family::DoubleSided)?;
    /// let (mut analyser, mut finder) = (Analyser::default(), Finder::new(21));
    /// // Spectral radii 1.0016 and 2.7.
    /// let mut beyond = |i: usize, reach: f64| analyser.surely_exceeds(&found.orbits[i], &mut finder, reach);
    /// assert!(!beyond(0, 1.0)? && beyond(1, 1.0)? && beyond(1, 2.5)? && !beyond(1, 2.8)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn surely_exceeds(&mut self, orbit: &Orbit, finder: &mut Finder, reach: f64) -> Result<bool, FloquetError> {
        if self.dense_only || orbit.is_conservative() || orbit.lattice().is_ok_and(|orbit| !is_affordable(orbit)) {
            return Ok(false);
        }
        Ok(BlochProblem::of(&*finder.at_contacts(orbit)?).surely_exceeds(reach))
    }

    /// The verdict, with its error, and all multipliers.
    ///
    /// # Errors
    /// [`FloquetError`].
    pub fn stability(
        &mut self,
        orbit: &Orbit,
        finder: &mut Finder,
        tolerance: Tolerance,
    ) -> Result<Stability, FloquetError> {
        let all = self.multipliers(orbit, finder, tolerance)?;
        Ok(Stability { verdict: all.verdict, multipliers: all.sorted().collect() })
    }

    /// As [`Analyser::stability`], with the multipliers for one after the other.
    ///
    /// # Errors
    /// [`FloquetError`].
    pub fn multipliers(
        &mut self,
        orbit: &Orbit,
        finder: &mut Finder,
        tolerance: Tolerance,
    ) -> Result<Multipliers, FloquetError> {
        if let Some(contacts) = by_contacts(orbit, finder)? {
            return structures::multipliers(&contacts, tolerance);
        }
        let orbit = orbit.lattice()?;
        let (verdict, found) = self.decide(Question { orbit, tolerance, thorough: true }, finder)?;
        let trivial = if orbit.is_conservative() { 2 } else { 0 };
        let spared = if uncoupled(orbit) {
            let chain = orbit.model().chain();
            Spared::new(orbit.period(), (1..chain.sites()).map(|mode| (mode, chain.gamma1().sqrt())))
        } else if found.len() + trivial < 2 * orbit.model().chain().sites() {
            Spared::of(orbit)
        } else {
            Spared::default()
        };
        Ok(Multipliers::new(verdict, found, trivial, spared))
    }

    /// Verdict and, if `thorough`, the non-trivial multipliers of the space that feels impacts.
    pub(crate) fn decide(&mut self, question: Question<'_>, finder: &mut Finder) -> Result<Answer, FloquetError> {
        if !takes_long(question) {
            return self.decide_here(question, finder);
        }
        let Question { orbit, tolerance, thorough } = question;
        let (stop, sites) = (finder.stop().clone(), orbit.model().chain().sites());
        let orbit = orbit.orbit().clone();
        let mut theirs = (std::mem::take(self), std::mem::replace(finder, Finder::new(sites)));
        let done = aside(&stop, move || {
            let (analyser, finder) = &mut theirs;
            let orbit = orbit.lattice().map_err(FloquetError::from);
            let decide = |orbit| analyser.decide_here(Question { orbit, tolerance, thorough }, finder);
            let answer = orbit.and_then(decide);
            (theirs, answer)
        });
        match done {
            Ok((theirs, answer)) => {
                (*self, *finder) = theirs;
                answer
            }
            Err(stopped) => {
                *finder = Finder::new(sites).until(&stop);
                Err(BreatherError::from(stopped).into())
            }
        }
    }

    fn decide_here(&mut self, question: Question<'_>, finder: &mut Finder) -> Result<Answer, FloquetError> {
        let Question { orbit, tolerance, thorough } = question;
        // Without coupling masses that are hit alike have equal multipliers, and those of masses that are not hit do not count.
        let alike = orbit.impact_site().is_none() && orbit.model().chain().is_uncoupled();
        let thorough = thorough || alike && is_affordable(orbit);
        let (mut verdict, mut multipliers) = self.by_multipliers(Question { thorough, ..question }, finder)?;
        // A map says what the orbit alone would be told.
        let lossless = orbit.model().loss() == 0.0;
        if !thorough && verdict.hangs_on_rounding(lossless, tolerance) && is_affordable(orbit) {
            (verdict, multipliers) = self.by_multipliers(Question { thorough: true, ..question }, finder)?;
        }
        if verdict.mechanism == Some(Mechanism::PlusOne)
            && is_symmetric(&orbit)
            && breaks_symmetry(finder.prepared(orbit.orbit())?, &verdict)
        {
            verdict.mechanism = Some(Mechanism::Pitchfork);
        }
        Ok((verdict, multipliers))
    }

    fn by_multipliers(&mut self, question: Question<'_>, finder: &mut Finder) -> Result<Answer, FloquetError> {
        if self.dense_only {
            return self.by_matrix(question, finder);
        }
        let Question { orbit, thorough, .. } = question;
        let chain = orbit.model().chain();
        let screened = has_residues(orbit) && (!thorough || chain.even_modes() > LARGE);
        if screened && let Some(answer) = self.by_residues(question, finder)? {
            return Ok(answer);
        }
        // A cell of a map of pairs on 21 masses takes 45 µs so, by all zeros of the determinant 560.
        let is_quick = orbit.is_reversible() && (screened || orbit.impact_site().is_none()) && chain.sites() <= LARGE;
        if !thorough && is_quick {
            let answer = self.by_matrix(question, finder)?;
            if !answer.0.undecided {
                return Ok(answer);
            }
        }
        if !is_affordable(orbit) {
            let by_matrix = if orbit.is_reversible() { MOST_DENSE } else { MOST_DENSE / 2 };
            if screened || chain.sites() <= by_matrix {
                return self.by_matrix(question, finder);
            }
            return Err(too_many(orbit, by_matrix));
        }
        let (mut verdict, multipliers) = match by_zeros(question, finder) {
            Err(FloquetError::Uncounted(doubt)) => {
                // Next to grazing multipliers of 10⁵ and more have no digits as zeros of a determinant.
                let answer = self.by_matrix(question, finder);
                let is_large = |error: &FloquetError| matches!(error, FloquetError::TooLarge { .. });
                return answer.map_err(|error| if is_large(&error) { doubt.into() } else { error });
            }
            answer => answer?,
        };
        if verdict.undecided && chain.sites() <= LARGE {
            // Neither is asked twice.
            let asks = !screened && has_residues(orbit);
            let residues = if asks { self.by_residues(question, finder)? } else { None };
            let other = match residues.map(|(verdict, _)| verdict).filter(|verdict| !verdict.undecided) {
                None if thorough || !is_quick => self.by_matrix(question, finder).ok().map(|(verdict, _)| verdict),
                residues => residues,
            };
            verdict = other.filter(|other| !other.undecided).unwrap_or(verdict);
        }
        Ok((verdict, multipliers))
    }

    /// Verdict and multipliers from a dense matrix.
    fn by_matrix(&mut self, question: Question<'_>, finder: &mut Finder) -> Result<Answer, FloquetError> {
        let verdict = self.dense.judge(question, finder)?;
        let multipliers = if question.thorough { self.dense.multipliers(&question.orbit) } else { Vec::new() };
        Ok((Verdict { method: Method::Dense, ..verdict }, multipliers))
    }

    /// Verdict and multipliers from residues; `None` where these leave it open.
    fn by_residues(&mut self, question: Question<'_>, finder: &mut Finder) -> Result<Option<Answer>, FloquetError> {
        let Some(verdict) = self.reversible(question, finder)? else { return Ok(None) };
        if !question.thorough {
            return Ok(Some((verdict, Vec::new())));
        }
        let Ok(all) = self.secular.all_nu() else { return Ok(None) };
        let multipliers: Vec<_> = all.flat_map(|(nu, _)| nu.multipliers()).collect();
        // Where none leads, one that is there.
        let leading = multipliers.first().filter(|_| verdict.excess() == 0.0).copied();
        Ok(Some((Verdict { leading: leading.unwrap_or(verdict.leading), ..verdict }, multipliers)))
    }
}

/// The orbit as contacts know it, where that tells all: of structures, and of lattices with dashpots, for no path of its own knows of these.
fn by_contacts(orbit: &Orbit, finder: &mut Finder) -> Result<Option<Arc<ContactOrbit>>, FloquetError> {
    let lattice = orbit.lattice().ok();
    if lattice.is_some_and(|lattice| !lattice.model().is_damped()) {
        return Ok(None);
    }
    match lattice.filter(|lattice| !is_affordable(*lattice)) {
        Some(lattice) => Err(too_many(lattice, 0)),
        None => Ok(Some(finder.at_contacts(orbit)?)),
    }
}

/// Of an orbit whose multipliers would take too long; a matrix has those of so many masses.
fn too_many(orbit: LatticeOrbit<'_>, by_matrix: usize) -> FloquetError {
    let (masses, impacts) = (orbit.model().chain().sites(), orbit.impacts().len());
    // Of a ring that is hit at one site half of the modes.
    let felt = if orbit.centre().is_some() { 2 * most_modes(impacts) - 1 } else { most_modes(impacts) };
    FloquetError::TooManyModes { masses, impacts, limit: felt.max(by_matrix) }
}

/// Verdict and, if they are asked for, multipliers from all zeros of the determinant of the impacts' equations; of impacts at several sites with those
/// of the modes that none of these feels.
fn by_zeros(
    Question { orbit, tolerance, thorough }: Question<'_>,
    finder: &mut Finder,
) -> Result<Answer, FloquetError> {
    let _ = saltations(&orbit)?;
    let known = finder.at_contacts(&orbit)?;
    let known = BlochProblem::of(&known);
    if !thorough {
        return Ok((known.worked_out(tolerance, true)?, Vec::new()));
    }
    let (verdict, mut multipliers) = known.all_worked_out(tolerance)?;
    if orbit.impact_site().is_none() {
        let both = |frequency: f64| [1.0, -1.0].map(|sign| Complex::from_polar(1.0, sign * frequency * orbit.period()));
        multipliers.extend(unfelt_frequencies(orbit.model().chain(), known.frequencies()).into_iter().flat_map(both));
    }
    Ok((verdict, multipliers))
}

/// Maps and large rings take residues: of orbits without force and losses that are their own mirror images in time, at one site.
fn has_residues(orbit: LatticeOrbit<'_>) -> bool {
    orbit.is_reversible() && orbit.impact_site().is_some() && !orbit.model().chain().is_uncoupled()
}

/// What may take longer than a look at a request to stop may be away.
fn takes_long(Question { orbit, thorough, .. }: Question<'_>) -> bool {
    let chain = orbit.model().chain();
    chain.sites() > LARGE && (thorough || orbit.impact_site().is_none() || !chain.is_kept())
}

/// Multipliers and verdict of an orbit, of a lattice or of any other structure: the one-shot form of [`Analyser::stability`].
///
/// # Errors
/// [`FloquetError`].
///
/// ```
/// use std::sync::Arc;
/// use vibrochain_breather::LoadedStructure;
/// use vibrochain_floquet::{Tolerance, stability};
/// use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};
/// // q″ + 0.1 q′ + q = cos ωt, a stop at 0.1.
/// let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
/// let mode = LinearMode::oscillator(0.05, 1.0 - 0.05 * 0.05, &shape, &[Complex::new(1.0, 0.0)]);
/// let stop = Contact { lower: None, upper: Some(0.1), restitution: 0.8 };
/// let structure = Arc::new(ModalStructure::new(vec![stop], vec![1], vec![mode])?);
/// let found = LoadedStructure::new(structure, 2.325)?.orbits(&"0+".parse()?, 1)?;
/// let radius = |orbit| Ok(stability(orbit, Tolerance::Rounding)?.verdict.spectral_radius);
/// let radii = found.orbits.iter().map(radius).collect::<Result<Vec<f64>, Box<dyn std::error::Error>>>()?;
/// assert!(radii.iter().any(|radius| (radius - 0.6988872749041013).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_floquet::{Mechanism, Tolerance, stability};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 0.93, 0.4)?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let answer = stability(orbit, Tolerance::Rounding)?;
/// assert_eq!(answer.verdict.mechanism, Some(Mechanism::PeriodDoubling));
/// assert_eq!(answer.multipliers.len(), 42);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn stability(orbit: &Orbit, tolerance: Tolerance) -> Result<Stability, FloquetError> {
    Analyser::default().stability(orbit, &mut Finder::default(), tolerance)
}
