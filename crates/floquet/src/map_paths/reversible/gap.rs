//! One gap between neighbouring poles, t from its left pole, 0 < t < w.
//!
//! Residues of opposite sign send s·F to +∞ at both ends, s the sign of the left one: there are no real roots in between
//! or two, which a look at the least s·F decides. Residues of equal sign enclose a root.

use nalgebra::Complex;

use crate::map_paths::fast_sums::evaluate::{Jet, Local};

/// Where s·F is least in a gap of opposite signs, or already negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lowest {
    pub(crate) t: f64,
    /// s·F and s·F″ there.
    pub(crate) value: f64,
    pub(crate) bend: f64,
    /// The error of F there; 0 if far smaller than the value.
    pub(crate) noise: f64,
}

impl Lowest {
    /// Half the distance of the two roots, along the real axis (value < 0) or off it (value > 0).
    pub(crate) fn half_distance(&self) -> f64 {
        if self.bend > 0.0 { (2.0 * self.value.abs() / self.bend).sqrt() } else { 0.0 }
    }

    /// The sign of the value is beyond doubt.
    pub(crate) fn is_certain(&self) -> bool {
        self.value.abs() > self.noise
    }
}

const STEPS: usize = 60;

/// Seeks the least s·F; stops at the first value that is negative beyond doubt.
pub(crate) fn lowest(local: Local<'_>, sign: f64, width: f64, ends: (f64, f64)) -> Lowest {
    lowest_within(local, sign, width, ends, |t| local.noise(Complex::new(t, 0.0)))
}

/// The same where `noise` says what is beyond doubt.
pub(crate) fn lowest_within(
    local: Local<'_>,
    sign: f64,
    width: f64,
    (left, right): (f64, f64),
    noise: impl Fn(f64) -> f64,
) -> Lowest {
    let (left, right) = (left.abs().sqrt(), right.abs().sqrt());
    // The two poles alone have their least value here.
    let mut t = width * left / (left + right);
    let (mut low, mut high) = (0.0, width);
    let mut best = Lowest { t, value: f64::INFINITY, bend: 0.0, noise: 0.0 };
    for _ in 0..STEPS {
        let Jet { value, slope, bend } = local.jet(t);
        let (value, slope, bend) = (sign * value, sign * slope, sign * bend);
        let room = t.min(width - t);
        if value < best.value {
            best = Lowest { t, value, bend, noise: 0.0 };
        }
        if value <= 0.0 {
            best.noise = noise(t);
            if -value > best.noise {
                return best;
            }
        }
        let gain = if bend > 0.0 { slope * slope / (2.0 * bend) } else { f64::INFINITY };
        let step = -slope / bend;
        if gain < 0.05 * value.abs() && step.abs() < 0.2 * room {
            break;
        }
        *(if slope < 0.0 { &mut low } else { &mut high }) = t;
        let next = t + step;
        let next = if bend > 0.0 && low < next && next < high { next } else { 0.5 * (low + high) };
        if (next - t).abs() <= 2.0 * f64::EPSILON * t || high - low <= f64::EPSILON * high {
            break;
        }
        t = next;
    }
    // Tangency or not? Worth the error only where the two roots are close.
    if best.noise == 0.0 && best.half_distance() < 1e-3 * width {
        best.noise = noise(best.t);
    }
    best
}

/// The root of F between `low` and `high`, where it changes sign. `weight` gives a smooth positive-definite factor's
/// logarithmic derivative, so that poles at the ends do not bend the function.
pub(crate) fn root(
    local: Local<'_>,
    (mut low, mut high): (f64, f64),
    rising: bool,
    weight: impl Fn(f64) -> f64,
) -> f64 {
    let mut t = 0.5 * (low + high);
    for _ in 0..200 {
        let Jet { value, slope, .. } = local.jet(t);
        if value == 0.0 {
            return t;
        }
        *(if (value < 0.0) == rising { &mut low } else { &mut high }) = t;
        let step = -1.0 / (slope / value + weight(t));
        let next = t + step;
        let next = if low < next && next < high { next } else { middle(low, high) };
        if (next - t).abs() <= f64::EPSILON * t.abs() || high - low <= f64::EPSILON * high.abs().max(low.abs()) {
            return next;
        }
        t = next;
    }
    t
}

/// Halves the exponent of a bracket that spans orders of magnitude, the bracket itself otherwise.
fn middle(low: f64, high: f64) -> f64 {
    if low > 0.0 && high > 8.0 * low {
        (low * high).sqrt()
    } else if high < 0.0 && low < 8.0 * high {
        -(low * high).sqrt()
    } else {
        0.5 * (low + high)
    }
}

/// δ > 0 with Σ R/(D+δ) = 0, for a sum that is negative at 0 (it is positive, 1/δ, far away): a root outside [−1, 1].
pub(crate) fn beyond(local: Local<'_>) -> f64 {
    let Jet { value, slope, .. } = local.jet(0.0);
    let nearest = local.distances.iter().flatten().copied().fold(f64::INFINITY, f64::min);
    let guess = match slope > 0.0 {
        // At a pole F = R/δ + …, with a rest that is of the order of 1.
        _ if nearest == 0.0 => local.charge_here().abs(),
        true => -value / slope,
        false => nearest,
    };
    let mut high = 2.0 * guess.max(f64::MIN_POSITIVE);
    let mut low = 0.0;
    while local.value(high) <= 0.0 && high < 1e300 {
        low = high;
        high *= 4.0;
    }
    root(local, (low, high), true, |t| 1.0 / (nearest + t))
}
