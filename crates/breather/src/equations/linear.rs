//! Small dense matrices of real numbers, the Jacobian of an orbit's equations with or without the parameter's column and one more row; with
//! the elimination that solves them. Words of up to two impacts need no allocation.

use std::ops::{Index, IndexMut};

use smallvec::{SmallVec, smallvec};

use super::elimination::substitute;
pub use super::elimination::{
    Entry, Order, Pivots, cofactors, determinant, determinant_and_condition, eliminate, null_vectors,
};

/// Unknowns of a word of two impacts under a force: impulses, static displacement, a time and the phase; and a parameter.
pub(crate) const USUAL: usize = 6;

/// Numbers by row or by unknown.
pub type Vector = SmallVec<[f64; USUAL]>;

/// A vector of `size` zeros.
pub fn zeros(size: usize) -> Vector {
    smallvec![0.0; size]
}

/// The vector of `size` entries whose entry `place` is 1 and whose others are 0.
pub fn unit(size: usize, place: usize) -> Vector {
    (0..size).map(|i| if i == place { 1.0 } else { 0.0 }).collect()
}

/// Σ a_i b_i
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A square matrix by rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    size: usize,
    entries: SmallVec<[f64; USUAL * USUAL]>,
}

impl Matrix {
    /// Of zeros.
    pub fn zeros(size: usize) -> Self {
        Self { size, entries: smallvec![0.0; size * size] }
    }

    /// By its entries.
    pub fn from_fn(size: usize, mut entry: impl FnMut(usize, usize) -> f64) -> Self {
        let mut matrix = Self::zeros(size);
        for i in 0..size {
            matrix.row_mut(i).iter_mut().enumerate().for_each(|(j, place)| *place = entry(i, j));
        }
        matrix
    }

    /// Rows, and columns.
    pub fn size(&self) -> usize {
        self.size
    }

    /// A row.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.entries[i * self.size..(i + 1) * self.size]
    }

    /// A row, to be written.
    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.entries[i * self.size..(i + 1) * self.size]
    }

    /// Rows as columns.
    pub fn transposed(&self) -> Self {
        Self::from_fn(self.size, |i, j| self[(j, i)])
    }

    /// (A b; cᵀ d) with the column (b; d) and the row c.
    pub fn bordered(&self, column: &[f64], row: &[f64]) -> Self {
        let n = self.size;
        Self::from_fn(n + 1, |i, j| match (i < n, j < n) {
            (true, true) => self[(i, j)],
            (true, false) => column[i],
            (false, _) => row[j],
        })
    }

    /// The solution of A x = `right`; `None` for a singular matrix.
    pub fn solve(&self, right: &[f64]) -> Option<Vector> {
        let solution = Factors::new(self.clone())?.solve(right);
        solution.iter().all(|x| x.is_finite()).then_some(solution)
    }

    /// The determinant with rows scaled to length 1.
    pub fn determinant(&self) -> f64 {
        Factors::new(self.clone()).map_or(0.0, |factors| factors.determinant)
    }
}

impl Index<(usize, usize)> for Matrix {
    type Output = f64;

    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.entries[i * self.size + j]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut f64 {
        &mut self.entries[i * self.size + j]
    }
}

/// A matrix, its rows scaled to length 1, as a product of two triangular ones.
#[derive(Debug, Clone)]
pub(crate) struct Factors {
    /// Both triangles in one.
    triangles: Matrix,
    order: Order,
    /// Of the matrix's rows.
    lengths: Vector,
    /// Of the matrix with its rows scaled.
    pub(crate) determinant: f64,
}

