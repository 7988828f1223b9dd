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

use super::approach::Place;
use super::motion::{Due, Motion, SIMULTANEOUS};
use crate::cascade::Change;
use crate::event::EventKind;
use crate::ring::Contact;
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
            let loss = 1.0 + self.system.structure.contacts()[from.contact].restitution;
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
        let near = hits.iter().flat_map(|due| self.system.sharing(due.contact)).map(|(contact, _)| *contact);
        near.collect::<std::collections::BTreeSet<usize>>().into_iter().filter_map(party).collect()
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
    pub(super) fn outward(&self, contact: usize, barrier: Barrier) -> f64 {
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
            self.places[party.contact] = Place { reference: Some(party.barrier), x: 0.0, v: Some(v), touch };
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
        let (site, force, kind) = (contact, impulse, EventKind::Impact);
        changes.push(Change { site, barrier, before, after, force, kind, delay: 0.0 });
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use vibrochain_lattice::{Contact as Stops, LinearMode, ModalStructure, ModeShape};
    use vibrochain_testkit::Random;

    use super::super::system::System;
    use super::*;

    /// What contacts are made to do at one instant.
    #[derive(Debug, Clone, Copy, PartialEq)]
    enum Made {
        Hits,
        Grazes,
        Touches,
        Rests,
        Away,
    }

    /// Contacts with velocities and mobilities as plain numbers.
    struct Plain {
        made: Vec<Made>,
        sign: Vec<f64>,
        restitution: Vec<f64>,
        velocity: Vec<f64>,
        mobility: Vec<Vec<f64>>,
        /// A decision was too close to tell.
        close: bool,
    }

    impl Plain {
        /// Impacts of each contact and velocities at the end, where of those that may hit the first in `order` does; none: it does not end.
        fn settled(&mut self, order: &[usize]) -> Option<(Vec<usize>, Vec<f64>)> {
            let (mut v, mut impacts) = (self.velocity.clone(), vec![0; order.len()]);
            for _ in 0..2000 {
                let is_due = |c: usize| matches!(self.made[c], Made::Hits | Made::Grazes) && impacts[c] == 0;
                let outward = |c: usize| self.sign[c] * v[c];
                let is_at = |c: usize| self.made[c] != Made::Away;
                self.close |= order.iter().any(|&c| is_at(c) && outward(c) != 0.0 && outward(c).abs() < 1e-6);
                let Some(&c) = order.iter().find(|&&c| is_at(c) && (is_due(c) || outward(c) > 1e-9)) else {
                    return Some((impacts, v));
                };
                let change = -(1.0 + self.restitution[c]) * self.sign[c] * outward(c).max(0.0);
                let impulse = change / self.mobility[c][c];
                v.iter_mut().enumerate().for_each(|(other, v)| *v += self.mobility[other][c] * impulse);
                // What rounding leaves of none is none.
                v[c] = if self.restitution[c] == 0.0 { 0.0 } else { v[c] };
                impacts[c] += 1;
            }
            None
        }
    }

    fn orders(of: &[usize]) -> Vec<Vec<usize>> {
        if of.is_empty() {
            return vec![vec![]];
        }
        let first = |&c: &usize| {
            let rest: Vec<usize> = of.iter().copied().filter(|other| *other != c).collect();
            orders(&rest).into_iter().map(move |rest| [&[c], &rest[..]].concat())
        };
        of.iter().flat_map(first).collect()
    }

    /// Contacts of random weights, some with coordinates in common, at their barriers at one instant.
    fn made(random: &mut Random) -> (Motion, Vec<Made>) {
        let (modes, count) = (2 + random.below(5), 2 + random.below(3));
        let part = random.between(0.0, 0.8);
        let shapes: Vec<Vec<f64>> = (0..count)
            .map(|_| {
                let mut shape: Vec<f64> =
                    (0..modes).map(|_| if random.chance(part) { random.between(-1.0, 1.0) } else { 0.0 }).collect();
                shape[random.below(modes)] = random.between(0.2, 1.0);
                shape
            })
            .collect();
        let rates: Vec<f64> = (0..modes).map(|_| random.between(0.5, 3.0)).collect();
        let restitution: Vec<f64> =
            (0..count).map(|_| [random.between(0.1, 1.0), 1.0, 0.0][random.below(10) / 4]).collect();
        let made: Vec<Made> = (0..count)
            .map(|_| {
                [
                    Made::Hits,
                    Made::Hits,
                    Made::Hits,
                    Made::Grazes,
                    Made::Touches,
                    Made::Touches,
                    Made::Rests,
                    Made::Away,
                ]
            })
            .map(|all| all[random.below(8)])
            .collect();
        let xi: Vec<[f64; 2]> = (0..modes).map(|_| [random.between(-1.0, 1.0), random.between(-1.0, 1.0)]).collect();
        let build = |stops: Vec<Stops>| {
            let mode = |k: usize| {
                let contacts = shapes.iter().map(|shape| shape[k]).collect();
                let shape = ModeShape { contacts, coordinates: Vec::new(), still: 0.0 };
                LinearMode::oscillator(0.01, rates[k] * rates[k], &shape, &[])
            };
            let structure = ModalStructure::new(stops, Vec::new(), (0..modes).map(mode).collect()).unwrap();
            Motion::new(System::new(structure, 1.0, 0.0), &xi)
        };
        let stand = |motion: &mut Motion, sides: &[Barrier]| {
            for c in 0..count {
                let place = &mut motion.places[c];
                if made[c] != Made::Away {
                    (place.reference, place.x) = (Some(sides[c]), 0.0);
                }
                if made[c] == Made::Rests {
                    place.touch = Contact::Resting(sides[c]);
                }
            }
            let grazing: Vec<usize> = (0..count).filter(|c| made[*c] == Made::Grazes).collect();
            motion.hold(&grazing);
            for c in (0..count).filter(|c| matches!(made[*c], Made::Hits | Made::Touches)) {
                motion.places[c].v = Some(motion.flight.velocity(&motion.system, c));
            }
        };
        let free = |c: usize| Stops { lower: None, upper: Some(1e3), restitution: restitution[c] };
        let mut motion = build((0..count).map(free).collect());
        stand(&mut motion, &vec![Barrier::Upper; count]);
        // On the side to which it moves, or from which.
        let sides: Vec<Barrier> = (0..count)
            .map(|c| {
                let outward = motion.flight.velocity(&motion.system, c) > 0.0;
                let is_upper = match made[c] {
                    Made::Hits => outward,
                    Made::Touches => !outward,
                    _ => random.chance(0.5),
                };
                if is_upper { Barrier::Upper } else { Barrier::Lower }
            })
            .collect();
        let at = |c: usize| {
            let place = motion.flight.place(&motion.system, c);
            let (lower, upper) = match (made[c], sides[c]) {
                (Made::Away, _) => (None, Some(place + 1.0)),
                (_, Barrier::Upper) => (None, Some(place)),
                (_, Barrier::Lower) => (Some(place), None),
            };
            Stops { lower, upper, restitution: restitution[c] }
        };
        let mut motion = build((0..count).map(at).collect());
        stand(&mut motion, &sides);
        motion.due = (0..count)
            .filter(|c| matches!(made[*c], Made::Hits | Made::Grazes))
            .map(|contact| Due { contact, barrier: sides[contact], release: false, pull: None })
            .collect();
        (motion, made)
    }

    /// Where no conflict is told, contacts hit once each in whatever order, to the same end; where one is, some order makes another one hit.
    #[test]
    fn impacts_at_one_instant_without_a_conflict_commute() {
        let mut random = Random(61);
        let (mut free, mut met, mut together) = (0, 0, 0);
        for round in 0..20_000 {
            let (mut motion, made) = made(&mut random);
            let count = made.len();
            if motion.due.is_empty() {
                continue;
            }
            let side = |c: usize| motion.places[c].reference.map_or(1.0, Barrier::sign);
            let velocity = |motion: &Motion, c: usize| {
                motion.places[c].v.unwrap_or_else(|| motion.flight.velocity(&motion.system, c))
            };
            let mut plain = Plain {
                sign: (0..count).map(side).collect(),
                restitution: motion.system.structure.contacts().iter().map(|stops| stops.restitution).collect(),
                velocity: (0..count).map(|c| velocity(&motion, c)).collect(),
                mobility: (0..count).map(|i| (0..count).map(|j| motion.system.mobility(i, j)).collect()).collect(),
                close: false,
                made: made.clone(),
            };
            let ends: Vec<_> =
                orders(&(0..count).collect::<Vec<_>>()).iter().map(|order| plain.settled(order)).collect();
            if plain.close {
                continue;
            }
            let is_hit = |c: usize| matches!(made[c], Made::Hits | Made::Grazes);
            let once: Vec<usize> = (0..count).map(|c| usize::from(is_hit(c))).collect();
            let is_free = ends.iter().all(|end| {
                end.as_ref().zip(ends[0].as_ref()).is_some_and(|((impacts, end), (_, other))| {
                    *impacts == once && end.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-9)
                })
            });
            let Some((first, second)) = motion.conflict() else {
                assert!(is_free, "{round}: {made:?} {ends:?}");
                let mut changes = Vec::new();
                motion.collide(&mut changes).unwrap();
                let impacts = |c: usize| {
                    changes.iter().filter(|change| change.site == c && change.kind == EventKind::Impact).count()
                };
                assert!((0..count).all(|c| impacts(c) == once[c]), "{round}: {made:?} {changes:?}");
                let (_, end) = ends[0].as_ref().unwrap();
                for c in 0..count {
                    let v = motion.flight.velocity(&motion.system, c);
                    // Resting contacts may feel what the others do to them only where they leave.
                    let is_held = matches!(motion.places[c].touch, Contact::Resting(_));
                    assert!(is_held || (v - end[c]).abs() < 1e-9, "{round} {c}: {v} {end:?} {made:?}");
                }
                free += 1;
                continue;
            };
            assert!(is_hit(first) && first != second, "{round}: {made:?} {first} {second}");
            let shares = |i: usize, j: usize| i != j && is_hit(i) && is_hit(j) && plain.mobility[i][j] != 0.0;
            if (0..count).any(|i| (0..count).any(|j| shares(i, j))) {
                continue;
            }
            let hits = |c: usize| ends.iter().any(|end| end.as_ref().is_none_or(|(impacts, _)| impacts[c] > once[c]));
            assert!(hits(second), "{round}: {made:?} {first} {second} {ends:?}");
            met += 1;
            let push = |c: usize| {
                let impulse = -(1.0 + plain.restitution[c]) * plain.velocity[c] / plain.mobility[c][c];
                plain.sign[second] * plain.mobility[second][c] * impulse
            };
            let alone = (0..count).filter(|c| is_hit(*c)).map(push).fold(0.0, f64::max);
            together += usize::from(alone + plain.sign[second] * plain.velocity[second] <= 0.0);
        }
        println!("{free} without a conflict, {met} that push another one, {together} of them only together");
        assert!(free > 2000 && met > 1000 && together > 3, "{free} {met} {together}");
    }
}
