//! A periodic orbit of a structure, and how far it can be trusted.

use std::sync::Arc;

use smallvec::SmallVec;
use vibrochain_lattice::Stop;

use super::equations::{Equations, System};
use super::errors::{ImpactError, OrbitErrors, Together};
use super::model::LoadedStructure;
use super::point::{Point, Strike};
use super::response::Response;
use crate::error::BreatherError;
use crate::orbit::delicate::UNSEEN;
use crate::orbit::impact::{Hit, Impact};
use crate::word::MAX_IMPACTS;
use crate::worse;

/// A periodic orbit of a structure.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactOrbit {
    model: LoadedStructure,
    response: Arc<Response>,
    force_periods: u32,
    psi: Option<f64>,
    /// Errors of the impacts, and of ψ, to first order.
    estimates: Together,
    psi_estimate: f64,
    /// A bound of that of ψ.
    psi_error: f64,
    period_error: f64,
    offsets: SmallVec<[f64; 1]>,
    impacts: Vec<Impact>,
    /// Bounds of their errors.
    errors: Together,
    /// The largest violation of the conditions at the impacts, against their terms.
    violation: f64,
    /// Bounds of the impacts' errors by origin.
    origins: Vec<Together>,
}

impl ContactOrbit {
    pub(super) fn new(
        equations: &Equations<'_>,
        force_periods: u32,
        (point, system): (Point, System),
    ) -> Result<Self, BreatherError> {
        if let Some((equations, point)) = equations.opened(&point)
            && let Ok((opened, system)) = equations.solve(point.clone())
            && opened.is_near(&point)
        {
            return Self::assembled_at(&equations, force_periods, (&opened, &system), false);
        }
        Self::at_own_period(equations, force_periods, (&point, &system), false)
    }

    /// The orbit at a point on the way to one of a branch: its errors have bounds where first order tells them.
    pub(super) fn on_the_way(
        equations: &Equations<'_>,
        force_periods: u32,
        at: (&Point, &System),
    ) -> Result<Self, BreatherError> {
        Self::at_own_period(equations, force_periods, at, true)
    }

    /// Whether all its errors have bounds.
    pub fn has_bounds(&self) -> bool {
        let finite = |error: &ImpactError| (error.time + error.impulse + error.acceleration).is_finite();
        self.origins.iter().flatten().all(finite)
    }

    /// The same with all bounds of errors that there are: of an orbit on the way of a branch those beyond first order are left out.
    ///
    /// # Errors
    /// [`BreatherError`] at a resonance.
    pub fn with_bounds(self) -> Result<Self, BreatherError> {
        if self.has_bounds() {
            return Ok(self);
        }
        let (equations, point) = self.equations()?;
        let system = equations.system(&point)?;
        Self::at_own_period(&equations, self.force_periods, (&point, &system), false)
    }

    /// The same of one that several hold.
    pub(crate) fn bounded(self: Arc<Self>) -> Result<Arc<Self>, BreatherError> {
        if self.has_bounds() { Ok(self) } else { Ok(Arc::new(Self::clone(&self).with_bounds()?)) }
    }

    /// The orbit at a point of the equations, which next to a resonance may be off more than rounding.
    fn at_own_period(
        equations: &Equations<'_>,
        force_periods: u32,
        (point, system): (&Point, &System),
        on_the_way: bool,
    ) -> Result<Self, BreatherError> {
        if equations.self_excited {
            let all =
                |equations: &Equations<'_>| Self::assembled_at(equations, force_periods, (point, system), on_the_way);
            return equations.at_period(point.period, all);
        }
        Self::assembled_at(equations, force_periods, (point, system), on_the_way)
    }

