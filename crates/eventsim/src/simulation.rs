//! The event loop and its public face.

use crate::cascade::{Cascade, Cascades, Change};
use crate::engine::Engine;
use crate::error::{StateError, TangentError};
use crate::event::{BOUNCE_TIME, Event, Limits, Outcome, Report, Work};
use crate::ring::{FORGET, Ring};
use crate::stop_check::StopCheck;
use crate::tangent::{Alone, Company, Tangents};
use crate::time::Time;
use crate::units::Units;
use vibrochain_lattice::{Barrier, Layout, Model, Stop};

/// Largest speed and force in units of the gap and of the fastest rate.
const FASTEST: f64 = 1e12;

/// How far behind a barrier a mass may start: the rounding of its displacement. It is put on the barrier.
const OVERSHOOT: f64 = 4.0 * f64::EPSILON;

/// Events in a row without any effect before the run gives up; a mass whose force touches zero makes one or two.
const STALLS: u32 = 1000;

/// State of a chain: displacements and velocities of all masses, phase of the force, and time.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct State {
    /// u_n, one a mass.
    pub displacement: Vec<f64>,
    /// u̇_n, one a mass; at an event, just after it.
    pub velocity: Vec<f64>,
    /// Phase ψ of the force at time zero: it is A cos ω(t+ψ), or the sum of its harmonics at t+ψ.
    pub psi: f64,
    /// The time t.
    pub time: Time,
}

/// An event-driven simulation of a vibro-impact chain: exact flight between certified events. The lattice may be a ring, a row
/// with free or fixed ends, or several layers of rows; masses are numbered as [`vibrochain_lattice::Chain`] numbers them.
///
/// ```
/// use vibrochain_eventsim::{Limits, Outcome, Simulation, Time};
/// use vibrochain_lattice::{Chain, Model, Point};
///
/// // One mass between its barriers at −1 and 1: u = 2 sin t until it hits.
/// let model = Point::ring(1).gamma1(1.0).gamma2(0.0).omega(1.0).restitution(0.5).model()?;
/// let mut simulation = Simulation::new(&model, 0.0, &[0.0], &[2.0])?;
/// let mut first = None;
/// let report = simulation.run(&Limits::until(Time::new(&model, 0, 0.25)), |event| first = first.or(Some(*event)));
/// assert_eq!(report.outcome, Outcome::TimeReached);
/// let impact = first.ok_or("no impact")?;
/// assert!((impact.time.to_f64() - std::f64::consts::FRAC_PI_6).abs() < 1e-15);
/// assert!((impact.velocity_before - 3f64.sqrt()).abs() < 1e-14 && impact.velocity_after < 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Simulation {
    model: Model,
    psi: f64,
    engine: Engine,
    /// Present time since the base of the engine's window.
    now: f64,
    /// Time of the latest event since the base; no later one is told with an earlier time.
    told: f64,
    cascades: Cascades,
    changes: Vec<Change>,
    stalls: u32,
    check: StopCheck,
}

