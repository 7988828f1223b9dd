//! The list of a family's or a word's orbits at a point, with what is known of it.

use crate::orbit::{Orbit, order};
use crate::search::completeness::Completeness;
use crate::search::words::ended::Ended;

/// All orbits of a family or a word at a point.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct OrbitList {
    /// The orbits, physical or not, in order of φ, those of one φ by ψ.
    pub orbits: Vec<Orbit>,
    /// Whether the list holds all orbits, why it holds none, or which it may lack.
    pub completeness: Completeness,
    /// A word's branches are followed from γ₂ = 0: where those ended that did not reach this point.
    pub ended: Vec<Ended>,
    /// The period of self-excited motion is an unknown: the least and the largest period that were searched. Of others nothing is known.
    pub periods: Option<[f64; 2]>,
}

impl Default for OrbitList {
    /// Nothing has been searched.
    fn default() -> Self {
        Self { orbits: Vec::new(), completeness: Completeness::default(), ended: Vec::new(), periods: None }
    }
}

impl OrbitList {
    /// The list of the one orbit that a start has led to. Others may exist.
    pub fn near(orbit: Orbit) -> Self {
        Self { orbits: vec![orbit], completeness: Completeness::followed(1, 1, 0), ..Self::default() }
    }

    /// Those of a structure, as its contacts know them.
    #[cfg(test)]
    pub(crate) fn contacts(&self) -> impl Iterator<Item = &crate::structures::orbit::ContactOrbit> + Clone {
        self.orbits.iter().map(|orbit| &**orbit.contacts().unwrap())
    }

    /// Puts them in the order of lists.
    pub(crate) fn sort(&mut self) {
        order::sort(&mut self.orbits, |orbit| (orbit.period(), orbit.psi()), Orbit::impacts, |impact| impact.time);
    }
}
