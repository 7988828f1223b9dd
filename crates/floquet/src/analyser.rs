//! From an orbit to its multipliers and verdict, along the path that fits its structure:
//!
//! | orbit | path |
//! |---|---|
//! | conservative, mirror image of itself in time | [`crate::Secular`]: real poles and residues in ν = ½(μ + 1/μ) |
//! | the same, two sites that a reflection exchanges | [`crate::Secular`] of their sum and of their difference, or of half a period |
//! | other impacts at one site | [`crate::SecularMultipliers`] |
//! | a mass without coupling | its 2 × 2 matrix, what comes of it settled by the impacts' equations |
//! | reversible words of other sites on a lattice of more than 1000 masses | inertia of the secular matrix: a count |
//! | impacts at several sites under a force or with losses or at other times, on such a lattice | turns of the secular function: a count |
//! | other impacts at several sites, and whatever the secular form doubts | dense matrix |
//! | the same where the matrix leaves the verdict open, as next to double multipliers | `spectrum`: all zeros of the impacts' determinant |
//!
//! Every answer names its path, see [`Method`].

use nalgebra::Complex;
use vibrochain_breather::{BreatherError, Finder, Orbit};

use crate::all_multipliers::{Multipliers, Spared};
use crate::aside::aside;
use crate::dense::{Dense, WORTH_A_MATRIX, is_reduced, uncoupled};
use crate::error::FloquetError;
use crate::monodromy::MAX_DIMENSION;
use crate::secular::{ForcedSecular, Inertia, MOST_IMPACTS, OutsideCircle, Pair, Partners, Secular, SecularError};
use crate::spectrum::spectrum;
use crate::symmetry::{breaks_symmetry, is_symmetric};
use crate::verdict::{Mechanism, Method, Question, Tolerance, Verdict};

/// Multipliers and verdict of one orbit.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Stability {
    /// The verdict; its [`Verdict::method`] is that of the multipliers, too.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub verdict: Verdict,
    /// The multipliers of the whole lattice, by falling modulus, then by argument; the trivial pair of a conservative
    /// orbit and the modes that feel no impact included. None of a word of several sites on a lattice of more than 1000 masses, with or
    /// without force and losses, which are counted only, unless two sites mirror each other.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::plain::complexes"))]
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
    turns_only: bool,
    pub(crate) dense: Dense,
    pub(crate) secular: Secular,
    pub(crate) partners: Partners,
    pub(crate) inertia: Inertia,
    pub(crate) circle: OutsideCircle,
    pub(crate) forced: ForcedSecular,
}

/// Why the secular form has no answer.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A dense solver may have one.
    SecularError(SecularError),
    /// Nor has a dense solver.
    Floquet(FloquetError),
}

impl From<SecularError> for Failure {
    fn from(doubt: SecularError) -> Self {
        Self::SecularError(doubt)
    }
}

impl<E: Into<FloquetError>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Floquet(error.into())
    }
}

impl Analyser {
    /// An analyser that takes the dense path whatever the orbit: the reference that the secular form is held against.
    pub fn dense() -> Self {
        Self { dense_only: true, ..Self::default() }
    }

