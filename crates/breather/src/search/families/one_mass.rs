//! Two impacts a period of a mass without coupling, by its flights: `two_impacts` without the kernels, which next to a resonance are
//! large and cancel.
//!
//! About the middles of the flights between the impacts (A, half as long as h_A = φ/2) and after them (B, h_B = (T−φ)/2) the motion
//! is even and odd parts of a free swing and of what the force C cos ωt − S sin ωt adds, σ = −1 turning round for B in an orbit of
//! one period of the force. With c, s = cos, sin Ωh and the Wronskians
//!
//! ```text
//! V = ∫₀ʰ cos Ωt cos ωt dt,   W = −∫₀ʰ sin Ωt sin ωt dt,        2V = P + Q,  2W = Q − P,  P, Q = sin((Ω∓ω)h)/(Ω∓ω)
//! F₁ = W_A s_B + σ s_A W_B    F₂ = V_A c_B + σ c_A V_B    F₃ = σ c_A V_B − V_A c_B    F₄ = σ s_A W_B − W_A s_B
//! ```
//!
//! positions b̄ = (b₁+b₂)/2, b̃ = (b₂−b₁)/2 and Newton's law give two linear equations for C and S: C = x/Δ, S = y/Δ,
//!
//! ```text
//! Δ = q²F₂F₄ − F₁F₃
//! x = Ω [b̄ (q²F₄ sin y + F₁ sin Ωδ) + 2q b̃ c_A c_B Z]         Z = W_A c_B − W_B c_A   (b̃ = 0 for two impacts on one barrier)
//! y = Ω [b̃ (q²F₂ sin y − F₃ sin Ωδ) − 2q b̄ s_A s_B Z']         Z' = V_A s_B − σ s_A V_B
//! ```
//!
//! and what is left is x² + y² = A²Δ². Every factor is a sum or difference over A and B, a plain wave in δ with its digits kept at δ = 0.

use vibrochain_lattice::simd::lanes::{LANES, Lane};
use vibrochain_lattice::{Model, sine_over};

use crate::roots::dual::{Algebra, Dual};
use crate::roots::interval::{Clearance, Enclosed, Zeros, one_by_one};
use crate::search::families::pattern::Pattern;

/// One parameter point.
pub(crate) struct OneMass {
    pattern: Pattern,
    rate: f64,
    omega: f64,
    period: f64,
    /// b̄ and b̃.
    mean: f64,
    half_gap: f64,
    loss: f64,
    amplitude: f64,
}

/// The sum over A and B of a function of h, and its difference.
#[derive(Clone, Copy)]
struct Both<T> {
    sum: T,
    difference: T,
}

impl OneMass {
    /// `None` with coupling, under several harmonics or without springs.
    pub(crate) fn new(pattern: Pattern, model: &Model) -> Option<Self> {
        let (chain, amplitude) = (model.chain(), model.force().cosine_amplitude()?);
        if !chain.is_uncoupled() || chain.gamma1() == 0.0 {
            return None;
        }
        let alike = pattern.is_alike();
        Some(Self {
            pattern,
            rate: chain.gamma1().sqrt(),
            omega: model.omega(),
            period: model.period() * f64::from(pattern.periods()),
            mean: if alike { pattern.stop(model) } else { model.asymmetry() },
            half_gap: if alike { 0.0 } else { -1.0 },
            loss: model.loss(),
            amplitude,
        })
    }

    /// All zeros on `from` … `to`, in δ.
    pub(crate) fn zeros(&self, zeros: &mut Zeros, from: f64, to: f64) {
        let pieces = 8 + ((to - from) * self.rate.max(self.omega)) as usize;
        let half = 0.5 * self.period;
        zeros.find(self, from, to, pieces.min(4096), |delta| 64.0 * f64::EPSILON * delta.abs().max(1e-20 * half));
    }

    /// θ at a zero δ.
    pub(crate) fn phase(&self, delta: f64) -> f64 {
        let [x, y, determinant] = self.cramer(|cos, sin, rate| Dual { function: cos, derivative: -rate * sin }, delta);
        let scale = determinant.function.signum();
        (y.function * scale).atan2(x.function * scale)
    }

