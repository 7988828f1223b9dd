//! Exact flight of all watched masses over short windows, as Taylor polynomials from the equation of motion,
//!
//! ```text
//! c_{k+2} = (−γ₁c_k − γ₂(2c_k − c_left − c_right) + F_k) / ((k+1)(k+2)) .
//! ```
//!
//! Time is counted in a unit near one radian of the fastest motion: c_k would leave the range of `f64` for frequencies
//! beyond 1e16. The unit is a power of two, so that it costs no digit.
//!
//! A window is at most one radian of the fastest motion, so that ORDER terms leave a remainder below rounding. The
//! polynomials are each mass's own: far from the breather their coefficients are as small as the motion itself, and
//! bounds taken from them are as tight, which no bound common to the ring could be.

use vibrochain_lattice::{Complex, DistinctMasses, Model, Wave};
use wide::f64x4;

use crate::lanes::{LANES, Lane, groups};
use crate::motion::Motion;
use crate::polynomial::{ORDER, Polynomial};

/// Windows after which the masses are set anew from the modes, so that rounding cannot add up.
const REFRESH: usize = 32;

/// Place of mass 0 in a row of numbers; before it stands its left neighbour, once more.
const FIRST: usize = 1;

/// The polynomials of the current window, and what they say of its length.
#[derive(Debug, Clone, Default)]
pub(crate) struct Window {
    /// [order][neighbour, masses, neighbour, room for whole lanes]
    coefficients: Vec<f64>,
    stride: usize,
    masses: usize,
    since_refresh: usize,
    unit: f64,
    lows: Vec<Lane>,
    highs: Vec<Lane>,
    values: Vec<Lane>,
    slopes: Vec<Lane>,
    /// Displacement and velocity of all masses of a large ring, as one complex number.
    all: Vec<Complex<f64>>,
}

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
    pub(crate) fn place(&mut self, watched: &DistinctMasses, motion: &mut Motion, interval: usize, elapsed: f64) {
        let masses = watched.sites().len();
        if self.masses != masses {
            let lanes = groups(masses);
            self.masses = masses;
            self.stride = lanes * LANES + 2;
            self.coefficients.clear();
            self.coefficients.resize(ORDER * self.stride, 0.0);
            for list in [&mut self.lows, &mut self.highs, &mut self.values, &mut self.slopes] {
                list.clear();
                list.resize(lanes, [0.0; LANES]);
            }
        }
        self.since_refresh = 0;
        motion.seek(interval, elapsed);
        let (values, slopes) = self.coefficients.split_at_mut(self.stride);
        let (values, slopes) = (&mut values[FIRST..FIRST + masses], &mut slopes[FIRST..FIRST + masses]);
        if motion.is_large() {
            motion.all_sites(&mut self.all);
            for ((value, slope), &site) in values.iter_mut().zip(slopes).zip(watched.sites()) {
                (*value, *slope) = (self.all[site].re, self.all[site].im * self.unit);
            }
            return;
        }
        motion.masses(watched.sites(), values, slopes);
        slopes.iter_mut().for_each(|slope| *slope *= self.unit);
    }

    /// Works out the polynomials from displacement and velocity; `time` is t+ψ, for the force, at the window's start.
    pub(crate) fn expand(&mut self, watched: &DistinctMasses, model: &Model, force: &Wave, time: f64) {
        let squared = self.unit * self.unit;
        let [g1, g2] = [model.chain().gamma1(), model.chain().gamma2()].map(|gamma| f64x4::splat(gamma * squared));
        let mut pushes = [0.0; ORDER - 2];
        for term in force.terms() {
            let (sin, cos) = (term.rate * time + term.phase).sin_cos();
            // Derivatives of A cos: A cos, −Aω sin, −Aω² cos, Aω³ sin, …, over k!.
            let mut size = term.amplitude * squared;
            let rate = term.rate * self.unit;
            let quarter = [cos, -sin, -cos, sin];
            for (k, push) in pushes.iter_mut().enumerate() {
                *push += size * quarter[k % 4];
                size *= rate / (k + 1) as f64;
            }
        }
        if !watched.across().is_empty() {
            self.expand_layers(watched, model, &pushes);
            return;
        }
        let masses = self.masses;
        let ends = [watched.left()[0], watched.right()[masses - 1]].map(|n| if n < masses { FIRST + n } else { NONE });
        let step = Step { g1, g2, ends, after: FIRST + masses };
        let rows = &mut self.coefficients;
        // With the length of a row known to the compiler, nothing but numbers is left to work on.
        match self.lows.len() {
            1 => expand_short::<1, 6>(rows, &step, &pushes),
            2 => expand_short::<2, 10>(rows, &step, &pushes),
            3 => expand_short::<3, 14>(rows, &step, &pushes),
            4 => expand_short::<4, 18>(rows, &step, &pushes),
            6 => expand_short::<6, 26>(rows, &step, &pushes),
            groups => {
                let stride = self.stride;
                rows.chunks_exact_mut(stride).take(2).for_each(|row| step.close(row));
                for (k, push) in pushes.into_iter().enumerate() {
                    let (known, rest) = rows.split_at_mut((k + 2) * stride);
                    step.next_row(k, push, &known[k * stride..(k + 1) * stride], &mut rest[..stride], groups);
                }
            }
        }
    }

    /// The same mass by mass, for layers, where neighbours do not stand next to each other in memory.
    fn expand_layers(&mut self, watched: &DistinctMasses, model: &Model, pushes: &[f64]) {
        let (chain, squared, stride) = (model.chain(), self.unit * self.unit, self.stride);
        let along = watched.left().iter().zip(watched.right());
        let sides: Vec<[usize; 4]> = along.zip(watched.across()).map(|((l, r), [b, a])| [*l, *r, *b, *a]).collect();
        for (k, push) in pushes.iter().enumerate() {
            let scale = 1.0 / ((k + 1) * (k + 2)) as f64;
            let (known, rest) = self.coefficients.split_at_mut((k + 2) * stride);
            let (c, next) = (&known[k * stride + FIRST..][..self.masses], &mut rest[FIRST..]);
            for ((next, own), sides) in next.iter_mut().zip(c).zip(&sides) {
                let sides = sides.map(|n| c.get(n).copied().unwrap_or_default());
                *next = scale * (push + squared * chain.spring_force(*own, sides));
            }
        }
    }

    /// Moves on to the end of the length last enclosed: through the polynomials, or from the modes where rounding is due to
    /// be cleared.
    pub(crate) fn advance(&mut self, watched: &DistinctMasses, motion: &mut Motion, interval: usize, elapsed: f64) {
        self.since_refresh += 1;
        if self.since_refresh >= REFRESH {
            self.place(watched, motion, interval, elapsed);
            return;
        }
        let (values, slopes) = self.coefficients.split_at_mut(self.stride);
        values[FIRST..FIRST + self.masses].copy_from_slice(&self.values.as_flattened()[..self.masses]);
        slopes[FIRST..FIRST + self.masses].copy_from_slice(&self.slopes.as_flattened()[..self.masses]);
    }

    /// Displacement of mass `i` at the window's start.
    pub(crate) fn displacement(&self, i: usize) -> f64 {
        self.coefficients[FIRST + i]
    }

    /// Works out ranges and final values of all masses within `length`, in units: Horner's rule for all of them at once.
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
    }

    /// Coefficients of every order, of some groups of masses.
    fn rows<const N: usize>(&self, from: usize) -> impl DoubleEndedIterator<Item = [f64x4; N]> + ExactSizeIterator {
        self.coefficients.chunks_exact(self.stride).map(move |row| lanes(row, FIRST + from * LANES))
    }

    fn enclose_lanes<const N: usize>(&mut self, from: usize, length: f64) -> usize {
        let (zero, length) = (f64x4::ZERO, f64x4::splat(length));
        let (mut low, mut high, mut value, mut slope) = ([zero; N], [zero; N], [zero; N], [zero; N]);
        let mut rows = self.rows::<N>(from);
        let start = rows.next().unwrap_or([zero; N]);
        for c in rows.rev() {
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

    /// By how much four masses at least stay away from the nearer barrier within the length last enclosed, at asymmetry `a`: each
    /// coefficient of the wrong sign is dropped, so that what is left can only grow.
    pub(crate) fn reaches(&self, group: usize, a: f64) -> Lane {
        let (a, low, high) = (f64x4::splat(a), f64x4::from(self.lows[group]), f64x4::from(self.highs[group]));
        (f64x4::ONE - (high - a)).fast_min(f64x4::ONE + (low - a)).to_array()
    }

    /// By how much they stay away from it at the window's start.
    pub(crate) fn distances(&self, group: usize, a: f64) -> Lane {
        let [own] = lanes::<1>(&self.coefficients, FIRST + group * LANES);
        (f64x4::ONE - (own - f64x4::splat(a)).abs()).to_array()
    }

    /// How far from 0 the velocities of four masses stay within `length`, in units; 0 or less where they may vanish.
    pub(crate) fn paces(&self, group: usize, length: f64) -> Lane {
        let (zero, length) = (f64x4::ZERO, f64x4::splat(length));
        let (mut low, mut high) = (zero, zero);
        let mut rows = self.rows::<1>(group).zip(ORDERS).skip(1);
        let [start] = rows.next().map_or([zero], |(c, _)| c);
        // Σ k c_k s^(k−1)
        for ([c], order) in rows.rev() {
            let c = c * f64x4::splat(order);
            low = (c + length * low).fast_min(zero);
            high = (c + length * high).fast_max(zero);
        }
        (start + length * low).fast_max(-(start + length * high)).to_array()
    }

    /// Displacement of mass `i` at the end of the length last enclosed.
    pub(crate) fn final_displacement(&self, i: usize) -> f64 {
        self.values[i / LANES][i % LANES]
    }

    /// The polynomial of mass `i`, in units of time.
    pub(crate) fn polynomial(&self, i: usize) -> Polynomial {
        let mut coefficients = [0.0; ORDER];
        for (c, row) in coefficients.iter_mut().zip(self.coefficients.chunks_exact(self.stride)) {
            *c = row[FIRST + i];
        }
        Polynomial { coefficients }
    }
}

/// Some groups of a row.
#[inline(always)]
fn lanes<const N: usize>(row: &[f64], place: usize) -> [f64x4; N] {
    let groups = row.get(place..).and_then(|row| row.as_chunks::<LANES>().0.first_chunk::<N>());
    groups.map_or([f64x4::ZERO; N], |groups| groups.map(f64x4::from))
}

/// Of a row without a neighbour: no place in it.
const NONE: usize = usize::MAX;

/// What leads from one row of coefficients to that two orders on.
struct Step {
    g1: f64x4,
    g2: f64x4,
    /// Places of the neighbours of the first and the last mass, if they have any.
    ends: [usize; 2],
    /// The place after the last mass.
    after: usize,
}

impl Step {
    /// Puts the neighbours of the first and the last mass beside them.
    #[inline(always)]
    fn close(&self, row: &mut [f64]) {
        let [before, after] = self.ends.map(|end| row.get(end).copied().unwrap_or_default());
        row[0] = before;
        if let Some(slot) = row.get_mut(self.after) {
            *slot = after;
        }
    }

    /// Works out a row from that two orders before.
    #[inline(always)]
    fn next_row(&self, k: usize, push: f64, row: &[f64], next: &mut [f64], groups: usize) {
        let (scale, push) = (f64x4::splat(SCALES[k]), f64x4::splat(push));
        for place in (FIRST..).step_by(LANES).take(groups) {
            let [[left], [own], [right]] = [place - 1, place, place + 1].map(|place| lanes::<1>(row, place));
            let sides = left + right;
            let value = scale * (push - self.g1 * own - self.g2 * (own + own - sides));
            next[place..place + LANES].copy_from_slice(&value.to_array());
        }
        self.close(next);
    }
}

/// 0, 1, 2, …
const ORDERS: [f64; ORDER] = {
    let mut orders = [0.0; ORDER];
    let mut k = 1;
    while k < ORDER {
        orders[k] = k as f64;
        k += 1;
    }
    orders
};

/// 1/((k+1)(k+2))
const SCALES: [f64; ORDER - 2] = {
    let mut scales = [0.0; ORDER - 2];
    let mut k = 0;
    while k < ORDER - 2 {
        scales[k] = 1.0 / ((k + 1) * (k + 2)) as f64;
        k += 1;
    }
    scales
};

/// All rows of `G` groups, each `S` numbers long.
fn expand_short<const G: usize, const S: usize>(coefficients: &mut [f64], step: &Step, pushes: &[f64; ORDER - 2]) {
    let rows = coefficients.as_chunks_mut::<S>().0;
    rows.iter_mut().take(2).for_each(|row| step.close(row));
    for (k, push) in pushes.iter().enumerate() {
        if let Some([row, _, next]) = rows.get_mut(k..).and_then(|rows| rows.first_chunk_mut::<3>()) {
            step.next_row(k, *push, row, next, G);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_and_bounds_of_a_sine() {
        let mut coefficients = [0.0; ORDER];
        let mut factorial = 1.0;
        for (k, c) in coefficients.iter_mut().enumerate() {
            factorial *= k.max(1) as f64;
            *c = [0.0, 1.0, 0.0, -1.0][k % 4] / factorial;
        }
        let sine = Polynomial { coefficients };
        for s in [0.0, 0.3, 1.0_f64] {
            let [value, slope, curvature] = sine.jet(s);
            assert!((value - s.sin()).abs() < 1e-15 && (slope - s.cos()).abs() < 1e-15);
            assert!((curvature + s.sin()).abs() < 1e-14);
            assert_eq!(sine.evaluate(s), (value, slope));
        }
        assert!(sine.third_bound(1.0) >= 1.0 && sine.third_bound(1.0) <= 1.6);
        let mut window = Window { masses: 1, stride: 6, unit: 1.0, ..Window::default() };
        window.coefficients = coefficients.iter().flat_map(|c| [0.0, *c, 0.0, 0.0, 0.0, 0.0]).collect();
        for list in [&mut window.lows, &mut window.highs, &mut window.values, &mut window.slopes] {
            list.resize(1, [0.0; LANES]);
        }
        window.enclose(1.0);
        // cos 1, and a little less.
        let [pace, ..] = window.paces(0, 1.0);
        assert!(pace <= 1f64.cos() && pace > 0.45);
        let [low, high] = [window.lows[0][0], window.highs[0][0]];
        assert!(low <= 0.0 && high >= 1f64.sin() && high <= 1.01);
        assert_eq!(window.reaches(0, 0.3)[0], (1.0 - (high - 0.3)).min(1.0 + (low - 0.3)));
        assert_eq!(window.final_displacement(0), sine.evaluate(1.0).0);
    }
}
