//! Taylor models of functions of two variables on a rectangle, with bounds of what their slopes change by and of rounding alone: f ∈ v + s·x ± rest,
//! ∂f/∂x_i ∈ s_i ± swing_i. One object serves to discard a rectangle, to shrink it, and to show that a map is one-to-one on it.

use std::ops::{Add, Mul, Neg, Sub};

use crate::roots::taylor::{SUMS, Taylor, reach};

/// A model on a rectangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Patch {
    model: Taylor<2>,
    /// How far each slope is from that at the centre at most.
    swing: [f64; 2],
    /// The part of the model's rest that is rounding.
    pub(crate) rounding: f64,
}

/// A function of one variable, or of the sum of both, on an interval: its value, slope and second derivative at the centre, a bound of its
/// third one; and the error of the value.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Piece {
    pub(crate) jet: [f64; 3],
    pub(crate) third: f64,
    pub(crate) doubt: f64,
}

impl Piece {
    /// amplitude·cos(rate·x + phase), given the cosine and sine of the phase at the centre times the amplitude.
    pub(crate) fn wave([cos, sin]: [f64; 2], rate: f64, amplitude: f64) -> Self {
        let square = rate * rate;
        Self { jet: [cos, -rate * sin, -square * cos], third: amplitude * (square * rate).abs(), doubt: 0.0 }
    }

    /// As a function of those of two variables whose sum it is of.
    pub(crate) fn of(self, axes: [bool; 2], radius: [f64; 2]) -> Patch {
        let Self { jet, third, doubt } = self;
        let (reach, [_, first, second]) = (reach(axes, radius), jet);
        let swing = reach * (second.abs() + 0.5 * reach * third) + SUMS * first.abs();
        Patch {
            model: Taylor::of_sum(axes, jet, third, radius).widened(doubt),
            swing: axes.map(|on| if on { swing } else { 0.0 }),
            rounding: SUMS * jet[0].abs() + doubt,
        }
    }

    pub(crate) fn along(self, axis: usize, radius: [f64; 2]) -> Patch {
        self.of([axis == 0, axis == 1], radius)
    }

    /// Its value at the centre, all over the rectangle.
    pub(crate) fn fixed(self, radius: [f64; 2]) -> Patch {
        Patch::constant(self.jet[0], radius).doubted(SUMS * self.jet[0].abs() + self.doubt)
    }
}

impl Patch {
    pub(crate) fn constant(value: f64, radius: [f64; 2]) -> Self {
        Self { model: Taylor::constant(value, radius), swing: [0.0; 2], rounding: 0.0 }
    }

    /// The same with a larger error.
    pub(crate) fn doubted(self, doubt: f64) -> Self {
        Self { model: self.model.widened(doubt), rounding: self.rounding + doubt, ..self }
    }

    pub(crate) fn scaled(self, factor: f64) -> Self {
        let size = factor.abs();
        Self {
            model: self.model.scaled(factor),
            swing: self.swing.map(|swing| size * swing),
            rounding: size * self.rounding,
        }
    }

    pub(crate) fn shifted(self, constant: f64) -> Self {
        self + Self::constant(constant, self.model.radius)
    }

    pub(crate) fn value(&self) -> f64 {
        self.model.value
    }

    pub(crate) fn slope(&self) -> [f64; 2] {
        self.model.slope
    }

    pub(crate) fn radius(&self) -> [f64; 2] {
        self.model.radius
    }

    /// What the function is away from its linear part at most, rounding included.
    pub(crate) fn rest(&self) -> f64 {
        self.model.rest
    }

    /// Half widths of the slopes' enclosures.
    pub(crate) fn swing(&self) -> [f64; 2] {
        self.swing
    }

    /// |f| is at most this.
    pub(crate) fn bound(&self) -> f64 {
        self.model.most()
    }

