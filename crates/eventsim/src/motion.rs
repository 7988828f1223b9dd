//! The state of a structure between events, and the search for the next one.

use crate::balance::Ledger;
use crate::event::Work;
use crate::flight::Flight;
use crate::flight::approach::{Approach, Share};
use crate::flight::near::Tendencies;
use crate::flight::places::{FORGET, Place, Places};
use crate::flight::rest_series::{RestForce, Series};
use crate::flight::system::System;
use crate::series::bound;
use crate::stop_check::StopCheck;
use crate::time::Clock;
use crate::units::{MAX_ORDER, spread};
use crate::watch::queue::{Candidates, Entry};
use crate::watch::{self, Contact, Kind, Step, Watch};
use vibrochain_lattice::{Barrier, Stopped};

/// Events this close together, relative to the time since the base or to the time of the fastest rate, happen together.
pub(crate) const SIMULTANEOUS: f64 = 8.0 * f64::EPSILON;

/// A contact whose flight rises less than this part of that scale, or which is so close to its barrier and so slow against the velocities
/// that make up its own, is followed by its own distance and velocity: modes would tell some digits less.
const LOW: f64 = 1.0 / 64.0;

/// An event that is due.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Due {
    pub(crate) contact: usize,
    pub(crate) barrier: Barrier,
    /// A release from rest.
    pub(crate) release: bool,
    /// Of a release right at the start of a series, the order of what takes it off.
    pub(crate) pull: Option<u8>,
}

/// The structure in flight.
#[derive(Debug, Clone)]
pub(crate) struct Motion {
    pub(crate) system: System,
    pub(crate) clock: Clock,
    /// Of the base.
    pub(crate) flight: Flight,
    pub(crate) places: Places,
    /// The window since the base of modes with contacts at rest or next to it; none: flight in modes, or local.
    pub(crate) series: Option<Box<Series>>,
    /// Time in a unit of that of polynomials.
    pub(crate) unit: f64,
    /// Its certified length.
    pub(crate) horizon: f64,
    pub(crate) due: Vec<Due>,
    pub(crate) work: Work,
    pub(crate) ledger: Option<Ledger>,
    pub(crate) candidates: Candidates,
    /// What is due restarts parts of the row alone.
    pub(crate) is_apart: bool,
    shares: Vec<Share>,
    taken: Vec<Entry>,
    pub(crate) seed: u64,
}

impl Motion {
    /// From ξ of the structure.
    pub(crate) fn new(system: System, xi: &[[f64; 2]]) -> Self {
        let flight = Flight::new(&system, system.about_equilibrium(xi), 0.0);
        Self::with(system, flight)
    }

    /// From a state at the base.
    pub(crate) fn with(system: System, flight: Flight) -> Self {
        let places = (0..system.contacts()).map(|contact| Place::free(flight.place(&system, contact))).collect();
        Self {
            clock: Clock::new(system.omega),
            flight,
            places: Places::new(places),
            series: None,
            unit: 1.0,
            horizon: 0.0,
            due: Vec::new(),
            work: Work::default(),
            ledger: None,
            candidates: Candidates::new(system.contacts()),
            is_apart: false,
            shares: Vec::new(),
            taken: Vec::new(),
            seed: 1,
            system,
        }
    }

    /// Whether it flies by its coordinates.
    pub(crate) fn is_local(&self) -> bool {
        matches!(self.flight, Flight::Local(_))
    }

    /// Starts a window at the base.
    pub(crate) fn begin(&mut self) {
        self.work.windows += 1;
        self.candidates.clear();
        self.series = None;
        if let Flight::Local(_) = self.flight {
            self.begin_local();
            return;
        }
        if self.needs_series() {
            self.begin_series();
            return;
        }
        // Windows of varying length, so that their rounding errors do not add up.
        self.horizon = self.system.longest * (1.0 - spread(&mut self.seed).abs() / 64.0);
        // Measured from a barrier for ever, places would drift.
        self.places.free_all(|contact| self.flight.place(&self.system, contact));
        (0..self.places.len()).for_each(|contact| self.candidates.push(contact, 0.0, None, None));
    }

