//! What is known of a list of orbits: that it holds all there are, why there are none, or what it may lack.

use std::fmt;

use crate::error::NoBreather;

/// By which means the orbits of a family at a point are known to be all there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "by", rename_all = "kebab-case")
)]
pub enum Proof {
    /// Every solution of the conditions has a closed form, or they have none for a reason that needs no search.
    ClosedForm,
    /// The conditions reduce to one analytic function of one variable: enclosures on intervals show where it has no zero
    /// and that each zero found is alone.
    Enclosures {
        /// Intervals enclosed.
        intervals: usize,
    },
    /// The conditions are two functions of φ and ψ: branch and prune in the plane shows where they have no common zero,
    /// and that each one found exists and is alone.
    BranchAndPrune {
        /// Rectangles examined.
        boxes: usize,
    },
    /// A word of one or two instants without force: one linear system has all orbits that are their own mirror images in time.
    Reversible,
}

impl Proof {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::ClosedForm => "closed-form",
            Self::Enclosures { .. } => "enclosures",
            Self::BranchAndPrune { .. } => "branch-and-prune",
            Self::Reversible => "reversible",
        }
    }
}

impl fmt::Display for Proof {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ClosedForm => write!(f, "closed form"),
            Self::Reversible => write!(f, "closed form among those symmetric in time"),
            Self::Enclosures { intervals } => write!(f, "enclosures on {intervals} intervals"),
            Self::BranchAndPrune { boxes } => write!(f, "branch and prune in the plane, {boxes} boxes"),
        }
    }
}

/// What is known of a list of orbits.
///
/// It is the list of what was asked for ([`Finder::find_symmetric`](crate::Finder::find_symmetric) leaves a part out), and
/// of orbits that can be told apart: a doubled orbit, or an asymmetric double-sided one, from the simple or symmetric one that
/// it branches from as soon as its φ is 1e-7 of half the period away (conservative: 1e-6).
///
/// ```
/// use vibrochain_breather::{Completeness, Family, NoBreather, Proof, breathers};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4, 0.1, 0.9)?;
/// assert_eq!(breathers(&model, Family::SingleSided)?.completeness, Completeness::All(Proof::ClosedForm));
/// let searched = breathers(&model, Family::DoubleSided)?.completeness;
/// assert!(matches!(searched, Completeness::All(Proof::Enclosures { intervals }) if intervals < 1000));
/// let weak = Model::forced(*model.chain(), 1.5, 0.4, 1e-6, 0.9)?;
/// let none = breathers(&weak, Family::SingleSided)?.completeness;
/// assert!(matches!(none.reason(), Some(NoBreather::ForceTooWeak { .. })) && none.is_established());
/// # Ok::<(), vibrochain_breather::BreatherError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[must_use]
pub enum Completeness {
    /// The list holds all orbits.
    All(Proof),
    /// There are none.
    None {
        /// Why.
        reason: NoBreather,
        /// How that is known; not where the reason is that nothing could be worked out.
        by: Option<Proof>,
    },
    /// The list holds all that were asked for. Physical orbits that were not could live elsewhere
    /// ([`Wanted::SymmetricCandidates`](crate::Wanted)).
    Asked {
        /// Intervals of φ where they could.
        left_out: usize,
    },
    /// A word followed from masses without coupling, or with hardly any, whose orbits are all known: orbits that are not connected to
    /// those are missing.
    Followed {
        /// Combinations of orbits of the masses alone that were followed.
        starts: usize,
        /// Combinations, of phases as well, that were not tried, because there are too many or they take too much work, and branches
        /// that were not followed to an event that ends them.
        left: usize,
    },
    /// There may be more orbits than the list holds: at the places told, or one is beyond the range of numbers.
    Open {
        /// Places where two orbits may have merged (a fold) closer than rounding can tell.
        unresolved: usize,
        /// Intervals of φ (under several harmonics rectangles of φ and ψ) that were not searched because the budget for one
        /// point was spent (hundreds of solutions at very low frequency).
        exhausted: usize,
    },
}

impl Default for Completeness {
    /// Nothing has been searched.
    fn default() -> Self {
        Self::Open { unresolved: 0, exhausted: 0 }
    }
}

impl Completeness {
    /// By which means the list is known to hold all orbits.
    pub fn proof(self) -> Option<Proof> {
        match self {
            Self::All(proof) => Some(proof),
            Self::None { by, .. } => by,
            Self::Asked { .. } | Self::Followed { .. } | Self::Open { .. } => None,
        }
    }

    /// The list holds all orbits.
    pub fn is_established(self) -> bool {
        self.proof().is_some()
    }

    /// Why there are no orbits.
    pub fn reason(self) -> Option<NoBreather> {
        match self {
            Self::None { reason, .. } => Some(reason),
            _ => None,
        }
    }

    /// How many places of the search were left unresolved, and how many unsearched.
    pub fn open(self) -> (usize, usize) {
        match self {
            Self::Open { unresolved, exhausted } => (unresolved, exhausted),
            Self::Followed { left, .. } => (0, left),
            _ => (0, 0),
        }
    }
}

impl fmt::Display for Completeness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self, self.proof()) {
            (_, Some(proof)) => write!(f, "complete, by {proof}"),
            (Self::Followed { starts, .. }, _) => {
                let (branches, lead) = if *starts == 1 { ("branch", "leads") } else { ("branches", "lead") };
                write!(f, "what {starts} {branches} from masses without coupling {lead} to: others may exist")
            }
            (Self::Asked { .. }, _) => write!(f, "complete but for orbits that were not asked for"),
            _ => write!(f, "not shown to be complete"),
        }
    }
}
