//! The null vector of a table of enclosures, and what its other rows leave: orbits sought in a plane are where nothing is left.
//!
//! On each rectangle the table W is multiplied by what makes it the unit matrix at the middle but for one column, the number of the null vector that
//! is largest there; what is left is eliminated in enclosures. So no determinant that vanishes somewhere divides anything, unless W loses two ranks.

use crate::roots::patch::Patch;

/// Rows, and columns, at most.
pub(super) const MOST: usize = 8;

/// W, or what is left of it.
pub(super) type Table = [[Patch; MOST]; MOST];

/// How many rows and columns of a table are used.
#[derive(Debug, Clone, Copy)]
pub(super) struct Elimination {
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// The size of each row at least: all its entries may vanish at once.
    pub(super) least: [f64; MOST],
}

/// A null vector, and what the last two rows leave; where there are as many rows as columns both are the last one.
pub(super) struct Reduced {
    pub(super) numbers: [Patch; MOST],
    pub(super) left: [Patch; 2],
}

/// W's rows are multiplied by `factors`, its columns by `sizes`, and these come in another order.
struct Prepared {
    factors: [[f64; MOST]; MOST],
    order: [usize; MOST],
    sizes: [f64; MOST],
    /// The size of the last pivot.
    last: f64,
}

impl Elimination {
    /// The size of the last pivot at the middle: 0 but for rounding where W has lost two ranks.
    pub(super) fn last_pivot(&self, table: &Table) -> f64 {
        self.prepared(table).last
    }

    /// What makes W nearly the unit matrix.
    fn prepared(&self, table: &Table) -> Prepared {
        let (rows, columns) = (self.rows, self.columns);
        let mut values = [[0.0; 2 * MOST]; MOST];
        for i in 0..rows {
            let largest = table[i][..columns].iter().map(|x| x.value().abs()).fold(self.least[i], f64::max);
            for j in 0..columns {
                values[i][j] = table[i][j].value() / largest;
            }
            values[i][columns + i] = largest.recip();
        }
        let mut sizes = [1.0; MOST];
        for j in 0..columns {
            let largest = values.iter().map(|row| row[j].abs()).fold(f64::MIN_POSITIVE, f64::max);
            sizes[j] = largest.recip();
            values.iter_mut().for_each(|row| row[j] /= largest);
        }
        let mut order = std::array::from_fn(|j| j);
        let mut last = 1.0;
        for k in 0..columns - 1 {
            let places = (k..rows).flat_map(|i| (k..columns).map(move |j| (i, j)));
            let size = |(i, j): (usize, usize)| values[i][j].abs();
            let Some((row, column)) = places.max_by(|a, b| size(*a).total_cmp(&size(*b))) else { break };
            values.swap(k, row);
            order.swap(k, column);
            values.iter_mut().for_each(|row| row.swap(k, column));
            last = values[k][k].abs();
            let pivot = if last < f64::EPSILON { f64::EPSILON } else { values[k][k] };
            values[k].iter_mut().for_each(|x| *x /= pivot);
            let own = values[k];
            for (i, row) in values.iter_mut().enumerate().take(rows) {
                let by = row[k];
                if i != k && by != 0.0 {
                    row.iter_mut().zip(&own).for_each(|(x, own)| *x -= by * own);
                }
            }
        }
        let factors = values.map(|row| std::array::from_fn(|i| row[(columns + i).min(2 * MOST - 1)]));
        Prepared { factors, order, sizes, last }
    }

    /// The null vector of W and what is left over; the pivot that may vanish, where that is not known.
    pub(super) fn reduced(&self, table: &Table) -> Result<Reduced, Patch> {
        let (rows, unknowns) = (self.rows, self.columns - 1);
        let Prepared { factors, order, sizes, .. } = self.prepared(table);
        let mut left = *table;
        for i in 0..rows {
            for (j, &column) in order.iter().enumerate().take(self.columns) {
                let terms = (0..rows).map(|l| table[l][column].scaled(factors[i][l] * sizes[column]));
                left[i][j] = terms.reduce(|a, b| a + b).unwrap_or(left[i][j]);
            }
        }
        let mut inverses = [left[0][0]; MOST];
        for k in 0..unknowns {
            inverses[k] = left[k][k].reciprocal().ok_or(left[k][k])?;
            for i in k + 1..rows {
                let by = left[i][k] * inverses[k];
                for j in k + 1..=unknowns {
                    left[i][j] = left[i][j] - by * left[k][j];
                }
            }
        }
        let mut found = [Patch::constant(1.0, inverses[0].radius()); MOST];
        for k in (0..unknowns).rev() {
            let sum = (k + 1..unknowns).fold(left[k][unknowns], |sum, j| sum + left[k][j] * found[j]);
            found[k] = -(sum * inverses[k]);
        }
        let mut numbers = found;
        for (number, &column) in found.iter().zip(&order).take(self.columns) {
            numbers[column] = number.scaled(sizes[column]);
        }
        Ok(Reduced { numbers, left: [left[unknowns][unknowns], left[rows - 1][unknowns]] })
    }
}
