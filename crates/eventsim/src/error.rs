//! What can be wrong with the request for a simulation.

use thiserror::Error;
use vibrochain_lattice::{Barrier, Layout, Short};

/// A state that no simulation can start from. What happens later is an [`Outcome`](crate::Outcome), never an error.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StateError {
    /// An array does not hold one number a mass.
    #[error("{name} has {found} entries, the lattice has {sites} masses: give one number a mass")]
    Length {
        /// `displacement` or `velocity`.
        name: &'static str,
        /// Entries given.
        found: usize,
        /// Masses of the lattice.
        sites: usize,
    },
    /// A number is infinite or not a number.
    #[error("{} is {value}: give a finite number", of_mass(.name, *.site, .layout))]
    NotFinite {
        /// `displacement`, `velocity` or, with site 0, `psi`.
        name: &'static str,
        /// The mass, counted through all layers.
        site: usize,
        /// How it is called.
        layout: Layout,
        /// The value as given.
        value: f64,
    },
    /// A mass starts outside its gap.
    #[error(
        "site {} starts at {}, {excess:e} beyond its {} barrier: give a number from {low} to {high}",
        .layout.name(*site),
        Short(*value),
        .barrier.name()
    )]
    OutsideGap {
        /// The mass, counted through all layers.
        site: usize,
        /// How it is called.
        layout: Layout,
        /// The barrier it is behind.
        barrier: Barrier,
        /// Its displacement.
        value: f64,
        /// How far behind the barrier it is.
        excess: f64,
        /// Position of the lower barrier.
        low: f64,
        /// Position of the upper barrier.
        high: f64,
    },
    /// Something crosses the gap in less time than the clock resolves.
    #[error(
        "{name} = {value:e} is beyond {limit:e}: in units of the gap and of the fastest frequency it exceeds 1e12, \
         and its impacts could not be told apart in time"
    )]
    TooFast {
        /// `velocity` or `amplitude`.
        name: &'static str,
        /// The value.
        value: f64,
        /// The largest magnitude that can be followed.
        limit: f64,
    },
}

/// A number of a mass, which words call by site and layer; the phase of the force is of none.
fn of_mass(name: &str, site: usize, layout: &Layout) -> String {
    if name == "psi" { name.to_owned() } else { format!("{name} of site {}", layout.name(site)) }
}

/// What is wrong with tangent vectors.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum TangentError {
    /// None, more than the lattice has directions, or more than anybody looks at.
    #[error("{count} tangent vectors: give 1 to {most}")]
    Count {
        /// How many were asked for.
        count: usize,
        /// How many there can be.
        most: usize,
    },
    /// Not one finite number a mass in each of displacement and velocity, or all of them zero.
    #[error(
        "tangent vector {vector} has not one finite number a mass in displacement and velocity, or nothing but zeros; the lattice has {sites} masses"
    )]
    Entries {
        /// Number of the vector, from 0.
        vector: usize,
        /// Masses of the lattice.
        sites: usize,
    },
    /// They belong to another model.
    #[error("the tangent vectors belong to another model than the simulation")]
    OtherModel,
}
