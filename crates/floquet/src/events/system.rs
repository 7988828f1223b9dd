//! An event as a solution: the orbit's equations, and a test function of it that vanishes.
//!
//! With one number free these are as many equations as unknowns, an event of a branch. With two it is a curve, which the one
//! tracer follows. Derivatives of the test function are differences.

use smallvec::SmallVec;
use vibrochain_breather::system::{Evaluation, Matrix, System, Vector, unit};
use vibrochain_breather::{BranchError, ContactOrbit, Continuation, SolutionPoint};

use super::poles::{room, without_poles};
use super::rounding::{ROUNDING, rounding};
use super::test_function::Test;
use super::unfolding::Unfolding;

/// Steps of differences of a test function, in units: error and rounding balance.
const DIFFERENCE: f64 = 1e-6;

/// Steps of differences by a number that is free, relative, at most; next to a resonance no more than this part of what multipliers are off it, so
/// that none leads beyond.
const LONGEST: f64 = 1e-5;
const SHARE: f64 = 0.01;

/// The unit of a mark: θ, or a part of the period.
const MARK: f64 = 0.1;

/// The equations of an orbit with a test function. z holds the orbit's unknowns, the mark if there is one, then the numbers that are free.
#[derive(Debug, Clone)]
pub(crate) struct EventSystem {
    base: Continuation,
    test: Test,
    /// Of symmetric orbits that lose their symmetry; the mark is μ.
    unfolding: Option<Unfolding>,
    units: Vector,
    origin: Vector,
    /// Of differences by a number that is free, relative, about the last orbit.
    step: f64,
    /// What takes the poles next to it away, and their modes.
    poles: (f64, SmallVec<[usize; 4]>),
}

/// An orbit where an event is.
#[derive(Debug, Clone)]
pub(crate) struct AtEvent {
    /// The orbit.
    pub orbit: ContactOrbit,
    /// θ of its multiplier on the circle, or the part of the period at which a contact touches; μ where symmetry is lost.
    pub mark: Option<f64>,
    /// Of the orbit's own equations.
    pub determinant: f64,
    /// The same among orbits of the symmetry that is kept to.
    pub fold_determinant: f64,
}

impl EventSystem {
    /// Of the orbits of `base`, from near `z`.
    pub(crate) fn new(mut base: Continuation, test: Test, z: &[f64], mark: Option<f64>) -> Self {
        let size = base.size();
        let unfolding = (test == Test::One).then(|| Unfolding::of(&mut base, z)).flatten();
        let mark = if unfolding.is_some() { Some(0.0) } else { mark.filter(|_| test.is_marked()) };
        let with = |base: &[f64], mark: Option<f64>| -> Vector {
            base[..size].iter().copied().chain(mark).chain(base[size..].iter().copied()).collect()
        };
        let units = with(base.units(), mark.map(|_| MARK));
        let origin = with(z, mark);
        Self { base, test, unfolding, units, origin, step: LONGEST, poles: (1.0, SmallVec::new()) }
    }

    /// What holds orbits symmetric along a curve on which they lose their symmetry, in units of their equations: μ, 0 as long as both numbers
    /// keep the symmetry.
    pub(crate) fn push(&self, at: &AtEvent) -> f64 {
        self.unfolding.as_ref().and(at.mark).unwrap_or(0.0)
    }

    /// How fast that grows along a curve, in units.
    pub(crate) fn push_along(&self, tangent: &[f64]) -> f64 {
        if self.unfolding.is_some() { tangent[self.base.size()] } else { 0.0 }
    }

    fn marks(&self) -> usize {
        usize::from(self.test.is_marked() || self.unfolding.is_some())
    }

    /// The rows of an orbit's own equations.
    fn own_rows(&self, rows: &[f64], mark: Option<f64>) -> Vector {
        let mut rows = Vector::from(rows);
        if let (Some(unfolding), Some(mark)) = (&self.unfolding, mark) {
            rows.iter_mut().zip(&unfolding.push).for_each(|(row, push)| *row += mark * push);
        }
        rows
    }

    /// The coordinates of the orbit alone, and the mark.
    fn parts(&self, z: &[f64]) -> (Vector, Option<f64>) {
        let (size, marks) = (self.base.size(), self.marks());
        (z[..size].iter().chain(&z[size + marks..]).copied().collect(), z[size..size + marks].first().copied())
    }

    fn tested(&self, here: &Evaluation<ContactOrbit, Vector>, mark: Option<f64>) -> Result<Vector, BranchError> {
        let mut values = self.test.values(here, mark)?;
        values.extend(self.unfolding.iter().map(|unfolding| unfolding.value(&here.orbit)));
        if values.iter().all(|value| value.is_finite()) {
            Ok(values.iter().copied().collect())
        } else {
            Err(BranchError::NoConvergence)
        }
    }

