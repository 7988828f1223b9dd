//! An event as a solution: the orbit's equations, and a test function of it that vanishes.
//!
//! With one number of the structure free these are as many equations as unknowns, an event of a branch. With two it is a curve, which the one
//! tracer follows. Derivatives of the test function are differences.

use vibrochain_breather::system::{Evaluation, Matrix, System, Vector};
use vibrochain_breather::{BranchError, StructureContinuation, StructureOrbit};

use super::rounding::{ROUNDING, rounding};
use super::test_function::Test;
use super::unfolding::Unfolding;

/// Steps of differences, in units: error and rounding balance.
const DIFFERENCE: f64 = 1e-6;

/// The unit of a mark: θ, or a part of the period.
const MARK: f64 = 0.1;

/// The equations of an orbit with a test function. z holds the orbit's unknowns, the mark if there is one, then the numbers of the structure.
#[derive(Debug, Clone)]
pub(super) struct EventSystem {
    base: StructureContinuation,
    test: Test,
    /// Of symmetric orbits that lose their symmetry; the mark is μ.
    unfolding: Option<Unfolding>,
    units: Vector,
    origin: Vector,
}

/// An orbit where an event is.
#[derive(Debug, Clone)]
pub(super) struct AtEvent {
    /// The orbit.
    pub orbit: StructureOrbit,
    /// θ of its multiplier on the circle, or the part of the period at which a contact touches; μ where symmetry is lost.
    pub mark: Option<f64>,
    /// Of the orbit's own equations.
    pub determinant: f64,
}

impl EventSystem {
    /// Of the orbits of `base`, from near `z`.
    pub(super) fn new(mut base: StructureContinuation, test: Test, z: &[f64], mark: Option<f64>) -> Self {
        let size = base.size();
        let unfolding = (test == Test::One).then(|| Unfolding::of(&mut base, z)).flatten();
        let mark = if unfolding.is_some() { Some(0.0) } else { mark.filter(|_| test.is_marked()) };
        let with = |base: &[f64], mark: Option<f64>| -> Vector {
            base[..size].iter().copied().chain(mark).chain(base[size..].iter().copied()).collect()
        };
        let units = with(base.units(), mark.map(|_| MARK));
        let origin = with(z, mark);
        Self { base, test, unfolding, units, origin }
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

    fn tested(&self, here: &Evaluation<StructureOrbit, Vector>, mark: Option<f64>) -> Result<Vector, BranchError> {
        let mut values = self.test.values(here, mark)?;
        values.extend(self.unfolding.iter().map(|unfolding| unfolding.value(&here.orbit)));
        if values.iter().all(|value| value.is_finite()) {
            Ok(values.iter().copied().collect())
        } else {
            Err(BranchError::NoConvergence)
        }
    }
}

impl System for EventSystem {
    type Orbit = AtEvent;
    type Kept = Vector;

    /// The first number of the structure counts as an unknown: the test function is its equation.
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
        let here = self.base.evaluate(&own)?;
        let mut rows = self.own_rows(&here.rows, mark);
        rows.extend(self.tested(&here, mark)?);
        Ok(rows)
    }

    fn evaluate(&mut self, z: &[f64]) -> Result<Evaluation<AtEvent, Vector>, BranchError> {
        let (own, mark) = self.parts(z);
        let here = self.base.evaluate(&own)?;
        let (size, marks) = (self.base.size(), self.marks());
        let values = self.tested(&here, mark)?;
        let column = self.base.parameter_column(&own, &here.rows, 0)?;
        let mut matrix = Matrix::zeros(size + marks + 1);
        for i in 0..size {
            let row = matrix.row_mut(i);
            row[..size].copy_from_slice(here.matrix.row(i));
            row[size + marks] = column[i];
        }
        let slopes = |matrix: &mut Matrix, place: usize, low: Vector, high: Vector| {
            for (k, (low, high)) in low.iter().zip(&high).enumerate() {
                matrix.row_mut(size + k)[place] = (high - low) / (2.0 * DIFFERENCE);
            }
        };
        for j in (0..size).chain([size + marks]) {
            let at = if j < size { j } else { size };
            let mut side = |sign: f64| -> Result<Vector, BranchError> {
                let mut moved = own.clone();
                moved[at] += sign * DIFFERENCE * self.units[j];
                let there = self.base.evaluate(&moved)?;
                self.tested(&there, mark)
            };
            let (low, high) = (side(-1.0)?, side(1.0)?);
            slopes(&mut matrix, j, low, high);
        }
        if let Some(mark) = mark {
            let side = |sign: f64| self.tested(&here, Some(mark + sign * DIFFERENCE * MARK));
            slopes(&mut matrix, size, side(-1.0)?, side(1.0)?);
        }
        if let Some(unfolding) = &self.unfolding {
            unfolding.push.iter().enumerate().for_each(|(i, push)| matrix[(i, size)] = push * MARK);
        }
        let (mut rows, mut kept) = (self.own_rows(&here.rows, mark), self.base.row_errors(&here));
        // What Newton's method leaves of it where it ends is rounding, too, and more than this next to other events.
        let own = rounding(self.test, &here, mark);
        kept.extend(values.iter().map(|value| own.max(value.abs())));
        if self.unfolding.is_some() {
            kept[size + 1] = kept[size + 1].max(ROUNDING);
        }
        rows.extend(values);
        let orbit = AtEvent { orbit: here.orbit, mark, determinant: here.full_determinant };
        Ok(Evaluation { orbit, rows, full_determinant: matrix.determinant(), matrix, kept })
    }

    fn row_errors(&self, here: &Evaluation<AtEvent, Vector>) -> Vector {
        here.kept.clone()
    }

    fn evaluations(&self) -> usize {
        self.base.evaluations()
    }
}

/// An event of a branch, to which Newton's method has led.
pub(super) struct Solved {
    pub(super) at: AtEvent,
    /// The orbit's coordinates on its branch.
    pub(super) coordinates: Vector,
    pub(super) value: f64,
    pub(super) error: f64,
}

/// The event of a branch near `z`.
pub(super) fn solve(
    base: &StructureContinuation,
    test: Test,
    (z, mark): (&[f64], Option<f64>),
    reach: f64,
) -> Result<Solved, BranchError> {
    let mut system = EventSystem::new(base.clone(), test, z, mark);
    let start = system.origin()?;
    let z = system.newton(&start, &[], reach, false)?;
    let here = system.evaluate(&z)?;
    let last = z.len() - 1;
    let row = here.matrix.transposed().solve(&vibrochain_breather::system::unit(z.len(), last));
    let row = row.ok_or(BranchError::NoConvergence)?;
    let error: f64 = row.iter().zip(&here.kept).map(|(row, error)| row.abs() * error).sum();
    let (coordinates, _) = system.parts(&z);
    let value = z[last];
    Ok(Solved { at: here.orbit, coordinates, value, error: error * system.units[last] + f64::EPSILON * value.abs() })
}