    /// (x, y, Δ) at δ, each wave given by its value, −slope/rate and rate.
    fn cramer<T: Algebra>(&self, wave: impl Fn(f64, f64, f64) -> T, delta: f64) -> [T; 3] {
        let (quarter, q) = (0.25 * self.period, self.loss);
        // sin(rh)/scale at h = T/4 ± δ/2, its sum and difference; cos likewise.
        let sine = |rate: f64, over: f64| {
            let ((s, c), (sin, cos)) = ((rate * quarter).sin_cos(), (0.5 * rate * delta).sin_cos());
            let (s, c) = (2.0 * s * over, 2.0 * c * over);
            Both { sum: wave(s * cos, s * sin, 0.5 * rate), difference: wave(c * sin, -c * cos, 0.5 * rate) }
        };
        let fast = self.rate + self.omega;
        let slow = self.rate - self.omega;
        let s = sine(self.rate, 1.0);
        let c = {
            let ((s, c), (sin, cos)) = ((self.rate * quarter).sin_cos(), (0.5 * self.rate * delta).sin_cos());
            let (s, c) = (2.0 * s, 2.0 * c);
            let rate = 0.5 * self.rate;
            Both { sum: wave(c * cos, c * sin, rate), difference: wave(-s * sin, s * cos, rate) }
        };
        let q_part = sine(fast, 1.0 / fast);
        // sin(dh)/d stays smooth at d = 0.
        let p_part = {
            let (sin, cos) = (0.5 * slow * delta).sin_cos();
            let (at, there) = (2.0 * sine_over(slow, quarter), 2.0 * (slow * quarter).cos());
            let (rate, over) = (0.5 * slow, 0.5 * sine_over(0.5 * slow, delta));
            // The slope there·cos(rate δ)/2 over −rate, whose wave it is.
            let steep = if rate == 0.0 { 0.0 } else { -there * 0.5 * cos / rate };
            Both { sum: wave(at * cos, at * sin, rate), difference: wave(there * over, steep, rate) }
        };
        let half = |a: Both<T>, b: Both<T>, sign: f64| Both {
            sum: (a.sum.scaled(0.5)) + b.sum.scaled(0.5 * sign),
            difference: a.difference.scaled(0.5) + b.difference.scaled(0.5 * sign),
        };
        let (v, w) = (half(q_part, p_part, 1.0), half(q_part, p_part, -1.0));
        // u_A w_B + u_B w_A and u_A w_B − u_B w_A.
        let even = |u: Both<T>, w: Both<T>| (u.sum * w.sum - u.difference * w.difference).scaled(0.5);
        let odd = |u: Both<T>, w: Both<T>| (u.difference * w.sum - u.sum * w.difference).scaled(0.5);
        let turns_round = self.pattern.turns_round();
        let (f1, f4, f2, f3) = if turns_round {
            (odd(w, s), even(w, s).scaled(-1.0), odd(v, c), even(v, c).scaled(-1.0))
        } else {
            (even(w, s), odd(w, s).scaled(-1.0), even(v, c), odd(v, c).scaled(-1.0))
        };
        let sin_y = (self.rate * 0.5 * self.period).sin();
        let (sin, cos) = (self.rate * delta).sin_cos();
        let sin_d = wave(sin, -cos, self.rate);
        let cosines = (c.sum * c.sum - c.difference * c.difference).scaled(0.25);
        let sines = (s.sum * s.sum - s.difference * s.difference).scaled(0.25);
        let z_other = if turns_round { even(v, s) } else { odd(v, s) };
        let mut x = (f4.scaled(q * q * sin_y) + f1 * sin_d).scaled(self.rate * self.mean);
        let mut y = (sines * z_other).scaled(-2.0 * q * self.mean * self.rate);
        if !self.pattern.is_alike() {
            x = x + (cosines * odd(w, c)).scaled(2.0 * q * self.half_gap * self.rate);
            y = y + (f2.scaled(q * q * sin_y) - f3 * sin_d).scaled(self.half_gap * self.rate);
        }
        [x, y, (f2 * f4).scaled(q * q) - f1 * f3]
    }

    fn condition<T: Algebra>(&self, [x, y, determinant]: [T; 3]) -> T {
        let scaled = determinant.scaled(self.amplitude);
        x * x + y * y - scaled * scaled
    }
}

impl Enclosed for OneMass {
    fn clearances(&self, deltas: Lane, radii: Lane) -> [Clearance; LANES] {
        one_by_one(deltas, radii, |delta, radius| self.enclose(delta, radius))
    }

    fn at(&self, delta: f64) -> (f64, f64) {
        self.enclose(delta, 0.0).at_centre()
    }
}

impl OneMass {
    fn enclose(&self, delta: f64, radius: f64) -> Dual {
        self.condition(self.cramer(|cos, sin, rate| Dual::wave(cos, sin, rate, cos.hypot(sin), radius), delta))
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::Point;

    use super::*;

    /// What an interval is told to be holds at its points, whatever the sizes of the waves.
    #[test]
    fn models_of_intervals_contain_the_condition_at_points() {
        let mut checked = 0;
        for (omega, gamma1) in [(0.7, 1.0), (1.9, 0.2), (1.0, 0.9), (2.0, 9.0)] {
            for pattern in [Pattern::DOUBLE_SIDED, Pattern::DOUBLED] {
                let ring = Point::ring(1).gamma1(gamma1).gamma2(0.0);
                let model = ring.omega(omega).asymmetry(0.3).amplitude(0.2).restitution(0.8).model().unwrap();
                let problem = OneMass::new(pattern, &model).unwrap();
                for part in [-0.8, -0.1, 0.37, 0.6] {
                    let (centre, radius) = (0.5 * part * problem.period, 0.02 * problem.period);
                    let around = problem.enclose(centre, radius);
                    for i in -20..=20 {
                        let x = f64::from(i) / 20.0 * radius;
                        let at = problem.at(centre + x);
                        for (told, at) in [(around.function, at.0), (around.derivative, at.1)] {
                            let away = (at - told.value - told.slope[0] * x).abs();
                            assert!(away <= told.rest * (1.0 + 1e-9), "{omega} {part} {x}: {away:e} {told:?}");
                        }
                        checked += 1;
                    }
                }
            }
        }
        assert_eq!(checked, 4 * 2 * 4 * 41);
    }
}
