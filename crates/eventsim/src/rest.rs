//! Chatter, rest and release of a structure's contacts: those of the chain ([`crate::collision`]), with accelerations that know dashpots and the
//! forces of other contacts at rest. A contact that comes to rest may take another one's load off: whose force would pull is released at once.

use crate::cascade::Change;
use crate::event::EventKind;
use crate::flight::Flight;
use crate::flight::near::Tendencies;
use crate::flight::places::Place;
use crate::motion::Motion;
use crate::watch::Contact;
use vibrochain_lattice::Barrier;

/// An accumulation of impacts is completed at its limit when so much time is left of it, in units of the fastest rate: of a chain
/// 1/√(γ₁+4γ₂+4γ₃), or 1/ω where the force is faster.
pub const CHATTER_TIME: f64 = 1e-8;

impl Motion {
    /// What a contact on its barrier does after the impacts there.
    pub(crate) fn part(&mut self, contact: usize, barrier: Barrier, changes: &mut Vec<Change>) {
        let outward = self.outward(contact, barrier);
        if outward == 0.0 {
            self.rest_or_leave(contact, barrier, changes);
            return;
        }
        self.places.touch(contact, Contact::Leaving(barrier, 1));
        if let Some(left) = self.chatters(contact, barrier, outward.abs()) {
            self.rest(contact, barrier, left, changes);
        }
    }

    /// How soon a contact that leaves its barrier at a speed comes to rest there, if it is pressed back so soon.
    fn chatters(&self, contact: usize, barrier: Barrier, speed: f64) -> Option<f64> {
        let loss = 1.0 - self.system.restitution(contact);
        if loss <= 0.0 {
            return None;
        }
        let [acceleration, jerk] = self.bends(contact);
        let (pressing, jerk) = (barrier.sign() * acceleration, jerk.abs());
        let left = 2.0 * speed / (pressing * loss);
        (pressing > 0.0 && left * (self.system.fastest + jerk / pressing) < CHATTER_TIME).then_some(left)
    }

    /// g″ and g‴ of a contact that moves.
    pub(crate) fn bends(&self, contact: usize) -> [f64; 2] {
        match &self.flight {
            Flight::Local(flight) if self.system.is_direct() || self.places.resting().is_empty() => {
                flight.bends(&self.places, contact)
            }
            _ => self.tendencies().bends(contact),
        }
    }

    /// The order of the first derivative that takes a contact off its barrier, or presses it against it, and whether it presses.
    fn tendency(&self, contact: usize, barrier: Barrier, from: usize) -> Option<(u8, bool)> {
        match &self.flight {
            Flight::Local(flight) if self.system.is_direct() => flight.tendency(&self.places, contact, barrier, from),
            _ => self.tendencies().tendency((contact, &self.places[contact]), barrier, from),
        }
    }

    /// A contact on its barrier without velocity: it rests, or leaves.
    pub(crate) fn rest_or_leave(&mut self, contact: usize, barrier: Barrier, changes: &mut Vec<Change>) {
        self.places.set(contact, Place { v: Some(0.0), touch: Contact::Free, ..self.places[contact] });
        match self.tendency(contact, barrier, 2) {
            Some((order, false)) => self.places.touch(contact, Contact::Leaving(barrier, order)),
            _ => self.rest(contact, barrier, 0.0, changes),
        }
    }

    /// The velocity of a contact at rest that its force takes off again within [`CHATTER_TIME`]: it is none.
    pub(crate) fn holds(&self, tendencies: &Tendencies, contact: usize) -> f64 {
        let pressing = tendencies.force(contact).abs() * self.system.mobility(contact, contact);
        0.5 * pressing * CHATTER_TIME / self.system.fastest
    }

    fn rest(&mut self, contact: usize, barrier: Barrier, delay: f64, changes: &mut Vec<Change>) {
        if let Some(ledger) = &mut self.ledger {
            let v = self.places[contact].v.unwrap_or(0.0);
            ledger.impact(0.5 * v * v / self.system.mobility(contact, contact));
        }
        let touch = Contact::Resting(barrier);
        self.places.set(contact, Place { reference: Some(barrier), x: 0.0, v: Some(0.0), touch });
        self.work.sticks += 1;
        changes.push(Change::still(contact, barrier, EventKind::Stick, delay));
        match (&mut self.flight, self.system.barrier(contact, barrier)) {
            (Flight::Local(flight), Some(place)) if self.system.is_direct() => flight.put(contact, [place, 0.0], 0.0),
            _ => self.hold(&[]),
        }
    }

