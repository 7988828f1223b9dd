//! Stripes of instability: which modes collide, where, and how wide.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod along_rows;
mod edges;
mod krein;
mod of_rows;
mod signatures;
