//! Looks at a structure's orbits.

use vibrochain_breather::{Admissibility, BranchError, StructureOrbit};

use super::by_matrix;
use super::stability::{StructureMultipliers, participating_multipliers};
use crate::analyser::Analyser;
use crate::error::FloquetError;
use crate::events::half_sums::half_sums;
use crate::events::{EventOrbit, Spectrum, Watcher, strongest};
use crate::locate::LocateError;
use crate::verdict::{Tolerance, Verdict};

/// Looks at a structure's orbits.
#[derive(Debug, Default)]
pub(crate) struct OfStructures {
    spectra: usize,
    analyser: Analyser,
}

impl Watcher for OfStructures {
    type Orbit = StructureOrbit;
    const FAINT: f64 = 1e-9;

    fn admissibility(&mut self, orbit: &StructureOrbit) -> Result<Admissibility, LocateError> {
        Ok(orbit.admissibility().map_err(BranchError::from)?)
    }

    fn spectrum(&mut self, orbit: &StructureOrbit, tolerance: Tolerance) -> Result<Spectrum, LocateError> {
        self.spectra += 1;
        let reversible = orbit.reversible().filter(|_| orbit.is_lossless());
        if let Some(values) = reversible.and_then(|orbit| self.analyser.structure_half_sums(&orbit)) {
            return Ok((values, None));
        }
        let (multipliers, verdict) = match participating_multipliers(orbit, tolerance) {
            Err(FloquetError::Uncounted(doubt)) if orbit.is_lossless() => {
                let all = by_matrix::multipliers(&orbit.bloch_equations().0, orbit.is_conservative());
                (all.ok_or(FloquetError::Uncounted(doubt))?, None)
            }
            told => told?,
        };
        let values = if orbit.is_lossless() { half_sums(&multipliers, false) } else { multipliers };
        Ok((values, verdict))
    }

    fn verdict(&mut self, orbit: &StructureOrbit, tolerance: Tolerance) -> Result<Verdict, LocateError> {
        Ok(StructureMultipliers::of(orbit).verdict(&mut self.analyser, tolerance)?)
    }

    fn strength(&self, orbit: &StructureOrbit) -> f64 {
        strongest(orbit).max(f64::MIN_POSITIVE)
    }

    fn spectra(&self) -> usize {
        self.spectra
    }
}
