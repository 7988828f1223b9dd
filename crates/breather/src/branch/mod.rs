//! A branch: the curve that one orbit draws when one parameter is varied.
//!
//! With x the unknowns of the orbit's equations F (`equations`) and λ the parameter, the branch is the curve F(x, λ) = 0 in
//! z = (x, λ), each coordinate in its natural unit. From a point z₀ with unit tangent τ the curve is described by the
//! length σ along the tangent,
//!
//! ```text
//! F(z) = 0,     τ·(z − z₀) = σ ,
//! ```
//!
//! which stays regular where the branch turns back in λ (a fold: ∂F/∂x is singular, the bordered matrix is not). The
//! fold itself is F = 0 and det ∂F/∂x = 0.
//!
//! On a branch of symmetric orbits (double-sided, φ = T/2) asymmetric ones branch off where ∂F/∂x is singular in a direction
//! that breaks the symmetry. There the curve is followed among symmetric orbits alone ([`Reduction`]), so that it passes
//! through regularly, while the determinant of all equations tells of the pitchfork.

pub(crate) mod at_resonance;
pub(crate) mod departure;
pub(crate) mod resonances;

use vibrochain_lattice::{Parameter, Stop};

use crate::equations::linear::{Vector, dot, unit};
use crate::equations::unknowns::Unknowns;
use crate::error::BranchError;
use crate::orbit::Orbit;
use crate::tracer::corrector::Continuation;
use crate::tracer::manifold::{Manifold, ManifoldPoint, NEAR, normed};
use crate::tracer::reduction::Reduction;
use crate::tracer::system::System;

/// Step of the difference quotients of a determinant, in units.
const DIFFERENCE: f64 = 1e-6;

/// Newton steps at most to a fold, damped where it is far.
const STEPS_TO_FOLD: usize = 48;

/// A point of a branch.
pub type BranchPoint = ManifoldPoint<Orbit, 1>;

impl<O: Clone> ManifoldPoint<O, 1> {
    /// Value of the free parameter.
    pub fn value(&self) -> f64 {
        self.coordinates[self.coordinates.len() - 1]
    }

    /// Component of the unit tangent along the parameter; it changes sign at a fold.
    pub fn heading(&self) -> f64 {
        let [tangent] = &self.tangents;
        tangent[tangent.len() - 1]
    }

    /// The same point, with the curve to be followed the other way.
    pub fn reversed(&self) -> Self {
        let tangents = [self.tangents[0].iter().map(|x| -x).collect()];
        Self { tangents, orientation: -self.orientation, ..self.clone() }
    }
}

/// One branch, to be followed step by step.
///
/// ```
/// use vibrochain_breather::{Branch, Family, breathers};
/// use vibrochain_lattice::{Chain, Model, Parameter};
/// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.07, 0.8, 0.165, 0.25)?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let mut branch = Branch::through(orbit, Parameter::Amplitude, 0.1)?;
/// // Downwards the branch turns back at a fold.
/// let mut point = branch.start()?.reversed();
/// while point.heading() < 0.0 {
///     point = branch.step(&point, 0.02)?;
/// }
/// let fold = branch.fold(&point)?;
/// assert!((fold.value() - 0.157927457266535).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Branch = Manifold<Continuation, 1>;

impl<const N: usize> Manifold<Continuation, N> {
    /// Through an orbit. With each parameter stands its unit, the length along it that counts like a change of order 1 of the orbit.
    pub(crate) fn of_free(orbit: &Orbit, free: [(Parameter, f64); N]) -> Result<Self, BranchError> {
        let unknowns = Unknowns::of(orbit);
        Self::with(orbit, free, unknowns, Reduction::of(orbit, &free.map(|(parameter, _)| parameter), &unknowns))
    }

    /// In these unknowns.
    pub(crate) fn with(
        orbit: &Orbit,
        free: [(Parameter, f64); N],
        unknowns: Unknowns,
        reduction: Reduction,
    ) -> Result<Self, BranchError> {
        Ok(Self { equations: Continuation::new(orbit, &free, unknowns, reduction)? })
    }

    /// The same, along which no step is made once `stop` is raised.
    #[must_use]
    pub fn until(mut self, stop: &Stop) -> Self {
        self.equations.finder = self.equations.finder.until(stop);
        self
    }
}

impl Branch {
    /// The branch of `free` through an orbit of any word. `unit` is the length along the parameter that counts like a change
    /// of order 1 of the orbit.
    ///
    /// # Errors
    /// [`BranchError::Breather`] at a resonance, which an orbit that exists has already passed.
    pub fn through(orbit: &Orbit, free: Parameter, unit: f64) -> Result<Self, BranchError> {
        Self::of_free(orbit, [(free, unit)])
    }

    /// The free parameter.
    pub fn free(&self) -> Parameter {
        self.equations.free[0]
    }

    /// The branch of a word among orbits with all the symmetry that the impacts of `orbit` have: it passes the points where others
    /// branch off that lack it.
    pub(crate) fn of_symmetric(orbit: &Orbit, free: Parameter, unit: f64) -> Result<Self, BranchError> {
        let unknowns = Unknowns::of(orbit);
        Self::with(orbit, [(free, unit)], unknowns, Reduction::of_word(orbit, &unknowns))
    }

    /// The same point, with impulses measured by what they are there from here on: of a branch along which they grow without bound,
    /// equal steps are then equal factors, where they would be equal differences for ever.
    pub(crate) fn rescaled(&mut self, point: BranchPoint) -> BranchPoint {
        let before = self.equations.units.clone();
        self.equations.rescale(&point.orbit);
        let own = before.iter().zip(&self.equations.units);
        let tangent = point.tangents[0].iter().zip(own).map(|(x, (before, now))| x * before / now);
        BranchPoint { tangents: [normed(tangent.collect())], ..point }
    }