impl Simulation {
    /// A simulation of `model` from the displacements and velocities of all its masses at t = 0, where the force is
    /// A cos ωψ (or what its harmonics add up to at the time ψ).
    ///
    /// A mass may start on a barrier. With a velocity outward its impact is the first event, at t = 0; with none it
    /// leaves or rests (event at t = 0), whichever the force wants. A displacement behind a barrier by rounding
    /// (4·2⁻⁵²) is put on it.
    ///
    /// # Errors
    /// A [`StateError`] when an array has not one finite number a mass, a mass is outside the gap, or something is
    /// too fast to be followed (1e12 gaps in the time of the fastest oscillation).
    pub fn new(model: &Model, psi: f64, displacement: &[f64], velocity: &[f64]) -> Result<Self, StateError> {
        let (units, layout) = (Units::new(model), model.chain().layout());
        for (name, values) in [("displacement", displacement), ("velocity", velocity)] {
            let sites = model.chain().sites();
            if values.len() != sites {
                return Err(StateError::Length { name, found: values.len(), sites });
            }
            if let Some(site) = values.iter().position(|x| !x.is_finite()) {
                return Err(StateError::NotFinite { name, site, layout, value: values[site] });
            }
        }
        if !psi.is_finite() {
            return Err(StateError::NotFinite { name: "psi", site: 0, layout, value: psi });
        }
        let limit = FASTEST * units.scale;
        if let Some(&value) = velocity.iter().find(|v| v.abs() > limit) {
            return Err(StateError::TooFast { name: "velocity", value, limit });
        }
        if units.amplitude > FASTEST {
            let limit = FASTEST * units.scale * units.scale;
            return Err(StateError::TooFast { name: "amplitude", value: model.amplitude(), limit });
        }
        let mut ring = Ring::new(displacement.len());
        for (site, (&u, &v)) in displacement.iter().zip(velocity).enumerate() {
            place(&mut ring, &units, layout, site, u)?;
            ring.v[site] = v / units.scale;
        }
        // The force repeats: a phase of many periods is brought into one.
        let phase = psi.rem_euclid(model.period()) * units.scale;
        let mut engine = Engine::new(units, phase, ring);
        engine.set_force(0.0);
        let mut simulation = Self {
            model: *model,
            psi,
            engine,
            now: 0.0,
            told: 0.0,
            cascades: Cascades::new(displacement.len()),
            changes: Vec::new(),
            stalls: 0,
            check: StopCheck::new(Stop::default(), displacement.len()),
        };
        simulation.classify_contacts();
        simulation.engine.begin_window();
        Ok(simulation)
    }