    /// Derivatives by differences, in units: of the test function by all unknowns, and of the orbit's equations by the number that is free. Next to a
    /// resonance both are large and nearly cancel along the curve.
    fn differentiate(
        &mut self,
        own: &[f64],
        (here, mark): (&Evaluation<ContactOrbit, Vector>, Option<f64>),
        rows: &[f64],
        matrix: &mut Matrix,
    ) -> Result<(), BranchError> {
        let (size, marks) = (self.base.size(), self.marks());
        for j in 0..size {
            let side = |system: &mut Self, h: f64| {
                let mut moved = Vector::from(own);
                moved[j] += h * system.units[j];
                let there = system.base.evaluate(&moved)?;
                system.tested(&there, mark)
            };
            let column = self.difference(&rows[size..], DIFFERENCE, side)?;
            column.iter().enumerate().for_each(|(k, slope)| matrix[(size + k, j)] = *slope);
        }
        if let Some(unfolding) = &self.unfolding {
            unfolding.push.iter().enumerate().for_each(|(i, push)| matrix[(i, size)] = push * MARK);
        } else if let Some(mark) = mark {
            let side = |system: &mut Self, h: f64| system.tested(here, Some(mark + h * MARK));
            let column = self.difference(&rows[size..], DIFFERENCE, side)?;
            column.iter().enumerate().for_each(|(k, slope)| matrix[(size + k, size)] = *slope);
        }
        let column = self.by_number((own, size), size + marks, rows, |system, moved| system.all_rows(moved, mark))?;
        column.iter().enumerate().for_each(|(i, slope)| matrix[(i, size + marks)] = *slope);
        Ok(())
    }

    /// The difference over a step to both sides; one-sided at the end of what an unknown may be.
    fn difference(
        &mut self,
        here: &[f64],
        step: f64,
        mut at: impl FnMut(&mut Self, f64) -> Result<Vector, BranchError>,
    ) -> Result<Vector, BranchError> {
        let (low, high, apart) = match [at(self, -step), at(self, step)] {
            [Ok(low), Ok(high)] => (low, high, 2.0 * step),
            [Ok(low), Err(_)] => (low, here.into(), step),
            [Err(_), Ok(high)] => (here.into(), high, step),
            [Err(error), Err(_)] => return Err(error),
        };
        Ok(high.iter().zip(&low).map(|(high, low)| (high - low) / apart).collect())
    }

    /// Derivatives in units by a number that is free, `z[at]`, whose unit stands at `place`: by differences over one step and over two, of all
    /// rows F as (fF)′ = f′F + fF′, where f takes their poles away.
    fn by_number(
        &mut self,
        (z, at): (&[f64], usize),
        place: usize,
        here: &[f64],
        mut rows: impl FnMut(&mut Self, &[f64]) -> Result<(Vector, ContactOrbit), BranchError>,
    ) -> Result<Vector, BranchError> {
        let unit = self.units[place];
        let (factor, modes) = self.poles.clone();
        // A window may be far shorter than the number.
        let step = self.step * (z[at] / unit).abs().max(1e-2);
        let regular =
            |rows: &[f64], factor: f64| -> Vector { rows.iter().map(|row| factor * row).chain([factor]).collect() };
        let centre = regular(here, factor);
        let mut over = |step: f64| {
            self.difference(&centre, step, |system, h| {
                let mut moved = Vector::from(z);
                moved[at] += h * unit;
                let (rows, orbit) = rows(system, &moved)?;
                Ok(regular(&rows, without_poles(&orbit, Some(&modes)).0))
            })
        };
        let (near, far) = (over(step)?, over(2.0 * step)?);
        let mut slopes: Vector = near.iter().zip(&far).map(|(near, far)| near + (near - far) / 3.0).collect();
        let of_factor = slopes.pop().unwrap_or(0.0);
        slopes.iter_mut().zip(here).for_each(|(slope, row)| *slope = (*slope - of_factor * row) / factor);
        Ok(slopes)
    }

    fn all_rows(&mut self, own: &[f64], mark: Option<f64>) -> Result<(Vector, ContactOrbit), BranchError> {
        let here = self.base.evaluate(own)?;
        let mut rows = self.own_rows(&here.rows, mark);
        rows.extend(self.tested(&here, mark)?);
        Ok((rows, here.orbit))
    }

    /// The equations at `z`, where the event is, with rounding of the rows and what Newton's method has left of them.
    fn known_at(&mut self, z: &[f64]) -> Result<Evaluation<AtEvent, Vector>, BranchError> {
        let (own, mark) = self.parts(z);
        let base = self.base.evaluate(&own)?;
        let values = rounding(self.test, &base, mark);
        let mut here = self.evaluate(z)?;
        here.kept[self.base.size()..].iter_mut().zip(values).for_each(|(error, value)| *error = value);
        here.kept.iter_mut().zip(&here.rows).for_each(|(error, left)| *error = error.max(left.abs()));
        Ok(here)
    }

