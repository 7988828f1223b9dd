//! Impacts of a structure.
//!
//! **Impact.** An impulse P = −(1+e) m g′⁻ at the contact, m = 1/(wᵀM⁻¹w): it changes the velocity of every contact that shares a coordinate.
//! The modes are not moved: where rounding has put the barrier is where it is until the contact is back, so no energy is made. A contact that
//! was followed by its own distance and velocity is an exception: there the modes take up what these say ([`Motion::take_up`]).
//!
//! **In sequence.** Contacts that share coordinates may meet their barriers at one instant. On request they hit one after another in the
//! order of their numbers, those at rest among them, again and again until none moves outward. A velocity below 1e-12 of the first is none, and
//! so is one that the force on a contact at rest takes off within [`CHATTER_TIME`](crate::CHATTER_TIME): contacts that chatter together would never end.
//! Without coordinates in common the order does not matter.

use crate::cascade::Change;
use crate::event::EventKind;
use crate::flight::Flight;
use crate::flight::places::Place;
use crate::motion::{Due, Motion, SIMULTANEOUS};
use crate::time::two_sum;
use crate::watch::Contact;
use vibrochain_lattice::Barrier;

/// In a sequence, velocity relative to the first one's that is none.
const STILL: f64 = 1e-12;

/// Impacts of one sequence.
const SEQUENCE: u32 = 100_000;

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

/// Velocity with which a contact meets a barrier that its series misses by `gap` = barrier − x, under the acceleration
/// `a`: never one that leaves it.
fn speed_at_barrier(barrier: Barrier, v: f64, gap: f64, a: f64) -> f64 {
    let work = a * gap;
    let corrected = if work.abs() < 1e-4 * v * v {
        v + work / v
    } else {
        // Near a graze the correction is not small: from the energy.
        let square = v * v + 2.0 * work;
        if square > 0.0 { barrier.sign() * square.sqrt() } else { 0.0 }
    };
    if corrected * barrier.sign() > 0.0 { corrected } else { 0.0 }
}

impl Motion {
    /// Two contacts of those due at the base whose impacts do not commute, or one with one that it pushes into its barrier.
    ///
    /// Of the forces on contacts at rest their values at the base alone are read, the coefficients of order 0. These follow from ξ, the loads and
    /// from who rests: contacts that have just left ([`Contact::Leaving`]) exert no force, and what they keep changes their own coefficients,
    /// of order 1 and higher, and no other. So nothing that is read here depends on it.
    ///
    /// Several that hit may push one together that none of them pushes alone, and in some order those that push it come first.
    pub(crate) fn conflict(&self) -> Option<(usize, usize)> {
        let parties = self.parties();
        let is_rest = |party: &Party| party.role == Role::Rests;
        let forces = parties.iter().any(is_rest).then(|| self.tendencies());
        let holds = |contact: usize| forces.as_ref().map_or(0.0, |forces| self.holds(forces, contact));
        let push = |from: &Party, to: &Party| {
            let loss = 1.0 + self.system.restitution(from.contact);
            let impulse = -from.sign() * loss * self.outward(from.contact, from.barrier).max(0.0);
            let shared = self.system.mobility(to.contact, from.contact);
            to.sign() * shared * impulse / self.system.mobility(from.contact, from.contact)
        };
        let outward = |party: &Party| self.outward(party.contact, party.barrier);
        let none = STILL * parties.iter().map(outward).fold(0.0, f64::max);
        let meeting = |other: &Party| {
            let pushed = (parties.iter())
                .filter(|party| party.role == Role::Hits && party.contact != other.contact)
                .filter(|party| self.system.mobility(other.contact, party.contact) != 0.0)
                .map(|party| (party.contact, push(party, other)));
            let first = pushed.clone().max_by(|a, b| a.1.total_cmp(&b.1))?.0;
            let most: f64 = pushed.map(|(_, push)| push.max(0.0)).sum();
            let is_met = match other.role {
                Role::Hits => true,
                Role::Touches => most + outward(other) > none,
                Role::Rests => most > holds(other.contact).max(none),
            };
            let pair = (first, other.contact);
            // Of two that hit the one of the lower number first.
            is_met.then_some(if other.role == Role::Hits { (pair.0.min(pair.1), pair.0.max(pair.1)) } else { pair })
        };
        parties.iter().find_map(meeting)
    }

    /// Contacts that are due to hit at the base, and those on their barriers that share a coordinate with one of them, by number.
    fn parties(&self) -> Vec<Party> {
        let hits: Vec<&Due> = self.due.iter().filter(|due| !due.release).collect();
        let party = |contact: usize| {
            if let Some(due) = hits.iter().find(|due| due.contact == contact) {
                return Some(Party { contact, barrier: due.barrier, role: Role::Hits });
            }
            let place = &self.places[contact];
            let mut met = hits.iter().filter(|due| self.system.mobility(contact, due.contact) != 0.0);
            if let Contact::Resting(barrier) = place.touch {
                return Some(Party { contact, barrier, role: Role::Rests });
            }
            let barrier = place.reference.filter(|_| place.v.is_some())?;
            // The order of two that are followed by their own distances is known as well as the clock; an impact that modes tell is late or
            // early by their rounding.
            let is_known = met.all(|due| self.places[due.contact].v.is_some());
            let on = if is_known {
                place.v.map_or(0.0, f64::abs) * SIMULTANEOUS / self.system.fastest
            } else {
                f64::EPSILON * self.flight.scale(&self.system, contact)
            };
            (place.x.abs() <= on).then_some(Party { contact, barrier, role: Role::Touches })
        };
        // Those that share no coordinate with another.
        if hits.iter().all(|due| self.system.sharing(due.contact).len() == 1) {
            return hits.iter().filter_map(|due| party(due.contact)).collect();
        }
        let near = hits.iter().flat_map(|due| self.system.sharing(due.contact)).map(|(contact, _)| *contact);
        near.collect::<std::collections::BTreeSet<usize>>().into_iter().filter_map(party).collect()
    }

