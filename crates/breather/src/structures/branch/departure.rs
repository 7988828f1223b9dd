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

use vibrochain_lattice::Stop;

use super::continuation::{Branch, BranchPoint, Continuation};
use super::family::ModelFamily;
use crate::branch_error::BranchError;
use crate::equations::linear::{Vector, unit};
use crate::error::BreatherError;
use crate::orbit::{Hit, Impact, SIMULTANEOUS};
use crate::structures::model::LoadedStructure;
use crate::structures::orbit::ContactOrbit;
use crate::structures::point::Strike;
use crate::tracer::solution_curve::{SolutionCurve, SolutionPoint, normed};
use crate::tracer::system::{Matrix, System};
use crate::word::MAX_IMPACTS;

/// What the equations leave of their null vector, as a part of the terms: next to an event that was located it is rounding, but for what Newton's
/// method loses where symmetry breaks. Where they are regular, as where the energy of a conservative orbit is extreme, it is of order 1.
const SINGULAR: f64 = 1e-2;

/// Terms that are no larger than this, of a row of length 1, are rounding.
const NOTHING: f64 = 1e-9;

/// An impact this slow, against velocities and accelerations over ω, is lost together with another one that is.
const STILL: f64 = 1e-6;

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

impl Branch {
    /// The branch that leaves `orbit`, which stands at `value` of the number of `family`, and the point where it does, heading along it. Steps the
    /// other way give the mirror image, or the same orbits begun later; at a grazing those that are pulled.
    ///
    /// # Errors
    /// [`BranchError::Family`] where none is known to branch off, or the equations are regular; otherwise as [`Branch::step`].
    pub fn leaving(
        orbit: &ContactOrbit,
        departure: &Departure,
        family: ModelFamily,
        (value, unit): (f64, f64),
        stop: &Stop,
    ) -> Result<(Self, BranchPoint), BranchError> {
        let through = |orbit: &ContactOrbit| -> Result<Self, BranchError> {
            Ok(Self::of(Continuation::through(orbit, family.clone(), &[value], &[unit], stop)?))
        };
        let exchanged = |lost, touching: &[_]| -> Result<(Self, BranchPoint), BranchError> {
            let mut branch = through(&orbit.with_contacts_at(touching)?.exchanged(lost, touching)?)?;
            let point = branch.start()?;
            Ok((branch, point))
        };
        let mut branch = match departure {
            Departure::PeriodDoubling if orbit.is_conservative() => return Err(BranchError::Family),
            Departure::PeriodDoubling => through(&orbit.twice()?)?,
            Departure::Pitchfork => Self::of(Continuation::among_all(orbit, family.clone(), &[value], &[unit], stop)?),
            Departure::Touching(hits) => return exchanged(None, hits),
            Departure::Without(lost) => return exchanged(Some(*lost), &[]),
        };
        let point = branch.along_null_vector()?;
        let matrix = branch.equations.evaluate(point.coordinates())?.matrix;
        if is_null_vector(&matrix, point.tangent()) { Ok((branch, point)) } else { Err(BranchError::Family) }
    }
}

/// Whether a matrix leaves nothing but rounding of a vector.
fn is_null_vector(matrix: &Matrix, vector: &[f64]) -> bool {
    (0..matrix.size()).all(|i| {
        let terms = || matrix.row(i).iter().zip(vector).map(|(entry, x)| entry * x);
        // Symmetry leaves rows whose terms are rounding themselves.
        let length = matrix.row(i).iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        terms().sum::<f64>().abs() <= SINGULAR * terms().map(f64::abs).sum::<f64>() + NOTHING * length
    })
}

impl ContactOrbit {
    /// An orbit of these impacts as they are, in order of time from 0 on.
    fn assembled(
        model: &LoadedStructure,
        force_periods: u32,
        psi: f64,
        strikes: Vec<Strike>,
    ) -> Result<Self, BreatherError> {
        if strikes.len() > MAX_IMPACTS {
            return Err(BreatherError::TooManyImpacts { impacts: strikes.len() });
        }
        Self::given(model, (force_periods, psi), strikes.into())
    }

    /// The same as one of twice as many impacts in twice its period.
    fn twice(&self) -> Result<Self, BreatherError> {
        let period = self.period();
        let later = |by: f64| self.strikes().map(move |strike| Strike { time: strike.time + by, ..strike });
        let strikes = later(0.0).chain(later(period)).collect();
        let (model, periods) = if self.is_self_excited() {
            (self.model().at(0.5 * self.model().omega())?, 1)
        } else {
            (self.model().clone(), 2 * self.force_periods())
        };
        Self::assembled(&model, periods, self.psi().unwrap_or(0.0), strikes)
    }

