//! First-order Taylor models: c + s·x ± rest for |x| ≤ radius, closed under sums and products.
//!
//! They answer, for a whole interval at once, whether a function can vanish there. The excess shrinks with the
//! square of the radius, so that bisection soon decides; rounding is carried in `rest` too, so that a "no" is a
//! proof to working precision.

use std::ops::{Add, Mul, Neg, Sub};

use crate::lanes::Number;

/// An enclosure of a function on an interval of the given radius about its centre, or of four such.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Enclosure<T = f64> {
    value: T,
    slope: T,
    rest: T,
    radius: T,
}

/// Ends are as far from the centre as the radius says but for this part of it: no interval is shorter than 64 units in the last place of
/// its centre.
const ROUNDED: f64 = 1.0 / 32.0;

impl<T: Number> Enclosure<T> {
    /// A function with this value and slope at the centre and |second derivative| ≤ `curvature` on the interval.
    pub(crate) fn new(value: T, slope: T, curvature: T, radius: T) -> Self {
        // 8 units in the last place: what the kernels' sums are good for, relative to themselves.
        let rounding = value.modulus() * (8.0 * f64::EPSILON);
        Self { value, slope, rest: curvature * 0.5 * radius * radius + rounding, radius }
    }

    pub(crate) fn constant(value: f64, radius: T) -> Self {
        Self { value: T::of(value), slope: T::of(0.0), rest: T::of(0.0), radius }
    }

    /// By how much the function stays away from 0 on the interval: it has no zero there where this is positive.
    pub(crate) fn clearance(&self) -> T {
        self.value.modulus() - (self.slope.modulus() * self.radius + self.rest)
    }

    /// No more than this is the function on the interval, by its size.
    pub(crate) fn most(&self) -> T {
        self.value.modulus() + self.slope.modulus() * self.radius + self.rest
    }

    /// What the function is at both ends, and by how much that can be wrong.
    pub(crate) fn ends(&self) -> ([T; 2], T) {
        let rise = self.slope * self.radius;
        ([self.value - rise, self.value + rise], self.rest + rise.modulus() * ROUNDED)
    }
}

impl<T: Number> Add for Enclosure<T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let rounding = (self.value.modulus() + other.value.modulus()) * f64::EPSILON;
        let rest = self.rest + other.rest + rounding;
        Self { value: self.value + other.value, slope: self.slope + other.slope, rest, radius: self.radius }
    }
}

impl<T: Number> Neg for Enclosure<T> {
    type Output = Self;
    fn neg(self) -> Self {
        self.scaled(-1.0)
    }
}

impl<T: Number> Sub for Enclosure<T> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<T: Number> Mul for Enclosure<T> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let r = self.radius;
        let (rise, other_rise) = (self.slope.modulus() * r, other.slope.modulus() * r);
        let value = self.value * other.value;
        let (a, b) = (self.value.modulus() + rise, other.value.modulus() + other_rise);
        let rest = rise * other_rise
            + a * other.rest
            + b * self.rest
            + self.rest * other.rest
            + value.modulus() * f64::EPSILON;
        Self { value, slope: self.value * other.slope + self.slope * other.value, rest, radius: r }
    }
}

impl<T: Number> Algebra for Enclosure<T> {
    fn scaled(self, factor: f64) -> Self {
        Self { value: self.value * factor, slope: self.slope * factor, rest: self.rest * factor.abs(), ..self }
    }

    fn shifted(self, constant: f64) -> Self {
        self + Self::constant(constant, self.radius)
    }
}

/// What a formula needs of the numbers it is evaluated in.
pub(crate) trait Algebra: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    fn scaled(self, factor: f64) -> Self;
    fn shifted(self, constant: f64) -> Self;
}

impl Algebra for f64 {
    fn scaled(self, factor: f64) -> Self {
        factor * self
    }

    fn shifted(self, constant: f64) -> Self {
        self + constant
    }
}

/// A function and its derivative: both enclosed on an interval or, for less work, both at a point (`f64`).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dual<T = Enclosure> {
    pub(crate) function: T,
    pub(crate) derivative: T,
}

