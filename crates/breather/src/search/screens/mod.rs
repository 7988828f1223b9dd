//! Bounds that rule orbits out for a fraction of the cost of finding them.

pub(crate) mod forced_places;
pub(crate) mod kernel_grid;
pub(crate) mod radiation;