    /// Whether a contact rests, or leaves its barrier so slowly that it is back, or not, before it is far from it.
    fn needs_series(&self) -> bool {
        let Flight::Modes(flight) = &self.flight else { return false };
        if !self.places.resting().is_empty() || self.places.soft().next().is_some() {
            return true;
        }
        if self.places.near().all(|contact| self.places[contact].v.is_none()) {
            return false;
        }
        let tendencies = Series::tendencies(&self.system, flight, &self.places);
        self.places.iter().zip(&tendencies.contacts).enumerate().any(|(contact, (place, c))| {
            let Some(v) = place.v else { return false };
            let most = c[2].abs().max(c[3].abs()).max(c[4].abs());
            let low = LOW * flight.scale(&self.system, contact);
            let is_slow = || v.abs() <= LOW * flight.pace(&self.system, contact);
            c[0].abs() <= low && (c[1].abs() <= most && c[1] * c[1] <= low * most || is_slow())
        })
    }

    fn begin_series(&mut self) {
        let Flight::Modes(flight) = &self.flight else { return };
        let series = Series::window(&self.system, flight, &self.places);
        (self.horizon, self.unit) = (series.length, series.length);
        for (contact, place) in self.places.iter().enumerate() {
            if let Contact::Resting(_) = place.touch {
                continue;
            }
            let c = series.contacts[contact];
            let mut bend = bound::Enclosure::default();
            (2..=MAX_ORDER).rev().for_each(|k| bend.add((k * (k - 1)) as f64 * c[k], 1.0));
            // A barrier that is not there is beyond reach.
            let far = f64::MIN_POSITIVE + 2.0 * c.iter().map(|c| c.abs()).sum::<f64>();
            let [lower, upper] = place.barriers(&self.system, contact);
            let (lower, upper) = (lower.unwrap_or(-far), upper.unwrap_or(far));
            let (order, horizon) = (MAX_ORDER, 1.0);
            let flight = watch::Flight { c, order, horizon, lower, upper, bend, contact: place.touch };
            let watch = Watch::flight(contact, &flight);
            self.candidates.push(contact, watch.tau * series.length, None, Some(watch));
        }
        for &RestForce { contact, barrier, ref push } in &series.forces {
            let doubt = series.force_doubt(&self.system, contact);
            let mut watch = Watch::rest(contact, barrier, MAX_ORDER, 1.0, doubt);
            watch.c[..MAX_ORDER - 1].copy_from_slice(&push[..MAX_ORDER - 1]);
            let key = watch.prepare() * series.length;
            if key.is_finite() {
                self.candidates.push(contact, key, None, Some(watch));
            }
        }
        self.series = Some(Box::new(series));
    }

