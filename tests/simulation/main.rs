//! The closed forms against the event-driven simulation, which knows nothing of them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod bifurcations;
mod harmonics;
mod mechanism;
mod monodromy;
mod orbits;
