//! Is an orbit physical? By bounds, not by samples.

pub(crate) mod answer;
pub(crate) mod check;
pub(crate) mod conservative_modes;
pub(crate) mod gap;
pub(crate) mod grid;
pub(crate) mod map_breather;
