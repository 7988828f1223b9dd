//! Orbits in many digits.
//!
//! The arithmetic has twice the digits asked for, and some: a multiplier +1 comes in pairs that part like a square root,
//! and the orbit must not be what limits it.

use vibrochain_breather::Orbit;
use vibrochain_lattice::{Barrier, Model};

use crate::conditions::{Problem, State, Steady};
use crate::error::TruthError;
use crate::kernel::Kernel;
use crate::real::Real;

/// The model of an orbit of a lattice without dashpots.
pub(crate) fn undamped(orbit: &Orbit) -> Result<&Model, TruthError> {
    let model = orbit.model().ok_or(TruthError::NoLattice)?;
    if model.is_damped() { Err(TruthError::Dashpots) } else { Ok(model) }
}

/// One impact of a [`TrueOrbit`].
#[derive(Debug, Clone, PartialEq)]
pub struct TrueImpact {
    /// The mass that hits.
    pub site: usize,
    /// The barrier it hits.
    pub barrier: Barrier,
    /// Time of the impact.
    pub time: Real,
    /// Momentum P given to the mass, signed.
    pub impulse: Real,
    /// Velocity just before, by superposition.
    pub velocity_before: Real,
    /// Velocity just after, by superposition.
    pub velocity_after: Real,
    /// Acceleration, force included, by superposition.
    pub acceleration: Real,
}

/// What an `f64` orbit is wrong by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrbitError {
    /// Largest error of an impulse, relative to the largest impulse.
    pub impulse: f64,
    /// Largest error of a time, relative to the orbit's period.
    pub time: f64,
    /// Error of ψ, relative to the period of the force; 0 without force.
    pub psi: f64,
    /// Largest error of an acceleration at an impact, relative to the largest acceleration.
    pub acceleration: f64,
}

/// An orbit whose impulses, times and phase are good to all digits.
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_lattice::Point;
/// use vibrochain_truth::{DEFAULT_BITS, TrueOrbit};
/// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
/// let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model()?;
/// let orbit = &breathers(&model, Family::DoubleSided)?.orbits[0];
/// let truth = TrueOrbit::refine(orbit, DEFAULT_BITS)?;
/// assert!(truth.residual().log10_abs() < -50.0);
/// assert!(truth.error_of(orbit)?.impulse < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct TrueOrbit {
    model: Model,
    force_periods: u32,
    bits: usize,
    kernel: Kernel,
    force: Steady,
    psi: Option<Real>,
    offset: Real,
    impacts: Vec<TrueImpact>,
    last_step: f64,
    residual: Real,
}

impl TrueOrbit {
    /// Solves the orbit's equations to `bits` binary digits, starting from `orbit`. Works for every family and for
    /// words.
    ///
    /// # Errors
    /// [`TruthError::NotConverged`] where Newton's method does not settle, or settles on another orbit;
    /// [`TruthError::Singular`], [`TruthError::Resonance`]; [`TruthError::Dissipative`] for e < 1 without force.
    pub fn refine(orbit: &Orbit, bits: usize) -> Result<Self, TruthError> {
        let model = undamped(orbit)?;
        let chain = model.chain();
        let forced = model.amplitude() > 0.0;
        if !forced && model.restitution() < 1.0 {
            return Err(TruthError::Dissipative);
        }
        let kernel = Kernel::new(chain, model.omega(), orbit.force_periods(), 2 * bits + 64)?;
        let work = kernel.work_bits();
        let e = Real::new(model.restitution(), work);
        let hits: Vec<_> = orbit.impacts().iter().map(|impact| (impact.site, impact.barrier)).collect();
        let strongest = (0..hits.len())
            .max_by(|&i, &j| orbit.impacts()[i].impulse.abs().total_cmp(&orbit.impacts()[j].impulse.abs()));
        let newton = if orbit.is_reversible() {
            Vec::new()
        } else {
            (0..hits.len()).filter(|&i| forced || Some(i) != strongest).collect()
        };
        let problem = Problem {
            model,
            kernel: &kernel,
            force: Steady::new(model, work)?,
            loss: (-&e + 1.0) / (&e + 1.0),
            hits,
            times_free: !orbit.is_reversible(),
            newton,
            rigid: chain.is_adrift(),
        };
        let start = State {
            impulses: orbit.impacts().iter().map(|impact| Real::new(impact.impulse, work)).collect(),
            times: orbit.impacts().iter().map(|impact| start_time(orbit, impact.time, &kernel)).collect(),
            psi: orbit.psi().map(|psi| Real::new(psi, work)),
            offset: Real::zero(work),
        };
        let (state, last_step) = problem.newton(start, bits)?;
        let jets = problem.jets(&state);
        let mut impacts = Vec::with_capacity(problem.hits.len());
        for (i, &(site, barrier)) in problem.hits.iter().enumerate() {
            let [_, velocity, acceleration] = problem.motion(&state, &jets, i);
            let half = &state.impulses[i] / 2.0;
            let (velocity_before, velocity_after) = (&velocity - &half, &velocity + &half);
            let (time, impulse) = (state.times[i].clone(), state.impulses[i].clone());
            impacts.push(TrueImpact { site, barrier, time, impulse, velocity_before, velocity_after, acceleration });
        }
        // All of Newton's equations, also the one that was left out.
        let everything = Problem { newton: (0..problem.hits.len()).collect(), ..problem };
        let residuals = everything.residuals(&state, &jets);
        let residual = residuals.iter().map(Real::abs).fold(Real::zero(work), |a, b| if b > a { b } else { a });
        let force = everything.force;
        let (psi, offset) = (state.psi, state.offset);
        let force_periods = orbit.force_periods();
        Ok(Self { model: *model, force_periods, bits, force, psi, offset, impacts, last_step, residual, kernel })
    }

