//! The state that a period brings back, every impact on its stop: Newton's method on shooting.
//!
//! ```text
//! unknown    (q, q′) just before the first impact, the times of the others, and the closing unknown
//! equations  (q, q′) a period later is the same;   w_iᵀq(t_i) is the stop of impact i
//! impact     q′ becomes q′ − (1+e) M⁻¹w w·q′ / w·M⁻¹w
//! ```
//!
//! What closes the count is ψ under a load; without one the period, which is an orbit's own where something gives and takes energy. Where
//! nothing does, each period has its orbit: the energy's return follows from the rest, and a gain of energy at the first impact, which
//! comes out as nothing, takes the place of an unknown.

use vibrochain_breather::Hit;
use vibrochain_lattice::Structure;

use super::flow::Flow;
use crate::error::TruthError;
use crate::linear::{Matrix, dot, product, solve};
use crate::real::Real;

/// Newton's method doubles the digits a step; next to a fold it first halves the error a step.
const MAX_STEPS: usize = 60;

/// log₂ of a step, relative to the orbit, from which no start comes back.
const FARTHEST: f64 = 64.0;

/// Digits of the last step beyond those of the steps before: they tell what rounding has hidden there.
const MORE: usize = 128;

/// Times that the digits are doubled where rounding hides too much.
const RETRIES: usize = 4;

/// What closes the count of unknowns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Closing {
    /// ψ
    Phase,
    /// T
    Period,
    /// The gain that is none.
    Gain,
}

/// Contact, stop and restitution of an impact.
#[derive(Debug, Clone)]
pub(crate) struct Hitting {
    pub(crate) weights: Vec<Real>,
    pub(crate) stop: Real,
    pub(crate) restitution: Real,
    /// M⁻¹w
    pub(crate) response: Vec<Real>,
    /// w·M⁻¹w
    pub(crate) mobility: Real,
}

/// The unknowns.
#[derive(Debug, Clone)]
pub(crate) struct Unknowns {
    /// (q, q′/σ) just before the first impact.
    pub(crate) state: Vec<Real>,
    /// Of all impacts, the first at 0.
    pub(crate) times: Vec<Real>,
    pub(crate) psi: Real,
    pub(crate) period: Real,
}

/// What an orbit is solved with, to so many digits.
pub(crate) struct Shooting {
    pub(crate) flow: Flow,
    pub(crate) hits: Vec<Hitting>,
    pub(crate) closing: Closing,
}

/// A period of motion.
pub(crate) struct Round {
    /// (x, u) just before each impact, and at the end.
    pub(crate) before: Vec<Vec<Real>>,
    /// The flights after each impact.
    pub(crate) flights: Vec<Matrix>,
}

/// Where Newton's method has come to.
pub(crate) struct Solved {
    pub(crate) shooting: Shooting,
    pub(crate) unknowns: Unknowns,
    /// log₂ of the last step relative to the unknowns.
    pub(crate) last_step: f64,
}

/// An orbit as it is known before: where Newton's method starts.
#[derive(Debug, Clone, Copy)]
pub struct StructureStart<'a> {
    /// Its matrices, contacts and loads.
    pub structure: &'a Structure,
    /// Frequency of the loads; without them, of `force_periods` periods of the orbit.
    pub omega: f64,
    /// Periods of the loads in one of the orbit.
    pub force_periods: u32,
    /// Phase of the loads at t = 0, as a time.
    pub psi: f64,
    /// The impacts in order of time; the contact of each as its site. Impulses are not asked for: they follow.
    pub impacts: &'a [Hit],
}

