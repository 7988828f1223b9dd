//! How a list of orbits is known to be complete.

use std::fmt;

/// By which means the orbits of a family at a point are known to be all there are.
///
/// It is the list of what was asked for ([`Finder::find_symmetric`](crate::Finder::find_symmetric) leaves a part out), and
/// of orbits that can be told apart: a doubled orbit, or an asymmetric double-sided one, from the simple or symmetric one that
/// it branches from as soon as its φ is 1e-7 of half the period away (conservative: 1e-6).
///
/// ```
/// use vibrochain_breather::{Completeness, Family, breathers};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4, 0.1, 0.9)?;
/// assert_eq!(breathers(&model, Family::SingleSided)?.completeness, Completeness::ClosedForm);
/// let searched = breathers(&model, Family::DoubleSided)?.completeness;
/// assert!(matches!(searched, Completeness::Enclosures { intervals } if intervals < 1000));
/// # Ok::<(), vibrochain_breather::BreatherError>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Completeness {
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
    /// Followed in γ₂ from masses without coupling, whose orbits are all known: those that are not connected to them are missing.
    Followed {
        /// Combinations of orbits of the masses alone that were followed.
        starts: usize,
    },
    /// Not established: a place may hold two merged orbits (`Found::unresolved`), a part was not searched
    /// (`Found::exhausted`), or an orbit is beyond the range of numbers.
    #[default]
    NotEstablished,
}

impl Completeness {
    /// The list holds all orbits.
    pub fn is_established(self) -> bool {
        !matches!(self, Self::NotEstablished | Self::Followed { .. })
    }

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::ClosedForm => "closed-form",
            Self::Enclosures { .. } => "enclosures",
            Self::BranchAndPrune { .. } => "branch-and-prune",
            Self::Reversible => "reversible",
            Self::Followed { .. } => "followed",
            Self::NotEstablished => "not-established",
        }
    }
}

impl fmt::Display for Completeness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ClosedForm => write!(f, "complete, by closed form"),
            Self::Enclosures { intervals } => write!(f, "complete, by enclosures on {intervals} intervals"),
            Self::BranchAndPrune { boxes } => write!(f, "complete, by branch and prune in the plane, {boxes} boxes"),
            Self::Reversible => write!(f, "complete among orbits symmetric in time, by closed form"),
            Self::Followed { starts } => {
                let (branches, lead) = if *starts == 1 { ("branch", "leads") } else { ("branches", "lead") };
                write!(f, "what {starts} {branches} from masses without coupling {lead} to: others may exist")
            }
            Self::NotEstablished => write!(f, "not shown to be complete"),
        }
    }
}
