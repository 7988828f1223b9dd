//! Newton's method on an orbit's equations with free parameters: what branches and surfaces share.

pub(crate) mod corrector;
pub(crate) mod reduction;
