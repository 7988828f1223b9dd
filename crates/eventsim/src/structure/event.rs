//! What a run of a structure reports.

use thiserror::Error;

use crate::event::{EventKind, Report};
use crate::time::Time;
use vibrochain_lattice::{Barrier, Short};

/// One thing that happened at one contact. Contacts that hit together make one event each, at the same time, in the order in which they
/// were applied.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ContactEvent {
    /// When.
    pub time: Time,
    /// The contact.
    pub contact: usize,
    /// Its barrier.
    pub barrier: Barrier,
    /// g′ just before (0 for stick and release).
    pub velocity_before: f64,
    /// g′ just after.
    pub velocity_after: f64,
    /// P, which adds M⁻¹w P to q′; negative at an upper barrier.
    pub impulse: f64,
    /// What happened.
    pub kind: EventKind,
}

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum StructureOutcome {
    /// The time asked for was reached.
    TimeReached,
    /// The number of impacts asked for was reached.
    ImpactsReached,
    /// Two contacts that share a coordinate meet their barriers at one instant, or one pushes another, which rests, into its barrier: what
    /// comes of it depends on the order. The run stands just before it.
    Simultaneous {
        /// One of them.
        first: usize,
        /// The other one.
        second: usize,
    },
    /// A cascade of impacts could not be resolved: [`Limits::bounces`](crate::Limits::bounces) in a row. A contact
    /// that is pressed to its barrier with e = 1, or within 5e-5 of it, bounces for ever. Its impacts count as one cascade where each follows
    /// the last so soon that a period would hold more than these, and within 1e-3 of the fastest rate's unit.
    Cascade {
        /// The contact.
        contact: usize,
        /// Its barrier.
        barrier: Barrier,
        /// Impacts of the cascade so far.
        bounces: u32,
    },
    /// A mode that feeds itself has grown beyond any use: beyond 1e4 times what barriers, loads and the start make of the modes (by its
    /// own rate, where that is slower than the fastest one). A mode that does not feed itself: beyond 1e100.
    Diverged {
        /// The mode.
        mode: usize,
    },
    /// [`Limits::flights`](crate::Limits::flights) was reached.
    WorkLimit,
    /// The run was told to stop ([`StructureSimulation::heed`](crate::StructureSimulation::heed)); another one goes on with it.
    Stopped,
}

/// The end of a run of a structure.
pub type StructureReport = Report<StructureOutcome>;

/// A state that no simulation of a structure can start from.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StructureStateError {
    /// Not two numbers a mode.
    #[error("the state has {given} modes where the structure has {wanted}: give two numbers a mode")]
    Length {
        /// Modes given.
        given: usize,
        /// Modes of the structure.
        wanted: usize,
    },
    /// A number is infinite or not a number, or a frequency is not positive.
    #[error("{what} is {value}: give {requirement}")]
    Range {
        /// Which one.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// A contact starts beyond its barrier.
    #[error(
        "contact {contact} starts at {}, {excess:e} beyond its {} barrier at {}: start it between its barriers",
        Short(*value),
        .barrier.name(),
        Short(*place)
    )]
    OutsideGap {
        /// The contact.
        contact: usize,
        /// The barrier it is behind.
        barrier: Barrier,
        /// Where it is.
        value: f64,
        /// Where the barrier is.
        place: f64,
        /// How far behind the barrier it is.
        excess: f64,
    },
}
