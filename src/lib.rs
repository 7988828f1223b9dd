#![doc = include_str!("../docs/rust.md")]
//!
//! # Layers
//!
//! Data flows one way: parameters → spectrum → orbit → monodromy → verdict.

pub use vibrochain_breather as breather;
pub use vibrochain_eventsim as eventsim;
pub use vibrochain_floquet as floquet;
pub use vibrochain_lattice as lattice;
