//! Small dense systems by elimination with pivoting.

use crate::complex::Complex;
use crate::real::Real;

/// Rows of a matrix.
pub(crate) type Matrix = Vec<Vec<Real>>;

/// A B. Zeros of A cost nothing: blocks that are none stay free.
pub(crate) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let row = |line: &Vec<Real>| {
        let known: Vec<_> = line.iter().zip(b).filter(|(x, _)| !x.is_zero()).collect();
        let entry = |j: usize| {
            let terms = known.iter().filter(|(_, row)| !row[j].is_zero());
            terms.fold(Real::zero(line[0].bits()), |sum, (x, row)| sum + *x * &row[j])
        };
        (0..b[0].len()).map(entry).collect()
    };
    a.iter().map(row).collect()
}

/// A x
pub(crate) fn times(a: &Matrix, x: &[Real]) -> Vec<Real> {
    a.iter().map(|row| dot(row, x)).collect()
}

/// xᵀy
pub(crate) fn dot(x: &[Real], y: &[Real]) -> Real {
    let terms = x.iter().zip(y).filter(|(x, _)| !x.is_zero());
    terms.fold(Real::zero(64), |sum, (x, y)| sum + x * y)
}

/// Solves A x = b; `None` for a singular A.
pub(crate) fn solve(mut a: Vec<Vec<Real>>, mut b: Vec<Real>) -> Option<Vec<Real>> {
    let n = b.len();
    for column in 0..n {
        // Rows are of one scale here: the largest entry is pivot enough.
        let pivot = (column..n)
            .filter(|&row| !a[row][column].is_zero() && a[row][column].is_finite())
            .max_by(|&i, &j| a[i][column].log2_abs().total_cmp(&a[j][column].log2_abs()))?;
        a.swap(column, pivot);
        b.swap(column, pivot);
        let (top, below) = a.split_at_mut(column + 1);
        let (top_b, below_b) = b.split_at_mut(column + 1);
        for (row, b) in below.iter_mut().zip(below_b) {
            let factor = &row[column] / &top[column][column];
            for (x, y) in row.iter_mut().zip(&top[column]).skip(column) {
                *x -= &factor * y;
            }
            *b -= &factor * &top_b[column];
        }
    }
    for row in (0..n).rev() {
        for column in row + 1..n {
            let known = &a[row][column] * &b[column];
            b[row] -= known;
        }
        b[row] = &b[row] / &a[row][row];
    }
    b.iter().all(Real::is_finite).then_some(b)
}

/// Determinant; zero for a matrix without a pivot left.
pub(crate) fn determinant(mut a: Vec<Vec<Complex>>, bits: usize) -> Complex {
    let n = a.len();
    let mut product = Complex::new(1.0, 0.0, bits);
    for column in 0..n {
        let pivot =
            (column..n).max_by(|&i, &j| a[i][column].log2_abs().total_cmp(&a[j][column].log2_abs())).unwrap_or(column);
        if pivot != column {
            a.swap(column, pivot);
            product = -product;
        }
        product = product * &a[column][column];
        if product.is_zero() {
            return product;
        }
        let inverse = a[column][column].inverse();
        let (top, below) = a.split_at_mut(column + 1);
        for row in below {
            let factor = &row[column] * &inverse;
            for (x, y) in row.iter_mut().zip(&top[column]).skip(column + 1) {
                *x = &*x - &factor * y;
            }
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hilbert_system_and_a_vandermonde_determinant() {
        // Σ_j 1/(i+j+1) = b_i has the solution 1, …, 1; condition 1e13.
        let entry = |i: usize, j: usize| Real::one(192) / (i + j + 1) as f64;
        let a: Vec<Vec<Real>> = (0..9).map(|i| (0..9).map(|j| entry(i, j)).collect()).collect();
        let b = a.iter().map(|row| row.iter().fold(Real::zero(192), |sum, x| sum + x)).collect();
        let x = solve(a, b).unwrap();
        assert!(x.iter().all(|x| (x - &Real::one(64)).log10_abs() < -42.0));
        assert!(solve(vec![vec![Real::zero(64); 2]; 2], vec![Real::one(64); 2]).is_none());

        let nodes = [(0.0, 0.0), (1.0, 2.0), (-3.0, 0.5), (2.0, -1.0)].map(|(x, y)| Complex::new(x, y, 192));
        let mut matrix = vec![];
        let mut expected = Complex::new(1.0, 0.0, 192);
        for (i, node) in nodes.iter().enumerate() {
            let mut power = Complex::new(1.0, 0.0, 192);
            let mut row = vec![];
            for _ in 0..4 {
                row.push(power.clone());
                power = &power * node;
            }
            matrix.push(row);
            for other in &nodes[..i] {
                expected = expected * (node - other);
            }
        }
        assert!((determinant(matrix, 192) - expected).log2_abs() < -180.0);
        assert!(determinant(vec![vec![Complex::new(0.0, 0.0, 64); 2]; 2], 64).is_zero());
    }
}
