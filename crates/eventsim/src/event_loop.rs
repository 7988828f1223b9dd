//! The event loop: flight from window to window, and what interrupts it.

use crate::cascade::{Cascades, Change};
use crate::event::{BOUNCE_TIME, Event, Limits, Outcome, Report};
use crate::flight::Flight;
use crate::motion::Motion;
use crate::rest::CHATTER_TIME;
use crate::stop_check::StopCheck;
use crate::time::Time;
use crate::with_tangents::Perturbations;
use vibrochain_lattice::{Stop, Stopped};

/// Of a contact that loses nothing, flights shorter than this, in units of the fastest rate, and so short that a period holds more than
/// [`Limits::bounces`] of them, are of one cascade: pressed it bounces for ever, where one that loses energy comes to rest.
const PRESSED: f64 = 1e-3;

/// Events in a row without any effect before the run gives up; a contact whose force touches zero makes one or two.
const STALLS: u32 = 1000;

/// A run under way.
#[derive(Debug, Clone)]
pub(crate) struct EventLoop {
    pub(crate) motion: Motion,
    /// Present time since the base.
    pub(crate) now: f64,
    /// Contacts that share coordinates and hit at one instant do so in sequence.
    pub(crate) in_sequence: bool,
    cascades: Cascades,
    stalls: u32,
    /// Coordinates of each mode beyond these have diverged.
    reach: Vec<f64>,
    /// Events of the start, which the first run tells.
    untold: Vec<Change>,
    changes: Vec<Change>,
    check: StopCheck,
}

impl EventLoop {
    /// From a state in which contacts on their barriers have been told apart from those that hit them; modes have diverged beyond `reach`.
    pub(crate) fn new(mut motion: Motion, reach: Vec<f64>, mut untold: Vec<Change>) -> Self {
        motion.let_go(&mut untold);
        let (cascades, check) = (Cascades::new(motion.places.len()), StopCheck::new(Stop::default(), 1));
        motion.begin();
        let (now, in_sequence, stalls, changes) = (0.0, false, 0, Vec::new());
        Self { motion, now, in_sequence, cascades, stalls, reach, untold, changes, check }
    }

    /// From now on runs end once `stop` is raised.
    pub(crate) fn heed(&mut self, stop: &Stop) {
        self.check = StopCheck::new(stop.clone(), self.motion.system.size());
    }

    /// Present time.
    pub(crate) fn time(&self) -> Time {
        self.time_at(self.now)
    }

    /// Moves the base to the present time.
    pub(crate) fn bring_to_now(&mut self) {
        if self.now > 0.0 {
            self.move_on(self.now);
            self.motion.begin();
        }
    }

    /// Runs until the first of `limits` is met; every event is shown to `observer`, in the order of time.
    pub(crate) fn run(
        &mut self,
        limits: &Limits,
        observer: &mut impl FnMut(&Event),
        perturbations: &mut impl Perturbations,
    ) -> Report {
        let outcome = self.advance(limits, observer, perturbations);
        Report { outcome, time: self.time(), work: self.motion.work }
    }

    fn advance(
        &mut self,
        limits: &Limits,
        observer: &mut impl FnMut(&Event),
        perturbations: &mut impl Perturbations,
    ) -> Outcome {
        let impacts = self.motion.work.impacts.saturating_add(limits.impacts);
        let flights = self.flights().saturating_add(limits.flights);
        let untold = std::mem::take(&mut self.untold);
        let _ = self.tell(&untold, limits, observer);
        loop {
            if self.motion.work.impacts >= impacts {
                return Outcome::ImpactsReached;
            }
            if self.flights() >= flights {
                return Outcome::WorkLimit;
            }
            let is_within = |(xi, reach): (&[f64; 2], &f64)| xi.iter().all(|xi| xi.abs() <= *reach);
            if let Flight::Modes(flight) = &self.motion.flight
                && let Some(mode) = flight.xi.iter().zip(&self.reach).position(|pair| !is_within(pair))
            {
                return Outcome::Diverged { mode };
            }
            let target =
                limits.until.map_or(f64::INFINITY, |time| self.motion.clock.until(time.periods(), time.offset()));
            let horizon = self.motion.horizon;
            let pending = self.cascades.next_rest();
            let limit = target.min(horizon).min(pending);
            let next = match self.motion.next(limit, &mut self.check) {
                Ok(next) => next,
                Err(Stopped) => return Outcome::Stopped,
            };
            if let Some(first) = next {
                if let Some(outcome) = self.event(first, limits, observer, perturbations) {
                    return outcome;
                }
            } else if pending <= limit {
                self.now = self.now.max(pending);
                let time = self.time();
                self.cascades.rested_by(pending, |change| observer(&event(change, time)));
            } else if target <= horizon {
                self.now = self.now.max(target);
                return Outcome::TimeReached;
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
        observer: &mut impl FnMut(&Event),
        perturbations: &mut impl Perturbations,
    ) -> Option<Outcome> {
        let (at, is_whole) = self.motion.arrive(first, self.now);
        if is_whole {
            self.rebased(at);
        } else {
            self.now = at;
        }
        // Contacts that are coordinates share none.
        if !self.in_sequence
            && !self.motion.system.is_direct()
            && let Some((first, second)) = self.motion.conflict()
        {
            // The same events are due once more at the base.
            self.motion.stand();
            return Some(Outcome::Simultaneous { first, second });
        }
        let mut changes = std::mem::take(&mut self.changes);
        changes.clear();
        perturbations.arrive(&self.motion, self.now);
        let result = self.motion.collide(&mut changes);
        perturbations.meet(&self.motion, &changes);
        let outcome = self.tell(&changes, limits, observer);
        self.motion.flight.note_event(self.now);
        self.motion.restart(self.now);
        self.stalls = if changes.is_empty() { self.stalls + 1 } else { 0 };
        self.changes = changes;
        let stalled = if self.stalls > STALLS { self.motion.due.first().copied() } else { result.err() };
        let cascade = stalled.map(|due| Outcome::Cascade { contact: due.contact, barrier: due.barrier, bounces: 0 });
        cascade.or(outcome)
    }

    /// Reports `changes` at the base and counts bounces.
    fn tell(&mut self, changes: &[Change], limits: &Limits, observer: &mut impl FnMut(&Event)) -> Option<Outcome> {
        let (time, now, system) = (self.time(), (&self.motion.clock, self.now), &self.motion.system);
        let wait = |contact: usize| {
            // A cascade takes ln(from/to)/(1 − e) impacts from one length of its flights to another.
            let loss = 1.0 - system.restitution(contact);
            let most = f64::from(limits.bounces);
            let is_resolved = loss * most >= (BOUNCE_TIME / CHATTER_TIME).ln();
            let (bounce, pressed) = (BOUNCE_TIME / system.fastest, PRESSED / system.fastest);
            if is_resolved { bounce } else { pressed.min(system.period() / most).max(bounce) }
        };
        let observe = |change: &Change| observer(&event(change, time));
        self.cascades.tell(changes, now, limits.bounces, wait, observe)
    }

    fn time_at(&self, s: f64) -> Time {
        let (periods, offset) = self.motion.clock.after(s);
        Time::from_parts(periods, offset, self.motion.system.period())
    }
}

/// What is told of a change at `time`.
fn event(change: &Change, time: Time) -> Event {
    let &Change { contact, barrier, before, after, impulse, kind, .. } = change;
    Event { time, contact, barrier, velocity_before: before, velocity_after: after, impulse, kind }
}
