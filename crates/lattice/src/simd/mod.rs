//! Arithmetic of four numbers at a time, for the crates of this workspace.

pub mod lanes;
pub(crate) mod sines;
pub(crate) mod small;
#[cfg(feature = "matrices")]
pub(crate) mod twofold;
