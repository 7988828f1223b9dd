//! Multipliers on their way: which pair crosses the circle between two points, and which two collide on it.

use nalgebra::Complex;

/// The least imaginary part of one of a pair, and the largest distance from the circle of one that lies on it: the root of
/// rounding, by which a double eigenvalue may split.
pub(crate) const SPLIT: f64 = 1e-7;

/// A pair that is closer to the circle than this at both ends of a step stays on it: it hardly feels the impacts.
const ON_CIRCLE: f64 = 1e-12;

/// A match is clear if it is closer than this part of the distance to the next eigenvalue.
const CLEAR: f64 = 0.4;

/// One of each complex pair, the one above the real axis.
pub(crate) fn upper_half(values: &[Complex<f64>]) -> Vec<Complex<f64>> {
    values.iter().copied().filter(|value| value.im > SPLIT).collect()
}

/// What two spectra tell about a pair that crosses the circle between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Crossing {
    /// None does.
    None,
    /// This one does, from inside to outside or back.
    Pair(Complex<f64>, Complex<f64>),
    /// One may, but which is which cannot be told: the spectra are too far apart.
    Unclear,
}

fn nearest(value: Complex<f64>, others: &[Complex<f64>]) -> Option<(usize, f64)> {
    let distances = others.iter().enumerate().map(|(j, other)| (j, (other - value).norm()));
    distances.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Distance to the nearest other eigenvalue of the same spectrum, the pair's own other half included.
fn gap(i: usize, values: &[Complex<f64>]) -> f64 {
    let others = values.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| (other - values[i]).norm());
    others.fold(2.0 * values[i].im, f64::min)
}

/// −1 inside the circle, 0 on it, 1 outside.
pub(crate) fn side(value: &Complex<f64>) -> i32 {
    let excess = value.norm_sqr() - 1.0;
    if excess.abs() < ON_CIRCLE { 0 } else { 1 - 2 * i32::from(excess < 0.0) }
}

/// Compares two spectra of the upper half plane.
pub(crate) fn crossing(from: &[Complex<f64>], to: &[Complex<f64>]) -> Crossing {
    let count = |values: &[Complex<f64>], of: i32| values.iter().filter(|value| side(value) == of).count();
    let mut unclear = [-1, 1].iter().all(|&of| count(from, of) != count(to, of));
    for (i, value) in from.iter().enumerate() {
        let Some((j, distance)) = nearest(*value, to) else { continue };
        let sides = [side(value), side(&to[j])];
        if sides[0] * sides[1] >= 0 {
            // One that grows, and then cannot be told from the circle, may have crossed it.
            unclear |= sides[0] != sides[1] && sides.contains(&1);
            continue;
        }
        let back = nearest(to[j], from).is_some_and(|(back, _)| back == i);
        if back && distance < CLEAR * gap(i, from).min(gap(j, to)) {
            return Crossing::Pair(*value, to[j]);
        }
        unclear = true;
    }
    if unclear { Crossing::Unclear } else { Crossing::None }
}

/// ν = ½(μ + 1/μ), one for each pair μ, 1/μ of a spectrum without loss, those on the circle made real.
pub(crate) fn half_sums(values: &[Complex<f64>], reversible: bool) -> Vec<Complex<f64>> {
    if reversible {
        return values.to_vec();
    }
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
    fn a_pair_that_crosses_is_told_from_its_neighbours() {
        let polar = |r: f64, t: f64| Complex::from_polar(r, t);
        let from = [polar(0.99, 1.0), polar(1.02, 2.0), polar(0.999, 0.3)];
        let to = [polar(1.01, 1.05), polar(1.03, 2.1), polar(0.998, 0.33)];
        assert_eq!(crossing(&from, &to), Crossing::Pair(from[0], to[0]));
        assert_eq!(crossing(&from, &from), Crossing::None);
        // Two that are as close as the step is long.
        let from = [polar(0.99, 1.0), polar(1.01, 1.1)];
        let to = [polar(1.01, 1.1), polar(1.01, 1.2)];
        assert_eq!(crossing(&from, &to), Crossing::Unclear);
        // A pair that arrives from the real axis outside has crossed nothing.
        assert_eq!(crossing(&from[..1], &[polar(0.99, 1.0), polar(1.2, 3.0)]), Crossing::None);
        // Pairs that hardly feel the impacts wander about the circle by rounding.
        assert_eq!(crossing(&[polar(1.0 - 1e-15, 1.0)], &[polar(1.0 + 1e-15, 1.01)]), Crossing::None);
    }

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
        let nus = super::half_sums(&values, false);
        assert_eq!((nus.len(), complex_count(&nus)), (3, 2));
        // The quadruple turned real, and a pair at −1 that rounding split: one ν for each pair.
        let real = [1.5, 2.0 / 3.0, 1.25, 0.8, -1.0 - 1e-9, -1.0 + 1e-9].map(|value| Complex::new(value, 0.0));
        let mut nus: Vec<f64> = super::half_sums(&real, false).iter().map(|nu| nu.re).collect();
        nus.sort_unstable_by(f64::total_cmp);
        let expected = [-1.0, 1.025, 0.5 * (1.5 + 1.0 / 1.5)];
        assert!(
            nus.len() == 3 && nus.iter().zip(expected).all(|(nu, expected)| (nu - expected).abs() < 1e-15),
            "{nus:?}"
        );
    }
}
