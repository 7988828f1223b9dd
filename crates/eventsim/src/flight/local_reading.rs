//! What local series tell at any time of their window: coordinates, contacts, their derivatives and forces.

use super::local::Local;
use super::local_flight::LocalFlight;
use super::places::{Place, Places};
use super::rest_series::LOW;
use super::system::System;
use crate::series::weights::Weights;
use crate::units::MAX_ORDER;
use crate::watch::{Contact, Watch};
use vibrochain_lattice::Barrier;

impl LocalFlight {
    /// q and q′ at `s` after the base, in the structure's unit of time. q counts from where the static load holds the structure.
    pub(crate) fn at(&self, s: f64) -> [Vec<f64>; 2] {
        let (mut place, mut velocity) = (self.x.clone(), self.velocity.clone());
        self.read(s, [&mut place, &mut velocity]);
        [place, velocity]
    }

    /// The same of the first coordinates; those that are stopped themselves are on their barriers at most.
    pub(crate) fn read(&self, s: f64, [place, velocity]: [&mut [f64]; 2]) {
        self.fly(s, &self.weights_at(s), [&mut *place, &mut *velocity]);
        velocity.iter_mut().for_each(|v| *v *= self.local.scale);
        place.iter_mut().zip(&self.reference).for_each(|(place, reference)| *place += reference);
        if self.is_direct {
            let limits = self.limits[0].iter().zip(&self.limits[1]);
            place.iter_mut().zip(limits).for_each(|(place, (low, high))| *place = place.clamp(*low, *high));
        }
    }

    /// x and q′ of the first coordinates in internal time, with the weights of that time.
    pub(crate) fn fly(&self, s: f64, weights: &Weights, [x, velocity]: [&mut [f64]; 2]) {
        let own = &self.x[..x.len()];
        if s == 0.0 {
            x.copy_from_slice(own);
            velocity.copy_from_slice(&self.velocity[..velocity.len()]);
            return;
        }
        let rows = &self.series.rows;
        let s = s * self.local.scale;
        let inside = x.len();
        if self.moved.is_empty() {
            rows.at_all(own, weights, x, velocity);
        } else {
            rows.all_at((s, &self.origin), own, (weights, &self.local.inverse), [&mut *x, &mut *velocity]);
        }
        // For a coordinate that has restarted since, what was lost has served its turn.
        for (n, lost) in self.lost.iter().filter(|(n, _)| *n < inside && self.origin[*n] == 0.0) {
            (x[*n], velocity[*n]) = rows.at(*n, own[*n], weights, Some(lost));
        }
        // Those that have been carried there, and have no series from there yet.
        for &n in self.moved.iter().filter(|n| **n < inside && self.origin[**n] >= s) {
            (x[n], velocity[n]) = (own[n], self.velocity[n]);
        }
    }

    /// x and v of a contact at `s`, with the weights of that time.
    pub(crate) fn near_at(&self, contact: usize, place: &Place, s: f64, weights: &Weights) -> (f64, f64) {
        let origin = self.origin(contact);
        let mut own_weights = Weights::zero();
        let weights = if origin == 0.0 {
            weights
        } else {
            let lapse = (s * self.local.scale - origin).max(0.0);
            own_weights.plain(lapse, self.series.rows.order, &self.local.inverse_factorial);
            &own_weights
        };
        let first = match place.touch {
            Contact::Resting(_) => return (place.x, 0.0),
            Contact::Leaving(_, m) => usize::from(m),
            Contact::Free => 1,
        };
        if self.is_direct {
            let lost = self.lost.iter().find(|(n, _)| origin == 0.0 && *n == contact).map(|(_, lost)| lost);
            let (x, v) = self.series.rows.at(contact, self.x[contact], weights, lost);
            return (x, v * self.local.scale);
        }
        let (mut x, mut v) = (0.0, 0.0);
        for k in (first.max(2)..=self.series.rows.order).rev() {
            let d = self.series.derivative(&self.local, contact, k);
            x += weights.high[k] * d;
            v += weights.high[k - 1] * d;
        }
        let own = self.own(contact, place, 1);
        (self.own(contact, place, 0) + (weights.high[1] * own + x), (own + v) * self.local.scale)
    }

    /// x and v of a contact at `s`.
    pub(crate) fn contact_at(&self, contact: usize, place: &Place, s: f64) -> (f64, f64) {
        self.near_at(contact, place, s, &self.weights_at(s))
    }