impl StructureStart<'_> {
    /// The orbit to `bits` binary digits, which a last step with more digits confirms.
    pub(crate) fn solve(&self, bits: usize) -> Result<Solved, TruthError> {
        let mut last_step = f64::NAN;
        for work in (0..RETRIES).map(|retry| (bits + 64) << retry) {
            let coarse = Shooting::new(self, work)?;
            let mut unknowns = coarse.start(self)?;
            coarse.newton(&mut unknowns, bits)?;
            let shooting = Shooting::new(self, work + MORE)?;
            let mut unknowns = shooting.with_digits(&unknowns, self);
            last_step = shooting.step(&mut unknowns)?;
            if last_step <= -(bits as f64) {
                return Ok(Solved { shooting, unknowns, last_step });
            }
        }
        Err(astray(RETRIES, last_step))
    }
}

impl Shooting {
    fn new(start: &StructureStart<'_>, bits: usize) -> Result<Self, TruthError> {
        let structure = start.structure;
        let probe = Flow::new(structure, start.omega, 64)?;
        // What doubling loses, twice: for the flight, and for the step.
        let period = std::f64::consts::TAU * f64::from(start.force_periods) / start.omega;
        let bits = bits + 2 * probe.doublings(period.log2());
        let flow = Flow::new(structure, start.omega, bits)?;
        let hitting = |hit: &Hit| {
            let (weights, contact) = structure
                .contacts
                .get(hit.site)
                .ok_or(TruthError::Mismatch { what: "an impact at a contact that the structure does not have" })?;
            let stop = contact
                .barrier(hit.barrier)
                .ok_or(TruthError::Mismatch { what: "an impact on a barrier that its contact does not have" })?;
            let weights: Vec<Real> = weights.iter().map(|w| Real::new(*w, bits)).collect();
            let response = flow.over_mass(&weights);
            let mobility = dot(&weights, &response);
            let (stop, restitution) = (Real::new(stop, bits), Real::new(contact.restitution, bits));
            Ok(Hitting { weights, stop, restitution, response, mobility })
        };
        let hits = start.impacts.iter().map(hitting).collect::<Result<Vec<_>, TruthError>>()?;
        if hits.is_empty() {
            return Err(TruthError::Mismatch { what: "an orbit without impacts" });
        }
        let forced = structure.loads.iter().any(|(_, load)| load.iter().any(|f| f.re != 0.0 || f.im != 0.0));
        let loses = structure.damping.iter().any(|c| *c != 0.0) || hits.iter().any(|hit| hit.restitution != 1.0);
        let closing = match (forced, loses) {
            (true, _) => Closing::Phase,
            (false, true) => Closing::Period,
            (false, false) => Closing::Gain,
        };
        Ok(Self { flow, hits, closing })
    }

    fn bits(&self) -> usize {
        self.flow.bits()
    }

    fn states(&self) -> usize {
        2 * self.flow.coordinates()
    }

    /// 2πn/ω
    fn period(&self, start: &StructureStart<'_>) -> Real {
        Real::pi(self.bits()) * (2.0 * f64::from(start.force_periods)) / start.omega
    }

    /// The state that returns if the impulses are what the stops ask for, at the times and the phase that are given: a linear system.
    fn start(&self, start: &StructureStart<'_>) -> Result<Unknowns, TruthError> {
        let (n, states, bits) = (self.flow.coordinates(), self.states(), self.bits());
        let first = start.impacts[0].time;
        let times = start.impacts.iter().map(|hit| Real::new(hit.time, bits) - first).collect();
        let (psi, period) = (Real::new(start.psi, bits) + first, self.period(start));
        let mut unknowns = Unknowns { state: vec![Real::zero(bits); states], times, psi, period };
        // Columns: what a unit of each unknown does to (x, u), and at last u itself.
        let count = states + self.hits.len();
        let mut columns: Matrix = (0..=count).map(|_| vec![Real::zero(bits); self.flow.size()]).collect();
        (0..states).for_each(|i| columns[i][i] = Real::one(bits));
        columns[count][states..].clone_from_slice(&self.flow.phase(&unknowns.psi));
        let (mut rows, mut right) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for (i, hit) in self.hits.iter().enumerate() {
            rows.push(columns[..count].iter().map(|column| dot(&hit.weights, &column[..n])).collect());
            right.push(&hit.stop - dot(&hit.weights, &columns[count][..n]));
            for (entry, push) in columns[states + i][n..].iter_mut().zip(&hit.response) {
                *entry += self.flow.scaled(push);
            }
            columns = product(&columns, &transposed(&self.flow.after(&unknowns.lapse(i))));
        }
        for i in 0..states {
            let mut row: Vec<Real> = columns[..count].iter().map(|column| column[i].clone()).collect();
            row[i] -= Real::one(bits);
            rows.push(row);
            right.push(-&columns[count][i]);
        }
        let mut solution =
            solve(rows, right).ok_or(TruthError::Singular { what: "no state returns with these impacts" })?;
        solution.truncate(states);
        unknowns.state = solution;
        Ok(unknowns)
    }

