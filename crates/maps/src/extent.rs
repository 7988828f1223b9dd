//! Squares of cells: of the finest grid of a map, those that a leaf stands for, and the one at which it was computed.

/// Cells of the finest grid that a leaf stands for: a square of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// Its first column, counted from 0.
    pub column: u32,
    /// Its first row.
    pub row: u32,
    /// Columns and rows, a power of two.
    pub size: u32,
}

impl Extent {
    /// How many cells of the finest grid these are.
    #[must_use]
    pub fn cells(self) -> u64 {
        u64::from(self.size) * u64::from(self.size)
    }

    /// Column and row of the one that is computed for all of them: the first, so that it is that of the first quarter, too, when the
    /// square is halved, and no cell is computed twice.
    #[must_use]
    pub fn sample(self) -> [u32; 2] {
        [self.column, self.row]
    }

    /// Its quarters, the first row first.
    #[must_use]
    pub fn quarters(self) -> [Self; 4] {
        let size = self.size / 2;
        [(0, 0), (size, 0), (0, size), (size, size)].map(|(right, up)| Self {
            column: self.column + right,
            row: self.row + up,
            size,
        })
    }

    /// Whether it is a square of `whole`, which is halved any number of times, and all before it are so many cells: those of its first
    /// quarter come first, and so within each quarter.
    #[must_use]
    pub fn begins(self, whole: Self, before: u64) -> bool {
        let mut at = whole;
        let mut left = before;
        while at.size > self.size {
            let quarter = at.cells() / 4;
            at = at.quarters()[(left / quarter).min(3) as usize];
            left %= quarter;
        }
        left == 0 && at == self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_quarter_of_each_square_is_computed_where_the_square_is() {
        for depth in 1..=8 {
            let whole = Extent { column: 3 << depth, row: 5 << depth, size: 1 << depth };
            let of_quarters = whole.quarters().map(Extent::sample);
            assert_eq!(of_quarters.iter().filter(|sample| **sample == whole.sample()).count(), 1, "{depth}");
            for (quarter, sample) in whole.quarters().iter().zip(of_quarters) {
                assert!(quarter.column <= sample[0] && sample[0] < quarter.column + quarter.size);
                assert!(quarter.row <= sample[1] && sample[1] < quarter.row + quarter.size);
            }
            assert_eq!(whole.quarters().iter().map(|quarter| quarter.cells()).sum::<u64>(), whole.cells());
        }
    }
}
