//! Flights by their modes: contacts of any structure as polynomials on windows of a radian, from modes four at a time. Of masses of a lattice local
//! series ([`window`](super::window)) tell more: bounds by modes are common to all.

pub(crate) mod passage;
pub(crate) mod view;
pub(crate) mod windows;
