//! General ways to simulate a chain without its exact flight: an adaptive Runge–Kutta method with root finding
//! (DOP853), the classical one with a fixed step and bisection, and time stepping that knows impacts at the ends of steps
//! only. Free chains (A = 0), from t = 0; displacements first, then velocities.

use ode_solvers::dop_shared::OutputType;
use ode_solvers::{DVector, Dop853, System};
use thiserror::Error;
use vibrochain_lattice::Model;

/// The solver gave up: too many steps, or a step below rounding.
#[derive(Debug, Clone, Error)]
#[error("the Runge-Kutta solver stopped at t = {time}: {reason}")]
pub(super) struct StepperError {
    time: f64,
    reason: String,
}

/// Where a run ended.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Run {
    /// Displacements, then velocities, at the end.
    pub(super) state: Vec<f64>,
    /// Impacts on the way.
    pub(super) impacts: u64,
}

/// d/dt of a state.
fn slopes(model: &Model, y: &[f64], dy: &mut [f64]) {
    let m = model.chain().sites();
    let (g1, g2) = (model.chain().gamma1(), model.chain().gamma2());
    let (u, v) = y.split_at(m);
    let (du, dv) = dy.split_at_mut(m);
    du.copy_from_slice(v);
    for n in 0..m {
        let left = if n == 0 { u[m - 1] } else { u[n - 1] };
        let right = if n + 1 == m { u[0] } else { u[n + 1] };
        dv[n] = -g1 * u[n] - g2 * (2.0 * u[n] - left - right);
    }
}

/// The mass farthest beyond a barrier.
fn outside(model: &Model, y: &[f64]) -> Option<usize> {
    let m = model.chain().sites();
    let excess = |n: &usize| (y[*n] - model.asymmetry()).abs() - 1.0;
    (0..m).filter(|n| excess(n) > 0.0).max_by(|n, k| excess(n).total_cmp(&excess(k)))
}

/// Puts a mass on the barrier it has reached and turns it back, if it moves outward.
fn bounce(model: &Model, y: &mut [f64], site: usize) {
    let (m, a) = (model.chain().sites(), model.asymmetry());
    let side = (y[site] - a).signum();
    y[site] = a + side;
    if y[site + m] * side > 0.0 {
        y[site + m] *= -model.restitution();
    }
}

pub(super) type State = DVector<f64>;

#[derive(Clone, Copy)]
struct Ring<'a> {
    model: &'a Model,
}

impl System<f64, State> for Ring<'_> {
    fn system(&self, _: f64, y: &State, dy: &mut State) {
        slopes(self.model, y.as_slice(), dy.as_mut_slice());
    }
}

/// Times and states of the dense output every `step` over `time`, or of every step taken without one.
fn dop853_flight(
    system: impl System<f64, State>,
    from: &State,
    time: f64,
    step: Option<f64>,
    tolerance: f64,
) -> Result<(Vec<f64>, Vec<State>), StepperError> {
    let dx = step.unwrap_or(time);
    let mut solver = Dop853::new(system, 0.0, time, dx, from.clone(), tolerance, tolerance);
    if step.is_none() {
        solver.set_output(OutputType::Sparse);
    }
    solver.integrate().map_err(|error| StepperError { time, reason: error.to_string() })?;
    Ok((solver.x_out().clone(), solver.y_out().clone()))
}

/// The state after `time`, from t = 0.
pub(super) fn dop853_end(
    system: impl System<f64, State>,
    from: &State,
    time: f64,
    tolerance: f64,
) -> Result<State, StepperError> {
    let (_, mut states) = dop853_flight(system, from, time, None, tolerance)?;
    states.pop().ok_or_else(|| StepperError { time, reason: "it took no step".to_owned() })
}

/// DOP853 with event location the usual way: dense output twenty times a period, change of sign between outputs, then
/// Newton's method for the time of the impact, from the last output before it. States that are carried on come from the
/// method's own steps, not from its interpolation.
///
/// # Errors
/// [`StepperError`].
pub(super) fn dop853(model: &Model, start: &[f64], time: f64, tolerance: f64) -> Result<Run, StepperError> {
    let (m, period, ring) = (model.chain().sites(), model.period(), Ring { model });
    let mut state = State::from_column_slice(start);
    let (mut left, mut impacts) = (time, 0);
    while left > 0.0 {
        // A bit more than the time between two impacts of a breather on both barriers.
        let flight = left.min(0.6 * period);
        let (times, states) = dop853_flight(ring, &state, flight, Some((period / 20.0).min(flight)), tolerance)?;
        // A mass that has just hit may still be outside by rounding: the first output is passed over.
        let hit = states.iter().enumerate().skip(1).find_map(|(i, y)| Some((i, outside(model, y.as_slice())?)));
        let Some((index, site)) = hit else {
            state = dop853_end(ring, &state, flight, tolerance)?;
            left -= flight;
            continue;
        };
        let before = times[index - 1];
        if index > 1 {
            state = dop853_end(ring, &state, before, tolerance)?;
            left -= before;
        }
        let barrier = model.asymmetry() + (states[index][site] - model.asymmetry()).signum();
        let mut t = times[index] - before;
        let mut at = states[index].clone();
        for _ in 0..8 {
            let step = (at[site] - barrier) / at[site + m];
            if !step.is_finite() || step.abs() >= period {
                return Err(StepperError {
                    time: time - left + t,
                    reason: "an impact could not be located".to_owned(),
                });
            }
            t = (t - step).max(f64::MIN_POSITIVE);
            at = dop853_end(ring, &state, t, tolerance)?;
            if step.abs() < 1e-15 {
                break;
            }
        }
        at[site] = barrier;
        at[site + m] *= -model.restitution();
        (state, left) = (at, left - t);
        impacts += 1;
    }
    Ok(Run { state: state.as_slice().to_vec(), impacts })
}

