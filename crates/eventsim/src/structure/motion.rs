//! The state of a structure between events, and the search for the next one.

use super::approach::{Approach, Place, Share};
use super::balance::Ledger;
use super::flight::Flight;
use super::series::{RestForce, Series};
use super::system::System;
use crate::bound;
use crate::event::Work;
use crate::ring::Contact;
use crate::stop_check::StopCheck;
use crate::time::Clock;
use crate::units::{MAX_ORDER, spread};
use crate::watch::{self, Kind, Step, Watch};
use vibrochain_lattice::{Barrier, Stopped};

/// Events this close together, relative to the time since the base or to the time of the fastest rate, happen together.
pub(super) const SIMULTANEOUS: f64 = 8.0 * f64::EPSILON;

/// Beyond this part of the scale of its motion a contact forgets the barrier that x is measured from: g is known as well.
const FORGET: f64 = 1.0 / 16.0;

/// A contact whose flight rises less than this part of that scale, or which is so close to its barrier and so slow against the velocities
/// that make up its own, is followed by its own distance and velocity: modes would tell some digits less.
const LOW: f64 = 1.0 / 64.0;

/// A contact on its way to its barrier, or at rest and on its way to be released.
#[derive(Debug, Clone)]
struct Candidate {
    contact: usize,
    /// No event before this time since the base.
    key: f64,
    hit: Option<Barrier>,
    is_due: bool,
    /// In a window of series, its polynomial.
    watch: Option<Watch>,
}

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
    pub(crate) places: Vec<Place>,
    /// The window since the base; none: flight in modes.
    pub(crate) series: Option<Box<Series>>,
    /// Its certified length.
    pub(crate) horizon: f64,
    pub(crate) due: Vec<Due>,
    pub(crate) work: Work,
    pub(crate) ledger: Option<Ledger>,
    candidates: Vec<Candidate>,
    shares: Vec<Share>,
    seed: u64,
}

impl Motion {
    /// From ξ of the structure.
    pub(crate) fn new(system: System, xi: &[[f64; 2]]) -> Self {
        let flight = Flight::new(&system, system.about_equilibrium(xi), 0.0);
        let place =
            |contact| Place { reference: None, x: flight.place(&system, contact), v: None, touch: Contact::Free };
        let places = (0..system.contacts()).map(place).collect();
        Self {
            clock: Clock::new(system.omega),
            flight,
            places,
            series: None,
            horizon: 0.0,
            due: Vec::new(),
            work: Work::default(),
            ledger: None,
            candidates: Vec::new(),
            shares: Vec::new(),
            seed: 1,
            system,
        }
    }

    pub(crate) fn resting(&self) -> Vec<usize> {
        (0..self.places.len()).filter(|&contact| matches!(self.places[contact].touch, Contact::Resting(_))).collect()
    }

    /// Starts a window at the base.
    pub(crate) fn begin(&mut self) {
        self.work.windows += 1;
        self.candidates.clear();
        if self.needs_series() {
            self.begin_series();
            return;
        }
        self.series = None;
        // Windows of varying length, so that their rounding errors do not add up.
        self.horizon = self.system.longest * (1.0 - spread(&mut self.seed).abs() / 64.0);
        for contact in 0..self.places.len() {
            // Measured from a barrier for ever, places would drift.
            let x = self.flight.place(&self.system, contact);
            self.places[contact] = Place { reference: None, x, v: None, touch: Contact::Free };
            self.candidates.push(Candidate { contact, key: 0.0, hit: None, is_due: false, watch: None });
        }
    }

    /// Whether a contact rests, or leaves its barrier so slowly that it is back, or not, before it is far from it.
    fn needs_series(&self) -> bool {
        let is_soft = |place: &Place| matches!(place.touch, Contact::Resting(_) | Contact::Leaving(_, 2..));
        if self.places.iter().any(is_soft) {
            return true;
        }
        if self.places.iter().all(|place| place.v.is_none()) {
            return false;
        }
        let tendencies = Series::tendencies(&self.system, &self.flight, &self.places);
        self.places.iter().zip(&tendencies.contacts).enumerate().any(|(contact, (place, c))| {
            let Some(v) = place.v else { return false };
            let most = c[2].abs().max(c[3].abs()).max(c[4].abs());
            let low = LOW * self.flight.scale(&self.system, contact);
            let is_slow = || v.abs() <= LOW * self.flight.pace(&self.system, contact);
            c[0].abs() <= low && (c[1].abs() <= most && c[1] * c[1] <= low * most || is_slow())
        })
    }

