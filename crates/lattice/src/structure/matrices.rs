//! Mass, damping and stiffness with their contacts and loads: what a structure is before its modes are known.

use nalgebra::{Cholesky, DMatrix, DVector};
use rustfft::num_complex::Complex;

use super::contact::Contact;
use super::energy::{Block, EnergyForm};
use super::error::{StructureError, check_loads, finite};
use super::modal::ModalStructure;
use super::operator::{Bands, Pulls, SparseOperator, projected};

type C = Complex<f64>;

/// M q″ + C q′ + K q = s + Σ_j f_j cos jω(t+ψ), with contacts g = wᵀq. Units are the user's.
///
/// ```
/// use nalgebra::{DMatrix, DVector};
/// use vibrochain_lattice::{Contact, Structure};
/// let structure = Structure {
///     mass: DMatrix::identity(2, 2),
///     damping: DMatrix::from_row_slice(2, 2, &[0.02, 0.0, 0.0, 0.1]),
///     stiffness: DMatrix::from_row_slice(2, 2, &[1.0, -0.3, -0.3, 0.8]),
///     contacts: vec![(DVector::from_vec(vec![0.0, 1.0]), Contact { lower: None, upper: Some(0.7), restitution: 0.8 })],
///     ..Structure::default()
/// };
/// let modal = structure.modal()?;
/// assert_eq!(modal.modes().len(), 2);
/// assert!((modal.mobility(0, 0) - 1.0).abs() < 1e-14);
/// # Ok::<(), vibrochain_lattice::StructureError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Structure {
    /// M, symmetric and positive.
    pub mass: DMatrix<f64>,
    /// C, symmetric; without rows: none.
    pub damping: DMatrix<f64>,
    /// K, symmetric, without negative eigenvalues.
    pub stiffness: DMatrix<f64>,
    /// w of each contact, and where it is stopped.
    pub contacts: Vec<(DVector<f64>, Contact)>,
    /// s; without entries: none.
    pub static_load: DVector<f64>,
    /// Number j and f of each harmonic, complex: |f|cos(jω(t+ψ) + arg f).
    pub loads: Vec<(u32, DVector<C>)>,
    /// Only so many of its modes count, the slowest; `None`: all do. What loads, dashpots and contacts do to the others is left out.
    pub modes: Option<usize>,
}

impl Structure {
    /// 1/(wᵀM⁻¹w) of each contact: the mass that an impact there feels, whether all modes are kept or not. `None` of a mass that is not
    /// positive definite.
    pub fn effective_masses(&self) -> Option<Vec<f64>> {
        let mass = Cholesky::new(self.mass.clone())?;
        Some(self.contacts.iter().map(|(weights, _)| 1.0 / weights.dot(&mass.solve(weights))).collect())
    }

    /// Coordinates ξ of all modes of a state (q, q′); `modal` is what [`Structure::modal`] made of it.
    ///
    /// # Errors
    /// [`StructureError::Size`] where `place` or `velocity` has not one number a coordinate.
    pub fn project(
        &self,
        modal: &ModalStructure,
        place: &DVector<f64>,
        velocity: &DVector<f64>,
    ) -> Result<Vec<[f64; 2]>, StructureError> {
        let n = self.mass.nrows();
        StructureError::sized("the place", place.len(), n)?;
        StructureError::sized("the velocity", velocity.len(), n)?;
        let vector = |list: &[f64]| DVector::from_column_slice(list);
        let mass = |x: &[f64]| (&self.mass * vector(x)).data.into();
        let damping = |x: &[f64]| {
            if self.damping.is_empty() { vec![0.0; n] } else { (&self.damping * vector(x)).data.into() }
        };
        Ok(projected(modal.modes(), mass, damping, place.as_slice(), velocity.as_slice()))
    }

    /// What pulls at each coordinate; `None` where masses are coupled or some modes are left out.
    pub(super) fn operator(&self) -> Option<SparseOperator> {
        let n = self.mass.nrows();
        let is_coupled = |i: usize| (0..n).any(|j| i != j && self.mass[(i, j)] != 0.0);
        if self.modes.is_some_and(|modes| modes < n) || (0..n).any(is_coupled) {
            return None;
        }
        let mass = |i: usize| self.mass[(i, i)];
        let bands = |matrix: &DMatrix<f64>| {
            if matrix.is_empty() { Bands::default() } else { Bands::new(n, |i, j| matrix[(i, j)] / mass(i)) }
        };
        let weights = |weights: &DVector<f64>| {
            let places = weights.iter().copied().enumerate();
            places.filter(|(_, weight)| *weight != 0.0).collect::<Vec<_>>()
        };
        Some(SparseOperator {
            masses: (0..n).map(mass).collect(),
            pulls: Pulls::Bands { stiffness: bands(&self.stiffness), damping: bands(&self.damping) },
            contacts: self.contacts.iter().map(|(contact, _)| weights(contact)).collect(),
            loads: self.loads.iter().map(|(_, load)| (0..n).map(|i| load[i] / mass(i)).collect()).collect(),
        })
    }

