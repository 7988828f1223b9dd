//! One run from a perturbed breather: how it ends, and when it leaves.

use vibrochain_breather::{BreatherError, LoadedStructure, Orbit};
use vibrochain_eventsim::{Event, Exponent, Growth, Limits, Outcome, Report, Simulation, Tangents, Time};
use vibrochain_lattice::Stop;

use crate::end::End;
use crate::ensemble::Ensemble;
use crate::follow::{Follower, Track};
use crate::origin::Origin;
use crate::repeat::Latest;

/// Periods at the end whose impacts are looked at: enough for a slow drift to show, few enough for a run that has just settled.
pub const LOOKED_AT: u64 = 64;

/// What is nearer than this part of the tolerance to the impact before is of its instant: what a tolerance of times makes of masses
/// that hit together. (The breather's own instants stay apart, however near they are.)
pub(crate) const CLOSE: f64 = 0.5;

/// A perturbation has grown faster than by a power of time if it has grown so often by e more than the square of the periods gone by:
/// neighbours that run ahead of each other grow by the first power, where two such motions feed each other by the second.
const BEYOND_POWERS: f64 = 7.0;

/// Periods after the transient from which on a power of time can be told from a run that is still on its way.
const TOLD_APART: u64 = 256;

/// Standard errors that an exponent must be away from zero.
const CLEARLY: f64 = 3.0;

/// A breather to start from, or another origin, with what every run from it needs.
#[derive(Debug, Clone)]
pub struct Home {
    pub(crate) origin: Origin,
    track: Track,
}

/// What has become of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Fate {
    /// How it ended.
    pub end: End,
    /// When it left the breather, in periods of the force since the start, if it did. It may have come back since.
    pub left: Option<f64>,
    /// The largest Lyapunov exponent after the transient, where there is one.
    pub exponent: Option<Exponent>,
}

impl Home {
    /// Prepares runs from an orbit.
    ///
    /// # Errors
    /// [`BreatherError`] if its motion is not defined.
    pub fn of(orbit: &Orbit) -> Result<Self, BreatherError> {
        Ok(Self::with(Origin::on(orbit)?))
    }

    /// Prepares runs from a structure at rest under its static load: what it settles on by itself.
    #[must_use]
    pub fn at_rest(model: &LoadedStructure) -> Self {
        Self::with(Origin::at_rest(model))
    }

    /// Whether contacts that share coordinates and hit at one instant do so in sequence, whatever the ensemble says.
    #[must_use]
    pub fn in_sequence(self, in_sequence: bool) -> Self {
        Self { origin: self.origin.in_sequence(in_sequence), ..self }
    }

    fn with(origin: Origin) -> Self {
        Self { track: origin.track(), origin }
    }

    /// Runs from a perturbation drawn from `seed`. `None` if the stop flag is raised.
    #[must_use]
    pub fn run(&self, ensemble: &Ensemble, seed: u64, stop: &Stop) -> Option<Fate> {
        let incomplete = |left| Some(Fate { end: End::Incomplete, left, exponent: None });
        let Some(simulation) = self.origin.run(Some((ensemble.size, seed)), stop) else { return incomplete(None) };
        let Ok(mut tangents) = simulation.tangents(1, seed) else { return incomplete(None) };
        let mut simulation = if ensemble.in_sequence { simulation.in_sequence() } else { simulation };
        let mut follower = Follower::new(&self.track, self.origin.time, ensemble.leave);
        let mut latest = Latest::default();
        let close = CLOSE * ensemble.tolerance.min(self.track.shortest_wait() / self.track.unit);
        let (skipped, periods) = (ensemble.skipped(), ensemble.periods);
        let looked_at = periods - LOOKED_AT.min(periods - skipped);
        let mut growth = None;
        for period in 1..=periods {
            let until = simulation.time_of(period, 0.0);
            let observe = |event: &Event| {
                follower.see(event);
                if period > looked_at {
                    latest.see(event, close);
                }
            };
            let carried = (period > skipped).then_some(&mut tangents);
            let reached = reach(&mut simulation, carried, until, observe)?;
            follower.reach(simulation.time());
            if reached.outcome != Outcome::TimeReached {
                return incomplete(follower.left());
            }
            if period > skipped {
                let now = simulation.time().to_f64();
                let growth = growth.get_or_insert_with(|| Growth::from(now - self.track.unit, 0.0));
                growth.reach(now, tangents.orthonormalise()[0]);
            } else if period == skipped {
                growth = Some(Growth::from(simulation.time().to_f64(), 0.0));
            }
        }
        let growth = growth.filter(|_| !tangents.has_grazed());
        let exponent = growth.as_ref().and_then(Growth::exponent);
        let end = self.end(latest, growth.map(|growth| growth.total()), exponent, ensemble);
        Some(Fate { end, left: follower.left(), exponent })
    }

    fn end(&self, mut latest: Latest, grown: Option<f64>, exponent: Option<Exponent>, ensemble: &Ensemble) -> End {
        let tolerance = ensemble.tolerance;
        if latest.is_empty() {
            return End::Quiet;
        }
        latest.trim();
        if latest.is(&self.track, self.origin.time, tolerance) {
            return End::Breather;
        }
        let repeated = latest.repeated(tolerance, self.track.forced);
        if let Some(word) = repeated.and_then(|instants| self.origin.word(instants)) {
            return End::Periodic(word);
        }
        // What a power of time allows.
        let looked_at = ensemble.periods - ensemble.skipped();
        let powers = 2.0 * (looked_at as f64).ln() + BEYOND_POWERS;
        match (grown, exponent) {
            (Some(grown), Some(exponent)) if grown > powers && exponent.value > CLEARLY * exponent.error => End::Chaos,
            (Some(grown), _) if grown.abs() <= powers && looked_at >= TOLD_APART => End::QuasiPeriodic,
            _ => End::Unclassified,
        }
    }
}

/// Carries a run to a time, with tangent vectors of its model or without. `None` if the stop flag that it heeds is raised.
pub(crate) fn reach(
    run: &mut Simulation,
    tangents: Option<&mut Tangents>,
    until: Time,
    observe: impl FnMut(&Event),
) -> Option<Report> {
    let limits = Limits::until(until);
    let report = match tangents {
        Some(tangents) => run.run_with(tangents, &limits, observe).ok()?,
        None => run.run(&limits, observe),
    };
    (report.outcome != Outcome::Stopped).then_some(report)
}
