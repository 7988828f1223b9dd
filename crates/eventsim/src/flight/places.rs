//! Where contacts are at the origins of their series, and which of them are at a barrier.

use std::ops::Index;

use crate::flight::system::System;
use crate::watch::Contact;
use vibrochain_lattice::Barrier;

/// Beyond this part of the scale of its motion a contact forgets the barrier that x is measured from: g is known as well.
pub(crate) const FORGET: f64 = 1.0 / 16.0;

/// Where a contact is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// The barrier that x is measured from; none: g itself.
    pub(crate) reference: Option<Barrier>,
    /// Beside a barrier the distance to it, with digits that g has not.
    pub(crate) x: f64,
    /// g′, where it is known better than modes tell.
    pub(crate) v: Option<f64>,
    pub(crate) touch: Contact,
}

impl Place {
    /// Away from barriers.
    pub(crate) fn free(x: f64) -> Self {
        Self { reference: None, x, v: None, touch: Contact::Free }
    }

    /// A barrier as x is measured; none: there is none.
    pub(crate) fn barrier(&self, system: &System, contact: usize, barrier: Barrier) -> Option<f64> {
        let place = system.barrier(contact, barrier)?;
        let reference = self.reference.and_then(|barrier| system.barrier(contact, barrier));
        Some(place - reference.unwrap_or(0.0))
    }

    /// Both.
    pub(crate) fn barriers(&self, system: &System, contact: usize) -> [Option<f64>; 2] {
        [Barrier::Lower, Barrier::Upper].map(|barrier| self.barrier(system, contact, barrier))
    }

    /// The order of the first derivative with which it leaves a barrier, if above 1.
    fn soft(&self) -> Option<u8> {
        match self.touch {
            Contact::Leaving(_, order) if order > 1 => Some(order),
            _ => None,
        }
    }

    fn is_resting(&self) -> bool {
        matches!(self.touch, Contact::Resting(_))
    }
}

/// Places of all contacts.
#[derive(Debug, Clone, Default)]
pub(crate) struct Places {
    all: Vec<Place>,
    /// Those that are measured from a barrier, or were until the base has moved last, in no order; and whether one is in that list.
    near: Vec<usize>,
    is_listed: Vec<bool>,
    /// Those at rest, rising.
    resting: Vec<usize>,
}

impl Index<usize> for Places {
    type Output = Place;

    fn index(&self, contact: usize) -> &Place {
        &self.all[contact]
    }
}

impl Places {
    /// Of contacts none of which is at a barrier.
    pub(crate) fn new(all: Vec<Place>) -> Self {
        Self { is_listed: vec![false; all.len()], all, near: Vec::new(), resting: Vec::new() }
    }

    /// Of any.
    pub(crate) fn of(all: impl Iterator<Item = Place>) -> Self {
        let all: Vec<Place> = all.collect();
        let mut places = Self::new(all.iter().map(|_| Place::free(0.0)).collect());
        all.into_iter().enumerate().for_each(|(contact, place)| places.set(contact, place));
        places
    }

    pub(crate) fn len(&self) -> usize {
        self.all.len()
    }

    pub(crate) fn get(&self, contact: usize) -> Option<&Place> {
        self.all.get(contact)
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Place> {
        self.all.iter()
    }

    /// Contacts that are measured from a barrier, in no order.
    pub(crate) fn near(&self) -> impl Iterator<Item = usize> {
        self.near.iter().copied().filter(|&contact| self.all[contact].reference.is_some())
    }

    /// Contacts at rest, rising.
    pub(crate) fn resting(&self) -> &[usize] {
        &self.resting
    }

    pub(crate) fn is_resting(&self, contact: usize) -> bool {
        self.all[contact].is_resting()
    }

    /// Contacts that leave a barrier with a derivative of an order above 1, with that order.
    pub(crate) fn soft(&self) -> impl Iterator<Item = (usize, u8)> {
        self.near().filter_map(|contact| Some((contact, self.all[contact].soft()?)))
    }

    pub(crate) fn set(&mut self, contact: usize, place: Place) {
        let before = std::mem::replace(&mut self.all[contact], place);
        if before.is_resting() != place.is_resting() {
            match self.resting.binary_search(&contact) {
                Ok(i) => {
                    self.resting.remove(i);
                }
                Err(i) => self.resting.insert(i, contact),
            }
        }
        if place.reference.is_some() && !std::mem::replace(&mut self.is_listed[contact], true) {
            self.near.push(contact);
        }
    }

    pub(crate) fn touch(&mut self, contact: usize, touch: Contact) {
        self.set(contact, Place { touch, ..self.all[contact] });
    }

    pub(crate) fn set_velocity(&mut self, contact: usize, v: f64) {
        self.all[contact].v = Some(v);
    }

    /// Moves those that are measured from a barrier.
    pub(crate) fn move_near(&mut self, mut moved: impl FnMut(usize, &Place) -> Place) {
        let Self { all, near, is_listed, .. } = self;
        near.retain(|&contact| {
            let place = &mut all[contact];
            if place.reference.is_some() && !place.is_resting() {
                *place = moved(contact, place);
            }
            is_listed[contact] = place.reference.is_some();
            is_listed[contact]
        });
    }

    /// Moves the others.
    pub(crate) fn move_free(&mut self, at: impl Fn(usize) -> f64) {
        let free = self.all.iter_mut().enumerate().filter(|(_, place)| place.reference.is_none());
        free.for_each(|(contact, place)| place.x = at(contact));
    }

    /// None is at a barrier any more.
    pub(crate) fn free_all(&mut self, at: impl Fn(usize) -> f64) {
        self.near.drain(..).for_each(|contact| self.is_listed[contact] = false);
        self.resting.clear();
        self.all.iter_mut().enumerate().for_each(|(contact, place)| *place = Place::free(at(contact)));
    }
}