    /// The orbit at a point of the equations of its own period.
    fn assembled_at(
        equations: &Equations<'_>,
        force_periods: u32,
        (point, system): (&Point, &System),
        on_the_way: bool,
    ) -> Result<Self, BreatherError> {
        if !equations.is_mirrored
            && let Some((mirrored, point)) = equations.of_mirrored(point)
        {
            let system = mirrored.system(&point)?;
            return Self::assembled_at(&mirrored, force_periods, (&point, &system), on_the_way);
        }
        let n = point.strikes.len();
        let OrbitErrors { unknowns, accelerations, origins, estimates } =
            OrbitErrors::of(equations, point, system, on_the_way)?;
        let impact = |i: usize| {
            let (strike, arrival) = (&point.strikes[i], &system.arrivals[i]);
            Impact {
                site: strike.contact,
                barrier: strike.barrier,
                time: strike.time,
                impulse: strike.impulse,
                velocity_before: arrival.velocity,
                // From 0, so that none is left as 0 and not as −0.
                velocity_after: 0.0 - equations.restitution(strike.contact) * arrival.velocity,
                acceleration: arrival.acceleration,
            }
        };
        let impacts: Vec<Impact> = (0..n).map(impact).collect();
        let bound = |i: usize| {
            let error = equations.impact_error(n, i, &unknowns, accelerations[i]);
            ImpactError { time: error.time + equations.fixed_time_error(&point.strikes[i]), ..error }
        };
        let violation = system
            .rows
            .iter()
            .zip(&system.sizes)
            .map(|(row, size)| row.abs() / size.max(f64::MIN_POSITIVE))
            .fold(0.0, f64::max);
        let period = equations.model.period();
        let [of_unknowns, of_accelerations] = estimates;
        let estimate = |i: usize| equations.impact_error(n, i, &of_unknowns, of_accelerations[i]);
        let of_psi = |list: &[f64]| equations.psi(n).map_or(0.0, |place| list[place]);
        Ok(Self {
            model: equations.model.clone(),
            response: equations.model.response(&equations.hit, force_periods)?,
            force_periods,
            psi: equations.forced.then(|| point.psi.rem_euclid(period)),
            estimates: (0..n).map(estimate).collect(),
            psi_estimate: of_psi(&of_unknowns),
            psi_error: of_psi(&unknowns),
            period_error: if equations.self_excited { unknowns[2 * n - 1] } else { 0.0 },
            offsets: equations.all_offsets(&point.offsets),
            impacts,
            errors: (0..n).map(bound).collect(),
            violation,
            origins,
        })
    }

    /// The orbit as it is given by its impacts, in order of time from 0 on, and where rigid modes put them on their barriers.
    pub(super) fn given(
        model: &LoadedStructure,
        (force_periods, psi): (u32, f64),
        strikes: SmallVec<[Strike; 4]>,
    ) -> Result<Self, BreatherError> {
        let equations = Equations::new(model, force_periods, strikes.iter().map(|strike| strike.contact))?;
        let offsets = smallvec::smallvec![0.0; equations.rigid.len()];
        let point = equations.with_offsets(Point { strikes, psi, period: equations.period(), offsets })?;
        let system = equations.system(&point)?;
        Self::new(&equations, force_periods, (point, system))
    }

    /// Its equations, and where it is in them.
    pub(super) fn equations(&self) -> Result<(Equations<'_>, Point), BreatherError> {
        let equations = Equations::new(&self.model, self.force_periods, self.impacts.iter().map(|one| one.site))?;
        let point = Point {
            strikes: self.strikes().collect(),
            psi: self.psi.unwrap_or(0.0),
            period: self.period(),
            offsets: equations.felt_offsets(&self.offsets),
        };
        Ok(equations.of_mirrored(&point).unwrap_or((equations, point)))
    }

