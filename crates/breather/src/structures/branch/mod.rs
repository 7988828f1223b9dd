//! Branches: orbits as one number of their structure varies.
//!
//! | module | holds |
//! |---|---|
//! | `continuation` | [`StructureBranch`]: the equations with numbers of the structure free |
//! | `departure` | where the branch of other orbits begins |
//! | `resonances` | where a branch meets a resonance |
//! | `twins` | impacts that a mirror exchanges |
//!
//! [`StructureBranch`]: continuation::StructureBranch

pub(crate) mod continuation;
mod departure;
mod resonances;
mod twins;
