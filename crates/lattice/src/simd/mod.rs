//! Sines of four phases at once, and sums that keep their digits.

pub(crate) mod sines;
pub(crate) mod small;
