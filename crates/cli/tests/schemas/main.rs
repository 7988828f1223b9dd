//! JSON by its schemas, and the names of things.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod answers;
mod forms;
mod names;
