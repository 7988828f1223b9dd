//! Determinants of small complex matrices, by rows.

use nalgebra::Complex;
use smallvec::SmallVec;

type C = Complex<f64>;

/// Rows up to which nothing is allocated: two for each of eight impacts, and one.
const MOST: usize = 17;

/// Determinant by elimination with partial pivoting; the matrix is used up.
pub(super) fn determinant(matrix: &mut [C], size: usize) -> C {
    let mut product = C::new(1.0, 0.0);
    for column in 0..size {
        let (mut pivot, mut largest) = (column, 0.0);
        for row in column..size {
            let modulus = matrix[row * size + column].norm_sqr();
            if modulus > largest {
                (pivot, largest) = (row, modulus);
            }
        }
        if largest == 0.0 {
            return C::default();
        }
        if pivot != column {
            for j in column..size {
                matrix.swap(pivot * size + j, column * size + j);
            }
            product = -product;
        }
        let diagonal = matrix[column * size + column];
        product *= diagonal;
        let inverse = diagonal.inv();
        for row in column + 1..size {
            let factor = matrix[row * size + column] * inverse;
            for j in column + 1..size {
                let above = matrix[column * size + j];
                matrix[row * size + j] -= factor * above;
            }
        }
    }
    product
}

/// As [`determinant`], with Σ|B⁻¹_ji||B_ij|, by which relative errors of the entries are multiplied. `sizes` is scratch space.
pub(super) fn determinant_and_condition(matrix: &mut [C], sizes: &mut Vec<f64>, size: usize) -> (C, f64) {
    sizes.clear();
    sizes.extend(matrix.iter().map(|entry| entry.norm()));
    // Gauss–Jordan in place with exchange of rows: the matrix becomes B⁻¹ with its columns exchanged likewise.
    let mut order: SmallVec<[usize; MOST]> = (0..size).collect();
    let mut product = C::new(1.0, 0.0);
    for column in 0..size {
        let modulus = |row: &usize| matrix[row * size + column].norm_sqr();
        let pivot = (column..size).max_by(|a, b| modulus(a).total_cmp(&modulus(b))).unwrap_or(column);
        if pivot != column {
            for j in 0..size {
                matrix.swap(pivot * size + j, column * size + j);
            }
            order.swap(pivot, column);
            product = -product;
        }
        let diagonal = matrix[column * size + column];
        product *= diagonal;
        let inverse = diagonal.inv();
        matrix[column * size + column] = C::new(1.0, 0.0);
        for j in 0..size {
            matrix[column * size + j] *= inverse;
        }
        for row in (0..size).filter(|row| *row != column) {
            let factor = matrix[row * size + column];
            matrix[row * size + column] = C::default();
            for j in 0..size {
                let above = matrix[column * size + j];
                matrix[row * size + j] -= factor * above;
            }
        }
    }
    let mut condition = 0.0;
    for (column, row) in order.iter().enumerate() {
        condition += (0..size).map(|i| matrix[i * size + column].norm() * sizes[row * size + i]).sum::<f64>();
    }
    (product, condition)
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
