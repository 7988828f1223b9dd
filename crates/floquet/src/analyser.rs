//! From an orbit to its multipliers and verdict, along the path that fits its structure:
//!
//! | orbit | matrix | dimension |
//! |---|---|---|
//! | conservative, mirror image of itself in time | `reversible` block | ⌊M/2⌋ |
//! | impacts at one site | even subspace | 2(⌊M/2⌋+1), less the trivial pair |
//! | impacts at several sites | whole ring | 2M, less the trivial pair |
//!
//! The trivial pair μ = 1 of a conservative orbit (the perturbation along the orbit and its canonical partner) is
//! taken out before the eigenvalues are computed, by reflecting the known right and left eigenvectors to the axes.

use nalgebra::Complex;
use vibrochain_breather::{Finder, Orbit};

use crate::eigen::eigenvalues;
use crate::error::FloquetError;
use crate::monodromy::{EvenCoordinates, check_dimension, flow_before_first_impact, full_monodromy};
use crate::multipliers::{odd_multipliers, pair, sort_multipliers};
use crate::reversible::Reversible;
use crate::square::{Reflector, Square};
use crate::verdict::{Tolerance, Verdict};

/// Multipliers and verdict of one orbit.
#[derive(Debug, Clone, PartialEq)]
pub struct Stability {
    /// The verdict.
    pub verdict: Verdict,
    /// The multipliers of the whole ring, by falling modulus, then by argument; the trivial pair of a conservative
    /// orbit and the modes that feel no impact included.
    pub multipliers: Vec<Complex<f64>>,
}

/// Reusable work space for stability analyses.
///
/// ```
/// use vibrochain_breather::{Family, Finder, breathers};
/// use vibrochain_floquet::{Analyser, Tolerance};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 0.8, 0.4)?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let verdict = Analyser::default().verdict(orbit, &mut Finder::new(21), Tolerance::Rounding)?;
/// assert!(!verdict.stable && (verdict.spectral_radius - 2.797574412183362).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Analyser {
    reversible: Reversible,
    coordinates: EvenCoordinates,
    matrix: Square,
    flow: Vec<f64>,
    left: Vec<f64>,
    rows: (Vec<f64>, Vec<f64>),
    reflector: Reflector,
    pub(crate) values: Vec<Complex<f64>>,
}

impl Analyser {
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
        self.judge(orbit, finder, tolerance, false)
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
        let verdict = self.judge(orbit, finder, tolerance, true)?;
        let mut multipliers: Vec<Complex<f64>> = if orbit.is_reversible() {
            self.values.iter().flat_map(|&nu| pair(nu)).collect()
        } else {
            self.values.clone()
        };
        if orbit.model().is_conservative() {
            multipliers.extend([Complex::new(1.0, 0.0); 2]);
        }
        multipliers.extend(odd_multipliers(orbit).unwrap_or_default());
        if uncoupled(orbit) {
            let chain = orbit.model().chain();
            let phase = chain.gamma1().sqrt() * orbit.period();
            let spared = [1.0, -1.0].map(|sign| Complex::from_polar(1.0, sign * phase));
            (1..chain.even_modes()).for_each(|_| multipliers.extend(spared));
        }
        sort_multipliers(&mut multipliers);
        Ok(Stability { verdict, multipliers })
    }

    /// The matrix whose eigenvalues `values` are.
    pub(crate) fn matrix_of(&self, orbit: &Orbit) -> &Square {
        if orbit.is_reversible() { &self.reversible.block } else { &self.matrix }
    }

    /// Fills `values` with the non-trivial multipliers of the space that feels impacts (for a reversible orbit with
    /// their ν) and returns the norm of the matrix.
    pub(crate) fn solve(&mut self, orbit: &Orbit, finder: &mut Finder) -> Result<f64, FloquetError> {
        self.values.clear();
        let chain = orbit.model().chain();
        let alone = uncoupled(orbit);
        if alone && orbit.model().is_conservative() {
            // One mass, whose only pair is the trivial one.
            return Ok(0.0);
        }
        if orbit.is_reversible() {
            check_dimension(chain.even_modes())?;
            self.reversible.build(orbit, finder)?;
            eigenvalues(&self.reversible.block, &mut self.values)?;
            return Ok(self.reversible.block.norm());
        }
        if orbit.impact_site().is_some() {
            check_dimension(2 * chain.even_modes())?;
            finder.motion(orbit)?;
            let response = finder.response();
            let (frequencies, weights) = (response.frequencies(), response.weights());
            match frequencies.first() {
                Some(&frequency) if alone => self.coordinates.set(&[frequency], &[1.0], orbit.frequency()),
                _ => self.coordinates.set(frequencies, weights, orbit.frequency()),
            }
            self.coordinates.monodromy(orbit, &mut self.matrix, (&mut self.rows.0, &mut self.rows.1))?;
        } else {
            self.matrix = full_monodromy(orbit)?;
        }
        let norm = self.matrix.norm();
        if !norm.is_finite() {
            return Err(FloquetError::NotConverged { dimension: self.matrix.size() });
        }
        if orbit.model().is_conservative() {
            self.deflate(orbit, finder)?;
        }
        eigenvalues(&self.matrix, &mut self.values)?;
        Ok(norm)
    }

    /// Removes the trivial pair: M f = f with the flow f, and ωᵀ(f, ·)M = ωᵀ(f, ·) because M keeps the canonical form ω.
    fn deflate(&mut self, orbit: &Orbit, finder: &mut Finder) -> Result<(), FloquetError> {
        let half = self.matrix.size() / 2;
        self.left.clear();
        if orbit.impact_site().is_some() {
            flow_before_first_impact(orbit, finder, &self.coordinates, &mut self.flow)?;
            // ω(f, z) = Σ (f_X z_Y − f_Y z_X)/Ω̃
            let scales = &self.coordinates.scales;
            self.left.extend((0..half).map(|k| -self.flow[k + half] / scales[k]));
            self.left.extend((0..half).map(|k| self.flow[k] / scales[k]));
        } else {
            let motion = finder.motion(orbit)?;
            motion.seek(0, 0.0);
            self.flow.clear();
            self.flow.extend((0..half).map(|n| motion.site(n).velocity));
            self.flow.extend((0..half).map(|n| motion.site(n).acceleration));
            // Several impacts may share the first instant; before it each site is slower by its impulse.
            let first = orbit.impacts().first().map_or(0.0, |impact| impact.time);
            for impact in orbit.impacts().iter().filter(|impact| impact.time == first) {
                self.flow[impact.site] -= impact.impulse;
            }
            self.left.extend((0..half).map(|n| -self.flow[n + half]));
            self.left.extend_from_slice(&self.flow[..half]);
        }
        self.reflector.set(self.flow.iter().copied());
        self.matrix.reflect(&self.reflector);
        self.matrix.drop_first();
        self.reflector.apply(&mut self.left);
        self.reflector.set(self.left.iter().skip(1).copied());
        self.matrix.reflect(&self.reflector);
        self.matrix.drop_first();
        Ok(())
    }
}

/// Coupling, relative to γ₁, that does no more than rounding does: modes are one frequency to a few units in the last place.
const NO_COUPLING: f64 = 32.0 * f64::EPSILON;

/// No coupling that a number could hold: the masses that are not hit swing alone.
fn uncoupled(orbit: &Orbit) -> bool {
    let chain = orbit.model().chain();
    orbit.impact_site().is_some() && 4.0 * chain.gamma2() <= NO_COUPLING * chain.gamma1()
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