    /// The same numbers, to be calculated with in these digits. Only a period of the loads is known better.
    fn with_digits(&self, unknowns: &Unknowns, start: &StructureStart<'_>) -> Unknowns {
        let more = |x: &Real| x.with_bits(self.bits());
        let all = |list: &[Real]| list.iter().map(more).collect();
        let period = if self.closing == Closing::Period { more(&unknowns.period) } else { self.period(start) };
        Unknowns { state: all(&unknowns.state), times: all(&unknowns.times), psi: more(&unknowns.psi), period }
    }

    /// The velocity that an impact adds, of a state just before it.
    pub(crate) fn kick(&self, hit: &Hitting, before: &[Real]) -> Vec<Real> {
        let n = self.flow.coordinates();
        let meets = dot(&hit.weights, &before[n..2 * n]);
        let share = -(meets * (&hit.restitution + 1.0)) / &hit.mobility;
        hit.response.iter().map(|push| push * &share).collect()
    }

    /// The same state after an impact.
    pub(crate) fn after(&self, hit: &Hitting, before: &[Real]) -> Vec<Real> {
        let n = self.flow.coordinates();
        let mut state = before.to_vec();
        state[n..2 * n].iter_mut().zip(self.kick(hit, before)).for_each(|(v, kick)| *v += kick);
        state
    }

    /// A period from the unknowns.
    pub(crate) fn round(&self, unknowns: &Unknowns) -> Round {
        let mut now = unknowns.state.clone();
        now.extend(self.flow.phase(&unknowns.psi));
        let mut round = Round { before: vec![now], flights: Vec::with_capacity(self.hits.len()) };
        for (i, hit) in self.hits.iter().enumerate() {
            let flight = self.flow.after(&unknowns.lapse(i));
            let next = crate::linear::times(&flight, &self.after(hit, &round.before[i]));
            round.flights.push(flight);
            round.before.push(next);
        }
        round
    }

