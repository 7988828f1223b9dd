//! Branches: orbits as one number of their structure varies.
//!
//! | module | holds |
//! |---|---|
//! | `continuation` | [`Branch`]: the equations with numbers of the structure free |
//! | `departure` | where the branch of other orbits begins |
//! | `family` | models by numbers that are free |
//! | `images` | whether an orbit is its own mirror image |
//! | `reduction` | orbits of a symmetry among themselves |
//! | `resonances` | where a branch meets a resonance |
//!
//! [`Branch`]: continuation::Branch

pub(crate) mod continuation;
pub(crate) mod departure;
pub(crate) mod family;
mod images;
mod reduction;
pub(crate) mod resonances;
