//! Looks at a structure's orbits.

use vibrochain_breather::{Admissibility, BranchError, StructureOrbit};

use super::stability::{participating_multipliers, structure_verdict};
use crate::events::half_sums::half_sums;
use crate::events::{EventOrbit, Spectrum, Watcher, strongest};
use crate::locate::LocateError;
use crate::verdict::{Tolerance, Verdict};

/// Looks at a structure's orbits.
#[derive(Debug, Default)]
pub(super) struct OfStructures {
    spectra: usize,
}

impl Watcher for OfStructures {
    type Orbit = StructureOrbit;
    const FAINT: f64 = 1e-9;

    fn admissibility(&mut self, orbit: &StructureOrbit) -> Result<Admissibility, LocateError> {
        Ok(orbit.admissibility().map_err(BranchError::from)?)
    }

    fn spectrum(&mut self, orbit: &StructureOrbit, tolerance: Tolerance) -> Result<Spectrum, LocateError> {
        self.spectra += 1;
        let (multipliers, verdict) = participating_multipliers(orbit, tolerance)?;
        let values = if orbit.is_lossless() { half_sums(&multipliers, false) } else { multipliers };
        Ok((values, verdict))
    }

    fn verdict(&mut self, orbit: &StructureOrbit, tolerance: Tolerance) -> Result<Verdict, LocateError> {
        Ok(structure_verdict(orbit, tolerance)?)
    }

    fn strength(&self, orbit: &StructureOrbit) -> f64 {
        strongest(orbit).max(f64::MIN_POSITIVE)
    }

    fn spectra(&self) -> usize {
        self.spectra
    }
}
