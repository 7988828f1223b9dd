//! Outcomes that are not orbits.

use std::fmt;

use thiserror::Error;
use vibrochain_lattice::{Barrier, ParameterError, Resonance, Short, Stopped, StructureError};

use crate::word::{MAX_IMPACTS, WordError};

/// Why a request could not be computed. "There is no such breather" is not among these: it is an answer, see
/// [`NoBreather`].
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BreatherError {
    /// A parameter is outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A harmonic of the motion meets a mode of the ring, or the force meets the uniform mode.
    #[error(transparent)]
    Resonance(#[from] Resonance),
    /// The structure does not answer.
    #[error(transparent)]
    Structure(#[from] StructureError),
    /// The fastest mode swings so often in a period that following every mass is out of reach.
    #[error(
        "too stiff to be checked: the fastest motion needs {windows:e} windows a period, the limit is {limit:e}; raise omega or lower gamma1 and gamma2"
    )]
    TooStiff {
        /// Windows needed.
        windows: f64,
        /// Windows allowed.
        limit: f64,
    },
    /// An impact of a given word is not possible.
    #[error("impact {index}: {what}")]
    Impact {
        /// Position in the list of impacts.
        index: usize,
        /// What is wrong with it.
        what: &'static str,
    },
    /// The word is none of this chain.
    #[error(transparent)]
    Word(#[from] WordError),
    /// Newton's method does not lead from a given word to an orbit.
    #[error(
        "no orbit found near the given impacts: Newton's method leaves a violation of {violation:e} (relative to the terms of the conditions at the impacts); start nearer to an orbit"
    )]
    NotConverged {
        /// The largest violation left.
        violation: f64,
    },
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
        barrier: Barrier,
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
    /// What varies brings a load to an orbit without one: it has no phase to begin with.
    #[error(
        "the orbit has no load, which what varies would bring: vary a number that brings none, or start under a load"
    )]
    LoadWithoutPhase {
        /// Which of the numbers that vary brings it, from 0.
        which: usize,
    },
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
    /// What only lattices have is asked of another structure's orbit.
    #[error("this orbit is of a structure that is no lattice: ask its contacts, not its masses")]
    NoLattice,
    /// What is asked for takes modes that nothing damps, and the lattice has dashpots.
    #[error(
        "this takes modes that nothing damps, and the lattice has dashpots: leave damping and coupling_damping at 0"
    )]
    Dashpots,
    /// Impacts that are not in the order of time within one period.
    #[error("the impacts are not in order of time within one period of the orbit{}", if *found { ", where Newton's method has led" } else { "" })]
    OutOfOrder {
        /// Newton's method has led there.
        found: bool,
    },
    /// More impacts than are solved for.
    #[error("{impacts} impacts are too many: an orbit has at most {}", MAX_IMPACTS)]
    TooManyImpacts {
        /// How many were given.
        impacts: usize,
    },
    /// Whether it is physical could not be decided.
    #[error("too stiff to be checked: contact {contact} would need more than {steps} steps in one flight")]
    LongFlight {
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
    /// The [`Stop`](vibrochain_lattice::Stop) of [`Finder::until`](crate::Finder::until) or [`LoadedStructure::until`](crate::LoadedStructure::until)
    /// was raised.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// What keeps a word from being searched for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Unsearched {
    /// No word has been named.
    Unnamed,
    /// Without force and losses, more than two instants, and masses that feel each other too little, or not at all, to tell when each
    /// hits.
    FreePhases,
    /// The same without any coupling: any phases of the masses will do.
    Uncoupled,
    /// One mass hits more than twice, or twice in several periods of the force.
    ManyImpacts,
    /// Dashpots, of which one may feed the motion, and no force: an orbit would have a period of its own.
    OwnPeriod,
    /// A mass that γ₁ = 0 leaves without any spring once it is not coupled: there is nothing to follow.
    Unheld,
}

