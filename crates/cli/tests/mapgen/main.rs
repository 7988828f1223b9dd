//! The program as its users meet it.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod asked;
mod files;
mod harmonics;
mod orbits;
mod simulations;
mod sweeps;
