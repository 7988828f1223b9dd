//! What is asked about: lattice, barriers, force, and each parameter by name.

pub(crate) mod chain;
pub(crate) mod display;
pub(crate) mod force;
pub(crate) mod parameter;
pub(crate) mod params;
pub(crate) mod point;
#[cfg(feature = "serde")]
pub(crate) mod serde_impl;
