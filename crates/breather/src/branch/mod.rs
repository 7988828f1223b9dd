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
pub(crate) mod surface;

use vibrochain_lattice::{Parameter, Stop};

use crate::equations::linear::{Vector, dot, unit};
use crate::equations::unknowns::Unknowns;
use crate::error::BranchError;
use crate::orbit::Orbit;
use crate::tracer::corrector::Continuation;
use crate::tracer::reduction::Reduction;

/// A chord may differ from the mean of the tangents at its ends by this part of its length: that of an arc of a quarter of a
/// radian. One that leads to another branch does not fit the tangents.
pub(crate) const CHORD: f64 = 0.01;

/// A point may be this part of the step away from where the tangent pointed; farther is another branch or too long a
/// step.
const BEND: f64 = 0.35;

/// Step of the difference quotients of a determinant, in units.
const DIFFERENCE: f64 = 1e-6;

/// Newton steps at most to a fold, damped where it is far.
const STEPS_TO_FOLD: usize = 48;

/// A point of a branch.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchPoint {
    pub(crate) orbit: Orbit,
    /// The free unknowns, then the parameter.
    pub(crate) coordinates: Vector,
    /// Unit tangent, in units of the coordinates.
    pub(crate) tangent: Vector,
    pub(crate) full_determinant: f64,
    /// Sign of the determinant of ∂F/∂z bordered by the tangent: constant along a curve without branch points, and different
    /// on branches that are neighbours at one value of the parameter.
    pub(crate) orientation: f64,
    pub(crate) parameter_error: f64,
}

impl BranchPoint {
    /// The orbit.
    pub fn orbit(&self) -> &Orbit {
        &self.orbit
    }

    /// Value of the free parameter.
    pub fn value(&self) -> f64 {
        self.coordinates[self.coordinates.len() - 1]
    }

    /// Component of the unit tangent along the parameter; it changes sign at a fold.
    pub fn heading(&self) -> f64 {
        self.tangent[self.tangent.len() - 1]
    }

    /// Determinant of the Jacobian of the orbit's equations, columns in units and rows of length 1: 0 where an orbit under a force has a
    /// multiplier +1.
    pub fn determinant(&self) -> f64 {
        self.full_determinant
    }

    /// Estimated error of the parameter at a fold: what rounding of the equations does to the curve along the parameter.
    pub fn parameter_error(&self) -> f64 {
        self.parameter_error
    }

