//! Structures and damped chains as users of the program meet them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod branches;
mod commands;
mod long_runs;
mod maps;
mod pictures;
mod runs;
