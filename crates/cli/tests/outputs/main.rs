//! Where answers are written, and what can go wrong there.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod destinations;
mod faults;
mod readers;
