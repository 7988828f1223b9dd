//! From all multipliers to a verdict that knows its error.
//!
//! Where no energy is lost a zero is one of ν = ½(μ + 1/μ), and f is real for real ν: a zero in (−1, 1) that has no other within its
//! error is real, and its pair of multipliers on the circle exactly. Several together stay there where the Krein form is definite on
//! their space. What is left open is one next to ±1, or others that may have met.

use nalgebra::Complex;
use vibrochain_breather::{BlochEquations, ImpactError, Together};

use super::clusters::zeros;
use super::function::SpectralFunction;
use super::refine::{DataError, Origin};
use super::solve::{Zeros, is_reciprocal};
use super::zero::Zero;
use crate::verdict::{Tolerance, Verdict};
use crate::zeros::{SecularError, excess};

/// Room for what estimates of errors leave out where an answer hangs on them.
const ROOM: f64 = 4.0;

/// How far the multiplier of an orbit's own derivative may be off where the orbit's errors are left out: the root of rounding, with room.
const AS_IT_STANDS: f64 = 1e-6;

/// Verdict and multipliers of equations; `data` are the errors of what the orbit brings along.
pub(crate) fn told(
    equations: &BlochEquations,
    conservative: bool,
    data: &[Origin],
    tolerance: Tolerance,
) -> Result<(Verdict, Vec<Complex<f64>>), SecularError> {
    let Zeros { list, reciprocal, .. } = certified(zeros(equations, conservative, data))?;
    let mut multipliers = Vec::with_capacity(2 * list.len());
    let verdict = judged(&list, reciprocal, tolerance, &mut multipliers);
    Ok((verdict, multipliers))
}

/// The same of a self-excited orbit, which may begin at any time though energy is lost: its own derivative has the multiplier 1, a simple one,
/// which is left out. `drift` is what the error of its period makes of multipliers, relative.
pub(crate) fn told_of_cycle(
    equations: &BlochEquations,
    data: &[Origin],
    drift: f64,
    tolerance: Tolerance,
) -> Result<(Verdict, Vec<Complex<f64>>), SecularError> {
    let Zeros { mut list, .. } = certified(zeros(equations, false, data))?;
    list.iter_mut().for_each(|zero| zero.error += drift * zero.z.norm());
    let off = |zero: &Zero| (zero.z - 1.0).norm();
    let nearest = (0..list.len()).min_by(|&i, &j| off(&list[i]).total_cmp(&off(&list[j])));
    // The orbit's own errors move the trivial multiplier from 1; without them (no data) the distance that they may cause is allowed for.
    let reach = |i: usize| if data.is_empty() { AS_IT_STANDS } else { ROOM * list[i].error };
    let own = nearest.filter(|&i| off(&list[i]) <= reach(i)).ok_or(SecularError::Inconsistent)?;
    list.remove(own);
    let mut multipliers = Vec::with_capacity(list.len());
    let verdict = judged(&list, false, tolerance, &mut multipliers);
    Ok((verdict, multipliers))
}

/// Zeros that are all there and told apart.
fn certified(zeros: Zeros) -> Result<Zeros, SecularError> {
    if zeros.certified {
        return Ok(zeros);
    }
    let (found, wanted) = (zeros.list.iter().filter(|zero| zero.apart).count(), zeros.list.len());
    Err(if found == wanted { SecularError::Inconsistent } else { SecularError::Incomplete { found, wanted } })
}

/// What zeros say, of which the multipliers go to `multipliers`.
pub(crate) fn judged(
    list: &[Zero],
    reciprocal: bool,
    tolerance: Tolerance,
    multipliers: &mut Vec<Complex<f64>>,
) -> Verdict {
    if !reciprocal {
        multipliers.extend(list.iter().map(|zero| zero.z));
        return dissipative(list, tolerance);
    }
    let mut judge = Reciprocal::default();
    for zero in list {
        multipliers.extend(judge.take(zero));
    }
    judge.verdict(multipliers.first().copied(), tolerance)
}