impl<T: Number> Dual<Enclosure<T>> {
    /// From value, first, second and third derivative at the centre, with |fourth derivative| ≤ `fourth`.
    pub(crate) fn from_jet(jet: [T; 4], fourth: T, radius: T) -> Self {
        let [value, first, second, third] = jet;
        let third_bound = third.modulus() + radius * fourth;
        let second_bound = second.modulus() + third_bound * radius;
        Self {
            function: Enclosure::new(value, first, second_bound, radius),
            derivative: Enclosure::new(first, second, third_bound, radius),
        }
    }

    /// amplitude·cos(rate·x + phase), given the cosine and sine of the phase at the centre, each no larger than the amplitude.
    pub(crate) fn wave(cos: T, sin: T, rate: f64, amplitude: f64, radius: T) -> Self {
        let bound = amplitude * rate * rate;
        Self {
            function: Enclosure::new(cos, sin * -rate, T::of(bound), radius),
            derivative: Enclosure::new(sin * -rate, cos * (-rate * rate), T::of(bound * rate), radius),
        }
    }
}

impl<T: Number> Dual<Enclosure<T>> {
    /// The same with as much more doubt about function and derivative.
    pub(crate) fn widened(mut self, [function, derivative]: [f64; 2]) -> Self {
        self.function.rest = self.function.rest + T::of(function);
        self.derivative.rest = self.derivative.rest + T::of(derivative);
        self
    }

    /// Function and derivative at the centre.
    pub(crate) fn at_centre(&self) -> (T, T) {
        (self.function.value, self.derivative.value)
    }
}

impl<T: Algebra> Algebra for Dual<T> {
    fn scaled(self, factor: f64) -> Self {
        Self { function: self.function.scaled(factor), derivative: self.derivative.scaled(factor) }
    }

    fn shifted(self, constant: f64) -> Self {
        Self { function: self.function.shifted(constant), ..self }
    }
}

impl<T: Algebra> Add for Dual<T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { function: self.function + other.function, derivative: self.derivative + other.derivative }
    }
}

impl<T: Algebra> Sub for Dual<T> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { function: self.function - other.function, derivative: self.derivative - other.derivative }
    }
}

impl<T: Algebra> Mul for Dual<T> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            function: self.function * other.function,
            derivative: self.function * other.derivative + self.derivative * other.function,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enclosures_contain_what_they_enclose() {
        // f = (sin x)(cos 2x − 0.3) about several centres, checked at many points of each interval.
        for centre in [-1.0_f64, 0.0, 0.4, 2.0] {
            for radius in [0.5_f64, 0.1, 1e-3] {
                let sin = Dual::wave(centre.sin(), -centre.cos(), 1.0, 1.0, radius);
                let cos = Dual::wave((2.0 * centre).cos(), (2.0 * centre).sin(), 2.0, 1.0, radius);
                let product = sin * cos.shifted(-0.3);
                for i in -50..=50 {
                    let x = f64::from(i) / 50.0 * radius;
                    let t = centre + x;
                    let f = t.sin() * ((2.0 * t).cos() - 0.3);
                    let d = t.cos() * ((2.0 * t).cos() - 0.3) - 2.0 * t.sin() * (2.0 * t).sin();
                    for (enclosed, true_value) in [(product.function, f), (product.derivative, d)] {
                        let middle = enclosed.value + enclosed.slope * x;
                        assert!((true_value - middle).abs() <= enclosed.rest + 1e-15, "{centre} {radius} {x}");
                    }
                }
                // Useful, not only safe: the excess is of second order.
                assert!(product.function.rest < 12.0 * radius * radius + 1e-14);
                let (ends, doubt) = product.function.ends();
                for (end, x) in ends.into_iter().zip([centre - radius, centre + radius]) {
                    assert!((end - x.sin() * ((2.0 * x).cos() - 0.3)).abs() <= doubt + 1e-15, "{centre} {radius}");
                }
            }
        }
    }
}