impl Factors {
    /// `None` for a singular matrix, exactly only where elimination breaks down.
    pub(crate) fn new(mut matrix: Matrix) -> Option<Self> {
        let n = matrix.size;
        let mut lengths = zeros(n);
        for (i, length) in lengths.iter_mut().enumerate() {
            let row = matrix.row_mut(i);
            *length = dot(row, row).sqrt();
            if !(*length > 0.0 && length.is_finite()) {
                return None;
            }
            row.iter_mut().for_each(|x| *x /= *length);
        }
        let order = eliminate(&mut matrix.entries, n, Pivots::Partial)?;
        let determinant = order.determinant(&matrix.entries, n);
        let regular = matrix.entries.last().is_none_or(|last| *last != 0.0);
        regular.then_some(Self { triangles: matrix, order, lengths, determinant })
    }

    pub(crate) fn solve(&self, right: &[f64]) -> Vector {
        let mut x: Vector = self.order.rows.iter().map(|&row| right[row] / self.lengths[row]).collect();
        substitute(&self.triangles.entries, &mut x, 0);
        x
    }

    /// Row by row, for all right-hand sides at once.
    pub(crate) fn inverse(&self) -> Matrix {
        let n = self.triangles.size;
        let mut inverse = Matrix::zeros(n);
        for (i, &row) in self.order.rows.iter().enumerate() {
            inverse[(i, row)] = 1.0 / self.lengths[row];
        }
        for i in 0..n {
            let factors = self.triangles.row(i);
            let (above, own) = inverse.entries.split_at_mut(i * n);
            subtract_rows(&mut own[..n], above, &factors[..i]);
        }
        for i in (0..n).rev() {
            let factors = self.triangles.row(i);
            let (own, below) = inverse.entries[i * n..].split_at_mut(n);
            subtract_rows(own, below, &factors[i + 1..]);
            own.iter_mut().for_each(|x| *x /= factors[i]);
        }
        inverse
    }
}

/// Takes Σ factor·row over rows as long as `own` from it.
fn subtract_rows(own: &mut [f64], rows: &[f64], factors: &[f64]) {
    let n = own.len();
    for (j, own) in own.iter_mut().enumerate() {
        let mut sum = 0.0;
        for (k, factor) in factors.iter().enumerate() {
            sum += factor * rows[k * n + j];
        }
        *own -= sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_solve_and_determinants_have_their_sign() {
        // 0 in the first place asks for an exchange; the second row is a thousand times the natural size.
        let rows = [[0.0, 2.0, 1.0], [3000.0, -1000.0, 4000.0], [1.0, 1.0, 1.0]];
        let mut matrix = Matrix::from_fn(3, |i, j| rows[i][j]);
        let right = [7.0, 13_000.0, 6.0];
        let x = matrix.solve(&right).unwrap();
        for (x, expected) in x.iter().zip([1.0, 2.0, 3.0]) {
            assert!((x - expected).abs() < 1e-14, "{x} {expected}");
        }
        let inverse = Factors::new(matrix.clone()).unwrap().inverse();
        for i in 0..3 {
            assert!((dot(inverse.row(i), &right) - x[i]).abs() < 1e-14);
        }
        // det = 6000, over the lengths of the rows.
        let lengths = 5f64.sqrt() * 26e6f64.sqrt() * 3f64.sqrt();
        assert!((matrix.determinant() - 6000.0 / lengths).abs() < 1e-15);
        (0..3).for_each(|j| matrix[(2, j)] = matrix[(0, j)]);
        assert_eq!(matrix.determinant(), 0.0);
        assert!(matrix.solve(&right).is_none());
    }

    #[test]
    fn a_bordered_matrix_is_one_larger() {
        let matrix = Matrix::from_fn(2, |i, j| (2 * i + j) as f64);
        let bordered = matrix.bordered(&[7.0, 8.0], &[4.0, 5.0, 6.0]);
        let rows: Vec<_> = (0..3).map(|i| bordered.row(i).to_vec()).collect();
        assert_eq!(rows, [[0.0, 1.0, 7.0], [2.0, 3.0, 8.0], [4.0, 5.0, 6.0]]);
        assert_eq!(bordered.transposed().row(0), [0.0, 2.0, 4.0]);
    }
}
