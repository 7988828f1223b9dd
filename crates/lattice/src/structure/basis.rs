//! Modes without dashpots as well as numbers hold them: ΦᵀMΦ = 1, ΦᵀKΦ = Ω².
//!
//! An eigensolver knows a mode up to rounding of the largest eigenvalue: of a soft mode beside stiff ones, or of a light coordinate, few digits
//! are left. With the residuals R = KΦ − MΦΩ² in twice the digits
//!
//! ```text
//! E_ij = φ_iᵀR_j/(Ω_j² − Ω_i²),   E_jj = (1 − φ_jᵀMφ_j)/2,   Φ ← Φ(1 + E)
//! ```
//!
//! is right up to the square of E. The last correction stays beside Φ as a second part, and what it may be off bounds the errors that are told.

use nalgebra::{DMatrix, DVector};

use super::error::StructureError;
use super::oscillator::Bounded;
use crate::simd::twofold::{FINE, Twofold};

/// Corrections this small have no square that counts.
const SETTLED: f64 = 1e-13;

/// Corrections of a mode along another one beyond this are no small ones: the two are not told apart.
const APART: f64 = 0.1;

/// Corrections above this between modes whose coupling is rounding of their frequencies lead nowhere: any combination of the two serves.
const ALIKE: f64 = 1e-9;

/// Corrections at most: two are usual.
const PASSES: usize = 10;

/// Products of a pass beyond which one has to do: a second or two.
const MOST_PRODUCTS: usize = 400_000_000;

/// The modes without damping, by rising frequency.
#[derive(Debug, Clone)]
pub(super) struct Basis {
    /// Ω², and bounds of their errors.
    pub(super) squares: Vec<Twofold>,
    pub(super) square_errors: Vec<f64>,
    /// Φ is the sum of both parts; bounds of the errors of its entries.
    pub(super) shapes: DMatrix<f64>,
    pub(super) rest: DMatrix<f64>,
    pub(super) shape_errors: DMatrix<f64>,
}

/// The rows of a symmetric matrix without their zeros.
pub(super) struct SparseRows(Vec<Vec<(usize, f64)>>);

impl SparseRows {
    pub(super) fn new(matrix: &DMatrix<f64>) -> Self {
        let n = matrix.nrows();
        let mean = |i: usize, j: usize| 0.5 * (matrix[(i, j)] + matrix[(j, i)]);
        let row = |i: usize| (0..n).map(|j| (j, mean(i, j))).filter(|(_, entry)| *entry != 0.0).collect();
        Self((0..n).map(row).collect())
    }

    fn entries(&self) -> usize {
        self.0.iter().map(Vec::len).sum()
    }

    /// The matrix times a vector of two parts; sizes of the terms.
    pub(super) fn times(&self, x: &[f64], rest: Option<&[f64]>) -> (Vec<Twofold>, Vec<f64>) {
        let of_row = |row: &Vec<(usize, f64)>| {
            let sum = Twofold::dot(row.iter().map(|&(j, entry)| (entry, x[j])));
            let rest = rest.map_or(0.0, |rest| row.iter().map(|&(j, entry)| entry * rest[j]).sum());
            (sum + Twofold::from(rest), row.iter().map(|&(j, entry)| (entry * x[j]).abs()).sum::<f64>())
        };
        self.0.iter().map(of_row).unzip()
    }

    /// The moduli of its entries times a matrix.
    pub(super) fn moduli_times(&self, by: &DMatrix<f64>) -> DMatrix<f64> {
        let of_row = |row: &Vec<(usize, f64)>, column: &[f64]| -> f64 {
            row.iter().map(|&(j, entry)| entry.abs() * column[j]).sum()
        };
        let mut product: DMatrix<f64> = DMatrix::zeros(by.nrows(), by.ncols());
        for (mut sums, column) in product.column_iter_mut().zip(by.column_iter()) {
            sums.iter_mut().zip(&self.0).for_each(|(sum, row)| *sum = of_row(row, column.as_slice()));
        }
        product
    }
}