/// Work space of a Runge–Kutta step.
struct Stages {
    slopes: [Vec<f64>; 4],
    point: Vec<f64>,
}

/// One step of the classical fourth-order method.
fn rk4_step(model: &Model, from: &[f64], h: f64, to: &mut [f64], stages: &mut Stages) {
    let Stages { slopes: k, point } = stages;
    slopes(model, from, &mut k[0]);
    for (stage, part) in [(1, 0.5), (2, 0.5), (3, 1.0)] {
        let (known, rest) = k.split_at_mut(stage);
        for ((p, x), slope) in point.iter_mut().zip(from).zip(&known[stage - 1]) {
            *p = x + part * h * slope;
        }
        slopes(model, point, &mut rest[0]);
    }
    let [k1, k2, k3, k4] = k;
    for i in 0..from.len() {
        to[i] = from[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
    }
}

/// The classical Runge–Kutta method with `steps` equal steps over `time`; a step that ends beyond a barrier is halved in on
/// the impact by bisection, and finished after it.
pub(super) fn rk4(model: &Model, start: &[f64], time: f64, steps: u64) -> Run {
    let h = time / steps as f64;
    let mut stages = Stages { slopes: [(); 4].map(|()| vec![0.0; start.len()]), point: vec![0.0; start.len()] };
    let (mut state, mut next) = (start.to_vec(), start.to_vec());
    let mut impacts = 0;
    for _ in 0..steps {
        let mut done = 0.0;
        loop {
            let rest = h - done;
            rk4_step(model, &state, rest, &mut next, &mut stages);
            if outside(model, &next).is_none() {
                break;
            }
            // The first moment outside, of whichever mass: inside at `low`, outside at `high`.
            let (mut low, mut high) = (0.0, rest);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if middle <= low || middle >= high {
                    break;
                }
                rk4_step(model, &state, middle, &mut next, &mut stages);
                *(if outside(model, &next).is_some() { &mut high } else { &mut low }) = middle;
            }
            rk4_step(model, &state, high, &mut next, &mut stages);
            let Some(site) = outside(model, &next) else { break };
            bounce(model, &mut next, site);
            std::mem::swap(&mut state, &mut next);
            done += high;
            impacts += 1;
            if done >= h {
                next.copy_from_slice(&state);
                break;
            }
        }
        std::mem::swap(&mut state, &mut next);
    }
    Run { state, impacts }
}

/// Moreau's time stepping (the midpoint rule): half a step of displacements, velocities by the forces there, and for every
/// mass that is then beyond a barrier the impact law for its velocity at the end of the step; the other half. Second order
/// in flight, first order with impacts, whose time it does not look for.
pub(super) fn time_stepping(model: &Model, start: &[f64], time: f64, steps: u64) -> Run {
    let (m, a, e) = (model.chain().sites(), model.asymmetry(), model.restitution());
    let h = time / steps as f64;
    let mut state = start.to_vec();
    let mut slope = vec![0.0; start.len()];
    let mut impacts = 0;
    let drift = |state: &mut [f64]| {
        let (u, v) = state.split_at_mut(m);
        u.iter_mut().zip(v).for_each(|(u, v)| *u += 0.5 * h * *v);
    };
    for _ in 0..steps {
        drift(&mut state);
        slopes(model, &state, &mut slope);
        let (u, v) = state.split_at_mut(m);
        for ((u, v), dv) in u.iter().zip(v).zip(&slope[m..]) {
            let (free, offset) = (*v + h * dv, *u - a);
            // Newton's law in the form of a complementarity: the barrier only pushes.
            if offset.abs() >= 1.0 && offset * (free + e * *v) > 0.0 {
                *v *= -e;
                impacts += 1;
            } else {
                *v = free;
            }
        }
        drift(&mut state);
    }
    Run { state, impacts }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibrochain_lattice::Chain;

    /// One mass on a spring between barriers at −0.6 and 1.4, from the middle of its well with velocity 2: arcs of a sine.
    fn one_mass() -> (Model, f64, [f64; 2]) {
        let model = Model::conservative(Chain::new(1, 0.25, 0.0).unwrap(), 1.0, 0.4).unwrap();
        // x = 4 sin(t/2) reaches 1.4; from 0 to 1.4 and back, then to −0.6 and back.
        let round = 2.0 * 2.0 * ((1.4_f64 / 4.0).asin() + (0.6_f64 / 4.0).asin());
        (model, round, [0.0, 2.0])
    }

    #[test]
    fn every_method_comes_back_to_where_it_began_as_fast_as_its_order_says() {
        let (model, round, start) = one_mass();
        let error = |run: &Run| (run.state[0] - start[0]).abs().max((run.state[1] - start[1]).abs());
        let accurate = dop853(&model, &start, 3.0 * round, 1e-12).unwrap();
        assert!(error(&accurate) < 1e-9 && accurate.impacts == 6, "{accurate:?}");
        let [coarse, fine] = [40, 160].map(|steps| rk4(&model, &start, 3.0 * round, steps));
        assert_eq!((coarse.impacts, fine.impacts), (6, 6));
        assert!(error(&fine) < error(&coarse) / 100.0 && error(&fine) < 1e-7, "{} {}", error(&coarse), error(&fine));
        let [coarse, fine] = [1000, 100_000].map(|steps| time_stepping(&model, &start, 3.0 * round, steps));
        assert_eq!(fine.impacts, 6);
        assert!(error(&fine) < error(&coarse) / 10.0 && error(&fine) < 1e-2, "{} {}", error(&coarse), error(&fine));
    }
}
