//! Why there is no answer about the orbits of a structure.

use thiserror::Error;
use vibrochain_lattice::{Short, Stopped, StructureError};

use crate::error::BreatherError;

/// Why a structure's orbits could not be worked out. That there are none is an answer, not one of these.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StructureOrbitError {
    /// The structure does not answer.
    #[error(transparent)]
    Structure(#[from] StructureError),
    /// The lattice of which the contacts are masses does not answer.
    #[error(transparent)]
    Lattice(#[from] BreatherError),
    /// ω is no frequency.
    #[error("omega = {} is out of range: give a positive number, 1e-100 to 1e100", Short(*omega))]
    Omega {
        /// As given.
        omega: f64,
    },
    /// A period that is none.
    #[error("force-periods = 0: an orbit lasts one period of the force or more")]
    Periods,
    /// A contact that the structure does not have.
    #[error("contact {contact} does not exist: this structure has the contacts 0 to {last}")]
    NoSuchContact {
        /// Its number.
        contact: usize,
        /// The last one there is.
        last: usize,
    },
    /// A barrier that a contact does not have.
    #[error("contact {contact} has no {barrier} barrier")]
    NoBarrier {
        /// The contact.
        contact: usize,
        /// `lower` or `upper`.
        barrier: vibrochain_lattice::Barrier,
    },
    /// Several contacts of a word at one instant.
    #[error(
        "impacts at one instant are searched for without loads and losses, in two instants at most: put commas between them, as in 0+,1+"
    )]
    AtOnce,
    /// Losses and nothing that restores them.
    #[error(
        "losses end the motion: no load changes, and no mode grows by itself; give a load, a dashpot of negative damping, or restitution 1 and \
         no dashpots"
    )]
    LossWithoutLoad,
    /// Periods of a load that there is not.
    #[error(
        "force-periods = {force_periods}: no load acts, and a self-excited orbit has a period of its own; leave them out"
    )]
    OwnPeriod {
        /// As given.
        force_periods: u32,
    },
    /// A number that changes nothing is to vary, such as ω of a structure that no load drives.
    #[error("what varies changes nothing of this structure: vary another number of it")]
    NoEffect,
    /// The conditions at the impacts do not determine the impulses.
    #[error(
        "the conditions at the impacts are singular here: orbits of any size, or none; move omega or a barrier a little"
    )]
    Singular,
    /// The [`Stop`](vibrochain_lattice::Stop) of [`StructureModel::until`](crate::StructureModel::until) was raised.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// A branch has come to where the structure's orbits have other unknowns: offsets of motions that nothing holds, the phase of a load.
    #[error(
        "the equations of the branch end here: a motion of the structure that a spring has held is held by none, or the other way round, or \
         the load vanishes"
    )]
    OtherUnknowns,
    /// The load moves none of the contacts that are to be hit.
    #[error(
        "the load moves none of the contacts of this word: nothing tells its phase; leave the load out, or give another word"
    )]
    Unfelt,
    /// Impacts that are not in the order of time within one period.
    #[error("the impacts are not in order of time within one period of the orbit{}", if *found { ", where Newton's method has led" } else { "" })]
    OutOfOrder {
        /// Newton's method has led there.
        found: bool,
    },
    /// More impacts than are solved for.
    #[error("{impacts} impacts are too many: an orbit has at most {}", crate::word::MAX_IMPACTS)]
    TooManyImpacts {
        /// How many were given.
        impacts: usize,
    },
    /// Whether it is physical could not be decided.
    #[error("too stiff to be checked: contact {contact} would need more than {steps} steps in one flight")]
    TooStiff {
        /// The contact.
        contact: usize,
        /// Steps that were taken.
        steps: usize,
    },
    /// Velocity, acceleration and jerk after an impact are no larger than their errors.
    #[error(
        "whether contact {contact} leaves its barrier after impact {impact} cannot be told: its velocity, acceleration and jerk there are below \
         their errors; move a number of the structure a little"
    )]
    Undecided {
        /// The contact.
        contact: usize,
        /// Index of the impact.
        impact: usize,
    },
    /// Impulses cannot balance the load on a rigid motion.
    #[error(
        "a rigid motion is pushed by a static load that no impact of this word balances, or by impacts that no load balances"
    )]
    Unbalanced,
    /// Newton's method has not ended.
    #[error(
        "no orbit found near the given impacts: Newton's method leaves a violation of {violation:e} (relative to the terms of the conditions \
         at the impacts); start nearer to an orbit"
    )]
    NotConverged {
        /// What is left.
        violation: f64,
    },
}
