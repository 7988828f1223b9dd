//! Directions of small perturbations: what each has grown, and how they are kept apart. Of a chain a vector is displacements and velocities,
//! of a structure both coordinates of all modes.

use crate::error::TangentError;
use crate::units::spread;

/// The most tangent vectors, lest their number be asked for with too many digits.
const MAX_VECTORS: usize = 4096;

/// Once the longest has grown, or the shortest shrunk, so many times, vectors are made orthonormal anew: neighbours in
/// direction would otherwise lose as many digits.
const GROWN: f64 = 1e8;

/// Vectors that ride along a run.
#[derive(Debug, Clone)]
pub(crate) struct Directions {
    pub(crate) vectors: Vec<[Vec<f64>; 2]>,
    /// ln of what each direction has grown up to the last orthonormalisation.
    pub(crate) logs: Vec<f64>,
    /// No linear map has gone on from an impact.
    pub(crate) grazed: bool,
}

impl Directions {
    /// Given ones of `size` pairs of numbers each.
    pub(crate) fn of(vectors: Vec<[Vec<f64>; 2]>, size: usize) -> Result<Self, TangentError> {
        checked(vectors.len(), size)?;
        let is_wrong = |vector: &[Vec<f64>; 2]| {
            let length = dot(vector, vector);
            vector.iter().any(|part| part.len() != size) || !(length > 0.0 && length.is_finite())
        };
        if let Some(vector) = vectors.iter().position(is_wrong) {
            return Err(TangentError::Entries { vector, size });
        }
        Ok(Self { logs: vec![0.0; vectors.len()], vectors, grazed: false })
    }

    /// `count` orthonormal ones in random directions; the same seed gives the same ones.
    pub(crate) fn random(count: usize, size: usize, mut seed: u64) -> Result<Self, TangentError> {
        checked(count, size)?;
        // The first numbers of neighbouring seeds are neighbours, too.
        (0..4).for_each(|_| {
            spread(&mut seed);
        });
        let mut entries = || (0..size).map(|_| spread(&mut seed)).collect();
        let mut directions = Self::of((0..count).map(|_| [entries(), entries()]).collect(), size)?;
        // What that takes is no growth.
        directions.orthonormalise();
        directions.logs.fill(0.0);
        Ok(directions)
    }

    pub(crate) fn orthonormalise(&mut self) -> &[f64] {
        for i in 0..self.vectors.len() {
            let (before, rest) = self.vectors.split_at_mut(i);
            let Some((own, before)) = rest.first_mut().map(|own| (own, before)) else { break };
            // Twice is enough (Kahan): the second pass takes what rounding has left in the first.
            for _ in 0..2 {
                for other in &*before {
                    let along = dot(own, other);
                    for (x, y) in own.iter_mut().flatten().zip(other.iter().flatten()) {
                        *x -= along * y;
                    }
                }
            }
            let length = dot(own, own).sqrt();
            self.logs[i] += length.ln();
            if length > 0.0 {
                own.iter_mut().flatten().for_each(|x| *x /= length);
            }
        }
        &self.logs
    }

    /// Sees to vectors whose lengths have come far apart.
    pub(crate) fn keep_apart(&mut self) {
        let far = |vector: &[Vec<f64>; 2]| {
            let square = dot(vector, vector);
            square > 0.0 && !(1.0 / (GROWN * GROWN)..=GROWN * GROWN).contains(&square)
        };
        if self.vectors.iter().any(far) {
            self.orthonormalise();
        }
    }
}

fn checked(count: usize, size: usize) -> Result<(), TangentError> {
    let most = (2 * size).min(MAX_VECTORS);
    if (1..=most).contains(&count) { Ok(()) } else { Err(TangentError::Count { count, most }) }
}

fn dot(one: &[Vec<f64>; 2], other: &[Vec<f64>; 2]) -> f64 {
    one.iter().flatten().zip(other.iter().flatten()).map(|(x, y)| x * y).sum()
}
