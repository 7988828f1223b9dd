//! Where symmetric orbits lose their symmetry, as a regular solution.
//!
//! There the orbit's equations F are singular in a direction that breaks the symmetry, and det J(1) does not change along it: F = 0 and
//! det J(1) = 0 together are singular, too. One more equation and one more unknown μ make them regular. The equation keeps the orbit as symmetric as
//! it was; μ stands in F + μψ = 0, ψ the left null vector of F, and is 0 as long as both numbers keep the symmetry.

use nalgebra::{Complex, DMatrix};
use vibrochain_breather::system::{Matrix, System, Vector};
use vibrochain_breather::{ContactOrbit, Continuation};

use crate::singular::Singular;

/// An orbit less uneven than this is symmetric but for rounding.
const EVEN: f64 = 1e-6;

/// How far along the null vector the orbit is looked at, in units; and how uneven it must become, against that, where it loses its symmetry.
const ASIDE: f64 = 1e-4;
const BREAKS: f64 = 1e-3;

/// Of the equations next to an orbit that is symmetric.
#[derive(Debug, Clone)]
pub(super) struct Unfolding {
    /// ψ
    pub(super) push: Vector,
    /// What of the orbit's unevenness is looked at: the part that its null vector brings.
    weights: Vec<f64>,
}

impl Unfolding {
    /// `None` where the orbit at `z` is not symmetric, or its null vector is.
    pub(super) fn of(base: &mut Continuation, z: &[f64]) -> Option<Self> {
        let here = base.evaluate(z).ok()?;
        let even = here.orbit.unevenness();
        if even.is_empty() || even.iter().any(|part| part.abs() > EVEN) {
            return None;
        }
        let [push, along] = null_vectors(&here.matrix)?;
        let mut aside = |sign: f64| {
            let mut moved = Vector::from(z);
            moved.iter_mut().zip(&along).zip(base.units()).for_each(|((z, x), unit)| *z += sign * ASIDE * x * unit);
            base.evaluate(&moved).ok().map(|there| there.orbit.unevenness())
        };
        let (high, low) = (aside(1.0)?, aside(-1.0)?);
        let change: Vec<f64> = high.iter().zip(&low).map(|(high, low)| (high - low) / (2.0 * ASIDE)).collect();
        let size = change.iter().map(|part| part * part).sum::<f64>().sqrt();
        (size > BREAKS).then(|| Self { push, weights: change.iter().map(|part| part / size).collect() })
    }

    /// How uneven an orbit is.
    pub(super) fn value(&self, orbit: &ContactOrbit) -> f64 {
        self.weights.iter().zip(orbit.unevenness()).map(|(weight, part)| weight * part).sum()
    }
}

/// ψ and φ of the matrix's least singular value, its rows scaled to length 1 before: ψᵀA ≈ Aφ ≈ 0.
fn null_vectors(matrix: &Matrix) -> Option<[Vector; 2]> {
    let size = matrix.size();
    let length = |i: usize| matrix.row(i).iter().map(|entry| entry * entry).sum::<f64>().sqrt();
    let lengths: Vec<f64> = (0..size).map(length).collect();
    if !lengths.iter().all(|length| length.is_normal()) {
        return None;
    }
    let scaled = DMatrix::from_fn(size, size, |i, j| Complex::new(matrix[(i, j)] / lengths[i], 0.0));
    let Singular { left, right, .. } = Singular::of(&scaled)?;
    let push = (0..size).map(|i| left[(i, size - 1)].re * lengths[i]).collect();
    Some([push, (0..size).map(|j| right[(j, size - 1)].re).collect()])
}