    /// The time since the base of the next events up to `limit`, which are left in `due`; `None`: there are none up to it.
    ///
    /// The candidate with the earliest key is advanced by certified steps until another one is earlier or its event is reached: so an
    /// event that comes out is the first of all.
    ///
    /// # Errors
    /// [`Stopped`], which may be asked again.
    pub(crate) fn next(&mut self, limit: f64, check: &mut StopCheck) -> Result<Option<f64>, Stopped> {
        self.due.clear();
        let (mut first, mut last) = (None, limit);
        self.taken.clear();
        loop {
            if check.is_raised() {
                self.candidates.put_back(&mut self.taken);
                return Err(Stopped);
            }
            let Some((mut key, candidate)) = self.candidates.first().filter(|(key, _)| *key <= last) else { break };
            let contact = candidate.contact;
            if let Some(barrier) = candidate.hit {
                if first.is_none() {
                    first = Some(key);
                    last = key + SIMULTANEOUS * key.max(1.0 / self.system.fastest);
                }
                let watch = candidate.watch.as_ref();
                let release = watch.is_some_and(|watch| matches!(watch.kind, Kind::Rest(_)));
                let pull = watch.and_then(Watch::first_pull);
                self.due.push(Due { contact, barrier, release, pull });
                self.taken.extend(self.candidates.take());
                continue;
            }
            self.work.refinements += 1;
            let place = &self.places[contact];
            let mut origin = 0.0;
            if let Flight::Local(flight) = &self.flight {
                origin = flight.origin(contact);
                if candidate.watch.is_none() {
                    self.work.watched += 1;
                    let mut watch = flight.watch(contact, place, place.barriers(&self.system, contact));
                    watch.tau = watch.tau.max(key / self.unit - origin);
                    candidate.watch = Some(watch);
                }
            }
            let step = match (&mut candidate.watch, &self.flight) {
                (None, Flight::Modes(flight)) => {
                    let approach = Approach { system: &self.system, flight, contact, place };
                    let (step, hit) = approach.step((&mut key, self.horizon), &mut self.shares);
                    candidate.hit = hit;
                    step
                }
                (Some(watch), _) => {
                    let step = watch.step();
                    (key, candidate.hit) = ((origin + watch.tau) * self.unit, watch.hit);
                    step
                }
                (None, Flight::Local(_)) => Step::Clear,
            };
            if step == Step::Clear {
                self.candidates.take();
            } else {
                self.candidates.put_off(key);
            }
        }
        self.due.sort_unstable_by_key(|due| due.contact);
        Ok(first)
    }

    /// Starts a window and leaves the impacts that are due at the base for another run. (What is released comes again by itself.)
    pub(crate) fn stand(&mut self) {
        self.begin();
        self.candidates.clear();
        let hits = self.due.iter().filter(|due| !due.release);
        hits.for_each(|due| self.candidates.push(due.contact, 0.0, Some(due.barrier), None));
    }

    /// Moves the base to `s`.
    pub(crate) fn rebase(&mut self, s: f64) {
        // A flight that repeats would repeat its rounding.
        let is_varied = s != 0.0 && self.series.is_none();
        let s = if is_varied { s * (1.0 + 4.0 * f64::EPSILON * spread(&mut self.seed)) } else { s };
        self.move_base(s);
    }

    fn move_base(&mut self, s: f64) {
        if s == 0.0 {
            return;
        }
        if let Some(mut ledger) = self.ledger.take() {
            let form = ledger.form.take();
            ledger.flight(self.system.fastest, s, |time| self.powers_at(form.as_ref(), time));
            ledger.form = form;
            self.ledger = Some(ledger);
        }
        if let Self { flight: Flight::Local(flight), places, clock, system, .. } = self {
            let weights = flight.weights_at(s);
            if !flight.is_direct {
                places.move_near(|contact, place| flight.moved(contact, place, s, &weights));
            }
            clock.advance(s);
            flight.advance(s, &weights, &system.loads, clock.offset());
            places.move_near(|contact, place| flight.settled(contact, place));
        } else {
            self.move_modes(s);
        }
        if !self.places.resting().is_empty() {
            self.hold(&[]);
        }
    }

    fn move_modes(&mut self, s: f64) {
        let states: Vec<(usize, (f64, f64))> =
            self.places.near().map(|contact| (contact, self.contact_at(contact, s))).collect();
        let xi = self.modes_at(s);
        self.clock.advance(s);
        self.flight = Flight::new(&self.system, xi, self.clock.offset());
        for (contact, (x, v)) in states {
            let place = self.places[contact];
            if self.places.is_resting(contact) {
                continue;
            }
            self.places.set(
                contact,
                if x.abs() > FORGET * self.flight.scale(&self.system, contact) {
                    Place::free(self.flight.place(&self.system, contact))
                } else {
                    // A flight so short that even the distance underflows has not left.
                    let touch = if x == 0.0 { place.touch } else { Contact::Free };
                    Place { x, v: Some(v), touch, ..place }
                },
            );
        }
        let Self { flight, places, system, .. } = self;
        places.move_free(|contact| flight.place(system, contact));
    }

