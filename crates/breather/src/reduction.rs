//! Orbits with a symmetry, followed among themselves.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::Parameter;

use crate::bordered::{Matrix, Vector, WIDTH};
use crate::equations::Layout;
use crate::orbit::{Family, Orbit};

/// Closer to half the period than this a double-sided orbit is the symmetric one.
const SYMMETRIC: f64 = 1e-10;

/// Unknowns that one coordinate moves, each with its factor.
type Moves = SmallVec<[(usize, f64); 2]>;

/// Which unknowns are free and which equations are asked for. Those of an orbit of two impacts under a force stand as
/// P₀, P₁, s, t₁, ψ and as position 0, position 1, net impulse, Newton 0, Newton 1.
///
/// - Without symmetry: all of them.
/// - Mirror images in space half a period apart (a = 0, or γ₁ = 0 where the ring is not held): P₁ = −P₀, t₁ = T/2. The
///   equations of the second impact repeat those of the first, but for the displacement s.
/// - Mirror images in time (e = 1, a force of cosines): t₁ = T/2 and ψ = 0 or T/2. Newton's law holds by symmetry.
#[derive(Debug, Clone)]
pub(crate) struct Reduction {
    pub(crate) columns: SmallVec<[Moves; WIDTH]>,
    rows: SmallVec<[usize; WIDTH]>,
    /// ψ in periods of the force, where it is not free.
    pub(crate) psi: f64,
}

impl Reduction {
    pub(crate) fn of(orbit: &Orbit, free: Parameter, layout: Layout) -> Self {
        let model = orbit.model();
        let half = 0.5 * orbit.period();
        let centred = orbit.phi().is_some_and(|phi| (phi - half).abs() <= SYMMETRIC * half);
        let one = |i: usize| -> Moves { smallvec![(i, 1.0)] };
        if orbit.family() == Family::DoubleSided && layout.size == 5 && centred {
            let fixed = |parameter: Parameter, value: f64| model.get(parameter) == value && free != parameter;
            let phase = 2.0 * orbit.psi_or_zero() / model.period();
            if fixed(Parameter::Asymmetry, 0.0) || fixed(Parameter::Gamma1, 0.0) {
                let columns = smallvec![smallvec![(0, 1.0), (1, -1.0)], one(2), one(4)];
                return Self { columns, rows: smallvec![0, 1, 3], psi: 0.0 };
            }
            let even = model.force().harmonics().iter().all(|harmonic| harmonic.phase == 0.0);
            if even && fixed(Parameter::Restitution, 1.0) && (phase - phase.round()).abs() <= SYMMETRIC {
                let columns = (0..3).map(one).collect();
                return Self { columns, rows: smallvec![0, 1, 2], psi: 0.5 * phase.round().rem_euclid(2.0) };
            }
        }
        Self::none(layout)
    }

    /// All unknowns free.
    pub(crate) fn none(layout: Layout) -> Self {
        let columns = (0..layout.size).map(|i| -> Moves { smallvec![(i, 1.0)] }).collect();
        Self { columns, rows: (0..layout.size).collect(), psi: 0.0 }
    }

    /// The first unknown that a coordinate moves.
    pub(crate) fn leading(&self, coordinate: usize) -> usize {
        self.columns.get(coordinate).and_then(|column| column.first()).map_or(0, |entry| entry.0)
    }

    pub(crate) fn is_free(&self, unknown: usize) -> bool {
        self.columns.iter().flatten().any(|entry| entry.0 == unknown)
    }

    /// All unknowns from the free coordinates; those that are fixed are left 0.
    pub(crate) fn expand(&self, z: &Vector) -> Vector {
        let mut full = [0.0; WIDTH];
        for (column, z) in self.columns.iter().zip(z) {
            for &(i, factor) in column {
                full[i] += factor * z;
            }
        }
        full
    }

    pub(crate) fn rows(&self, full: &Vector) -> Vector {
        let mut rows = [0.0; WIDTH];
        for (row, &i) in rows.iter_mut().zip(&self.rows) {
            *row = full[i];
        }
        rows
    }

    pub(crate) fn matrix(&self, full: &Matrix) -> Matrix {
        let mut matrix = [[0.0; WIDTH]; WIDTH];
        for (row, &i) in matrix.iter_mut().zip(&self.rows) {
            for (entry, column) in row.iter_mut().zip(&self.columns) {
                *entry = column.iter().map(|&(j, factor)| factor * full[i][j]).sum();
            }
        }
        matrix
    }
}
