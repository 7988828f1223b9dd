//! A run of a structure from its modes: the public face of the event loop.

use std::sync::Arc;

use super::event::{ContactEvent, StructureReport, StructureStateError};
use super::event_loop::EventLoop;
use super::local::FlightChoice;
use super::modal_flight::ModalFlight;
use super::motion::Motion;
use super::places::Place;
use super::series::Series;
use super::system::System;
use super::tangent::{Alone, StructureTangents};
use crate::balance::{EnergyBalance, Ledger};
use crate::error::TangentError;
use crate::event::{Limits, Work};
use crate::time::Time;
use crate::watch::Contact;
use vibrochain_lattice::{Barrier, EnergyForm, ModalStructure, Stop};

/// How far behind a barrier a contact may start, relative to the terms it is made of: it is put on it.
const OVERSHOOT: f64 = 1e-12;

/// Rounding of a place, relative to the same: a contact so close to its barrier is on it.
const ON: f64 = 16.0 * f64::EPSILON;

/// Coordinates of modes beyond this are as good as infinite.
const LARGEST: f64 = 1e100;

/// What a contact does.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ContactState {
    /// g
    pub place: f64,
    /// g′; at an event, just after it.
    pub velocity: f64,
    /// The barrier on which it rests.
    pub resting: Option<Barrier>,
    /// The force of that barrier on the contact, positive towards larger g; 0 in flight.
    pub force: f64,
}

/// State of a structure.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct StructureState {
    /// q, as far as the modes know the coordinates.
    pub place: Vec<f64>,
    /// q′; at an event, just after it.
    pub velocity: Vec<f64>,
    /// Coordinates ξ of all modes ([`vibrochain_lattice::LinearMode`]).
    pub modes: Vec<[f64; 2]>,
    /// The contacts.
    pub contacts: Vec<ContactState>,
    /// The time t.
    pub time: Time,
}

/// An event-driven simulation of a linear structure with stops: exact flight in its modes between certified events. Units are those of the
/// structure; loads are at t + ψ, the start is t = 0.
///
/// ```
/// use vibrochain_eventsim::{Limits, StructureOutcome, StructureSimulation};
/// use vibrochain_lattice::{Contact, LinearMode, ModalStructure, ModeShape};
/// // A ball that falls with g = 9.81 from 1 onto a table at 0, e = 0.5.
/// let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: -9.81 };
/// let table = Contact { lower: Some(0.0), upper: None, restitution: 0.5 };
/// let ball = ModalStructure::new(vec![table], vec![], vec![LinearMode::oscillator(0.0, 0.0, &shape, &[])])?;
/// let mut simulation = StructureSimulation::new(ball, 1.0, 0.0, &[[1.0, 0.0]])?;
/// let (report, events) = simulation.collect(&Limits { until: Some(simulation.time_of(1, 0.0)), ..Limits::default() });
/// assert_eq!(report.outcome, StructureOutcome::TimeReached);
/// // It falls for √(2/g), and bounces for twice that.
/// let rest = events.last().ok_or("no event")?.time.to_f64();
/// assert!((rest - 3.0 * (2.0 / 9.81f64).sqrt()).abs() < 1e-14);
/// assert!((simulation.contact(0).ok_or("no contact")?.force - 9.81).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct StructureSimulation {
    structure: Arc<ModalStructure>,
    inner: EventLoop,
}

impl StructureSimulation {
    /// A simulation from coordinates ξ of all modes ([`ModalStructure::still`] is rest under the static load;
    /// `vibrochain_lattice::Structure::project` makes them of q and q′), under loads of frequency `omega` and phase `psi`. Without
    /// loads `omega` is the unit in which time is told.
    ///
    /// A contact may start on a barrier. With a velocity outward its impact is the first event; with none it leaves or rests.
    ///
    /// # Errors
    /// A [`StructureStateError`]: not two finite numbers a mode, a frequency that is not positive, a contact beyond its barrier.
    pub fn new(
        structure: ModalStructure,
        omega: f64,
        psi: f64,
        modes: &[[f64; 2]],
    ) -> Result<Self, StructureStateError> {
        let wanted = structure.modes().len();
        if modes.len() != wanted {
            return Err(StructureStateError::Length { given: modes.len(), wanted });
        }
        let range = |what, value, requirement| Err(StructureStateError::Range { what, value, requirement });
        if !(omega.is_finite() && omega > 0.0) {
            return range("omega", omega, "a frequency above 0");
        }
        if !psi.is_finite() {
            return range("psi", psi, "a finite number");
        }
        if let Some(value) = modes.iter().flatten().find(|value| !is_sound(value)) {
            return range("the state of a mode", *value, "numbers between -1e100 and 1e100");
        }
        let psi = psi.rem_euclid(std::f64::consts::TAU / omega);
        let structure = Arc::new(structure);
        let system = System::new(structure.clone(), omega, psi).local_if_faster();
        let mut motion = Motion::new(system, modes);
        let measured = motion.system.about_equilibrium(modes);
        let reach = motion.system.reach(&measured).into_iter().map(|reach| reach.min(LARGEST)).collect();
        let mut touching = Vec::new();
        for contact in 0..motion.places.len() {
            let terms = motion.system.seen_by(contact).map(|(k, _, row)| [row[0] * modes[k][0], row[1] * modes[k][1]]);
            let (value, terms) = terms.flatten().fold((0.0, 0.0), |(sum, size), term| (sum + term, size + term.abs()));
            for barrier in [Barrier::Lower, Barrier::Upper] {
                let Some(place) = structure.contacts()[contact].barrier(barrier) else { continue };
                let excess = barrier.sign() * (value - place);
                let size = terms + place.abs() + motion.system.origins[contact].abs();
                if excess > OVERSHOOT * size {
                    return Err(StructureStateError::OutsideGap { contact, barrier, value, place, excess });
                }
                if excess >= -ON * size {
                    motion.anchor(contact, barrier, 0.0);
                    touching.push((contact, barrier));
                }
            }
        }
        let mut untold = Vec::new();
        let flight = ModalFlight::new(&motion.system, measured, 0.0);
        let series = Series::tendencies(&motion.system, &flight, &motion.places);
        for (contact, barrier) in touching {
            let outward = barrier.sign() * series.contacts[contact][1];
            if outward.abs() <= 4.0 * series.doubts[contact][1] {
                motion.rest_or_leave(contact, barrier, &mut untold);
            } else if outward < 0.0 {
                let v = Some(barrier.sign() * outward / series.length);
                motion.places.set(contact, Place { v, touch: Contact::Leaving(barrier, 1), ..motion.places[contact] });
            }
        }
        Ok(Self { structure, inner: EventLoop::new(motion, reach, untold) })
    }

