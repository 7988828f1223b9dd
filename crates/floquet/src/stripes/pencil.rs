//! Two modes that meet, reduced to a pencil of two by two: the local model of a stripe.
//!
//! ```text
//! det(N + xN′ + …) = 0,    N, N′ real and symmetric, x an angle on the circle.
//! ```
//!
//! If N′ is definite both x are real whatever N is: two modes of one signature pass. If not there are two directions n₁ and n₂ on which
//! n·N′n = 0, and with α = n₁·Nn₁, β = n₁·Nn₂, γ = n₂·Nn₂, m = n₁·N′n₂
//!
//! ```text
//! det(N + xN′) ∝ αγ − (β + mx)²,    x = (−β ± √(αγ))/m:
//! ```
//!
//! off the circle where α and γ differ in sign. So a stripe ends where α = 0 and where γ = 0, at β = 0: there x = 0 is a double root, of
//! N + xN′ + … as well. Both are smooth functions that change sign, and their zeros are known as well as N is, however close they are;
//! of the double root itself half the digits would be lost. Changes of basis scale α and γ by positive numbers.

/// N and its slope N′: entries 11, 12, 22.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pencil {
    pub(super) value: [f64; 3],
    pub(super) slope: [f64; 3],
}

/// α, β and γ, each over m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Meeting {
    pub(super) alpha: f64,
    pub(super) beta: f64,
    pub(super) gamma: f64,
}

type Direction = [f64; 2];

fn bilinear([a, b, c]: [f64; 3], u: Direction, v: Direction) -> f64 {
    a * u[0] * v[0] + b * (u[0] * v[1] + u[1] * v[0]) + c * u[1] * v[1]
}

impl Pencil {
    /// `None` for modes of one signature.
    pub(super) fn meeting(&self) -> Option<Meeting> {
        let [p, q, r] = self.slope;
        let root = (q * q - p * r).sqrt();
        if root.is_nan() || root == 0.0 {
            return None;
        }
        // p x² + 2q xy + r y² = 0, without a difference of near numbers.
        let t = q + root.copysign(q);
        let unit = |[x, y]: Direction| [x / x.hypot(y), y / x.hypot(y)];
        let (mut one, mut other) = (unit([-t, p]), unit([-r, t]));
        let mut m = bilinear(self.slope, one, other);
        if m < 0.0 {
            (other, m) = ([-other[0], -other[1]], -m);
        }
        // Which is which must not change from one point to the next.
        if one[0] * other[1] - one[1] * other[0] < 0.0 {
            (one, other) = (other, one);
        }
        let [alpha, beta, gamma] =
            [(one, one), (one, other), (other, other)].map(|(u, v)| bilinear(self.value, u, v) / m);
        (alpha.is_finite() && beta.is_finite() && gamma.is_finite()).then_some(Meeting { alpha, beta, gamma })
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_testkit::Random;

    use super::*;

    #[test]
    fn roots_and_their_kind_are_those_of_the_determinant() {
        let mut random = Random(1);
        let (mut off, mut on, mut passing) = (0, 0, 0);
        for _ in 0..2000 {
            let [value, slope] = [(), ()].map(|()| [(), (), ()].map(|()| random.between(-1.0, 1.0)));
            // a x² + b x + c
            let a = slope[0] * slope[2] - slope[1] * slope[1];
            let b = value[0] * slope[2] + slope[0] * value[2] - 2.0 * value[1] * slope[1];
            let c = value[0] * value[2] - value[1] * value[1];
            let square = (b * b - 4.0 * a * c) / (4.0 * a * a);
            match (Pencil { value, slope }).meeting() {
                Some(Meeting { alpha, beta, gamma }) => {
                    let scale = 1.0 + b.abs() / a.abs() + square.abs();
                    assert!((-beta + b / (2.0 * a)).abs() < 1e-10 * scale, "{value:?} {slope:?}");
                    assert!((alpha * gamma - square).abs() < 1e-10 * scale, "{value:?} {slope:?}");
                    *(if square < 0.0 { &mut off } else { &mut on }) += 1;
                }
                None => {
                    assert!(a > 0.0 && square >= 0.0);
                    passing += 1;
                }
            }
        }
        assert!(off > 300 && on > 300 && passing > 300, "{off} {on} {passing}");
    }

    #[test]
    fn which_edge_is_which_does_not_change_on_the_way() {
        // Round a circle of slopes, all indefinite.
        let value = [0.3, 0.2, -0.5];
        let mut last: Option<Meeting> = None;
        for i in 0..=2000 {
            let (sin, cos) = (f64::from(i) * 1e-3 * std::f64::consts::TAU).sin_cos();
            let here = Pencil { value, slope: [0.4 + cos, sin, 0.4 - cos] }.meeting().unwrap();
            if let Some(last) = last {
                assert!((here.alpha - last.alpha).abs() < 0.02 && (here.gamma - last.gamma).abs() < 0.02, "{i}");
            }
            last = Some(here);
        }
    }
}
