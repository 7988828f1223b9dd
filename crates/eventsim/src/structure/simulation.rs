//! The event loop of a structure and its public face.

use super::approach::Place;
use super::balance::{EnergyBalance, Ledger};
use super::event::{ContactEvent, StructureOutcome, StructureReport, StructureStateError};
use super::flight::Flight;
use super::local::FlightChoice;
use super::modal_flight::ModalFlight;
use super::motion::Motion;
use super::series::Series;
use super::system::System;
use super::tangent::{Alone, Company, StructureTangents};
use crate::cascade::{Cascade, Cascades, Change};
use crate::engine::CHATTER_TIME;
use crate::error::TangentError;
use crate::event::{BOUNCE_TIME, Limits, Work};
use crate::ring::Contact;
use crate::stop_check::StopCheck;
use crate::time::Time;
use vibrochain_lattice::{Barrier, EnergyForm, ModalStructure, Stop, Stopped};

/// How far behind a barrier a contact may start, relative to the terms it is made of: it is put on it.
const OVERSHOOT: f64 = 1e-12;

/// Rounding of a place, relative to the same: a contact so close to its barrier is on it.
const ON: f64 = 16.0 * f64::EPSILON;

/// Coordinates of modes beyond this are as good as infinite.
const LARGEST: f64 = 1e100;

/// Of a contact that loses nothing, flights shorter than this, in units of the fastest rate, and so short that a period holds more than
/// [`Limits::bounces`] of them, are of one cascade: pressed it bounces for ever, where one that loses energy comes to rest.
const PRESSED: f64 = 1e-3;

