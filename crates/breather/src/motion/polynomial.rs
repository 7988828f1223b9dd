//! Taylor polynomials of one mass, and their turning points: on |s − c| ≤ r, with |p‴| ≤ B,
//!
//! ```text
//! p′(s) ∈ p′ ± (|p″| r + B r²/2)     no turning point if 0 is outside,
//! p″(s) ∈ p″ ± B r                   at most one if 0 is outside, found by its change of sign,
//! ```
//!
//! and the interval is halved otherwise.

use vibrochain_lattice::simd::lanes::{Lane, total};
use vibrochain_lattice::{Barrier, Wave};
use wide::f64x4;

/// Number of coefficients: over one radian of a motion the first one left out is below 1/20! = 4e-19 of it.
pub(crate) const ORDER: usize = 20;

/// Intervals this narrow, as a part of their window, are settled as they are: p changes by less than rounding on them.
const NARROW: f64 = 1e-9;

/// −1/((i+1)(i+2)) and −1/((i+2)(i+3)) for i = 0, 2, 4, …: from one Taylor coefficient of a swing to the next.
const FACTORS: [[f64; 2]; ORDER / 2] = {
    let mut factors = [[0.0; 2]; ORDER / 2];
    let mut i = 0;
    while i < ORDER / 2 {
        let k = (2 * i) as f64;
        factors[i] = [-1.0 / ((k + 1.0) * (k + 2.0)), -1.0 / ((k + 2.0) * (k + 3.0))];
        i += 1;
    }
    factors
};

/// k(k−1)(k−2), from coefficients to third derivatives.
const THIRDS: [f64; ORDER] = {
    let mut factors = [0.0; ORDER];
    let mut k = 3;
    while k < ORDER {
        factors[k] = (k * (k - 1) * (k - 2)) as f64;
        k += 1;
    }
    factors
};

/// Coefficients of a sum of cosines in a time from `time` on, counted in a unit.
pub(crate) fn taylor<const N: usize>(wave: &Wave, time: f64, unit: f64) -> [f64; N] {
    let mut coefficients = [0.0; N];
    // No force is a term of amplitude 0: not worth a sine.
    for term in wave.terms().iter().filter(|term| term.amplitude != 0.0) {
        let (sin, cos) = (term.rate * time + term.phase).sin_cos();
        // Derivatives of A cos: A cos, −Aω sin, −Aω² cos, Aω³ sin, …, over k!.
        let (mut size, rate) = (term.amplitude, term.rate * unit);
        let quarter = [cos, -sin, -cos, sin];
        for (k, coefficient) in coefficients.iter_mut().enumerate() {
            *coefficient += size * quarter[k % 4];
            size *= rate / (k + 1) as f64;
        }
    }
    coefficients
}

/// A Taylor polynomial.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Polynomial {
    pub(crate) coefficients: [f64; ORDER],
}

impl Polynomial {
    /// The motion that modes have together which nothing damps, by displacements and velocities at its start, four of each at a time, in units of
    /// `step`. What is left of these is of no use.
    pub(crate) fn of_swings(terms: &mut [[f64x4; 2]], frequencies: &[Lane], step: f64x4) -> Self {
        let mut coefficients = [0.0; ORDER];
        for (pair, factors) in coefficients.as_chunks_mut::<2>().0.iter_mut().zip(FACTORS) {
            let [mut even, mut odd] = [f64x4::ZERO; 2];
            for (term, frequency) in terms.iter_mut().zip(frequencies) {
                even += term[0];
                odd += term[1];
                let x = f64x4::from(*frequency) * step;
                let square = x * x;
                term[0] *= square * f64x4::splat(factors[0]);
                term[1] *= square * f64x4::splat(factors[1]);
            }
            *pair = [total(even), total(odd)];
        }
        Self { coefficients }
    }

    /// The polynomial in units of `size`.
    pub(crate) fn over(mut self, size: f64) -> Self {
        self.coefficients.iter_mut().for_each(|c| *c /= size);
        self
    }

