//! Linear systems of at most six unknowns: the Jacobian of an orbit's equations, bordered by the parameter's column and
//! one more row.

use crate::equations::MOST;

/// Unknowns of an orbit and the parameter.
pub(crate) const WIDTH: usize = MOST + 1;

pub(crate) type Vector = [f64; WIDTH];
pub(crate) type Matrix = [Vector; WIDTH];

/// Elimination with exchange of rows, each weighed by its largest entry. Returns the determinant of the matrix with its
/// rows scaled to length 1, which is 0 exactly only where elimination breaks down, and leaves the solution in `right`.
pub(crate) fn eliminate(mut matrix: Matrix, right: &mut Vector, size: usize) -> f64 {
    let mut determinant = 1.0;
    for i in 0..size {
        let length = matrix[i][..size].iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return 0.0;
        }
        matrix[i] = matrix[i].map(|x| x / length);
        right[i] /= length;
    }
    for column in 0..size {
        let pivot = (column..size).max_by(|&i, &j| matrix[i][column].abs().total_cmp(&matrix[j][column].abs()));
        let pivot = pivot.unwrap_or(column);
        if pivot != column {
            matrix.swap(column, pivot);
            right.swap(column, pivot);
            determinant = -determinant;
        }
        let head = matrix[column][column];
        determinant *= head;
        if head == 0.0 || !head.is_finite() {
            return 0.0;
        }
        for i in column + 1..size {
            let factor = matrix[i][column] / head;
            for j in column..size {
                matrix[i][j] -= factor * matrix[column][j];
            }
            right[i] -= factor * right[column];
        }
    }
    for i in (0..size).rev() {
        let known: f64 = (i + 1..size).map(|j| matrix[i][j] * right[j]).sum();
        right[i] = (right[i] - known) / matrix[i][i];
    }
    determinant
}

/// The solution, `None` for a singular matrix.
pub(crate) fn solve(matrix: &Matrix, right: &Vector, size: usize) -> Option<Vector> {
    let mut solution = *right;
    let determinant = eliminate(*matrix, &mut solution, size);
    (determinant != 0.0 && solution[..size].iter().all(|x| x.is_finite())).then_some(solution)
}

/// The determinant with rows scaled to length 1.
pub(crate) fn determinant(matrix: &Matrix, size: usize) -> f64 {
    eliminate(*matrix, &mut [0.0; WIDTH], size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_solve_and_determinants_have_their_sign() {
        let mut matrix = [[0.0; WIDTH]; WIDTH];
        // 0 in the first place asks for an exchange; the second row is a thousand times the natural size.
        matrix[0][..3].copy_from_slice(&[0.0, 2.0, 1.0]);
        matrix[1][..3].copy_from_slice(&[3000.0, -1000.0, 4000.0]);
        matrix[2][..3].copy_from_slice(&[1.0, 1.0, 1.0]);
        let mut right = [0.0; WIDTH];
        right[..3].copy_from_slice(&[7.0, 13_000.0, 6.0]);
        let x = solve(&matrix, &right, 3).unwrap();
        for (x, expected) in x.iter().zip([1.0, 2.0, 3.0]) {
            assert!((x - expected).abs() < 1e-14, "{x} {expected}");
        }
        // det = 6000, over the lengths of the rows.
        let lengths = 5f64.sqrt() * 26e6f64.sqrt() * 3f64.sqrt();
        assert!((determinant(&matrix, 3) - 6000.0 / lengths).abs() < 1e-15);
        matrix[2] = matrix[0];
        assert_eq!(determinant(&matrix, 3), 0.0);
        assert!(solve(&matrix, &right, 3).is_none());
    }
}
