//! An orbit that may begin at any time has its own derivative as a null vector of J(1): the equations without it.

use vibrochain_lattice::{BlochMode, Complex, Turned};

use super::BlochEquations;

type C = Complex<f64>;

/// An orbit's own derivative, as [`BlochEquations::leave_out_shift`] has put it in place of one unknown.
#[derive(Debug, Clone, PartialEq)]
pub struct Shift {
    /// The row and column in whose place it is.
    pub place: usize,
    /// s: what each impact's ωPδt is in it.
    pub weights: Vec<f64>,
    /// What was in its place, of each mode, and J₀ outside.
    row: Vec<[f64; 2]>,
    column: Vec<[f64; 2]>,
    outside: Vec<f64>,
}

impl Shift {
    /// Row number `r` of A_k as it was, where `rows` are those with the derivative in their place.
    pub fn row_before(&self, rows: &[[f64; 2]], k: usize, r: usize) -> [f64; 2] {
        if r == self.place { self.row[k] } else { rows[r] }
    }

    /// Column number `r` of C_k as it was.
    pub fn column_before(&self, columns: &[[f64; 2]], k: usize, r: usize) -> [f64; 2] {
        if r == self.place { self.column[k] } else { columns[r] }
    }

    /// J₀ outside as it was.
    pub fn constant_before(&self) -> &[f64] {
        &self.outside
    }
}

impl BlochEquations {
    /// Leaves its own derivative s out of the equations of an orbit that may begin at any time: s is the same δt for all impacts, J(1)s = 0 and
    /// sᵀJ(1) = 0. It takes the place of one δt, and its row and column are divided by z−1,
    ///
    /// ```text
    /// (J(z)s)/(z−1) = −Σ A_k R_k(z−R_k)⁻¹ (1−R_k)⁻¹C_k s,     the row alike, the corner with (1−R_k)⁻².
    /// ```
    ///
    /// So they have the form of J, nothing cancels next to z = 1, and their determinant is det J(z)/(z−1)² but for a factor. `None`, and
    /// all as it was, where a mode's pole is 1, and where modes lose energy.
    pub fn leave_out_shift(&mut self) -> Option<Shift> {
        let one = C::new(1.0, 0.0);
        let size = self.size();
        let largest = (0..self.impacts.len())
            .max_by(|&i, &j| self.impacts[i].impulse.abs().total_cmp(&self.impacts[j].impulse.abs()))?;
        let stays =
            |mode: &BlochMode| mode.poles().contains(&one) || mode.decay != 0.0 || !mode.coordinates.are_circular();
        if self.kernel.modes().iter().any(stays) {
            return None;
        }
        let scale = self.impacts[largest].impulse;
        let weights: Vec<f64> = self.impacts.iter().map(|impact| impact.impulse / scale).collect();
        let place = 2 * largest + 1;
        let count = self.kernel.modes().len();
        let [mut row, mut column] = [(); 2].map(|()| Vec::with_capacity(count));
        for (k, mode) in self.kernel.modes().iter().enumerate() {
            let coordinates = mode.coordinates;
            // (1−R)⁻¹ is ½(1 + cot(ΩT/2)·J); 1−cos ΩT would lose its digits next to a resonance.
            let Turned { even: cos, odd: sin } = mode.period;
            let cot = if cos > 0.0 { (1.0 + cos) / sin } else { sin / (1.0 - cos) };
            let by = Turned { even: -0.5, odd: -0.5 * cot };
            let sum = |table: &[[f64; 2]]| {
                let terms = weights.iter().enumerate().map(|(i, weight)| table[2 * i + 1].map(|x| weight * x));
                terms.fold([0.0; 2], |[x, y], [u, v]| [x + u, y + v])
            };
            let (seen, given) = (coordinates.seen(sum(self.rows(k)), by), coordinates.given(by, sum(self.columns(k))));
            row.push(std::mem::replace(&mut self.rows[k * size + place], seen));
            column.push(std::mem::replace(&mut self.columns[k * size + place], given));
        }
        let outside = self.outside.clone();
        for j in 0..size {
            self.outside[place * size + j] = 0.0;
            self.outside[j * size + place] = 0.0;
        }
        self.innermost = 0.0;
        Some(Shift { place, weights, row, column, outside })
    }
}
