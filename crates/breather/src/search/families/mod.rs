//! The families of one site, a file each, and the equations that they reduce to.

pub(crate) mod conservative;
pub(crate) mod forced_double;
pub(crate) mod forced_single;
pub(crate) mod one_mass;
pub(crate) mod overdetermined;
pub(crate) mod pattern;
pub(crate) mod positions;
pub(crate) mod two_impacts;
pub(crate) mod two_instants;