    /// The same point, with the curve to be followed the other way.
    pub fn reversed(&self) -> Self {
        let tangent = self.tangent.iter().map(|x| -x).collect();
        Self { tangent, orientation: -self.orientation, ..self.clone() }
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
#[derive(Debug, Clone)]
pub struct Branch {
    pub(crate) equations: Continuation,
}

impl Branch {
    /// The branch of `free` through an orbit of any word. `unit` is the length along the parameter that counts like a change
    /// of order 1 of the orbit.
    ///
    /// # Errors
    /// [`BranchError::Breather`] at a resonance, which an orbit that exists has already passed.
    pub fn through(orbit: &Orbit, free: Parameter, unit: f64) -> Result<Self, BranchError> {
        let unknowns = Unknowns::of(orbit);
        Self::with(orbit, (free, unit), unknowns, Reduction::of(orbit, &[free], &unknowns))
    }

    /// The branch of these unknowns.
    pub(crate) fn with(
        orbit: &Orbit,
        (free, unit): (Parameter, f64),
        unknowns: Unknowns,
        reduction: Reduction,
    ) -> Result<Self, BranchError> {
        Ok(Self { equations: Continuation::new(orbit, &[(free, unit)], unknowns, reduction)? })
    }

    /// The same branch, along which no step is made once `stop` is raised.
    #[must_use]
    pub fn until(mut self, stop: &Stop) -> Self {
        self.equations.finder = self.equations.finder.until(stop);
        self
    }

    /// Orbits assembled so far: the cost.
    pub fn evaluations(&self) -> usize {
        self.equations.evaluations
    }

    /// The free parameter.
    pub fn free(&self) -> Parameter {
        self.equations.free[0]
    }

    /// The orbit that the branch was started from, heading towards larger parameters.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn start(&mut self) -> Result<BranchPoint, BranchError> {
        let z = self.origin_coordinates()?;
        self.correct(&z, &unit(z.len(), z.len() - 1), 0.0, true)
    }

    /// The branch of a word among orbits with all the symmetry that the impacts of `orbit` have: it passes the points where others
    /// branch off that lack it.
    pub(crate) fn of_symmetric(orbit: &Orbit, free: Parameter, unit: f64) -> Result<Self, BranchError> {
        let unknowns = Unknowns::of(orbit);
        Self::with(orbit, (free, unit), unknowns, Reduction::of_word(orbit, &unknowns))
    }

    /// The same point, with impulses measured by what they are there from here on: of a branch along which they grow without bound,
    /// equal steps are then equal factors, where they would be equal differences for ever.
    pub(crate) fn rescaled(&mut self, point: BranchPoint) -> BranchPoint {
        let before = self.equations.units.clone();
        self.equations.rescale(&point.orbit);
        let own = before.iter().zip(&self.equations.units);
        let tangent: Vector = point.tangent.iter().zip(own).map(|(x, (before, now))| x * before / now).collect();
        let norm = dot(&tangent, &tangent).sqrt();
        BranchPoint { tangent: tangent.iter().map(|x| x / norm).collect(), ..point }
    }

    /// The orbit of the branch at the parameter of the one it was made with, which is only near it.
    pub(crate) fn nearby(&mut self, reach: f64) -> Result<Orbit, BranchError> {
        let z = self.origin_coordinates()?;
        let fixed = unit(z.len(), z.len() - 1);
        let z = self.equations.newton(&z, &[&fixed], reach, false)?;
        Ok(self.equations.evaluate(&z)?.orbit)
    }

    /// Where the orbit that the branch was started from stands.
    pub(crate) fn origin_coordinates(&mut self) -> Result<Vector, BranchError> {
        let origin = self.equations.origin.clone();
        self.equations.coordinates(&origin)
    }

    /// The point with τ·(z − z₀) = σ, z₀ the anchor. `known` says that this is an orbit itself.
    fn correct(
        &mut self,
        anchor: &[f64],
        tangent: &[f64],
        length: f64,
        known: bool,
    ) -> Result<BranchPoint, BranchError> {
        let ahead = anchor.iter().zip(&self.equations.units).zip(tangent);
        let predicted: Vector = ahead.map(|((anchor, unit), tangent)| anchor + unit * tangent * length).collect();
        let reach = if length == 0.0 { 1e-2 } else { BEND * length.abs() + 1e-9 };
        let z = self.equations.newton(&predicted, &[tangent], reach, known)?;
        self.finish(&z, tangent)
    }

    /// The point at `z`, with a tangent that goes the way `towards` does.
    pub(crate) fn finish(&mut self, z: &[f64], towards: &[f64]) -> Result<BranchPoint, BranchError> {
        let m = self.equations.reduction.size();
        let here = self.equations.evaluate(z)?;
        let errors = self.equations.row_errors(&here);
        let column = self.equations.parameter_column(z, &here.rows, 0)?;
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
            parameter_error: error * self.equations.units[m],
        })
    }

    /// `z`, an orbit, with this unit tangent.
    pub(crate) fn point(&mut self, z: &[f64], tangent: Vector) -> Result<BranchPoint, BranchError> {
        let here = self.equations.evaluate(z)?;
        Ok(BranchPoint {
            orbit: here.orbit,
            coordinates: z.into(),
            tangent,
            full_determinant: here.full_determinant,
            orientation: 0.0,
            parameter_error: f64::INFINITY,
        })
    }

    /// The point `length` along the tangent at `from`; negative lengths go back.
    ///
    /// # Errors
    /// [`BranchError`]; a shorter step may succeed.
    pub fn step(&mut self, from: &BranchPoint, length: f64) -> Result<BranchPoint, BranchError> {
        let next = self.correct(&from.coordinates, &from.tangent, length, false)?;
        self.continued(from, next)
    }

    /// As [`Branch::step`], but over a branch point, too, where Newton's method keeps to the symmetry of `from`.
    pub(crate) fn step_over(&mut self, from: &BranchPoint, length: f64) -> Result<BranchPoint, BranchError> {
        let next = self.correct(&from.coordinates, &from.tangent, length, false)?;
        if self.fits(from, &next) { Ok(next) } else { Err(BranchError::NoConvergence) }
    }

    /// `to` − `from`, in units of the coordinates.
    fn chord(&self, from: &BranchPoint, to: &BranchPoint) -> Vector {
        self.equations.chord(&from.coordinates, &to.coordinates)
    }

    /// The chord between two points agrees with the tangents at its ends.
    fn fits(&self, from: &BranchPoint, next: &BranchPoint) -> bool {
        let chord = self.chord(from, next);
        let norm = dot(&chord, &chord).sqrt();
        let length = norm.copysign(dot(&chord, &from.tangent));
        let mean = |i: usize| 0.5 * (from.tangent[i] + next.tangent[i]);
        let apart = chord.iter().enumerate().map(|(i, x)| (x - length * mean(i)).abs());
        apart.fold(0.0, f64::max) <= CHORD * norm + 1e-9
    }

    /// `next` if it is on the curve through `from`, as far as the two points can tell.
    fn continued(&self, from: &BranchPoint, next: BranchPoint) -> Result<BranchPoint, BranchError> {
        // Asymmetric orbits pass the symmetric one, a branch point, on their way to their own mirror images.
        let side = |point: &BranchPoint| point.orbit.phi().map_or(0.0, |phi| phi - 0.5 * point.orbit.period());
        let mirrored = side(from) * side(&next) < 0.0;
        let turned = from.orientation * next.orientation < 0.0;
        if self.fits(from, &next) && (!turned || mirrored || self.has_pole_between(from.value(), next.value())) {
            Ok(next)
        } else {
            Err(BranchError::NoConvergence)
        }
    }

    /// The point of the curve with the given parameter, near `from`, heading on as there.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn at(&mut self, from: &BranchPoint, value: f64) -> Result<BranchPoint, BranchError> {
        let (heading, m) = (from.heading(), self.equations.reduction.size());
        if heading == 0.0 {
            return Err(BranchError::NoConvergence);
        }
        let length = (value - from.value()) / self.equations.units[m];
        // Along the tangent to the parameter asked for, and from there at that parameter.
        let mut z = from.coordinates.clone();
        for i in 0..m {
            z[i] += self.equations.units[i] * from.tangent[i] * length / heading;
        }
        z[m] = value;
        let mut direction = unit(m + 1, m);
        direction[m] = heading.signum();
        let next = self.correct(&z, &direction, 0.0, false)?;
        self.continued(from, next)
    }

    /// The fold near `near`: F = 0 and det ∂F/∂x = 0 by Newton's method.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn fold(&mut self, near: &BranchPoint) -> Result<BranchPoint, BranchError> {
        let (m, mut z) = (self.equations.reduction.size(), near.coordinates.clone());
        let mut last = f64::INFINITY;
        for _ in 0..STEPS_TO_FOLD {
            let here = self.equations.evaluate(&z)?;
            let column = self.equations.parameter_column(&z, &here.rows, 0)?;
            let mut gradient = Vector::new();
            for j in 0..=m {
                let mut side = |sign: f64| -> Result<f64, BranchError> {
                    let mut moved = z.clone();
                    moved[j] += sign * DIFFERENCE * self.equations.units[j];
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
                z[i] += damping * change[i] * self.equations.units[i];
            }
            if size <= 4.0 * f64::EPSILON || size < 1e-10 && size >= 0.5 * last {
                return self.finish(&z, &near.tangent);
            }
            last = size;
        }
        Err(BranchError::NoConvergence)
    }

    /// How far apart two points are, in units of the coordinates.
    pub fn distance(&self, from: &BranchPoint, to: &BranchPoint) -> f64 {
        let chord = self.chord(from, to);
        dot(&chord, &chord).sqrt()
    }

    /// Number of masses.
    pub fn sites(&self) -> usize {
        self.equations.origin.model().chain().sites()
    }

    /// The length at which `to` lies from `from`, along the tangent there.
    pub fn length_between(&self, from: &BranchPoint, to: &BranchPoint) -> f64 {
        dot(&from.tangent, &self.chord(from, to))
    }
}
