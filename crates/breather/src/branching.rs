//! Where a branch of orbits of lower symmetry begins: at a pitchfork of double-sided orbits and, of doubled orbits, at the
//! period doubling of a single-sided one.
//!
//! Written with the unknowns of the orbits that branch off (both times and impulses free, for a doubled orbit twice the
//! period), ∂F/∂x of the orbit they leave is singular, ∂F/∂x n = 0, in a direction n that breaks its symmetry. Along n begins
//!
//! ```text
//! F(z) = 0,     n·(z − z₀) = σ,     λ = λ₀ + κσ² + …
//! ```
//!
//! while the orbit itself moves across n. So the curve of length along a tangent that every branch is followed by leads off
//! it, and the sign of κ is the side on which the orbits exist: nothing has to be searched for or told apart.

use smallvec::smallvec;
use vibrochain_lattice::Parameter;

use crate::branch::{Branch, BranchError, BranchPoint};
use crate::finder::Finder;
use crate::linear::{Vector, dot, unit};
use crate::orbit::{Draft, Family, Hit, Orbit};
use crate::reduction::Reduction;
use crate::unknowns::{Unknowns, static_displacement};

/// A border that is not orthogonal to n in any symmetry: no two of its entries are alike, none is small.
fn border(size: usize) -> Vector {
    (0..size).map(|i| 0.5 + (0.618 * i as f64).fract()).collect()
}

impl Branch {
    /// The branch that leaves `orbit` at a pitchfork (double-sided) or a period doubling (single-sided, under a force), and
    /// the point where it does, heading along it; steps the other way give the mirror image, of a doubled orbit the
    /// same one begun half its period later. Whether the orbit stands at such a point is the caller's to know.
    ///
    /// # Errors
    /// [`BranchError::Family`] for one from which none is known to branch off; otherwise as [`Branch::step`].
    ///
    /// ```
    /// use vibrochain_breather::{Branch, Family, breathers};
    /// use vibrochain_lattice::{Chain, Model, Parameter};
    /// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.07, 0.8, 0.15890808620612, 0.25)?;
    /// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
    /// let (mut branch, start) = Branch::leaving(orbit, Parameter::Amplitude, 0.1)?;
    /// let doubled = branch.step(&start, 0.01)?;
    /// assert!(doubled.orbit().family() == Family::PeriodDoubled && doubled.value() < start.value());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn leaving(orbit: &Orbit, free: Parameter, unit_length: f64) -> Result<(Self, BranchPoint), BranchError> {
        let model = orbit.model();
        let origin = match orbit.family() {
            Family::SingleSided if !model.is_conservative() => twice(orbit)?,
            Family::DoubleSided => orbit.clone(),
            _ => return Err(BranchError::Family),
        };
        let unknowns = Unknowns::free(&origin);
        let mut branch = Self::with(&origin, (free, unit_length), unknowns, Reduction::none(&unknowns))?;
        let coordinates = branch.origin_coordinates()?;
        // (∂F/∂x b; cᵀ 0)(n; g) = (0; 1), regular where ∂F/∂x is singular.
        let size = unknowns.size();
        let border = border(size);
        let mut last_row = border.clone();
        last_row.push(0.0);
        let bordered = branch.evaluate(&coordinates)?.matrix.bordered(&border, &last_row);
        let mut direction = bordered.solve(&unit(size + 1, size)).ok_or(BranchError::NoConvergence)?;
        direction[size] = 0.0;
        let norm = dot(&direction, &direction).sqrt();
        let point = branch.point(&coordinates, direction.iter().map(|x| x / norm).collect())?;
        Ok((branch, point))
    }
}

/// A single-sided orbit as one of two impacts in two periods of the force.
fn twice(orbit: &Orbit) -> Result<Orbit, BranchError> {
    let model = orbit.model();
    let mut finder = Finder::new(model.chain().sites());
    finder.prepare(model, orbit.frequency())?;
    let displacement = static_displacement(orbit, &finder.response);
    let first = orbit.impacts().first().ok_or(BranchError::Family)?;
    finder.prepare(model, 0.5 * model.omega())?;
    let (response, motion) = (&finder.response, &mut finder.motion);
    let impact = |time: f64| Hit { time, ..Hit::from(first) };
    let impacts = smallvec![impact(0.0), impact(0.5 * response.period())];
    let draft = Draft::new(response, (Family::PeriodDoubled, 2), orbit.psi_or_zero(), impacts, displacement);
    Ok(Orbit::assemble(model, response, motion, draft)?)
}
