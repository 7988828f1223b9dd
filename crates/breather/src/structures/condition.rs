//! How far an orbit can be trusted: its distance to the places where its equations lose their grip, and the errors of its impacts.

use std::sync::Arc;

use smallvec::SmallVec;
use vibrochain_lattice::{LinearMode, Turn};

use super::errors::{ImpactError, Together};
use super::orbit::ContactOrbit;
use crate::equations::System;
use crate::equations::linear::{Vector, zeros};
use crate::error::BreatherError;
use crate::orbit::{Impact, Orbit, time_between};
use crate::worse;

/// How well an orbit is determined: distances to resonance and grazing, the conditioning of its equations, and the errors that
/// follow. Dimensionless.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[must_use]
pub struct Condition {
    /// Distance to resonance: the smallest |λ_k − ijω|/|λ_k| over the poles λ_k of the modes that impacts feel and harmonics j ≥ 1, at most 1; ω is
    /// the orbit's base frequency. So many digits of the kernels are lost as this has zeros.
    pub resonance: f64,
    /// Distance to grazing: the smallest velocity before an impact, in units of ω times half the gap of its contact, or of a single stop times its
    /// distance from 0. Saltation grows like its inverse.
    pub grazing: f64,
    /// Reciprocal condition number of the orbit's equations, rows and columns scaled: at most 1, and 0 at a fold or a pitchfork,
    /// but no distance to either. For a mirror-symmetric conservative orbit, whose times are fixed, of the equations for its impulses alone.
    pub fold: f64,
    /// A bound of the error of the phase ψ, as a time; 0 without loads, not finite where none is known.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub psi_error: f64,
    /// Bounds of the errors of the impacts, not finite where none are known.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub impacts: SmallVec<[ImpactError; 2]>,
    /// The same by origin: what depends on several data of the orbit moves by the sum over these of the moduli, and hardly at all
    /// where the errors of one origin cancel.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub origins: Vec<Together>,
    /// The largest impulse, the period, and that of the loads.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) scales: [f64; 3],
}

impl Condition {
    /// Largest error of an impulse, relative to the largest impulse.
    pub fn impulse_error(&self) -> f64 {
        self.impacts.iter().map(|error| error.impulse).fold(0.0, worse) / self.scales[0]
    }

    /// Largest error of a time relative to the period of the orbit, or of the phase relative to that of the loads.
    pub fn time_error(&self) -> f64 {
        let phase = self.psi_error / self.scales[2];
        self.impacts.iter().map(|error| error.time / self.scales[1]).fold(phase, worse)
    }

    /// Where nothing is known of an orbit's impacts.
    pub(crate) fn lost(impacts: usize) -> Self {
        let impacts: Together = SmallVec::from_elem(ImpactError::LOST, impacts);
        let origins = vec![impacts.clone()];
        Self { psi_error: f64::INFINITY, origins, impacts, scales: [1.0; 3], ..Self::default() }
    }

    /// That of an orbit as contacts know it; of a lattice's, those at the masses that are hit.
    pub(crate) fn of(
        orbit: &Orbit,
        at_contacts: Result<Arc<ContactOrbit>, BreatherError>,
    ) -> Result<Self, BreatherError> {
        match at_contacts.and_then(|refined| Ok(refined.condition()?.from(&refined, orbit))) {
            Err(stopped @ BreatherError::Stopped(_)) => Err(stopped),
            // Exactly at a resonance the lattice has no kernel.
            Err(_) => Ok(Self::lost(orbit.impacts().len())),
            Ok(condition) => Ok(condition),
        }
    }

    /// The condition of a lattice's orbit from that of the structure's: the distance between the two adds to the bounds.
    fn from(mut self, refined: &ContactOrbit, orbit: &Orbit) -> Self {
        let since = |i: usize| orbit.impacts()[i].time - orbit.impacts()[0].time;
        let apart = |(i, (own, other)): (usize, (&Impact, &Impact))| ImpactError {
            time: other.time - since(i),
            impulse: other.impulse - own.impulse,
            acceleration: other.acceleration - own.acceleration,
        };
        let all_apart = orbit.impacts().iter().zip(refined.impacts()).enumerate().map(apart);
        for (bound, apart) in self.impacts.iter_mut().zip(all_apart) {
            bound.time += apart.time.abs();
            bound.impulse += apart.impulse.abs();
            bound.acceleration += apart.acceleration.abs();
        }
        let phase = |psi: f64| time_between(psi, orbit.psi_or_zero() + orbit.impacts()[0].time, orbit.force_period());
        self.psi_error += refined.psi().map_or(0.0, phase);
        self
    }
}

impl ContactOrbit {
    /// How far it can be trusted.
    ///
    /// # Errors
    /// [`BreatherError::Stopped`].
    pub fn condition(&self) -> Result<Condition, BreatherError> {
        let strongest = self.impacts().iter().map(|one| one.impulse.abs()).fold(f64::MIN_POSITIVE, f64::max);
        Ok(Condition {
            resonance: self.distance_to_resonance(),
            grazing: self.impacts().iter().map(|one| self.relative_speed(one)).fold(f64::INFINITY, f64::min),
            fold: self.reciprocal_condition(strongest)?,
            psi_error: self.psi_error(),
            impacts: self.impact_errors().into(),
            origins: self.error_origins().to_vec(),
            scales: [strongest, self.period(), self.model().period()],
        })
    }

    fn distance_to_resonance(&self) -> f64 {
        let omega = std::f64::consts::TAU / self.period();
        let distance = |mode: &LinearMode| {
            let harmonic = (mode.rate / omega).round().max(1.0);
            (mode.rate - harmonic * omega).hypot(mode.decay) / mode.rate.hypot(mode.decay)
        };
        // Real poles are farther from every ijω than from 0.
        let modes = self.response().kernel.felt.modes.iter().filter(|mode| mode.turn == Turn::Circular);
        modes.map(distance).fold(1.0, f64::min)
    }

    /// The speed of an impact in units of ω times half its contact's gap.
    fn relative_speed(&self, impact: &Impact) -> f64 {
        let contact = self.model().structure().contacts()[impact.site];
        let length = match (contact.lower, contact.upper) {
            (Some(lower), Some(upper)) => 0.5 * (upper - lower),
            (one, other) => one.or(other).unwrap_or(0.0).abs(),
        };
        impact.velocity_before.abs() / (self.model().omega() * length.max(f64::MIN_POSITIVE))
    }

    fn reciprocal_condition(&self, strongest: f64) -> Result<f64, BreatherError> {
        let (equations, point) = self.equations()?;
        let (equations, point) = equations.opened(&point).unwrap_or((equations, point));
        let (n, system) = (point.strikes.len(), equations.system(&point)?);
        let mut units: Vector = zeros(system.rows.len());
        units[..n].fill(strongest);
        units[equations.times(n)].fill(self.period());
        let reach = strongest * self.period() * equations.mobility(point.strikes[0].contact);
        let offsets = units[equations.times(n).end..].iter_mut().zip(&point.offsets);
        offsets.for_each(|(unit, offset)| *unit = offset.abs().max(reach));
        Ok(System::new(system.jacobian, &units).reciprocal_condition)
    }
}
