//! Stability of orbits of any linear structure: all multipliers from J(z), no other way.

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_breather::{
    BlochEquations, BreatherError, Condition, ImpactError, StructureImpact, StructureOrbit, Together,
};
use vibrochain_lattice::aside;

use crate::analyser::Stability;
use crate::error::FloquetError;
use crate::spectrum::{BEYOND, Origin, is_surely_beyond, origins, told, verdict};
use crate::verdict::{Tolerance, Verdict};
use crate::zeros::{SecularError, excess};

/// The root of rounding, with room: how well an orbit is known along a fold, relative.
const ROOT: f64 = 1e-7;

/// All multipliers of an orbit of a structure, and what they say. A conservative orbit's trivial pair 1, 1 is among them.
///
/// # Errors
/// [`FloquetError::Uncounted`] where the multipliers could not be told apart and counted.
///
/// ```
/// use std::sync::Arc;
/// use vibrochain_breather::{StructureModel, structure_orbits};
/// use vibrochain_floquet::{Tolerance, structure_stability};
/// use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};
/// // q″ + 0.1 q′ + q = cos ωt, a stop at 0.1.
/// let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
/// let mode = LinearMode::oscillator(0.05, 1.0 - 0.05 * 0.05, &shape, &[Complex::new(1.0, 0.0)]);
/// let stop = Contact { lower: None, upper: Some(0.1), restitution: 0.8 };
/// let structure = Arc::new(ModalStructure::new(vec![stop], vec![1], vec![mode])?);
/// let model = StructureModel::new(structure, 2.325)?;
/// let found = structure_orbits(&model, &"0+".parse()?, 1)?;
/// let stable = found.orbits.iter().map(|orbit| structure_stability(orbit, Tolerance::Rounding));
/// let radii = stable.map(|answer| Ok(answer?.verdict.spectral_radius)).collect::<Result<Vec<_>, Box<dyn std::error::Error>>>()?;
/// assert!(radii.iter().any(|radius| (radius - 0.6988872749040992).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn structure_stability(orbit: &StructureOrbit, tolerance: Tolerance) -> Result<Stability, FloquetError> {
    heard(orbit, move |orbit| stability(orbit, tolerance))
}

/// All of it here and now.
fn stability(orbit: &StructureOrbit, tolerance: Tolerance) -> Result<Stability, FloquetError> {
    let known = StructureMultipliers::of(orbit);
    let (verdict, mut multipliers) = known.all(tolerance)?;
    multipliers.extend(known.spared.iter().flat_map(|pair| known.multipliers_of(pair)));
    if orbit.is_conservative() {
        multipliers.extend([Complex::new(1.0, 0.0); 2]);
    }
    multipliers.sort_by(|a, b| b.norm().total_cmp(&a.norm()).then(b.im.total_cmp(&a.im)));
    Ok(Stability { verdict, multipliers })
}

/// The verdict of [`structure_stability`] alone.
///
/// # Errors
/// As [`structure_stability`].
pub fn structure_verdict(orbit: &StructureOrbit, tolerance: Tolerance) -> Result<Verdict, FloquetError> {
    heard(orbit, move |orbit| StructureMultipliers::of(orbit).verdict(tolerance))
}

/// Modes times impacts from which on the work on multipliers, which does not look at a request to stop, may take longer than whoever stops waits.
const LONG: usize = 128;

/// Does work on an orbit's multipliers: no longer than until its model's request to stop is raised.
fn heard<T: Send + 'static>(
    orbit: &StructureOrbit,
    work: impl FnOnce(&StructureOrbit) -> Result<T, FloquetError> + Send + 'static,
) -> Result<T, FloquetError> {
    if orbit.model().structure().modes().len() * orbit.impacts().len() < LONG {
        return work(orbit);
    }
    let (stop, orbit) = (orbit.model().stop().clone(), orbit.clone());
    aside(&stop, move || work(&orbit)).map_err(BreatherError::from)?
}

/// The multipliers of the modes that the orbit's impacts feel, and the verdict on all. Along folds errors may have no bound; then the multipliers are
/// told as the orbit stands, with no verdict.
pub(super) fn participating_multipliers(
    orbit: &StructureOrbit,
    tolerance: Tolerance,
) -> Result<(Vec<Complex<f64>>, Option<Verdict>), FloquetError> {
    heard(orbit, move |orbit| {
        let known = StructureMultipliers::of(orbit);
        if let Ok((verdict, multipliers)) = known.all(tolerance) {
            return Ok((multipliers, Some(verdict)));
        }
        let there = told(&known.equations, orbit.is_conservative(), &[], Tolerance::Rounding);
        Ok((there.map_err(FloquetError::Uncounted)?.1, None))
    })
}

