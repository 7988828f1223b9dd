//! The orbit's equations F in its unknowns x and the free parameters, their derivatives, and Newton's method from near an orbit onto it.

use smallvec::SmallVec;
use vibrochain_lattice::{Model, Parameter};

use crate::equations::linear::{Matrix, Vector, dot, zeros};
use crate::equations::unknowns::{Template, Unknowns};
use crate::equations::{Equations, Errors};
use crate::error::BranchError;
use crate::error::BreatherError;
use crate::orbit::Orbit;
use crate::search::finder::Finder;
use crate::tracer::reduction::{Reduction, SYMMETRIC};

/// Step of difference quotients in the parameters, relative: error and rounding balance. Newton's method needs no more
/// digits than that.
const DIFFERENCE: f64 = 1e-6;

/// Newton steps at most for one point; five are usual.
const STEPS: usize = 12;

/// Newton steps from one smaller than this on that shrink no more are rounding, if the equations hold to this many times the
/// bound of their rounding. Where they do not, as next to a resonance, the orbit itself changes over so little.
const NOISE: f64 = 1e-7;
const ROUNDING: f64 = 8.0;

/// The equations of an orbit, in its unknowns and the parameters that are free.
#[derive(Debug, Clone)]
pub(crate) struct Continuation {
    pub(crate) finder: Finder,
    pub(crate) origin: Orbit,
    /// One along a branch, two on a surface.
    pub(crate) free: SmallVec<[Parameter; 2]>,
    /// Another parameter, and its ratio to the first of these, which it keeps.
    pub(crate) tied: Option<(Parameter, f64)>,
    /// The origin's word, and its times in periods.
    template: Template,
    fractions: Vector,
    pub(crate) unknowns: Unknowns,
    pub(crate) reduction: Reduction,
    /// Natural sizes of all unknowns, and of the coordinates with the parameters.
    full_units: Vector,
    pub(crate) units: Vector,
    pub(crate) evaluations: usize,
}

/// What changes of impulses are compared to: an impact that grazes leaves the others, or what a mass of the ring's own speed would have.
fn impulse_unit(orbit: &Orbit) -> f64 {
    orbit.strength().max(0.1 * orbit.model().omega())
}

/// The equations and their derivatives at a point.
pub(crate) struct Evaluation {
    pub(crate) orbit: Orbit,
    places: Places,
    pub(crate) rows: Vector,
    /// ∂F/∂x, columns in units.
    pub(crate) matrix: Matrix,
    pub(crate) full_determinant: f64,
}

/// Which impact of the orbit each of the word's is.
type Places = SmallVec<[usize; 2]>;

impl Continuation {
    /// The equations of `orbit` with `free` parameters, each with its unit: the length along it that counts like a change of order 1 of
    /// the orbit.
    pub(crate) fn new(
        orbit: &Orbit,
        free: &[(Parameter, f64)],
        unknowns: Unknowns,
        reduction: Reduction,
    ) -> Result<Self, BranchError> {
        let model = orbit.model();
        let mut finder = Finder::new(model.chain().sites());
        finder.prepare(model, orbit.frequency())?;
        let mut full_units = unknowns.units(orbit, &finder.response, impulse_unit(orbit));
        for place in unknowns.times().chain(unknowns.psi()) {
            full_units[place] = model.period() / std::f64::consts::TAU;
        }
        let mut units: Vector = (0..reduction.size()).map(|i| full_units[reduction.leading(i)]).collect();
        units.extend(free.iter().map(|(_, unit)| unit.abs().max(f64::MIN_POSITIVE)));
        let fraction = |time: f64| {
            let fraction = time / orbit.period();
            if (fraction - 0.5).abs() <= SYMMETRIC { 0.5 } else { fraction }
        };
        let fractions = orbit.impacts().iter().map(|impact| fraction(impact.time)).collect();
        let (origin, template) = (orbit.clone(), Template::of(orbit));
        let free = free.iter().map(|(parameter, _)| *parameter).collect();
        let tied = None;
        Ok(Self {
            finder,
            origin,
            free,
            tied,
            template,
            fractions,
            unknowns,
            reduction,
            full_units,
            units,
            evaluations: 0,
        })
    }