    /// From now on runs end with [`StructureOutcome::Stopped`](crate::StructureOutcome::Stopped) once `stop` is raised, before the next event is known or before the next flight.
    /// What it has come to does not depend on that.
    pub fn heed(&mut self, stop: &Stop) {
        self.inner.heed(stop, self.structure().modes().len());
    }

    /// Contacts that share coordinates and hit at one instant do so in the order of their numbers, again until none moves into its barrier,
    /// where a run ends with [`StructureOutcome::Simultaneous`](crate::StructureOutcome::Simultaneous) otherwise.
    #[must_use]
    pub fn in_sequence(mut self) -> Self {
        self.inner.in_sequence = true;
        self
    }

    /// Keeps account of the energy from now on, which takes ten evaluations of all modes in two units of the fastest rate. `form`:
    /// [`ModalStructure::energy_form`], or of modes of complex shape `vibrochain_lattice::Structure::energy_form`.
    #[must_use]
    pub fn with_balance(mut self, form: EnergyForm) -> Self {
        self.inner.motion.ledger = None;
        self.inner.bring_to_now();
        self.inner.motion.ledger = Some(Ledger::new(form));
        self
    }

    /// The structure.
    pub fn structure(&self) -> &ModalStructure {
        &self.structure
    }

    /// How it flies between impacts.
    pub fn flight(&self) -> FlightChoice {
        let System { omega, fastest, .. } = &self.inner.motion.system;
        FlightChoice::new(self.structure(), (*omega, *fastest))
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

    /// What contact number `contact` does now; `None`: there is no such contact.
    pub fn contact(&self, contact: usize) -> Option<ContactState> {
        let place = self.inner.motion.places.get(contact)?;
        let (x, velocity) = self.inner.motion.contact_at(contact, self.inner.now);
        let limits = self.structure().contacts()[contact];
        let reference = place.reference.and_then(|barrier| limits.barrier(barrier));
        let reference = reference.unwrap_or(self.inner.motion.system.origins[contact]);
        let inside =
            (reference + x).clamp(limits.lower.unwrap_or(f64::NEG_INFINITY), limits.upper.unwrap_or(f64::INFINITY));
        let Contact::Resting(barrier) = place.touch else {
            return Some(ContactState { place: inside, velocity, resting: None, force: 0.0 });
        };
        let force = self.inner.motion.force_at(contact, self.inner.now);
        Some(ContactState { place: inside, velocity: 0.0, resting: Some(barrier), force })
    }

    /// The exact state now. Looking changes nothing.
    pub fn state(&self) -> StructureState {
        let ([place, velocity], modes) = self.inner.motion.coordinates_at(self.inner.now);
        let contacts = (0..self.inner.motion.places.len()).filter_map(|contact| self.contact(contact)).collect();
        StructureState { place, velocity, modes, contacts, time: self.time() }
    }

    /// Work and losses since [`StructureSimulation::with_balance`]: E(t) − E(0) = work − dashpots − impacts. `None` where none is kept.
    /// It is brought to the present time.
    pub fn balance(&mut self) -> Option<EnergyBalance> {
        self.inner.bring_to_now();
        self.inner.motion.ledger.as_ref().map(Ledger::balance)
    }

    /// Runs until the first of `limits` is met; every event is shown to `observer`, in the order of time.
    ///
    /// A run can be continued by another; its limits on impacts and work count anew.
    pub fn run(&mut self, limits: &Limits, mut observer: impl FnMut(&ContactEvent)) -> StructureReport {
        let outcome = self.inner.advance(limits, &mut observer, &mut Alone);
        StructureReport { outcome, time: self.time(), work: self.inner.motion.work }
    }

    /// The same run, to the bit, with tangent vectors, which are brought to the time at its end.
    ///
    /// # Errors
    /// [`TangentError::OtherModel`] of those of another structure.
    pub fn run_with(
        &mut self,
        tangents: &mut StructureTangents,
        limits: &Limits,
        mut observer: impl FnMut(&ContactEvent),
    ) -> Result<StructureReport, TangentError> {
        let mut riders = tangents.mount(&self.inner.motion, self.inner.now)?;
        let outcome = self.inner.advance(limits, &mut observer, &mut riders);
        riders.fly_to(&self.inner.motion, self.inner.now);
        Ok(StructureReport { outcome, time: self.time(), work: self.inner.motion.work })
    }

    /// The events of a run, collected.
    pub fn collect(&mut self, limits: &Limits) -> (StructureReport, Vec<ContactEvent>) {
        let mut events = Vec::new();
        let report = self.run(limits, |event| events.push(*event));
        (report, events)
    }
}

/// Neither infinite nor as good as that, nor not a number.
fn is_sound(value: &f64) -> bool {
    value.abs() <= LARGEST
}
