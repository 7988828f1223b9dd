//! Small dense matrices: one elimination for real and complex entries, stored by rows. Up to eight impacts the elimination allocates nothing; neither do
//! [`Matrix`] and its factors for words of up to two, the Jacobian of an orbit's equations with or without the parameter's column and one more row.
//!
//! nalgebra's LU of fixed sizes takes 610 instructions instead of 1000 for a complex determinant of 3 × 3 and 1980 instead of 2250 for 5 × 5, half a
//! percent of a sweep of forced orbits; it has neither conditions nor null vectors, nor other sizes without allocation.

use std::iter::Sum;
use std::ops::{Add, Index, IndexMut, Mul, Neg, Sub, SubAssign};

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::Complex;

type C = Complex<f64>;

/// Unknowns of a word of two impacts under a force: impulses, static displacement, a time and the phase; and a parameter.
pub(crate) const USUAL: usize = 6;

/// Rows up to which elimination allocates nothing: two for each of eight impacts, and one.
const MOST: usize = 17;

/// Numbers by row or by unknown.
pub type Vector = SmallVec<[f64; USUAL]>;

/// What matrices are of: real or complex numbers.
pub trait Entry:
    Copy + Default + Sum + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self> + SubAssign
{
    /// 1
    const ONE: Self;

    /// The modulus.
    fn size(self) -> f64;

    /// What grows with the modulus, without a root.
    fn rank(self) -> f64;

    /// This divided by `other`.
    fn over(self, other: Self) -> Self;
}

impl Entry for C {
    const ONE: Self = Self { re: 1.0, im: 0.0 };

    fn size(self) -> f64 {
        self.norm()
    }

    fn rank(self) -> f64 {
        self.norm_sqr()
    }

    fn over(self, other: Self) -> Self {
        self * other.inv()
    }
}

impl Entry for f64 {
    const ONE: Self = 1.0;

    fn size(self) -> f64 {
        self.abs()
    }

    fn rank(self) -> f64 {
        self.abs()
    }

    fn over(self, other: Self) -> Self {
        self / other
    }
}

/// Where pivots are sought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pivots {
    /// In their column.
    Partial,
    /// In all that is left: the last one tells how singular the matrix is.
    Full,
}

/// The order of rows and columns in which a matrix is LU; both factors have taken its place, ones on the diagonal of L left out.
#[derive(Debug, Clone)]
pub struct Order {
    /// The row of the matrix that stands in each row of the factors.
    pub rows: SmallVec<[usize; MOST]>,
    /// The same of columns; empty with partial pivots, which leave them in their order.
    pub columns: SmallVec<[usize; MOST]>,
    odd: bool,
}

/// Factors a matrix in place; `None` where a pivot but the last is 0 or not a number.
#[inline]
pub fn eliminate<T: Entry>(matrix: &mut [T], size: usize, pivots: Pivots) -> Option<Order> {
    let columns = if pivots == Pivots::Full { 0..size } else { 0..0 };
    let mut order = Order { rows: (0..size).collect(), columns: columns.collect(), odd: false };
    for step in 0..size.saturating_sub(1) {
        let (mut at, mut largest) = ((step, step), 0.0);
        let columns = if pivots == Pivots::Full { step..size } else { step..step + 1 };
        for row in step..size {
            for column in columns.clone() {
                let rank = matrix[row * size + column].rank();
                if rank > largest {
                    (at, largest) = ((row, column), rank);
                }
            }
        }
        if largest == 0.0 {
            return None;
        }
        if at.0 != step {
            (0..size).for_each(|column| matrix.swap(at.0 * size + column, step * size + column));
            order.rows.swap(at.0, step);
            order.odd = !order.odd;
        }
        if at.1 != step {
            (0..size).for_each(|row| matrix.swap(row * size + at.1, row * size + step));
            order.columns.swap(at.1, step);
            order.odd = !order.odd;
        }
        let (head, tail) = matrix.split_at_mut((step + 1) * size);
        let above = &head[step * size + step..];
        let pivot = above[0];
        for row in tail.chunks_exact_mut(size) {
            let row = &mut row[step..];
            let factor = row[0].over(pivot);
            row[0] = factor;
            for (entry, above) in row.iter_mut().zip(above).skip(1) {
                *entry -= factor * *above;
            }
        }
    }
    Some(order)
}

impl Order {
    fn determinant<T: Entry>(&self, factors: &[T], size: usize) -> T {
        let one = if self.odd { -T::ONE } else { T::ONE };
        (0..size).fold(one, |product, i| product * factors[i * size + i])
    }
}

/// Solves LUx = b in place of b, the rows of which are in the order of the factors; those before `first` are 0.
fn substitute<T: Entry>(factors: &[T], x: &mut [T], first: usize) {
    let size = x.len();
    let sum = |factors: &[T], x: &[T]| factors.iter().zip(x).map(|(a, b)| *a * *b).sum::<T>();
    for i in first + 1..size {
        let known = sum(&factors[i * size + first..i * size + i], &x[first..i]);
        x[i] -= known;
    }
    for i in (0..size).rev() {
        let row = &factors[i * size..(i + 1) * size];
        x[i] = (x[i] - sum(&row[i + 1..], &x[i + 1..])).over(row[i]);
    }
}