/// What is left of KΦ = MΦΩ² and ΦᵀMΦ = 1.
struct Residuals {
    /// Φᵀ(KΦ − MΦΩ²), and bounds of its errors.
    couplings: DMatrix<f64>,
    doubts: DMatrix<f64>,
    /// φ_jᵀMφ_j − 1
    lengths: Vec<f64>,
    /// MΦ
    momenta: Vec<Vec<Twofold>>,
}

impl Basis {
    /// From what an eigensolver says.
    pub(super) fn refined(
        mass: &DMatrix<f64>,
        stiffness: &DMatrix<f64>,
        mut shapes: DMatrix<f64>,
        squares: &[f64],
    ) -> Self {
        let (mass, stiffness) = (SparseRows::new(mass), SparseRows::new(stiffness));
        let n = squares.len();
        let mut squares: Vec<Twofold> = squares.iter().map(|square| Twofold::from(*square)).collect();
        let once = (mass.entries() + stiffness.entries()).saturating_mul(n) > MOST_PRODUCTS;
        let (mut last, mut pass) = (f64::INFINITY, 1);
        loop {
            let left = Residuals::of(&mass, &stiffness, &shapes, &squares);
            let moved: Vec<f64> = (0..n).map(|j| left.couplings[(j, j)] / (1.0 + left.lengths[j])).collect();
            squares.iter_mut().zip(&moved).for_each(|(square, by)| *square = *square + Twofold::from(*by));
            let (by, open) = corrections(&left, &squares, &shapes);
            let size = by.amax();
            if size <= SETTLED || size > 0.25 * last || pass == PASSES || once {
                return Self::settled(left, squares, shapes, (by, open));
            }
            (last, pass) = (size, pass + 1);
            shapes = &shapes * by + shapes;
        }
    }

    /// With the last corrections and what these may be off.
    fn settled(
        left: Residuals,
        squares: Vec<Twofold>,
        shapes: DMatrix<f64>,
        (by, open): (DMatrix<f64>, Vec<(usize, usize)>),
    ) -> Self {
        let n = squares.len();
        let gap = |i: usize, j: usize| (squares[j] - squares[i]).value().abs();
        let mut square_errors: Vec<f64> = (0..n)
            .map(|j| {
                let bent: f64 = (0..n).map(|k| gap(k, j) * by[(k, j)] * by[(k, j)]).sum();
                let own = left.couplings[(j, j)].abs() * (2.0 * f64::EPSILON + left.lengths[j].powi(2));
                left.doubts[(j, j)] + bent + own + 4.0 * FINE * squares[j].high.abs()
            })
            .collect();
        for &(i, j) in &open {
            square_errors[j] += left.couplings[(i, j)].abs() + left.doubts[(i, j)];
        }
        // Terms of second order.
        let moduli = by.abs();
        let steep = DMatrix::from_fn(n, n, |i, k| moduli[(i, k)] * gap(i, k));
        let skew = DMatrix::from_fn(n, n, |i, k| match i == k {
            true => left.lengths[i].abs(),
            false => moduli[(i, k)] + moduli[(k, i)],
        });
        let second = &steep * &moduli + &skew * &steep;
        let squared = &moduli * &moduli;
        let mut doubts = DMatrix::from_fn(n, n, |i, j| {
            if i == j {
                return squared[(j, j)] + left.lengths[j].powi(2) + (n * n) as f64 * FINE;
            }
            let known = left.doubts[(i, j)] + second[(i, j)] + moduli[(i, j)] * (square_errors[i] + square_errors[j]);
            known / gap(i, j) + 4.0 * f64::EPSILON * moduli[(i, j)]
        });
        for &(i, j) in &open {
            doubts[(i, j)] = squared[(i, j)] + (n * n) as f64 * FINE + 4.0 * f64::EPSILON * moduli[(i, j)];
        }
        let doubts = doubts + moduli * (n as f64 * f64::EPSILON);
        Self { rest: &shapes * by, shape_errors: shapes.abs() * doubts, squares, square_errors, shapes }
    }

