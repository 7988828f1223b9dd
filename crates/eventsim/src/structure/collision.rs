//! Impacts of a structure, chatter, rest and release.
//!
//! **Impact.** An impulse P = −(1+e) m g′⁻ at the contact, m = 1/(wᵀM⁻¹w): it changes the velocity of every contact that shares a coordinate.
//! The modes are not moved: where rounding has put the barrier is where it is until the contact is back, so no energy is made.
//!
//! **In sequence.** Contacts that share coordinates may meet their barriers at one instant. On request they hit one after another in the
//! order of their numbers, those at rest among them, again and again until none moves outward; a velocity below 1e-12 of the first is none.
//! Without coordinates in common the order does not matter.
//!
//! **Chatter, rest, release** are those of the chain ([`crate::collision`]), with accelerations that know dashpots and the forces of other
//! contacts at rest. A contact that comes to rest may take another one's load off: whose force would pull is released at once.

use super::approach::Place;
use super::motion::{Due, Motion};
use super::series::Series;
use crate::collision::CHATTER_TIME;
use crate::event::EventKind;
use crate::ring::Contact;
use vibrochain_lattice::Barrier;

/// In a sequence, velocity relative to the first one's that is none.
const STILL: f64 = 1e-12;

/// Impacts of one sequence.
const SEQUENCE: u32 = 100_000;

/// What became of one contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Change {
    pub(crate) contact: usize,
    pub(crate) barrier: Barrier,
    pub(crate) before: f64,
    pub(crate) after: f64,
    pub(crate) impulse: f64,
    pub(crate) kind: EventKind,
    /// How much later than now: the limit of a cascade.
    pub(crate) delay: f64,
}

impl Change {
    pub(crate) fn still(contact: usize, barrier: Barrier, kind: EventKind, delay: f64) -> Self {
        Self { contact, barrier, before: 0.0, after: 0.0, impulse: 0.0, kind, delay }
    }
}

impl Motion {
    /// Two contacts of those due (and at rest) whose impacts do not commute.
    pub(crate) fn conflict(&self) -> Option<(usize, usize)> {
        let hits: Vec<&Due> = self.due.iter().filter(|due| !due.release).collect();
        for (i, due) in hits.iter().enumerate() {
            let shares = |contact: usize| self.system.mobility(contact, due.contact);
            if let Some(other) = hits[i + 1..].iter().find(|other| shares(other.contact) != 0.0) {
                return Some((due.contact, other.contact));
            }
            // The impulse is away from the barrier of the one that hits.
            let is_pushed = |contact: &usize| match self.places[*contact].touch {
                Contact::Resting(barrier) => shares(*contact) * barrier.sign() * due.barrier.sign() < 0.0,
                _ => false,
            };
            if let Some(other) = self.resting().iter().find(|contact| is_pushed(contact)) {
                return Some((due.contact, *other));
            }
        }
        None
    }

    /// Applies what is due at the base.
    ///
    /// # Errors
    /// A contact whose sequence of impacts does not end.
    pub(crate) fn collide(&mut self, changes: &mut Vec<Change>) -> Result<(), Due> {
        let due = std::mem::take(&mut self.due);
        let result = self.strike(&due, changes);
        for due in &due {
            self.part(due, changes);
        }
        self.let_go(changes);
        self.due = due;
        result
    }

    /// g′ outward.
    fn outward(&self, contact: usize, barrier: Barrier) -> f64 {
        let v = self.places[contact].v.unwrap_or_else(|| self.flight.velocity(&self.system, contact));
        barrier.sign() * v
    }

    fn strike(&mut self, due: &[Due], changes: &mut Vec<Change>) -> Result<(), Due> {
        let mut involved: Vec<(usize, Barrier, bool)> =
            due.iter().filter(|due| !due.release).map(|due| (due.contact, due.barrier, false)).collect();
        if involved.is_empty() {
            return Ok(());
        }
        for contact in self.resting() {
            if let Contact::Resting(barrier) = self.places[contact].touch {
                involved.push((contact, barrier, true));
            }
        }
        involved.sort_unstable_by_key(|(contact, ..)| *contact);
        for &(contact, barrier, is_resting) in &involved {
            let v = if is_resting { 0.0 } else { barrier.sign() * self.outward(contact, barrier) };
            let touch = self.places[contact].touch;
            self.places[contact] = Place { reference: Some(barrier), x: 0.0, v: Some(v), touch };
        }
        let first = involved.iter().map(|&(contact, barrier, _)| self.outward(contact, barrier)).fold(0.0, f64::max);
        let (mut round, mut impacts) = (0, 0);
        loop {
            let mut is_quiet = true;
            for &(contact, barrier, is_resting) in &involved {
                let outward = self.outward(contact, barrier).max(0.0);
                // A graze is an event, too: once.
                let counts = if round == 0 && !is_resting { true } else { outward > STILL * first };
                if counts {
                    self.impact(contact, barrier, outward, changes);
                    impacts += 1;
                    is_quiet = false;
                }
            }
            if is_quiet {
                break;
            }
            if impacts > SEQUENCE {
                let (contact, barrier, _) = involved[0];
                return Err(Due { contact, barrier, release: false, pull: None });
            }
            round += 1;
        }
        for &(contact, barrier, is_resting) in &involved {
            let outward = self.outward(contact, barrier);
            if is_resting && -outward > STILL * first {
                self.places[contact].touch = Contact::Leaving(barrier, 1);
                self.work.releases += 1;
                let after = barrier.sign() * outward;
                changes.push(Change { after, ..Change::still(contact, barrier, EventKind::Release, 0.0) });
            } else if is_resting || outward > 0.0 {
                self.places[contact].v = Some(0.0);
            }
        }
        Ok(())
    }

