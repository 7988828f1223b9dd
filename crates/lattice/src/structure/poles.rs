//! Poles of λ² + λD + Ω² and their shapes, where D couples the modes.
//!
//! They begin as eigenvalues of the state matrix [[0, Ω], [−Ω, −D]] of (Ωy, y′). (With 1 and Ω² in it instead, digits would depend on the unit
//! of time.) That knows them up to rounding of the fastest one. With L(λ)y = r in twice the digits, yᵀL′y = 1 and (λ²+λD+Ω²)⁻¹ = Σ yyᵀ/(λ−λ_i),
//!
//! ```text
//! δλ = −yᵀr,    δy = −Σ_i y_i · y_iᵀ(r + δλL′y)/(λ−λ_i)  + what keeps yᵀL′y = 1
//! ```
//!
//! are steps of Newton's method for all of them. What the last one leaves of r bounds the errors that are told.

use nalgebra::{DMatrix, DVector};
use rustfft::num_complex::Complex;

use super::error::StructureError;
use super::oscillator::Bounded;
use super::state_matrix::eigen;
use crate::simd::complex_twofold::ComplexTwofold;
use crate::simd::twofold::{FINE, Twofold};

type C = Complex<f64>;

/// Poles of one shape closer than this part of their size are as good as one.
const COINCIDENT: f64 = 1e-7;

/// Poles closer than this part of their size are one with several shapes, of which any mixtures are shapes, too.
const ONE: f64 = 64.0 * f64::EPSILON;

/// Corrections this small have no square that counts.
const SETTLED: f64 = 1e-13;

/// Corrections along another pole's shape beyond this are no small ones.
const APART: f64 = 0.1;

/// Corrections at most: two are usual.
const PASSES: usize = 10;

/// A pole with its shape in the coordinates of the modes, yᵀ(2λ + D)y = 1. Of a real one y is real, or imaginary.
#[derive(Debug, Clone)]
pub(super) struct Pole {
    rate: ComplexTwofold,
    /// A bound of its error.
    pub(super) error: f64,
    /// y is the sum of both parts; bounds of the errors of its entries.
    shape: Vec<C>,
    rest: Vec<C>,
    shape_errors: Vec<f64>,
}

/// λ² + λD + Ω²
pub(super) struct Pencil<'a> {
    pub(super) squares: &'a [Bounded],
    pub(super) damping: &'a [Vec<Bounded>],
}

/// What is left of L(λ)y = 0.
struct Residual {
    left: Vec<C>,
    /// Bounds of its errors by rounding, and by those of D and Ω².
    errors: Vec<f64>,
    /// L′y = 2λy + Dy
    slope: Vec<C>,
    /// yᵀL′y − 1
    length: C,
}

/// One step of Newton's method.
struct Step {
    rate: C,
    shape: Vec<C>,
    /// The largest part of another pole's shape in it.
    size: f64,
}

impl Pole {
    /// λ
    pub(super) fn rate(&self) -> C {
        self.rate.value()
    }

    /// y
    pub(super) fn shape(&self) -> DVector<C> {
        DVector::from_iterator(self.shape.len(), self.shape.iter().zip(&self.rest).map(|(high, low)| high + low))
    }

    /// Σ b_k y_k with a bound of its error, b_k being what is seen of each mode.
    pub(super) fn seen(&self, of_modes: &[Bounded]) -> (C, f64) {
        let part = |of: fn(&C) -> f64| {
            let high = of_modes.iter().zip(&self.shape).map(|(mode, y)| (mode.sum.high, of(y)));
            let rest = of_modes.iter().zip(self.shape.iter().zip(&self.rest));
            let low: f64 = rest.map(|(mode, (y, rest))| mode.sum.low * of(y) + mode.sum.high * of(rest)).sum();
            (Twofold::dot(high) + Twofold::from(low)).value()
        };
        let n = of_modes.len() as f64;
        let mut error = 0.0;
        for (k, mode) in of_modes.iter().enumerate() {
            let (b, y, rest) = (mode.sum.high.abs(), self.shape[k].norm(), self.rest[k].norm());
            error += mode.error * (y + rest) + b * (self.shape_errors[k] + n * f64::EPSILON * rest + n * n * FINE * y);
        }
        (C::new(part(|y| y.re), part(|y| y.im)), error)
    }

    /// Of a shape that begins a search.
    fn begun(rate: C, shape: Vec<C>) -> Self {
        let none = vec![C::default(); shape.len()];
        let shape_errors = vec![0.0; shape.len()];
        Self { rate: rate.into(), error: 0.0, shape, rest: none, shape_errors }
    }

