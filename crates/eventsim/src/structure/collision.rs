//! Impacts of a structure, chatter, rest and release.
//!
//! **Impact.** An impulse P = −(1+e) m g′⁻ at the contact, m = 1/(wᵀM⁻¹w): it changes the velocity of every contact that shares a coordinate.
//! The modes are not moved: where rounding has put the barrier is where it is until the contact is back, so no energy is made.
//!
//! **In sequence.** Contacts that share coordinates may meet their barriers at one instant. On request they hit one after another in the
//! order of their numbers, those at rest among them, again and again until none moves outward. A velocity below 1e-12 of the first is none, and
//! so is one that the force on a contact at rest takes off within [`CHATTER_TIME`]: contacts that chatter together would never end.
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
use crate::units::MAX_ORDER;
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

/// A contact at its barrier when contacts hit.
#[derive(Debug, Clone, Copy)]
struct Party {
    contact: usize,
    barrier: Barrier,
    role: Role,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Role {
    /// It is due.
    Hits,
    /// It is on its barrier, to rounding, without resting.
    Touches,
    /// It rests.
    Rests,
}

impl Party {
    fn sign(&self) -> f64 {
        self.barrier.sign()
    }
}

impl Change {
    pub(crate) fn still(contact: usize, barrier: Barrier, kind: EventKind, delay: f64) -> Self {
        Self { contact, barrier, before: 0.0, after: 0.0, impulse: 0.0, kind, delay }
    }
}

impl Motion {
    /// Two contacts of those due at the base whose impacts do not commute, or one with one that it pushes into its barrier.
    ///
    /// Of the forces on contacts at rest their values at the base alone are read, the coefficients of order 0. These follow from ξ, the loads and
    /// from who rests: contacts that have just left ([`Contact::Leaving`]) exert no force, and what they keep changes their own coefficients,
    /// of order 1 and higher, and no other. So nothing that is read here depends on it.
    pub(crate) fn conflict(&self) -> Option<(usize, usize)> {
        let parties = self.parties();
        let forces = Series::tendencies(&self.system, &self.flight, &self.places);
        for (i, party) in parties.iter().enumerate().filter(|(_, party)| party.role == Role::Hits) {
            let impulse = -party.sign() / self.system.mobility(party.contact, party.contact);
            let is_met = |(j, other): &(usize, &Party)| {
                let shared = self.system.mobility(other.contact, party.contact);
                let loss = 1.0 + self.system.structure.contacts()[party.contact].restitution;
                let kick = shared * impulse * loss * self.outward(party.contact, party.barrier);
                match other.role {
                    Role::Hits => *j > i && shared != 0.0,
                    Role::Touches => other.sign() * kick + self.outward(other.contact, other.barrier) > 0.0,
                    Role::Rests => other.sign() * kick > self.holds(&forces, other.contact),
                }
            };
            if let Some((_, other)) = parties.iter().enumerate().find(is_met) {
                return Some((party.contact, other.contact));
            }
        }
        None
    }

    /// Contacts that are due to hit at the base, and those on their barriers that share a coordinate with one of them, by number.
    fn parties(&self) -> Vec<Party> {
        let hits: Vec<&Due> = self.due.iter().filter(|due| !due.release).collect();
        let party = |contact: usize| {
            if let Some(due) = hits.iter().find(|due| due.contact == contact) {
                return Some(Party { contact, barrier: due.barrier, role: Role::Hits });
            }
            let place = &self.places[contact];
            if hits.iter().all(|due| self.system.mobility(contact, due.contact) == 0.0) {
                return None;
            }
            if let Contact::Resting(barrier) = place.touch {
                return Some(Party { contact, barrier, role: Role::Rests });
            }
            let barrier = place.reference.filter(|_| place.v.is_some())?;
            let on = f64::EPSILON * self.flight.size(&self.system, contact);
            (place.x.abs() <= on).then_some(Party { contact, barrier, role: Role::Touches })
        };
        (0..self.places.len()).filter_map(party).collect()
    }

    /// The velocity of a contact at rest that its force takes off again within [`CHATTER_TIME`]: it is none.
    fn holds(&self, series: &Series, contact: usize) -> f64 {
        let pressing = series.force(contact, 0.0).abs() * self.system.mobility(contact, contact);
        0.5 * pressing * CHATTER_TIME / self.system.fastest
    }

    /// Applies what is due at the base.
    ///
    /// # Errors
    /// A contact whose sequence of impacts does not end.
    pub(crate) fn collide(&mut self, changes: &mut Vec<Change>) -> Result<(), Due> {
        let parties = self.parties();
        let result = self.strike(&parties, changes);
        for party in parties.iter().filter(|party| party.role != Role::Rests) {
            self.part(party.contact, party.barrier, changes);
        }
        let due = std::mem::take(&mut self.due);
        for &Due { contact, barrier, pull, .. } in due.iter().filter(|due| due.release) {
            // Its impacts' company may have taken it off already.
            if let Contact::Resting(_) = self.places[contact].touch {
                self.release(contact, barrier, 3, pull, changes);
            }
        }
        self.due = due;
        self.let_go(changes);
        result
    }

