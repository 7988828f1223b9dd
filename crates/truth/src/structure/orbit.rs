//! An orbit of a structure whose impulses, times and phase are good to all digits.

use vibrochain_breather::{Hit, Orbit};
use vibrochain_lattice::{Barrier, Structure};

use super::saltation::monodromy;
use super::shooting::{Closing, Round, Shooting, Solved, StructureStart};
use crate::error::TruthError;
use crate::linear::{Matrix, dot};
use crate::real::Real;

/// One impact of a [`TrueStructureOrbit`], in units of the structure's.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueStructureImpact {
    /// Number of the contact.
    pub contact: usize,
    /// The barrier it meets.
    pub barrier: Barrier,
    /// Time from the first impact on.
    pub time: Real,
    /// The momentum that the barrier gives, signed.
    pub impulse: Real,
    /// Velocity of the contact just before.
    pub velocity_before: Real,
    /// Its acceleration just before, loads and dashpots included.
    pub acceleration_before: Real,
}

/// What an `f64` orbit of a structure is wrong by, in units of the structure's; lists in the order of its impacts.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureErrors {
    /// Of impulses.
    pub impulses: Vec<f64>,
    /// Of times.
    pub times: Vec<f64>,
    /// Of accelerations just before impacts.
    pub accelerations: Vec<f64>,
    /// Of ψ; 0 without loads.
    pub psi: f64,
    /// Of the period.
    pub period: f64,
}

/// An orbit of a structure to all digits.
///
/// ```
/// use std::sync::Arc;
/// use nalgebra::{DMatrix, DVector};
/// use vibrochain_breather::LoadedStructure;
/// use vibrochain_lattice::{Complex, Contact, Structure};
/// use vibrochain_truth::{DEFAULT_BITS, TrueStructureOrbit};
/// // q″ + 0.1 q′ + q = cos ωt, a stop at 0.1.
/// let structure = Structure {
///     mass: DMatrix::identity(1, 1),
///     damping: DMatrix::from_element(1, 1, 0.1),
///     stiffness: DMatrix::identity(1, 1),
///     contacts: vec![(DVector::from_element(1, 1.0), Contact { lower: None, upper: Some(0.1), restitution: 0.8 })],
///     loads: vec![(1, DVector::from_element(1, Complex::new(1.0, 0.0)))],
///     ..Structure::default()
/// };
/// let model = LoadedStructure::new(Arc::new(structure.modal()?), 2.325)?;
/// let orbits = model.orbits(&"0+".parse()?, 1)?.orbits;
/// let orbit = orbits.iter().max_by(|a, b| b.impacts()[0].impulse.total_cmp(&a.impacts()[0].impulse)).unwrap();
/// let truth = TrueStructureOrbit::refine(&structure, orbit, DEFAULT_BITS)?;
/// assert!(truth.errors_of(orbit)?.impulses[0] < 1e-14);
/// assert!((truth.spectral_radius() - 0.6988872749041013).log10_abs() < -15.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct TrueStructureOrbit {
    bits: usize,
    force_periods: u32,
    period: Real,
    psi: Option<Real>,
    impacts: Vec<TrueStructureImpact>,
    last_step: f64,
    residual: Real,
    monodromy: Matrix,
}

impl TrueStructureOrbit {
    /// Solves an orbit's equations to `bits` binary digits; `structure` is what its modes were made of.
    ///
    /// # Errors
    /// As [`TrueStructureOrbit::near`].
    pub fn refine(structure: &Structure, orbit: &Orbit, bits: usize) -> Result<Self, TruthError> {
        let hit =
            |impact: &vibrochain_breather::Impact| Hit::new(impact.site, impact.barrier, impact.time, impact.impulse);
        let impacts: Vec<Hit> = orbit.impacts().iter().map(hit).collect();
        let (omega, psi) = (orbit.omega(), orbit.psi().unwrap_or(0.0));
        let start = StructureStart { structure, omega, force_periods: orbit.force_periods(), psi, impacts: &impacts };
        Self::near(&start, bits)
    }

