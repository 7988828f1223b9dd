//! How far a uniform force cos wt swings a mass between walls where dashpots act: as without them, with γ₁ + icw and γ₂ + ic₂w for γ₁ and γ₂,
//!
//! ```text
//! g_n(w) = λ q_{n+1} q_{M−n} / ((1 + λ^(M+1)) (γ₂ + ic₂w)),   q_j = (1 − λ^j)/(1 − λ)
//! ```
//!
//! with the |λ| ≤ 1 for which (γ₂ + ic₂w)(λ + 1/λ − 2) = γ₁ + icw − w². Products, in which nothing cancels.

use rustfft::num_complex::Complex;

use crate::model::chain::Chain;

type C = Complex<f64>;

/// γ₁ + icw − w², with one rounding of the square: what a harmonic has against it where all masses move alike.
pub(crate) fn stiffness(gamma1: f64, damping: f64, w: f64) -> C {
    C::new((-w).mul_add(w, gamma1), damping * w)
}

/// A wave along the rows.
struct Wave {
    /// −ln λ, its real part not below 0.
    fall: C,
    /// γ₂ + ic₂w
    coupling: C,
}

impl Wave {
    /// `None` of masses without coupling.
    fn of(chain: &Chain, [damping, coupling_damping]: [f64; 2], w: f64) -> Option<Self> {
        let coupling = C::new(chain.gamma2(), coupling_damping * w);
        // 2 cosh μ − 2 = (2 sinh ½μ)², in which a small one keeps its digits.
        let half = (stiffness(chain.gamma1(), damping, w) / coupling).sqrt() * 0.5;
        let fall = half.asinh() * 2.0;
        (coupling != C::default()).then_some(Self { fall: if fall.re < 0.0 { -fall } else { fall }, coupling })
    }

    /// 1 − λ^j
    fn less(&self, j: usize) -> C {
        let whole = self.fall * j as f64;
        // 1 − e^{−x} = 2 e^{−x/2} sinh ½x, but for what overflows.
        if whole.re > 1.0 {
            C::new(1.0, 0.0) - (-whole).exp()
        } else {
            (whole * 0.5).sinh() * (-whole * 0.5).exp() * 2.0
        }
    }

    /// q_j
    fn part(&self, j: usize) -> C {
        let one = self.less(1);
        if one == C::default() { C::new(j as f64, 0.0) } else { self.less(j) / one }
    }

    /// λ/((1 + λ^(M+1))(γ₂ + ic₂w))
    fn scale(&self, masses: usize) -> C {
        (-self.fall).exp() / (((-self.fall * (masses + 1) as f64).exp() + 1.0) * self.coupling)
    }
}

/// g_n(w).
pub(crate) fn held(chain: &Chain, dashpots: [f64; 2], w: f64, n: usize) -> C {
    match Wave::of(chain, dashpots, w) {
        None => stiffness(chain.gamma1(), dashpots[0], w).inv(),
        Some(wave) => wave.scale(chain.length()) * wave.part(n + 1) * wave.part(chain.length() - n),
    }
}

/// A bound of |g_n(w)| at all n.
pub(crate) fn held_at_most(chain: &Chain, dashpots: [f64; 2], w: f64) -> f64 {
    let Some(wave) = Wave::of(chain, dashpots, w) else {
        return stiffness(chain.gamma1(), dashpots[0], w).norm().recip();
    };
    // q_j is a sum of j terms of at most 1, and has at most 2 above |1 − λ|.
    let middle = 0.5 * (chain.length() + 1) as f64;
    wave.scale(chain.length()).norm() * middle.min(2.0 / wave.less(1).norm()).powi(2)
}
