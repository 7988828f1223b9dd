//! Exact flight of all watched masses over short windows, as Taylor polynomials from the equation of motion,
//!
//! ```text
//! c_{k+2} = (−γ₁c_k − γ₂(2c_k − c_left − c_right) + F_k) / ((k+1)(k+2)) ,
//! ```
//!
//! and with dashpots the same of (k+1)c_{k+1} with c and c₂ for γ₁ and γ₂.
//!
//! Time is counted in a unit near one radian of the fastest motion: c_k would leave the range of `f64` for frequencies
//! beyond 1e16. The unit is a power of two, so that it costs no digit.
//!
//! A window is at most one radian of the fastest motion, so that ORDER terms leave a remainder below rounding. The
//! polynomials are each mass's own: far from the breather their coefficients are as small as the motion itself, and
//! bounds taken from them are as tight, which no bound common to the ring could be.

use std::ops::Range;

use vibrochain_lattice::simd::lanes::{LANES, Lane};
use vibrochain_lattice::{DistinctMasses, Model, Wave};
use wide::f64x4;

use crate::motion::Motion;
use crate::motion::polynomial::{ORDER, Polynomial, taylor};

/// Windows after which the masses are set anew from the modes, so that rounding cannot add up.
const REFRESH: usize = 32;

/// Place of mass 0 in a row of numbers; before it stands its left neighbour, once more.
const FIRST: usize = 1;

/// Masses at most whose polynomials are held at a time, of a lattice of one layer: with [`REACH`] more at either side they stay near
/// the processor.
const BLOCK: usize = 1024;

/// A coefficient knows of neighbours one step farther away than the one two orders below, and with dashpots between them than the one below.
const REACH: usize = ORDER;

/// The state of all masses, and for one block of them after the other the polynomials of the current window and what they say of its
/// length.
#[derive(Debug, Clone, Default)]
pub(crate) struct Window {
    masses: usize,
    /// Displacements and velocities of all masses at the window's start, and at the end of the length last enclosed.
    starts: [Vec<Lane>; 2],
    ends: [Vec<Lane>; 2],
    /// The masses whose polynomials these are, and how many stand before them.
    block: Range<usize>,
    before: usize,
    /// [order][neighbour, masses, neighbour, room for whole lanes]
    coefficients: Vec<f64>,
    stride: usize,
    since_refresh: usize,
    unit: f64,
    lows: Vec<Lane>,
    highs: Vec<Lane>,
    values: Vec<Lane>,
    slopes: Vec<Lane>,
}

/// What a force adds to the orders of all polynomials of a window.
pub(crate) type Pushes = [f64; ORDER - 2];

impl Window {
    /// Counts time in units for a fastest motion of `rate` radians a unit of the model's time, from the next placement on.
    pub(crate) fn set_rate(&mut self, rate: f64) {
        self.unit = 2f64.powi(-(rate.log2().floor() as i32));
    }

    /// The unit of time.
    pub(crate) fn unit(&self) -> f64 {
        self.unit
    }

    /// Sets all masses from the modes, `elapsed` after the start of an interval between impacts.
    pub(crate) fn set(&mut self, watched: &DistinctMasses, motion: &mut Motion, interval: usize, elapsed: f64) {
        let masses = watched.sites().len();
        let whole = masses <= BLOCK || !watched.across().is_empty();
        let lanes = if whole { masses } else { BLOCK + 2 * REACH }.div_ceil(LANES);
        let stride = lanes * LANES + 2;
        if (self.masses, self.stride) != (masses, stride) {
            (self.masses, self.stride) = (masses, stride);
            self.coefficients.clear();
            self.coefficients.resize(ORDER * self.stride, 0.0);
            for list in self.starts.iter_mut().chain(&mut self.ends) {
                list.clear();
                list.resize(masses.div_ceil(LANES), [0.0; LANES]);
            }
            for list in [&mut self.lows, &mut self.highs, &mut self.values, &mut self.slopes] {
                list.clear();
                list.resize(lanes, [0.0; LANES]);
            }
        }
        self.since_refresh = 0;
        motion.seek(interval, elapsed);
        let [values, slopes] = self.starts.each_mut().map(|list| &mut list.as_flattened_mut()[..masses]);
        if motion.is_large() {
            let all = motion.all_sites();
            for ((value, slope), &site) in values.iter_mut().zip(slopes).zip(watched.sites()) {
                (*value, *slope) = (all[site].re, all[site].im * self.unit);
            }
            return;
        }
        motion.masses(watched.sites(), values, slopes);
        slopes.iter_mut().for_each(|slope| *slope *= self.unit);
    }