    /// The force on a contact at rest at `s`, positive towards larger g.
    pub(crate) fn force_at(&self, system: &System, contact: usize, s: f64) -> f64 {
        if self.is_direct {
            let operator = &self.local.operator;
            let at = |m: usize| {
                let (x, v) = self.contact_at(m, &Place::free(0.0), s);
                (self.reference[m] + x, v)
            };
            let turned = system.loads.later(&self.turned, s);
            let pulled = operator.pull(contact, false, |m| at(m).0) + operator.pull(contact, true, |m| at(m).1);
            return (pulled - self.local.load(&turned, contact, 0)) / system.mobility(contact, contact);
        }
        let Some(i) = self.series.held_as(contact) else { return 0.0 };
        let weights = self.weights_at(s);
        let terms = (0..self.series.rows.order - 1).map(|k| weights.high[k] * self.series.forces[i][k]);
        terms.sum::<f64>() * self.local.scale * self.local.scale
    }

    /// The k-th derivative of coordinate `n`, in the structure's time: as if it were free, while those at rest stay.
    /// Each at the origin of its series, which must be one instant for those that can be felt so soon.
    pub(crate) fn derivative(&self, places: &Places, free: usize, n: usize, k: usize) -> f64 {
        if k > 0 && n != free && self.is_direct && places.is_resting(n) {
            return 0.0;
        }
        let operator = &self.local.operator;
        let pull =
            |is_damping: bool, from: usize| operator.pull(n, is_damping, |m| self.derivative(places, free, m, from));
        match k {
            0 => self.position(n),
            1 => self.velocity[n] * self.local.scale,
            _ => {
                let damped = if operator.is_damped() { pull(true, k - 1) } else { 0.0 };
                self.local.load(&self.now, n, k as u32 - 2) - pull(false, k - 2) - damped
            }
        }
    }

    /// Its rounding.
    fn doubt(&self, places: &Places, free: usize, n: usize, k: usize) -> f64 {
        if k > 0 && n != free && places.is_resting(n) {
            return 0.0;
        }
        let operator = &self.local.operator;
        let size = |is_damping: bool, from: usize| {
            let side = |m: usize| f64::EPSILON * self.derivative(places, free, m, from).abs();
            operator.size(n, is_damping, |m| side(m) + self.doubt(places, free, m, from))
        };
        let own = f64::EPSILON * self.derivative(places, free, n, k).abs();
        match k {
            0 | 1 => own,
            _ => own + size(false, k - 2) + if operator.is_damped() { size(true, k - 1) } else { 0.0 },
        }
    }

    /// g″ and g‴ of a contact that moves, at the origin of its series; where contacts see several coordinates, none may rest.
    pub(crate) fn bends(&self, places: &Places, contact: usize) -> [f64; 2] {
        let free = if self.is_direct { contact } else { usize::MAX };
        [2, 3].map(|k| {
            let weights = self.weights(contact).iter();
            weights.map(|(n, weight)| weight * self.derivative(places, free, *n, k)).sum()
        })
    }

    /// Of a contact that sees one coordinate what [`Tendencies::tendency`] says of all.
    pub(crate) fn tendency(
        &self,
        places: &Places,
        contact: usize,
        barrier: Barrier,
        from: usize,
    ) -> Option<(u8, bool)> {
        let first = match places[contact].touch {
            Contact::Leaving(_, m) => usize::from(m),
            _ => 0,
        };
        (from.max(first)..=LOW).find_map(|k| {
            let outward = barrier.sign() * self.derivative(places, contact, contact, k);
            (outward.abs() > 4.0 * self.doubt(places, contact, contact, k)).then_some((k as u8, outward > 0.0))
        })
    }

    /// Follows the force on a contact at rest.
    pub(crate) fn rest_watch(
        &self,
        system: &System,
        (contact, barrier): (usize, Barrier),
        forces: &[f64; MAX_ORDER + 1],
    ) -> Watch {
        let order = self.series.rows.order;
        let doubt = 8.0 * self.acceleration_doubt(contact) / system.mobility(contact, contact);
        let mut watch = Watch::rest(contact, barrier, order, self.horizon - self.origin(contact), doubt);
        for k in 0..order - 1 {
            watch.c[k] = -barrier.sign() * forces[k] * self.local.inverse_factorial[k];
        }
        watch
    }

    /// Rounding of the acceleration of a contact, in internal time.
    fn acceleration_doubt(&self, contact: usize) -> f64 {
        let Local { operator, scale, .. } = &*self.local;
        let of = |(n, weight): &(usize, f64)| {
            let stiff = operator.size(*n, false, |m| self.position(m).abs()) / (scale * scale);
            let damped = operator.size(*n, true, |m| self.velocity[m].abs()) / scale;
            weight.abs() * f64::EPSILON * (self.series.rows.get(2, *n).abs() + 2.0 * (stiff + damped))
        };
        self.weights(contact).iter().map(of).sum()
    }
}
