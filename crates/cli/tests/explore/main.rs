//! `mapgen explore`: who may ask, and that what is answered is what the program prints.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod ends;
mod points;
mod refusals;
mod served;
mod tiles;
mod waiting;