    /// What the force adds to each order of the polynomials; `time` is t+ψ at the window's start.
    pub(crate) fn pushes(&self, force: &Wave, time: f64) -> Pushes {
        let squared = self.unit * self.unit;
        taylor::<{ ORDER - 2 }>(force, time, self.unit).map(|push| push * squared)
    }

    /// The masses in blocks, each of which [`Window::expand`] takes over.
    pub(crate) fn blocks(&self, watched: &DistinctMasses) -> impl Iterator<Item = Range<usize>> + use<> {
        let masses = self.masses;
        let size = if watched.across().is_empty() { BLOCK } else { masses };
        (0..masses).step_by(size.max(1)).map(move |from| from..masses.min(from + size))
    }

    /// Works out the polynomials of a block from displacement and velocity.
    pub(crate) fn expand(&mut self, watched: &DistinctMasses, model: &Model, pushes: &Pushes, block: Range<usize>) {
        let (stride, masses) = (self.stride, self.masses);
        // Whether the last mass is next to the first one, on a ring without symmetry.
        let [left, right] = [watched.left()[0], watched.right()[masses - 1]];
        let around = block.len() < masses && left == masses - 1 && right == 0;
        let places = if around {
            block.start + masses - REACH..block.end + masses + REACH
        } else {
            block.start.saturating_sub(REACH)..masses.min(block.end + REACH)
        };
        let count = places.len();
        self.before = if around { REACH } else { block.start - places.start };
        self.block = block;
        for (row, states) in self.coefficients.chunks_exact_mut(stride).zip(&self.starts) {
            let row = &mut row[FIRST..FIRST + count];
            let states = states.as_flattened();
            if around {
                row.iter_mut().zip(places.clone()).for_each(|(slot, place)| *slot = states[place % masses]);
            } else {
                row.copy_from_slice(&states[places.clone()]);
            }
        }
        if !watched.across().is_empty() {
            self.expand_layers(watched, model, pushes);
            return;
        }
        let squared = self.unit * self.unit;
        let [g1, g2] = [model.chain().gamma1(), model.chain().gamma2()].map(|gamma| f64x4::splat(gamma * squared));
        let dashpots = model.dashpots().map(|c| c * self.unit);
        // A wall stands still. (What is beyond the reach of the block may be anything.)
        let [left, right] = [left, right].map(|neighbour| match neighbour.checked_sub(places.start) {
            Some(place) if place < count => (FIRST + place, 1.0),
            _ => (FIRST, 0.0),
        });
        let close = |row: &mut [f64]| {
            let ends = [left, right].map(|(place, moves)| row[place] * moves);
            (row[0], row[FIRST + count]) = (ends[0], ends[1]);
        };
        self.coefficients.chunks_exact_mut(stride).take(2).for_each(close);
        for (k, push) in pushes.iter().enumerate() {
            let scale = 1.0 / ((k + 1) * (k + 2)) as f64;
            let (known, rest) = self.coefficients.split_at_mut((k + 2) * stride);
            let (c, next) = (&known[k * stride..(k + 1) * stride], &mut rest[..stride]);
            let (left, own, right) = (&c[..stride - 2], &c[1..stride - 1], &c[2..]);
            let sides = left.as_chunks::<LANES>().0.iter().zip(right.as_chunks::<LANES>().0);
            let targets = next[FIRST..].as_chunks_mut::<LANES>().0.iter_mut().zip(own.as_chunks::<LANES>().0);
            let (scale, push) = (f64x4::splat(scale), f64x4::splat(*push));
            if !model.is_damped() {
                for ((next, own), (left, right)) in targets.zip(sides) {
                    let (own, sides) = (f64x4::from(*own), f64x4::from(*left) + f64x4::from(*right));
                    *next = (scale * (push - g1 * own - g2 * (own + own - sides))).to_array();
                }
                close(next);
                continue;
            }
            let speeds = &known[(k + 1) * stride..];
            if dashpots[1] == 0.0 {
                // Of dashpots to the ground alone neighbours know nothing.
                let c1 = f64x4::splat(dashpots[0] * (k + 1) as f64);
                let own = speeds[FIRST..].as_chunks::<LANES>().0;
                for (((next, own), (left, right)), speed) in targets.zip(sides).zip(own) {
                    let (own, sides) = (f64x4::from(*own), f64x4::from(*left) + f64x4::from(*right));
                    let pulled = g1 * own + g2 * (own + own - sides) + c1 * f64x4::from(*speed);
                    *next = (scale * (push - pulled)).to_array();
                }
                close(next);
                continue;
            }
            let beside =
                [&speeds[..stride - 2], &speeds[1..stride - 1], &speeds[2..]].map(|row| row.as_chunks::<LANES>().0);
            let speeds = beside[0].iter().zip(beside[1]).zip(beside[2]);
            let [c1, c2] = dashpots.map(|c| f64x4::splat(c * (k + 1) as f64));
            let pull = |left: &Lane, own: &Lane, right: &Lane, [ground, between]: [f64x4; 2]| {
                let (own, sides) = (f64x4::from(*own), f64x4::from(*left) + f64x4::from(*right));
                ground * own + between * (own + own - sides)
            };
            for (((next, own), (left, right)), ((slow, speed), fast)) in targets.zip(sides).zip(speeds) {
                let pulled = pull(left, own, right, [g1, g2]) + pull(slow, speed, fast, [c1, c2]);
                *next = (scale * (push - pulled)).to_array();
            }
            close(next);
        }
    }

