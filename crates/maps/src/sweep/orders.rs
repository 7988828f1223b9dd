//! The orders of signatures of a cell's orbits: where they differ between two points, a stripe passes between them, however thin.
//!
//! The best orbit alone would not do. Between two points where it is unstable another word may be stable, in a band thinner than a cell;
//! and beyond the edge where one word takes over from another, what the first one does no longer counts.

use std::hash::{DefaultHasher, Hash, Hasher};

use vibrochain_breather::Orbit;
use vibrochain_floquet::OrderFinder;
use vibrochain_lattice::Model;

use crate::cell::{Cell, Class, Task, Worker};

/// The orders of all orbits that could give a cell its class: a number that is the same where each of them is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct CellOrders(u64);

/// Computes cells together with their orders; keeps what the next cell needs again.
#[derive(Debug, Default)]
pub(super) struct CellOrderFinder {
    orders: OrderFinder,
    orbits: Vec<Orbit>,
}

impl CellOrderFinder {
    /// A cell and its orders; `None` where there is no orbit, or an order is not known.
    pub(super) fn cell(&mut self, worker: &mut Worker, model: &Model, task: &Task) -> (Cell, Option<CellOrders>) {
        self.orbits.clear();
        let mut best = 0;
        let cell = worker.examine(model, task, |orbit, is_best| {
            if is_best {
                best = self.orbits.len();
            }
            self.orbits.push(orbit.clone());
        });
        (cell, self.orders_of(task, best, cell.class))
    }

    fn orders_of(&mut self, task: &Task, best: usize, class: Option<Class>) -> Option<CellOrders> {
        // Words that are no family's give one class.
        let place = |orbit: &Orbit| task.families.iter().position(|family| *family == orbit.family());
        let place = |orbit: &Orbit| place(orbit).unwrap_or(task.families.len());
        let winner = place(self.orbits.get(best)?);
        let is_stable = matches!(class.and_then(Class::parts), Some((_, Some(true))));
        let mut hasher = DefaultHasher::new();
        for (number, orbit) in self.orbits.iter().enumerate() {
            // As long as the best one is stable, only families that are asked for before its own take the class from it.
            if is_stable && number != best && place(orbit) >= winner {
                continue;
            }
            // Orbits come word by word, as the scene lists these: the number tells which word has the order.
            (number, self.orders.of(orbit).ok()??).hash(&mut hasher);
        }
        Some(CellOrders(hasher.finish()))
    }
}
