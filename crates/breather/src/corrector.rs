//! From near a branch onto it: F and its derivatives, and Newton's method along a tangent.

use smallvec::SmallVec;

use crate::branch::{Branch, BranchError, BranchPoint, DIFFERENCE};
use crate::equations::{Equations, Errors};
use crate::error::BreatherError;
use crate::linear::{Matrix, Vector, dot, unit, zeros};
use crate::orbit::Orbit;

/// Newton steps at most for one point; five are usual.
const STEPS: usize = 12;

/// Newton steps from one smaller than this on that shrink no more are rounding, if the equations hold to this many times the
/// bound of their rounding. Where they do not, as next to a resonance, the orbit itself changes over so little.
const NOISE: f64 = 1e-7;
const ROUNDING: f64 = 8.0;

/// A point may be this part of the step away from where the tangent pointed; farther is another branch or too long a
/// step.
const BEND: f64 = 0.35;

/// The equations and their derivatives at a point.
pub(crate) struct Evaluation {
    orbit: Orbit,
    places: Places,
    pub(crate) rows: Vector,
    /// ∂F/∂x, columns in units.
    pub(crate) matrix: Matrix,
    full_determinant: f64,
}

/// Which impact of the orbit each of the word's is.
type Places = SmallVec<[usize; 2]>;

impl Branch {
    /// The orbit with these coordinates, whatever its residual, and its impulse response in the finder.
    fn assemble(&mut self, z: &[f64]) -> Result<(Orbit, Places), BranchError> {
        let model = self.origin.model().with(self.free, z[self.reduction.size()]).map_err(BreatherError::from)?;
        self.evaluations += 1;
        self.finder.prepare(&model, model.omega() / f64::from(self.template.force_periods()))?;
        let (response, motion) = (&self.finder.response, &mut self.finder.motion);
        // What no coordinate moves keeps its part of the period.
        let (period, fractions) = (response.period(), &self.fractions);
        let psi = self.reduction.psi.unwrap_or(0.0) * model.period();
        self.template.hold(|i| fractions[i] * period, psi);
        let mut full = zeros(self.unknowns.size());
        for (i, fraction) in fractions.iter().enumerate() {
            if let Some(place) = self.unknowns.time(i) {
                full[place] = fraction * period;
            }
        }
        if let Some(place) = self.unknowns.psi() {
            full[place] = psi;
        }
        self.reduction.expand(z, &mut full);
        let draft = self.template.draft(&self.unknowns, &full, &model, response);
        let (draft, places) = draft.ok_or(BranchError::NoConvergence)?;
        Ok((Orbit::assemble(&model, response, motion, draft)?, places))
    }

    fn equations<'a>(&'a self, orbit: &'a Orbit, places: &Places) -> Equations<'a> {
        Equations::ordered(orbit, &self.finder.response, self.unknowns, places.clone())
    }

    /// F at `z`.
    fn rows(&mut self, z: &[f64]) -> Result<Vector, BranchError> {
        let (orbit, places) = self.assemble(z)?;
        Ok(self.reduction.rows(&self.equations(&orbit, &places).residuals()))
    }

    /// F and its derivatives at `z`; the finder is left with that orbit's impulse response.
    pub(crate) fn evaluate(&mut self, z: &[f64]) -> Result<Evaluation, BranchError> {
        let (orbit, places) = self.assemble(z)?;
        let equations = self.equations(&orbit, &places);
        let rows = self.reduction.rows(&equations.residuals());
        let mut full = equations.jacobian();
        for i in 0..full.size() {
            full.row_mut(i).iter_mut().zip(&self.full_units).for_each(|(entry, unit)| *entry *= unit);
        }
        let matrix = self.reduction.matrix(&full);
        let full_determinant = full.determinant();
        Ok(Evaluation { orbit, places, rows, matrix, full_determinant })
    }

    /// `z`, an orbit, with this unit tangent.
    pub(crate) fn point(&mut self, z: &[f64], tangent: Vector) -> Result<BranchPoint, BranchError> {
        let here = self.evaluate(z)?;
        Ok(BranchPoint {
            orbit: here.orbit,
            coordinates: z.into(),
            tangent,
            full_determinant: here.full_determinant,
            orientation: 0.0,
            parameter_error: f64::INFINITY,
        })
    }