/// An orbit with its equations J(z), from which all that is asked of its multipliers is told.
#[derive(Debug)]
pub struct StructureMultipliers<'a> {
    orbit: &'a StructureOrbit,
    equations: BlochEquations,
    /// The rates of the modes that these leave out.
    spared: Vec<[Complex<f64>; 2]>,
}

impl<'a> StructureMultipliers<'a> {
    /// Of an orbit.
    #[must_use]
    pub fn of(orbit: &'a StructureOrbit) -> Self {
        let (equations, spared) = orbit.bloch_equations();
        Self { orbit, equations, spared }
    }

    /// Whether the spectral radius is surely beyond `reach`: a real multiplier is, by 5 %. No says nothing. A map asks so: of two orbits that are
    /// born in a fold one has such a multiplier, and a sign takes a small part of what a verdict takes.
    #[must_use]
    pub fn surely_exceeds(&self, reach: f64) -> bool {
        !self.orbit.is_conservative() && is_surely_beyond(&self.equations, BEYOND * reach)
    }

    /// The verdict of [`structure_stability`].
    ///
    /// # Errors
    /// As [`structure_stability`].
    pub fn verdict(&self, tolerance: Tolerance) -> Result<Verdict, FloquetError> {
        let conservative = self.orbit.is_conservative();
        let felt = self.as_well_as_known(|data| verdict(&self.equations, conservative, data, tolerance))?;
        Ok(self.with_spared(felt, tolerance))
    }

    /// The same with the multipliers of the modes that the impacts feel.
    fn all(&self, tolerance: Tolerance) -> Result<(Verdict, Vec<Complex<f64>>), FloquetError> {
        let conservative = self.orbit.is_conservative();
        let (felt, multipliers) = self.as_well_as_known(|data| told(&self.equations, conservative, data, tolerance))?;
        Ok((self.with_spared(felt, tolerance), multipliers))
    }

    /// What the equations answer, given the errors of the orbit's data. On a fold the equations are singular and these errors have no bound to
    /// first order: there the orbit's times and impulses are known to the root of rounding.
    fn as_well_as_known<T>(&self, ask: impl Fn(&[Origin]) -> Result<T, SecularError>) -> Result<T, FloquetError> {
        let data = |most| data(self.orbit, &self.equations, most);
        ask(&data(f64::INFINITY)).or_else(|_| ask(&data(ROOT))).map_err(FloquetError::Uncounted)
    }

    fn multipliers_of(&self, pair: &[Complex<f64>; 2]) -> [Complex<f64>; 2] {
        pair.map(|rate| (rate * self.orbit.period()).exp())
    }

    /// Of a mode without a dashpot that is spared, the multipliers are on the circle, and decide nothing; nor does the 1 of a motion of the whole
    /// that nothing brings back, which is neutral by symmetry: of its pair the other decides.
    fn with_spared(&self, verdict: Verdict, tolerance: Tolerance) -> Verdict {
        self.spared.iter().fold(verdict, |verdict, pair| {
            let both = pair.iter().zip(self.multipliers_of(pair));
            let deciding = both.filter(|(rate, _)| rate.re != 0.0).map(|(_, multiplier)| multiplier);
            let Some(leading) = deciding.max_by(|a, b| a.norm().total_cmp(&b.norm())) else { return verdict };
            let error = 8.0 * f64::EPSILON * leading.norm();
            verdict.or_worse(Verdict::of_excess(leading, excess(leading), error, tolerance))
        })
    }
}

/// What the orbit's errors do to J(z), each no larger than this part of the largest time, impulse and acceleration.
fn data(orbit: &StructureOrbit, equations: &BlochEquations, most: f64) -> Vec<Origin> {
    let impacts = orbit.impacts();
    let apart = |i: usize, error: ImpactError| {
        let mut origin: Together = SmallVec::from_elem(ImpactError::default(), impacts.len());
        origin[i] = error;
        origin
    };
    let largest = |of: fn(&StructureImpact) -> f64| most * impacts.iter().map(|one| of(one).abs()).fold(0.0, f64::max);
    let impulses = largest(|impact| impact.impulse);
    let accelerations = largest(|impact| impact.acceleration_before);
    let each = impacts.iter().enumerate().flat_map(|(i, impact)| {
        let none = ImpactError::default();
        [
            apart(i, ImpactError { time: impact.time_error.min(most * orbit.period()), ..none }),
            apart(i, ImpactError { impulse: impact.impulse_error.min(impulses), ..none }),
            apart(i, ImpactError { acceleration: impact.acceleration_error.min(accelerations), ..none }),
        ]
    });
    origins(equations, &Condition { origins: each.collect(), ..Condition::default() })
}