    /// Lets a contact leave its barrier with the first derivative, from `order` on, that does not vanish; if that points outward it stays.
    pub(crate) fn release(
        &mut self,
        contact: usize,
        barrier: Barrier,
        order: usize,
        pull: Option<u8>,
        changes: &mut Vec<Change>,
    ) {
        let before = self.places[contact];
        self.places.set(contact, Place { v: Some(0.0), touch: Contact::Free, ..before });
        let tendency = self.tendency(contact, barrier, order);
        if let Some((order, false)) = tendency.or(pull.map(|order| (order, false))) {
            self.places.touch(contact, Contact::Leaving(barrier, order));
            self.work.releases += 1;
            changes.push(Change::still(contact, barrier, EventKind::Release, 0.0));
        } else {
            self.places.set(contact, before);
        }
    }

    /// Lets the forces of all contacts on their barriers agree: releases those at rest that their barriers would have to pull, the strongest
    /// pull first, and puts at rest those that were about to leave and are pressed now that others rest.
    pub(crate) fn let_go(&mut self, changes: &mut Vec<Change>) {
        if self.system.is_direct() {
            return self.let_go_directly(changes);
        }
        for _ in 0..4 * self.places.len() {
            if self.places.resting().is_empty() && self.places.soft().next().is_none() {
                return;
            }
            let tendencies = self.tendencies();
            let pushes = tendencies.pushes(&self.system).into_iter();
            let pulled = pushes.filter(|(.., push, doubt)| *push < -doubt).min_by(|a, b| a.2.total_cmp(&b.2));
            if let Some((contact, barrier, ..)) = pulled {
                self.release(contact, barrier, 2, Some(2), changes);
                continue;
            }
            let pressed = self.places.iter().enumerate().find_map(|(contact, place)| match place.touch {
                Contact::Leaving(barrier, 2..) => {
                    let tendency = tendencies.tendency((contact, place), barrier, 2)?;
                    tendency.1.then_some((contact, barrier))
                }
                _ => None,
            });
            let Some((contact, barrier)) = pressed else { return };
            self.rest(contact, barrier, 0.0, changes);
        }
    }

    /// The same where each contact is a coordinate: the force on one at rest changes at an instant with velocities alone, by dashpots between
    /// neighbours.
    fn let_go_directly(&mut self, changes: &mut Vec<Change>) {
        let Flight::Local(flight) = &self.flight else { return };
        if !flight.local.operator.couples_velocities() || changes.is_empty() {
            return;
        }
        let mut touched: Vec<usize> =
            changes.iter().flat_map(|change| flight.local.operator.beside(change.contact)).collect();
        touched.sort_unstable();
        touched.dedup();
        for contact in touched {
            match self.places[contact].touch {
                Contact::Resting(barrier) => {
                    if let Some((2, false)) = self.tendency(contact, barrier, 2) {
                        self.release(contact, barrier, 2, Some(2), changes);
                    }
                }
                Contact::Leaving(barrier, 2..) => {
                    if let Some((_, true)) = self.tendency(contact, barrier, 2) {
                        self.rest(contact, barrier, 0.0, changes);
                    }
                }
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::{Complex, Contact as Stops, LinearMode, ModalStructure, ModeShape};

    use crate::{CHATTER_TIME, EventKind, Limits, Simulation};

    /// A free mass chatters on a table while its load changes from pressing to lifting: how soon, not how fast the motion is, decides how many
    /// of its bounces are told one by one. It rests at the first whose rest lasts no longer than [`CHATTER_TIME`] against that, and is let go
    /// where the load vanishes.
    #[test]
    fn a_contact_rests_only_if_its_load_does_not_change_before() {
        let pressing = 1e-2;
        for (restitution, lift) in [(0.5, 100.0), (0.5, 10.0), (0.8, 100.0), (0.3, 1.0)] {
            for left in [5e-9, 1.3e-8] {
                let table = Stops { lower: Some(0.0), upper: None, restitution };
                let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: -pressing };
                // g″ = −pressing + lift·sin t
                let mode = LinearMode::oscillator(0.0, 0.0, &shape, &[Complex::new(0.0, -lift)]);
                let structure = ModalStructure::new(vec![table], vec![1], vec![mode.clone()]).unwrap();
                let speed = 0.5 * left * pressing * (1.0 - restitution);
                let start = [0.0, -speed / restitution / mode.rate];
                let mut simulation = Simulation::of_modes(structure, 1.0, 0.0, &[start]).unwrap();
                let limits = Limits { until: Some(simulation.time_of(0, 2.0 * pressing / lift)), ..Limits::default() };
                let (_, events) = simulation.collect(&limits);
                let bounces = events.iter().filter(|event| event.kind == EventKind::Impact).count();
                let too_soon = |n: i32| left * restitution.powi(n) * (1.0 + lift / pressing) >= CHATTER_TIME;
                let expected = 1 + (0..).take_while(|n| too_soon(*n)).count();
                assert_eq!(bounces, expected, "{restitution} {lift} {left}: {events:?}");
                assert_eq!(events[bounces].kind, EventKind::Stick);
                let released = &events[bounces + 1];
                let off = (released.time.to_f64() - (pressing / lift).asin()).abs();
                assert!(released.kind == EventKind::Release && off < 1e-12, "{released:?} {off:e}");
            }
        }
    }
}
