//! Where a run starts: on an orbit, perhaps perturbed.
//!
//! A run from an orbit begins in the middle of its last flight, at a time −s before the impact at t = 0: there every mass
//! has room for a perturbation, and times agree with those of `mapgen orbit`.

use vibrochain_breather::{BreatherError, Motion, Orbit};
use vibrochain_eventsim::{Simulation, StateError};
use vibrochain_floquet::Complex;
use vibrochain_lattice::Model;

/// From so many masses on all are moved by a Fourier transform at once: of 1e5 one by one takes ten seconds.
const MANY: usize = 1000;

/// A Floquet mode: (displacement, velocity) of each mass.
pub type ModeShape = Vec<(Complex<f64>, Complex<f64>)>;

/// Displacements and velocities, and what is needed to place them in time.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// u_n
    pub displacement: Vec<f64>,
    /// u̇_n
    pub velocity: Vec<f64>,
    /// Phase ψ of the force at the start.
    pub psi: f64,
    /// Time of the start, 0 or negative.
    pub time: f64,
}

impl Start {
    /// On an orbit, before its first impact.
    ///
    /// # Errors
    /// [`BreatherError`] if the orbit's motion is not defined.
    pub fn on(orbit: &Orbit) -> Result<Self, BreatherError> {
        let time = orbit.time_in_last_flight();
        let (displacement, velocity) = Self::states(orbit, time)?;
        Ok(Self { displacement, velocity, psi: orbit.psi().unwrap_or(0.0) + time, time })
    }

    /// Displacements and velocities of all masses of an orbit at a time on its clock.
    ///
    /// # Errors
    /// [`BreatherError`] if the orbit's motion is not defined.
    pub fn states(orbit: &Orbit, time: f64) -> Result<(Vec<f64>, Vec<f64>), BreatherError> {
        let mut motion = Motion::of(orbit)?;
        if motion.sites() > MANY {
            return Ok(motion.state(time));
        }
        motion.at(0, time);
        let masses = (0..motion.sites()).map(|n| motion.site(n));
        Ok(masses.map(|mass| (mass.displacement, mass.velocity)).unzip())
    }

    /// A simulation from here.
    ///
    /// # Errors
    /// [`StateError`]: a perturbation has put a mass behind its barrier.
    pub fn simulation(&self, model: &Model) -> Result<Simulation, StateError> {
        Simulation::new(model, self.psi, &self.displacement, &self.velocity)
    }

    /// Adds a random perturbation whose largest entry (displacements, and velocities over ω) is `size`.
    pub fn perturb_at_random(&mut self, model: &Model, size: f64, seed: u64) {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut entries: Vec<f64> = (0..2 * self.displacement.len()).map(|_| 2.0 * random.f64() - 1.0).collect();
        let largest = entries.iter().fold(f64::MIN_POSITIVE, |largest: f64, x| largest.max(x.abs()));
        entries.iter_mut().for_each(|x| *x *= size / largest);
        let (u, v) = entries.split_at(self.displacement.len());
        self.displacement.iter_mut().zip(u).for_each(|(x, d)| *x += d);
        self.velocity.iter_mut().zip(v).for_each(|(x, d)| *x += model.omega() * d);
    }

    /// Adds the real part of a Floquet mode, scaled like a random perturbation.
    pub fn perturb_along(&mut self, model: &Model, size: f64, mode: &[(Complex<f64>, Complex<f64>)]) {
        let largest =
            mode.iter().map(|(u, v)| u.re.abs().max(v.re.abs() / model.omega())).fold(f64::MIN_POSITIVE, f64::max);
        for ((x, v), (du, dv)) in self.displacement.iter_mut().zip(&mut self.velocity).zip(mode) {
            *x += size / largest * du.re;
            *v += size / largest * dv.re;
        }
    }
}
