//! A small square matrix, by rows, and the two operations that the deflation of known eigenvectors needs.

/// A square matrix stored by rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Square {
    size: usize,
    entries: Vec<f64>,
}

impl Square {
    /// The zero matrix.
    pub fn zeros(size: usize) -> Self {
        Self { size, entries: vec![0.0; size * size] }
    }

    /// The matrix with these entries, row after row; `None` unless there are `size`² of them.
    pub fn from_rows(size: usize, entries: Vec<f64>) -> Option<Self> {
        (Some(entries.len()) == size.checked_mul(size)).then_some(Self { size, entries })
    }

    /// The unit matrix.
    pub fn identity(size: usize) -> Self {
        let mut unit = Self::zeros(size);
        unit.set_identity(size);
        unit
    }

    /// Becomes the unit matrix of this size, without allocation if it has been as large before.
    pub(crate) fn set_identity(&mut self, size: usize) {
        self.reset(size);
        for i in 0..size {
            self.entries[i * size + i] = 1.0;
        }
    }

    /// Becomes the zero matrix of this size.
    pub(crate) fn reset(&mut self, size: usize) {
        self.size = size;
        self.entries.clear();
        self.entries.resize(size * size, 0.0);
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.size
    }

    /// All entries, row after row.
    pub fn entries(&self) -> &[f64] {
        &self.entries
    }

    /// Entry (row, column); 0 outside the matrix.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        if column < self.size { self.entries.get(row * self.size + column).copied().unwrap_or(0.0) } else { 0.0 }
    }

    pub(crate) fn row_mut(&mut self, row: usize) -> &mut [f64] {
        let n = self.size;
        &mut self.entries[row * n..(row + 1) * n]
    }

    pub(crate) fn row(&self, row: usize) -> &[f64] {
        &self.entries[row * self.size..(row + 1) * self.size]
    }

    /// Rows `i` < `j` at once.
    pub(crate) fn two_rows_mut(&mut self, i: usize, j: usize) -> (&mut [f64], &mut [f64]) {
        let n = self.size;
        let (head, tail) = self.entries.split_at_mut(j * n);
        (&mut head[i * n..(i + 1) * n], &mut tail[..n])
    }

    /// Frobenius norm.
    pub fn norm(&self) -> f64 {
        self.entries.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// All entries are finite, and so small that their squares are, too: beyond it eigenvalue iterations overflow.
    pub(crate) fn is_finite(&self) -> bool {
        self.norm().is_finite()
    }

    /// H·A·H with the reflection H that takes the direction of `vector` to the first axis.
    pub(crate) fn reflect(&mut self, reflector: &Reflector) {
        let (n, w) = (self.size, reflector.normal.as_slice());
        for row in self.entries.chunks_exact_mut(n.max(1)) {
            reflector.apply(row);
        }
        for column in 0..n {
            let dot: f64 = (0..n).map(|i| w[i] * self.entries[i * n + column]).sum();
            for i in 0..n {
                self.entries[i * n + column] -= 2.0 * dot * w[i];
            }
        }
    }

    /// Removes the first row and column.
    pub(crate) fn drop_first(&mut self) {
        let n = self.size;
        for row in 1..n {
            for column in 1..n {
                self.entries[(row - 1) * (n - 1) + column - 1] = self.entries[row * n + column];
            }
        }
        self.size = n.saturating_sub(1);
        self.entries.truncate(self.size * self.size);
    }
}

/// A Householder reflection I − 2wwᵀ.
#[derive(Debug, Clone, Default)]
pub(crate) struct Reflector {
    normal: Vec<f64>,
}

impl Reflector {
    /// The reflection that takes the direction of `vector` to ± the first axis; the identity for a zero vector.
    pub(crate) fn set(&mut self, vector: impl Iterator<Item = f64>) {
        self.normal.clear();
        self.normal.extend(vector);
        let scale = self.normal.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if scale == 0.0 || !scale.is_finite() {
            self.normal.iter_mut().for_each(|x| *x = 0.0);
            return;
        }
        let length = scale * self.normal.iter().map(|x| (x / scale).powi(2)).sum::<f64>().sqrt();
        let Some(first) = self.normal.first_mut() else { return };
        // The sign that adds: w never cancels.
        *first += length.copysign(*first);
        let squared: f64 = self.normal.iter().map(|x| (x / length).powi(2)).sum();
        let factor = 1.0 / (length * squared.sqrt());
        self.normal.iter_mut().for_each(|x| *x *= factor);
    }

    /// Reflects one vector.
    pub(crate) fn apply(&self, vector: &mut [f64]) {
        let dot: f64 = vector.iter().zip(&self.normal).map(|(x, w)| x * w).sum();
        for (x, w) in vector.iter_mut().zip(&self.normal) {
            *x -= 2.0 * dot * w;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflection_takes_the_vector_to_the_first_axis_and_keeps_eigenvalues() {
        let mut reflector = Reflector::default();
        let v = [3e200, 0.0, 4e200];
        reflector.set(v.into_iter());
        let mut image = v;
        reflector.apply(&mut image);
        assert!((image[0] + 5e200).abs() < 1e186 && image[2].abs() < 1e186);
        let mut a = Square::identity(3);
        a.row_mut(0).copy_from_slice(&[2.0, 1.0, 0.0]);
        a.row_mut(2).copy_from_slice(&[0.5, 0.0, -1.0]);
        a.reflect(&reflector);
        let trace: f64 = (0..3).map(|i| a.at(i, i)).sum();
        assert!((trace - 2.0).abs() < 1e-15);
        a.drop_first();
        assert_eq!((a.size(), a.entries().len()), (2, 4));
    }
}