    /// The same mass by mass, for layers, where neighbours do not stand next to each other in memory.
    fn expand_layers(&mut self, watched: &DistinctMasses, model: &Model, pushes: &Pushes) {
        let (chain, squared, stride) = (model.chain(), self.unit * self.unit, self.stride);
        let [c1, c2] = model.dashpots().map(|c| c * self.unit);
        let along = watched.left().iter().zip(watched.right());
        let sides: Vec<[usize; 4]> = along.zip(watched.across()).map(|((l, r), [b, a])| [*l, *r, *b, *a]).collect();
        for (k, push) in pushes.iter().enumerate() {
            let scale = 1.0 / ((k + 1) * (k + 2)) as f64;
            let (known, rest) = self.coefficients.split_at_mut((k + 2) * stride);
            let [c, speeds] = [k, k + 1].map(|order| &known[order * stride + FIRST..][..self.masses]);
            let next = &mut rest[FIRST..];
            let order = (k + 1) as f64;
            for (n, ((next, own), sides)) in next.iter_mut().zip(c).zip(&sides).enumerate() {
                let at = |row: &[f64], n: usize| row.get(n).copied().unwrap_or_default();
                let mut force = squared * chain.spring_force(*own, sides.map(|n| at(c, n)));
                if model.is_damped() {
                    let [slow, fast] = [sides[0], sides[1]].map(|n| at(speeds, n));
                    force -= order * (c1 * speeds[n] + c2 * (2.0 * speeds[n] - (slow + fast)));
                }
                *next = scale * (push + force);
            }
        }
    }

    /// Moves on to the end of the length last enclosed: through the polynomials, or from the modes where rounding is due to
    /// be cleared.
    pub(crate) fn advance(&mut self, watched: &DistinctMasses, motion: &mut Motion, interval: usize, elapsed: f64) {
        self.since_refresh += 1;
        if self.since_refresh >= REFRESH {
            self.set(watched, motion, interval, elapsed);
            return;
        }
        std::mem::swap(&mut self.starts, &mut self.ends);
    }

