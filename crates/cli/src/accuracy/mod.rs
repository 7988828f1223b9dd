//! placeholder until the command is merged
pub mod extremes;