    /// Measures impulses, and what they hold up, by those of `orbit` from here on.
    pub(crate) fn rescale(&mut self, orbit: &Orbit) {
        let own = self.unknowns.units(orbit, &self.finder.response, impulse_unit(orbit));
        let which = ..=self.unknowns.impacts;
        self.full_units[which].copy_from_slice(&own[which]);
        for i in 0..self.reduction.size() {
            self.units[i] = self.full_units[self.reduction.leading(i)];
        }
    }

    /// Where an orbit of the origin's word stands.
    pub(crate) fn coordinates(&mut self, orbit: &Orbit) -> Result<Vector, BranchError> {
        self.finder.prepare(orbit.model(), orbit.frequency())?;
        let full = self.unknowns.read(orbit, &self.finder.response);
        let mut z: Vector = (0..self.reduction.size()).map(|i| full[self.reduction.leading(i)]).collect();
        z.extend(self.free.iter().map(|&parameter| orbit.model().get(parameter)));
        Ok(z)
    }

    /// `to` − `from`, in units of the coordinates.
    pub(crate) fn chord(&self, from: &[f64], to: &[f64]) -> Vector {
        to.iter().zip(from).zip(&self.units).map(|((to, from), unit)| (to - from) / unit).collect()
    }

    /// The model with these values of the free parameters.
    pub(crate) fn model(&self, values: &[f64]) -> Result<Model, BreatherError> {
        let tied = self.tied.map(|(parameter, ratio)| (parameter, ratio * values[0]));
        let all = self.free.iter().copied().zip(values.iter().copied()).chain(tied);
        let set = |model: Model, (parameter, value)| model.with(parameter, value);
        Ok(all.into_iter().try_fold(*self.origin.model(), set)?)
    }

    /// The orbit with these coordinates, whatever its residual, and its impulse response in the finder.
    fn assemble(&mut self, z: &[f64]) -> Result<(Orbit, Places), BranchError> {
        let model = self.model(&z[self.reduction.size()..])?;
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
        self.reduction.expand(z, period, &mut full);
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

    /// ∂F/∂λ in units, one of the free parameters, by differences; one-sided at the end of the parameter's range.
    pub(crate) fn parameter_column(&mut self, z: &[f64], here: &[f64], which: usize) -> Result<Vector, BranchError> {
        let m = self.reduction.size() + which;
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

    /// ∂F/∂z at `z` above as many rows as parameters are free.
    pub(crate) fn bordered(&mut self, z: &[f64], here: &Evaluation, rows: &[Vector]) -> Result<Matrix, BranchError> {
        let (mut matrix, m) = (here.matrix.clone(), self.reduction.size());
        for (which, row) in rows.iter().enumerate() {
            let mut column = self.parameter_column(z, &here.rows, which)?;
            column.extend(rows[..which].iter().map(|above| above[m + which]));
            matrix = matrix.bordered(&column, row);
        }
        Ok(matrix)
    }

    /// Newton's method for F(z) = 0, ρ·(z − z₀) = 0 for each of the rows ρ, in units, from z₀ = `predicted`; the orbit is no farther than
    /// `reach` from there. `known` says that z₀ itself is an orbit.
    pub(crate) fn newton(
        &mut self,
        predicted: &[f64],
        rows: &[Vector],
        reach: f64,
        known: bool,
    ) -> Result<Vector, BranchError> {
        let mut z = Vector::from(predicted);
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            let here = self.evaluate(&z)?;
            let exact = last < NOISE && self.holds(&here);
            let bordered = self.bordered(&z, &here, rows)?;
            let mut right: Vector = here.rows.iter().map(|x| -x).collect();
            let moved = self.chord(predicted, &z);
            right.extend(rows.iter().map(|row| -dot(row, &moved)));
            let change = bordered.solve(&right).ok_or(BranchError::NoConvergence)?;
            let size = change.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            z.iter_mut().zip(&change).zip(&self.units).for_each(|((z, change), unit)| *z += change * unit);
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

    /// Rounding of F; right after the orbit was worked out.
    pub(crate) fn row_errors(&self, here: &Evaluation) -> Vector {
        self.reduction.rows(&self.equations(&here.orbit, &here.places).row_errors(Errors::Evaluated))
    }

    /// Whether the equations hold but for rounding; right after they were worked out.
    fn holds(&self, here: &Evaluation) -> bool {
        here.rows.iter().zip(self.row_errors(here)).all(|(row, error)| row.abs() <= ROUNDING * error)
    }
}