/// x and y with xᵀA = Ay = 0, the last pivot taken for 0, on a scale of their own and in the order of the factors.
pub fn null_vectors<T: Entry>(factors: &[T], size: usize) -> [SmallVec<[T; MOST]>; 2] {
    let mut x: SmallVec<[T; MOST]> = smallvec![T::default(); size];
    let mut y = x.clone();
    (x[size - 1], y[size - 1]) = (T::ONE, T::ONE);
    for i in (0..size - 1).rev() {
        for j in i + 1..size {
            let (a, b) = (factors[j * size + i] * x[j], factors[i * size + j] * y[j]);
            x[i] -= a;
            y[i] -= b;
        }
        y[i] = y[i].over(factors[i * size + i]);
    }
    [x, y]
}

/// Determinant; the matrix is used up.
pub fn determinant<T: Entry>(matrix: &mut [T], size: usize) -> T {
    eliminate(matrix, size, Pivots::Partial).map_or(T::default(), |order| order.determinant(matrix, size))
}

/// The derivatives of a determinant that is next to 0 by its entries; the matrix is used up.
pub fn cofactors<T: Entry>(matrix: &mut [T], size: usize) -> Option<Vec<T>> {
    let order = eliminate(matrix, size, Pivots::Full)?;
    let pivots = (0..size - 1).fold(T::ONE, |product, i| product * matrix[i * (size + 1)]);
    let [x, y] = null_vectors(matrix, size);
    let mut cofactors = vec![T::default(); size * size];
    for (x, row) in x.iter().zip(&order.rows) {
        y.iter().zip(&order.columns).for_each(|(y, column)| cofactors[row * size + column] = pivots * *x * *y);
    }
    Some(cofactors)
}

/// As [`determinant`], with Σ|B⁻¹_ji||B_ij|, by which relative errors of the entries are multiplied. `sizes` is scratch space.
pub fn determinant_and_condition<T: Entry>(matrix: &mut [T], sizes: &mut Vec<f64>, size: usize) -> (T, f64) {
    sizes.clear();
    sizes.extend(matrix.iter().map(|entry| entry.size()));
    let Some(order) = eliminate(matrix, size, Pivots::Partial) else { return (T::default(), f64::INFINITY) };
    let mut condition = 0.0;
    for (unit, row) in order.rows.iter().enumerate() {
        // A column of B⁻¹.
        let mut v: SmallVec<[T; MOST]> = smallvec![T::default(); size];
        v[unit] = T::ONE;
        substitute(matrix, &mut v, unit);
        condition += v.iter().zip(&sizes[row * size..]).map(|(v, size)| v.size() * size).sum::<f64>();
    }
    (order.determinant(matrix, size), condition)
}

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

    #[test]
    fn both_determinants_agree_and_the_condition_is_that_of_the_entries() {
        // (1 + i)·3i − 2·(4 − i) and its inverse by hand.
        let entries = [C::new(1.0, 1.0), C::new(2.0, 0.0), C::new(4.0, -1.0), C::new(0.0, 3.0)];
        let expected = entries[0] * entries[3] - entries[1] * entries[2];
        assert!((determinant(&mut entries.clone(), 2) - expected).norm() < 1e-15);
        let (found, condition) = determinant_and_condition(&mut entries.clone(), &mut Vec::new(), 2);
        assert!((found - expected).norm() < 1e-15);
        let by_hand = 2.0 * ((entries[0] * entries[3]).norm() + (entries[1] * entries[2]).norm()) / expected.norm();
        assert!((condition - by_hand).abs() < 1e-14, "{condition} {by_hand}");
    }

    /// diag(1, 2, 0) has the one cofactor 2; of a rotated one the entries' errors reach it through both rotations.
    #[test]
    fn a_singular_determinant_moves_by_its_cofactors() {
        let real = |x: f64| C::new(x, 0.0);
        let mut diagonal: Vec<C> = [1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0].map(real).to_vec();
        let moved_by = |matrix: &mut Vec<C>, errors: &[f64], size: usize| -> f64 {
            cofactors(matrix, size).unwrap().iter().zip(errors).map(|(factor, error)| factor.norm() * error).sum()
        };
        assert!((moved_by(&mut diagonal, &[1e-3; 9], 3) - 2e-3).abs() < 1e-18);
        // (1, 2; 2, 4): cofactors 4, −2, −2, 1.
        let mut whole: Vec<C> = [1.0, 2.0, 2.0, 4.0].map(real).to_vec();
        assert!((moved_by(&mut whole, &[1.0, 10.0, 100.0, 1000.0], 2) - (4.0 + 20.0 + 200.0 + 1000.0)).abs() < 1e-10);
    }

    /// A product of a tall and a wide matrix has one null vector on either side.
    #[test]
    fn null_vectors_of_a_singular_matrix() {
        let mut random = vibrochain_testkit::Random(3);
        for size in [2, 3, 4, 6, 12] {
            let mut entry = || C::new(random.unit() - 0.5, random.unit() - 0.5);
            let (tall, wide): (Vec<C>, Vec<C>) = (0..size * (size - 1)).map(|_| (entry(), entry())).unzip();
            let inner = size - 1;
            let matrix: Vec<C> = (0..size * size)
                .map(|at| (0..inner).map(|k| tall[at / size * inner + k] * wide[k * size + at % size]).sum())
                .collect();
            let mut factored = matrix.clone();
            let order = eliminate(&mut factored, size, Pivots::Full).unwrap();
            let [x, y] = null_vectors(&factored, size);
            let length = |v: &[C]| v.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
            let allowed = 1e-13 * length(&x) * length(&y);
            for i in 0..size {
                let left: C = (0..size).map(|j| x[j] * matrix[order.rows[j] * size + i]).sum();
                let right: C = (0..size).map(|j| matrix[i * size + order.columns[j]] * y[j]).sum();
                assert!(left.norm() < allowed && right.norm() < allowed, "{size}: {left} {right}");
            }
        }
    }
}
