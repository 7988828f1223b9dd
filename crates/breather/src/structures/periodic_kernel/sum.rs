//! What a regular mode adds up to over all periods, and how well that is known.

use vibrochain_lattice::{LinearMode, ModeFlow, Turn, Turned};

/// From 1 − R = 1e-3 on the error of (1−R)⁻¹ is kept apart from that of terms: it is the same in all of them, as if the frequency of the mode
/// were another one, and an orbit next to a resonance feels it far less than errors of its terms one by one.
const NEAR: f64 = 1e-3;

/// The unit that errors of sums over modes are counted in: each term is a product of four rounded numbers.
pub(in crate::structures) const UNIT: f64 = 4.0 * f64::EPSILON;

/// What a regular mode adds up to over all periods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::structures) struct Sum {
    /// (1−R)⁻¹
    pub(in crate::structures) sum: Turned,
    /// How much its errors are larger than the unit of rounding: next to a resonance, and where the mode's own poles are known worse.
    pub(super) steep: f64,
    /// How much errors of terms are larger than rounding: by this sum's own, or next to a resonance by those of the mode's flight alone.
    pub(in crate::structures) blur: f64,
    /// The length of its generator, κ or more.
    pub(in crate::structures) fast: f64,
}

/// K and its first three derivatives; and the sizes of their terms, with what next to a resonance, and by errors of the modes, is lost on them:
/// [`UNIT`] of it bounds the error.
pub(in crate::structures) type Jet = ([f64; 4], [f64; 4]);

impl Sum {
    /// `None` of a rigid mode.
    pub(super) fn of(mode: &LinearMode, period: f64) -> Option<Self> {
        if mode.is_rigid() {
            return None;
        }
        let (sum, square) = inverse(mode.flow(), period);
        let size = (mode.errors.poles / f64::EPSILON).max(mode.decay.abs() + mode.rate) * period;
        let away = square.abs().sqrt();
        let fast = length([mode.decay, mode.rate]);
        if away >= NEAR {
            return Some(Self { sum, steep: size / away, blur: size / away, fast });
        }
        // The poles are off, and beside them T = 2πn/ω and its product with them are rounded, four times in all.
        let turned = (mode.errors.poles / f64::EPSILON + 2.0 * (mode.decay.abs() + mode.rate)) * period;
        Some(Self { sum, steep: turned / away, blur: size, fast })
    }
}

/// The length of two numbers: `hypot`, which takes ten times as long, only where squares leave the range.
pub(crate) fn length([x, y]: [f64; 2]) -> f64 {
    let square = x * x + y * y;
    if square > 1e-280 && square < 1e280 { square.sqrt() } else { x.hypot(y) }
}

/// (1−R)⁻¹ of a mode that is not rigid, and the square of the length of 1 − R.
pub(crate) fn inverse(flow: ModeFlow, period: f64) -> (Turned, f64) {
    let one_less = one_less(flow, period);
    let square = match flow.turn {
        Turn::Circular => one_less.even * one_less.even + one_less.odd * one_less.odd,
        // By the two poles.
        Turn::Hyperbolic => (one_less.even + one_less.odd) * (one_less.even - one_less.odd),
        Turn::Parabolic => one_less.even * one_less.even,
    };
    // 1 − R = a − bJ has the inverse (a + bJ)/(a² + σb²); `odd` holds −b.
    (Turned { even: one_less.even / square, odd: -one_less.odd / square }, square)
}

/// 1 − e^{AT} as a + bJ, without cancellation next to a resonance.
pub(in crate::structures) fn one_less(flow: ModeFlow, period: f64) -> Turned {
    let (decay, angle) = (-flow.decay * period, flow.rate * period);
    match flow.turn {
        Turn::Circular => {
            let half = (0.5 * angle).sin();
            if decay == 0.0 {
                return Turned { even: 2.0 * half * half, odd: -angle.sin() };
            }
            Turned { even: 2.0 * half * half - decay.exp_m1() * angle.cos(), odd: -decay.exp() * angle.sin() }
        }
        Turn::Hyperbolic => {
            let [slow, fast] = [decay + angle, decay - angle].map(|x| -x.exp_m1());
            Turned { even: 0.5 * (slow + fast), odd: 0.5 * (slow - fast) }
        }
        Turn::Parabolic => Turned { even: -decay.exp_m1(), odd: -decay.exp() * angle },
    }
}