    /// Rounding is all that the function is away from its linear part.
    pub(crate) fn is_blurred(&self) -> bool {
        self.rounding >= 0.5 * self.model.rest
    }

    /// Shares of the two axes in what the slopes change by.
    pub(crate) fn shares(&self) -> [f64; 2] {
        let ([x, y], [dx, dy]) = (self.radius(), self.swing);
        [x * dx, y * dy]
    }

    /// The function has no zero on the rectangle.
    pub(crate) fn excludes_zero(&self) -> bool {
        self.model.clearance() > 16.0 * f64::EPSILON * self.model.tilt()
    }

    /// The sign that the function has all over the rectangle; 0 if it may have either.
    pub(crate) fn sign(&self) -> f64 {
        if self.excludes_zero() { self.model.value.signum() } else { 0.0 }
    }

    /// 1/f; `None` where f may vanish.
    pub(crate) fn reciprocal(&self) -> Option<Self> {
        if !self.excludes_zero() {
            return None;
        }
        let Taylor { value, slope, rest, radius } = self.model;
        let (tilt, least, inverse) = (self.model.tilt(), self.model.clearance().recip(), value.recip());
        let size = inverse.abs();
        // 1/f − (1/v − σ/v²) = (σ² − ρ(v − σ))/(f v²) with f = v + σ + ρ, and (s f² − s v² − δv²)/(f v)² of a slope s + δ.
        let away = (tilt + rest) * (value.abs() + self.bound()) * (least * size) * (least * size);
        let rounding = self.rounding * least * least + f64::EPSILON * size;
        let rest = (tilt * tilt + rest * (value.abs() + tilt)) * least * size * size + f64::EPSILON * size;
        Some(Self {
            model: Taylor { value: inverse, slope: slope.map(|slope| -slope * inverse * inverse), rest, radius },
            swing: std::array::from_fn(|i| slope[i].abs() * away + self.swing[i] * least * least),
            rounding,
        })
    }

    /// What is known of a function that may be anything, as this one may vanish: where to halve for that to end.
    pub(crate) fn unknown(self) -> Self {
        let ([x, y], slope) = (self.radius(), self.slope());
        let size = (self.value().abs() + self.rounding).max(f64::MIN_POSITIVE);
        let steep: [f64; 2] = std::array::from_fn(|i| (slope[i].abs() + self.swing[i]) / size);
        let swing = steep.map(|steep| if steep.is_finite() { steep } else { 0.0 });
        let rounding = self.rounding / size;
        let rest = 0.5 * (swing[0] * x + swing[1] * y) + rounding;
        Self { model: Taylor { value: 0.0, slope: [0.0; 2], rest, ..self.model }, swing, rounding }
    }
}

impl Add for Patch {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let rounding = f64::EPSILON * (self.value().abs() + other.value().abs());
        Self {
            model: self.model + other.model,
            swing: [self.swing[0] + other.swing[0], self.swing[1] + other.swing[1]],
            rounding: self.rounding + other.rounding + rounding,
        }
    }
}

impl Neg for Patch {
    type Output = Self;
    fn neg(self) -> Self {
        Self { model: -self.model, ..self }
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
        let model = self.model * other.model;
        // What each factor differs from its value at the centre by; rounding of the slopes comes with it.
        let change = |f: &Self| f.model.tilt() + f.model.rest + f64::EPSILON * f.model.value.abs();
        let (change_f, change_g) = (change(&self), change(&other));
        let (f, g) = (self.model.value.abs() + change_f, other.model.value.abs() + change_g);
        let swing = |i: usize| {
            let (s, t) = (self.model.slope[i].abs(), other.model.slope[i].abs());
            s * change_g + t * change_f + self.swing[i] * g + other.swing[i] * f
        };
        Self {
            model,
            swing: [swing(0), swing(1)],
            rounding: f * other.rounding + g * self.rounding + f64::EPSILON * model.value.abs(),
        }
    }
}

#[cfg(test)]
mod tests;
