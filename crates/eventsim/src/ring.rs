//! The masses of a lattice between two expansions: where they are, how fast, and which of them touch a barrier.

use crate::units::{MAX_ORDER, Units};
use vibrochain_lattice::Barrier;

/// How a mass touches a barrier at the origin of its series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Contact {
    /// It does not.
    Free,
    /// It is on the barrier and leaves it: the first derivative of its displacement that does not vanish has this
    /// order (1 after an impact, 3 after a release) and points inward. Those before it vanish exactly.
    Leaving(Barrier, u8),
    /// It rests on the barrier, which pushes it back.
    Resting(Barrier),
}

/// Beyond this distance a mass forgets the barrier that its displacement is measured from: there the position
/// itself is known as well as the distance.
pub(crate) const FORGET: f64 = 0.25;

/// Displacements and velocities in internal units.
///
/// u = `reference` + x. Near a barrier the reference is that barrier: x is then the distance to it, and a mass that
/// leaves at 1e-13 and comes back at once has its flight to full RELATIVE accuracy, which u could not hold.
#[derive(Debug, Clone)]
pub(crate) struct Ring {
    pub(crate) x: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) reference: Vec<f64>,
    pub(crate) contact: Vec<Contact>,
    /// Masses at rest on a barrier, rising.
    pub(crate) resting: Vec<usize>,
    /// Masses whose reference is a barrier.
    near: Vec<usize>,
}

impl Ring {
    /// `sites` masses in the middle of nowhere, free and at rest.
    pub(crate) fn new(sites: usize) -> Self {
        Self {
            x: vec![0.0; sites],
            v: vec![0.0; sites],
            reference: vec![0.0; sites],
            contact: vec![Contact::Free; sites],
            resting: Vec::new(),
            near: Vec::new(),
        }
    }

    pub(crate) fn sites(&self) -> usize {
        self.x.len()
    }

    pub(crate) fn position(&self, n: usize) -> f64 {
        self.reference[n] + self.x[n]
    }

    pub(crate) fn is_resting(&self, n: usize) -> bool {
        matches!(self.contact[n], Contact::Resting(_))
    }

    /// Measures the displacement of mass `n` from `position`, where it is: x = 0.
    pub(crate) fn touch(&mut self, n: usize, position: f64) {
        self.anchor(n, position, 0.0);
    }

    /// Measures the displacement of mass `n` from a barrier's `position`, at the distance x.
    pub(crate) fn anchor(&mut self, n: usize, position: f64, x: f64) {
        // A barrier is never at 0: a < 1.
        if self.reference[n] == 0.0 {
            self.near.push(n);
        }
        self.reference[n] = position;
        self.x[n] = x;
    }

    pub(crate) fn rest(&mut self, n: usize, barrier: Barrier) {
        self.v[n] = 0.0;
        self.contact[n] = Contact::Resting(barrier);
        if let Err(place) = self.resting.binary_search(&n) {
            self.resting.insert(place, n);
        }
    }

    pub(crate) fn leave(&mut self, n: usize, barrier: Barrier, order: u8) {
        if self.is_resting(n) {
            self.resting.retain(|&m| m != n);
        }
        self.contact[n] = Contact::Leaving(barrier, order);
    }

    /// A mass that has moved on is no longer on its barrier.
    pub(crate) fn free_departed(&mut self, n: usize) {
        // A flight so short that even the distance underflows has not left.
        if matches!(self.contact[n], Contact::Leaving(..)) && self.x[n] != 0.0 {
            self.contact[n] = Contact::Free;
        }
    }

    /// The same for all masses, and those far from the barrier they came from forget it.
    pub(crate) fn free_all_departed(&mut self) {
        let mut near = std::mem::take(&mut self.near);
        near.retain(|&n| {
            self.free_departed(n);
            // At the other barrier, too: it is about to be struck, and the change would round its distance.
            let keep = (self.x[n].abs() - 1.0).abs() >= 1.0 - FORGET;
            if !keep {
                self.x[n] += self.reference[n];
                self.reference[n] = 0.0;
            }
            keep
        });
        self.near = near;
    }