    /// Applies what is due at the base.
    ///
    /// # Errors
    /// A contact whose sequence of impacts does not end.
    pub(crate) fn collide(&mut self, changes: &mut Vec<Change>) -> Result<(), Due> {
        if self.system.is_direct() {
            self.collide_directly(changes);
            return Ok(());
        }
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

    /// The same where each contact is a coordinate: the order does not matter, places do not jump and no jump depends on another velocity. The
    /// series ends a rounding error away from the barrier; the coordinate is put on it.
    fn collide_directly(&mut self, changes: &mut Vec<Change>) {
        let due = std::mem::take(&mut self.due);
        for due in due.iter().filter(|due| !due.release) {
            self.strike_directly(due, changes);
        }
        // Velocities are final now: derivatives of forces may be looked at.
        for &Due { contact, barrier, release, pull } in &due {
            if release {
                self.release(contact, barrier, 3, pull, changes);
            } else {
                self.part(contact, barrier, changes);
            }
        }
        self.due = due;
        self.let_go(changes);
    }

    fn strike_directly(&mut self, &Due { contact, barrier, .. }: &Due, changes: &mut Vec<Change>) {
        let Self { flight: Flight::Local(flight), system, places, .. } = self else { return };
        let Some(position) = system.barrier(contact, barrier) else { return };
        // The distance between the barriers is no floating-point number; its rounding would count at every crossing.
        let (distance, rest) = two_sum(position, -flight.reference[contact]);
        let gap = (distance - flight.x[contact]) + rest;
        let acceleration = flight.derivative(places, contact, contact, 2);
        let before = speed_at_barrier(barrier, flight.velocity(contact), gap, acceleration);
        let after = 0.0 - system.restitution(contact) * before;
        flight.put(contact, [position, 0.0], after);
        places.set(contact, Place { reference: Some(barrier), ..Place::free(0.0) });
        let impulse = system.impulse(contact, after - before);
        self.note_impact(contact, barrier, [before, after], impulse, changes);
    }

    fn note_impact(
        &mut self,
        contact: usize,
        barrier: Barrier,
        [before, after]: [f64; 2],
        impulse: f64,
        changes: &mut Vec<Change>,
    ) {
        if let Some(ledger) = &mut self.ledger {
            ledger.impact(-0.5 * impulse * (before + after));
        }
        self.work.impacts += 1;
        changes.push(Change { contact, barrier, before, after, impulse, kind: EventKind::Impact, delay: 0.0 });
    }

    /// g′ outward.
    pub(crate) fn outward(&self, contact: usize, barrier: Barrier) -> f64 {
        let v = self.places[contact].v.unwrap_or_else(|| self.flight.velocity(&self.system, contact));
        barrier.sign() * v
    }

    fn strike(&mut self, parties: &[Party], changes: &mut Vec<Change>) -> Result<(), Due> {
        if parties.is_empty() {
            return Ok(());
        }
        let followed: Vec<(usize, Barrier)> = (parties.iter())
            .filter(|party| party.role != Role::Rests && self.places[party.contact].v.is_some())
            .map(|party| (party.contact, party.barrier))
            .collect();
        self.take_up(&followed);
        for party in parties {
            let v =
                if party.role == Role::Rests { 0.0 } else { party.sign() * self.outward(party.contact, party.barrier) };
            let touch = self.places[party.contact].touch;
            self.places.set(party.contact, Place { reference: Some(party.barrier), x: 0.0, v: Some(v), touch });
        }
        let forces = parties.iter().any(|party| party.role == Role::Rests).then(|| self.tendencies());
        let outward = |motion: &Self, party: &Party| motion.outward(party.contact, party.barrier);
        let first = parties.iter().map(|party| outward(self, party)).fold(0.0, f64::max);
        let none = |motion: &Self, party: &Party| {
            let forces = forces.as_ref().filter(|_| party.role == Role::Rests);
            let held = forces.map_or(0.0, |forces| motion.holds(forces, party.contact));
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
                self.places.touch(party.contact, Contact::Leaving(party.barrier, 1));
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
        let restitution = self.system.restitution(contact);
        let before = barrier.sign() * outward;
        let after = 0.0 - restitution * before;
        let impulse = self.system.impulse(contact, after - before);
        self.push(contact, impulse);
        self.places.set_velocity(contact, after);
        self.note_impact(contact, barrier, [before, after], impulse, changes);
    }
}

#[cfg(test)]
mod tests;
