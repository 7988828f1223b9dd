//! Sines and cosines of whole parts of a turn in twice the digits.

use crate::simd::twofold::Twofold;

const PI: Twofold = Twofold { high: std::f64::consts::PI, low: 1.224_646_799_147_353_2e-16 };

/// Terms of the series: of an eighth of a turn the next one is below 1e-33.
const TERMS: usize = 14;

/// sin 2πj/4Q for all whole j, each off by at most 16 [`FINE`](crate::simd::twofold::FINE) of itself; those that are 0 or 1 exactly.
#[derive(Debug, Clone)]
pub(crate) struct QuarterWave {
    /// j = 0 … Q
    sines: Vec<Twofold>,
}

impl QuarterWave {
    /// Of turns in `4 * quarter` parts.
    pub(crate) fn new(quarter: usize) -> Self {
        let angle = |part: usize| (PI * Twofold::from(part as f64)).over(2.0 * quarter as f64);
        let sine = |j: usize| if 2 * j <= quarter { sine(angle(j)) } else { cosine(angle(quarter - j)) };
        Self { sines: (0..=quarter).map(sine).collect() }
    }

    /// sin 2πj/4Q
    pub(crate) fn sine(&self, j: u64) -> Twofold {
        let quarter = self.sines.len() as u64 - 1;
        let part = j % (2 * quarter);
        let sine = self.sines[part.min(2 * quarter - part) as usize];
        if (j / (2 * quarter)).is_multiple_of(2) { sine } else { -sine }
    }

    /// cos 2πj/4Q
    pub(crate) fn cosine(&self, j: u64) -> Twofold {
        self.sine(j + self.sines.len() as u64 - 1)
    }
}

/// Up to an eighth of a turn.
fn sine(x: Twofold) -> Twofold {
    x * series(x * x, |k| 2 * k * (2 * k + 1))
}

fn cosine(x: Twofold) -> Twofold {
    series(x * x, |k| 2 * k * (2 * k - 1))
}

/// 1 − s/d₁ (1 − s/d₂ (1 − …))
fn series(square: Twofold, divisor: impl Fn(usize) -> usize) -> Twofold {
    let one = Twofold::from(1.0);
    (1..=TERMS).rev().fold(one, |sum, k| one - (square * sum).over(divisor(k) as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::twofold::FINE;

    /// By mpmath in 50 digits, as two numbers each.
    #[test]
    fn waves_are_right_to_twice_the_digits() {
        let right = [
            (3, 1, 0.5, -3.8893845486632136e-62),
            (3, 2, 0.8660254037844386, 5.0175421109034514e-17),
            (5, 1, 0.30901699437494745, -2.716057601841253e-17),
            (7, 3, 0.6234898018587335, 4.716099920540896e-17),
            (7, 4, 0.7818314824680298, 5.074320362582868e-18),
            (21, 1, 0.07473009358642425, 4.755807367669775e-19),
            (21, 10, 0.6801727377709194, 3.4583009934969234e-17),
            (21, 11, 0.7330518718298263, -1.178748981719997e-17),
            (21, 20, 0.9972037971811801, 1.8875231990455562e-17),
            (21, 50, -0.5633200580636221, 3.670999113159173e-17),
            (1000, 1, 0.0015707956808308787, 1.0497488493572567e-19),
            (1000, 499, 0.7059951885509279, -2.3350583446829568e-17),
            (4001, 1234, 0.4657390175483179, 6.6197136725816924e-18),
            (4001, 2700, 0.872366489058177, 1.435787783410569e-17),
            (100003, 1, 1.5707492042541765e-05, -7.41875115259956e-22),
        ];
        for (quarter, j, high, low) in right {
            let off = (QuarterWave::new(quarter).sine(j) - Twofold { high, low }).value().abs();
            assert!(off <= 16.0 * FINE * high.abs(), "{quarter} {j}: {:e}", off / high.abs() / FINE);
        }
    }

    #[test]
    fn waves_go_on_beyond_a_quarter() {
        for quarter in [1, 2, 3, 10, 21] {
            let wave = QuarterWave::new(quarter);
            assert_eq!((wave.sine(0).value(), wave.cosine(0).value()), (0.0, 1.0));
            for j in 0..9 * quarter as u64 {
                let x = std::f64::consts::FRAC_PI_2 * j as f64 / quarter as f64;
                let (sine, cosine) = (wave.sine(j), wave.cosine(j));
                assert!((sine.value() - x.sin()).abs() < 1e-14 && (cosine.value() - x.cos()).abs() < 1e-14);
                let one = (sine * sine + cosine * cosine - Twofold::from(1.0)).value();
                assert!(one.abs() < 32.0 * FINE, "{quarter} {j} {one:e}");
            }
        }
    }
}