    /// ∂F/∂λ in units, by differences; one-sided at the end of the parameter's range.
    pub(crate) fn parameter_column(&mut self, z: &[f64], here: &[f64]) -> Result<Vector, BranchError> {
        let m = self.reduction.size();
        let step = DIFFERENCE * z[m].abs().max(1e-2 * self.units[m]);
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
        let scale = self.units[m] / (top - bottom);
        Ok(high.iter().zip(&low).map(|(high, low)| (high - low) * scale).collect())
    }

    /// Newton's method for F(z) = 0, τ·(z − z₀) = σ. `known` says that z₀ itself is an orbit.
    pub(crate) fn correct(
        &mut self,
        anchor: &[f64],
        tangent: &[f64],
        length: f64,
        known: bool,
    ) -> Result<BranchPoint, BranchError> {
        let units = self.units.clone();
        let predicted: Vector = (0..units.len()).map(|i| anchor[i] + units[i] * tangent[i] * length).collect();
        let mut z = predicted.clone();
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            let here = self.evaluate(&z)?;
            let exact = last < NOISE && self.holds(&here);
            let column = self.parameter_column(&z, &here.rows)?;
            let mut right: Vector = here.rows.iter().map(|x| -x).collect();
            right.push(length - (0..units.len()).map(|i| tangent[i] * (z[i] - anchor[i]) / units[i]).sum::<f64>());
            let bordered = here.matrix.bordered(&column, tangent);
            let change = bordered.solve(&right).ok_or(BranchError::NoConvergence)?;
            let size = change.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            (0..units.len()).for_each(|i| z[i] += change[i] * units[i]);
            let moved = (0..units.len()).map(|i| ((z[i] - predicted[i]) / units[i]).abs()).fold(0.0, f64::max);
            let farthest = if length == 0.0 { 1e-2 } else { BEND * length.abs() + 1e-9 };
            if moved.is_nan() || moved > farthest {
                return Err(BranchError::NoConvergence);
            }
            // Far from rounding a step is the square of the last one; next to a bifurcation rounding is as large as this.
            if size <= 4.0 * f64::EPSILON || size >= 0.25 * last && exact || known && size < 1e-9 {
                return self.finish(&z, tangent);
            }
            last = size;
        }
        Err(BranchError::NoConvergence)
    }

    /// Rounding of F; right after the orbit was worked out.
    fn row_errors(&self, here: &Evaluation) -> Vector {
        self.reduction.rows(&self.equations(&here.orbit, &here.places).row_errors(Errors::Evaluated))
    }

    /// Whether the equations hold but for rounding; right after they were worked out.
    fn holds(&self, here: &Evaluation) -> bool {
        here.rows.iter().zip(self.row_errors(here)).all(|(row, error)| row.abs() <= ROUNDING * error)
    }

    /// The point at `z`, with a tangent that goes the way `towards` does.
    pub(crate) fn finish(&mut self, z: &[f64], towards: &[f64]) -> Result<BranchPoint, BranchError> {
        let m = self.reduction.size();
        let here = self.evaluate(z)?;
        let errors = self.row_errors(&here);
        let column = self.parameter_column(z, &here.rows)?;
        let last = unit(m + 1, m);
        let tangent = here.matrix.bordered(&column, towards).solve(&last).ok_or(BranchError::NoConvergence)?;
        let norm = dot(&tangent, &tangent).sqrt();
        let tangent: Vector = tangent.iter().map(|x| x / norm).collect();
        // The parameter's row of the inverse, bordered by the tangent itself.
        let bordered = here.matrix.bordered(&column, &tangent);
        let carried = |row: Vector| row.iter().zip(&errors).map(|(row, error)| row.abs() * error).sum::<f64>();
        let error = bordered.transposed().solve(&last).map_or(f64::INFINITY, carried);
        Ok(BranchPoint {
            orbit: here.orbit,
            coordinates: z.into(),
            tangent,
            full_determinant: here.full_determinant,
            orientation: bordered.determinant().signum(),
            parameter_error: error * self.units[m],
        })
    }
}
