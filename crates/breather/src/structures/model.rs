//! A structure and the frequency of its loads.

use std::f64::consts::TAU;
use std::sync::Arc;

use vibrochain_lattice::{Barrier, MAX_MAGNITUDE, ModalStructure};

use super::error::StructureOrbitError;

/// A linear structure with stops under loads of frequency ω; of an orbit without them, ω is its own.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureModel {
    structure: Arc<ModalStructure>,
    omega: f64,
}

impl StructureModel {
    /// The structure at a frequency, in units of the user's.
    ///
    /// # Errors
    /// [`StructureOrbitError::Omega`].
    pub fn new(structure: Arc<ModalStructure>, omega: f64) -> Result<Self, StructureOrbitError> {
        if (1.0 / MAX_MAGNITUDE..=MAX_MAGNITUDE).contains(&omega) {
            Ok(Self { structure, omega })
        } else {
            Err(StructureOrbitError::Omega { omega })
        }
    }

    /// The structure.
    pub fn structure(&self) -> &Arc<ModalStructure> {
        &self.structure
    }

    /// ω
    pub fn omega(&self) -> f64 {
        self.omega
    }

    /// 2π/ω
    pub fn period(&self) -> f64 {
        TAU / self.omega
    }

    /// Where a barrier of a contact is.
    ///
    /// # Errors
    /// [`StructureOrbitError`]: there is no such contact, or it has no such barrier.
    pub fn barrier(&self, contact: usize, barrier: Barrier) -> Result<f64, StructureOrbitError> {
        let contacts = self.structure.contacts();
        let last = contacts.len() - 1;
        let found = contacts.get(contact).ok_or(StructureOrbitError::NoSuchContact { contact, last })?;
        found.barrier(barrier).ok_or(StructureOrbitError::NoBarrier { contact, barrier })
    }
}
