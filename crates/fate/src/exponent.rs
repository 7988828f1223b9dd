//! The largest Lyapunov exponent of a breather, measured along it in the simulation: what ln|μ|/T says, by other means.
//!
//! A run that starts on an unstable breather leaves it by rounding, the sooner the faster a perturbation grows. So it is set back
//! onto the breather before that matters, while a tangent vector rides on: for as many periods as its direction needs to settle.
//! Every period does the same to it. Of three of its states in a row, x₀, x₁ and x₂, two multipliers are left that explain
//! x₂ = s x₁ − p x₀: their sum s and product p, which for a complex pair is |μ|². (The growth of a period alone would swing with the
//! phase of the pair for ever.)
//!
//! Where many multipliers have nearly the same modulus, as where a force drives a breather that radiates, no direction settles in any
//! reasonable time. Then all directions ride along at once, and the multipliers are those of what a period makes of them.

use thiserror::Error;
use vibrochain_breather::{BreatherError, Orbit};
use vibrochain_eventsim::{Outcome, Report, Simulation, Tangents};
use vibrochain_floquet::{DMatrix, eigenvalues};
use vibrochain_lattice::Stop;

use crate::follow::Track;
use crate::origin::{Origin, directions};
use crate::run::reach;

/// Once a perturbation has grown by e to this power the run is set back: rounding is then a hundredth of a millionth of the gap at
/// most, and what is not linear in it some 1e-13 of the growth.
const SET_BACK: f64 = 5.0;

/// Periods after which a run is set back in any case: rounding adds up where nothing grows.
const LONGEST: u64 = 100;

/// States that differ in direction by less are one: a single real multiplier is left.
const ALONE: f64 = 1e-7;

/// Where the estimate of all periods and that of half of them agree to this, more would not be seen: in the growth of a period.
const SETTLED: f64 = 1e-11;

/// Periods before which nothing is settled, whatever it looks like.
const LEAST: usize = 16;

/// An exponent measured along a breather.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Largest Lyapunov exponent, per unit of time.
    pub value: f64,
    /// How far the estimate has moved since half of the periods; of all directions at once, the difference of one period and two.
    pub error: f64,
    /// Periods of the breather that it took.
    pub periods: u64,
}

/// Why there is none.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Unmeasured {
    /// The motion of the orbit is not defined.
    #[error(transparent)]
    Breather(#[from] BreatherError),
    /// It cannot be a state of the simulation: a mass is behind its barrier.
    #[error("no simulation can start on this orbit: it is not physical")]
    NoStart,
    /// The run does not follow the breather, or grazes a barrier.
    #[error("the simulation does not follow this breather for one period")]
    NotFollowed,
    /// The stop flag was raised.
    #[error("interrupted")]
    Stopped,
}

/// Measures the exponent of `orbit` over at most so many of its periods. The answer depends on nothing else: `stop` only ends it.
///
/// # Errors
/// [`Unmeasured`].
///
/// ```
/// use vibrochain_lattice::Stop;
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_fate::measure;
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 0.8, 0.4)?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let measured = measure(orbit, 1000, &Stop::default())?;
/// assert!((measured.value - 2.797574412183362_f64.ln() / orbit.period()).abs() < 1e-9, "{measured:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure(orbit: &Orbit, periods: u64, stop: &Stop) -> Result<Measured, Unmeasured> {
    measure_from(&Origin::on(orbit)?, periods, stop)
}

pub(crate) fn measure_from(origin: &Origin, periods: u64, stop: &Stop) -> Result<Measured, Unmeasured> {
    let track = origin.track();
    let impacts: usize = track.instants.iter().map(Vec::len).sum();
    let mut states = [const { Vec::new() }; 3];
    let mut logs = [0.0; 3];
    let mut estimates: Vec<f64> = Vec::new();
    let started = || origin.run(None, stop).ok_or(Unmeasured::NoStart);
    let mut run = started()?;
    let mut tangents = run.tangents(1, 1).map_err(|_| Unmeasured::NoStart)?;
    let (mut since, mut grown, mut before) = (0, 0.0, 0);
    for period in 1..=periods.max(1) {
        if grown > SET_BACK || since == LONGEST {
            (run, since, grown, before) = (started()?, 0, 0.0, 0);
        }
        since += 1;
        // (An orbit's period is one or two of the force, or a few.)
        let until = run.time_of(since * track.span, 0.0);
        let Report { outcome, work, .. } =
            reach(&mut run, Some(&mut tangents), until, |_| {}).ok_or(Unmeasured::Stopped)?;
        let log = tangents.orthonormalise()[0];
        let state = tangents.vector(0).unwrap_or_default().concat();
        // (Its own units, not those in which the tangents have length 1.)
        let length = dot(&state, &state).sqrt();
        let log = log + length.ln();
        let followed = outcome == Outcome::TimeReached && work.impacts - before == impacts as u64 && work.sticks == 0;
        before = work.impacts;
        if !followed || tangents.has_grazed() || !log.is_finite() {
            return Err(Unmeasured::NotFollowed);
        }
        grown += log - logs[2];
        states.rotate_left(1);
        states[2] = state.into_iter().map(|x| x / length).collect();
        (logs[0], logs[1], logs[2]) = (logs[1], logs[2], log);
        if period < 3 {
            continue;
        }
        let of_period = leading(&states, [logs[1] - logs[0], logs[2] - logs[1]]);
        estimates.push(of_period);
        let moved = (of_period - estimates[estimates.len() / 2]).abs();
        if estimates.len() >= LEAST && moved <= SETTLED {
            break;
        }
    }
    let last = estimates.last().copied().unwrap_or(logs[2]);
    let late = &estimates[estimates.len() / 2..];
    let moved = late.iter().fold(0.0, |most: f64, estimate| most.max((estimate - last).abs()));
    let periods = estimates.len() as u64 + 2;
    let settled = estimates.len() >= LEAST && moved <= SETTLED;
    if !settled && let Some((tangents, count)) = directions(&run) {
        let measured = in_all_directions(&track, started()?, tangents, count);
        return measured.map(|measured| Measured { periods: periods + measured.periods, ..measured });
    }
    Ok(Measured { value: last / track.period, error: moved / track.period, periods })
}

