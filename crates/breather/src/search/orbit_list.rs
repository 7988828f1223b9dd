//! Orbits of a family or a word at a point, and what is known of their list.

use crate::orbit::{Orbit, order};
use crate::search::completeness::Completeness;
use crate::search::words::ended::Ended;

/// All orbits of a family or a word at a point.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct OrbitList<O = Orbit> {
    /// The orbits, physical or not, in order of φ, those of one φ by ψ.
    pub orbits: Vec<O>,
    /// Whether these are all, why there are none, or what may be missing.
    pub completeness: Completeness,
    /// Where branches of a word ended that were followed from γ₂ = 0 and did not come as far as this point.
    pub ended: Vec<Ended>,
    /// Of self-excited motion, whose period is an unknown, the least and the largest that were searched: of others nothing is known.
    pub periods: Option<[f64; 2]>,
}

impl<O> Default for OrbitList<O> {
    /// Nothing has been searched.
    fn default() -> Self {
        Self { orbits: Vec::new(), completeness: Completeness::default(), ended: Vec::new(), periods: None }
    }
}

impl<O> OrbitList<O> {
    /// The orbit that one start leads to: others may exist.
    pub fn near(orbit: O) -> Self {
        Self { orbits: vec![orbit], completeness: Completeness::followed(1, 1, 0), ..Self::default() }
    }
}

impl OrbitList {
    /// Puts them in the order of lists.
    pub(crate) fn sort(&mut self) {
        order::sort(&mut self.orbits, |orbit| (orbit.period(), orbit.psi()), Orbit::impacts, |impact| impact.time);
    }
}