    /// Measures a contact from a barrier, at the distance `x`.
    pub(crate) fn anchor(&mut self, contact: usize, barrier: Barrier, x: f64) {
        self.places.set(contact, Place { reference: Some(barrier), ..Place::free(x) });
        if let (Flight::Local(flight), true) = (&mut self.flight, self.system.is_direct())
            && let Some(at) = self.system.barrier(contact, barrier)
        {
            let velocity = flight.velocity(contact);
            flight.put(contact, [at, x], velocity);
        }
    }

    /// Where contacts tend to.
    pub(crate) fn tendencies(&self) -> Tendencies {
        self.flight.tendencies(&self.system, &self.places)
    }

    /// Takes the rounding off the places and velocities of contacts at rest, and the velocities of those that stand `still`.
    pub(crate) fn hold(&mut self, still: &[usize]) {
        // A coordinate that rests does not move from where it was put.
        let mut resting = if self.system.is_direct() { Vec::new() } else { self.places.resting().to_vec() };
        let off = |motion: &Self, contact: usize| {
            let place = &motion.places[contact];
            let barrier = place.reference.and_then(|barrier| motion.system.barrier(contact, barrier));
            barrier.map_or(0.0, |barrier| barrier - motion.flight.place(&motion.system, contact))
        };
        let changes: Vec<f64> = resting.iter().map(|&contact| off(self, contact)).collect();
        for (&contact, amount) in resting.iter().zip(self.system.impulses(&resting, &changes)) {
            self.flight.shift(&self.system, contact, amount);
        }
        resting.extend_from_slice(still);
        if resting.is_empty() {
            return;
        }
        let changes: Vec<f64> = resting.iter().map(|&contact| -self.flight.velocity(&self.system, contact)).collect();
        for (&contact, impulse) in resting.iter().zip(self.system.impulses(&resting, &changes)) {
            self.push(contact, impulse);
        }
        resting.iter().for_each(|&contact| self.places.set_velocity(contact, 0.0));
    }

    /// Lets the modes have the places and velocities of contacts that were followed by their own: their rounding would add up from bounce to
    /// bounce, and the acceleration of a contact that chatters is what its modes say.
    pub(crate) fn take_up(&mut self, followed: &[(usize, Barrier)]) {
        // Each moves the others that share its modes.
        for &(contact, barrier) in followed.iter().chain(followed) {
            let place = self.system.barrier(contact, barrier);
            let off = place.map_or(0.0, |place| place - self.flight.place(&self.system, contact));
            self.flight.lean(&self.system, contact, off);
        }
        for &(contact, _) in followed.iter().chain(followed) {
            let off = self.places[contact].v.map_or(0.0, |v| v - self.flight.velocity(&self.system, contact));
            self.flight.strike(&self.system, contact, self.system.impulse(contact, off));
        }
    }

    /// An impulse at a contact, which moves all that share a coordinate with it.
    pub(crate) fn push(&mut self, contact: usize, impulse: f64) {
        self.flight.strike(&self.system, contact, impulse);
        for &(other, mobility) in self.system.sharing(contact) {
            let place = self.places[other];
            let Some(v) = place.v.filter(|_| impulse != 0.0) else { continue };
            let v = v + mobility * impulse;
            // On its barrier still: it leaves with a velocity now, or hits at once.
            let touch = match place.touch {
                Contact::Leaving(barrier, _) if barrier.sign() * v < 0.0 => Contact::Leaving(barrier, 1),
                Contact::Leaving(..) => Contact::Free,
                touch => touch,
            };
            self.places.set(other, Place { v: Some(v), touch, ..place });
        }
    }
}
