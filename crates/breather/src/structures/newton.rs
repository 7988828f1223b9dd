//! From impacts nearby to an orbit.

use super::equations::{Equations, System};
use super::point::Point;
use crate::equations::linear::{Factors, Matrix, Vector};
use crate::error::BreatherError;

/// Steps at most: a start that leads anywhere takes a handful.
const STEPS: usize = 60;

/// Rows below this part of their terms are as small as rounding lets them be: no orbit is found where steps end above it.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Rows of a closed form are as small as this part of their terms, a few roundings, unless something is amiss.
const EXACT: f64 = 4.0 * f64::EPSILON;

/// A step that leaves more than this part of the rows, once they are rounding, is followed by none.
const IMPROVED: f64 = 0.5;

impl Equations<'_> {
    /// The orbit that Newton's method leads to, with the system there.
    pub(super) fn solve(&self, point: Point) -> Result<(Point, System), BreatherError> {
        self.solve_to(point, 0.0)
    }

    /// The same from a closed form or a zero: where rounding alone is left of its rows, it is the orbit.
    pub(super) fn solve_exact(&self, point: Point) -> Result<(Point, System), BreatherError> {
        self.solve_to(point, EXACT)
    }

    fn solve_to(&self, mut point: Point, enough: f64) -> Result<(Point, System), BreatherError> {
        let mut best: Option<(f64, Point, System)> = None;
        for _ in 0..STEPS {
            let system = self.system(&point)?;
            let violation = (system.rows.iter().zip(&system.sizes))
                .map(|(row, size)| if *size > 0.0 { row.abs() / size } else { row.abs() })
                .fold(0.0, f64::max);
            if violation.is_nan() {
                break;
            }
            let least = best.as_ref().map_or(f64::INFINITY, |(least, ..)| *least);
            let improved = violation < least;
            let last = violation <= enough || (least < ROUNDING && violation >= IMPROVED * least);
            let step = if last { None } else { Factors::new(system.jacobian.clone()) };
            let step = step.map(|factors| factors.solve(&system.rows));
            if improved {
                best = Some((violation, point.clone(), system));
            }
            let Some(step) = step else { break };
            if step.iter().any(|x| !x.is_finite()) {
                break;
            }
            self.take(&mut point, &step);
        }
        let (violation, point, system) = best.ok_or(BreatherError::NotConverged { violation: f64::NAN })?;
        if violation < ROUNDING { Ok((point, system)) } else { Err(BreatherError::NotConverged { violation }) }
    }

    /// The same point with offsets that bring the impacts to their barriers as well as they can.
    pub(super) fn with_offsets(&self, mut point: Point) -> Result<Point, BreatherError> {
        if self.rigid.is_empty() {
            return Ok(point);
        }
        let system = self.system(&point)?;
        let count = self.rigid.len();
        let shape = |k: usize, i: usize| self.rigid[k].shapes[point.strikes[i].contact];
        let matrix = Matrix::from_fn(count, |k, l| (0..point.strikes.len()).map(|i| shape(k, i) * shape(l, i)).sum());
        let right: Vector =
            (0..count).map(|k| (0..point.strikes.len()).map(|i| -shape(k, i) * system.rows[i]).sum()).collect();
        let moves = matrix.solve(&right).ok_or(BreatherError::Unbalanced)?;
        point.offsets.iter_mut().zip(&moves).for_each(|(offset, by)| *offset += by);
        Ok(point)
    }

    /// One step back along the unknowns, shortened where a time would move by more than a part of the period.
    pub(super) fn take(&self, point: &mut Point, step: &[f64]) {
        let (n, period) = (point.strikes.len(), self.period());
        let times = &step[self.times(n)];
        let longest = times.iter().map(|x| x.abs()).fold(0.0, f64::max);
        let by = if longest > 0.1 * period { 0.1 * period / longest } else { 1.0 };
        for (i, strike) in point.strikes.iter_mut().enumerate() {
            strike.impulse -= by * step[i];
            if let Some(place) = self.time(n, i) {
                strike.time -= by * step[place];
            }
        }
        if self.forced {
            point.psi -= by * step[2 * n - 1];
        } else if self.self_excited {
            point.period -= by * step[2 * n - 1];
        }
        let first = step.len() - point.offsets.len();
        point.offsets.iter_mut().zip(&step[first..]).for_each(|(offset, step)| *offset -= by * step);
    }
}
