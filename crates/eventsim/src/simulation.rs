//! A run of a chain or of any structure: the public face of the event loop.

use std::sync::Arc;

use crate::balance::{EnergyBalance, Ledger};
use crate::error::{StateError, TangentError};
use crate::event::{Event, Limits, Report, Work};
use crate::event_loop::EventLoop;
use crate::flight::local::FlightChoice;
use crate::start;
use crate::tangent::Tangents;
use crate::time::Time;
use crate::watch::Contact;
use crate::with_tangents::WithTangents;
use crate::with_tangents::WithoutTangents;
use vibrochain_lattice::{Barrier, EnergyForm, ModalStructure, Model, Stop};

/// State of a run, from which another one can start.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct State {
    /// q, one a coordinate as far as they are known: of a chain u_n of all masses.
    pub displacement: Vec<f64>,
    /// q′; at an event, just after it.
    pub velocity: Vec<f64>,
    /// Coordinates ξ of all modes ([`vibrochain_lattice::LinearMode`]); none of a chain, which is simulated without them.
    pub modes: Vec<[f64; 2]>,
    /// Phase ψ of the force at time zero: it is A cos ω(t+ψ), or the sum of its harmonics at t+ψ.
    pub psi: f64,
    /// The time t.
    pub time: Time,
}

/// What a contact does.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ContactState {
    /// g, of a mass its displacement.
    pub place: f64,
    /// g′; at an event, just after it.
    pub velocity: f64,
    /// The barrier on which it rests.
    pub resting: Option<Barrier>,
    /// The force of that barrier on the contact, positive towards larger g; 0 in flight.
    pub force: f64,
}

/// An event-driven simulation of a linear structure with stops: exact flight between certified events. Contacts are what is stopped; in a
/// lattice (a ring, a row with free or fixed ends, several layers of rows) each mass is one, numbered as [`vibrochain_lattice::Chain`] numbers
/// them. Loads are at t + ψ, the start is t = 0.
///
/// One mass between its barriers at −1 and 1: u = 2 sin t until it hits.
///
/// ```
/// use vibrochain_eventsim::{Limits, Outcome, Simulation};
/// use vibrochain_lattice::Point;
/// let model = Point::ring(1).gamma1(1.0).gamma2(0.0).omega(1.0).restitution(0.5).model()?;
/// let mut simulation = Simulation::new(&model, 0.0, &[0.0], &[2.0])?;
/// let (report, events) = simulation.collect(&Limits::until(simulation.time_of(0, 0.25)));
/// assert_eq!(report.outcome, Outcome::TimeReached);
/// let impact = events.first().ok_or("no impact")?;
/// assert!((impact.time.to_f64() - std::f64::consts::FRAC_PI_6).abs() < 1e-15);
/// assert!((impact.velocity_before - 3f64.sqrt()).abs() < 1e-14 && impact.velocity_after < 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// A ball that falls with g = 9.81 from 1 onto a table at 0, e = 0.5, given as a structure of one mode.
///
/// ```
/// use vibrochain_eventsim::{Limits, Outcome, Simulation};
/// use vibrochain_lattice::{Contact, LinearMode, ModalStructure, ModeShape};
/// let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: -9.81 };
/// let table = Contact { lower: Some(0.0), upper: None, restitution: 0.5 };
/// let ball = ModalStructure::new(vec![table], vec![], vec![LinearMode::oscillator(0.0, 0.0, &shape, &[])])?;
/// let mut simulation = Simulation::of_modes(ball, 1.0, 0.0, &[[1.0, 0.0]])?;
/// let (report, events) = simulation.collect(&Limits::until(simulation.time_of(1, 0.0)));
/// assert_eq!(report.outcome, Outcome::TimeReached);
/// // It falls for √(2/g), and bounces for twice that.
/// let rest = events.last().ok_or("no event")?.time.to_f64();
/// assert!((rest - 3.0 * (2.0 / 9.81f64).sqrt()).abs() < 1e-14);
/// assert!((simulation.contact(0).ok_or("no contact")?.force - 9.81).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Simulation {
    psi: f64,
    inner: EventLoop,
}