    /// The orbit of the branch at the parameter of the one it was made with, which is only near it.
    pub(crate) fn nearby(&mut self, reach: f64) -> Result<Orbit, BranchError> {
        let z = self.equations.origin()?;
        let fixed = unit(z.len(), z.len() - 1);
        let z = self.equations.newton(&z, &[fixed], reach, false)?;
        Ok(self.equations.evaluate(&z)?.orbit)
    }

    /// Number of masses.
    pub fn sites(&self) -> usize {
        self.equations.origin.model().chain().sites()
    }
}

type Point<S> = ManifoldPoint<<S as System>::Orbit, 1>;

impl<S: System> Manifold<S, 1> {
    /// The orbit that the branch was started from, heading towards larger parameters.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn start(&mut self) -> Result<Point<S>, BranchError> {
        let z = self.equations.origin()?;
        self.correct(&z, &[unit(z.len(), z.len() - 1)], NEAR, true)
    }

    /// The point `length` along the tangent at `from`; negative lengths go back.
    ///
    /// # Errors
    /// [`BranchError`]; a shorter step may succeed.
    pub fn step(&mut self, from: &Point<S>, length: f64) -> Result<Point<S>, BranchError> {
        let next = self.step_along(from, [length])?;
        self.continued(from, next)
    }

    /// `next` if no branch point lies between it and `from`, as far as the two can tell.
    fn continued(&self, from: &Point<S>, next: Point<S>) -> Result<Point<S>, BranchError> {
        let turned = from.orientation * next.orientation < 0.0;
        let places = ((&from.orbit, from.value()), (&next.orbit, next.value()));
        if !turned || self.equations.may_turn(places.0, places.1) { Ok(next) } else { Err(BranchError::NoConvergence) }
    }

    /// The point of the curve with the given parameter, near `from`, heading on as there.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn at(&mut self, from: &Point<S>, value: f64) -> Result<Point<S>, BranchError> {
        let (heading, last) = (from.heading(), from.coordinates.len() - 1);
        if heading == 0.0 {
            return Err(BranchError::NoConvergence);
        }
        // Along the tangent to the parameter asked for, and from there at that parameter.
        let mut z = self.ahead(from, [(value - from.value()) / self.equations.units()[last] / heading]);
        z[last] = value;
        let mut direction = unit(z.len(), last);
        direction[last] = heading.signum();
        let next = self.correct(&z, &[direction], NEAR, false)?;
        let next = self.fitting(from, next)?;
        self.continued(from, next)
    }

    /// The fold near `near`: F = 0 and det ∂F/∂x = 0 by Newton's method.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn fold(&mut self, near: &Point<S>) -> Result<Point<S>, BranchError> {
        let (m, mut z) = (self.equations.size(), near.coordinates.clone());
        let mut last = f64::INFINITY;
        for _ in 0..STEPS_TO_FOLD {
            let here = self.equations.evaluate(&z)?;
            let column = self.equations.parameter_column(&z, &here.rows, 0)?;
            let mut gradient = Vector::new();
            for j in 0..=m {
                let mut side = |sign: f64| -> Result<f64, BranchError> {
                    let mut moved = z.clone();
                    moved[j] += sign * DIFFERENCE * self.equations.units()[j];
                    Ok(self.equations.evaluate(&moved)?.matrix.determinant())
                };
                gradient.push((side(1.0)? - side(-1.0)?) / (2.0 * DIFFERENCE));
            }
            let mut right: Vector = here.rows.iter().map(|x| -x).collect();
            right.push(-here.matrix.determinant());
            let bordered = here.matrix.bordered(&column, &gradient);
            let change = bordered.solve(&right).ok_or(BranchError::NoConvergence)?;
            let size = change.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            // Damped while far away.
            let damping = (0.1 / size).min(1.0);
            for i in 0..=m {
                z[i] += damping * change[i] * self.equations.units()[i];
            }
            if size <= 4.0 * f64::EPSILON || size < 1e-10 && size >= 0.5 * last {
                return self.finish(z, &near.tangents);
            }
            last = size;
        }
        Err(BranchError::NoConvergence)
    }

    /// Estimated error of the parameter at a fold: what rounding of the equations does to the curve along the parameter.
    pub fn parameter_error(&mut self, fold: &Point<S>) -> f64 {
        let (z, last) = (&fold.coordinates, fold.coordinates.len() - 1);
        let row = |equations: &mut S| {
            let here = equations.evaluate(z)?;
            let errors = equations.row_errors(&here);
            // The parameter's row of the inverse, bordered by the tangent itself.
            let bordered = equations.bordered(z, &here, &fold.tangents)?;
            let row = bordered.transposed().solve(&unit(z.len(), last)).ok_or(BranchError::NoConvergence)?;
            Ok(row.iter().zip(&errors).map(|(row, error)| row.abs() * error).sum::<f64>())
        };
        let error: Result<f64, BranchError> = row(&mut self.equations);
        error.unwrap_or(f64::INFINITY) * self.equations.units()[last]
    }

    /// The length at which `to` lies from `from`, along the tangent there.
    pub fn length_between(&self, from: &Point<S>, to: &Point<S>) -> f64 {
        self.between(from, to)[0]
    }

    /// The length of a chord along the tangent at `from`.
    pub fn along(&self, from: &Point<S>, chord: &[f64]) -> f64 {
        dot(&from.tangents[0], chord)
    }
}
