//! What an interval of the grid does to a mode.

use wide::f64x4;

/// cos Ωh, sin Ωh/Ω and Ω sin Ωh, for Ωh up to [`INTERVAL`](super::INTERVAL).
pub(crate) fn turn(frequency: f64x4, step: f64x4) -> [f64x4; 3] {
    let x = frequency * step;
    let square = x * x;
    let series = |coefficients: [f64; 8]| {
        coefficients.into_iter().rev().fold(f64x4::ZERO, |sum, c| sum * square + f64x4::splat(c))
    };
    let sin_over = step * series(SINC);
    [series(COSINE), sin_over, frequency * frequency * sin_over]
}

/// cos x and sin x/x in powers of −x²; for x ≤ 1/2 the first term left out is below 1e-18.
const COSINE: [f64; 8] = [
    1.0,
    -1.0 / 2.0,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
];

const SINC: [f64; 8] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
];