    /// The orbit of given impacts, refined from there by Newton's method: in order of time, the contact of each as its site. A period of its own
    /// begins as the model's.
    ///
    /// # Errors
    /// [`BreatherError`]: a contact or barrier that is not there, a resonance, or no orbit near enough.
    pub fn near(model: &LoadedStructure, force_periods: u32, psi: f64, impacts: &[Hit]) -> Result<Self, BreatherError> {
        if impacts.len() > MAX_IMPACTS {
            return Err(BreatherError::TooManyImpacts { impacts: impacts.len() });
        }
        let (first, period) =
            (impacts.first().map_or(0.0, |impact| impact.time), model.period() * f64::from(force_periods));
        if !in_order(impacts.iter().map(|impact| impact.time - first), period) {
            return Err(BreatherError::OutOfOrder { found: false });
        }
        let strike = |hit: &Hit| Ok(Strike { time: hit.time - first, ..model.strike(hit)? });
        let strikes = impacts.iter().map(strike).collect::<Result<SmallVec<[Strike; 4]>, BreatherError>>()?;
        let contacts: Vec<usize> = strikes.iter().map(|strike| strike.contact).collect();
        let equations = Equations::new(model, force_periods, contacts.iter().copied())?;
        let point =
            Point { strikes, psi: psi + first, period, offsets: smallvec::smallvec![0.0; equations.rigid.len()] };
        let point = equations.with_offsets(point)?;
        let (equations, point) = equations.of_mirrored(&point).unwrap_or((equations, point));
        let mut solved = equations.solve(point.clone())?;
        let turned = solved.0.in_turn(&point).ok_or(BreatherError::OutOfOrder { found: true })?;
        if turned != solved.0 {
            let system = equations.system(&turned)?;
            solved = (turned, system);
        }
        if !equations.self_excited {
            equations.off_resonance(&contacts)?;
        }
        Self::new(&equations, force_periods, solved)
    }

    /// The same orbit begun with another impact.
    ///
    /// # Errors
    /// [`BreatherError`]
    pub(crate) fn begun_with(&self, first: usize) -> Result<Self, BreatherError> {
        let (period, start) = (self.period(), self.impacts[first].time);
        let psi = self.model.phase(self.psi.unwrap_or(0.0) + start);
        let mut strikes: SmallVec<[Strike; 4]> = self.strikes().collect();
        strikes.rotate_left(first);
        strikes.iter_mut().for_each(|strike| strike.time = (strike.time - start).rem_euclid(period));
        Self::given(&self.model, (self.force_periods, psi), strikes)
    }

    /// The same, of which all is worked out no longer than until the request to stop is raised.
    pub(crate) fn until(self: &Arc<Self>, stop: &Stop) -> Arc<Self> {
        if self.model.stop().is_same(stop) {
            return self.clone();
        }
        Arc::new(Self { model: self.model.clone().until(stop), ..Self::clone(self) })
    }

    /// The model.
    pub fn model(&self) -> &LoadedStructure {
        &self.model
    }

    /// Whether neither impacts nor modes lose energy.
    pub fn is_lossless(&self) -> bool {
        self.model.structure().is_lossless()
    }

    /// The fastest velocity before an impact, or the fastest that its acceleration makes in 1/ω: what velocities are measured by
    /// (dimensionless).
    pub fn speed(&self) -> f64 {
        let of = |one: &Impact| one.velocity_before.abs().max(one.acceleration.abs() / self.model.omega());
        self.impacts.iter().map(of).fold(f64::MIN_POSITIVE, f64::max)
    }

    /// What contacts do after impacts and under the loads.
    pub(super) fn response(&self) -> &Response {
        &self.response
    }

    /// Periods of the load in one of the orbit.
    pub fn force_periods(&self) -> u32 {
        self.force_periods
    }

    /// The orbit's period.
    pub fn period(&self) -> f64 {
        self.model.period() * f64::from(self.force_periods)
    }

    /// The phase ψ of the loads, as a time, at the first impact; `None` without loads that change.
    pub fn psi(&self) -> Option<f64> {
        self.psi
    }

    /// How far it may be off at most, times as parts of the period and impulses as parts of the strongest.
    pub(super) fn error(&self) -> f64 {
        let strongest = self.impacts.iter().map(|impact| impact.impulse.abs()).fold(f64::MIN_POSITIVE, f64::max);
        let off = |one: &ImpactError| (one.time / self.period()).max(one.impulse / strongest);
        self.estimates.iter().map(off).fold(self.psi_estimate / self.period(), f64::max)
    }

