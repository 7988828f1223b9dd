//! The kernel of a rigid mode: that of an impulse and of a constant pull that balances it, 0 at the impulse.
//!
//! Next to c = 0 each term of [½ − t/T − e^{−ct}/(1−e^{−cT})]/c is as large as 1/c²T: all is written in quotients that are smooth there.

/// Below this h and its like are sums of a series.
const SERIES: f64 = 0.5;

/// Terms of these: 0.5¹⁶/17! is below rounding.
const TERMS: usize = 16;

/// h(x) = (1 − e^{−x})/x
fn h(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x }
}

/// (1 − h(x))/x = 1/2 − x/6 + x²/24 − …
fn fall(x: f64) -> f64 {
    if x.abs() >= SERIES {
        return (1.0 - h(x)) / x;
    }
    // 1/2!, 1/3!, …: each term is the one before times −x/(n + 2).
    let mut term = 0.5;
    let mut sum = 0.0;
    for n in 1..=TERMS {
        sum += term;
        term *= -x / (n + 2) as f64;
    }
    sum
}

/// (h(a) − h(b))/(b − a) = 1/2 − (a + b)/6 + (a² + ab + b²)/24 − …
fn slope(a: f64, b: f64) -> f64 {
    if a.abs().max(b.abs()) >= SERIES {
        return if a == b { 0.0 } else { (h(a) - h(b)) / (b - a) };
    }
    // Σ aⁱbⁿ⁻¹⁻ⁱ, one order after the other, and (−1)ⁿ⁺¹/(n + 1)!.
    let (mut powers, mut power, mut factor, mut sum) = (1.0, 1.0, 0.5, 0.0);
    for n in 1..=TERMS {
        sum += factor * powers;
        power *= a;
        powers = power + b * powers;
        factor /= -((n + 2) as f64);
    }
    sum
}

/// k of a rigid mode whose dashpot is 2δ, and its first three derivatives at 0 ≤ t ≤ T. (Its rows are [φ, 0], its columns [0, φ/κ].)
pub(crate) fn rigid_jet(decay: f64, period: f64, t: f64) -> [f64; 4] {
    let (part, dashpot) = (t / period, 2.0 * decay);
    if dashpot == 0.0 {
        return [0.5 * t * (1.0 - part), 0.5 - part, -period.recip(), 0.0];
    }
    let (a, b) = (dashpot * t, dashpot * period);
    let whole = h(b);
    let place = part * (period - t) * slope(a, b) / whole;
    let speed = (fall(b) - part * h(a)) / whole;
    let falling = -(-a).exp() / (period * whole);
    [place, speed, falling, -dashpot * falling]
}

/// Derivatives by T of a rigid mode's k and its first two derivatives, at −T < t < T: of those at t + T where t is not positive.
pub(super) fn rigid_by_period(decay: f64, period: f64, t: f64) -> [f64; 3] {
    let (part, dashpot) = (t / period, 2.0 * decay);
    if dashpot == 0.0 {
        return [0.5 * part * part, part / period, (period * period).recip()];
    }
    let left = (-dashpot * period).exp_m1();
    let (whole, dying) = ((-dashpot * period).exp() / (left * left), (-dashpot * (t + period)).exp() / (left * left));
    let pull = (dashpot * period).recip();
    [pull * part + dying - whole, pull / period - dashpot * dying, dashpot * dashpot * dying]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// c of 1e-9 and less, where the kernel is that without a dashpot and what first order adds; large c, by the formula with its terms; differences
    /// by t, and by T with t and with t − T held.
    #[test]
    fn kernels_of_rigid_modes_are_smooth_where_their_dashpots_vanish() {
        let mut checked = 0;
        for dashpot in [1e-14, 1e-9, 1e-4, 0.03, 0.19, 0.3, 2.0, -1e-9, -0.02, -0.4] {
            let (own, period) = (0.5 * dashpot, 2.6);
            for part in [0.0, 1e-3, 0.3, 0.77, 1.0] {
                let t = part * period;
                let jet = rigid_jet(own, period, t);
                let [place, speed, ..] = rigid_jet(0.0, period, t);
                // c(T − t)(T − 2t)t/12T, by hand.
                let first = dashpot * (period - t) * (period - 2.0 * t) * t / (12.0 * period);
                let size = dashpot * dashpot;
                assert!((jet[0] - place - first).abs() < 2e-15 + size, "{dashpot} {part}: {jet:?}");
                assert!((jet[1] - speed).abs() < 2e-15 + 2.0 * dashpot.abs(), "{dashpot} {part}: {jet:?}");
                if dashpot > 0.02 {
                    let dying = (-dashpot * t).exp() / -(-dashpot * period).exp_m1();
                    let at_once = 0.5 - 1.0 / -(-dashpot * period).exp_m1();
                    let plain = (0.5 - part - dying - at_once) / dashpot;
                    assert!((jet[0] - plain).abs() < 1e-14 / dashpot.powi(2), "{dashpot} {part}: {jet:?} {plain}");
                }
                let step = 1e-4;
                if (step..period - step).contains(&t) {
                    let [before, after] = [-step, step].map(|by| rigid_jet(own, period, t + by));
                    for order in 0..3 {
                        let rise = (after[order] - before[order]) / (2.0 * step);
                        assert!((rise - jet[order + 1]).abs() < 1e-7, "{dashpot} {part} {order}: {rise} {jet:?}");
                    }
                }
                let [shorter, longer] = [-step, step].map(|by| rigid_jet(own, period + by, t));
                let [earlier, later] = [-step, step].map(|by| rigid_jet(own, period + by, t + by));
                for (told, [low, high]) in [
                    (rigid_by_period(own, period, t), [shorter, longer]),
                    (rigid_by_period(own, period, t - period), [earlier, later]),
                ] {
                    for order in 0..3 {
                        let rise = (high[order] - low[order]) / (2.0 * step);
                        let rounding = 1e-7 + 1e-15 / size;
                        assert!((rise - told[order]).abs() < rounding, "{dashpot} {part} {order}: {rise} {told:?}");
                        checked += 1;
                    }
                }
            }
        }
        assert_eq!(checked, 300);
    }
}