    /// Masses that start on a barrier: at rest, leaving, or (the queue's business) about to hit it.
    fn classify_contacts(&mut self) {
        let engine = &mut self.engine;
        for site in 0..engine.ring.sites() {
            if engine.ring.reference[site] == 0.0 || engine.ring.x[site] != 0.0 {
                continue;
            }
            let upper = engine.ring.reference[site] == engine.units.upper;
            let barrier = if upper { Barrier::Upper } else { Barrier::Lower };
            let outward = barrier.sign() * engine.ring.v[site];
            if outward < 0.0 {
                engine.ring.leave(site, barrier, 1);
            } else if outward == 0.0 {
                match engine.ring.tendency(&engine.units, &engine.force, site, barrier, 2) {
                    Some((order, false)) => engine.ring.leave(site, barrier, order),
                    _ => {
                        engine.ring.rest(site, barrier);
                        engine.work.sticks += 1;
                        self.cascades.rest_at(site, barrier, 0.0);
                    }
                }
            }
        }
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// From now on runs end with [`Outcome::Stopped`] once `stop` is raised, between two flights. What it has come to does not depend on that.
    pub fn heed(&mut self, stop: &Stop) {
        self.check = StopCheck::new(stop.clone(), self.engine.ring.sites());
    }

    /// Present time.
    pub fn time(&self) -> Time {
        self.time_at(self.now)
    }

    /// Work since the start.
    pub fn work(&self) -> Work {
        self.engine.work
    }

    /// Windows of flight from now to `until` that no luck can spare: so many of the longest kind. Impacts make more of them.
    ///
    /// ```
    /// use vibrochain_eventsim::{Simulation, Time};
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(1, 1.0, 0.0)?, 1e-50, 0.0)?;
    /// let simulation = Simulation::new(&model, 0.0, &[0.0], &[0.5])?;
    /// assert!(simulation.least_windows(Time::new(&model, 1, 0.0)) > 1e49);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn least_windows(&self, until: Time) -> f64 {
        let left = self.engine.clock.until(until.periods(), until.offset() * self.engine.units.scale) - self.now;
        left.max(0.0) / self.engine.longest_window()
    }

    /// The barrier on which mass `site` rests now; `None` if it flies (or does not exist).
    pub fn resting(&self, site: usize) -> Option<Barrier> {
        match self.engine.ring.contact.get(site) {
            Some(crate::ring::Contact::Resting(barrier)) => Some(*barrier),
            _ => None,
        }
    }

    /// The exact state now. Looking changes nothing: a run is the same to the bit however often it is sampled.
    pub fn state(&self) -> State {
        let sites = self.engine.ring.sites();
        let (mut displacement, mut velocity) = (vec![0.0; sites], vec![0.0; sites]);
        self.read(&mut displacement, &mut velocity);
        State { displacement, velocity, psi: self.psi, time: self.time() }
    }

    /// The exact state now, written to `displacement` and `velocity`; entries beyond the number of masses are left
    /// alone, and of shorter arrays both are filled as far as the shorter goes.
    pub fn read(&self, displacement: &mut [f64], velocity: &mut [f64]) {
        let sites = self.engine.ring.sites().min(displacement.len()).min(velocity.len());
        let (x, v) = (&mut displacement[..sites], &mut velocity[..sites]);
        self.engine.read(self.now, x, v);
        for ((x, v), reference) in x.iter_mut().zip(v).zip(&self.engine.ring.reference) {
            // A rounding error behind its barrier is on it.
            *x = (*x + reference).clamp(self.engine.units.lower, self.engine.units.upper);
            *v *= self.engine.units.scale;
        }
    }

    /// Energy of the lattice now: kinetic, on-site and coupling, Σ ½u̇² + ½γ₁u² + ½γ₂(u_{n+1}−u_n)², and the like with γ₃
    /// between layers. A free end has no spring, a wall has one, at u = 0. Constant without force and with e = 1.
    pub fn energy(&self) -> f64 {
        let State { displacement: u, velocity: v, .. } = self.state();
        let chain = self.model.chain();
        let terms = u.iter().zip(&v).enumerate().map(|(n, (own, v))| {
            let spring = |gamma: f64, side: Option<usize>| {
                let stretch = side.map_or(0.0, |m| u[m]) - own;
                gamma * stretch * stretch
            };
            // Each spring once: from the mass before it, or from the one that has a wall before it.
            let wall = |gamma: f64, side: Option<usize>| if side.is_none() { spring(gamma, None) } else { 0.0 };
            let [left, right, below, above] = chain.neighbours(n);
            let (along, across) = (chain.gamma2(), chain.gamma3());
            let row = v * v + chain.gamma1() * own * own + spring(along, right) + wall(along, left);
            0.5 * (row + spring(across, above) + wall(across, below))
        });
        terms.sum()
    }

    /// Runs until the first of `limits` is met; every event is shown to `observer`, in the order of time.
    ///
    /// A run can be continued by another; its limits on impacts and work count anew.
    pub fn run(&mut self, limits: &Limits, mut observer: impl FnMut(&Event)) -> Report {
        let outcome = self.advance(limits, &mut observer, &mut Alone);
        Report { outcome, time: self.time(), work: self.engine.work }
    }

    /// As [`Simulation::run`], with tangent vectors that ride along: perturbations of the state as it is now, carried to
    /// where the run ends. The run is the same to the bit as without them.
    ///
    /// # Errors
    /// [`TangentError::OtherModel`]: the vectors belong to another model than the simulation.
    pub fn run_with(
        &mut self,
        tangents: &mut Tangents,
        limits: &Limits,
        mut observer: impl FnMut(&Event),
    ) -> Result<Report, TangentError> {
        let mut riders = tangents.mount(&self.model, &self.engine, self.now)?;
        let outcome = self.advance(limits, &mut observer, &mut riders);
        riders.fly_to(&self.engine, self.now);
        Ok(Report { outcome, time: self.time(), work: self.engine.work })
    }

    /// The events of a run, as [`Simulation::run`], collected.
    ///
    /// ```
    /// use vibrochain_eventsim::{Limits, Simulation};
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(2, 0.2, 0.1)?, 1.5, 0.4)?;
    /// let mut simulation = Simulation::new(&model, 0.0, &[0.0; 2], &[1.0; 2])?;
    /// let (report, events) = simulation.collect(&Limits::impacts(4));
    /// // Both masses hit together, in one event of two rows.
    /// assert_eq!((events.len(), report.work.impacts), (4, 4));
    /// assert_eq!(events[0].time, events[1].time);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn collect(&mut self, limits: &Limits) -> (Report, Vec<Event>) {
        let mut events = Vec::new();
        let report = self.run(limits, |event| events.push(*event));
        (report, events)
    }

    fn advance(&mut self, limits: &Limits, observer: &mut impl FnMut(&Event), company: &mut impl Company) -> Outcome {
        let impacts = self.engine.work.impacts.saturating_add(limits.impacts);
        let flights = self.flights().saturating_add(limits.flights);
        loop {
            if self.engine.work.impacts >= impacts {
                return Outcome::ImpactsReached;
            }
            if self.flights() >= flights {
                return Outcome::WorkLimit;
            }
            if self.check.is_raised() {
                return Outcome::Stopped;
            }
            let target = match limits.until {
                Some(time) => self.engine.clock.until(time.periods(), time.offset() * self.engine.units.scale),
                None => f64::INFINITY,
            };
            let horizon = self.engine.horizon;
            let pending = self.cascades.next_rest();
            let limit = target.min(horizon).min(pending);
            if let Some(first) = self.engine.next_contacts(limit) {
                if let Some(outcome) = self.event(first, limits, observer, company) {
                    return outcome;
                }
            } else if pending <= limit {
                self.now = self.now.max(pending);
                self.told = pending;
                let (time, scale) = (self.time(), self.engine.units.scale);
                self.cascades.rested_by(pending, |change| observer(&event(change, time, scale)));
            } else if target <= horizon {
                self.now = self.now.max(target);
                return Outcome::TimeReached;
            } else {
                self.engine.rebase(horizon);
                self.rebased(horizon);
                self.engine.begin_window();
            }
        }
    }

    fn flights(&self) -> u64 {
        self.engine.work.windows + self.engine.work.restarts
    }

    /// What is kept here moves with the base.
    fn rebased(&mut self, by: f64) {
        (self.now, self.told) = (0.0, 0.0);
        self.cascades.rebased(by);
    }

    /// The contacts that are due at `first`.
    fn event(
        &mut self,
        first: f64,
        limits: &Limits,
        observer: &mut impl FnMut(&Event),
        company: &mut impl Company,
    ) -> Option<Outcome> {
        let mut changes = std::mem::take(&mut self.changes);
        changes.clear();
        let (at, moved) = self.engine.restart(first, self.told, &mut changes);
        if moved {
            self.rebased(at);
        } else {
            (self.now, self.told) = (at, at);
        }
        company.meet(&self.engine, self.now, &changes);
        let outcome = self.tell(&changes, limits, observer);
        self.stalls = if changes.is_empty() { self.stalls + 1 } else { 0 };
        self.changes = changes;
        if self.stalls > STALLS {
            let stalled = self.engine.due.first()?;
            return Some(Outcome::Cascade { site: stalled.site, barrier: stalled.barrier, bounces: 0 });
        }
        outcome
    }

    /// Reports `changes` at the present time and counts bounces.
    fn tell(&mut self, changes: &[Change], limits: &Limits, observer: &mut impl FnMut(&Event)) -> Option<Outcome> {
        let (time, &Units { scale, rate, .. }) = (self.time(), &self.engine.units);
        let (now, wait) = ((&self.engine.clock, self.now), BOUNCE_TIME / rate);
        let observe = |change: &Change| observer(&event(change, time, scale));
        let cascade = self.cascades.tell(changes, now, limits.bounces, |_| wait, observe);
        cascade.map(|Cascade { site, barrier, bounces }| Outcome::Cascade { site, barrier, bounces })
    }

    fn time_at(&self, s: f64) -> Time {
        let (periods, offset) = self.engine.clock.after(s);
        Time::from_parts(periods, offset / self.engine.units.scale, self.model.period())
    }
}

/// What is told of a change at `time`, where velocities are in so many internal units.
fn event(change: &Change, time: Time, scale: f64) -> Event {
    let &Change { site, barrier, before, after, kind, .. } = change;
    Event { time, site, barrier, velocity_before: before * scale, velocity_after: after * scale, kind }
}

/// Puts a mass at `u`, measured from a barrier if it is near one.
fn place(ring: &mut Ring, units: &Units, layout: Layout, site: usize, u: f64) -> Result<(), StateError> {
    for barrier in [Barrier::Lower, Barrier::Upper] {
        let position = units.barrier(barrier);
        let outside = barrier.sign() * (u - position);
        if outside > OVERSHOOT {
            let (low, high) = (units.lower, units.upper);
            return Err(StateError::OutsideGap { site, layout, barrier, value: u, excess: outside, low, high });
        }
        if outside > -FORGET {
            ring.anchor(site, position, if outside > 0.0 { 0.0 } else { u - position });
            return Ok(());
        }
    }
    ring.x[site] = u;
    Ok(())
}
