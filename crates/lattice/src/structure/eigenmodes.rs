//! From full matrices to modes.
//!
//! Φ with ΦᵀMΦ = 1, ΦᵀKΦ = Ω² first (`basis`). Where ΦᵀCΦ is diagonal the modes are oscillators of real shape; otherwise they are the poles
//! of λ² + λD + Ω² (`poles`). `assembly` makes modes of either, with bounds of their errors.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::assembly::Assembly;
use super::basis::Basis;
use super::error::StructureError;
use super::matrices::Structure;
use super::modal::ModalStructure;
use super::state_matrix::SWEEPS;

impl Structure {
    /// Its modes.
    ///
    /// # Errors
    /// [`StructureError`]: sizes that do not fit, numbers that are not finite, a mass that is not positive, a stiffness that is not
    /// symmetric or has a negative eigenvalue, damping that makes two poles of one shape coincide. Of a contact that none of the modes which are
    /// kept moves, [`StructureError::Unmoved`].
    pub fn modal(&self) -> Result<ModalStructure, StructureError> {
        let n = self.mass.nrows();
        self.check()?;
        let mass = Cholesky::new(self.mass.clone()).ok_or(StructureError::Massless)?;
        let lower = mass.l();
        // L⁻¹KL⁻ᵀ
        let half = lower.solve_lower_triangular(&self.stiffness).ok_or(StructureError::Massless)?;
        let even = lower.solve_lower_triangular(&half.transpose()).ok_or(StructureError::Massless)?;
        let eigen = (&even + even.transpose()).scale(0.5).try_symmetric_eigen(f64::EPSILON, SWEEPS * n);
        let eigen = eigen.ok_or(StructureError::NotConverged)?;
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
        let squares: Vec<f64> = order.iter().map(|&k| eigen.eigenvalues[k]).collect();
        let sorted = DMatrix::from_fn(n, n, |i, k| eigen.eigenvectors[(i, order[k])]);
        let shapes = lower.tr_solve_lower_triangular(&sorted).ok_or(StructureError::Massless)?;
        let mut basis = Basis::refined(&self.mass, &self.stiffness, shapes, &squares);
        basis.fix_rigid(&self.stiffness)?;
        if let Some(modes) = self.modes {
            basis.keep(modes.min(n));
        }
        // How much each contact may see.
        let reach = |weights: &DVector<f64>| lower.solve_lower_triangular(weights).map_or(0.0, |seen| seen.norm());
        let reaches: Vec<f64> = self.contacts.iter().map(|(weights, _)| reach(weights)).collect();
        let modes = Assembly::new(self, &basis, &lower, reaches).modes()?;
        let contacts = self.contacts.iter().map(|(_, contact)| *contact).collect();
        let harmonics = self.loads.iter().map(|(number, _)| *number).collect();
        Ok(ModalStructure::keeping(self.modes, contacts, harmonics, modes)?.with_operator(self.operator()))
    }
}