/// Events in a row without any effect before the run gives up.
const STALLS: u32 = 1000;

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
    motion: Motion,
    /// Present time since the base.
    now: f64,
    in_sequence: bool,
    cascades: Cascades,
    stalls: u32,
    /// Coordinates of each mode beyond these have diverged.
    reach: Vec<f64>,
    /// Events of the start, which the first run tells.
    untold: Vec<Change>,
    check: StopCheck,
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
        let system = System::new(structure, omega, psi).local_if_faster();
        let mut motion = Motion::new(system, modes);
        let measured = motion.system.about_equilibrium(modes);
        let reach = motion.system.reach(&measured).into_iter().map(|reach| reach.min(LARGEST)).collect();
        let mut touching = Vec::new();
        for contact in 0..motion.places.len() {
            let terms = motion.system.seen_by(contact).map(|(k, _, row)| [row[0] * modes[k][0], row[1] * modes[k][1]]);
            let (value, terms) = terms.flatten().fold((0.0, 0.0), |(sum, size), term| (sum + term, size + term.abs()));
            for barrier in [Barrier::Lower, Barrier::Upper] {
                let Some(place) = motion.system.structure.contacts()[contact].barrier(barrier) else { continue };
                let excess = barrier.sign() * (value - place);
                let size = terms + place.abs() + motion.system.origins[contact].abs();
                if excess > OVERSHOOT * size {
                    return Err(StructureStateError::OutsideGap { contact, barrier, value, place, excess });
                }
                if excess >= -ON * size {
                    motion.places[contact] = Place { reference: Some(barrier), x: 0.0, v: None, touch: Contact::Free };
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
                motion.places[contact] = Place { v, touch: Contact::Leaving(barrier, 1), ..motion.places[contact] };
            }
        }
        motion.let_go(&mut untold);
        let cascades = Cascades::new(motion.places.len());
        motion.begin();
        let check = StopCheck::new(Stop::default(), wanted);
        Ok(Self { motion, now: 0.0, in_sequence: false, cascades, stalls: 0, reach, untold, check })
    }

    /// From now on runs end with [`StructureOutcome::Stopped`] once `stop` is raised, before the next event is known or before the next flight.
    /// What it has come to does not depend on that.
    pub fn heed(&mut self, stop: &Stop) {
        self.check = StopCheck::new(stop.clone(), self.structure().modes().len());
    }

    /// Contacts that share coordinates and hit at one instant do so in the order of their numbers, again until none moves into its barrier,
    /// where a run ends with [`StructureOutcome::Simultaneous`] otherwise.
    #[must_use]
    pub fn in_sequence(mut self) -> Self {
        self.in_sequence = true;
        self
    }

    /// Keeps account of the energy from now on, which takes ten evaluations of all modes in two units of the fastest rate. `form`:
    /// [`ModalStructure::energy_form`], or of modes of complex shape `vibrochain_lattice::Structure::energy_form`.
    #[must_use]
    pub fn with_balance(mut self, form: EnergyForm) -> Self {
        self.motion.ledger = None;
        self.bring_to_now();
        self.motion.ledger = Some(Ledger::new(form));
        self
    }

    /// The structure.
    pub fn structure(&self) -> &ModalStructure {
        &self.motion.system.structure
    }

    /// How it flies between impacts.
    pub fn flight(&self) -> FlightChoice {
        let System { structure, omega, fastest, .. } = &self.motion.system;
        FlightChoice::new(structure, (*omega, *fastest))
    }

    /// `periods` periods of the loads and the `part` of one more, as a limit.
    pub fn time_of(&self, periods: u64, part: f64) -> Time {
        Time::of_period(self.motion.system.period(), periods, part)
    }

    /// Present time.
    pub fn time(&self) -> Time {
        self.time_at(self.now)
    }

    /// Work since the start.
    pub fn work(&self) -> Work {
        self.motion.work
    }

    /// What contact number `contact` does now; `None`: there is no such contact.
    pub fn contact(&self, contact: usize) -> Option<ContactState> {
        let place = self.motion.places.get(contact)?;
        let (x, velocity) = self.motion.contact_at(contact, self.now);
        let limits = self.structure().contacts()[contact];
        let reference = place.reference.and_then(|barrier| limits.barrier(barrier));
        let reference = reference.unwrap_or(self.motion.system.origins[contact]);
        let inside =
            (reference + x).clamp(limits.lower.unwrap_or(f64::NEG_INFINITY), limits.upper.unwrap_or(f64::INFINITY));
        let Contact::Resting(barrier) = place.touch else {
            return Some(ContactState { place: inside, velocity, resting: None, force: 0.0 });
        };
        let force = self.motion.force_at(contact, self.now);
        Some(ContactState { place: inside, velocity: 0.0, resting: Some(barrier), force })
    }

    /// The exact state now. Looking changes nothing.
    pub fn state(&self) -> StructureState {
        let ([place, velocity], modes) = self.motion.coordinates_at(self.now);
        let contacts = (0..self.motion.places.len()).filter_map(|contact| self.contact(contact)).collect();
        StructureState { place, velocity, modes, contacts, time: self.time() }
    }

    /// Work and losses since [`StructureSimulation::with_balance`]: E(t) − E(0) = work − dashpots − impacts. `None` where none is kept.
    /// It is brought to the present time.
    pub fn balance(&mut self) -> Option<EnergyBalance> {
        self.bring_to_now();
        self.motion.ledger.as_ref().map(Ledger::balance)
    }

    fn bring_to_now(&mut self) {
        if self.now > 0.0 {
            self.move_on(self.now);
            self.motion.begin();
        }
    }

    /// Runs until the first of `limits` is met; every event is shown to `observer`, in the order of time.
    ///
    /// A run can be continued by another; its limits on impacts and work count anew.
    pub fn run(&mut self, limits: &Limits, mut observer: impl FnMut(&ContactEvent)) -> StructureReport {
        let outcome = self.advance(limits, &mut observer, &mut Alone);
        StructureReport { outcome, time: self.time(), work: self.motion.work }
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
        let mut riders = tangents.mount(&self.motion, self.now)?;
        let outcome = self.advance(limits, &mut observer, &mut riders);
        riders.fly_to(&self.motion, self.now);
        Ok(StructureReport { outcome, time: self.time(), work: self.motion.work })
    }

    /// The events of a run, collected.
    pub fn collect(&mut self, limits: &Limits) -> (StructureReport, Vec<ContactEvent>) {
        let mut events = Vec::new();
        let report = self.run(limits, |event| events.push(*event));
        (report, events)
    }

    fn advance(
        &mut self,
        limits: &Limits,
        observer: &mut impl FnMut(&ContactEvent),
        company: &mut impl Company,
    ) -> StructureOutcome {
        let impacts = self.motion.work.impacts.saturating_add(limits.impacts);
        let flights = self.flights().saturating_add(limits.flights);
        let untold = std::mem::take(&mut self.untold);
        let _ = self.tell(&untold, limits, observer);
        loop {
            if self.motion.work.impacts >= impacts {
                return StructureOutcome::ImpactsReached;
            }
            if self.flights() >= flights {
                return StructureOutcome::WorkLimit;
            }
            let is_within = |(xi, reach): (&[f64; 2], &f64)| xi.iter().all(|xi| xi.abs() <= *reach);
            if let Flight::Modes(flight) = &self.motion.flight
                && let Some(mode) = flight.xi.iter().zip(&self.reach).position(|pair| !is_within(pair))
            {
                return StructureOutcome::Diverged { mode };
            }
            let target =
                limits.until.map_or(f64::INFINITY, |time| self.motion.clock.until(time.periods(), time.offset()));
            let horizon = self.motion.horizon;
            let pending = self.cascades.next_rest();
            let limit = target.min(horizon).min(pending);
            let next = match self.motion.next(limit, &mut self.check) {
                Ok(next) => next,
                Err(Stopped) => return StructureOutcome::Stopped,
            };
            if let Some(first) = next {
                if let Some(outcome) = self.event(first, limits, observer, company) {
                    return outcome;
                }
            } else if pending <= limit {
                self.now = self.now.max(pending);
                let time = self.time();
                self.cascades.rested_by(pending, |change| observer(&event(change, time)));
            } else if target <= horizon {
                self.now = self.now.max(target);
                return StructureOutcome::TimeReached;
            } else {
                self.move_on(horizon);
                self.motion.begin();
            }
        }
    }

    fn flights(&self) -> u64 {
        self.motion.work.windows + self.motion.work.restarts
    }

    /// Moves the base, and what is kept here with it.
    fn move_on(&mut self, by: f64) {
        self.motion.rebase(by);
        self.rebased(by);
    }

    /// What is kept here moves with the base.
    fn rebased(&mut self, by: f64) {
        self.now = 0.0;
        self.cascades.rebased(by);
    }

    fn event(
        &mut self,
        first: f64,
        limits: &Limits,
        observer: &mut impl FnMut(&ContactEvent),
        company: &mut impl Company,
    ) -> Option<StructureOutcome> {
        let (at, parts) = self.motion.arrive(first, self.now);
        if parts.is_some() {
            self.now = at;
        } else {
            self.rebased(at);
        }
        // Contacts that restart in a part share no coordinates.
        if !self.in_sequence
            && parts.is_none()
            && let Some((first, second)) = self.motion.conflict()
        {
            // The same events are due once more at the base.
            self.motion.stand();
            return Some(StructureOutcome::Simultaneous { first, second });
        }
        let mut changes = Vec::new();
        company.arrive(&self.motion, self.now);
        let result = self.motion.collide(&mut changes);
        company.meet(&self.motion, &changes);
        let outcome = self.tell(&changes, limits, observer);
        self.motion.flight.note_event(self.now);
        match parts {
            Some(parts) => self.motion.restart(&parts, self.now),
            None => self.motion.begin(),
        }
        self.stalls = if changes.is_empty() { self.stalls + 1 } else { 0 };
        let stalled = if self.stalls > STALLS { self.motion.due.first().copied() } else { result.err() };
        let cascade =
            stalled.map(|due| StructureOutcome::Cascade { contact: due.contact, barrier: due.barrier, bounces: 0 });
        cascade.or(outcome)
    }

    /// Reports `changes` at the base and counts bounces.
    fn tell(
        &mut self,
        changes: &[Change],
        limits: &Limits,
        observer: &mut impl FnMut(&ContactEvent),
    ) -> Option<StructureOutcome> {
        let (time, now, system) = (self.time(), (&self.motion.clock, self.now), &self.motion.system);
        let wait = |contact: usize| {
            // A cascade takes ln(from/to)/(1 − e) impacts from one length of its flights to another.
            let loss = 1.0 - system.structure.contacts()[contact].restitution;
            let most = f64::from(limits.bounces);
            let is_resolved = loss * most >= (BOUNCE_TIME / CHATTER_TIME).ln();
            let (bounce, pressed) = (BOUNCE_TIME / system.fastest, PRESSED / system.fastest);
            if is_resolved { bounce } else { pressed.min(system.period() / most).max(bounce) }
        };
        let observe = |change: &Change| observer(&event(change, time));
        let cascade = self.cascades.tell(changes, now, limits.bounces, wait, observe);
        cascade.map(|Cascade { site: contact, barrier, bounces }| StructureOutcome::Cascade {
            contact,
            barrier,
            bounces,
        })
    }

    fn time_at(&self, s: f64) -> Time {
        let (periods, offset) = self.motion.clock.after(s);
        Time::from_parts(periods, offset, self.motion.system.period())
    }
}

/// What is told of a change at `time`.
fn event(change: &Change, time: Time) -> ContactEvent {
    let &Change { site: contact, barrier, before, after, force: impulse, kind, .. } = change;
    ContactEvent { time, contact, barrier, velocity_before: before, velocity_after: after, impulse, kind }
}

/// Neither infinite nor as good as that, nor not a number.
fn is_sound(value: &f64) -> bool {
    value.abs() <= LARGEST
}
