//! The manual holds: its links, names, lengths, commands and numbers.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod damped_chains;
mod links;
mod pages;
mod problems;
