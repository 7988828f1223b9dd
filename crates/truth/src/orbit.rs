//! Orbits in many digits, by Newton's method on the conditions at the impacts.
//!
//! ```text
//! v_n(t) = Σ_j P_j K_{n−n_j}(t−t_j) + c + G(t+ψ),   G(t) = Ã cos ωt,   Ã = A/(γ₁−ω²)
//! position   v(t_i) − (a ± 1)                                   = 0
//! Newton     Σ_{j≠i} P_j K′(t_i−t_j) + Ġ(t_i+ψ) + q P_i/2       = 0,   q = (1−e)/(1+e)
//! γ₁ = 0     Σ_j P_j                                            = 0
//! ```
//!
//! Unknown are the impulses, all times but the first, ψ under a force, and for γ₁ = 0 the offset c of the ring (otherwise
//! c = 0). Without force there is one unknown less, and one equation: Σ P_i × (Newton's equation i) vanishes by itself
//! when q = 0, because K′ is odd; the one of the strongest impact is left out. Orbits that are their own mirror image in
//! time have their impacts at 0 and T/2 and are left with a linear system.
//!
//! The arithmetic has twice the digits asked for, and some: a multiplier +1 comes in pairs that part like a square root,
//! and the orbit must not be what limits it.

use vibrochain_breather::Orbit;
use vibrochain_lattice::{Barrier, Model};

use crate::error::TruthError;
use crate::kernel::{Jet, Kernel};
use crate::linear::solve;
use crate::real::Real;

/// Newton's method doubles the digits a step; next to a fold it first halves the error a step, from 1e-8 or so.
const MAX_STEPS: usize = 100;

/// An orbit farther than this from its start (relative to its impulses and period) is another orbit.
const MAX_MOVE: f64 = 1e-2;

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
/// use vibrochain_lattice::{Chain, Model};
/// use vibrochain_truth::{DEFAULT_BITS, TrueOrbit};
/// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4, 0.1, 0.9)?;
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
    force: Real,
    psi: Option<Real>,
    offset: Real,
    impacts: Vec<TrueImpact>,
    last_step: f64,
    residual: Real,
}

/// The unknowns.
#[derive(Clone)]
struct State {
    impulses: Vec<Real>,
    times: Vec<Real>,
    psi: Option<Real>,
    offset: Real,
}

/// What is solved for and by which equations.
struct Problem<'a> {
    model: &'a Model,
    kernel: &'a Kernel,
    /// Ã
    force: Real,
    /// q
    loss: Real,
    hits: Vec<(usize, Barrier)>,
    times_free: bool,
    /// Newton's equations that are asked for.
    newton: Vec<usize>,
    rigid: bool,
}

impl TrueOrbit {
    /// Solves the orbit's equations to `bits` binary digits, starting from `orbit`. Works for every family and for
    /// words.
    ///
    /// # Errors
    /// [`TruthError::NotConverged`] where Newton's method does not settle, or settles on another orbit;
    /// [`TruthError::Singular`], [`TruthError::Resonance`]; [`TruthError::Dissipative`] for e < 1 without force.
    pub fn refine(orbit: &Orbit, bits: usize) -> Result<Self, TruthError> {
        let model = orbit.model();
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
            force: force_response(model, work)?,
            loss: (-&e + 1.0) / (&e + 1.0),
            hits,
            times_free: !orbit.is_reversible(),
            newton,
            rigid: chain.gamma1() == 0.0,
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
        response + &self.offset + self.wave(t).0
    }

    /// Velocity of a mass at any time; the mean of both sides for the mass that is hit, at its impact.
    pub fn velocity(&self, site: usize, t: &Real) -> Real {
        self.superposed(site, t, Kernel::slope) + self.wave(t).1
    }

    /// Acceleration of a mass at any time.
    pub fn acceleration(&self, site: usize, t: &Real) -> Real {
        self.superposed(site, t, Kernel::curvature) + self.wave(t).2
    }

    /// Σ_j P_j × K or a derivative of it.
    fn superposed(&self, site: usize, t: &Real, response: impl Fn(&Kernel, usize, &Real) -> Real) -> Real {
        let chain = self.model.chain();
        self.impacts.iter().fold(Real::zero(self.kernel.work_bits()), |sum, impact| {
            let distance = chain.distance(site % chain.sites(), impact.site);
            sum + &impact.impulse * response(&self.kernel, distance, &(t - &impact.time))
        })
    }

    /// G(t+ψ) and its derivatives.
    fn wave(&self, t: &Real) -> (Real, Real, Real) {
        wave(&self.force, self.model.omega(), self.psi.as_ref(), t)
    }

