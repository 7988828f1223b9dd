//! Spectra on their way: one of each pair above the real axis; without losses, which two collide on the circle.

use nalgebra::Complex;

/// The least imaginary part of one of a pair, and the largest distance from the circle of one that lies on it: the root of
/// rounding, by which a double eigenvalue may split.
pub(crate) const SPLIT: f64 = 1e-7;

/// A pair that is closer to the circle than this, as ln|μ|, all along a step stays on it: it hardly feels the impacts.
pub(crate) const ON_CIRCLE: f64 = 1e-12;

/// One of each complex pair, the one above the real axis.
pub(crate) fn upper_half(values: &[Complex<f64>]) -> Vec<Complex<f64>> {
    values.iter().copied().filter(|value| value.im > SPLIT).collect()
}

fn nearest(value: Complex<f64>, others: &[Complex<f64>]) -> Option<(usize, f64)> {
    let distances = others.iter().enumerate().map(|(j, other)| (j, (other - value).norm()));
    distances.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// ν = ½(μ + 1/μ), one for each pair μ, 1/μ of a spectrum without loss, those on the circle made real.
pub(crate) fn half_sums(values: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let half_sum = |value: Complex<f64>| {
        let nu = (value + value.inv()) * 0.5;
        if (value.norm() - 1.0).abs() < SPLIT { Complex::new(nu.re, 0.0) } else { nu }
    };
    // Of four off the circle the two above the axis give ν and its conjugate, of two pairs on it one each.
    let mut sums: Vec<Complex<f64>> = values.iter().copied().filter(|value| value.im > SPLIT).map(half_sum).collect();
    // Real ones in pairs, the largest with the smallest; the larger has the digits.
    for sign in [1.0, -1.0] {
        let mut real: Vec<f64> =
            values.iter().filter(|value| value.im.abs() <= SPLIT).map(|value| sign * value.re).collect();
        real.retain(|value| *value > 0.0);
        real.sort_by(|a, b| b.total_cmp(a));
        real.truncate(real.len().div_ceil(2));
        sums.extend(real.into_iter().map(|value| Complex::new(0.5 * sign * (value + 1.0 / value), 0.0)));
    }
    sums
}

/// Number of complex ν.
pub(crate) fn complex_count(half_sums: &[Complex<f64>]) -> usize {
    half_sums.iter().filter(|nu| nu.im.abs() > SPLIT).count()
}

/// A ν of `off` that is complex and has no complex one near it in `on`.
pub(crate) fn collided(on: &[Complex<f64>], off: &[Complex<f64>]) -> Option<Complex<f64>> {
    let complex =
        |values: &[Complex<f64>]| -> Vec<Complex<f64>> { values.iter().copied().filter(|nu| nu.im > SPLIT).collect() };
    let others = complex(on);
    let lonely = |nu: &Complex<f64>| nearest(*nu, &others).map_or(f64::INFINITY, |(_, distance)| distance);
    complex(off).into_iter().max_by(|a, b| lonely(a).total_cmp(&lonely(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_that_collide_are_told_from_others() {
        // ν = ±√d + 0.3
        let half_sums = |d: f64| {
            let root = Complex::new(d, 0.0).sqrt();
            vec![Complex::new(-0.8, 0.0), root + 0.3, -root + 0.3]
        };
        let off = half_sums(-1e-4);
        assert_eq!((complex_count(&off), complex_count(&half_sums(1e-4))), (2, 0));
        assert!((collided(&half_sums(1e-4), &off).unwrap().re - 0.3).abs() < 1e-12);
        // Multipliers e^{±iθ} on the circle, and a quadruple off it.
        let mu = Complex::from_polar(1.1, 1.0);
        let values = [mu, mu.conj(), mu.inv(), mu.inv().conj(), Complex::from_polar(1.0, 0.5)];
        let nus = super::half_sums(&values);
        assert_eq!((nus.len(), complex_count(&nus)), (3, 2));
        // The quadruple turned real, and a pair at −1 that rounding split: one ν for each pair.
        let real = [1.5, 2.0 / 3.0, 1.25, 0.8, -1.0 - 1e-9, -1.0 + 1e-9].map(|value| Complex::new(value, 0.0));
        let mut nus: Vec<f64> = super::half_sums(&real).iter().map(|nu| nu.re).collect();
        nus.sort_unstable_by(f64::total_cmp);
        let expected = [-1.0, 1.025, 0.5 * (1.5 + 1.0 / 1.5)];
        assert!(
            nus.len() == 3 && nus.iter().zip(expected).all(|(nu, expected)| (nu - expected).abs() < 1e-15),
            "{nus:?}"
        );
    }
}
