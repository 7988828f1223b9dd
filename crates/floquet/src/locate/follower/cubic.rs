//! The cubic of a multiplier through a part of a step: ln μ and its slope at both ends, and where it crosses the circle, ln|μ| = 0.

use nalgebra::Complex;
use smallvec::SmallVec;

use crate::events::half_sums::ON_CIRCLE;
use crate::zeros::modulus;

type C = Complex<f64>;

/// Steps to where a cubic nearly stands still.
const NEWTON_STEPS: usize = 3;

/// Halvings of a cubic's zero: to rounding.
const BISECTIONS: usize = 60;

/// The cubic of one multiplier between two places, over t from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Path {
    pub(super) ends: [C; 2],
    /// By t.
    pub(super) slopes: [C; 2],
    /// Its error at most.
    pub(super) error: f64,
}

impl Path {
    pub(super) fn at(&self, t: f64) -> C {
        let ([a, b], [p, q]) = (self.ends, self.slopes);
        let u = 1.0 - t;
        a * (u * u * (1.0 + 2.0 * t)) + b * (t * t * (3.0 - 2.0 * t)) + (p * u - q * t) * (t * u)
    }

    pub(super) fn slope(&self, t: f64) -> C {
        let ([a, b], [p, q]) = (self.ends, self.slopes);
        let u = 1.0 - t;
        (b - a) * (6.0 * t * u) + p * (u * (u - 2.0 * t)) + q * (t * (t - 2.0 * u))
    }

    /// How far it is at t from a value and a slope that are known there.
    pub(super) fn departure(&self, t: f64, value: C, slope: C) -> f64 {
        modulus(self.at(t) - value) + 0.5 * modulus(self.slope(t) - slope)
    }

    /// That of the other one of the pair, about one end of the upper half of the circle.
    pub(super) fn image(&self, end: f64) -> Self {
        Self {
            ends: self.ends.map(|at| conjugate(at, end)),
            slopes: self.slopes.map(|slope| slope.conj()),
            error: self.error,
        }
    }

    /// Its modulus where it nearly stands still.
    pub(super) fn size_at_rest(&self) -> f64 {
        let [p, q] = self.slopes;
        let [half, square] = self.bends();
        let within = |t: f64| if t > 0.0 { t.min(1.0) } else { 0.0 };
        let mut t = within((p / (p - q)).re);
        for _ in 0..NEWTON_STEPS {
            t = within(t - (self.slope(t) / ((half + square * t) * 2.0)).re);
        }
        modulus(self.at(t))
    }

    /// Of its slope p + 2ht + kt², h and k.
    fn bends(&self) -> [C; 2] {
        let ([a, b], [p, q]) = (self.ends, self.slopes);
        [(b - a) * 3.0 - p * 2.0 - q, (p + q - (b - a) * 2.0) * 3.0]
    }

    /// Where ln|μ| turns.
    pub(super) fn turns(&self) -> SmallVec<[f64; 2]> {
        let (p, [half, square]) = (self.slopes[0].re, self.bends().map(|bend| bend.re));
        let root = half.mul_add(half, -p * square);
        if root <= 0.0 {
            return SmallVec::new();
        }
        let sum = -(half + root.sqrt().copysign(half));
        let mut turns: SmallVec<[f64; 2]> =
            [sum / square, p / sum].into_iter().filter(|t| *t > 0.0 && *t < 1.0).collect();
        turns.sort_by(f64::total_cmp);
        turns
    }

    /// It hardly feels the impacts, and stays on the circle.
    pub(super) fn is_still(&self) -> bool {
        let turns = self.turns().into_iter().map(|t| self.at(t).re);
        turns.chain(self.ends.map(|end| end.re)).all(|growth| growth.abs() < ON_CIRCLE)
    }

    /// Where it crosses the circle; `None` where its error leaves that open.
    pub(super) fn zeros(&self) -> Option<SmallVec<[[f64; 3]; 3]>> {
        if self.is_still() {
            return Some(SmallVec::new());
        }
        let growth = |t: f64| self.at(t).re;
        let turns = self.turns();
        let within = |t: &f64| growth(*t).abs() <= self.error;
        if turns.iter().any(within) {
            return None;
        }
        let sign = |t: f64| {
            // What is on the circle at an end comes from where its slope says.
            let here = growth(t);
            if here.abs() < ON_CIRCLE { -self.slope(t).re > 0.0 } else { here > 0.0 }
        };
        let mut stops: SmallVec<[f64; 4]> = SmallVec::from_slice(&[0.0]);
        stops.extend(turns);
        stops.push(1.0);
        let mut zeros = SmallVec::new();
        for pair in stops.windows(2) {
            let (mut low, mut high) = (pair[0], pair[1]);
            let before = sign(low);
            if before == sign(high) {
                continue;
            }
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                if (growth(middle) > 0.0) == before { low = middle } else { high = middle }
            }
            zeros.push([pair[0], 0.5 * (low + high), pair[1]]);
        }
        Some(zeros)
    }
}

/// The other one of a pair, about 0 or π.
pub(super) fn conjugate(at: C, end: f64) -> C {
    C::new(at.re, 2.0 * end - at.im)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_and_its_slope_agree() {
        let path = Path {
            ends: [C::new(0.3, -1.0), C::new(-0.2, 0.4)],
            slopes: [C::new(1.3, 0.2), C::new(-0.7, 2.0)],
            error: 0.0,
        };
        assert!(path.at(0.0) == path.ends[0] && path.at(1.0) == path.ends[1]);
        assert!(path.slope(0.0) == path.slopes[0] && path.slope(1.0) == path.slopes[1]);
        for t in [0.1, 0.37, 0.8] {
            let difference = (path.at(t + 1e-6) - path.at(t - 1e-6)) / 2e-6;
            assert!((difference - path.slope(t)).norm() < 1e-8);
        }
        let turns = path.turns();
        assert!(turns.len() == 1 && path.slope(turns[0]).re.abs() < 1e-14, "{turns:?}");
    }
}
