//! Free flight of one mode.

use crate::real::Real;

/// R(τ) = [[cos, sin/Ω], [−Ω sin, cos]] of one mode.
#[derive(Debug, Clone)]
pub(crate) struct Flight {
    pub(crate) cos: Real,
    pub(crate) sin_over: Real,
    pub(crate) sin_times: Real,
}

impl Flight {
    pub(crate) fn new(frequency: &Real, time: &Real) -> Self {
        if frequency.is_zero() {
            let (one, zero) = (Real::one(time.bits()), Real::zero(time.bits()));
            return Self { cos: one, sin_over: time.clone(), sin_times: zero };
        }
        let (sin, cos) = (frequency * time).sin_cos();
        Self { cos, sin_over: &sin / frequency, sin_times: sin * frequency }
    }
}
