//! From a model to its orbits: families in closed form, words of impacts, and what rules orbits out before they are looked at.

pub(crate) mod as_structure;
pub(crate) mod at_point;
pub(crate) mod at_resonance;
pub(crate) mod completeness;
pub(crate) mod families;
pub(crate) mod finder;
pub(crate) mod orbit_list;
pub(crate) mod screens;
pub(crate) mod words;