    /// Displacement of mass `i` at the window's start.
    pub(crate) fn displacement(&self, i: usize) -> f64 {
        self.starts[0].as_flattened()[i]
    }

    /// Velocity of mass `i` there, in units.
    pub(crate) fn velocity(&self, i: usize) -> f64 {
        self.starts[1].as_flattened()[i]
    }

    /// Works out ranges and final values of the block's masses within `length`, in units: Horner's rule for some of them at once.
    pub(crate) fn enclose(&mut self, length: f64) {
        let mut from = 0;
        while from < self.lows.len() {
            // As many lanes at a time as processors have registers for.
            from += match self.lows.len() - from {
                1 => self.enclose_lanes::<1>(from, length),
                2 => self.enclose_lanes::<2>(from, length),
                _ => self.enclose_lanes::<3>(from, length),
            };
        }
        let states = self.ends.iter_mut().zip([&mut self.values, &mut self.slopes]);
        if self.block.len() == self.masses {
            states.for_each(|(ends, state)| std::mem::swap(ends, state));
            return;
        }
        let places = self.before..self.before + self.block.len();
        for (ends, state) in states {
            let state = &state.as_flattened()[places.clone()];
            ends.as_flattened_mut()[self.block.clone()].copy_from_slice(state);
        }
    }

    /// Where a mass of the block stands in a row.
    fn place(&self, i: usize) -> usize {
        i - self.block.start + self.before
    }

    fn enclose_lanes<const N: usize>(&mut self, from: usize, length: f64) -> usize {
        let (zero, length) = (f64x4::ZERO, f64x4::splat(length));
        let (mut low, mut high, mut value, mut slope) = ([zero; N], [zero; N], [zero; N], [zero; N]);
        let place = FIRST + from * LANES;
        let lanes = |row: &[f64]| -> [f64x4; N] {
            let lanes = row.get(place..).unwrap_or_default().as_chunks::<LANES>().0;
            std::array::from_fn(|lane| lanes.get(lane).map_or(zero, |four| f64x4::from(*four)))
        };
        let mut rows = self.coefficients.chunks_exact(self.stride);
        let start = rows.next().map_or([zero; N], lanes);
        for c in rows.rev().map(lanes) {
            for i in 0..N {
                low[i] = (c[i] + length * low[i]).fast_min(zero);
                high[i] = (c[i] + length * high[i]).fast_max(zero);
                slope[i] = slope[i] * length + value[i];
                value[i] = value[i] * length + c[i];
            }
        }
        for (i, c) in start.into_iter().enumerate() {
            self.lows[from + i] = (c + length * low[i]).to_array();
            self.highs[from + i] = (c + length * high[i]).to_array();
            self.slopes[from + i] = (slope[i] * length + value[i]).to_array();
            self.values[from + i] = (value[i] * length + c).to_array();
        }
        N
    }

    /// Smallest and largest displacement that mass `i` could have within the length last enclosed: each coefficient of the
    /// wrong sign is dropped, so that what is left can only grow.
    pub(crate) fn range(&self, i: usize) -> (f64, f64) {
        let place = self.place(i);
        (self.lows.as_flattened()[place], self.highs.as_flattened()[place])
    }

    /// Displacement of any mass at the end of that length, once all blocks have been looked at.
    pub(crate) fn final_displacement(&self, i: usize) -> f64 {
        self.ends[0].as_flattened()[i]
    }

    /// The polynomial of mass `i`, in units of time.
    pub(crate) fn polynomial(&self, i: usize) -> Polynomial {
        let (place, mut coefficients) = (self.place(i), [0.0; ORDER]);
        for (c, row) in coefficients.iter_mut().zip(self.coefficients.chunks_exact(self.stride)) {
            *c = row[FIRST + place];
        }
        Polynomial { coefficients }
    }
}

#[cfg(test)]
mod tests;
