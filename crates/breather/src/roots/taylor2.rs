//! Enclosures of functions of two variables on a rectangle: value and slopes at the centre, bounds of the second
//! derivatives on the whole of it. Closed under sums and products.
//!
//! With radii r and |x| ≤ r_x, |y| ≤ r_y about the centre
//!
//! ```text
//! f ∈ v + s_x x + s_y y ± ½(H_xx r_x² + 2H_xy r_x r_y + H_yy r_y²) ± rounding,     ∂f/∂x ∈ s_x ± (H_xx r_x + H_xy r_y), …
//! ```
//!
//! so that one object serves to discard a rectangle, to shrink it, and to show that a map is one-to-one on it.

use std::ops::{Add, Mul, Neg, Sub};

/// An enclosure on a rectangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Patch {
    pub(crate) value: f64,
    pub(crate) slope: [f64; 2],
    /// Bounds of |f_xx|, |f_xy|, |f_yy|.
    bend: [f64; 3],
    /// Error of `value`.
    pub(crate) rounding: f64,
    radius: [f64; 2],
}

impl Patch {
    /// A function of x alone, or of y alone, by `axis`: value and slope at the centre, bound of the second derivative.
    pub(crate) fn along(axis: usize, [value, first, second_bound]: [f64; 3], radius: [f64; 2]) -> Self {
        // 8 units in the last place: what the kernels' sums are good for, relative to themselves.
        let mut patch =
            Self { value, slope: [0.0; 2], bend: [0.0; 3], rounding: 8.0 * f64::EPSILON * value.abs(), radius };
        patch.slope[axis] = first;
        patch.bend[2 * axis] = second_bound;
        patch
    }

    /// cos(rate·s + phase) along one axis, given the cosine and sine of the phase at the centre, and the phase's error.
    pub(crate) fn wave(axis: usize, cos: f64, sin: f64, rate: f64, error: f64, radius: [f64; 2]) -> Self {
        // A sine that starts near a zero stays small.
        let crest = (cos.abs() + rate * radius[axis]).min(1.0);
        let mut patch = Self::along(axis, [cos, -rate * sin, rate * rate * crest], radius);
        patch.rounding += error * sin.abs();
        patch
    }

    /// A function of x + y: value and slope at the centre, bound of the second derivative, error of the value.
    pub(crate) fn of_sum(jet: [f64; 3], doubt: f64, radius: [f64; 2]) -> Self {
        let [value, first, second_bound] = jet;
        let rounding = 8.0 * f64::EPSILON * value.abs() + doubt;
        Self { value, slope: [first; 2], bend: [second_bound; 3], rounding, radius }
    }

    pub(crate) fn constant(value: f64, radius: [f64; 2]) -> Self {
        Self { value, slope: [0.0; 2], bend: [0.0; 3], rounding: 0.0, radius }
    }

    /// The same with a larger error.
    pub(crate) fn doubted(self, doubt: f64) -> Self {
        Self { rounding: self.rounding + doubt, ..self }
    }

    /// What is known of a function that may be anything, as this one may vanish: where to halve for that to end.
    pub(crate) fn unknown(self) -> Self {
        let ([x, y], [r, s], [dx, dy]) = (self.slope.map(f64::abs), self.radius, self.slope_radius());
        let size = (self.value.abs() + self.rounding).max(f64::MIN_POSITIVE);
        let bend = [(x + dx) / r, 0.0, (y + dy) / s].map(|bend| if bend.is_finite() { bend } else { 0.0 });
        Self { value: 0.0, slope: [0.0; 2], bend: bend.map(|bend| bend / size), rounding: self.rounding / size, ..self }
    }

    /// 1/f; `None` where f may vanish.
    pub(crate) fn reciprocal(&self) -> Option<Self> {
        let least = self.value.abs() - self.tilt() - self.curvature() - self.rounding;
        if !(self.excludes_zero() && least > 0.0) {
            return None;
        }
        let ([x, y], [dx, dy]) = (self.slope.map(f64::abs), self.slope_radius());
        let [square, cube] = [least.powi(-2), 2.0 * least.powi(-3)];
        let (x, y) = (x + dx, y + dy);
        let mixed = [x * x, x * y, y * y];
        let value = self.value.recip();
        Some(Self {
            value,
            slope: self.slope.map(|slope| -slope * value * value),
            bend: std::array::from_fn(|i| self.bend[i] * square + mixed[i] * cube),
            rounding: self.rounding * square + f64::EPSILON * value.abs(),
            radius: self.radius,
        })
    }

    /// The sign that the function has all over the rectangle; 0 if it may have either.
    pub(crate) fn sign(&self) -> f64 {
        if self.excludes_zero() { self.value.signum() } else { 0.0 }
    }