    /// The errors of an `f64` orbit that this one was refined from, or of any other with the same impacts.
    ///
    /// # Errors
    /// [`TruthError::Mismatch`] for an orbit of other parameters or with other impacts.
    pub fn error_of(&self, orbit: &Orbit) -> Result<OrbitError, TruthError> {
        let mismatch = |what| Err(TruthError::Mismatch { what });
        if orbit.model() != &self.model || orbit.force_periods() != self.force_periods {
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

/// Ã = A/(γ₁−ω²)
fn force_response(model: &Model, bits: usize) -> Result<Real, TruthError> {
    let omega = Real::new(model.omega(), bits);
    let stiffness = -(&omega * &omega) + model.chain().gamma1();
    if model.amplitude() == 0.0 {
        Ok(Real::zero(bits))
    } else if stiffness.is_zero() {
        Err(TruthError::Resonance { mode: 0, omega: model.omega() })
    } else {
        Ok(Real::new(model.amplitude(), bits) / stiffness)
    }
}

/// A mirror-symmetric orbit has its impacts at 0 and exactly T/2, which no `f64` is.
fn start_time(orbit: &Orbit, time: f64, kernel: &Kernel) -> Real {
    if orbit.is_reversible() && time > 0.0 { kernel.period() / 2.0 } else { Real::new(time, kernel.work_bits()) }
}

/// Ã cos θ, −Ãω sin θ, −Ãω² cos θ, at θ = ω(t+ψ).
fn wave(force: &Real, omega: f64, psi: Option<&Real>, t: &Real) -> (Real, Real, Real) {
    match psi {
        None => (Real::zero(64), Real::zero(64), Real::zero(64)),
        Some(psi) => {
            let (sin, cos) = ((t + psi) * omega).sin_cos();
            let (x, y) = (force * cos, force * sin * omega);
            let z = -(&x * omega * omega);
            (x, -y, z)
        }
    }
}

impl Problem<'_> {
    /// K and its derivatives at t_j − t_i for i ≤ j.
    fn jets(&self, state: &State) -> Vec<Vec<Jet>> {
        let n = self.hits.len();
        let mut at_impulse: Vec<(usize, Jet)> = Vec::new();
        let mut jet = |i: usize, j: usize| {
            let distance = self.model.chain().distance(self.hits[i].0, self.hits[j].0);
            let t = &state.times[j] - &state.times[i];
            if !t.is_zero() {
                return self.kernel.jet(distance, &t);
            }
            // Every impact has one of these.
            match at_impulse.iter().find(|known| known.0 == distance) {
                Some(known) => known.1.clone(),
                None => {
                    let jet = self.kernel.jet(distance, &t);
                    at_impulse.push((distance, jet.clone()));
                    jet
                }
            }
        };
        (0..n).map(|i| (i..n).map(|j| jet(i, j)).collect()).collect()
    }

    /// K, K′, K″ at t_i − t_j: even, odd, even.
    fn pair(jets: &[Vec<Jet>], i: usize, j: usize) -> (&Real, Real, &Real) {
        let jet = &jets[i.min(j)][i.max(j) - i.min(j)];
        (&jet.value, if i < j { -&jet.slope } else { jet.slope.clone() }, &jet.curvature)
    }

    /// Displacement, mean velocity and acceleration of the mass that is hit at impact i.
    fn motion(&self, state: &State, jets: &[Vec<Jet>], i: usize) -> [Real; 3] {
        let (mut u, mut v, mut a) = wave(&self.force, self.model.omega(), state.psi.as_ref(), &state.times[i]);
        u += &state.offset;
        for (j, impulse) in state.impulses.iter().enumerate() {
            let (value, slope, curvature) = Self::pair(jets, i, j);
            u += impulse * value;
            v += impulse * slope;
            a += impulse * curvature;
        }
        [u, v, a]
    }

    /// The equations' left sides: positions, Newton's, net impulse.
    fn residuals(&self, state: &State, jets: &[Vec<Jet>]) -> Vec<Real> {
        let motions: Vec<_> = (0..self.hits.len()).map(|i| self.motion(state, jets, i)).collect();
        let positions = motions.iter().zip(&self.hits).map(|(motion, (_, barrier))| {
            // The barrier in full precision: a ± 1 need not be an f64.
            &motion[0] - (Real::new(self.model.asymmetry(), 128) + barrier.sign())
        });
        let newton = self.newton.iter().map(|&i| &motions[i][1] + &self.loss * &state.impulses[i] / 2.0);
        let net = self.rigid.then(|| state.impulses.iter().fold(Real::zero(64), |sum, impulse| sum + impulse));
        positions.chain(newton).chain(net).collect()
    }

    /// Derivatives of the left sides by (P_0 …, t_1 …, ψ, c).
    fn jacobian(&self, state: &State, jets: &[Vec<Jet>]) -> Vec<Vec<Real>> {
        let n = self.hits.len();
        let zero = Real::zero(self.kernel.work_bits());
        let waves: Vec<_> =
            state.times.iter().map(|t| wave(&self.force, self.model.omega(), state.psi.as_ref(), t)).collect();
        let row = |i: usize, newton: bool| {
            let mut row = Vec::with_capacity(2 * n + 1);
            for j in 0..n {
                let (value, slope, _) = Self::pair(jets, i, j);
                row.push(match (newton, i == j) {
                    (false, _) => value.clone(),
                    (true, false) => slope,
                    (true, true) => &self.loss / 2.0,
                });
            }
            // d/dt_i of what the impact j does at t_i, and d/dt_j is the opposite.
            let rate = |j: usize| {
                let (_, slope, curvature) = Self::pair(jets, i, j);
                &state.impulses[j] * if newton { curvature } else { &slope }
            };
            let by_phase = if newton { &waves[i].2 } else { &waves[i].1 };
            if self.times_free {
                for k in 1..n {
                    row.push(if k == i {
                        (0..n).filter(|&j| j != i).fold(by_phase.clone(), |sum, j| sum + rate(j))
                    } else {
                        -rate(k)
                    });
                }
            }
            if state.psi.is_some() {
                row.push(by_phase.clone());
            }
            if self.rigid {
                row.push(if newton { zero.clone() } else { Real::one(64) });
            }
            row
        };
        let positions = (0..n).map(|i| row(i, false));
        let newton = self.newton.iter().map(|&i| row(i, true));
        let columns = n + self.newton.len() + usize::from(self.rigid);
        let net = self.rigid.then(|| (0..columns).map(|j| if j < n { Real::one(64) } else { zero.clone() }).collect());
        positions.chain(newton).chain(net).collect()
    }

    /// Newton's method until the steps no longer shrink; the last one, relative, must be below 2^−bits. Returns log₂ of
    /// it.
    fn newton(&self, start: State, bits: usize) -> Result<(State, f64), TruthError> {
        let largest = start.impulses.iter().map(Real::log2_abs).fold(f64::NEG_INFINITY, f64::max);
        let period = self.kernel.period().log2_abs();
        let floor = -(self.kernel.work_bits() as f64);
        let mut state = start.clone();
        let mut previous = f64::INFINITY;
        for step_number in 1..=MAX_STEPS {
            let jets = self.jets(&state);
            let residuals = self.residuals(&state, &jets);
            let step = solve(self.jacobian(&state, &jets), residuals)
                .ok_or(TruthError::Singular { what: "the conditions at the impacts do not determine the orbit" })?;
            let mut size = f64::NEG_INFINITY;
            let mut steps = step.into_iter();
            let mut advance = |x: &mut Real, scale: f64| {
                if let Some(step) = steps.next() {
                    size = size.max(step.log2_abs() - scale);
                    *x -= step;
                }
            };
            state.impulses.iter_mut().for_each(|x| advance(x, largest));
            if self.times_free {
                state.times.iter_mut().skip(1).for_each(|x| advance(x, period));
            }
            if let Some(psi) = &mut state.psi {
                advance(psi, period);
            }
            if self.rigid {
                // Linear and without a start of its own: the others tell when it is done.
                advance(&mut state.offset, f64::INFINITY);
            }
            let moved = self.moved(&start, &state, largest, period);
            let failed = || TruthError::NotConverged { iterations: step_number, last_step: size * 2f64.log10(), moved };
            if !size.is_finite() && size > 0.0 || size.is_nan() {
                return Err(failed());
            }
            let settled = size <= floor || (size < -(bits as f64) && size > previous - 1.0);
            if settled {
                return if moved < MAX_MOVE && self.in_order(&state, bits) { Ok((state, size)) } else { Err(failed()) };
            }
            if step_number == MAX_STEPS || size > 64.0 {
                return Err(failed());
            }
            previous = size;
        }
        Err(TruthError::Singular { what: "no steps were allowed" })
    }

    /// Distance from the start, relative to the impulses and the period.
    fn moved(&self, start: &State, state: &State, largest: f64, period: f64) -> f64 {
        let distance = |a: &[Real], b: &[Real], scale: f64| {
            a.iter().zip(b).map(|(a, b)| (a - b).log2_abs() - scale).fold(f64::NEG_INFINITY, f64::max)
        };
        let psi = start.psi.as_slice();
        distance(&start.impulses, &state.impulses, largest)
            .max(distance(&start.times, &state.times, period))
            .max(distance(psi, state.psi.as_slice(), period))
            .exp2()
    }

    /// Times rise and stay within the period; those of simultaneous impacts agree to the digits asked for.
    fn in_order(&self, state: &State, bits: usize) -> bool {
        let slack = -self.kernel.period().times_power_of_two(-(bits.min(1 << 20) as i32));
        let ordered = state.times.windows(2).all(|pair| &pair[1] - &pair[0] >= slack);
        ordered && state.times.last().is_none_or(|last| last < self.kernel.period())
    }
}
