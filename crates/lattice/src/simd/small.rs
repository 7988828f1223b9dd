//! Quotients that stay smooth at zero, and sums that keep their digits.

use wide::f64x4;

/// sin(x)/x, 1 at 0. Below 2⁻¹³ the series is exact to the last digit and avoids 0/0.
pub fn sinc(x: f64) -> f64 {
    if x.abs() < SERIES { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

/// 2⁻¹³.
const SERIES: f64 = 1.220703125e-4;

/// sin(Ωt)/Ω, t at Ω = 0.
pub fn sine_over(frequency: f64, t: f64) -> f64 {
    t * sinc(frequency * t)
}

/// (y − sin y)/y³ for |y| ≤ 1, where the difference itself would cancel; 1/6 at 0.
pub(crate) fn cubic_defect(y: f64) -> f64 {
    // 1/3! − y²/5! + y⁴/7! − … + … 1/19!: the first term left out is below 1e-18 of the sum.
    const COEFFICIENTS: [f64; 9] = [
        1.0 / 6.0,
        -1.0 / 120.0,
        1.0 / 5040.0,
        -1.0 / 362_880.0,
        1.0 / 39_916_800.0,
        -1.0 / 6_227_020_800.0,
        1.0 / 1_307_674_368_000.0,
        -1.0 / 355_687_428_096_000.0,
        1.0 / 121_645_100_408_832_000.0,
    ];
    let z = y * y;
    COEFFICIENTS.iter().rev().fold(0.0, |sum, c| sum * z + c)
}

/// Terms added up plainly before they go into a compensated sum: rounding of long sums grows with the square root of this,
/// not of their length, while short ones cost nothing more.
pub(crate) const BLOCK: usize = 64;

/// Σ_k a_k b_k with each of three lists b, in whole groups of four: of no more than [`BLOCK`] terms the same as [`long_sum`] has,
/// side by side.
pub(crate) fn products_in_order(a: &[f64], lists: [&Vec<f64>; 3]) -> [f64; 3] {
    let mut sums = f64x4::ZERO;
    let [x, y, z] = lists.map(|list| list.as_chunks().0);
    for (((a, x), y), z) in a.as_chunks().0.iter().zip(x).zip(y).zip(z) {
        let a = f64x4::from(*a);
        let products = [*x, *y, *z].map(|b| a * f64x4::from(b));
        for terms in f64x4::transpose([products[0], products[1], products[2], f64x4::ZERO]) {
            sums += terms;
        }
    }
    let [first, second, third, _] = sums.to_array();
    [first, second, third]
}

/// Σ term(k) over k < `count`, asked for in this order.
pub(crate) fn long_sum<const N: usize>(count: usize, mut term: impl FnMut(usize) -> [f64; N]) -> [f64; N] {
    let mut block = |from: usize| {
        let mut sum = [0.0; N];
        for k in from..(from + BLOCK).min(count) {
            let term = term(k);
            (0..N).for_each(|i| sum[i] += term[i]);
        }
        sum
    };
    let (mut sum, mut carry) = (block(0), [0.0; N]);
    for from in (BLOCK..count).step_by(BLOCK) {
        let next = block(from);
        for i in 0..N {
            // What the addition drops is kept (Neumaier).
            let total = sum[i] + next[i];
            carry[i] +=
                if sum[i].abs() >= next[i].abs() { (sum[i] - total) + next[i] } else { (next[i] - total) + sum[i] };
            sum[i] = total;
        }
    }
    (0..N).for_each(|i| sum[i] += carry[i]);
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_sums_keep_their_digits() {
        for count in [0, 1, 64, 65, 100_000] {
            let [sum] = long_sum(count, |_| [0.1]);
            assert!((sum - 0.1 * count as f64).abs() <= 16.0 * f64::EPSILON * sum, "{count}: {sum}");
        }
    }

    #[test]
    fn sums_side_by_side_are_those_one_by_one() {
        let number = |i: usize| ((i * 7919 + 13) % 1009) as f64 / 503.0 - 1.0;
        for count in 1..=BLOCK {
            let size = count.next_multiple_of(4);
            let a: Vec<f64> = (0..size).map(|i| if i < count { number(i) } else { 0.0 }).collect();
            let [x, y, z] = [1, 2, 3].map(|j| (0..size).map(|i| number(i + 71 * j)).collect::<Vec<f64>>());
            let one_by_one = long_sum(count, |k| [a[k] * x[k], a[k] * y[k], a[k] * z[k]]);
            assert_eq!(products_in_order(&a, [&x, &y, &z]), one_by_one);
        }
    }

    #[test]
    fn series_meet_the_plain_forms() {
        for x in [1.2e-4_f64, 1.3e-4, 0.3, 1.0, 3.0] {
            assert!((sinc(x) - x.sin() / x).abs() < 1e-15);
        }
        assert_eq!(sinc(0.0), 1.0);
        assert!((cubic_defect(1.0) - (1.0 - 1f64.sin())).abs() < 1e-16);
        assert_eq!(cubic_defect(0.0), 1.0 / 6.0);
    }
}