    /// Energies ½q′ᵀMq′ + ½qᵀKq, q′ᵀCq′ and powers of the loads, in the modes that [`Structure::modal`] made.
    pub fn energy_form(&self, modal: &ModalStructure) -> EnergyForm {
        let n = self.mass.nrows();
        let modes = modal.modes();
        // q and q′ of a unit of each coordinate ξ.
        let place = DMatrix::from_fn(n, 2 * modes.len(), |i, at| modes[at / 2].coordinates[i][at % 2]);
        let velocity = DMatrix::from_fn(n, 2 * modes.len(), |i, at| {
            let (mode, mut unit) = (&modes[at / 2], [0.0; 2]);
            unit[at % 2] = 1.0;
            let rise = mode.turn.act(mode.generator(), unit);
            mode.coordinates[i][0] * rise[0] + mode.coordinates[i][1] * rise[1]
        });
        let blocks = |form: DMatrix<f64>| {
            let block = |first: usize, second: usize| {
                let at = |i: usize, j: usize| form[(2 * first + i, 2 * second + j)];
                Block { first, second, form: [[at(0, 0), at(0, 1)], [at(1, 0), at(1, 1)]] }
            };
            (0..modes.len()).flat_map(|i| (0..modes.len()).map(move |j| (i, j))).map(|(i, j)| block(i, j)).collect()
        };
        let energy = velocity.transpose() * &self.mass * &velocity + place.transpose() * &self.stiffness * &place;
        let dissipation =
            if self.damping.is_empty() { Vec::new() } else { blocks(velocity.transpose() * &self.damping * &velocity) };
        let power = |load: &DVector<C>, k: usize| {
            [0, 1].map(|i| load.iter().zip(&velocity.column(2 * k + i)).map(|(f, v)| f * *v).sum())
        };
        let still = if self.static_load.is_empty() { DVector::zeros(n) } else { self.static_load.clone() };
        let still = velocity.transpose() * still;
        EnergyForm {
            energy: blocks(energy),
            dissipation,
            still: (0..modes.len()).map(|k| [still[2 * k], still[2 * k + 1]]).collect(),
            loads: (0..modes.len()).map(|k| self.loads.iter().map(|(_, load)| power(load, k)).collect()).collect(),
        }
    }

    pub(super) fn check(&self) -> Result<(), StructureError> {
        let n = self.mass.nrows();
        let size = StructureError::sized;
        if n == 0 {
            return Err(StructureError::Size { what: "the mass matrix".to_owned(), given: 0, wanted: 1 });
        }
        if self.modes == Some(0) {
            return Err(StructureError::Range { what: "modes".to_owned(), value: 0.0, requirement: "a number from 1" });
        }
        size("the mass matrix", self.mass.ncols(), n)?;
        for (what, matrix) in [("the stiffness matrix", &self.stiffness), ("the damping matrix", &self.damping)] {
            if !(what == "the damping matrix" && matrix.is_empty()) {
                size(what, matrix.nrows(), n)?;
                size(what, matrix.ncols(), n)?;
            }
        }
        let symmetric = [
            ("the mass matrix", &self.mass),
            ("the stiffness matrix", &self.stiffness),
            ("the damping matrix", &self.damping),
        ];
        for (what, matrix) in symmetric.into_iter().filter(|(_, matrix)| !matrix.is_empty()) {
            let largest = matrix.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
            for row in 0..n {
                for column in 0..row {
                    if (matrix[(row, column)] - matrix[(column, row)]).abs() > 1e-12 * largest {
                        return Err(StructureError::Asymmetric { what, row, column });
                    }
                }
            }
        }
        let loads = self.loads.iter().map(|(number, load)| (*number, load.as_slice()));
        check_loads(n, self.static_load.as_slice(), loads)?;
        for (number, (weights, _)) in self.contacts.iter().enumerate() {
            size(&format!("the weights of contact {number}"), weights.len(), n)?;
            if weights.iter().all(|weight| *weight == 0.0) {
                return Err(StructureError::NoWeight { contact: number });
            }
        }
        let of_contacts = self.contacts.iter().flat_map(|(weights, _)| weights.iter().copied());
        finite("the mass matrix", self.mass.iter().copied())?;
        finite("the stiffness matrix", self.stiffness.iter().copied())?;
        finite("the damping matrix", self.damping.iter().copied())?;
        finite("the weights of contacts", of_contacts)
    }
}