    /// The same in the form that turning points are sought in: the distance from a barrier, over the scale that is told too, is 1 − |p|, and p beyond
    /// −1 is far away, on −1 … 1.
    pub(crate) fn before(&self, barrier: Barrier, stop: f64) -> (Self, f64) {
        let far: f64 = self.coefficients.iter().map(|c| c.abs()).sum();
        let scale = 2.0 * (far + stop.abs()).max(f64::MIN_POSITIVE);
        let mut own = *self;
        own.coefficients.iter_mut().for_each(|c| *c *= barrier.sign() / scale);
        own.coefficients[0] += 1.0 - barrier.sign() * stop / scale;
        (own, scale)
    }

    /// Value and first derivative.
    pub(crate) fn evaluate(&self, s: f64) -> (f64, f64) {
        let (mut value, mut slope) = (0.0, 0.0);
        for &c in self.coefficients.iter().rev() {
            slope = slope * s + value;
            value = value * s + c;
        }
        (value, slope)
    }

    /// Value, first and second derivative.
    pub(crate) fn jet(&self, s: f64) -> [f64; 3] {
        let (mut value, mut slope, mut half_curvature) = (0.0, 0.0, 0.0);
        for &c in self.coefficients.iter().rev() {
            half_curvature = half_curvature * s + slope;
            slope = slope * s + value;
            value = value * s + c;
        }
        [value, slope, 2.0 * half_curvature]
    }

    /// A bound on the modulus of the third derivative on −`length` … `length`.
    pub(crate) fn third_bound(&self, length: f64) -> f64 {
        let terms = self.coefficients.iter().zip(&THIRDS).rev();
        terms.take(ORDER - 3).fold(0.0, |bound, (c, factor)| bound * length + c.abs() * factor)
    }
}

/// By what part of its length a piece of a flight is looked at beyond an end where another piece goes on: a turning point
/// right there is in neither by rounding.
const OVERLAP: f64 = 1.0 / 1024.0;

/// 0 … `length`, and a little more where the flight goes on, before and after.
pub(crate) fn with_overlap(length: f64, goes_on: [bool; 2]) -> [f64; 2] {
    let [before, after] = goes_on.map(|more| if more { OVERLAP * length } else { 0.0 });
    [-before, length + after]
}

/// Reports the turning points on a `range` that could come closer than the smallest distance so far, `distance` to begin
/// with and then what `note` returns.
pub(crate) fn turning_points(
    polynomial: &Polynomial,
    range: [f64; 2],
    pending: &mut Vec<(f64, f64)>,
    mut distance: f64,
    note: &mut impl FnMut(f64, f64) -> f64,
    a: f64,
) {
    let [start, end] = range;
    let (bound, length) = (polynomial.third_bound(end.max(-start)), end - start);
    pending.clear();
    pending.push((start, end));
    while let Some((low, high)) = pending.pop() {
        let (centre, radius) = (0.5 * (low + high), 0.5 * (high - low));
        let [value, slope, curvature] = polynomial.jet(centre);
        let turn = radius * (curvature.abs() + 0.5 * bound * radius);
        let reach = radius * (slope.abs() + 0.5 * turn);
        if slope.abs() > turn || 1.0 - (value - a).abs() - reach >= distance {
            continue;
        }
        if curvature.abs() > bound * radius {
            if let Some((s, value)) = turning_point(polynomial, low, high) {
                distance = note(s, value);
            }
        } else if radius < NARROW * length {
            distance = note(centre, value);
        } else {
            pending.push((centre, high));
            pending.push((low, centre));
        }
    }
}

/// The zero of a monotone p′ on an interval, if there is one, and the displacement there.
fn turning_point(polynomial: &Polynomial, mut low: f64, mut high: f64) -> Option<(f64, f64)> {
    let (first, last) = (polynomial.evaluate(low).1, polynomial.evaluate(high).1);
    if first * last > 0.0 {
        return None;
    }
    let mut s = 0.5 * (low + high);
    for _ in 0..60 {
        let [value, slope, curvature] = polynomial.jet(s);
        let step = slope / curvature;
        // Near the zero the displacement is flat: an error of `step` in time is one of p″·step²/2 in place.
        if slope == 0.0 || 0.5 * (slope * step).abs() < 0.25 * f64::EPSILON {
            let shift = if slope == 0.0 { 0.0 } else { step };
            return Some((s - shift, value - 0.5 * slope * shift));
        }
        if (slope < 0.0) == (first < 0.0) {
            low = s;
        } else {
            high = s;
        }
        let newton = s - step;
        s = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    Some((s, polynomial.evaluate(s).0))
}

#[cfg(test)]
mod tests;
