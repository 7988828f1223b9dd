//! What is followed: equations F(x, λ) = 0 in unknowns x and free parameters λ, and Newton's method for them.

use crate::branch_error::BranchError;
pub use crate::equations::linear::{Matrix, Vector, dot, unit, zeros};

/// Step of difference quotients in the parameters, relative: error and rounding balance. Newton's method needs no more
/// digits than that.
const DIFFERENCE: f64 = 1e-6;

/// Newton steps at most for one point; five are usual.
const STEPS: usize = 12;

/// Newton steps from one smaller than this on that shrink no more are rounding, if the equations hold to this many times the
/// bound of their rounding. Where they do not, as next to a resonance, the orbit itself changes over so little.
const NOISE: f64 = 1e-7;
const ROUNDING: f64 = 8.0;

/// The equations and their derivatives at a point.
#[derive(Debug, Clone)]
pub struct Evaluation<O, K> {
    /// What solves the equations, or nearly.
    pub orbit: O,
    /// F
    pub rows: Vector,
    /// ∂F/∂x, columns in units.
    pub matrix: Matrix,
    /// The same of the equations without the symmetry that is kept to, if one is.
    pub full: Option<Matrix>,
    /// What errors of the rows are worked out from.
    pub kept: K,
}

impl<O, K> Evaluation<O, K> {
    /// ∂F/∂x of the equations without any symmetry that is kept to.
    pub fn all(&self) -> &Matrix {
        self.full.as_ref().unwrap_or(&self.matrix)
    }
}

/// Orbits' equations as far as they are followed. z = (x, λ), each coordinate in its natural unit.
pub trait System {
    /// What solves them.
    type Orbit: Clone;
    /// What of an evaluation its errors are worked out from.
    type Kept;

    /// Number of unknowns x.
    fn size(&self) -> usize;

    /// Natural sizes of x and λ.
    fn units(&self) -> &[f64];

    /// Where the solution stands that all this was laid through.
    ///
    /// # Errors
    /// [`BranchError`].
    fn origin(&mut self) -> Result<Vector, BranchError>;

    /// F at `z`.
    fn rows(&mut self, z: &[f64]) -> Result<Vector, BranchError>;

    /// F and its derivatives at `z`.
    fn evaluate(&mut self, z: &[f64]) -> Result<Evaluation<Self::Orbit, Self::Kept>, BranchError>;

    /// Rounding of F; right after it was worked out.
    fn row_errors(&self, here: &Evaluation<Self::Orbit, Self::Kept>) -> Vector;

    /// Orbits worked out so far: the cost.
    fn evaluations(&self) -> usize;

    /// Whether the determinant of ∂F/∂z may change its sign between two orbits of one branch, at these values of its parameter.
    fn may_turn(&self, _from: (&Self::Orbit, f64), _to: (&Self::Orbit, f64)) -> bool {
        false
    }

    /// `to` − `from`, in units of the coordinates.
    fn chord(&self, from: &[f64], to: &[f64]) -> Vector {
        to.iter().zip(from).zip(self.units()).map(|((to, from), unit)| (to - from) / unit).collect()
    }

    /// ∂F/∂λ in units, by differences; one-sided at the end of the parameter's range.
    fn parameter_column(&mut self, z: &[f64], here: &[f64]) -> Result<Vector, BranchError> {
        let m = self.size();
        let step = DIFFERENCE * z[m].abs().max(1e-2 * self.units()[m]);
        let mut side = |sign: f64| {
            let mut moved = Vector::from(z);
            moved[m] += sign * step;
            self.rows(&moved).ok().map(|rows| (rows, moved[m]))
        };
        let (high, low) = (side(1.0), side(-1.0));
        if high.is_none() && low.is_none() {
            return Err(BranchError::NoConvergence);
        }
        let centre = || (Vector::from(here), z[m]);
        let ((high, top), (low, bottom)) = (high.unwrap_or_else(centre), low.unwrap_or_else(centre));
        let scale = self.units()[m] / (top - bottom);
        Ok(high.iter().zip(&low).map(|(high, low)| (high - low) * scale).collect())
    }

    /// ∂F/∂z at `z` above a row, if a parameter is free.
    fn bordered(
        &mut self,
        z: &[f64],
        here: &Evaluation<Self::Orbit, Self::Kept>,
        row: Option<&Vector>,
    ) -> Result<Matrix, BranchError> {
        let Some(row) = row else { return Ok(here.matrix.clone()) };
        Ok(here.matrix.bordered(&self.parameter_column(z, &here.rows)?, row))
    }

    /// Newton's method for F(z) = 0 and, if a parameter is free, ρ·(z − z₀) = 0 with the row ρ, in units, from z₀ = `predicted`; the orbit is no
    /// farther than `reach` from there. `known` says that z₀ itself is an orbit.
    fn newton(
        &mut self,
        predicted: &[f64],
        row: Option<&Vector>,
        reach: f64,
        known: bool,
    ) -> Result<Vector, BranchError> {
        let mut z = Vector::from(predicted);
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            let here = self.evaluate(&z)?;
            let exact = last < NOISE && self.holds(&here);
            let bordered = self.bordered(&z, &here, row)?;
            let mut right: Vector = here.rows.iter().map(|x| -x).collect();
            let moved = self.chord(predicted, &z);
            right.extend(row.map(|row| -dot(row, &moved)));
            let change = bordered.solve(&right).ok_or(BranchError::NoConvergence)?;
            let size = change.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            z.iter_mut().zip(&change).zip(self.units()).for_each(|((z, change), unit)| *z += change * unit);
            let moved = self.chord(predicted, &z).iter().map(|x| x.abs()).fold(0.0, f64::max);
            if moved.is_nan() || moved > reach {
                return Err(BranchError::NoConvergence);
            }
            // Far from rounding a step is the square of the last one; next to a bifurcation rounding is as large as this.
            if size <= 4.0 * f64::EPSILON || size >= 0.25 * last && exact || known && size < 1e-9 {
                return Ok(z);
            }
            last = size;
        }
        Err(BranchError::NoConvergence)
    }

    /// Whether the equations hold but for rounding; right after they were worked out.
    fn holds(&self, here: &Evaluation<Self::Orbit, Self::Kept>) -> bool {
        here.rows.iter().zip(self.row_errors(here)).all(|(row, error)| row.abs() <= ROUNDING * error)
    }
}