impl fmt::Display for Unsearched {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unnamed => "give the word",
            Self::FreePhases => {
                "the masses share no harmonic, or are so far apart that rounding hides what they feel of each other, so that nothing tells when each hits; bring them nearer, raise gamma2, or give an orbit nearby"
            }
            Self::Uncoupled => {
                "without coupling and force the masses may hit whenever they like, and every shift in time of one of them is another orbit; give gamma2 or gamma3"
            }
            Self::ManyImpacts => {
                "a mass that hits more than twice in a period of the force, or not as often as there are periods, has no closed form to begin from; give the word as many periods of the force as its masses have impacts alike, or an orbit nearby"
            }
            Self::OwnPeriod => {
                "without a force a dashpot of negative damping gives an orbit a period of its own, which is not that of omega; ask for the chain as a structure"
            }
            Self::Unheld => {
                "with gamma1 = 0 masses without coupling have no springs to begin from; give an orbit nearby"
            }
        })
    }
}

/// Why a family has no orbit at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "kind", rename_all = "kebab-case")
)]
pub enum NoBreather {
    /// Inelastic impacts and no force: every impact loses energy, nothing brings it back.
    LossWithoutForce,
    /// The family lives under a force only.
    NeedsForce,
    /// What solves the conditions is the orbit of a part of the word, gone through several times.
    RepeatsSooner,
    /// γ₁ = 0 and a word with net impulse: nothing would hold the ring in place.
    NetImpulse,
    /// The force is below the least one, given here, that sustains the family at this point.
    ForceTooWeak {
        /// The least amplitude.
        threshold: f64,
    },
    /// No phase of the force meets the conditions at the impacts.
    NoPhase,
    /// No times of the impacts meet their conditions.
    NoTimes,
    /// No times of the impacts, and under a force no phase, meet the conditions with barriers that push.
    NothingPushes,
    /// The conditions at the impacts are singular: the two impacts do not determine their impulses.
    Singular,
    /// No orbits of the masses alone hit in the order of the word, each from inside.
    NoStart,
    /// All branches of the word that were followed from γ₂ = 0 ended on the way ([`crate::OrbitList::ended`]).
    BranchesEnded,
    /// No way is known to find the orbits of this word by itself; one nearby leads to them.
    NotSearched(Unsearched),
}

impl fmt::Display for NoBreather {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LossWithoutForce => {
                write!(
                    f,
                    "impacts lose energy (restitution < 1), or dashpots do, and no force restores it: give an amplitude, or restitution 1 and no dashpots"
                )
            }
            Self::NeedsForce => write!(f, "this family exists under a force only: give amplitude and restitution"),
            Self::RepeatsSooner => {
                write!(
                    f,
                    "what meets its conditions is the orbit of a part of the word, gone through several times: ask for that part at its frequency"
                )
            }
            Self::NetImpulse => {
                write!(
                    f,
                    "gamma1 = 0 leaves the masses free to drift and impacts on one side push them away: no periodic orbit"
                )
            }
            Self::ForceTooWeak { threshold } => {
                write!(f, "the force is too weak: this family needs an amplitude of at least {}", Short(*threshold))
            }
            Self::NoPhase => write!(f, "no phase of the force meets the conditions at the impacts"),
            Self::NoTimes => write!(f, "no times of the impacts meet their conditions"),
            Self::NothingPushes => {
                write!(
                    f,
                    "no times of the impacts, under a force with no phase, meet their conditions with barriers that push"
                )
            }
            Self::Singular => write!(f, "the conditions at the impacts are singular here"),
            Self::NoStart => {
                write!(
                    f,
                    "the masses alone, without coupling, have no orbits that hit in the order of the word, each from inside"
                )
            }
            Self::BranchesEnded => write!(f, "all branches from masses without coupling end before this point"),
            Self::NotSearched(why) => write!(f, "this word cannot be searched for: {why}"),
        }
    }
}
