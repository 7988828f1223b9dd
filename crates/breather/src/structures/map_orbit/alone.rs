//! Whether two impacts of one contact can only be half a period apart.

use smallvec::smallvec;
use vibrochain_lattice::Turn;
use vibrochain_lattice::simd::lanes::{LANES, ZERO, four, total};

use super::modes::Modes;
use crate::motion::modal::passage::Passage;
use crate::motion::modal::view::Lanes;

/// Radians of the fastest mode in a window.
const WINDOW: f64 = 1.0;

impl Modes {
    /// Whether no other two instants are possible: −K′(T/2 + s) = Σ φ₀² sin Ωs/(2 sin ΩT/2) has no zero for 0 < s ≤ T/2.
    /// `fastest` is the rate of the fastest mode.
    pub(super) fn is_alone(&self, half: f64, fastest: f64) -> bool {
        let windows = (half * fastest / WINDOW).ceil().max(1.0);
        let length = half / windows;
        let empty = || -> Lanes { smallvec![[0.0; LANES]; self.seen.len()] };
        let (mut wave, mut turn) = ([empty(), empty()], [empty(), empty()]);
        let mut fourth = ZERO;
        for (g, wave) in wave[1].iter_mut().enumerate() {
            let omega = four(self.frequency[g]);
            let size = four(self.seen[g]) * four(self.inverse[g]) * omega;
            fourth += size.abs() * (omega * omega) * (omega * omega);
            *wave = size.to_array();
            let Some([cos, sin]) = Turn::Circular.turns(length, self.frequency[g]) else { return false };
            (turn[0][g], turn[1][g]) = (cos, sin);
        }
        let fourth = total(fourth);
        // Value and slope; the cosines' amplitudes are those of the sines.
        let jet = |[sine, cosine]: &[Lanes; 2]| {
            let mut sums = [ZERO; 2];
            for g in 0..sine.len() {
                sums = [sums[0] + four(sine[g]), sums[1] + four(cosine[g]) * four(self.frequency[g])];
            }
            sums.map(total)
        };
        let mut here = jet(&wave);
        let mut sign = 0.0;
        for window in 0..windows as usize {
            turn_on(&mut wave, &turn);
            let next = jet(&wave);
            let mut passage = Passage::new(here, next, length, fourth);
            passage.off += self.doubt;
            // 0 at its beginning, it is monotone there; then it keeps its sign.
            let clear = if window == 0 {
                sign = next[0].signum();
                !passage.may_turn([false, false])
            } else {
                passage.points.iter().all(|point| point * sign > passage.off)
            };
            if !clear {
                return false;
            }
            here = next;
        }
        true
    }
}

/// Turns the modes on by a window: what they are, and their rates over Ω.
fn turn_on([place, speed]: &mut [Lanes; 2], turn: &[Lanes; 2]) {
    for g in 0..place.len() {
        let ([x, y], [cos, sin]) = ([four(place[g]), four(speed[g])], [0, 1].map(|i| four(turn[i][g])));
        place[g] = (x * cos + y * sin).to_array();
        speed[g] = (y * cos - x * sin).to_array();
    }
}