    /// The parameters.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Periods of the force in one period of the orbit.
    pub fn force_periods(&self) -> u32 {
        self.force_periods
    }

    /// Binary digits asked for.
    pub fn bits(&self) -> usize {
        self.bits
    }

    /// The impulse response of the orbit's period.
    pub fn kernel(&self) -> &Kernel {
        &self.kernel
    }

    /// Period of the orbit.
    pub fn period(&self) -> &Real {
        self.kernel.period()
    }

    /// The impacts in order of time.
    pub fn impacts(&self) -> &[TrueImpact] {
        &self.impacts
    }

    /// Phase ψ of the force at t = 0, as a time; `None` without force.
    pub fn psi(&self) -> Option<&Real> {
        self.psi.as_ref()
    }

    /// Time of the second impact, if there is one.
    pub fn phi(&self) -> Option<&Real> {
        self.impacts.get(1).map(|impact| &impact.time)
    }

    /// Largest violation of the defining equations, |v(t_i) − (a±1)| and |w_i + qP_i/2| over all impacts.
    pub fn residual(&self) -> &Real {
        &self.residual
    }

    /// log₂ of Newton's last step relative to the orbit: how many digits the unknowns hold.
    pub fn last_step_log2(&self) -> f64 {
        self.last_step
    }

    /// Displacement of a mass at any time.
    pub fn displacement(&self, site: usize, t: &Real) -> Real {
        let response = self.superposed(site, t, Kernel::value);
        response + &self.offset + self.wave(site, t).0
    }

    /// Velocity of a mass at any time; the mean of both sides for the mass that is hit, at its impact.
    pub fn velocity(&self, site: usize, t: &Real) -> Real {
        self.superposed(site, t, Kernel::slope) + self.wave(site, t).1
    }

    /// Acceleration of a mass at any time.
    pub fn acceleration(&self, site: usize, t: &Real) -> Real {
        self.superposed(site, t, Kernel::curvature) + self.wave(site, t).2
    }

    /// Σ_j P_j × K or a derivative of it.
    fn superposed(&self, site: usize, t: &Real, response: impl Fn(&Kernel, usize, usize, &Real) -> Real) -> Real {
        let to = site % self.model.chain().sites();
        self.impacts.iter().fold(Real::zero(self.kernel.work_bits()), |sum, impact| {
            sum + &impact.impulse * response(&self.kernel, to, impact.site, &(t - &impact.time))
        })
    }

    /// G(t+ψ) and its derivatives.
    fn wave(&self, site: usize, t: &Real) -> (Real, Real, Real) {
        self.force.at(site, self.psi.as_ref(), t)
    }

    /// The errors of an `f64` orbit that this one was refined from, or of any other with the same impacts.
    ///
    /// # Errors
    /// [`TruthError::Mismatch`] for an orbit of other parameters or with other impacts.
    pub fn error_of(&self, orbit: &Orbit) -> Result<OrbitError, TruthError> {
        let mismatch = |what| Err(TruthError::Mismatch { what });
        if orbit.model() != Some(&self.model) || orbit.force_periods() != self.force_periods {
            return mismatch("the parameters");
        }
        let pairs: Vec<_> = self.impacts.iter().zip(orbit.impacts()).collect();
        if orbit.impacts().len() != self.impacts.len()
            || pairs.iter().any(|(truth, impact)| truth.site != impact.site || truth.barrier != impact.barrier)
        {
            return mismatch("the impacts");
        }
        let largest = |values: &mut dyn Iterator<Item = Real>| {
            values.map(|x| x.abs()).fold(Real::zero(64), |a, b| if b > a { b } else { a })
        };
        let ratio = |error: Real, scale: Real| if error.is_zero() { 0.0 } else { (error / scale).to_f64() };
        let impulse = largest(&mut pairs.iter().map(|(truth, impact)| &truth.impulse - impact.impulse));
        let acceleration = largest(&mut pairs.iter().map(|(truth, impact)| &truth.acceleration - impact.acceleration));
        let time = largest(&mut pairs.iter().map(|(truth, impact)| circular(&truth.time - impact.time, self.period())));
        let force_period = self.period() / f64::from(self.force_periods);
        let psi = match (&self.psi, orbit.psi()) {
            (Some(truth), Some(psi)) => ratio(circular(truth - psi, &force_period).abs(), force_period),
            _ => 0.0,
        };
        Ok(OrbitError {
            impulse: ratio(impulse, largest(&mut self.impacts.iter().map(|impact| impact.impulse.clone()))),
            time: ratio(time, self.period().clone()),
            psi,
            acceleration: ratio(
                acceleration,
                largest(&mut self.impacts.iter().map(|impact| impact.acceleration.clone())),
            ),
        })
    }
}

/// `x` less the nearest multiple of `period`.
fn circular(x: Real, period: &Real) -> Real {
    let turns = (&x / period + 0.5).floor();
    x - turns * period
}

/// A mirror-symmetric orbit has its impacts at 0 and exactly T/2, which no `f64` is.
fn start_time(orbit: &Orbit, time: f64, kernel: &Kernel) -> Real {
    if orbit.is_reversible() && time > 0.0 { kernel.period() / 2.0 } else { Real::new(time, kernel.work_bits()) }
}