/// The verdict alone, of which the multipliers that lead say enough where there are losses.
pub(crate) fn verdict(
    equations: &BlochEquations,
    conservative: bool,
    data: &[Origin],
    tolerance: Tolerance,
) -> Result<Verdict, SecularError> {
    if !conservative && !is_reciprocal(equations) {
        let leading = SpectralFunction::new(equations, false).leading(data);
        if let Some(list) = leading {
            return Ok(dissipative(&list, tolerance));
        }
    }
    told(equations, conservative, data, tolerance).map(|(verdict, _)| verdict)
}

/// The largest modulus, with room for others that may be larger.
fn dissipative(list: &[Zero], tolerance: Tolerance) -> Verdict {
    let all = || list.iter().map(|zero| (zero.z, excess(zero.z), zero.error));
    let Some((leading, excess, error)) = all().max_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Verdict::on_circle(None);
    };
    let error = all().map(|(_, other, reach)| other + reach - excess).fold(error, f64::max);
    // Of two conjugates the one above the real axis.
    let leading = Complex::new(leading.re, if leading.im.abs() <= error { 0.0 } else { leading.im.abs() });
    Verdict::of_excess(leading, excess, error, tolerance)
}

/// What is known of multipliers that come in pairs.
#[derive(Debug, Default)]
struct Reciprocal {
    /// The one that is surely the farthest outside the circle, with excess and error.
    leading: Option<Outside>,
    /// The one that may be the farthest outside of those that may have left it, and how far it is then.
    open: Option<(Complex<f64>, f64)>,
}

/// A multiplier that is surely outside the circle.
#[derive(Debug, Clone, Copy)]
struct Outside {
    value: Complex<f64>,
    excess: f64,
    error: f64,
}

impl Reciprocal {
    /// Takes note of a zero; its multipliers.
    fn take(&mut self, zero: &Zero) -> [Complex<f64>; 2] {
        let mut nu = zero.nu;
        if zero.held && nu.below < 0.0 && nu.above > 0.0 {
            nu.im = 0.0;
            return nu.multipliers();
        }
        if nu.below.max(-nu.above) > 0.0 && nu.im.abs() <= zero.error {
            // Two that are as good as one leave the real axis by rounding alone.
            nu.im = 0.0;
        }
        let excess = nu.excess();
        let reach = ROOM * zero.error;
        let beyond = nu.below.max(-nu.above).max(0.0);
        let error = nu.excess_error(excess, if zero.settled { zero.error } else { reach });
        if beyond.hypot(nu.im) > reach {
            if self.leading.is_none_or(|other| excess > other.excess) {
                self.leading = Some(Outside { value: nu.multipliers()[0], excess, error });
            }
        } else if !zero.settled || zero.held || nu.im != 0.0 || nu.below.max(-nu.above) >= -reach {
            let farthest = excess + nu.excess_error(excess, reach);
            if self.open.is_none_or(|(_, other)| farthest > other) {
                self.open = Some((nu.multipliers()[0], farthest));
            }
        }
        nu.multipliers()
    }

    fn verdict(&self, any: Option<Complex<f64>>, tolerance: Tolerance) -> Verdict {
        let above = |value: Complex<f64>| Complex::new(value.re, value.im.abs());
        match (self.leading, self.open) {
            (Some(Outside { value, excess, error }), other) => {
                // One that may lead instead is as good.
                let error = other.map_or(error, |(_, farthest)| error.max(farthest - excess));
                Verdict::of_excess(above(value), excess, error, tolerance)
            }
            (None, Some((value, farthest))) => {
                Verdict::unsettled(above(value), excess(value).max(0.0), farthest, tolerance)
            }
            (None, None) => Verdict::on_circle(any),
        }
    }
}

