//! Stability of orbits of any linear structure: all multipliers from J(z). Those of an orbit without losses that is its own mirror image in
//! time, with impacts at one contact, come from the modes as that contact feels them, unless these leave something open.

use nalgebra::Complex;
use vibrochain_breather::{BreatherError, StructureOrbit};
use vibrochain_lattice::aside;

use crate::analyser::{Analyser, Stability};
use crate::error::FloquetError;
use crate::structures::multipliers::StructureMultipliers;
use crate::verdict::{Tolerance, Verdict};

/// All multipliers of an orbit of a structure, and what they say. A conservative orbit's trivial pair 1, 1 is among them, and the 1 of a
/// self-excited one. Where the orbit's own
/// errors have no bound, as next to a fold, or are too large for the multipliers' to have one, the verdict is undecided and its
/// [`Verdict::resolution`] not finite.
///
/// # Errors
/// [`FloquetError::Uncounted`] where the multipliers could not be told apart and counted.
///
/// ```
/// use std::sync::Arc;
/// use vibrochain_breather::StructureModel;
/// use vibrochain_floquet::{Tolerance, structure_stability};
/// use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};
/// // q″ + 0.1 q′ + q = cos ωt, a stop at 0.1.
/// let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
/// let mode = LinearMode::oscillator(0.05, 1.0 - 0.05 * 0.05, &shape, &[Complex::new(1.0, 0.0)]);
/// let stop = Contact { lower: None, upper: Some(0.1), restitution: 0.8 };
/// let structure = Arc::new(ModalStructure::new(vec![stop], vec![1], vec![mode])?);
/// let model = StructureModel::new(structure, 2.325)?;
/// let found = model.orbits(&"0+".parse()?, 1)?;
/// let stable = found.orbits.iter().map(|orbit| structure_stability(orbit, Tolerance::Rounding));
/// let radii = stable.map(|answer| Ok(answer?.verdict.spectral_radius)).collect::<Result<Vec<_>, Box<dyn std::error::Error>>>()?;
/// assert!(radii.iter().any(|radius| (radius - 0.6988872749041013).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn structure_stability(orbit: &StructureOrbit, tolerance: Tolerance) -> Result<Stability, FloquetError> {
    heard(orbit, move |orbit| stability(orbit, tolerance))
}

/// All of it here and now.
fn stability(orbit: &StructureOrbit, tolerance: Tolerance) -> Result<Stability, FloquetError> {
    let known = StructureMultipliers::of(orbit);
    let (verdict, mut multipliers) = known.all(tolerance)?;
    multipliers.extend(known.spared().iter().flatten().map(|rate| known.multiplier(*rate)));
    let own = if orbit.is_conservative() { 2 } else { usize::from(orbit.is_self_excited()) };
    multipliers.extend(std::iter::repeat_n(Complex::new(1.0, 0.0), own));
    multipliers.sort_by(|a, b| b.norm().total_cmp(&a.norm()).then(b.im.total_cmp(&a.im)));
    Ok(Stability { verdict, multipliers })
}

/// The verdict of [`structure_stability`] alone.
///
/// # Errors
/// As [`structure_stability`].
pub fn structure_verdict(orbit: &StructureOrbit, tolerance: Tolerance) -> Result<Verdict, FloquetError> {
    StructureMultipliers::of(orbit).verdict(&mut Analyser::default(), tolerance)
}

/// Modes times impacts from which on the work on multipliers, which does not look at a request to stop, may take longer than whoever stops waits.
const LONG: usize = 128;

fn is_long(orbit: &StructureOrbit) -> bool {
    orbit.model().structure().modes().len() * orbit.impacts().len() >= LONG
}

/// Does work on an orbit's multipliers: no longer than until its model's request to stop is raised.
fn heard<T: Send + 'static>(
    orbit: &StructureOrbit,
    work: impl FnOnce(&StructureOrbit) -> Result<T, FloquetError> + Send + 'static,
) -> Result<T, FloquetError> {
    if !is_long(orbit) {
        return work(orbit);
    }
    let (stop, orbit) = (orbit.model().stop().clone(), orbit.clone());
    aside(&stop, move || work(&orbit)).map_err(BreatherError::from)?
}

/// The multipliers of the modes that the orbit's impacts feel, and the verdict on all; none where no bound of its error is known, as along folds.
pub(crate) fn participating_multipliers(
    orbit: &StructureOrbit,
    tolerance: Tolerance,
) -> Result<(Vec<Complex<f64>>, Option<Verdict>), FloquetError> {
    heard(orbit, move |orbit| {
        let (verdict, multipliers) = StructureMultipliers::of(orbit).all(tolerance)?;
        Ok((multipliers, verdict.resolution.is_finite().then_some(verdict)))
    })
}

impl StructureMultipliers<'_> {
    /// The verdict of [`structure_stability`], in the work space of an analyser.
    ///
    /// # Errors
    /// As [`structure_stability`].
    pub fn verdict(&self, analyser: &mut Analyser, tolerance: Tolerance) -> Result<Verdict, FloquetError> {
        self.decided(analyser, tolerance, false)
    }

    /// The same for a map: what errors of the orbit's data add to the spectral radius's is worked out only where it could show.
    ///
    /// # Errors
    /// As [`structure_stability`].
    pub fn quick_verdict(&self, analyser: &mut Analyser, tolerance: Tolerance) -> Result<Verdict, FloquetError> {
        self.decided(analyser, tolerance, true)
    }

    fn decided(&self, analyser: &mut Analyser, tolerance: Tolerance, quick: bool) -> Result<Verdict, FloquetError> {
        let reversible = self.orbit.reversible();
        if let Some(verdict) = reversible.and_then(|orbit| analyser.structure_reversible(&orbit, tolerance)) {
            return Ok(verdict);
        }
        if is_long(self.orbit) {
            return heard(self.orbit, move |orbit| StructureMultipliers::of(orbit).worked_out(tolerance, quick));
        }
        self.worked_out(tolerance, quick)
    }

    /// The same with the multipliers of the modes that the impacts feel.
    fn all(&self, tolerance: Tolerance) -> Result<(Verdict, Vec<Complex<f64>>), FloquetError> {
        let reversible = self.orbit.reversible();
        let known = reversible.and_then(|orbit| Analyser::default().structure_multipliers(&orbit, tolerance));
        known.map_or_else(|| self.all_worked_out(tolerance), Ok)
    }
}

#[cfg(test)]
mod tests;
