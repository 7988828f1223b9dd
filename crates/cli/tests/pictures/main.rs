//! Pictures that the program draws.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod all_plots;
mod draw;
mod gallery;
mod maps;
mod pages;
