//! Bounds of a Taylor series over a window: the arithmetic of "no impact can hide".
//!
//! Write x(s) = p₀(s) with p_k(s) = d_k + s/(k+1) · p_{k+1}(s). For 0 ≤ s ≤ H, U_{k+1} ≥ p_{k+1} implies
//!
//! ```text
//! p_k(s) ≤ U_k = d_k + H/(k+1) · max(0, U_{k+1}) ,
//! ```
//!
//! and mirrored for the lower bound. One pass from the highest order down gives U₀ ≥ x over the whole window,
//! and on the way U₂ with x(s) ≤ d₀ + d₁s + U₂s²/2, a parabola above the motion. Started at the second derivative,
//! d₂ + s d₃ + …, the same pass bounds the curvature.
//!
//! For the whole ring the pass begins at order J, not at the top: |d_{k+2}| ≤ r²|d_k| + |F_k| for the largest
//! entries of the rows (with dashpots r² max(|d_k|, |d_{k+1}|/r), and twice the last term below), so that with E the larger of max|d_J| and max|d_{J+1}|/r
//!
//! ```text
//! |p_J| ≤ E/(1−q) + A r^{J−2} q/(2(1−q)²) ,      q = rH/(J+1) .
//! ```

use std::ops::Range;

use wide::f64x8;

use crate::series::{LANES, Rows};
use crate::units::{Growth, MAX_ORDER};

/// Order at which the bound of a whole ring begins.
pub(crate) const TAIL: usize = 6;

/// Relative enlargement of every bound: the rounding of a pass of some seventy operations, with room.
const INFLATE: f64 = 1.0 + 128.0 * f64::EPSILON;

/// H/(k+1).
pub(crate) fn fractions(horizon: f64) -> [f64; MAX_ORDER + 1] {
    let mut table = [0.0; MAX_ORDER + 1];
    for (k, entry) in table.iter_mut().enumerate() {
        *entry = horizon / (k + 1) as f64;
    }
    table
}

fn positive(a: f64) -> f64 {
    if a > 0.0 { a } else { 0.0 }
}

/// The largest size in a row.
pub(crate) fn largest(row: &[f64]) -> f64 {
    let larger = |most: f64, d: f64| if d > most { d } else { most };
    let Some(end) = row.last_chunk::<LANES>() else { return row.iter().fold(0.0, |most, d| larger(most, d.abs())) };
    // The last eight may have been seen in part: a largest size does not change.
    let groups = row.as_chunks::<LANES>().0.iter().chain([end]);
    let most = groups.fold(f64x8::ZERO, |most, group| most.fast_max(f64x8::from(*group).abs()));
    let [a, b, c, d, e, f, g, h] = most.to_array();
    larger(larger(larger(a, e), larger(b, f)), larger(larger(c, g), larger(d, h)))
}

/// Bound on |p_J| for every mass of a ring.
pub(crate) fn tail(rows: &Rows, sites: usize, growth: Growth, horizon: f64) -> f64 {
    let largest = |k: usize| largest(&rows.row(k, 0)[..sites]);
    let edge = positive(largest(TAIL).max(largest(TAIL + 1) / growth.rate));
    let q = growth.rate * horizon / (TAIL + 1) as f64;
    let forced = growth.forced * growth.rate.powi(TAIL as i32 - 2) * q / ((1.0 - q) * (1.0 - q));
    (edge / (1.0 - q) + forced) * INFLATE
}

/// Bounds of eight neighbouring masses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Group {
    /// s·(upper bound of p₁) and s²/2·p₂: x ≤ d₀ + `rise`, and `bend_up` ≥ p₂.
    pub(crate) rise: f64x8,
    pub(crate) fall: f64x8,
    pub(crate) bend_up: f64x8,
    pub(crate) bend_down: f64x8,
}

/// Upper and lower bounds of the displacements of masses `base` … `base`+7 relative to their start, over the window
/// whose `fractions` are given.
#[inline(always)]
pub(crate) fn group(rows: &Rows, base: usize, from: usize, tail: f64, fractions: &[f64; MAX_ORDER + 1]) -> Group {
    let zero = f64x8::ZERO;
    // From bounds of p_{k+1} to bounds of p_k.
    let pass = |(up, down): (f64x8, f64x8), (row, h): (f64x8, &f64)| {
        let h = f64x8::splat(*h);
        (row + h * up.fast_max(zero), row + h * down.fast_min(zero))
    };
    let from_down_to = |orders: Range<usize>| rows.eights(orders.clone(), base).zip(fractions[orders].iter().rev());
    let bend = from_down_to(2..from).fold((f64x8::splat(tail), f64x8::splat(-tail)), pass);
    let (up, down) = from_down_to(1..2).fold(bend, pass);
    let [h, inflate, more] = [fractions[0], INFLATE, INFLATE - 1.0].map(f64x8::splat);
    Group {
        rise: h * up.fast_max(zero) * inflate,
        fall: h * down.fast_min(zero) * inflate,
        bend_up: bend.0 + bend.0.abs() * more,
        bend_down: bend.1 - bend.1.abs() * more,
    }
}

/// Upper and lower bound of one series over a window, under way: the highest terms come first.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Enclosure {
    up: f64,
    down: f64,
}

impl Enclosure {
    /// Of p_{k+1}, from now on of p_k = d_k + s/(k+1) · p_{k+1}, the most of s/(k+1) being `part`.
    #[inline(always)]
    pub(crate) fn add(&mut self, d: f64, part: f64) {
        self.up = d + part * positive(self.up);
        self.down = d - part * positive(-self.down);
    }

    /// The bounds, rounding of the way here included.
    pub(crate) fn bounds(self) -> (f64, f64) {
        let Self { up, down } = self;
        (up + up.abs() * (INFLATE - 1.0), down - down.abs() * (INFLATE - 1.0))
    }
}

/// Upper and lower bound over [0, H] of the polynomial Σ c_k s^k, plain Taylor coefficients.
pub(crate) fn polynomial(c: &[f64], horizon: f64) -> (f64, f64) {
    let mut enclosure = Enclosure::default();
    c.iter().rev().for_each(|c| enclosure.add(*c, horizon));
    enclosure.bounds()
}

#[cfg(test)]
mod tests;