    /// What rounding does to both numbers at a point of a curve, in their units.
    pub(crate) fn error(&mut self, point: &SolutionPoint<AtEvent>) -> Option<f64> {
        let z = point.coordinates();
        let here = self.known_at(z).ok()?;
        let bordered = self.bordered(z, &here, Some(point.tangent())).ok()?.transposed();
        let of_number = |place: usize| {
            let row = bordered.solve(&unit(z.len(), place))?;
            Some(row.iter().zip(&here.kept).map(|(row, error)| row.abs() * error).sum::<f64>())
        };
        Some(of_number(z.len() - 2)?.hypot(of_number(z.len() - 1)?))
    }
}

impl System for EventSystem {
    type Orbit = AtEvent;
    type Kept = Vector;

    /// The first number that is free counts as an unknown: the test function is its equation.
    fn size(&self) -> usize {
        self.base.size() + self.marks() + 1
    }

    fn units(&self) -> &[f64] {
        &self.units
    }

    fn origin(&mut self) -> Result<Vector, BranchError> {
        Ok(self.origin.clone())
    }

    fn rows(&mut self, z: &[f64]) -> Result<Vector, BranchError> {
        let (own, mark) = self.parts(z);
        Ok(self.all_rows(&own, mark)?.0)
    }

    fn evaluate(&mut self, z: &[f64]) -> Result<Evaluation<AtEvent, Vector>, BranchError> {
        let (own, mark) = self.parts(z);
        let here = self.base.evaluate(&own)?;
        // Right after it was worked out.
        let mut kept = self.base.row_errors(&here);
        let (size, marks) = (self.base.size(), self.marks());
        let room = room(&here.orbit, self.test.angle(mark));
        self.step = LONGEST.min(SHARE * room);
        let (poles, modes) = without_poles(&here.orbit, None);
        self.poles = (poles, modes);
        let values = self.tested(&here, mark)?;
        let mut rows = self.own_rows(&here.rows, mark);
        rows.extend(values.iter().copied());
        let mut matrix = Matrix::zeros(size + marks + 1);
        (0..size).for_each(|i| matrix.row_mut(i)[..size].copy_from_slice(here.matrix.row(i)));
        self.differentiate(&own, (&here, mark), &rows, &mut matrix)?;
        // What Newton's method leaves of it where it ends is rounding, too, and more than this next to other events.
        kept.extend(values.iter().map(|value| ROUNDING.max(value.abs())));
        let [determinant, fold_determinant] = [here.all(), &here.matrix].map(Matrix::determinant);
        let orbit = AtEvent { orbit: here.orbit, mark, determinant, fold_determinant };
        Ok(Evaluation { orbit, rows, matrix, full: None, kept })
    }

    /// Over the step about the last orbit.
    fn parameter_column(&mut self, z: &[f64], here: &[f64]) -> Result<Vector, BranchError> {
        let place = self.size();
        self.by_number((z, place), place, here, |system, moved| {
            let (own, mark) = system.parts(moved);
            system.all_rows(&own, mark)
        })
    }

    fn row_errors(&self, here: &Evaluation<AtEvent, Vector>) -> Vector {
        here.kept.clone()
    }

    fn evaluations(&self) -> usize {
        self.base.evaluations()
    }

    /// With that of the orbit's own equations.
    fn chord(&self, from: &[f64], to: &[f64]) -> Vector {
        let ((from, marked), (to, mark)) = (self.parts(from), self.parts(to));
        let mut chord = self.base.chord(&from, &to);
        let at = self.base.size();
        let marks = mark.zip(marked).map(|(to, from)| (to - from) / MARK);
        chord.insert_many(at, marks);
        chord
    }
}

/// An event of a branch, to which Newton's method has led.
pub(crate) struct Solved {
    pub(crate) at: AtEvent,
    /// The orbit's coordinates on its branch.
    pub(crate) coordinates: Vector,
    pub(crate) value: f64,
    pub(crate) error: f64,
}

/// The event of a branch near `z`.
pub(crate) fn solve(
    base: &Continuation,
    test: Test,
    (z, mark): (&[f64], Option<f64>),
    reach: f64,
) -> Result<Solved, BranchError> {
    let mut system = EventSystem::new(base.clone(), test, z, mark);
    let start = system.origin()?;
    let z = system.newton(&start, None, reach, false)?;
    let here = system.known_at(&z)?;
    let last = z.len() - 1;
    let row = here.matrix.transposed().solve(&unit(z.len(), last)).ok_or(BranchError::NoConvergence)?;
    let error: f64 = row.iter().zip(&here.kept).map(|(row, error)| row.abs() * error).sum();
    let (coordinates, _) = system.parts(&z);
    let value = z[last];
    Ok(Solved { at: here.orbit, coordinates, value, error: error * system.units[last] + f64::EPSILON * value.abs() })
}