    fn is_one_with(&self, other: &Self) -> bool {
        (self.rate() - other.rate()).norm() <= ONE * self.rate().norm()
    }

    fn conjugate(&self) -> Self {
        let turned = |list: &[C]| list.iter().map(C::conj).collect();
        let rate = ComplexTwofold { re: self.rate.re, im: -self.rate.im };
        Self { rate, shape: turned(&self.shape), rest: turned(&self.rest), ..self.clone() }
    }
}

impl Pencil<'_> {
    /// The poles on the real axis and above it, as well as numbers hold them.
    ///
    /// # Errors
    /// [`StructureError`] where two poles of one shape coincide.
    pub(super) fn poles(&self) -> Result<Vec<Pole>, StructureError> {
        let mut poles = self.first()?;
        let mut last = f64::INFINITY;
        for _ in 0..PASSES {
            let all = with_conjugates(&poles);
            let steps: Vec<Step> = poles.iter().map(|pole| self.step(pole, &all)).collect();
            let size = steps.iter().map(|step| step.size).fold(0.0, f64::max);
            let done = size <= SETTLED || size > 0.25 * last;
            for (pole, step) in poles.iter_mut().zip(steps) {
                pole.rate = pole.rate + step.rate.into();
                if done {
                    pole.rest = step.shape;
                } else {
                    pole.shape.iter_mut().zip(step.shape).for_each(|(y, by)| *y += by);
                }
            }
            if done {
                break;
            }
            last = size;
        }
        let all = with_conjugates(&poles);
        let errors: Vec<_> = (0..poles.len()).map(|k| self.errors(k, &all)).collect();
        for (pole, (error, shape_errors)) in poles.iter_mut().zip(errors) {
            (pole.error, pole.shape_errors) = (error, shape_errors);
        }
        Ok(poles)
    }

    /// As an eigensolver knows them.
    fn first(&self) -> Result<Vec<Pole>, StructureError> {
        let m = self.squares.len();
        let damping = DMatrix::from_fn(m, m, |i, j| self.damping[i][j].sum.value());
        let squares: Vec<f64> = self.squares.iter().map(|square| square.sum.value()).collect();
        let size = damping.amax();
        let (rates, vectors) = eigen(&squares, &damping)?;
        let complex_damping = damping.map(|x| C::new(x, 0.0));
        let mut poles: Vec<Pole> = Vec::with_capacity(m);
        for (rate, mut vector) in rates.into_iter().zip(vectors).filter(|(rate, _)| rate.im >= 0.0) {
            // The shapes that count have yᵢᵀ(λᵢ + λⱼ + D)yⱼ = 0, which those of one pole do not have by themselves. Twice is enough.
            let beside = |other: &&Pole| (other.rate() - rate).norm() <= COINCIDENT * (rate.norm() + size);
            for other in poles.iter().filter(beside).chain(poles.iter().filter(beside)) {
                let shape = Pole::shape(other);
                let along = shape.dot(&(&vector * (rate + other.rate()) + &complex_damping * &vector));
                vector -= shape * along;
            }
            // yᵀ(2λ + D)y, of a symmetric D; of others both sides would count.
            let square = |y: &DVector<C>| y.dot(&(y * (rate * 2.0) + &complex_damping * y));
            let length = vector.iter().map(|x| x.norm_sqr()).sum::<f64>();
            if square(&vector).norm() <= COINCIDENT * length * (rate.norm() + size) {
                return Err(StructureError::Defective { re: rate.re, im: rate.im });
            }
            let mut shape = vector.clone();
            if rate.im == 0.0 {
                // Its phase is any: along its largest entry it is real.
                let largest = vector.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
                shape = vector.map(|x| C::new((x / largest).re, 0.0));
            }
            let root = square(&shape).sqrt();
            // The root of what is below 0 is imaginary, exactly.
            let root = if rate.im != 0.0 {
                root
            } else if root.re.abs() > root.im.abs() {
                C::new(root.re, 0.0)
            } else {
                C::new(0.0, root.im)
            };
            poles.push(Pole::begun(rate, shape.iter().map(|y| y / root).collect()));
        }
        Ok(poles)
    }

    fn residual(&self, pole: &Pole) -> Residual {
        let m = self.squares.len();
        let rate = pole.rate;
        let speed = rate.value().norm();
        let square = rate * rate;
        let fine = (m * m) as f64 * FINE;
        let shape: Vec<ComplexTwofold> = (pole.shape.iter().zip(&pole.rest))
            .map(|(high, low)| ComplexTwofold {
                re: Twofold::of_sum(high.re, low.re),
                im: Twofold::of_sum(high.im, low.im),
            })
            .collect();
        let (mut left, mut errors, mut slope) = (Vec::with_capacity(m), Vec::with_capacity(m), Vec::with_capacity(m));
        let mut length = ComplexTwofold::from(C::new(-1.0, 0.0));
        for (i, (own, row)) in self.squares.iter().zip(self.damping).enumerate() {
            let image = |part: fn(&ComplexTwofold) -> Twofold| {
                let high = Twofold::dot(row.iter().zip(&shape).map(|(entry, y)| (entry.sum.high, part(y).high)));
                let low = row.iter().zip(&shape).map(|(d, y)| d.sum.low * part(y).high + d.sum.high * part(y).low);
                high + Twofold::from(low.sum::<f64>())
            };
            let damped = ComplexTwofold { re: image(|y| y.re), im: image(|y| y.im) };
            let y = shape[i];
            let held = ComplexTwofold { re: own.sum * y.re, im: own.sum * y.im };
            let whole = (square * y + rate * damped + held).value();
            let steep = rate * y + rate * y + damped;
            let (mut damping, mut doubt) = (0.0, 0.0);
            for (entry, y) in row.iter().zip(&pole.shape) {
                damping += entry.sum.high.abs() * y.norm();
                doubt += entry.error * y.norm();
            }
            let size = pole.shape[i].norm();
            let terms = (speed * speed + own.sum.high.abs()) * size + speed * damping;
            errors.push(
                m as f64 * f64::EPSILON * whole.norm()
                    + (fine + 16.0 * FINE) * terms
                    + speed * doubt
                    + own.error * size,
            );
            left.push(whole);
            slope.push(steep.value());
            length = length + y * steep;
        }
        Residual { left, errors, slope, length: length.value() }
    }

    /// Parts of the shapes of all other poles in the correction of one.
    fn parts(pole: &Pole, all: &[Pole], whole: &[C]) -> Vec<C> {
        let rate = pole.rate();
        let part = |other: &Pole| {
            let distance = rate - other.rate();
            if pole.is_one_with(other) { C::default() } else { -dot(&other.shape, whole) / distance }
        };
        all.iter().map(part).collect()
    }

    fn step(&self, pole: &Pole, all: &[Pole]) -> Step {
        let Residual { left, slope, length, .. } = self.residual(pole);
        let rate = -dot(&pole.shape, &left) / (C::new(1.0, 0.0) + length);
        let whole: Vec<C> = left.iter().zip(&slope).map(|(r, steep)| r + rate * steep).collect();
        let mut parts = Self::parts(pole, all, &whole);
        // Those that are no small ones lead nowhere.
        parts
            .iter_mut()
            .filter(|part| part.norm().is_nan() || part.norm() > APART)
            .for_each(|part| *part = C::default());
        let size = parts.iter().map(|part| part.norm()).fold(length.norm(), f64::max);
        let mut shape = vec![C::default(); left.len()];
        for (part, other) in parts.iter().zip(all) {
            shape.iter_mut().zip(&other.shape).for_each(|(entry, y)| *entry += part * y);
        }
        let own = -0.5 * length - rate * dot(&pole.shape, &pole.shape) - dot(&slope, &shape);
        shape.iter_mut().zip(&pole.shape).for_each(|(entry, y)| *entry += own * y);
        if pole.rate.im.value() == 0.0 {
            // What is real or imaginary stays so.
            let is_real = pole.shape.iter().all(|y| y.im == 0.0);
            shape.iter_mut().for_each(|y| *y = if is_real { C::new(y.re, 0.0) } else { C::new(0.0, y.im) });
            return Step { rate: C::new(rate.re, 0.0), shape, size };
        }
        Step { rate, shape, size }
    }

    /// Bounds of the errors of pole number `k` and of the entries of its shape.
    fn errors(&self, k: usize, all: &[Pole]) -> (f64, Vec<f64>) {
        let pole = &all[k];
        let Residual { left, errors, slope, length } = self.residual(pole);
        let left: Vec<f64> = left.iter().zip(&errors).map(|(left, error)| left.norm() + error).collect();
        let size = |other: &Pole, list: &[f64]| other.shape.iter().zip(list).map(|(y, x)| y.norm() * x).sum::<f64>();
        let moved = size(pole, &left);
        let crossed = |other: &Pole| dot(&other.shape, &slope).norm();
        let others = all.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, other)| other);
        let (one, apart): (Vec<&Pole>, Vec<&Pole>) = others.partition(|other| pole.is_one_with(other));
        let crossings: Vec<f64> = one.iter().map(|other| crossed(other)).collect();
        let slope: Vec<f64> = slope.iter().map(|steep| steep.norm()).collect();
        let mut error = moved + 4.0 * FINE * pole.rate().norm();
        let whole: Vec<f64> = left.iter().zip(&slope).map(|(left, steep)| left + moved * steep).collect();
        let mut shape_errors = vec![0.0; left.len()];
        for (other, along) in one.into_iter().zip(crossings) {
            error += size(other, &whole);
            shape_errors.iter_mut().zip(&other.shape).for_each(|(entry, y)| *entry += along * y.norm());
        }
        for other in apart {
            let part = size(other, &whole);
            let along = part / (pole.rate() - other.rate()).norm();
            // Of two that are not told apart each may be where the other one is said to be.
            if along <= APART {
                error += part * along;
                shape_errors.iter_mut().zip(&other.shape).for_each(|(entry, y)| *entry += along * y.norm());
            } else {
                error += part;
            }
        }
        let square: f64 = pole.shape.iter().map(|y| y.norm_sqr()).sum();
        let own = length.norm() + moved * square + slope.iter().zip(&shape_errors).map(|(a, b)| a * b).sum::<f64>();
        shape_errors.iter_mut().zip(&pole.shape).for_each(|(entry, y)| *entry += own * y.norm());
        (error, shape_errors)
    }
}