    fn begin_series(&mut self) {
        let series = Series::window(&self.system, &self.flight, &self.places);
        self.horizon = series.length;
        for (contact, place) in self.places.iter().enumerate() {
            if let Contact::Resting(_) = place.touch {
                continue;
            }
            let c = series.contacts[contact];
            let mut bend = bound::Enclosure::default();
            (2..=MAX_ORDER).rev().for_each(|k| bend.add((k * (k - 1)) as f64 * c[k], 1.0));
            // A barrier that is not there is beyond reach.
            let far = f64::MIN_POSITIVE + 2.0 * c.iter().map(|c| c.abs()).sum::<f64>();
            let [lower, upper] = [Barrier::Lower, Barrier::Upper]
                .map(|barrier| place.barrier(&self.system, contact, barrier).unwrap_or(barrier.sign() * far));
            let (order, horizon) = (MAX_ORDER, 1.0);
            let flight = watch::Flight { c, order, horizon, lower, upper, bend, contact: place.touch };
            let watch = Watch::flight(contact, &flight);
            let key = watch.tau * series.length;
            self.candidates.push(Candidate { contact, key, hit: None, is_due: false, watch: Some(watch) });
        }
        for &RestForce { contact, barrier, ref push } in &series.forces {
            let doubt = series.force_doubt(&self.system, contact);
            let mut watch = Watch::rest(contact, barrier, MAX_ORDER, 1.0, doubt);
            watch.c[..MAX_ORDER - 1].copy_from_slice(&push[..MAX_ORDER - 1]);
            let key = watch.prepare() * series.length;
            if key.is_finite() {
                self.candidates.push(Candidate { contact, key, hit: None, is_due: false, watch: Some(watch) });
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
        self.candidates.iter_mut().for_each(|candidate| candidate.is_due = false);
        let (mut first, mut last) = (None, limit);
        loop {
            if check.is_raised() {
                return Err(Stopped);
            }
            let open = self.candidates.iter_mut().enumerate().filter(|(_, candidate)| !candidate.is_due);
            let Some((i, candidate)) = open.min_by(|a, b| a.1.key.total_cmp(&b.1.key)) else { break };
            if candidate.key > last {
                break;
            }
            if let Some(barrier) = candidate.hit {
                if first.is_none() {
                    first = Some(candidate.key);
                    last = candidate.key + SIMULTANEOUS * candidate.key.max(1.0 / self.system.fastest);
                }
                candidate.is_due = true;
                let watch = candidate.watch.as_ref();
                let release = watch.is_some_and(|watch| matches!(watch.kind, Kind::Rest(_)));
                let pull = watch.and_then(Watch::first_pull);
                self.due.push(Due { contact: candidate.contact, barrier, release, pull });
                continue;
            }
            self.work.refinements += 1;
            let step = if let (Some(watch), Some(series)) = (&mut candidate.watch, &self.series) {
                let step = watch.step();
                (candidate.key, candidate.hit) = (watch.tau * series.length, watch.hit);
                step
            } else {
                let contact = candidate.contact;
                let place = &self.places[contact];
                let approach = Approach { system: &self.system, flight: &self.flight, contact, place };
                let (step, hit) = approach.step((&mut candidate.key, self.horizon), &mut self.shares);
                candidate.hit = hit;
                step
            };
            if step == Step::Clear {
                self.candidates.swap_remove(i);
            }
        }
        self.due.sort_unstable_by_key(|due| due.contact);
        Ok(first)
    }

    /// Starts a window and leaves the impacts that are due at the base for another run. (What is released comes again by itself.)
    pub(crate) fn stand(&mut self) {
        self.begin();
        self.candidates = (self.due.iter().filter(|due| !due.release))
            .map(|due| Candidate { contact: due.contact, key: 0.0, hit: Some(due.barrier), is_due: false, watch: None })
            .collect();
    }

    /// ξ of all modes at `s` since the base, from their equilibrium.
    pub(crate) fn modes_at(&self, s: f64) -> Vec<[f64; 2]> {
        match &self.series {
            Some(series) if !series.forces.is_empty() => {
                (0..self.flight.xi.len()).map(|k| series.mode(k, s / series.length)).collect()
            }
            _ => self.flight.all_at(&self.system, s),
        }
    }

    /// x, measured as at the base, and v of a contact at `s`.
    pub(crate) fn contact_at(&self, contact: usize, s: f64) -> (f64, f64) {
        match &self.series {
            Some(series) => series.contact(contact, s / series.length),
            None => {
                let place = &self.places[contact];
                let approach = Approach { system: &self.system, flight: &self.flight, contact, place };
                let view = approach.view(s, 0.0, &mut Vec::new());
                (view.x, view.v)
            }
        }
    }

    /// Moves the base to `s`.
    pub(crate) fn rebase(&mut self, s: f64) {
        if s == 0.0 {
            return;
        }
        let is_held = self.series.as_ref().is_some_and(|series| !series.forces.is_empty());
        // A flight that repeats would repeat its rounding.
        let s = if self.series.is_none() { s * (1.0 + 4.0 * f64::EPSILON * spread(&mut self.seed)) } else { s };
        if let Some(mut ledger) = self.ledger.take() {
            ledger.flight(&self.system, &self.flight.turned, s, |time| self.system.absolute(&self.modes_at(time)));
            self.ledger = Some(ledger);
        }
        let states: Vec<(f64, f64)> = (0..self.places.len()).map(|contact| self.contact_at(contact, s)).collect();
        let xi = self.modes_at(s);
        self.clock.advance(s);
        self.flight = Flight::new(&self.system, xi, self.clock.offset());
        for (contact, (place, (x, v))) in self.places.iter_mut().zip(states).enumerate() {
            if let Contact::Resting(_) = place.touch {
                continue;
            }
            if place.reference.is_none() {
                place.x = self.flight.place(&self.system, contact);
                continue;
            }
            if x.abs() > FORGET * self.flight.scale(&self.system, contact) {
                *place = Place {
                    reference: None,
                    x: self.flight.place(&self.system, contact),
                    v: None,
                    touch: Contact::Free,
                };
            } else {
                // A flight so short that even the distance underflows has not left.
                let touch = if x == 0.0 { place.touch } else { Contact::Free };
                *place = Place { x, v: Some(v), touch, ..*place };
            }
        }
        if is_held {
            self.hold(&[]);
        }
    }

    /// Takes the rounding off the places and velocities of contacts at rest, and the velocities of those that stand `still`.
    pub(crate) fn hold(&mut self, still: &[usize]) {
        let mut resting = self.resting();
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
        let changes: Vec<f64> = resting.iter().map(|&contact| -self.flight.velocity(&self.system, contact)).collect();
        for (&contact, impulse) in resting.iter().zip(self.system.impulses(&resting, &changes)) {
            self.push(contact, impulse);
        }
        resting.iter().for_each(|&contact| self.places[contact].v = Some(0.0));
    }

    /// Lets the modes have the places and velocities of contacts that were followed by their own: their rounding would add up from bounce to
    /// bounce, and the acceleration of a contact that chatters is what its modes say.
    pub(super) fn take_up(&mut self, followed: &[(usize, Barrier)]) {
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
        for (other, place) in self.places.iter_mut().enumerate() {
            let change = self.system.mobility(other, contact) * impulse;
            if let Some(v) = place.v.as_mut().filter(|_| change != 0.0) {
                *v += change;
                // On its barrier still: it leaves with a velocity now, or hits at once.
                if let Contact::Leaving(barrier, _) = place.touch {
                    let is_inward = barrier.sign() * *v < 0.0;
                    place.touch = if is_inward { Contact::Leaving(barrier, 1) } else { Contact::Free };
                }
            }
        }
    }
}
