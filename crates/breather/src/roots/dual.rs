//! A function of one variable and its derivative, each in its own model; and what formulas need of the numbers they are evaluated in.

use std::ops::{Add, Mul, Sub};

use vibrochain_lattice::simd::lanes::Number;

use crate::roots::taylor::Taylor;

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

impl<T: Number> Algebra for Taylor<1, T> {
    fn scaled(self, factor: f64) -> Self {
        self.scaled(factor)
    }

    fn shifted(self, constant: f64) -> Self {
        self.shifted(constant)
    }
}

/// A function and its derivative: both enclosed on an interval or, for less work, both at a point (`f64`).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dual<T = Taylor<1>> {
    pub(crate) function: T,
    pub(crate) derivative: T,
}

impl<T: Number> Dual<Taylor<1, T>> {
    /// From value, first, second and third derivative at the centre, with |fourth derivative| ≤ `fourth`.
    pub(crate) fn from_jet(jet: [T; 4], fourth: T, radius: T) -> Self {
        let [value, first, second, third] = jet;
        let along = |jet: [T; 3], bound: T| Taylor::of_sum([true], jet, bound, [radius]);
        Self {
            function: along([value, first, second], third.modulus() + radius * fourth),
            derivative: along([first, second, third], fourth),
        }
    }

    /// amplitude·cos(rate·x + phase), given the cosine and sine of the phase at the centre times the amplitude.
    pub(crate) fn wave(cos: T, sin: T, rate: f64, amplitude: f64, radius: T) -> Self {
        let square = rate * rate;
        let jet = [cos, sin * -rate, cos * -square, sin * (square * rate)];
        Self::from_jet(jet, T::of(amplitude * square * square), radius)
    }

    /// The same with as much more doubt about function and derivative.
    pub(crate) fn widened(self, [function, derivative]: [f64; 2]) -> Self {
        Self { function: self.function.widened(function), derivative: self.derivative.widened(derivative) }
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
    fn models_contain_what_they_enclose() {
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
                        let middle = enclosed.value + enclosed.slope[0] * x;
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
