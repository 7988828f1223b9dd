//! The families of one site, a file each, and the equations that they reduce to.

pub(crate) mod conservative;
pub(crate) mod overdetermined;
pub(crate) mod positions;
pub(crate) mod two_instants;
