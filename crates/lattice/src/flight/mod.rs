//! Exact free flight.

pub(crate) mod propagator;
