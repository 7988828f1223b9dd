//! Sines and cosines of four phases at once, without branches and without a library's own: the same bits on every machine, for a fifth
//! of the time.
//!
//! A phase is reduced by the nearest multiple of π/2, which is kept in three parts that meet without rounding, to |r| ≤ π/4, where
//! Taylor's series of 8 and 9 terms leave less than 1e-16 of the sine and 3e-18 of the cosine.

use std::f64::consts::FRAC_2_PI;

use wide::f64x4;

use super::lanes::{HALF, ONE, TWO};

/// Phases up to here: multiples of π/2 below 2²⁰, whose products with its first two parts of 33 digits are exact.
pub(crate) const MOST: f64 = 1.6e6;

/// π/2 in three parts: the first two have 33 binary digits each.
const PARTS: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_7e-21];

/// 1.5·2⁵²: added and taken away again it rounds to a whole number, which stands in the last digits of the sum.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// (−1)ᵏ/(2k+1)! and (−1)ᵏ/(2k)!.
const SINE: [f64; 9] = coefficients(1);
const COSINE: [f64; 9] = coefficients(0);

const fn coefficients(odd: u32) -> [f64; 9] {
    let mut all = [0.0; 9];
    // Up to 17! whole numbers below 2⁵³ hold the factorial exactly.
    let (mut k, mut factorial) = (0, 1.0);
    let mut n = 1;
    while k < 9 {
        while n <= 2 * k as u32 + odd {
            factorial *= n as f64;
            n += 1;
        }
        all[k] = if k % 2 == 0 { 1.0 / factorial } else { -1.0 / factorial };
        k += 1;
    }
    all
}

fn series<const N: usize>(square: f64x4, coefficients: [f64x4; N]) -> f64x4 {
    coefficients.into_iter().rev().fold(f64x4::ZERO, |sum, c| sum * square + c)
}

/// Sine and cosine of four phases of no more than [`MOST`].
#[inline(always)]
pub(crate) fn sin_cos(x: f64x4) -> [f64x4; 2] {
    let [first, second, third] = PARTS.map(f64x4::splat);
    let rounded = x * f64x4::splat(FRAC_2_PI) + f64x4::splat(ROUND);
    let turns = rounded - f64x4::splat(ROUND);
    // The second difference is rounded; what it drops moves sine and cosine by their slopes.
    let (coarse, fine) = (x - turns * first, turns * second);
    let r = coarse - fine;
    let dropped = ((coarse - r) - fine) - turns * third;
    let square = r * r;
    // The first terms are added last, that of the cosine with what it drops in turn.
    let [one, sine @ ..] = SINE.map(f64x4::splat);
    let [_, half, cosine @ ..] = COSINE.map(f64x4::splat);
    let bend = square * half;
    let cos_so_far = one + bend;
    let sin = r + (r * (square * series(square, sine)) + dropped * cos_so_far);
    let cos = cos_so_far + (((one - cos_so_far) + bend) + (square * square * series(square, cosine) - r * dropped));
    // Of quarter turns the last two digits tell.
    let parity = turns - TWO * (turns * HALF).floor();
    let odd = parity.simd_eq(ONE);
    let half_turns = (turns * HALF).floor();
    let flip = (half_turns - TWO * (half_turns * HALF).floor()).simd_eq(ONE);
    let (s, c) = (odd.select(cos, sin), odd.select(sin, cos));
    let sine = flip.select(-s, s);
    // cos(x + π/2) = −sin x: turned round in the second and third quarter.
    let cosine = (odd ^ flip).select(-c, c);
    [sine, cosine]
}

/// sin x/x and (1 − cos x)/x² of four numbers |x| ≤ 1, smooth at 0.
#[inline(always)]
pub(crate) fn soft(x: f64x4) -> [f64x4; 2] {
    let square = x * x;
    let [_, halves @ ..] = COSINE.map(f64x4::splat);
    [series(square, SINE.map(f64x4::splat)), -series(square, halves)]
}

/// sin x/x and (x − sin x)/x³ of four numbers |x| ≤ 1.
#[inline(always)]
pub(crate) fn soft_defect(x: f64x4) -> [f64x4; 2] {
    let square = x * x;
    let [one, sine @ ..] = SINE.map(f64x4::splat);
    let defect = -series(square, sine);
    [one - square * defect, defect]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_are_those_of_the_library() {
        assert_eq!(PARTS[0] + PARTS[1], std::f64::consts::FRAC_PI_2);
        for part in &PARTS[..2] {
            assert_eq!(part.to_bits() & ((1 << 19) - 1), 0, "a product with 20 more digits is exact");
        }
        let mut random = 1_u64;
        let mut next = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut checked = 0;
        for i in 0..200_000_i32 {
            let size = [0.5, 3.0, 40.0, 1e3, MOST][i as usize % 5];
            let near = std::f64::consts::FRAC_PI_2 * f64::from(i % 9 - 4) + 1e-6 * (next() - 0.5);
            let x = [size * (next() - 0.5), -size * next(), size * next(), near];
            let [sin, cos] = sin_cos(f64x4::from(x)).map(f64x4::to_array);
            for j in 0..4 {
                let (sine, cosine) = x[j].sin_cos();
                assert!((sin[j] - sine).abs() <= 2.0 * f64::EPSILON * sine.abs(), "{} {} {sine}", x[j], sin[j]);
                assert!((cos[j] - cosine).abs() <= 2.0 * f64::EPSILON * cosine.abs(), "{} {} {cosine}", x[j], cos[j]);
                checked += 1;
            }
            let x = 2.0 * next() - 1.0;
            let [sinc, rest] = soft(f64x4::splat(x)).map(|four| four.to_array()[0]);
            let half = (0.5 * x).sin();
            let [same, defect] = soft_defect(f64x4::splat(x)).map(|four| four.to_array()[0]);
            assert!((same - sinc).abs() < 4e-16 && (defect - crate::simd::small::cubic_defect(x)).abs() < 1e-16);
            assert!(
                (sinc - crate::simd::small::sinc(x)).abs() < 4e-16 && (rest - 2.0 * (half / x).powi(2)).abs() < 4e-16
            );
        }
        assert_eq!(checked, 800_000);
        let [sinc, rest] = soft(f64x4::ZERO).map(f64x4::to_array);
        assert_eq!((sinc[0], rest[0], sin_cos(f64x4::ZERO)), (1.0, 0.5, [f64x4::ZERO, ONE]));
    }
}