    /// An analyser that counts the multipliers of words of several sites that have a force or losses however small the lattice is, to hold
    /// the count against a matrix.
    pub fn counting() -> Self {
        Self { turns_only: true, ..Self::default() }
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
        self.decide(Question { orbit, tolerance, thorough: false }, finder).map(|(verdict, _)| verdict)
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
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4, 0.1, 0.9)?;
    /// let found = breathers(&model, Family::DoubleSided)?;
    /// let (mut analyser, mut finder) = (Analyser::default(), Finder::new(21));
    /// // Spectral radii 1.0016 and 2.7.
    /// let mut beyond = |i: usize, reach: f64| analyser.surely_exceeds(&found.orbits[i], &mut finder, reach);
    /// assert!(!beyond(0, 1.0)? && beyond(1, 1.0)? && beyond(1, 2.5)? && !beyond(1, 2.8)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn surely_exceeds(&mut self, orbit: &Orbit, finder: &mut Finder, reach: f64) -> Result<bool, FloquetError> {
        let asked = !self.dense_only
            && !orbit.model().is_conservative()
            && orbit.impact_site().is_some()
            && !uncoupled(orbit)
            && orbit.impacts().len() <= MOST_IMPACTS;
        let beyond = asked && self.forced.is_beyond(finder.prepared(orbit)?, BEYOND * reach);
        Ok(beyond && !finder.is_delicate(orbit)?)
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
        let (verdict, found) = self.decide(Question { orbit, tolerance, thorough: true }, finder)?;
        let counted = is_counted(orbit) || self.turns(orbit);
        if verdict.method == Method::Secular && Pair::of(orbit).is_none() && counted {
            return Ok(Multipliers::new(verdict, found, 0, Spared::default()));
        }
        let trivial = if orbit.model().is_conservative() { 2 } else { 0 };
        let spared = if uncoupled(orbit) {
            let chain = orbit.model().chain();
            Spared::new(orbit.period(), (1..chain.sites()).map(|mode| (mode, chain.gamma1().sqrt())))
        } else if verdict.method == Method::Secular || is_reduced(orbit) {
            Spared::of(orbit)
        } else {
            Spared::default()
        };
        Ok(Multipliers::new(verdict, found, trivial, spared))
    }

    /// The non-trivial multipliers of the space that feels impacts, where the secular form vouches for them.
    pub(crate) fn secular_multipliers(
        &mut self,
        orbit: &Orbit,
        finder: &mut Finder,
    ) -> Result<Vec<Complex<f64>>, Failure> {
        if orbit.centre().is_none() || uncoupled(orbit) && orbit.model().chain().sites() > 1 {
            return Err(SecularError::NotReversible.into());
        }
        let question = Question { orbit, tolerance: Tolerance::Rounding, thorough: true };
        self.by_secular_function(question, finder).map(|(_, multipliers)| multipliers)
    }

    /// Verdict and, if `thorough`, the non-trivial multipliers of the space that feels impacts.
    fn decide(
        &mut self,
        question: Question<'_>,
        finder: &mut Finder,
    ) -> Result<(Verdict, Vec<Complex<f64>>), FloquetError> {
        if !takes_long(question) {
            return self.decide_here(question, finder);
        }
        let Question { orbit, tolerance, thorough } = question;
        let (stop, sites, orbit) = (finder.stop().clone(), orbit.model().chain().sites(), orbit.clone());
        let mut theirs = (std::mem::take(self), std::mem::replace(finder, Finder::new(sites)));
        let done = aside(&stop, move || {
            let (analyser, finder) = &mut theirs;
            let answer = analyser.decide_here(Question { orbit: &orbit, tolerance, thorough }, finder);
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

    fn decide_here(
        &mut self,
        question: Question<'_>,
        finder: &mut Finder,
    ) -> Result<(Verdict, Vec<Complex<f64>>), FloquetError> {
        let (mut verdict, multipliers) = self.by_multipliers(question, finder)?;
        let orbit = question.orbit;
        if verdict.mechanism == Some(Mechanism::PlusOne)
            && is_symmetric(orbit)
            && breaks_symmetry(finder.prepared(orbit)?, &verdict)
        {
            verdict.mechanism = Some(Mechanism::Pitchfork);
        }
        Ok((verdict, multipliers))
    }

    fn by_multipliers(
        &mut self,
        question: Question<'_>,
        finder: &mut Finder,
    ) -> Result<(Verdict, Vec<Complex<f64>>), FloquetError> {
        let Question { orbit, thorough, .. } = question;
        let alone = uncoupled(orbit);
        let secular = !self.dense_only && orbit.impact_site().is_some() && !alone;
        let other = !self.dense_only && !secular && !orbit.model().chain().is_uncoupled();
        let pair = if other { Pair::of(orbit) } else { None };
        let counted = other && pair.is_none() && is_counted(orbit);
        let turning = other && pair.is_none() && !counted && self.turns(orbit);
        let mut doubt = None;
        if secular || pair.is_some() || counted || turning {
            let answer = match pair {
                Some(pair) => self.by_partners(pair, question, finder),
                // What is left over by one count another one may have.
                None if counted => match self.by_inertia(question, finder) {
                    Err(Failure::SecularError(why)) if beyond_half_a_matrix(orbit) => {
                        match self.by_turns(question, finder) {
                            Err(Failure::SecularError(_)) => Err(why.into()),
                            answer => answer,
                        }
                    }
                    answer => answer,
                },
                None if turning => self.by_turns(question, finder),
                None => self.by_secular_function(question, finder),
            };
            match answer {
                Ok(answer) => return Ok(answer),
                Err(Failure::Floquet(error)) => return Err(error),
                Err(Failure::SecularError(why)) => doubt = Some(why),
            }
        }
        if let Some(doubt) = doubt {
            let chain = orbit.model().chain();
            let modes = if is_reduced(orbit) { chain.even_modes() } else { chain.sites() };
            let dimension = if orbit.is_reversible() { modes } else { 2 * modes };
            if dimension > MAX_DIMENSION {
                return Err(FloquetError::InDoubt { doubt, dimension, limit: MAX_DIMENSION });
            }
        }
        let verdict = self.dense.judge(question, finder)?;
        let method = Method::Dense(doubt);
        let tried = doubt.is_some() || alone && !self.dense_only;
        let open = tried && verdict.resolution > 0.0 && (thorough || verdict.marginal);
        if open && let Some(settled) = self.settled_from_matrix(question, finder, &verdict)? {
            let multipliers = if thorough { self.forced.symmetric_multipliers() } else { Vec::new() };
            return Ok((Verdict { method, ..settled }, multipliers));
        }
        // Double multipliers, which a matrix splits, the impacts' equations know as such. What they say is held against the matrix.
        if verdict.marginal
            && !self.dense_only
            && orbit.model().chain().sites() <= WORTH_A_MATRIX
            && let Ok(answer) = spectrum(question, finder)?
            && answer.verdict.is_within(&verdict)
        {
            let better = answer.verdict;
            return Ok((better, if thorough { answer.listed(orbit) } else { Vec::new() }));
        }
        let multipliers = if thorough { self.dense.multipliers(orbit) } else { Vec::new() };
        Ok((Verdict { method, ..verdict }, multipliers))
    }

    /// A word whose multipliers are counted along circles.
    fn turns(&self, orbit: &Orbit) -> bool {
        let worth = self.turns_only || orbit.model().chain().sites() > WORTH_A_MATRIX;
        worth && orbit.impact_site().is_none() && !orbit.is_reversible()
    }

    fn by_secular_function(
        &mut self,
        question: Question<'_>,
        finder: &mut Finder,
    ) -> Result<(Verdict, Vec<Complex<f64>>), Failure> {
        let thorough = question.thorough;
        if question.orbit.is_reversible() {
            let verdict = self.reversible(question, finder)?;
            if !thorough {
                return Ok((verdict, Vec::new()));
            }
            let multipliers: Vec<_> = self.secular.all_nu()?.flat_map(|(nu, _)| nu.multipliers()).collect();
            // Where none leads, one that is there.
            let leading = multipliers.first().filter(|_| verdict.growth() == 0.0).copied();
            return Ok((Verdict { leading: leading.unwrap_or(verdict.leading), ..verdict }, multipliers));
        }
        let verdict = self.not_reversible(question, finder)?;
        Ok((verdict, if thorough { self.forced.symmetric_multipliers() } else { Vec::new() }))
    }
}

/// How far beyond a spectral radius another is looked for that is surely larger: no poles are near there, and no verdict's error is as
/// large.
const BEYOND: f64 = 1.05;

/// Masses beyond which all multipliers, or the verdict on a word of several sites, may take a tenth of a second.
const QUICK: usize = 256;

/// What may take longer than a look at a request to stop may be away.
fn takes_long(Question { orbit, thorough, .. }: Question<'_>) -> bool {
    let chain = orbit.model().chain();
    chain.sites() > QUICK && (thorough || orbit.impact_site().is_none() || !chain.is_kept())
}

/// A word without force that inertia leaves open, on a lattice so large that turns are counted sooner than a matrix of half the size is
/// reduced: up to some 2000 masses that is a matter of seconds, and along the unit circle, where most multipliers of elastic impacts are,
/// turns take minutes.
fn beyond_half_a_matrix(orbit: &Orbit) -> bool {
    orbit.model().chain().sites() > 2000
}

/// Terms that a count may sum up in one pass over the gaps: some seconds, of which there may be some.
const MOST_TERMS: f64 = 2e10;

/// A word of several sites without force on a lattice so large that its multipliers are counted, and none is worked out that does not
/// decide.
fn is_counted(orbit: &Orbit) -> bool {
    let chain = orbit.model().chain();
    let terms = || {
        let sites = orbit.hit_sites().len() as f64;
        let pairs = 0.5 * sites * (sites - 1.0) + if chain.is_ring() { 1.0 } else { sites };
        (chain.even_modes() as f64).powi(2) * 6.0 * pairs
    };
    orbit.is_reversible()
        && orbit.impact_site().is_none()
        && !chain.is_uncoupled()
        && chain.sites() > WORTH_A_MATRIX
        && terms() <= MOST_TERMS
}

/// Multipliers and verdict of an orbit: the one-shot form of [`Analyser::stability`].
///
/// # Errors
/// [`FloquetError`].
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
    let sites = orbit.model().chain().sites();
    Analyser::default().stability(orbit, &mut Finder::new(sites), tolerance)
}