    /// Masses that leave a barrier with an order above 1, among all, appended to `out`.
    pub(crate) fn soft_departures(&self, out: &mut Vec<(usize, u8)>) {
        out.extend(self.near.iter().filter_map(|&n| self.soft_departure(n).map(|order| (n, order))));
    }

    /// Masses that leave a barrier, appended to `out`.
    pub(crate) fn departures(&self, out: &mut Vec<usize>) {
        out.extend(self.near.iter().filter(|&&n| matches!(self.contact[n], Contact::Leaving(..))));
    }

    /// The order with which mass `n` leaves a barrier, if above 1.
    pub(crate) fn soft_departure(&self, n: usize) -> Option<u8> {
        match self.contact[n] {
            Contact::Leaving(_, order) if order > 1 => Some(order),
            _ => None,
        }
    }

    /// The k-th derivative (k ≤ 5) of the displacement of mass `n`, as if it were free; its neighbours are as they
    /// are. For a mass at rest this is the acceleration it is denied, and its derivatives.
    pub(crate) fn derivative(&self, units: &Units, force: &[f64; MAX_ORDER + 1], n: usize, k: usize) -> f64 {
        match k {
            0 => self.position(n),
            1 => self.v[n],
            _ => {
                let own = self.derivative(units, force, n, k - 2);
                let of = |m: usize| match m {
                    // Beside a free end: no spring.
                    _ if m == n => own,
                    _ if k > 3 && self.is_resting(m) => 0.0,
                    _ => self.derivative(units, force, m, k - 2),
                };
                units.pull(own, units.sides(n, of)) + force[k - 2]
            }
        }
    }

    /// For a mass at rest at the very barrier: the first derivative, from order `from` on, that does not vanish, and
    /// whether it points outward (pressed) or inward (free to leave). `None` if none up to the fifth does: no force.
    pub(crate) fn tendency(
        &self,
        units: &Units,
        force: &[f64; MAX_ORDER + 1],
        n: usize,
        barrier: Barrier,
        from: u8,
    ) -> Option<(u8, bool)> {
        (from..=5).find_map(|k| {
            let outward = barrier.sign() * self.derivative(units, force, n, usize::from(k));
            (outward != 0.0).then_some((k, outward > 0.0))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibrochain_lattice::{Chain, Ends, Model};

    /// Beside a free end stands the mass itself, be it at rest or not: no spring.
    #[test]
    fn derivatives_at_rest_beside_an_end_are_those_by_hand() {
        let (g1, g2, g3) = (0.2, 0.1, 0.05);
        for (ends, wall) in [(Ends::Free, 0.0), (Ends::Fixed, 1.0)] {
            let chain = Chain::new(2, g1, g2).unwrap().with_ends(ends).with_layers(2, g3, Ends::Free).unwrap();
            let units = Units::new(&Model::conservative(chain, 0.3, 0.4).unwrap());
            let mut ring = Ring::new(4);
            ring.x = vec![1.4, 0.3, -0.2, 0.1];
            ring.rest(0, Barrier::Upper);
            let force = [0.0; MAX_ORDER + 1];
            // Springs to the one beside, to the one above or below, and to a wall.
            let pull = |own: f64, beside: f64, across: f64| {
                -g1 * own - g2 * (own - beside) - g2 * wall * own - g3 * (own - across)
            };
            let second = [pull(1.4, 0.3, -0.2), pull(0.3, 1.4, 0.1), pull(-0.2, 0.1, 1.4)];
            let fourth = pull(second[0], second[1], second[2]);
            let square = units.scale * units.scale;
            assert!((ring.derivative(&units, &force, 0, 2) * square - second[0]).abs() < 1e-15);
            assert!((ring.derivative(&units, &force, 0, 4) * square * square - fourth).abs() < 1e-15);
        }
    }
}
