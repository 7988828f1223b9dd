//! Stability of orbits of any linear structure: all multipliers from J(z). Those of an orbit without losses that is its own mirror image in
//! time, with impacts at one contact, come from the modes as that contact feels them, unless these leave something open.

use nalgebra::Complex;
use vibrochain_breather::{BreatherError, ContactOrbit};
use vibrochain_lattice::aside;

use crate::all_multipliers::{Multipliers, Spared};
use crate::analyser::Analyser;
use crate::error::FloquetError;
use crate::structures::multipliers::BlochProblem;
use crate::verdict::{Tolerance, Verdict};

/// All multipliers of an orbit, and what they say. A conservative orbit's trivial pair 1, 1 is among them, and the 1 of a self-excited one. Where
/// the orbit's own errors have no bound, as next to a fold, or are too large for the multipliers' to have one, the verdict is undecided and its
/// [`Verdict::resolution`] not finite.
pub(crate) fn multipliers(orbit: &ContactOrbit, tolerance: Tolerance) -> Result<Multipliers, FloquetError> {
    heard(orbit, move |orbit| {
        let known = BlochProblem::of(orbit);
        let (verdict, mut found) = known.all(tolerance)?;
        found.extend(known.spared().iter().flatten().map(|rate| known.multiplier(*rate)));
        let trivial = if orbit.is_conservative() { 2 } else { usize::from(orbit.is_self_excited()) };
        Ok(Multipliers::new(verdict, found, trivial, Spared::default()))
    })
}

/// Modes times impacts from which on the work on multipliers, which does not look at a request to stop, may take longer than whoever stops waits.
const LONG: usize = 128;

fn is_long(orbit: &ContactOrbit) -> bool {
    orbit.model().structure().modes().len() * orbit.impacts().len() >= LONG
}

/// Does work on an orbit's multipliers: no longer than until its model's request to stop is raised.
fn heard<T: Send + 'static>(
    orbit: &ContactOrbit,
    work: impl FnOnce(&ContactOrbit) -> Result<T, FloquetError> + Send + 'static,
) -> Result<T, FloquetError> {
    if !is_long(orbit) {
        return work(orbit);
    }
    let (stop, orbit) = (orbit.model().stop().clone(), orbit.clone());
    aside(&stop, move || work(&orbit)).map_err(BreatherError::from)?
}

/// The multipliers of the modes that the orbit's impacts feel, and the verdict on all; none where no bound of its error is known, as along folds.
pub(crate) fn participating_multipliers(
    orbit: &ContactOrbit,
    tolerance: Tolerance,
) -> Result<(Vec<Complex<f64>>, Option<Verdict>), FloquetError> {
    heard(orbit, move |orbit| {
        let (verdict, multipliers) = BlochProblem::of(orbit).all(tolerance)?;
        Ok((multipliers, verdict.resolution.is_finite().then_some(verdict)))
    })
}

impl BlochProblem<'_> {
    /// The verdict, in the work space of an analyser.
    ///
    /// # Errors
    /// [`FloquetError::Uncounted`] where the multipliers could not be told apart and counted.
    pub fn verdict(&self, analyser: &mut Analyser, tolerance: Tolerance) -> Result<Verdict, FloquetError> {
        self.decided(analyser, tolerance, false)
    }

    /// The same for a map: what errors of the orbit's data add to the spectral radius's is worked out only where it could show.
    ///
    /// # Errors
    /// [`FloquetError::Uncounted`] where the multipliers could not be told apart and counted.
    pub fn quick_verdict(&self, analyser: &mut Analyser, tolerance: Tolerance) -> Result<Verdict, FloquetError> {
        self.decided(analyser, tolerance, true)
    }

    fn decided(&self, analyser: &mut Analyser, tolerance: Tolerance, quick: bool) -> Result<Verdict, FloquetError> {
        let reversible = self.orbit.reversible();
        if let Some(verdict) = reversible.and_then(|orbit| analyser.structure_reversible(&orbit, tolerance)) {
            return Ok(verdict);
        }
        if is_long(self.orbit) {
            return heard(self.orbit, move |orbit| BlochProblem::of(orbit).worked_out(tolerance, quick));
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