    /// The orbit that Newton's method leads to from given impacts, to `bits` binary digits. How far it is from there is for the caller to
    /// judge. Without loads the period is that of `omega` where nothing takes energy or gives any, else it is found, too.
    ///
    /// # Errors
    /// [`TruthError::NotConverged`] where Newton's method does not settle; [`TruthError::Singular`]; [`TruthError::Mismatch`] and
    /// [`TruthError::Parameter`] for a structure or impacts that are none.
    pub fn near(start: &StructureStart<'_>, bits: usize) -> Result<Self, TruthError> {
        let Solved { shooting, unknowns, last_step } = start.solve(bits)?;
        let round = shooting.round(&unknowns);
        let n = shooting.flow.coordinates();
        let impact = |(i, hit): (usize, &Hit)| {
            let (own, before) = (&shooting.hits[i], &round.before[i]);
            let seen = |state: &[Real]| shooting.flow.unscaled(&dot(&own.weights, &state[n..2 * n]));
            TrueStructureImpact {
                contact: hit.site,
                barrier: hit.barrier,
                time: unknowns.times[i].clone(),
                impulse: shooting.impulse(own, before),
                velocity_before: seen(before),
                acceleration_before: seen(&shooting.flow.slope(before)),
            }
        };
        let impacts = start.impacts.iter().enumerate().map(impact).collect();
        let forced = shooting.closing == Closing::Phase;
        Ok(Self {
            bits,
            force_periods: start.force_periods,
            psi: forced.then_some(unknowns.psi),
            impacts,
            last_step,
            residual: residual(&shooting, &round),
            monodromy: monodromy(&shooting, &round)?,
            period: unknowns.period,
        })
    }

    /// Binary digits asked for.
    pub fn bits(&self) -> usize {
        self.bits
    }

    /// Period of the orbit.
    pub fn period(&self) -> &Real {
        &self.period
    }

    /// Phase ψ of the loads at the first impact, as a time; `None` without loads.
    pub fn psi(&self) -> Option<&Real> {
        self.psi.as_ref()
    }

    /// The impacts in order of time.
    pub fn impacts(&self) -> &[TrueStructureImpact] {
        &self.impacts
    }

    /// log₂ of the last step, taken in more digits than those before, relative to the orbit: how many digits are known.
    pub fn last_step_log2(&self) -> f64 {
        self.last_step
    }

    /// Largest distance of an impact from its stop, and of the end of the period from its beginning (velocities in the unit of the state).
    pub fn residual(&self) -> &Real {
        &self.residual
    }

    /// The monodromy matrix of (q, q′) from just before the first impact, velocities in a unit of its own; in rows.
    pub fn monodromy(&self) -> &[Vec<Real>] {
        &self.monodromy
    }

    /// The errors of an `f64` orbit with the same impacts.
    ///
    /// # Errors
    /// [`TruthError::Mismatch`] for other impacts.
    pub fn errors_of(&self, orbit: &Orbit) -> Result<StructureErrors, TruthError> {
        let pairs: Vec<_> = self.impacts.iter().zip(orbit.impacts()).collect();
        let same = |(truth, impact): &(&TrueStructureImpact, &vibrochain_breather::Impact)| {
            (truth.contact, truth.barrier) == (impact.site, impact.barrier)
        };
        let fits = orbit.impacts().len() == self.impacts.len() && orbit.force_periods() == self.force_periods;
        if !fits || !pairs.iter().all(same) {
            return Err(TruthError::Mismatch { what: "the impacts" });
        }
        let off = |truth: &Real, told: f64| (truth - told).abs().to_f64();
        let around = |truth: &Real, told: f64, period: &Real| {
            let distance = truth - told;
            let turns = (&distance / period + 0.5).floor();
            (distance - turns * period).abs().to_f64()
        };
        let force_period = &self.period / f64::from(self.force_periods);
        Ok(StructureErrors {
            impulses: pairs.iter().map(|(truth, told)| off(&truth.impulse, told.impulse)).collect(),
            times: pairs.iter().map(|(truth, told)| around(&truth.time, told.time, &self.period)).collect(),
            accelerations: (pairs.iter())
                .map(|(truth, told)| off(&truth.acceleration_before, told.acceleration))
                .collect(),
            psi: match (&self.psi, orbit.psi()) {
                (Some(truth), Some(told)) => around(truth, told, &force_period),
                _ => 0.0,
            },
            period: off(&self.period, orbit.period()),
        })
    }
}

fn residual(shooting: &Shooting, round: &Round) -> Real {
    let n = shooting.flow.coordinates();
    let stops = shooting.hits.iter().zip(&round.before);
    let stops = stops.map(|(hit, before)| dot(&hit.weights, &before[..n]) - &hit.stop);
    let (first, last) = (&round.before[0], &round.before[shooting.hits.len()]);
    let returns = first.iter().zip(last).take(2 * n).map(|(a, b)| a - b);
    stops.chain(returns).map(|x| x.abs()).fold(Real::zero(64), |a, b| if b > a { b } else { a })
}