    fn impact(&mut self, contact: usize, barrier: Barrier, outward: f64, changes: &mut Vec<Change>) {
        let restitution = self.system.structure.contacts()[contact].restitution;
        let before = barrier.sign() * outward;
        let after = 0.0 - restitution * before;
        let impulse = self.system.impulse(contact, after - before);
        self.flight.strike(&self.system, contact, impulse);
        for other in 0..self.places.len() {
            if let Some(v) = &mut self.places[other].v {
                *v += self.system.mobility(other, contact) * impulse;
            }
        }
        self.places[contact].v = Some(after);
        if let Some(ledger) = &mut self.ledger {
            ledger.impact(-0.5 * impulse * (before + after));
        }
        self.work.impacts += 1;
        changes.push(Change { contact, barrier, before, after, impulse, kind: EventKind::Impact, delay: 0.0 });
    }

    fn part(&mut self, due: &Due, changes: &mut Vec<Change>) {
        let &Due { contact, barrier, release, pull } = due;
        if release {
            self.release(contact, barrier, 3, pull, changes);
            return;
        }
        let outward = self.outward(contact, barrier);
        if outward == 0.0 {
            self.settle(contact, barrier, changes);
            return;
        }
        self.places[contact].touch = Contact::Leaving(barrier, 1);
        let loss = 1.0 - self.system.structure.contacts()[contact].restitution;
        if loss > 0.0 {
            let series = Series::tendencies(&self.system, &self.flight, &self.places);
            let (c, h) = (series.contacts[contact], series.length);
            let pressing = 2.0 * barrier.sign() * c[2] / (h * h);
            let jerk = 6.0 * c[3].abs() / (h * h * h);
            if pressing > 0.0 {
                let left = 2.0 * outward.abs() / (pressing * loss);
                if left * (1.0 + jerk / pressing) * self.system.fastest < CHATTER_TIME {
                    self.rest(contact, barrier, left, changes);
                }
            }
        }
    }

    /// A contact on its barrier without velocity: it rests, or leaves.
    pub(crate) fn settle(&mut self, contact: usize, barrier: Barrier, changes: &mut Vec<Change>) {
        self.places[contact].v = Some(0.0);
        self.places[contact].touch = Contact::Free;
        match Series::tendencies(&self.system, &self.flight, &self.places).tendency(contact, barrier, 2) {
            Some((order, false)) => self.places[contact].touch = Contact::Leaving(barrier, order),
            _ => self.rest(contact, barrier, 0.0, changes),
        }
    }

    fn rest(&mut self, contact: usize, barrier: Barrier, delay: f64, changes: &mut Vec<Change>) {
        if let Some(ledger) = &mut self.ledger {
            let v = self.places[contact].v.unwrap_or(0.0);
            ledger.impact(0.5 * v * v / self.system.mobility(contact, contact));
        }
        let place = &mut self.places[contact];
        (place.x, place.v, place.reference) = (0.0, Some(0.0), Some(barrier));
        place.touch = Contact::Resting(barrier);
        self.work.sticks += 1;
        changes.push(Change::still(contact, barrier, EventKind::Stick, delay));
        self.hold();
    }

    /// Lets a contact leave its barrier with the first derivative, from `order` on, that does not vanish; if that points outward it stays.
    fn release(&mut self, contact: usize, barrier: Barrier, order: usize, pull: Option<u8>, changes: &mut Vec<Change>) {
        let before = self.places[contact].touch;
        self.places[contact].touch = Contact::Free;
        self.places[contact].v = Some(0.0);
        let series = Series::tendencies(&self.system, &self.flight, &self.places);
        let tendency = series.tendency(contact, barrier, order);
        if let Some((order, false)) = tendency.or(pull.map(|order| (order, false))) {
            self.places[contact].touch = Contact::Leaving(barrier, order);
            self.work.releases += 1;
            changes.push(Change::still(contact, barrier, EventKind::Release, 0.0));
        } else {
            self.places[contact].touch = before;
        }
    }

    /// Releases contacts at rest that their barriers would have to pull, the strongest pull first.
    pub(crate) fn let_go(&mut self, changes: &mut Vec<Change>) {
        for _ in 0..self.places.len() {
            if self.resting().is_empty() {
                return;
            }
            let series = Series::tendencies(&self.system, &self.flight, &self.places);
            let pulled = series.forces.iter().filter(|(contact, _, force)| force[0] < -series.force_doubt(&self.system, *contact));
            let Some(&(contact, barrier, _)) = pulled.min_by(|a, b| a.2[0].total_cmp(&b.2[0])) else { return };
            self.release(contact, barrier, 2, Some(2), changes);
        }
    }
}
