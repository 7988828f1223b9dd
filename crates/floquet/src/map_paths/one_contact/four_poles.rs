//! The determinants that give the residues, at four poles at once, for one or two impacts: a fast path beside the elimination of [`vibrochain_breather::linear`].
//!
//! No pivot is sought, so that four poles go alike: the bordered matrix (see [`crate::map_paths::one_contact::multipliers`])
//!
//! ```text
//! ⎡ K̂(p)  W ⎤     W = (w, e^{iΩτ}w),         w = (1, iΩ/ω)
//! ⎣ Ṽᵀ    0 ⎦     Ṽ = (ṽ, e^{−iΩτ}ṽ),   ṽ = ½(1, −iω/Ω)
//! ```
//!
//! is expanded by the minors of the two rows of either impact (Laplace), products only.

use std::ops::{Add, Mul, Sub};

use nalgebra::Complex;
use vibrochain_lattice::simd::lanes::{HALF, ONE, ZERO, all};
use wide::f64x4;

use crate::map_paths::one_contact::other_modes::FourSums;

/// Four complex numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Four {
    re: f64x4,
    im: f64x4,
}

impl Four {
    fn new(re: f64x4, im: f64x4) -> Self {
        Self { re, im }
    }

    /// One of them.
    pub(crate) fn one(&self, lane: usize) -> Complex<f64> {
        Complex::new(self.re.to_array()[lane], self.im.to_array()[lane])
    }

    fn real(re: f64x4) -> Self {
        Self { re, im: ZERO }
    }
}

impl Add for Four {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Sub for Four {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }
}

impl Mul for Four {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}

/// The determinant of the bordered matrix at four poles. `shared` is what K̂ has at all poles alike, `ratio` Ω/ω of their modes,
/// `turn` cos, sin Ωτ of the time τ between two impacts. `None` for more than two.
pub(crate) fn bordered(sums: &FourSums, shared: &[f64], ratio: f64x4, turn: Option<[f64x4; 2]>) -> Option<Four> {
    let inverse = ONE / ratio;
    let [u, up, down] = sums.own;
    match (sums.pairs.as_slice(), turn, shared) {
        ([], _, &[loss, _, kappa, _]) => {
            // −Ṽᵀ adj K̂ W, whose diagonal is one number.
            let (even, up, down) = (Four::new(all(loss), ZERO - u), ZERO - up, all(kappa) + down);
            Some(Four::new(ZERO, HALF * (ratio * up - down * inverse)) - even)
        }
        (&[[uc, vs, vc_up, us_up, vc_down, us_down]], Some([cos, sin]), shared) if shared.len() == 16 => {
            let at = |row: usize, column: usize| all(shared[4 * row + column]);
            let even = |i: usize| Four::new(at(2 * i, 2 * i), ZERO - u);
            let own_up = Four::real(ZERO - up);
            let own_down = |i: usize| Four::real(at(2 * i + 1, 2 * i) + down);
            let off = |row: usize, column: usize, sign: f64x4| {
                let even = Four::new(at(row, column) + sign * vs, ZERO - uc);
                let up = Four::new(at(row, column + 1) - vc_up, ZERO - sign * us_up);
                let down = Four::new(at(row + 1, column) + vc_down, sign * us_down);
                [even, up, down]
            };
            let ([early, early_up, early_down], [late, late_up, late_down]) = (off(0, 2, ZERO - ONE), off(2, 0, ONE));
            let wave = Four::new(cos, sin);
            let forth = Four::new(ZERO - ratio * sin, ratio * cos);
            let rows = [
                [even(0), own_up, early, early_up, Four::real(ONE)],
                [own_down(0), even(0), early_down, early, Four::new(ZERO, ratio)],
                [late, late_up, even(1), own_up, wave],
                [late_down, late, own_down(1), even(1), forth],
            ];
            let back = [
                Four::real(HALF),
                Four::new(ZERO, ZERO - HALF * inverse),
                Four::new(HALF * cos, ZERO - HALF * sin),
                Four::new(ZERO - HALF * inverse * sin, ZERO - HALF * inverse * cos),
            ];
            Some(expanded(&rows, back))
        }
        _ => None,
    }
}

/// The determinant of four rows of five and a last one, whose last entry is 0.
fn expanded(rows: &[[Four; 5]; 4], last: [Four; 4]) -> Four {
    let minors = |first: usize| -> [[Four; 5]; 5] {
        let (a, b) = (&rows[first], &rows[first + 1]);
        std::array::from_fn(|i| {
            std::array::from_fn(|j| if i < j { a[i] * b[j] - a[j] * b[i] } else { Four::real(ZERO) })
        })
    };
    let (m, n) = (minors(0), minors(2));
    let mut sum = Four::real(ZERO);
    for (column, entry) in last.into_iter().enumerate() {
        let [a, b, c, d]: [usize; 4] = std::array::from_fn(|i| if i < column { i } else { i + 1 });
        let rest = m[a][b] * n[c][d] - m[a][c] * n[b][d] + m[a][d] * n[b][c] + m[b][c] * n[a][d] - m[b][d] * n[a][c]
            + m[c][d] * n[a][b];
        let term = entry * rest;
        sum = if column % 2 == 0 { sum + term } else { sum - term };
    }
    sum
}