/// What errors of the orbit's own data do to its equations, by origin.
pub(crate) fn origins(equations: &BlochEquations, known: &[Together]) -> Vec<Origin> {
    let impacts = equations.impacts();
    // Impulses are units of times: of g″⁻/(ωP) alone they count. Only differences of times do.
    let of_impact = |(i, known): (usize, &ImpactError)| {
        let pull = impacts[i].acceleration_before / impacts[i].impulse;
        let slide = (known.acceleration - pull * known.impulse) / (equations.omega() * impacts[i].impulse);
        let share = known.impulse / impacts[i].impulse;
        DataError { slide, time: if i == 0 { 0.0 } else { known.time }, share }
    };
    // What rounding makes of an acceleration alone is not felt where it is not asked for.
    let given = equations.slide_errors().is_none();
    let felt = |origin: &&Together| given || origin.iter().any(|error| error.impulse != 0.0 || error.time != 0.0);
    let mut origins: Vec<Origin> = Vec::with_capacity(known.len() + 2 * impacts.len());
    let asked = known.iter().filter(felt);
    origins.extend(asked.map(|origin| origin.iter().enumerate().map(of_impact).collect::<Origin>()));
    // And both are rounded.
    for (i, impact) in impacts.iter().enumerate() {
        let mut origin: Origin = impacts.iter().map(|_| DataError::default()).collect();
        let slide = 4.0 * f64::EPSILON * impact.acceleration_before / (equations.omega() * impact.impulse);
        origin[i].slide = if given { slide } else { 0.0 };
        origins.push(origin.clone());
        let time = if i == 0 { 0.0 } else { f64::EPSILON * equations.kernel().period() };
        origin[i] = DataError { slide: 0.0, time, share: 0.0 };
        origins.push(origin);
    }
    origins
}

#[cfg(test)]
mod tests {
    use super::super::random_equations;
    use super::*;

    /// A datum of an orbit that is off, a time, an impulse or an acceleration, moves the leading multiplier by what is told, and rounding is far
    /// less than that.
    #[test]
    fn errors_of_times_impulses_and_accelerations_are_carried_to_the_verdict() {
        let mut random = vibrochain_testkit::Random(77);
        let (mut checked, mut felt) = ([0; 3], [0; 3]);
        for round in 0..240 {
            let equations = random_equations(&mut random, 0.5);
            let (n, kind) = (equations.impacts().len(), round % 3);
            let i = random.below(n);
            if kind == 0 && i == 0 {
                // Times are counted from the first impact on.
                continue;
            }
            let off = 1e-8;
            let mut impacts = equations.impacts().to_vec();
            let mut origin: Together = impacts.iter().map(|_| ImpactError::default()).collect();
            match kind {
                0 => (impacts[i].time, origin[i].time) = (impacts[i].time + off, off),
                1 => (impacts[i].impulse, origin[i].impulse) = (impacts[i].impulse + off, off),
                _ => {
                    (impacts[i].acceleration_before, origin[i].acceleration) =
                        (impacts[i].acceleration_before + off, off)
                }
            }
            let moved = BlochEquations::new(equations.kernel().clone(), impacts);
            let data = origins(&equations, &[origin]);
            let ask = |equations: &BlochEquations, data: &[Origin]| {
                told(equations, false, data, Tolerance::Rounding).map(|(verdict, _)| verdict)
            };
            let (Ok(known), Ok(exact), Ok(there)) = (ask(&equations, &data), ask(&equations, &[]), ask(&moved, &[]))
            else {
                continue;
            };
            let apart = (there.excess() - exact.excess()).abs();
            let room = 1e-4 * apart + exact.resolution + there.resolution;
            assert!(apart <= known.resolution + room, "{kind} {i}: {apart:e} {:e} {equations:?}", known.resolution);
            checked[kind] += 1;
            felt[kind] += usize::from(apart > 1e3 * exact.resolution && known.resolution < 1e3 * apart);
        }
        assert!(
            checked.iter().all(|count| *count > 20) && felt.iter().all(|count| *count > 10),
            "{checked:?} {felt:?}"
        );
    }
}
