//! Orbits under forces of several harmonics.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod completeness;
mod pairs;
mod shifts;
