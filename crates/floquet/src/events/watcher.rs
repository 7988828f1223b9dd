//! Who looks at orbits along a branch or a curve.

use nalgebra::Complex;
use vibrochain_breather::{Admissibility, BranchError, BreatherError, ContactOrbit, Finder, Orbit};

use super::by_matrix;
use super::half_sums::half_sums;
use super::mirrored;
use crate::analyser::Analyser;
use crate::error::FloquetError;
use crate::locate::Evidence;
use crate::locate::LocateError;
use crate::structures::{BlochProblem, participating_multipliers};
use crate::verdict::{Mechanism, Tolerance, Verdict};
use crate::zeros::Nu;

/// A contact no farther beyond a barrier than this part of what it moves by touches it.
pub(crate) const TOUCHES: f64 = 1e-9;

/// An orbit whose impulses have grown by this factor is on its way to infinity.
pub(crate) const UNBOUNDED: f64 = 1e4;

/// Impulses this small, against the first, are on their way to none.
pub(crate) const FAINT: f64 = 1e-9;

/// A multiplier farther than this from where it should be is not the zero of the function.
const POLE: f64 = 1e-4;

/// Multipliers, and the verdict if it comes with them.
pub(crate) type Spectrum = (Vec<Complex<f64>>, Option<Verdict>);

/// The largest impulse of an orbit.
pub(crate) fn strongest(orbit: &ContactOrbit) -> f64 {
    orbit.impacts().iter().map(|impact| impact.impulse.abs()).fold(0.0, f64::max)
}

/// An orbit of a branch with all bounds of its errors that are known.
pub(crate) fn bounded(orbit: &ContactOrbit) -> ContactOrbit {
    orbit.clone().with_bounds().unwrap_or_else(|_| orbit.clone())
}

/// Looks at orbits.
#[derive(Debug, Default)]
pub(crate) struct Watcher {
    spectra: usize,
    analyser: Analyser,
    finder: Finder,
}

impl Watcher {
    /// Whether an orbit is physical, and what is nearest to a barrier.
    pub(crate) fn admissibility(&mut self, orbit: &ContactOrbit) -> Result<Admissibility, LocateError> {
        Ok(orbit.admissibility().map_err(BranchError::from)?)
    }

    /// Multipliers of the modes that feel the impacts; without losses ν = ½(μ + 1/μ) of each pair.
    pub(crate) fn spectrum(&mut self, orbit: &ContactOrbit, tolerance: Tolerance) -> Result<Spectrum, LocateError> {
        self.spectra += 1;
        let reversible = orbit.reversible().filter(|_| orbit.is_lossless());
        if let Some(values) = reversible.and_then(|orbit| self.analyser.structure_half_sums(&orbit)) {
            return Ok((values, None));
        }
        if let Some(values) = mirrored::half_sums(orbit) {
            return Ok((values, None));
        }
        let (multipliers, verdict) = match participating_multipliers(orbit, tolerance) {
            Err(FloquetError::Uncounted(doubt)) if orbit.is_lossless() => {
                let all = by_matrix::multipliers(&orbit.bloch_equations().0, orbit.is_conservative());
                (all.ok_or(FloquetError::Uncounted(doubt))?, None)
            }
            told => told?,
        };
        let values = if orbit.is_lossless() { half_sums(&multipliers) } else { multipliers };
        Ok((values, verdict))
    }

    /// The multiplier of an orbit that is at `goal`, if there is one.
    pub(crate) fn multiplier_at(
        &mut self,
        orbit: &ContactOrbit,
        goal: Complex<f64>,
        tolerance: Tolerance,
    ) -> Option<Evidence> {
        // Two that meet are known to the root of rounding, and may not be told apart.
        let Ok((values, _)) = self.spectrum(orbit, tolerance) else { return Some(Evidence::Multiplier(goal)) };
        let lossless = orbit.is_lossless();
        let both = |value: Complex<f64>| if lossless { Nu::of(value).multipliers() } else { [value; 2] };
        let multipliers = values.into_iter().flat_map(both).flat_map(|mu| [mu, mu.conj()]);
        let nearest = multipliers.min_by(|a, b| (a - goal).norm().total_cmp(&(b - goal).norm()))?;
        ((nearest - goal).norm() <= POLE).then_some(Evidence::Multiplier(if lossless { goal } else { nearest }))
    }

    /// The verdict.
    pub(crate) fn verdict(&mut self, orbit: &ContactOrbit, tolerance: Tolerance) -> Result<Verdict, LocateError> {
        // A matrix of half the size is quicker than J(z) of several impacts.
        if orbit.is_conservative()
            && orbit.impacts().len() > 2
            && let Some(verdict) = self.verdict_of_lattice(orbit, tolerance)
        {
            return verdict;
        }
        let verdict = BlochProblem::of(&bounded(orbit)).verdict(&mut self.analyser, tolerance)?;
        Ok(self.named(orbit, verdict, tolerance))
    }

    /// A verdict with what the symmetry of a lattice says of a multiplier beyond +1.
    pub(crate) fn named(&mut self, orbit: &ContactOrbit, verdict: Verdict, tolerance: Tolerance) -> Verdict {
        let known = (verdict.mechanism == Some(Mechanism::PlusOne)).then(|| self.verdict_of_lattice(orbit, tolerance));
        known.flatten().and_then(Result::ok).unwrap_or(verdict)
    }

    fn verdict_of_lattice(
        &mut self,
        orbit: &ContactOrbit,
        tolerance: Tolerance,
    ) -> Option<Result<Verdict, LocateError>> {
        let told = |orbit: Result<Orbit, BreatherError>| {
            let orbit = orbit.map_err(BranchError::from)?;
            Ok(self.analyser.verdict(&orbit, &mut self.finder, tolerance)?)
        };
        orbit.of_all_masses().map(told)
    }

    /// Spectra worked out.
    pub(crate) fn spectra(&self) -> usize {
        self.spectra
    }
}
