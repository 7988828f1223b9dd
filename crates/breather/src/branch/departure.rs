//! Where a branch of other orbits begins: of lower symmetry at a pitchfork, of twice the period at a period doubling, of another
//! word at a grazing.
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
//!
//! Where a mass touches a barrier, an impact without impulse may be added to the word: the orbit is one of the new word, too, and as
//! such regular. So is one without its impact that has lost all velocity.

use vibrochain_lattice::Parameter;

use crate::branch::{Branch, BranchPoint};
use crate::equations::linear::{Vector, unit};
use crate::equations::unknowns::{Unknowns, static_displacement};
use crate::error::BranchError;
use crate::orbit::{Draft, Family, Hit, Orbit, SIMULTANEOUS};
use crate::search::finder::Finder;
use crate::tracer::reduction::Reduction;
use crate::tracer::solution_curve::{SolutionCurve, SolutionPoint, normed};
use crate::tracer::system::System;

/// A border that is not orthogonal to n in any symmetry: no two of its entries are alike, none is small.
fn border(size: usize) -> Vector {
    (0..size).map(|i| 0.5 + (0.618 * i as f64).fract()).collect()
}

/// The way in which other orbits leave one.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub enum Departure {
    /// At a pitchfork: those without its symmetry.
    Pitchfork,
    /// At a period doubling, under a force: those of twice the period.
    PeriodDoubling,
    /// At a grazing: those that hit where masses touch. Impulses are not read.
    Touching(Vec<Hit>),
    /// At a grazing: those without this impact, which has lost its velocity.
    Without(usize),
}

impl Branch {
    /// The branch that leaves `orbit`, and the point where it does, heading along it. At a pitchfork, steps the other way give
    /// the mirror image, at a period doubling the same orbit begun a period of the force later. Whether the orbit stands at such a
    /// point is the caller's to know.
    ///
    /// # Errors
    /// [`BranchError::Family`] for one from which none is known to branch off; otherwise as [`Branch::step`].
    ///
    /// ```
    /// use vibrochain_breather::{Branch, Departure, Family, breathers};
    /// use vibrochain_lattice::{Chain, Model, Parameter, Point};
    /// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    /// let model = ring.omega(1.07).asymmetry(0.8).amplitude(0.15890808620612).restitution(0.25).model()?;
    /// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
    /// let (mut branch, start) = Branch::leaving(orbit, &Departure::PeriodDoubling, Parameter::Amplitude, 0.1)?;
    /// let doubled = branch.step(&start, 0.01)?;
    /// assert!(doubled.orbit().family() == Family::PeriodDoubled && doubled.value() < start.value());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn leaving(
        orbit: &Orbit,
        departure: &Departure,
        free: Parameter,
        unit_length: f64,
    ) -> Result<(Self, BranchPoint), BranchError> {
        let origin = match departure {
            Departure::Pitchfork => orbit.clone(),
            Departure::PeriodDoubling if orbit.model().is_conservative() => return Err(BranchError::Family),
            Departure::PeriodDoubling => twice(orbit)?,
            Departure::Touching(hits) => return Self::of_word(exchanged(orbit, None, hits)?, free, unit_length),
            Departure::Without(lost) => {
                return Self::of_word(exchanged(orbit, Some(*lost), &[])?, free, unit_length);
            }
        };
        let unknowns = Unknowns::free(&origin);
        let mut branch = Self::with(&origin, (free, unit_length), unknowns, Reduction::none(&unknowns))?;
        let point = branch.along_null_vector()?;
        Ok((branch, point))
    }

    /// The branch of an orbit that is one of its word but for rounding.
    fn of_word(origin: Orbit, free: Parameter, unit_length: f64) -> Result<(Self, BranchPoint), BranchError> {
        let mut branch = Self::through(&origin, free, unit_length)?;
        let point = branch.start()?;
        Ok((branch, point))
    }
}

impl<S: System> SolutionCurve<S> {
    /// The origin, where ∂F/∂x is singular, heading along the null vector.
    pub(crate) fn along_null_vector(&mut self) -> Result<SolutionPoint<S::Orbit>, BranchError> {
        let coordinates = self.equations.origin()?;
        // (∂F/∂x b; cᵀ 0)(n; g) = (0; 1), regular where ∂F/∂x is singular.
        let size = self.equations.size();
        let border = border(size);
        let mut last_row = border.clone();
        last_row.push(0.0);
        let here = self.equations.evaluate(&coordinates)?;
        let bordered = here.matrix.bordered(&border, &last_row);
        let mut direction = bordered.solve(&unit(size + 1, size)).ok_or(BranchError::NoConvergence)?;
        direction[size] = 0.0;
        Ok(SolutionPoint {
            determinant: here.all().determinant(),
            orbit: here.orbit,
            coordinates,
            tangent: normed(direction),
            fold_determinant: 0.0,
            // A branch point: its neighbours have either sign.
            orientation: 0.0,
        })
    }
}

/// An orbit as one of twice as many impacts in twice its period.
fn twice(orbit: &Orbit) -> Result<Orbit, BranchError> {
    let model = orbit.model();
    let mut finder = Finder::new(model.chain().sites());
    finder.prepare(model, orbit.frequency())?;
    let displacement = static_displacement(orbit, &finder.response);
    let periods = 2 * orbit.force_periods();
    finder.prepare(model, model.omega() / f64::from(periods))?;
    let (response, motion) = (&finder.response, &mut finder.motion);
    let half = 0.5 * response.period();
    let again =
        |later: f64| orbit.impacts().iter().map(move |impact| Hit { time: impact.time + later, ..impact.into() });
    let impacts = again(0.0).chain(again(half)).collect();
    let family = if orbit.family() == Family::SingleSided { Family::PeriodDoubled } else { Family::Word };
    let draft = Draft::new(response, (family, periods), orbit.psi_or_zero(), impacts, displacement);
    Ok(Orbit::assemble(model, response, motion, draft)?)
}

/// The same motion as an orbit of another word: without an impact that has no impulse left, with others that have none yet.
fn exchanged(orbit: &Orbit, lost: Option<usize>, touching: &[Hit]) -> Result<Orbit, BranchError> {
    let period = orbit.period();
    let kept = orbit.impacts().iter().enumerate().filter(|(i, _)| Some(*i) != lost).map(|(_, impact)| impact.into());
    let mut hits: Vec<Hit> = kept.chain(touching.iter().map(|hit| Hit { impulse: 0.0, ..*hit })).collect();
    let first = hits.first().ok_or(BranchError::Family)?.time;
    for hit in &mut hits {
        hit.time = (hit.time - first).rem_euclid(period);
        // Where symmetry puts it, but for rounding.
        for place in [0.0, 0.5 * period, period] {
            if (hit.time - place).abs() <= SIMULTANEOUS * period {
                hit.time = place % period;
            }
        }
    }
    hits.sort_by(|one, other| one.time.total_cmp(&other.time));
    let psi = (orbit.psi_or_zero() + first).rem_euclid(orbit.model().period());
    Ok(Orbit::from_impulses(orbit.model(), orbit.force_periods(), psi, &hits)?)
}