impl Simulation {
    /// A simulation of a chain from the displacements and velocities of all its masses at t = 0, where the force is A cos ωψ (or what its
    /// harmonics add up to at the time ψ).
    ///
    /// A mass may start on a barrier. With a velocity outward its impact is the first event, at t = 0; with none it leaves or rests (event at
    /// t = 0), whichever the force wants. A displacement behind a barrier by rounding (4·2⁻⁵²) is put on it.
    ///
    /// # Errors
    /// A [`StateError`] when an array has not one finite number a mass, a mass is outside the gap, or something is
    /// too fast to be followed (1e12 gaps in the time of the fastest oscillation).
    pub fn new(model: &Model, psi: f64, displacement: &[f64], velocity: &[f64]) -> Result<Self, StateError> {
        Ok(Self { psi, inner: start::of_masses(model, psi, [displacement, velocity])? })
    }

    /// A simulation of a structure from coordinates ξ of all its modes ([`ModalStructure::still`] is rest under the static load;
    /// `vibrochain_lattice::Structure::project` makes them of q and q′), under loads of frequency `omega` and phase `psi`. Without loads
    /// `omega` is the unit in which time is told. It flies by its modes, or by its coordinates where it knows these and that is faster.
    ///
    /// A contact may start on a barrier, as a mass in [`Simulation::new`].
    ///
    /// # Errors
    /// A [`StateError`]: not two finite numbers a mode, a frequency that is not positive, a contact beyond its barrier.
    pub fn of_modes(
        structure: impl Into<Arc<ModalStructure>>,
        omega: f64,
        psi: f64,
        modes: &[[f64; 2]],
    ) -> Result<Self, StateError> {
        Ok(Self { psi, inner: start::of_modes(structure.into(), (omega, psi), modes)? })
    }

    /// From now on runs end with [`Outcome::Stopped`](crate::Outcome::Stopped) once `stop` is raised, before the next event is known or before
    /// the next flight. What it has come to does not depend on that.
    pub fn heed(&mut self, stop: &Stop) {
        self.inner.heed(stop);
    }

    /// Contacts that share coordinates and hit at one instant do so in the order of their numbers, again until none moves into its barrier,
    /// where a run ends with [`Outcome::Simultaneous`](crate::Outcome::Simultaneous) otherwise. Masses of a lattice share none.
    #[must_use]
    pub fn in_sequence(mut self) -> Self {
        self.inner.in_sequence = true;
        self
    }