    /// Squares that rounding of the stiffness could have made are 0: those of rigid modes.
    ///
    /// # Errors
    /// [`StructureError::Unstable`] where one is below.
    pub(super) fn fix_rigid(&mut self, stiffness: &DMatrix<f64>) -> Result<(), StructureError> {
        let moduli = self.shapes.abs();
        let sizes = SparseRows::new(stiffness).moduli_times(&moduli);
        let n = self.squares.len();
        for k in 0..n {
            let floor = 8.0 * n as f64 * f64::EPSILON * moduli.column(k).dot(&sizes.column(k)) + self.square_errors[k];
            let square = self.squares[k].value();
            if square < -floor {
                return Err(StructureError::Unstable { square });
            }
            if square <= floor {
                (self.squares[k], self.square_errors[k]) = (Twofold::default(), 0.0);
            }
        }
        Ok(())
    }

    /// The lowest modes alone.
    pub(super) fn keep(&mut self, modes: usize) {
        self.squares.truncate(modes);
        self.square_errors.truncate(modes);
        for table in [&mut self.shapes, &mut self.rest, &mut self.shape_errors] {
            *table = table.columns(0, modes).into_owned();
        }
    }

    /// φ
    pub(super) fn coordinates(&self, k: usize) -> Vec<f64> {
        self.shapes.column(k).iter().zip(&self.rest.column(k)).map(|(high, low)| high + low).collect()
    }

    /// wᵀφ of all modes.
    pub(super) fn seen(&self, weights: &DVector<f64>) -> Vec<Bounded> {
        let n = weights.len() as f64;
        let of_mode = |k: usize| {
            let (shape, rest, errors) = (self.shapes.column(k), self.rest.column(k), self.shape_errors.column(k));
            let sum = Twofold::dot(weights.iter().copied().zip(shape.iter().copied()));
            let low: f64 = weights.iter().zip(&rest).map(|(w, x)| w * x).sum();
            let mut error = 0.0;
            for (i, w) in weights.iter().enumerate() {
                error += w.abs() * (errors[i] + n * f64::EPSILON * rest[i].abs() + n * n * FINE * shape[i].abs());
            }
            Bounded { sum: sum + Twofold::from(low), error }
        };
        (0..self.squares.len()).map(of_mode).collect()
    }

    /// ΦᵀCΦ with bounds of its errors; and |Φ|ᵀ|C||Φ|, which rounding of C is a part of.
    pub(super) fn form(&self, matrix: &DMatrix<f64>) -> (Vec<Vec<Bounded>>, DMatrix<f64>) {
        let (rows, n) = (SparseRows::new(matrix), self.squares.len());
        let moduli = self.shapes.abs();
        let sizes = rows.moduli_times(&moduli);
        let largest = moduli.tr_mul(&sizes);
        let carried = self.shape_errors.tr_mul(&sizes);
        let fine = (matrix.nrows() * matrix.nrows()) as f64 * FINE;
        let lows = (self.rest.abs() * (matrix.nrows() as f64 * f64::EPSILON)).tr_mul(&sizes);
        let mut form = vec![vec![Bounded::default(); n]; n];
        for j in 0..n {
            let (shape, rest) = (self.shapes.column(j), self.rest.column(j));
            let (image, _) = rows.times(shape.as_slice(), Some(rest.as_slice()));
            for i in 0..=j {
                let (shape, rest) = (self.shapes.column(i), self.rest.column(i));
                let sum = Twofold::dot(shape.iter().copied().zip(image.iter().map(|image| image.high)));
                let low: f64 = (image.iter().zip(&shape).zip(&rest))
                    .map(|((image, shape), rest)| shape * image.low + rest * image.high)
                    .sum();
                let both = |of: &DMatrix<f64>| of[(i, j)] + of[(j, i)];
                let error = both(&carried) + both(&lows) + fine * largest[(i, j)];
                form[i][j] = Bounded { sum: sum + Twofold::from(low), error };
                form[j][i] = form[i][j];
            }
        }
        (form, largest)
    }
}

