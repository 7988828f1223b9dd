//! The lattice of which contacts are masses.

use std::sync::Arc;

use vibrochain_lattice::{FeltShapes, ModalStructure, Model};

/// A lattice, and of each contact of a structure which of its masses it is. The structure holds what impacts of these feel; the lattice, what all
/// others do between the same barriers.
#[derive(Debug, Clone)]
pub(super) struct Masses {
    pub(super) lattice: Model,
    pub(super) sites: Vec<usize>,
    /// What the contacts feel of its modes, and the structure of these under a force of amplitude 1, if any.
    pub(super) shapes: Arc<FeltShapes>,
    pub(super) unit: Arc<ModalStructure>,
}

impl Masses {
    /// Of another lattice, whose modes have the same shapes.
    pub(super) fn of(&self, lattice: Model) -> Self {
        Self { lattice, ..self.clone() }
    }

    /// The same at another frequency; `None` where there is no such lattice.
    pub(super) fn at(&self, omega: f64) -> Option<Self> {
        let mut lattice = self.lattice;
        lattice.set_omega(omega).ok()?;
        Some(self.of(lattice))
    }
}