    /// The orbit next to this one that repeats itself after half the period or, mirrored, at the other barriers, in its own period: of neighbouring
    /// impacts the means. `None` where the impacts of its second half are neither.
    ///
    /// # Errors
    /// [`BreatherError`].
    pub fn evened(&self) -> Option<Result<Self, BreatherError>> {
        let (impacts, half) = (self.impacts(), self.impacts().len() / 2);
        let (one, other) = impacts.split_at(half);
        let pairs = || one.iter().zip(other);
        if half == 0 || other.len() != half || pairs().any(|(a, b)| a.site != b.site) {
            return None;
        }
        let again = pairs().all(|(a, b)| a.barrier == b.barrier);
        let mirrored = pairs().all(|(a, b)| a.barrier != b.barrier);
        let repeats = again && (self.is_self_excited() || self.force_periods().is_multiple_of(2));
        if !(repeats || mirrored) {
            return None;
        }
        let lapse = 0.5 * self.period();
        let shift = other[0].time;
        // Time alone mirrors an orbit between barriers that are not as far away.
        let alike = again || self.is_centred();
        let mean = |(a, b): (&Impact, &Impact)| {
            let mean = 0.5 * (a.impulse.abs() + b.impulse.abs()) * a.impulse.signum();
            let impulse = if alike { mean } else { a.impulse };
            let time = 0.5 * (a.time + b.time - shift);
            Strike { contact: a.site, barrier: a.barrier, time, impulse }
        };
        let mut strikes: Vec<Strike> = pairs().map(mean).collect();
        if mirrored {
            let image = |(a, b): (&Strike, &Impact)| Strike {
                barrier: b.barrier,
                time: a.time + lapse,
                impulse: if alike { -a.impulse } else { b.impulse },
                ..*a
            };
            let images: Vec<Strike> = strikes.iter().zip(other).map(image).collect();
            strikes.extend(images);
        }
        let psi = self.psi().unwrap_or(0.0) + 0.5 * (shift - lapse);
        let (periods, own) = (self.force_periods(), self.is_self_excited());
        let of = |model: &LoadedStructure, periods| Self::assembled(model, periods, psi, strikes);
        Some(match (repeats, own) {
            (true, true) => self.model().at(2.0 * self.model().omega()).and_then(|model| of(&model, periods)),
            (true, false) => of(self.model(), periods / 2),
            (false, _) => of(self.model(), periods),
        })
    }

    /// The same motion without one of its impacts, whatever impulse that has.
    ///
    /// # Errors
    /// [`BranchError`]: it has no other impact.
    pub fn without_impact(&self, lost: usize) -> Result<Self, BranchError> {
        self.reassembled(|i| i == lost, &[])
    }

    /// The same motion as an orbit of another word: without an impact that has no impulse left, with others that have none yet.
    fn exchanged(&self, lost: Option<usize>, touching: &[Hit]) -> Result<Self, BranchError> {
        let speed = |one: &Impact| one.velocity_before.abs();
        // Symmetry may have several lose their velocity at once.
        let is_lost =
            |i: usize| lost.is_some() && (Some(i) == lost || speed(&self.impacts()[i]) <= STILL * self.speed());
        let strike = |hit: &Hit| Ok(Strike { impulse: 0.0, ..self.model().strike(hit)? });
        let touching = touching.iter().map(strike).collect::<Result<Vec<Strike>, BreatherError>>()?;
        self.reassembled(is_lost, &touching)
    }

    fn reassembled(&self, is_lost: impl Fn(usize) -> bool, touching: &[Strike]) -> Result<Self, BranchError> {
        let period = self.period();
        let kept = self.strikes().enumerate().filter(|(i, _)| !is_lost(*i)).map(|(_, strike)| strike);
        let mut strikes: Vec<Strike> = kept.chain(touching.iter().copied()).collect();
        let first = strikes.first().ok_or(BranchError::Family)?.time;
        for strike in &mut strikes {
            strike.time = (strike.time - first).rem_euclid(period);
            // Where it is once more the first instant, but for rounding.
            if period - strike.time <= SIMULTANEOUS * period {
                strike.time = 0.0;
            }
        }
        strikes.sort_by(|one, other| one.time.total_cmp(&other.time));
        let psi = self.psi().unwrap_or(0.0) + first;
        Ok(Self::assembled(self.model(), self.force_periods(), psi, strikes)?)
    }
}

#[cfg(test)]
mod tests;
