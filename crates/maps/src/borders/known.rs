//! Whether a place lies on a border that is known.

use std::collections::HashMap;

/// Squares of the window along each side, by which pieces of borders are filed.
const SQUARES: f64 = 256.0;

/// Pieces of known borders, in parts of the window's sides.
#[derive(Debug, Clone, Default)]
pub(super) struct Known {
    pieces: Vec<[[f64; 2]; 2]>,
    squares: HashMap<[i32; 2], Vec<u32>>,
}

fn square(place: f64) -> i32 {
    (place * SQUARES).floor() as i32
}

impl Known {
    pub(super) fn add(&mut self, line: &[[f64; 2]]) {
        for pair in line.windows(2) {
            let number = self.pieces.len() as u32;
            self.pieces.push([pair[0], pair[1]]);
            let range = |i: usize| {
                let (low, high) = (pair[0][i].min(pair[1][i]), pair[0][i].max(pair[1][i]));
                // What is next to a square counts for it, too.
                square(low) - 1..=square(high) + 1
            };
            for x in range(0) {
                for y in range(1) {
                    self.squares.entry([x, y]).or_default().push(number);
                }
            }
        }
    }

    /// Whether a border passes within `reach` (less than a square) of a place.
    pub(super) fn holds(&self, [x, y]: [f64; 2], reach: f64) -> bool {
        let Some(pieces) = self.squares.get(&[square(x), square(y)]) else { return false };
        pieces.iter().any(|&piece| {
            let [from, to] = self.pieces[piece as usize];
            let (chord, away) = ([to[0] - from[0], to[1] - from[1]], [x - from[0], y - from[1]]);
            let square = chord[0] * chord[0] + chord[1] * chord[1];
            let along = away[0] * chord[0] + away[1] * chord[1];
            let share = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
            (away[0] - share * chord[0]).hypot(away[1] - share * chord[1]) <= reach
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_near_a_border_is_known() {
        let mut known = Known::default();
        known.add(&[[0.1, 0.1], [0.9, 0.3], [0.9, 0.3]]);
        assert!(known.holds([0.5, 0.2], 1e-9) && known.holds([0.9, 0.3 + 1e-6], 2e-6));
        assert!(!known.holds([0.5, 0.2 + 1e-6], 1e-7) && !known.holds([0.05, 0.1], 1e-3));
    }
}
