//! The conditions at the impacts and Newton's method for them.
//!
//! ```text
//! v_n(t) = Σ_j P_j K_{n n_j}(t−t_j) + c + G_n(t+ψ),   G_n(t) = Σ_h Ã_h cos(hωt + θ_h)
//!                                                    Ã_h = A_h/(γ₁−h²ω²), or Σ_k φ_k(n) A_h (Σ_m φ_k(m))/(Ω_k²−h²ω²)
//! position   v(t_i) − (a ± 1)                                   = 0
//! Newton     Σ_{j≠i} P_j K′(t_i−t_j) + Ġ(t_i+ψ) + q P_i/2       = 0,   q = (1−e)/(1+e)
//! adrift     Σ_j P_j                                            = 0
//! ```
//!
//! Unknown are the impulses, all times but the first, ψ under a force, and for a lattice that nothing holds its offset c
//! (otherwise c = 0). Without force there is one unknown less, and one equation: Σ P_i × (Newton's equation i) vanishes by itself
//! when q = 0, because K′ is odd; the one of the strongest impact is left out. Orbits that are their own mirror image in
//! time have their impacts at 0 and T/2 and are left with a linear system.

use vibrochain_lattice::{Barrier, Ends, Harmonic, Model};

use crate::direction::Direction;
use crate::error::TruthError;
use crate::kernel::{Jet, Kernel, Waves};
use crate::linear::solve;
use crate::real::Real;

/// Newton's method doubles the digits a step; next to a fold it first halves the error a step, from 1e-8 or so.
const MAX_STEPS: usize = 100;

/// An orbit farther than this from its start (relative to its impulses and period) is another orbit.
const MAX_MOVE: f64 = 1e-2;

/// The unknowns.
#[derive(Clone)]
pub(crate) struct State {
    pub(crate) impulses: Vec<Real>,
    pub(crate) times: Vec<Real>,
    pub(crate) psi: Option<Real>,
    pub(crate) offset: Real,
}

/// What is solved for and by which equations.
pub(crate) struct Problem<'a> {
    pub(crate) model: &'a Model,
    pub(crate) kernel: &'a Kernel,
    /// G
    pub(crate) force: Steady,
    /// q
    pub(crate) loss: Real,
    pub(crate) hits: Vec<(usize, Barrier)>,
    pub(crate) times_free: bool,
    /// Newton's equations that are asked for.
    pub(crate) newton: Vec<usize>,
    pub(crate) rigid: bool,
}

/// The motion that the force drives: hω, θ_h and Ã_h of each harmonic, the last of all masses alike or, between walls, of each
/// mass of a row.
#[derive(Debug, Clone)]
pub(crate) struct Steady(Vec<(Real, f64, Vec<Real>)>);

impl Steady {
    /// The answer to the model's force, in `bits` digits.
    pub(crate) fn new(model: &Model, bits: usize) -> Result<Self, TruthError> {
        let chain = model.chain();
        let [row, _] = Direction::both(chain);
        let harmonics = model.force().harmonics().iter().filter(|harmonic| harmonic.amplitude != 0.0);
        let answer = |harmonic: &Harmonic| {
            let rate = Real::new(model.omega(), bits) * f64::from(harmonic.number);
            let amplitude = Real::new(harmonic.amplitude, bits);
            let response = |mode: usize, stiffness: Real| {
                let difference = stiffness + chain.gamma1() - &rate * &rate;
                let resonance = || TruthError::Resonance { mode, omega: model.omega() };
                (!difference.is_zero()).then(|| &amplitude / difference).ok_or_else(resonance)
            };
            let amplitudes = if chain.ends() == Ends::Fixed {
                let row = row.clone().tabulated(bits);
                let mut sums = vec![Real::zero(bits); row.masses()];
                for mode in 0..row.modes() {
                    let response = response(mode, row.stiffness(mode, bits) * chain.gamma2())?;
                    sums.iter_mut().zip(row.pushed(mode, bits)).for_each(|(sum, part)| *sum += part * &response);
                }
                sums
            } else {
                vec![response(0, Real::zero(bits))?]
            };
            Ok((rate, harmonic.phase, amplitudes))
        };
        harmonics.map(answer).collect::<Result<_, _>>().map(Self)
    }

    /// G, Ġ and G̈ of a mass at t+ψ; nothing without a phase, hence without force.
    pub(crate) fn at(&self, site: usize, psi: Option<&Real>, t: &Real) -> (Real, Real, Real) {
        let mut sum = (Real::zero(64), Real::zero(64), Real::zero(64));
        let Some(psi) = psi else { return sum };
        for (rate, phase, amplitudes) in &self.0 {
            let amplitude = &amplitudes[site % amplitudes.len()];
            let (sin, cos) = ((t + psi) * rate + *phase).sin_cos();
            let (x, y) = (amplitude * cos, amplitude * sin * rate);
            let z = &x * rate * rate;
            sum = (sum.0 + x, sum.1 - y, sum.2 - z);
        }
        sum
    }
}

impl Problem<'_> {
    /// K and its derivatives at t_j − t_i for i ≤ j.
    pub(crate) fn jets(&self, state: &State) -> Vec<Vec<Jet>> {
        let n = self.hits.len();
        // Most of the work; impacts of the same instants share them.
        let mut known: Vec<(Real, Waves)> = Vec::new();
        let mut jet = |i: usize, j: usize| {
            let t = &state.times[j] - &state.times[i];
            let place = known.iter().position(|known| known.0 == t).unwrap_or_else(|| {
                let waves = self.kernel.waves(&t);
                known.push((t, waves));
                known.len() - 1
            });
            self.kernel.jet_of(self.hits[j].0, self.hits[i].0, &known[place].1)
        };
        (0..n).map(|i| (i..n).map(|j| jet(i, j)).collect()).collect()
    }

    /// K, K′, K″ at t_i − t_j: even, odd, even.
    fn pair(jets: &[Vec<Jet>], i: usize, j: usize) -> (&Real, Real, &Real) {
        let jet = &jets[i.min(j)][i.max(j) - i.min(j)];
        (&jet.value, if i < j { -&jet.slope } else { jet.slope.clone() }, &jet.curvature)
    }

    /// Displacement, mean velocity and acceleration of the mass that is hit at impact i.
    pub(crate) fn motion(&self, state: &State, jets: &[Vec<Jet>], i: usize) -> [Real; 3] {
        let (mut u, mut v, mut a) = self.force.at(self.hits[i].0, state.psi.as_ref(), &state.times[i]);
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
    pub(crate) fn residuals(&self, state: &State, jets: &[Vec<Jet>]) -> Vec<Real> {
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
        let waves: Vec<_> = (state.times.iter().zip(&self.hits))
            .map(|(t, (site, _))| self.force.at(*site, state.psi.as_ref(), t))
            .collect();
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
    pub(crate) fn newton(&self, start: State, bits: usize) -> Result<(State, f64), TruthError> {
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
