//! One point of the parameter space, validated: a value is always in range, nothing downstream checks again.

use crate::error::{ParameterError, RESONANCE_TOLERANCE, Resonance};
use crate::kernel::damped_steady::stiffness;
use crate::model::chain::{Barrier, Chain};
use crate::model::force::{Force, Wave};
use crate::model::parameter::Parameter;

/// A chain with its barriers, its force and its law of impact: one point of the parameter space.
///
/// Without force (`amplitude` = 0) and with elastic impacts (`restitution` = 1) it is conservative; `omega`
/// is then the frequency of the orbit that is asked for. A model with a force or losses is made from a [`Point`](crate::Point), with each
/// value by its name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    pub(super) chain: Chain,
    pub(super) omega: f64,
    pub(super) asymmetry: f64,
    pub(super) force: Force,
    pub(super) restitution: f64,
    /// c and c₂.
    pub(super) dashpots: [f64; 2],
}

impl Model {
    /// A conservative model: no force, elastic impacts, orbits of frequency `omega`.
    ///
    /// # Errors
    /// A [`ParameterError`] unless 1e-100 ≤ ω ≤ 1e100 and 0 ≤ a < 1.
    pub fn conservative(chain: Chain, omega: f64, asymmetry: f64) -> Result<Self, ParameterError> {
        chain.point().omega(omega).asymmetry(asymmetry).model()
    }

    /// The linear lattice.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Frequency ω of the force (and of a map).
    pub fn omega(&self) -> f64 {
        self.omega
    }

    /// Changes the frequency alone, as along a row of a map; see [`Model::with`] for any parameter.
    ///
    /// # Errors
    /// A [`ParameterError`] unless 1e-100 ≤ ω ≤ 1e100; the model stays as it was.
    pub fn set_omega(&mut self, omega: f64) -> Result<(), ParameterError> {
        Parameter::Omega.check(omega)?;
        self.omega = omega;
        Ok(())
    }

    /// Period T = 2π/ω of the force.
    pub fn period(&self) -> f64 {
        std::f64::consts::TAU / self.omega
    }

    /// Centre a of the gap.
    pub fn asymmetry(&self) -> f64 {
        self.asymmetry
    }

    /// Amplitude A of the force; of a force of several harmonics Σ|A_j|, which it never exceeds.
    pub fn amplitude(&self) -> f64 {
        self.force.amplitude()
    }

    /// The force.
    pub fn force(&self) -> &Force {
        &self.force
    }

    /// The force as a function of the time t + ψ.
    #[inline]
    pub fn force_wave(&self) -> Wave {
        Wave::new(&self.force, self.omega, |_, _| Ok::<_, std::convert::Infallible>(1.0)).unwrap_or_default()
    }

    /// Coefficient e of restitution.
    pub fn restitution(&self) -> f64 {
        self.restitution
    }

    /// q = (1−e)/(1+e): the part of an impact's momentum that Newton's law loses.
    pub fn loss(&self) -> f64 {
        (1.0 - self.restitution) / (1.0 + self.restitution)
    }

    /// Springs γ₁, γ₂ and γ₃.
    pub fn springs(&self) -> [f64; 3] {
        [self.chain.gamma1(), self.chain.gamma2(), self.chain.gamma3()]
    }

    /// Dashpots c between each mass and the ground, and c₂ in each spring along the rows.
    pub fn dashpots(&self) -> [f64; 2] {
        self.dashpots
    }

    /// Whether it has dashpots.
    #[inline]
    pub fn is_damped(&self) -> bool {
        self.dashpots != [0.0; 2]
    }

    /// Neither its impacts nor dashpots lose or add anything.
    #[inline]
    pub fn is_lossless(&self) -> bool {
        self.restitution == 1.0 && !self.is_damped()
    }

    /// No force, elastic impacts and no dashpots.
    #[inline]
    pub fn is_conservative(&self) -> bool {
        self.amplitude() == 0.0 && self.is_lossless()
    }

    /// Position of a barrier.
    pub fn barrier(&self, barrier: Barrier) -> f64 {
        barrier.position(self.asymmetry)
    }

    /// Σ A_j/(γ₁ − j²ω²) cos(jω(t+ψ) + θ_j): the uniform motion that the force drives without impacts and walls, as a function of the
    /// time t + ψ (paper, sec. II B; of the plain cosine Ã cos ω(t+ψ)). With dashpots γ₁ + ijωc stands for γ₁: it is smaller, and late.
    ///
    /// # Errors
    /// [`Resonance`] when a harmonic meets the uniform mode, Ω₀ = √γ₁.
    pub fn steady_response(&self) -> Result<Wave, Resonance> {
        let (gamma1, omega) = (self.chain.gamma1(), self.omega);
        if self.amplitude() == 0.0 {
            return Ok(self.force_wave());
        }
        if self.dashpots[0] != 0.0 {
            return Ok(self.force_wave().turned(|term| stiffness(gamma1, self.dashpots[0], term.rate).inv()));
        }
        Wave::new(&self.force, omega, |harmonic, rate| {
            // One rounding only: the difference is what resonance hangs on.
            let stiffness = (-rate).mul_add(rate, gamma1);
            if stiffness.abs() <= 2.0 * RESONANCE_TOLERANCE * rate * rate {
                let frequency = gamma1.sqrt();
                let harmonic = u64::from(harmonic);
                return Err(Resonance { harmonic, mode: 0, frequency, omega, distance: frequency - rate });
            }
            Ok(stiffness)
        })
    }

    /// Ã = A/(γ₁ − ω²), the amplitude of [`Model::steady_response`] to a plain cosine; of any other force
    /// Σ|A_j/(γ₁ − j²ω²)|, which that motion never exceeds.
    ///
    /// # Errors
    /// As [`Model::steady_response`].
    pub fn force_response(&self) -> Result<f64, Resonance> {
        Ok(self.steady_response()?.reach())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_closed_where_they_should_be() {
        assert!(Chain::new(1, 0.0, 1e-300).is_ok());
        for (sites, g1, g2) in
            [(0, 1., 1.), (1, -1., 1.), (1, 1., -1.), (2, 0., 0.), (2, f64::NAN, 1.), (2, 1., f64::INFINITY)]
        {
            assert!(Chain::new(sites, g1, g2).is_err(), "{sites} {g1} {g2}");
        }
        let chain = Chain::new(3, 1.0, 0.0).unwrap();
        for (w, a, f, e) in [
            (0., 0., 0., 1.),
            (1., 1., 0., 1.),
            (1., -0.1, 0., 1.),
            (1., 0., -1., 1.),
            (1., 0., 0., 0.),
            (1., 0., 0., 1.1),
        ] {
            assert!(
                chain.point().omega(w).asymmetry(a).amplitude(f).restitution(e).model().is_err(),
                "{w} {a} {f} {e}"
            );
        }
        let mut model = chain.point().omega(2.0).amplitude(1.0).model().unwrap();
        assert!(model.set_omega(0.0).is_err() && model.omega() == 2.0);
        assert!(model.set_omega(1.5).is_ok() && model == chain.point().omega(1.5).amplitude(1.0).model().unwrap());
    }

    #[test]
    fn force_on_the_uniform_mode_is_a_resonance() {
        let model =
            Chain::new(5, 0.25, 0.1).unwrap().point().omega(0.5).amplitude(1.0).restitution(0.5).model().unwrap();
        let error = model.steady_response().unwrap_err();
        assert_eq!((error.harmonic, error.mode), (1, 0));
    }
}
