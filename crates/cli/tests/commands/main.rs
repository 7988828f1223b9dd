//! Commands as their users meet them, one after the other.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod bounds;
mod branch;
mod curve;
mod curves;
mod fate;
mod from_scenes;
mod language;
mod locate;
mod modes;
mod multipliers;
mod simulate;
mod stripes;
mod words;
