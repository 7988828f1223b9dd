//! Structures of any mass, damping and stiffness: the table of orbits, a dense search that shares no code, cases known by hand.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod dense;
mod energies;
mod found;
mod local;
mod made;
mod preloaded;
mod resting;
mod runs;
