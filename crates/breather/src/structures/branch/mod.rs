//! Branches: orbits as one number of their structure varies.
//!
//! | module | holds |
//! |---|---|
//! | `continuation` | [`Branch`]: the equations with numbers of the structure free |
//! | `departure` | where the branch of other orbits begins |
//! | `images` | whether an orbit is its own mirror image |
//! | `resonances` | where a branch meets a resonance |
//! | `twins` | orbits of a symmetry that needs fewer unknowns |
//!
//! [`Branch`]: continuation::Branch

pub(crate) mod continuation;
pub(crate) mod departure;
mod images;
mod resonances;
mod twins;
