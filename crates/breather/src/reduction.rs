//! Orbits with a symmetry, followed among themselves.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::Parameter;

use crate::linear::{Matrix, USUAL, Vector};
use crate::orbit::{Family, Orbit};
use crate::unknowns::Unknowns;

/// Closer to half the period than this a double-sided orbit is the symmetric one.
pub(crate) const SYMMETRIC: f64 = 1e-10;

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
    columns: SmallVec<[Moves; USUAL]>,
    rows: SmallVec<[usize; USUAL]>,
    /// ψ in periods of the force, where symmetry holds it.
    pub(crate) psi: Option<f64>,
}

impl Reduction {
    pub(crate) fn of(orbit: &Orbit, free: &[Parameter], unknowns: &Unknowns) -> Self {
        let model = orbit.model();
        let half = 0.5 * orbit.period();
        let centred = orbit.phi().is_some_and(|phi| (phi - half).abs() <= SYMMETRIC * half);
        let one = |i: usize| -> Moves { smallvec![(i, 1.0)] };
        if orbit.family() == Family::DoubleSided && unknowns.size() == 5 && centred {
            let fixed = |parameter: Parameter, value: f64| model.get(parameter) == value && !free.contains(&parameter);
            let phase = 2.0 * orbit.psi_or_zero() / model.period();
            if fixed(Parameter::Asymmetry, 0.0) || fixed(Parameter::Gamma1, 0.0) {
                let columns = smallvec![smallvec![(0, 1.0), (1, -1.0)], one(2), one(4)];
                return Self { columns, rows: smallvec![0, 1, 3], psi: None };
            }
            let even = model.force().harmonics().iter().all(|harmonic| harmonic.phase == 0.0);
            if even && fixed(Parameter::Restitution, 1.0) && (phase - phase.round()).abs() <= SYMMETRIC {
                let (columns, psi) = ((0..3).map(one).collect(), Some(0.5 * phase.round().rem_euclid(2.0)));
                return Self { columns, rows: smallvec![0, 1, 2], psi };
            }
        }
        Self::none(unknowns)
    }

    /// All unknowns free.
    pub(crate) fn none(unknowns: &Unknowns) -> Self {
        let all = 0..unknowns.size();
        let columns = all.clone().map(|i| -> Moves { smallvec![(i, 1.0)] }).collect();
        Self { columns, rows: all.collect(), psi: None }
    }

    /// Number of coordinates.
    pub(crate) fn size(&self) -> usize {
        self.columns.len()
    }

    /// The first unknown that a coordinate moves.
    pub(crate) fn leading(&self, coordinate: usize) -> usize {
        self.columns.get(coordinate).and_then(|column| column.first()).map_or(0, |entry| entry.0)
    }

    /// All unknowns from the free coordinates, with those that are fixed as in `full`.
    pub(crate) fn expand(&self, z: &[f64], full: &mut Vector) {
        self.columns.iter().flatten().for_each(|&(i, _)| full[i] = 0.0);
        for (column, z) in self.columns.iter().zip(z) {
            for &(i, factor) in column {
                full[i] += factor * z;
            }
        }
    }

    pub(crate) fn rows(&self, full: &[f64]) -> Vector {
        self.rows.iter().map(|&i| full[i]).collect()
    }

    pub(crate) fn matrix(&self, full: &Matrix) -> Matrix {
        Matrix::from_fn(self.size(), |i, j| {
            self.columns[j].iter().map(|&(k, factor)| factor * full[(self.rows[i], k)]).sum()
        })
    }
}