    /// Whether its errors could show in a verdict: to first order a time, an impulse or an acceleration is off by more than a small part of what
    /// it counts by.
    pub fn is_delicate(&self) -> bool {
        let omega = std::f64::consts::TAU / self.period();
        let off = |(one, error): (&Impact, &ImpactError)| {
            let impulse = one.impulse.abs();
            (error.time * omega).max(error.impulse / impulse).max(error.acceleration / (omega * impulse))
        };
        let most = self.impacts.iter().zip(&self.estimates).map(off).fold(self.psi_estimate * omega, worse);
        most > UNSEEN
    }

    /// Errors of an impact to first order, which are there where no bound is known, too.
    pub(super) fn estimate(&self, i: usize) -> ImpactError {
        self.estimates[i]
    }

    /// Error of ψ to first order.
    pub(super) fn psi_estimate(&self) -> f64 {
        self.psi_estimate
    }

    /// A bound of the error of ψ, not finite where none is known; 0 without loads that change.
    pub fn psi_error(&self) -> f64 {
        self.psi_error
    }

    /// Where each rigid mode is; in the order of the modes.
    pub fn offsets(&self) -> &[f64] {
        &self.offsets
    }

    /// The impacts, in order of time; the first one at 0. Contacts stand in place of sites.
    pub fn impacts(&self) -> &[Impact] {
        &self.impacts
    }

    /// Bounds of the errors of the impacts, for the matrices or modes as they are given; not finite where none is known, as next to a fold.
    pub fn impact_errors(&self) -> &[ImpactError] {
        &self.errors
    }

    /// The impulses, in the order of the impacts.
    pub fn impulses(&self) -> Vec<f64> {
        self.impacts.iter().map(|impact| impact.impulse).collect()
    }

    /// The time of the second impact of two.
    pub fn phi(&self) -> Option<f64> {
        match &self.impacts[..] {
            [_, second] => Some(second.time),
            _ => None,
        }
    }

    /// The largest violation of the conditions at the impacts, against their terms.
    pub fn violation(&self) -> f64 {
        self.violation
    }

    /// Bounds of the errors of its impacts by origin, with signs: what depends on several data of the orbit moves by the sum over these of the
    /// moduli. Not finite where no bound is known.
    pub fn error_origins(&self) -> &[Together] {
        &self.origins
    }

    /// Whether neither loads that change nor losses are there: the orbit may begin at any time.
    pub fn is_conservative(&self) -> bool {
        self.psi.is_none() && self.model.structure().is_lossless()
    }

    /// Whether no load acts on it, but losses that a dashpot of negative damping makes up for: it has a period of its own, and may begin at any time.
    pub fn is_self_excited(&self) -> bool {
        self.psi.is_none() && !self.model.structure().is_lossless()
    }

    /// The error of the period: 0 where a frequency gives it.
    pub fn period_error(&self) -> f64 {
        self.period_error
    }

    /// The impacts as their equations know them.
    pub(super) fn strikes(&self) -> impl Iterator<Item = Strike> + '_ {
        let strike =
            |one: &Impact| Strike { contact: one.site, barrier: one.barrier, time: one.time, impulse: one.impulse };
        self.impacts().iter().map(strike)
    }

    /// The impacts as they are given, in order of time: in a lattice by its masses, else with the contact as the site.
    pub fn hits(&self) -> Vec<Hit> {
        let site = |impact: &Impact| self.model.site(impact.site);
        let of = |impact: &Impact| Hit::new(site(impact), impact.barrier, impact.time, impact.impulse);
        self.impacts.iter().map(of).collect()
    }
}

/// Whether times rise, or stay, within a period from 0 on.
pub(super) fn in_order(times: impl Iterator<Item = f64>, period: f64) -> bool {
    let mut last = 0.0;
    for time in times {
        if !(last..period).contains(&time) {
            return false;
        }
        last = time;
    }
    true
}