    /// Keeps account of the energy from now on, which takes ten evaluations of the whole motion in two units of the fastest rate. Modes of
    /// complex shape do not know their energy: of these `vibrochain_lattice::Structure::energy_form` is asked for, and without it no account
    /// is kept.
    ///
    /// ```
    /// use vibrochain_eventsim::{Limits, Simulation};
    /// use vibrochain_lattice::Point;
    /// let model = Point::ring(3).gamma1(1.0).gamma2(0.2).omega(1.3).amplitude(0.5).restitution(0.8).model()?;
    /// let mut simulation = Simulation::new(&model, 0.0, &[0.0; 3], &[1.5, 0.2, -0.4])?.with_balance(None);
    /// let before = simulation.energy().ok_or("unknown")?;
    /// simulation.run(&Limits::until(simulation.time_of(10, 0.0)), |_| {});
    /// let balance = simulation.balance().ok_or("no account")?;
    /// assert!(balance.work != 0.0 && balance.impacts > 0.0 && balance.dashpots == 0.0);
    /// let gained = simulation.energy().ok_or("unknown")? - before;
    /// assert!((gained - (balance.work - balance.impacts)).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_balance(mut self, form: impl Into<Option<EnergyForm>>) -> Self {
        self.inner.motion.ledger = None;
        self.inner.bring_to_now();
        let motion = &mut self.inner.motion;
        let form = form.into().or_else(|| motion.system.structure.as_ref()?.energy_form());
        motion.ledger = (motion.is_local() || form.is_some()).then(|| Ledger::new(form));
        self
    }

    /// The structure of a simulation from modes; `None` of a chain.
    pub fn structure(&self) -> Option<&ModalStructure> {
        self.inner.motion.system.structure.as_deref()
    }

    /// How it flies between impacts.
    pub fn flight(&self) -> FlightChoice {
        self.inner.motion.system.choice()
    }

    /// `periods` periods of the loads and the `part` of one more, as a limit.
    pub fn time_of(&self, periods: u64, part: f64) -> Time {
        Time::of_period(self.inner.motion.system.period(), periods, part)
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
    /// use vibrochain_eventsim::Simulation;
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(1, 1.0, 0.0)?, 1e-50, 0.0)?;
    /// let simulation = Simulation::new(&model, 0.0, &[0.0], &[0.5])?;
    /// assert!(simulation.least_windows(simulation.time_of(1, 0.0)) > 1e49);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn least_windows(&self, until: Time) -> f64 {
        let motion = &self.inner.motion;
        let left = motion.clock.until(until.periods(), until.offset()) - self.inner.now;
        left.max(0.0) / motion.longest_window()
    }

    /// What contact number `contact` does now; `None`: there is no such contact.
    pub fn contact(&self, contact: usize) -> Option<ContactState> {
        let motion = &self.inner.motion;
        let place = motion.places.get(contact)?;
        let (x, velocity) = motion.contact_at(contact, self.inner.now);
        let limits = motion.system.limits(contact);
        let reference = place.reference.and_then(|barrier| limits.barrier(barrier));
        let reference = reference.unwrap_or(motion.system.origins[contact]);
        let inside =
            (reference + x).clamp(limits.lower.unwrap_or(f64::NEG_INFINITY), limits.upper.unwrap_or(f64::INFINITY));
        let Contact::Resting(barrier) = place.touch else {
            return Some(ContactState { place: inside, velocity, resting: None, force: 0.0 });
        };
        let force = motion.force_at(contact, self.inner.now);
        Some(ContactState { place: inside, velocity: 0.0, resting: Some(barrier), force })
    }

    /// What all contacts do now.
    pub fn contacts(&self) -> Vec<ContactState> {
        (0..self.inner.motion.places.len()).filter_map(|contact| self.contact(contact)).collect()
    }

    /// The exact state now. Looking changes nothing: a run is the same to the bit however often it is sampled.
    pub fn state(&self) -> State {
        let coordinates = self.inner.motion.coordinates();
        let (mut displacement, mut velocity) = (vec![0.0; coordinates], vec![0.0; coordinates]);
        self.read(&mut displacement, &mut velocity);
        let modes = self.inner.motion.modes_at(self.inner.now);
        let modes = self.inner.motion.system.absolute(&modes);
        State { displacement, velocity, modes, psi: self.psi, time: self.time() }
    }

    /// The exact state now, written to `displacement` and `velocity`; entries beyond the number of coordinates are left
    /// alone, and of shorter arrays both are filled as far as the shorter goes.
    pub fn read(&self, displacement: &mut [f64], velocity: &mut [f64]) {
        let count = self.inner.motion.coordinates().min(displacement.len()).min(velocity.len());
        self.inner.motion.read(self.inner.now, [&mut displacement[..count], &mut velocity[..count]]);
    }

    /// Kinetic energy and that of all springs now, ½q′ᵀMq′ + ½qᵀKq: of a lattice Σ ½u̇² + ½γ₁u² + ½γ₂(u_{n+1}−u_n)², and the like with γ₃
    /// between layers. A free end has no spring, a wall has one, at u = 0. Constant without loads and dashpots and with e = 1. `None` of modes
    /// of complex shape, which know too little.
    pub fn energy(&self) -> Option<f64> {
        self.inner.motion.energy_at(self.inner.now)
    }

    /// Work and losses since [`Simulation::with_balance`]: E(t) − E(0) = work − dashpots − impacts. `None` where none is kept.
    /// It is brought to the present time.
    pub fn balance(&mut self) -> Option<EnergyBalance> {
        self.inner.bring_to_now();
        self.inner.motion.ledger.as_ref().map(Ledger::balance)
    }

    /// `count` orthonormal tangent vectors of its runs in random directions; the same seed gives the same ones.
    ///
    /// # Errors
    /// [`TangentError::Count`] if there are none, more than 4096 or more than two a mass, or a mode.
    pub fn tangents(&self, count: usize, seed: u64) -> Result<Tangents, TangentError> {
        Tangents::random(&self.inner.motion.system, count, seed)
    }

    /// Tangent vectors in given directions, two lists each as [`Tangents`] has them, which need be neither orthogonal nor of length 1.
    ///
    /// # Errors
    /// [`TangentError::Count`], [`TangentError::Entries`].
    pub fn tangents_along(&self, vectors: &[[Vec<f64>; 2]]) -> Result<Tangents, TangentError> {
        Tangents::along(&self.inner.motion.system, vectors)
    }

    /// Runs until the first of `limits` is met; every event is shown to `observer`, in the order of time.
    ///
    /// A run can be continued by another; its limits on impacts and work count anew.
    pub fn run(&mut self, limits: &Limits, mut observer: impl FnMut(&Event)) -> Report {
        self.inner.run(limits, &mut observer, &mut WithoutTangents)
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
        let mut vectors = WithTangents::new(tangents, &self.inner.motion, self.inner.now)?;
        let report = self.inner.run(limits, &mut observer, &mut vectors);
        vectors.fly_to(&self.inner.motion, self.inner.now);
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
}