    /// One step of Newton's method; log₂ of its size, relative to the state, the period and the largest impulse.
    fn step(&self, unknowns: &mut Unknowns) -> Result<f64, TruthError> {
        let (n, states, bits, impacts) = (self.flow.coordinates(), self.states(), self.bits(), self.hits.len());
        let round = self.round(unknowns);
        let count = states + impacts;
        let zero = || Real::zero(bits);
        // Rows: what each unknown does to (x, u).
        let mut tangents: Matrix = (0..count).map(|_| vec![zero(); self.flow.size()]).collect();
        (0..states).for_each(|i| tangents[i][i] = Real::one(bits));
        let closing = count - 1;
        match self.closing {
            Closing::Phase => {
                tangents[closing][states..].clone_from_slice(&self.flow.slope(&round.before[0])[states..])
            }
            Closing::Gain => tangents[closing][n..states].clone_from_slice(&round.before[0][n..states]),
            Closing::Period => {}
        }
        let (mut rows, mut right) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for (i, hit) in self.hits.iter().enumerate() {
            rows.push(tangents.iter().map(|tangent| dot(&hit.weights, &tangent[..n])).collect());
            right.push(dot(&hit.weights, &round.before[i][..n]) - &hit.stop);
            tangents = tangents.iter().map(|tangent| self.after(hit, tangent)).collect();
            tangents = product(&tangents, &transposed(&round.flights[i]));
            // A later end of the flight, and a later beginning.
            let slope = self.flow.slope(&round.before[i + 1]);
            let mut moved = |unknown: usize, sign: f64| {
                tangents[unknown].iter_mut().zip(&slope).for_each(|(entry, slope)| *entry += slope * sign);
            };
            if i > 0 {
                moved(states + i - 1, -1.0);
            }
            if i + 1 < impacts {
                moved(states + i, 1.0);
            } else if self.closing == Closing::Period {
                moved(closing, 1.0);
            }
        }
        for i in 0..states {
            let mut row: Vec<Real> = tangents.iter().map(|tangent| tangent[i].clone()).collect();
            row[i] -= Real::one(bits);
            rows.push(row);
            right.push(&round.before[impacts][i] - &unknowns.state[i]);
        }
        let step = solve(rows, right)
            .ok_or(TruthError::Singular { what: "the conditions at the impacts do not determine the orbit" })?;
        unknowns.state.iter_mut().zip(&step).for_each(|(x, step)| *x -= step);
        unknowns.times[1..].iter_mut().zip(&step[states..]).for_each(|(t, step)| *t -= step);
        match self.closing {
            Closing::Phase => unknowns.psi -= &step[closing],
            Closing::Period => unknowns.period -= &step[closing],
            Closing::Gain => {}
        }
        let clocks = if self.closing == Closing::Gain { &step[states..closing] } else { &step[states..] };
        let own = self.impulse(&self.hits[0], &step[..states]);
        let parts = [
            log2_largest(&step[..states]) - log2_largest(&unknowns.state),
            log2_largest(clocks) - unknowns.period.log2_abs(),
            // An impulse may be far smaller than the motion that it belongs to.
            own.log2_abs() - log2_largest(&self.impulses(&round)),
        ];
        Ok(parts.into_iter().fold(f64::NEG_INFINITY, f64::max))
    }

    /// Newton's method until its steps are below 2^−bits, or rounding keeps them from it.
    fn newton(&self, unknowns: &mut Unknowns, bits: usize) -> Result<(), TruthError> {
        let mut previous = f64::INFINITY;
        for count in 1..=MAX_STEPS {
            let size = self.step(unknowns)?;
            let at_rest = size < -0.5 * bits as f64 && size > previous - 0.5;
            if size <= -(bits as f64) || at_rest {
                return Ok(());
            }
            if size.is_nan() || size > FARTHEST {
                return Err(astray(count, size));
            }
            previous = size;
        }
        Err(astray(MAX_STEPS, previous))
    }

    /// The impulse of an impact: what its state just before makes of it.
    pub(crate) fn impulse(&self, hit: &Hitting, before: &[Real]) -> Real {
        let n = self.flow.coordinates();
        let meets = self.flow.unscaled(&dot(&hit.weights, &before[n..2 * n]));
        -(meets * (&hit.restitution + 1.0)) / &hit.mobility
    }

    fn impulses(&self, round: &Round) -> Vec<Real> {
        self.hits.iter().zip(&round.before).map(|(hit, before)| self.impulse(hit, before)).collect()
    }
}

impl Unknowns {
    /// The flight after an impact.
    fn lapse(&self, impact: usize) -> Real {
        let until = self.times.get(impact + 1).unwrap_or(&self.period);
        until - &self.times[impact]
    }
}

fn astray(iterations: usize, size: f64) -> TruthError {
    TruthError::NotConverged { iterations, last_step: size * 2f64.log10(), moved: f64::INFINITY }
}

fn log2_largest(list: &[Real]) -> f64 {
    list.iter().map(Real::log2_abs).fold(f64::NEG_INFINITY, f64::max)
}

fn transposed(matrix: &Matrix) -> Matrix {
    (0..matrix[0].len()).map(|j| matrix.iter().map(|row| row[j].clone()).collect()).collect()
}