impl Residuals {
    fn of(mass: &SparseRows, stiffness: &SparseRows, shapes: &DMatrix<f64>, squares: &[Twofold]) -> Self {
        let n = squares.len();
        let fine = (n * n) as f64 * FINE;
        let (mut residuals, mut errors) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        let (mut lengths, mut momenta) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for (j, square) in squares.iter().enumerate() {
            let shape = shapes.column(j);
            let (forces, sizes) = stiffness.times(shape.as_slice(), None);
            let (momentum, masses) = mass.times(shape.as_slice(), None);
            for i in 0..n {
                let left = (forces[i] - momentum[i] * *square).value();
                let size = sizes[i] + square.high.abs() * masses[i];
                residuals[(i, j)] = left;
                errors[(i, j)] = n as f64 * f64::EPSILON * left.abs() + (fine + 8.0 * FINE) * size;
            }
            lengths.push((overlap(shapes, j, &momentum) - Twofold::from(1.0)).value());
            momenta.push(momentum);
        }
        let (couplings, doubts) = (shapes.tr_mul(&residuals), shapes.abs().tr_mul(&errors));
        Self { couplings, doubts, lengths, momenta }
    }
}

/// φ_iᵀ times a vector.
fn overlap(shapes: &DMatrix<f64>, i: usize, vector: &[Twofold]) -> Twofold {
    let shape = shapes.column(i);
    let low: f64 = shape.iter().zip(vector).map(|(x, entry)| x * entry.low).sum();
    Twofold::dot(shape.iter().copied().zip(vector.iter().map(|entry| entry.high))) + Twofold::from(low)
}

/// E, and the pairs of modes that it does not tell apart: along these it makes them orthogonal, no more.
fn corrections(left: &Residuals, squares: &[Twofold], shapes: &DMatrix<f64>) -> (DMatrix<f64>, Vec<(usize, usize)>) {
    let n = squares.len();
    let gap = |i: usize, j: usize| (squares[j] - squares[i]).value();
    let are_apart = |i: usize, j: usize| {
        let (coupling, gap) = (left.couplings[(i, j)], gap(i, j));
        let rounding = 4.0 * f64::EPSILON * (squares[i].high.abs() + squares[j].high.abs());
        let along = (coupling / gap).abs();
        // A gap that rounding of the coupling would bridge is none, however small the coupling happens to be.
        let is_gap = left.doubts[(i, j)] <= APART * gap.abs();
        is_gap && (along <= ALIKE || along <= APART && coupling.abs() > rounding)
    };
    let mut open = Vec::new();
    let by = DMatrix::from_fn(n, n, |i, j| {
        if i == j {
            return -0.5 * left.lengths[j];
        }
        if are_apart(i, j) && are_apart(j, i) {
            return left.couplings[(i, j)] / gap(i, j);
        }
        open.push((i, j));
        -0.5 * overlap(shapes, i, &left.momenta[j]).value()
    });
    (by, open)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ring has its modes in pairs of one frequency: along its partner a mode is any combination, and no error of that is told.
    #[test]
    fn modes_of_one_frequency_have_errors_of_rounding() {
        for n in 3..40 {
            let stiffness = DMatrix::from_fn(n, n, |i, j| match (i + n - j) % n {
                0 => 0.4,
                1 => -0.1,
                apart if apart == n - 1 => -0.1,
                _ => 0.0,
            });
            let mass: DMatrix<f64> = DMatrix::identity(n, n);
            let eigen = stiffness.clone().symmetric_eigen();
            let basis = Basis::refined(&mass, &stiffness, eigen.eigenvectors, eigen.eigenvalues.as_slice());
            assert!(basis.shape_errors.amax() < 1e-15, "{n}: {:e}", basis.shape_errors.amax());
            assert!(basis.square_errors.iter().all(|error| *error < 1e-15), "{n}: {:?}", basis.square_errors);
        }
    }
}
