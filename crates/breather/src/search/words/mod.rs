//! Orbits of any impact word: among those of the lattice as a structure, and from masses without coupling, followed to the coupling of the model.

pub(crate) mod at_contacts;
pub(crate) mod coupling_continuation;
pub(crate) mod ended;
pub(crate) mod isolated_mass;
pub(crate) mod phase_rule;
pub(crate) mod superpose;
pub(crate) mod uncoupled;
pub(crate) mod word_search;
