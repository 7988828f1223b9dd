//! What happens at a contact: the impact law, chatter, rest and release.
//!
//! **Impact.** v⁺ = −e v⁻, at the barrier itself: the series ends a rounding error away from it, and the velocity is
//! corrected by that distance times the acceleration over the velocity, so that no energy is made by the snap. Several
//! masses that meet their barriers together jump together: the order does not matter, positions do not jump and
//! no jump depends on another mass's velocity. A grazing mass (v⁻ = 0) makes one event, with its zero divided out
//! of what follows.
//!
//! **Chatter** (e < 1). A mass pressed against its barrier with acceleration α returns with e times its speed after
//! each flight of 2v⁺/α: infinitely many impacts in
//!
//! ```text
//! t_rem = 2 v⁺ / (α (1−e)) .
//! ```
//!
//! Once t_rem (1 + |j|/α) < [`CHATTER_TIME`], j the derivative of α, the sum is right to 1e-8 of itself, 1e-16 of a
//! unit of time, and the mass rests on the barrier from t + t_rem on. It is held there from now on: the excursions
//! left out are below 1e-17 of the gap.
//!
//! **Rest.** The mass stays while its barrier has to push. **Release** is the first root of that force; the mass leaves
//! with zero velocity and acceleration, and what decides is the next derivative *after* all jumps at this
//! instant: an impact of a neighbour can press the mass back at once.

use super::{Due, Engine};
use crate::cascade::Change;
use crate::event::EventKind;
use crate::time::two_sum;
use vibrochain_lattice::Barrier;

/// An accumulation of impacts is completed at its limit when so much time is left of it, in units of
/// 1/√(γ₁+4γ₂+4γ₃) (or 1/ω where the force is faster).
pub const CHATTER_TIME: f64 = 1e-8;

/// Velocity with which a mass meets a barrier that its series misses by `gap` = barrier − x, under the acceleration
/// `a`: never one that leaves it.
pub(crate) fn speed_at_barrier(barrier: Barrier, v: f64, gap: f64, a: f64) -> f64 {
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

impl Engine {
    /// Applies the contacts in `due` to the states at the common instant `s`; what became of them is added to
    /// `changes`, in the order of sites, the forced rests after their impacts.
    pub(crate) fn collide(&mut self, s: f64, changes: &mut Vec<Change>) {
        self.set_force(s);
        let due = std::mem::take(&mut self.due);
        for contact in &due {
            self.strike(contact, changes);
        }
        // Velocities are final now: derivatives of forces may be looked at.
        for contact in &due {
            self.part(contact, changes);
        }
        self.due = due;
    }

    fn strike(&mut self, contact: &Due, changes: &mut Vec<Change>) {
        let &Due { site, barrier, release, .. } = contact;
        if release {
            return;
        }
        let position = self.units.barrier(barrier);
        // The distance between the barriers is no floating-point number; its rounding would count at every crossing.
        let (distance, rest) = two_sum(position, -self.ring.reference[site]);
        let gap = (distance - self.ring.x[site]) + rest;
        let acceleration = self.ring.derivative(&self.units, &self.force, site, 2);
        let before = speed_at_barrier(barrier, self.ring.v[site], gap, acceleration);
        let after = 0.0 - self.units.restitution * before;
        self.ring.touch(site, position);
        self.ring.v[site] = after;
        self.fastest = self.fastest.max(before.abs());
        self.work.impacts += 1;
        let kind = EventKind::Impact;
        changes.push(Change { site, barrier, before, after, force: acceleration, kind, delay: 0.0 });
    }

    fn part(&mut self, contact: &Due, changes: &mut Vec<Change>) {
        let &Due { site, barrier, release, pull } = contact;
        let still = |kind, delay| Change::still(site, barrier, kind, delay);
        if release {
            // Its force is zero now, and was positive before; or zero, too, until a far neighbour set out.
            let tendency = self.ring.tendency(&self.units, &self.force, site, barrier, 3);
            if let Some((order, false)) = tendency.or(pull.map(|order| (order, false))) {
                self.ring.leave(site, barrier, order);
                self.work.releases += 1;
                changes.push(still(EventKind::Release, 0.0));
            }
            return;
        }
        let speed = self.ring.v[site].abs();
        if speed == 0.0 {
            match self.ring.tendency(&self.units, &self.force, site, barrier, 2) {
                Some((order, false)) => self.ring.leave(site, barrier, order),
                _ => {
                    self.ring.rest(site, barrier);
                    self.work.sticks += 1;
                    changes.push(still(EventKind::Stick, 0.0));
                }
            }
            return;
        }
        let loss = 1.0 - self.units.restitution;
        // (Without a loss there is no chatter, and nobody asks.)
        let pressing =
            if loss > 0.0 { barrier.sign() * self.ring.derivative(&self.units, &self.force, site, 2) } else { 0.0 };
        if pressing > 0.0 {
            let left = 2.0 * speed / (pressing * loss);
            let jerk = self.ring.derivative(&self.units, &self.force, site, 3).abs();
            if left * (1.0 + jerk / pressing) * self.units.rate < CHATTER_TIME {
                self.ring.rest(site, barrier);
                self.work.sticks += 1;
                changes.push(still(EventKind::Stick, left));
                return;
            }
        }
        self.ring.leave(site, barrier, 1);
    }
}