/// Σ a b, without conjugates.
fn dot(a: &[C], b: &[C]) -> C {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn with_conjugates(poles: &[Pole]) -> Vec<Pole> {
    let below = poles.iter().filter(|pole| pole.rate.im.value() != 0.0).map(Pole::conjugate);
    poles.iter().cloned().chain(below).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If squares and dashpots are off by no more than their errors, poles and shapes move by no more than theirs; some move by a fifth of it.
    #[test]
    fn errors_of_entries_are_carried_to_poles_and_shapes() {
        let (mut draw, mut near, mut checked) = (0.0_f64, [0.0_f64; 2], 0);
        for round in 0..300 {
            let m = 1 + round % 4;
            let mut entry = |value: f64| {
                // Spread over 0 to 1 by the golden section.
                draw = (draw + 0.618_033_988_749_894_9).fract();
                let error = 1e-10 * value.abs() * draw;
                let moved = value + if (64.0 * draw) % 2.0 < 1.0 { error } else { -error };
                [value, moved].map(|value| Bounded { sum: value.into(), error })
            };
            let squares: Vec<_> = (0..m).map(|k| entry(1.0 + 1.7 * (k * k) as f64)).collect();
            let mut damping = vec![vec![[Bounded::default(); 2]; m]; m];
            for i in 0..m {
                for j in 0..=i {
                    let size = [0.1, 0.3, 1.0][(round / 4) % 3];
                    let value = if i == j { size + 0.1 * (i + 1) as f64 } else { 0.2 * size * (i + 2 * j + 1) as f64 };
                    damping[i][j] = entry(value);
                    damping[j][i] = damping[i][j];
                }
            }
            let [told, moved] = [0, 1].map(|which| {
                let squares: Vec<Bounded> = squares.iter().map(|both| both[which]).collect();
                let damping: Vec<Vec<Bounded>> =
                    damping.iter().map(|row| row.iter().map(|both| both[which]).collect()).collect();
                Pencil { squares: &squares, damping: &damping }.poles().unwrap()
            });
            for (pole, other) in told.iter().zip(&moved) {
                let off = (pole.rate() - other.rate()).norm();
                assert!(off <= pole.error * (1.0 + 1e-6), "{round}: {off:e} {:e}", pole.error);
                near[0] = near[0].max(off / pole.error);
                let (shape, theirs) = (pole.shape(), other.shape());
                // Either sign.
                let sign = if (&shape - &theirs).norm() < shape.norm() { 1.0 } else { -1.0 };
                for ((y, x), error) in shape.iter().zip(&theirs).zip(&pole.shape_errors) {
                    let off = (y - x * sign).norm();
                    assert!(off <= error * (1.0 + 1e-6) + 4.0 * f64::EPSILON * y.norm(), "{round}: {off:e} {error:e}");
                    near[1] = near[1].max(off / error);
                }
                checked += 1;
            }
        }
        assert!(checked > 600 && near.iter().all(|near| *near > 0.2), "{checked} {near:?}");
    }
}
