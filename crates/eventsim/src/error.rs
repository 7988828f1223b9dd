//! What can be wrong with the request for a simulation.

use thiserror::Error;
use vibrochain_lattice::{Barrier, Short};

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
    /// Not two numbers a mode.
    #[error("the state has {given} modes where the structure has {wanted}: give two numbers a mode")]
    Modes {
        /// Modes given.
        given: usize,
        /// Modes of the structure.
        wanted: usize,
    },
    /// A number is infinite, not a number, or not what it must be.
    #[error("{what} is {value}: give {requirement}")]
    Range {
        /// Which one: `psi`, `omega`, `velocity of site 3`.
        what: String,
        /// The value as given.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// A contact starts beyond its barrier.
    #[error(
        "{name} starts at {}, {excess:e} beyond its {} barrier at {}: start it between its barriers",
        Short(*value),
        .barrier.name(),
        Short(*place)
    )]
    OutsideGap {
        /// The contact; of a lattice the mass, counted through all layers.
        contact: usize,
        /// What it is called: `contact 3`, `site 1:2`.
        name: String,
        /// The barrier it is behind.
        barrier: Barrier,
        /// Where it is.
        value: f64,
        /// Where the barrier is.
        place: f64,
        /// How far behind the barrier it is.
        excess: f64,
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

impl StateError {
    pub(crate) fn not_finite(what: String, value: f64) -> Self {
        Self::Range { what, value, requirement: "a finite number" }
    }

    /// Of a contact at `value`, whose barrier is at `place`.
    pub(crate) fn outside((contact, name): (usize, String), barrier: Barrier, [value, place]: [f64; 2]) -> Self {
        Self::OutsideGap { contact, name, barrier, value, place, excess: barrier.sign() * (value - place) }
    }
}

/// What is wrong with tangent vectors.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum TangentError {
    /// None, more than the state space has directions, or more than anybody looks at.
    #[error("{count} tangent vectors: give 1 to {most}")]
    Count {
        /// How many were asked for.
        count: usize,
        /// How many there can be.
        most: usize,
    },
    /// A vector has not two finite numbers a mass, or a mode, or all of them are zero.
    #[error("tangent vector {vector} has not {size} finite numbers in each of its two lists, or nothing but zeros")]
    Entries {
        /// Number of the vector, from 0.
        vector: usize,
        /// Masses of the lattice, or modes of the structure.
        size: usize,
    },
    /// They belong to another model.
    #[error("the tangent vectors belong to another model than the simulation")]
    OtherModel,
}
