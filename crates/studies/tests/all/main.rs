//! The studies: what they write, and what it says. One program, for each that is linked takes as long as all of them run.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod accuracy;
mod documents;
mod extremes;
mod figures;
mod net;
mod peer;
mod requests;
mod stripe_laws;
mod stripe_lines;
mod structures;
