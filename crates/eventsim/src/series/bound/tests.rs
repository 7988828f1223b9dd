//! Bounds of series over a window.

use super::*;
use crate::series::tests::{empty, filled};
use crate::series::weights::Weights;

/// Each of eight masses stays within its bounds, and above and below its parabolas; where no term turns back it reaches them.
#[test]
fn bounds_of_eight_masses_enclose_their_motions() {
    let (order, end) = (14, 1.3);
    let (signed, mut positive) = (filled(21, order), filled(21, order));
    positive.data.iter_mut().for_each(|d| *d = d.abs());
    for (rows, no_turn) in [(signed, false), (positive, true)] {
        let Group { rise, fall, bend_up, bend_down } = group(&rows, 9, order + 1, 0.0, &fractions(end));
        let [rise, fall, bend_up, bend_down] = [rise, fall, bend_up, bend_down].map(f64x8::to_array);
        for i in 0..LANES {
            let mut weights = Weights::zero();
            let mut at = |s: f64| {
                weights.plain(s, order, &crate::units::inverse_factorials());
                let x = rows.at(9 + i, 0.0, &weights, None).0;
                (x, 2.0 * (x - s * rows.get(1, 9 + i)) / (s * s))
            };
            for s in (1..=200).map(|j| end * f64::from(j) / 200.0) {
                let (x, bend) = at(s);
                assert!(fall[i] <= x && x <= rise[i], "column {i} at {s}");
                // (Rounding of x over the square of a short time.)
                let rounding = 1e-14 / (s * s);
                assert!(bend_down[i] - rounding <= bend && bend <= bend_up[i] + rounding, "column {i} at {s}");
            }
            let (x, bend) = at(end);
            if no_turn {
                assert!((rise[i] - x).abs() < 1e-12 && (bend_up[i] - bend).abs() < 1e-12 && fall[i] == 0.0);
            }
        }
    }
}

#[test]
fn bounds_enclose_and_touch_where_no_term_turns_back() {
    let c = [0.3, -0.2, 0.5, -0.1, 0.05];
    let (up, down) = polynomial(&c, 0.8);
    for i in 0..=1000 {
        let s = 0.8 * f64::from(i) / 1000.0;
        let value = c.iter().rev().fold(0.0, |p, c| p * s + c);
        assert!(down <= value && value <= up);
    }
    let (up, down) = polynomial(&[1.0, 1.0, 1.0], 2.0);
    assert!((up - 7.0).abs() < 1e-12 && (down - 1.0).abs() < 1e-12);
}

/// Derivatives that grow as fast as the fastest rate and the force let them, all of one sign: the bound of p₆ is above their sum, and within a
/// tenth of it on short windows.
#[test]
fn the_tail_of_a_ring_is_above_all_that_can_come() {
    let mut seed = 5;
    let mut near = 0;
    for (rate, amplitude) in [(1.55, 0.0), (1.5, 0.3), (1.55, 8.0), (1.5, 2.5e-4), (1.8, 200.0)] {
        let growth = Growth { rate, forced: 0.5 * amplitude };
        for part in [0.05, 0.3, 0.9, 2.0] {
            let horizon = part / rate;
            let (sites, column) = (19, 1 + (seed % 17) as usize);
            let mut rows = empty(sites);
            let at = |k: usize| k * rows.stride + column + 1;
            let (sixth, seventh) = (at(TAIL), at(TAIL + 1));
            rows.data[sixth] = crate::units::spread(&mut seed);
            rows.data[seventh] = -rows.data[sixth] * rate;
            let tail = tail(&rows, sites, growth, horizon);
            // p_J = Σ d_{J+j} J!/(J+j)! s^j with |d_{k+2}| ≤ r²|d_k| + A r^k.
            let mut d = [rows.data[sixth].abs(), rows.data[seventh].abs()];
            let (mut sum, mut part) = (0.0, 1.0);
            for j in 0..200 {
                let k = TAIL + j;
                sum += part * d[j % 2];
                d[j % 2] = rate.powi(2) * d[j % 2] + amplitude * rate.powi(k as i32);
                part *= horizon / (k + 1) as f64;
            }
            assert!(tail >= sum, "{rate} {amplitude} {horizon}: {tail} {sum}");
            near += usize::from(tail < 1.1 * sum);
            // The other end is looked at as well as the first.
            let mut last = empty(sites);
            let place = TAIL * last.stride + sites;
            last.data[place] = rows.data[sixth].abs();
            let of_last = super::tail(&last, sites, growth, horizon);
            assert!(of_last >= rows.data[sixth].abs() && of_last <= tail);
        }
    }
    assert!(near >= 8, "{near}");
}