    /// The same on a rectangle of another width in a direction that the function does not depend on.
    pub(crate) fn on(self, radius: [f64; 2]) -> Self {
        Self { radius, ..self }
    }

    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self {
            value: factor * self.value,
            slope: self.slope.map(|s| factor * s),
            bend: self.bend.map(|h| factor.abs() * h),
            rounding: factor.abs() * self.rounding,
            radius: self.radius,
        }
    }

    pub(crate) fn shifted(self, constant: f64) -> Self {
        self + Self::constant(constant, self.radius)
    }

    pub(crate) fn radius(&self) -> [f64; 2] {
        self.radius
    }

    /// Half widths of the slopes' enclosures.
    pub(crate) fn slope_radius(&self) -> [f64; 2] {
        let ([xx, xy, yy], [x, y]) = (self.bend, self.radius);
        [xx * x + xy * y, xy * x + yy * y]
    }

    /// What the curvature adds to the linear part, at most.
    pub(crate) fn curvature(&self) -> f64 {
        let ([x, y], [dx, dy]) = (self.radius, self.slope_radius());
        0.5 * (x * dx + y * dy)
    }

    /// Largest change of the linear part.
    fn tilt(&self) -> f64 {
        self.slope[0].abs() * self.radius[0] + self.slope[1].abs() * self.radius[1]
    }

    /// |f| is at most this.
    pub(crate) fn bound(&self) -> f64 {
        self.value.abs() + self.tilt() + self.curvature() + self.rounding
    }

    /// Shares of the two axes in the curvature, mixed terms in both.
    pub(crate) fn curvature_shares(&self) -> [f64; 2] {
        let ([x, y], [dx, dy]) = (self.radius, self.slope_radius());
        [x * dx, y * dy]
    }

    /// The function has no zero on the rectangle.
    pub(crate) fn excludes_zero(&self) -> bool {
        self.value.abs() > (1.0 + 16.0 * f64::EPSILON) * self.tilt() + self.curvature() + self.rounding
    }
}

impl Add for Patch {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            slope: [self.slope[0] + other.slope[0], self.slope[1] + other.slope[1]],
            bend: std::array::from_fn(|i| self.bend[i] + other.bend[i]),
            rounding: self.rounding + other.rounding + f64::EPSILON * (self.value.abs() + other.value.abs()),
            radius: self.radius,
        }
    }
}

impl Neg for Patch {
    type Output = Self;
    fn neg(self) -> Self {
        self.scaled(-1.0)
    }
}

impl Sub for Patch {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Patch {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (f, g) = (self.bound(), other.bound());
        let (df, dg) = (self.slope_radius(), other.slope_radius());
        let steepest_f = [self.slope[0].abs() + df[0], self.slope[1].abs() + df[1]];
        let steepest_g = [other.slope[0].abs() + dg[0], other.slope[1].abs() + dg[1]];
        let mixed = [
            2.0 * steepest_f[0] * steepest_g[0],
            steepest_f[0] * steepest_g[1] + steepest_f[1] * steepest_g[0],
            2.0 * steepest_f[1] * steepest_g[1],
        ];
        let value = self.value * other.value;
        Self {
            value,
            slope: std::array::from_fn(|i| self.value * other.slope[i] + self.slope[i] * other.value),
            bend: std::array::from_fn(|i| f * other.bend[i] + g * self.bend[i] + mixed[i]),
            rounding: f * other.rounding + g * self.rounding + f64::EPSILON * value.abs(),
            radius: self.radius,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_contain_what_they_enclose() {
        // f = sin x (cos 3y − 0.3) + x-free and y-free terms, about several centres.
        for (x0, y0) in [(0.0, 0.0), (1e-6, 0.3), (-1.0, 2.0), (0.4_f64, -0.7_f64)] {
            for r in [[0.5, 0.2], [0.1, 0.1], [1e-3, 1e-2]] {
                let sin = Patch::wave(0, x0.sin(), -x0.cos(), 1.0, 0.0, r);
                let cos = Patch::wave(1, (3.0 * y0).cos(), (3.0 * y0).sin(), 3.0, 0.0, r);
                // 1/(2 + sin(x + y)) as well.
                let both = Patch::of_sum([(x0 + y0).sin(), (x0 + y0).cos(), 1.0], 0.0, r);
                let inverse = both.shifted(2.0).reciprocal().unwrap();
                let f = sin * cos.shifted(-0.3) + cos.scaled(2.0) - sin + inverse;
                for i in -20..=20 {
                    for j in -20..=20 {
                        let (x, y) = (f64::from(i) / 20.0 * r[0], f64::from(j) / 20.0 * r[1]);
                        let (sx, cx) = (x0 + x).sin_cos();
                        let (sy, cy) = (3.0 * (y0 + y)).sin_cos();
                        let (sin, cos) = (x0 + x + y0 + y).sin_cos();
                        let (inverse, rise) = ((2.0 + sin).recip(), -cos / ((2.0 + sin) * (2.0 + sin)));
                        let value = sx * (cy - 0.3) + 2.0 * cy - sx + inverse;
                        let slopes = [cx * (cy - 0.3) - cx + rise, -3.0 * sx * sy - 6.0 * sy + rise];
                        let middle = f.value + f.slope[0] * x + f.slope[1] * y;
                        assert!((value - middle).abs() <= f.curvature() + f.rounding + 1e-15);
                        assert!(value.abs() <= f.bound() + 1e-15);
                        for k in 0..2 {
                            assert!((slopes[k] - f.slope[k]).abs() <= f.slope_radius()[k] + 1e-14);
                        }
                    }
                }
                // Useful, not only safe: the excess is of second order.
                assert!(f.curvature() < 40.0 * (r[0] * r[0] + r[1] * r[1]) + 1e-14);
            }
        }
    }
}
