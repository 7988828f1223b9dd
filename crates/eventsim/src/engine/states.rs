//! Where the masses are at any time of a window.

use std::ops::Range;

use super::Engine;
use crate::series::LANES;
use crate::weights::Weights;

/// From this size on an event restarts a part of the ring, as a rule.
const LARGE: usize = 64;

impl Engine {
    /// Weights of the whole ring at `s` since the base. On a small ring every event restarts all masses, at instants that
    /// may repeat; on a large one the varying windows spread the rounding of the weights.
    fn weights_at(&self, s: f64) -> Weights {
        let mut weights = Weights::zero();
        if self.ring.sites() < LARGE {
            weights.precise(s, self.rows.order, &self.units.inverse_factorial);
        } else {
            weights.plain(s, self.rows.order, &self.units.inverse_factorial);
        }
        weights
    }

    /// Moves the base to `s`: the states of all masses there, and nothing in flight.
    pub(crate) fn rebase(&mut self, s: f64) {
        self.weights = self.weights_at(s);
        let (mut x, mut v) = (std::mem::take(&mut self.x_next), std::mem::take(&mut self.v_next));
        self.states_at(s, &self.weights, &mut x, &mut v);
        (self.x_next, self.v_next) = (x, v);
        for (n, lost) in &self.lost {
            // For a mass restarted since, it has served its turn.
            if self.origin[*n] == 0.0 {
                (self.x_next[*n], self.v_next[*n]) = self.rows.at(*n, self.ring.x[*n], &self.weights, Some(lost));
            }
        }
        self.moved.drain(..).for_each(|n| self.origin[n] = 0.0);
        std::mem::swap(&mut self.ring.x, &mut self.x_next);
        std::mem::swap(&mut self.ring.v, &mut self.v_next);
        self.ring.free_all_departed();
        self.clock.advance(s);
        self.pace.pass(s);
    }

    /// Displacements and velocities (internal) at `s` since the base, within the certified part of the window.
    pub(crate) fn read(&self, s: f64, x: &mut [f64], v: &mut [f64]) {
        self.states_at(s, &self.weights_at(s), x, v);
    }

    /// The same with the weights for masses whose series begin at the base.
    fn states_at(&self, s: f64, weights: &Weights, x: &mut [f64], v: &mut [f64]) {
        if self.moved.is_empty() {
            self.rows.at_all(&self.ring.x, weights, x, v);
        } else {
            self.rows.all_at((s, &self.origin), &self.ring.x, (weights, &self.units.inverse), [x, v]);
        }
    }

    /// Carries the masses of a range alone to `s`, as the new origin of their series.
    pub(crate) fn carry(&mut self, masses: Range<usize>, s: f64) {
        for base in masses.clone().step_by(LANES) {
            let (x, v) = self.rows.eight_at(base, (s, &self.origin), &self.ring.x, &self.units.inverse);
            for ((n, x), v) in (base..masses.end).zip(x).zip(v) {
                let origin = &mut self.origin[n];
                if s > *origin {
                    if *origin == 0.0 {
                        self.moved.push(n);
                    }
                    *origin = s;
                    (self.ring.x[n], self.ring.v[n]) = (x, v);
                    self.ring.free_departed(n);
                }
            }
        }
    }
}
