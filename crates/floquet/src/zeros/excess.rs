//! From ν to excess per period without cancellation.

use nalgebra::Complex;

/// ν by its distances from both ends of [−1, 1], since roots next to the ends are told apart by nothing else.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Nu {
    /// Re ν − 1
    pub(crate) below: f64,
    /// Re ν + 1
    pub(crate) above: f64,
    /// Im ν
    pub(crate) im: f64,
}

impl Nu {
    /// ±(1 + δ) for `end` = ±1.
    pub(crate) fn beyond(end: f64, delta: f64) -> Self {
        if end > 0.0 {
            Self { below: delta, above: 2.0 + delta, im: 0.0 }
        } else {
            Self { below: -2.0 - delta, above: -delta, im: 0.0 }
        }
    }

    pub(crate) fn of(nu: Complex<f64>) -> Self {
        Self { below: nu.re - 1.0, above: nu.re + 1.0, im: nu.im }
    }

    pub(crate) fn complex(&self) -> Complex<f64> {
        let re = if self.below.abs() < self.above.abs() { 1.0 + self.below } else { self.above - 1.0 };
        Complex::new(re, self.im)
    }

    /// |μ| − 1 ≥ 0 of the larger of the two multipliers μ + 1/μ = 2ν. With ν = cos θ, |Im θ| = arsinh r,
    /// 2r² = B + √(B²+4y²), B = x²+y²−1; for B < 0 the conjugate form.
    pub(crate) fn excess(&self) -> f64 {
        let y = self.im;
        if y == 0.0 {
            return outside(self.below.max(-self.above));
        }
        let b = self.below * self.above + y * y;
        let root = b.hypot(2.0 * y);
        let square = if b > 0.0 { 0.5 * (b + root) } else { 2.0 * y * y / (root - b) };
        square.sqrt().asinh().exp_m1()
    }

    /// How much an error of ν moves the excess: |dμ/dν| = |μ|/|√(ν²−1)|; a root within the error of ±1 like a square root.
    pub(crate) fn excess_error(&self, excess: f64, error: f64) -> f64 {
        let from = |end: f64| modulus(Complex::new(end, self.im));
        let square = from(self.below) * from(self.above);
        let reach = if square > 2.0 * error { error / square.sqrt() } else { (2.0 * error).sqrt() };
        (1.0 + excess) * reach + 4.0 * f64::EPSILON * excess
    }

    /// μ = ν ± √(ν−1)√(ν+1), the larger modulus first; by factors, since next to ±1 the difference keeps its digits.
    pub(crate) fn multipliers(&self) -> [Complex<f64>; 2] {
        let value = self.complex();
        if self.im == 0.0 && self.below <= 0.0 && self.above >= 0.0 {
            let on_circle = Complex::new(value.re, (-self.below * self.above).sqrt());
            return [on_circle, on_circle.conj()];
        }
        let root = Complex::new(self.below, self.im).sqrt() * Complex::new(self.above, self.im).sqrt();
        let (plus, minus) = (value + root, value - root);
        let large = if plus.norm_sqr() >= minus.norm_sqr() { plus } else { minus };
        [large, large.inv()]
    }
}

/// |z| − 1 without the cancellation of the modulus itself.
pub(crate) fn excess(z: Complex<f64>) -> f64 {
    let square = (z.re - 1.0).mul_add(z.re + 1.0, z.im * z.im);
    square / (1.0 + modulus(z))
}

/// |z|, by the plain root of its square wherever that is in range: `hypot` takes ten times as long.
#[inline]
pub(crate) fn modulus(z: Complex<f64>) -> f64 {
    let square = z.norm_sqr();
    if square > 1e-280 && square < 1e280 { square.sqrt() } else { z.norm() }
}

/// |μ| − 1 for a real |ν| = 1 + δ; 0 for δ ≤ 0.
pub(crate) fn outside(delta: f64) -> f64 {
    if delta > 0.0 { delta + (delta * (2.0 + delta)).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excess_is_that_of_the_multiplier() {
        for (x, y) in [(1.5_f64, 0.0_f64), (-3.0, 0.0), (0.3, 0.4), (-0.9, 1e-3), (2.0, 1.0), (0.0, 1e-2)] {
            let nu = Complex::new(x, y);
            let root = (nu * nu - 1.0).sqrt();
            let modulus: f64 = (nu + root).norm().max((nu - root).norm());
            assert!((Nu::of(nu).excess() / (modulus - 1.0) - 1.0).abs() < 1e-11, "{nu}");
        }
        assert_eq!(Nu::of(Complex::new(0.5, 0.0)).excess(), 0.0);
        // Next to an end only the distance from it tells.
        let close = Nu { below: 1e-20, above: 2.0, im: 1e-20 };
        let expected = (1e-20 * (1.0 + 2f64.sqrt())).sqrt();
        assert!((close.excess() / expected - 1.0).abs() < 1e-9);
        assert!((close.multipliers()[0].re - 1.0 - expected).abs() < 1e-15);
        // Far below what |μ| − 1 can hold: excess y/sin θ.
        assert!((Nu::of(Complex::new(0.6, 1e-20)).excess() * 1e20 - 1.25).abs() < 1e-14);
    }

    #[test]
    fn pairs_are_reciprocal_and_on_the_circle_where_they_should_be() {
        for (re, im) in [(0.3, 0.0), (-1.0, 0.0), (1.0, 0.0), (1.5, 0.0), (-7.0, 0.0), (0.2, 0.4), (1.0 + 1e-12, 0.0)] {
            let nu = Complex::new(re, im);
            let [a, b] = Nu::of(nu).multipliers();
            assert!((a * b - Complex::new(1.0, 0.0)).norm() < 1e-15);
            assert!(((a + b) * 0.5 - nu).norm() < 1e-15 * (1.0 + nu.norm()));
            if im == 0.0 && re.abs() <= 1.0 {
                assert!((a.norm() - 1.0).abs() < 1e-15);
            }
        }
        // Just outside +1 the excess is √(2δ), to full relative accuracy.
        let delta = 2f64.powi(-40);
        let [a, _] = Nu::of(Complex::new(1.0 + delta, 0.0)).multipliers();
        assert!(((a.re - 1.0) / ((2.0 * delta).sqrt() + delta) - 1.0).abs() < 1e-9);
    }
}
