//! Stability of orbits of any linear structure: all multipliers from J(z), no other way.

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_breather::{BlochEquations, Condition, ImpactError, StructureImpact, StructureOrbit, Together};

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
    let conservative = orbit.is_conservative();
    let (equations, spared) = orbit.bloch_equations();
    let answer = as_well_as_known(orbit, &equations, |data| told(&equations, conservative, data, tolerance));
    let (mut verdict, mut multipliers) = answer.map_err(FloquetError::Uncounted)?;
    for pair in spared {
        let both = pair.map(|rate| (rate * orbit.period()).exp());
        multipliers.extend(both);
        verdict = with_spared(verdict, pair, both, tolerance);
    }
    if conservative {
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
    decided(orbit, &orbit.bloch_equations(), tolerance)
}

/// The same of an orbit whose spectral radius is not surely beyond `reach`: `None` says that a real multiplier is, by 5 %, and none is worked out.
/// A map asks so: of two orbits that are born in a fold one has such a multiplier, and a sign takes a small part of what a verdict takes.
///
/// # Errors
/// As [`structure_stability`].
pub fn structure_verdict_within(
    orbit: &StructureOrbit,
    reach: f64,
    tolerance: Tolerance,
) -> Result<Option<Verdict>, FloquetError> {
    let equations = orbit.bloch_equations();
    if !orbit.is_conservative() && is_surely_beyond(&equations.0, BEYOND * reach) {
        return Ok(None);
    }
    decided(orbit, &equations, tolerance).map(Some)
}

/// The verdict by the orbit's equations and the rates of the modes that these leave out.
fn decided(
    orbit: &StructureOrbit,
    (equations, spared): &(BlochEquations, Vec<[Complex<f64>; 2]>),
    tolerance: Tolerance,
) -> Result<Verdict, FloquetError> {
    let conservative = orbit.is_conservative();
    let told = as_well_as_known(orbit, equations, |data| verdict(equations, conservative, data, tolerance));
    let told = told.map_err(FloquetError::Uncounted)?;
    let with = |told, pair: &[Complex<f64>; 2]| {
        with_spared(told, *pair, pair.map(|rate| (rate * orbit.period()).exp()), tolerance)
    };
    Ok(spared.iter().fold(told, with))
}

/// The multipliers of the modes that the orbit's impacts feel, and the verdict on all. Along folds errors may have no bound; then the multipliers are
/// told as the orbit stands, with no verdict.
pub(super) fn felt_multipliers(
    orbit: &StructureOrbit,
    tolerance: Tolerance,
) -> Result<(Vec<Complex<f64>>, Option<Verdict>), FloquetError> {
    let (equations, spared) = orbit.bloch_equations();
    let conservative = orbit.is_conservative();
    if let Ok((verdict, multipliers)) =
        as_well_as_known(orbit, &equations, |data| told(&equations, conservative, data, tolerance))
    {
        let both = |pair: &[Complex<f64>; 2]| pair.map(|rate| (rate * orbit.period()).exp());
        let verdict = spared.iter().fold(verdict, |told, pair| with_spared(told, *pair, both(pair), tolerance));
        return Ok((multipliers, Some(verdict)));
    }
    let there = told(&equations, conservative, &[], Tolerance::Rounding).map_err(FloquetError::Uncounted)?;
    Ok((there.1, None))
}

/// What the equations answer, given the errors of the orbit's data. On a fold the equations are singular and these errors have no bound to
/// first order: there the orbit's times and impulses are known to the root of rounding.
fn as_well_as_known<T>(
    orbit: &StructureOrbit,
    equations: &BlochEquations,
    ask: impl Fn(&[Origin]) -> Result<T, SecularError>,
) -> Result<T, SecularError> {
    ask(&data(orbit, equations, f64::INFINITY)).or_else(|_| ask(&data(orbit, equations, ROOT)))
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

/// Of a mode without a dashpot that is spared, the multipliers are on the circle, and decide nothing; nor does the 1 of a motion of the whole
/// that nothing brings back, which is neutral by symmetry: of its pair the other decides.
fn with_spared(verdict: Verdict, pair: [Complex<f64>; 2], both: [Complex<f64>; 2], tolerance: Tolerance) -> Verdict {
    let deciding = pair.into_iter().zip(both).filter(|(rate, _)| rate.re != 0.0).map(|(_, multiplier)| multiplier);
    let Some(leading) = deciding.max_by(|a, b| a.norm().total_cmp(&b.norm())) else { return verdict };
    let error = 8.0 * f64::EPSILON * leading.norm();
    verdict.or_worse(Verdict::of_growth(leading, excess(leading), error, tolerance))
}