/// The same from all directions at once: tangent vectors along each of them, over one period and over two.
fn in_all_directions(
    track: &Track,
    mut run: Simulation,
    mut tangents: Tangents,
    size: usize,
) -> Result<Measured, Unmeasured> {
    let mut logs = [0.0; 2];
    for (count, log) in (1..).zip(&mut logs) {
        let until = run.time_of(count * track.span, 0.0);
        let report = reach(&mut run, Some(&mut tangents), until, |_| {}).ok_or(Unmeasured::Stopped)?;
        if report.outcome != Outcome::TimeReached || tangents.has_grazed() {
            return Err(Unmeasured::NotFollowed);
        }
        let columns: Vec<Vec<f64>> = (0..size).filter_map(|i| Some(tangents.vector(i)?.concat())).collect();
        // A run makes its vectors orthonormal from time to time; after that they are no longer what the flow makes of the first ones.
        let whole = columns.len() == size && tangents.growth().iter().all(|log| *log == 0.0);
        if !whole {
            return Err(Unmeasured::NotFollowed);
        }
        let mut multipliers = Vec::new();
        eigenvalues(&DMatrix::from_fn(size, size, |i, j| columns[j][i]), &mut multipliers)
            .map_err(|_| Unmeasured::NotFollowed)?;
        *log = multipliers.iter().fold(0.0, |most: f64, z| most.max(z.norm())).ln() / count as f64;
    }
    Ok(Measured { value: logs[0] / track.period, error: (logs[1] - logs[0]).abs() / track.period, periods: 2 })
}

/// ln of the larger modulus of the two multipliers that explain three states of length 1 in a row, between which the growth was
/// e to the power `grown`.
fn leading([x0, x1, x2]: &[Vec<f64>; 3], grown: [f64; 2]) -> f64 {
    // In the plane of x₀ and x₁: x₁ = c x₀ + ρ n, x₂ = a x₀ + b n + a rest.
    let c = dot(x0, x1);
    let mut normal: Vec<f64> = x1.iter().zip(x0).map(|(x1, x0)| x1 - c * x0).collect();
    let rho = dot(&normal, &normal).sqrt();
    if rho < ALONE {
        return grown[1];
    }
    normal.iter_mut().for_each(|x| *x /= rho);
    let (a, b) = (dot(x0, x2), dot(&normal, x2));
    // In units of the growth: x₂ g₂ = s x₁ − (p/g₁) x₀.
    let sum = grown[1].exp() * b / rho;
    let product = (grown[0] + grown[1]).exp() * (b * c / rho - a);
    let discriminant = 0.25 * sum * sum - product;
    if discriminant < 0.0 { 0.5 * product.ln() } else { (0.5 * sum.abs() + discriminant.sqrt()).ln() }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::leading;

    /// Three states of a linear map with these two multipliers and nothing else.
    #[test]
    fn two_multipliers_are_found_real_or_complex() {
        let map = |[[a, b], [c, d]]: [[f64; 2]; 2], x: &[f64]| vec![a * x[0] + b * x[1], c * x[0] + d * x[1], 0.0];
        let complex = [[0.8, -0.9], [0.9, 0.8]];
        let real = [[1.2, 0.3], [0.0, -0.4]];
        let negative = [[-1.7, 0.3], [0.0, 0.4]];
        let single = [[1.5, 0.0], [0.0, 1.5]];
        for (matrix, modulus) in [(complex, 1.45_f64.sqrt()), (real, 1.2), (negative, 1.7), (single, 1.5)] {
            let mut states = vec![vec![0.6, 0.8, 0.0]];
            let mut grown = Vec::new();
            for _ in 0..2 {
                let mut next = map(matrix, states.last().unwrap());
                let length = next.iter().map(|x| x * x).sum::<f64>().sqrt();
                next.iter_mut().for_each(|x| *x /= length);
                grown.push(length.ln());
                states.push(next);
            }
            let found = leading(&states.try_into().unwrap(), [grown[0], grown[1]]);
            assert!((found - f64::ln(modulus)).abs() < 1e-14, "{matrix:?}: {found}");
        }
    }
}
