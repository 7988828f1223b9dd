//! From impacts nearby to an orbit.

use super::equations::{Equations, Point, System};
use super::error::StructureOrbitError;
use crate::equations::linear::Factors;

/// Steps at most: a start that leads anywhere takes a handful.
const STEPS: usize = 60;

/// A row below this part of its terms is rounding.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A row that no step makes smaller counts as solved up to this part of its terms: where these are far larger than their sum.
const STALLED: f64 = 1e-9;

impl Equations<'_> {
    /// The orbit that Newton's method leads to, with the system there.
    pub(super) fn solve(&self, mut point: Point) -> Result<(Point, System), StructureOrbitError> {
        let mut best: Option<(f64, Point, System)> = None;
        for _ in 0..STEPS {
            let system = self.system(&point)?;
            let violation = (system.rows.iter().zip(&system.sizes))
                .map(|(row, size)| if *size > 0.0 { row.abs() / size } else { row.abs() })
                .fold(0.0, f64::max);
            if violation.is_nan() {
                break;
            }
            let improved = best.as_ref().is_none_or(|(least, ..)| violation < *least);
            let stalled = best.as_ref().is_some_and(|(least, ..)| !improved && *least < STALLED);
            let factors = Factors::new(system.jacobian.clone());
            let rows = system.rows.clone();
            if improved {
                best = Some((violation, point.clone(), system));
            }
            if stalled || violation < ROUNDING * 1e-2 {
                break;
            }
            let Some(factors) = factors else { break };
            let step = factors.solve(&rows);
            if step.iter().any(|x| !x.is_finite()) {
                break;
            }
            self.take(&mut point, &step);
        }
        let (violation, point, system) = best.ok_or(StructureOrbitError::NotConverged { violation: f64::NAN })?;
        if violation < STALLED { Ok((point, system)) } else { Err(StructureOrbitError::NotConverged { violation }) }
    }

    /// One step back along the unknowns, shortened where a time would move by more than a part of the period.
    fn take(&self, point: &mut Point, step: &[f64]) {
        let (n, period) = (point.strikes.len(), self.period());
        let times = &step[n..2 * n - 1 + usize::from(self.forced)];
        let longest = times.iter().map(|x| x.abs()).fold(0.0, f64::max);
        let by = if longest > 0.1 * period { 0.1 * period / longest } else { 1.0 };
        for (i, strike) in point.strikes.iter_mut().enumerate() {
            strike.impulse -= by * step[i];
            if i > 0 {
                strike.time -= by * step[n + i - 1];
            }
        }
        if self.forced {
            point.psi -= by * step[2 * n - 1];
        }
        let first = step.len() - point.offsets.len();
        point.offsets.iter_mut().zip(&step[first..]).for_each(|(offset, step)| *offset -= by * step);
    }
}