    /// g′ outward.
    fn outward(&self, contact: usize, barrier: Barrier) -> f64 {
        let v = self.places[contact].v.unwrap_or_else(|| self.flight.velocity(&self.system, contact));
        barrier.sign() * v
    }

    fn strike(&mut self, parties: &[Party], changes: &mut Vec<Change>) -> Result<(), Due> {
        if parties.is_empty() {
            return Ok(());
        }
        for party in parties {
            let v =
                if party.role == Role::Rests { 0.0 } else { party.sign() * self.outward(party.contact, party.barrier) };
            let touch = self.places[party.contact].touch;
            self.places[party.contact] = Place { reference: Some(party.barrier), x: 0.0, v: Some(v), touch };
        }
        let forces = Series::tendencies(&self.system, &self.flight, &self.places);
        let outward = |motion: &Self, party: &Party| motion.outward(party.contact, party.barrier);
        let first = parties.iter().map(|party| outward(self, party)).fold(0.0, f64::max);
        let none = |motion: &Self, party: &Party| {
            let held = if party.role == Role::Rests { motion.holds(&forces, party.contact) } else { 0.0 };
            held.max(STILL * first)
        };
        let (mut round, mut impacts) = (0, 0);
        loop {
            let before = impacts;
            for party in parties {
                let speed = outward(self, party);
                // A graze is an event, too: once.
                if (round == 0 && party.role == Role::Hits) || speed > none(self, party) {
                    self.impact(party.contact, party.barrier, speed.max(0.0), changes);
                    impacts += 1;
                }
            }
            if impacts == before {
                break;
            }
            if impacts > SEQUENCE {
                let Party { contact, barrier, .. } = parties[0];
                return Err(Due { contact, barrier, release: false, pull: None });
            }
            round += 1;
        }
        for party in parties.iter().filter(|party| party.role == Role::Rests) {
            let speed = outward(self, party);
            if -speed > none(self, party) {
                self.places[party.contact].touch = Contact::Leaving(party.barrier, 1);
                self.work.releases += 1;
                let after = party.sign() * speed;
                let still = Change::still(party.contact, party.barrier, EventKind::Release, 0.0);
                changes.push(Change { after, ..still });
            }
        }
        // What is left of a velocity outward is none.
        let mut still = Vec::new();
        loop {
            self.hold(&still);
            let next = parties.iter().find(|party| {
                party.role != Role::Rests && !still.contains(&party.contact) && outward(self, party) >= 0.0
            });
            let Some(party) = next else { break };
            still.push(party.contact);
        }
        Ok(())
    }

    fn impact(&mut self, contact: usize, barrier: Barrier, outward: f64, changes: &mut Vec<Change>) {
        let restitution = self.system.structure.contacts()[contact].restitution;
        let before = barrier.sign() * outward;
        let after = 0.0 - restitution * before;
        let impulse = self.system.impulse(contact, after - before);
        self.push(contact, impulse);
        self.places[contact].v = Some(after);
        if let Some(ledger) = &mut self.ledger {
            ledger.impact(-0.5 * impulse * (before + after));
        }
        self.work.impacts += 1;
        changes.push(Change { contact, barrier, before, after, impulse, kind: EventKind::Impact, delay: 0.0 });
    }

    /// What a contact on its barrier does after the impacts there.
    fn part(&mut self, contact: usize, barrier: Barrier, changes: &mut Vec<Change>) {
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
                if left * (self.system.fastest + jerk / pressing) < CHATTER_TIME {
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
        self.hold(&[]);
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

    /// Lets the forces of all contacts on their barriers agree: releases those at rest that their barriers would have to pull, the strongest
    /// pull first, and puts at rest those that were about to leave and are pressed now that others rest.
    pub(crate) fn let_go(&mut self, changes: &mut Vec<Change>) {
        for _ in 0..4 * self.places.len() {
            let is_soft = |place: &Place| matches!(place.touch, Contact::Resting(_) | Contact::Leaving(_, 2..));
            if !self.places.iter().any(is_soft) {
                return;
            }
            let series = Series::tendencies(&self.system, &self.flight, &self.places);
            let is_pulled = |(contact, _, force): &&(usize, Barrier, [f64; MAX_ORDER + 1])| {
                force[0] < -series.force_doubt(&self.system, *contact)
            };
            let pulled = series.forces.iter().filter(is_pulled).min_by(|a, b| a.2[0].total_cmp(&b.2[0]));
            if let Some(&(contact, barrier, _)) = pulled {
                self.release(contact, barrier, 2, Some(2), changes);
                continue;
            }
            let pressed = self.places.iter().enumerate().find_map(|(contact, place)| match place.touch {
                Contact::Leaving(barrier, 2..) => {
                    let tendency = series.tendency(contact, barrier, 2)?;
                    tendency.1.then_some((contact, barrier))
                }
                _ => None,
            });
            let Some((contact, barrier)) = pressed else { return };
            self.rest(contact, barrier, 0.0, changes);
        }
    }
}
