//! A run of a chain from the displacements and velocities of its masses: the public face of the event loop.

use crate::cascade::Change;
use crate::error::{StateError, TangentError};
use crate::event::{Event, Limits, Outcome, Report, Work};
use crate::structure::{Alone, Company, ContactEvent, EventLoop, Flight, Motion, StructureOutcome, System};
use crate::tangent::{Tangents, system};
use crate::time::Time;
use crate::watch::Contact;
use vibrochain_lattice::{Barrier, Model, Stop};

/// Largest speed and force in units of the gap and of the fastest rate.
const FASTEST: f64 = 1e12;

/// How far behind a barrier a mass may start: the rounding of its displacement. It is put on the barrier.
const OVERSHOOT: f64 = 4.0 * f64::EPSILON;

/// Nearer to a barrier than this a mass is measured from there: its distance is known as well as its displacement.
const NEAR: f64 = 0.25;

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
    inner: EventLoop,
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
        let layout = model.chain().layout();
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
        // The force repeats: a phase of many periods is brought into one.
        let system = system(model, psi.rem_euclid(model.period()));
        let fastest = system.fastest;
        let limit = FASTEST * fastest;
        if let Some(&value) = velocity.iter().find(|v| v.abs() > limit) {
            return Err(StateError::TooFast { name: "velocity", value, limit });
        }
        let limit = FASTEST * fastest * fastest;
        if model.amplitude() > limit {
            return Err(StateError::TooFast { name: "amplitude", value: model.amplitude(), limit });
        }
        let mut places = Vec::new();
        let mut within = displacement.to_vec();
        for (site, u) in within.iter_mut().enumerate() {
            for barrier in [Barrier::Lower, Barrier::Upper] {
                let position = model.barrier(barrier);
                let outside = barrier.sign() * (*u - position);
                if outside > OVERSHOOT {
                    let [low, high] = [Barrier::Lower, Barrier::Upper].map(|barrier| model.barrier(barrier));
                    return Err(StateError::OutsideGap {
                        site,
                        layout,
                        barrier,
                        value: *u,
                        excess: outside,
                        low,
                        high,
                    });
                }
                *u = if outside > 0.0 { position } else { *u };
                if outside > -NEAR {
                    places.push((site, barrier, *u - position));
                    break;
                }
            }
        }
        let (motion, untold) = started(system, [within, velocity.to_vec()], &places);
        Ok(Self { model: *model, psi, inner: EventLoop::new(motion, Vec::new(), untold) })
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// From now on runs end with [`Outcome::Stopped`] once `stop` is raised, between two flights. What it has come to does not depend on that.
    pub fn heed(&mut self, stop: &Stop) {
        self.inner.heed(stop, self.model.chain().sites());
    }

    /// Present time.
    pub fn time(&self) -> Time {
        self.inner.time()
    }

    /// Work since the start.
    pub fn work(&self) -> Work {
        self.inner.motion.work
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
        let motion = &self.inner.motion;
        let left = motion.clock.until(until.periods(), until.offset()) - self.inner.now;
        left.max(0.0) / motion.longest_window()
    }

    /// The barrier on which mass `site` rests now; `None` if it flies (or does not exist).
    pub fn resting(&self, site: usize) -> Option<Barrier> {
        self.inner.resting(site)
    }

    /// The exact state now. Looking changes nothing: a run is the same to the bit however often it is sampled.
    pub fn state(&self) -> State {
        let sites = self.model.chain().sites();
        let (mut displacement, mut velocity) = (vec![0.0; sites], vec![0.0; sites]);
        self.read(&mut displacement, &mut velocity);
        State { displacement, velocity, psi: self.psi, time: self.time() }
    }

    /// The exact state now, written to `displacement` and `velocity`; entries beyond the number of masses are left
    /// alone, and of shorter arrays both are filled as far as the shorter goes.
    pub fn read(&self, displacement: &mut [f64], velocity: &mut [f64]) {
        let sites = self.model.chain().sites().min(displacement.len()).min(velocity.len());
        self.inner.motion.read(self.inner.now, [&mut displacement[..sites], &mut velocity[..sites]]);
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
        self.advance(limits, &mut observer, &mut Alone)
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
        let mut riders = tangents.mount(&self.model, &self.inner.motion, self.inner.now)?;
        let report = self.advance(limits, &mut observer, &mut riders);
        riders.fly_to(&self.inner.motion, self.inner.now);
        Ok(report)
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

    fn advance(&mut self, limits: &Limits, observer: &mut impl FnMut(&Event), company: &mut impl Company) -> Report {
        let outcome = match self.inner.advance(limits, &mut |found| observer(&event(found)), company) {
            StructureOutcome::TimeReached => Outcome::TimeReached,
            StructureOutcome::ImpactsReached => Outcome::ImpactsReached,
            StructureOutcome::Cascade { contact: site, barrier, bounces } => {
                Outcome::Cascade { site, barrier, bounces }
            }
            StructureOutcome::Stopped => Outcome::Stopped,
            // Masses share nothing, and no mode of a chain feeds itself.
            StructureOutcome::WorkLimit | StructureOutcome::Simultaneous { .. } | StructureOutcome::Diverged { .. } => {
                Outcome::WorkLimit
            }
        };
        Report { outcome, time: self.time(), work: self.work() }
    }
}

/// A motion from displacements and velocities, of which some are measured from barriers: masses that start on one are at rest, leave, or
/// (the queue's business) are about to hit it. With the events of that.
fn started(
    system: System,
    [displacement, velocity]: [Vec<f64>; 2],
    near: &[(usize, Barrier, f64)],
) -> (Motion, Vec<Change>) {
    let speeds = velocity.clone();
    let flight = Flight::of_coordinates(&system, [displacement, velocity]);
    let mut motion = Motion::with(system, flight);
    for &(site, barrier, x) in near {
        motion.anchor(site, barrier, x);
    }
    let mut untold = Vec::new();
    for &(site, barrier, _) in near.iter().filter(|(.., x)| *x == 0.0) {
        let outward = barrier.sign() * speeds[site];
        if outward == 0.0 {
            motion.rest_or_leave(site, barrier, &mut untold);
        } else if outward < 0.0 {
            motion.places.touch(site, Contact::Leaving(barrier, 1));
        }
    }
    (motion, untold)
}

/// An event of a contact as one of its mass.
fn event(event: &ContactEvent) -> Event {
    let &ContactEvent { time, contact: site, barrier, velocity_before, velocity_after, kind, .. } = event;
    Event { time, site, barrier, velocity_before, velocity_after, kind }
}
