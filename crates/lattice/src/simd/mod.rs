//! Arithmetic of four numbers at a time, for the crates of this workspace.

#[cfg(feature = "matrices")]
pub(crate) mod complex_twofold;
pub mod lanes;
pub(crate) mod sines;
pub(crate) mod small;
pub(crate) mod twofold;
