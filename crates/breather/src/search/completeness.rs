//! What is known of a list of orbits: that it holds all there are, why there are none, or what it may lack.
//!
//! Every search tells what it has done ([`Searched`]); whether its list may be called complete is decided here alone.

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
}

impl Proof {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::ClosedForm => "closed-form",
            Self::Enclosures { .. } => "enclosures",
            Self::BranchAndPrune { .. } => "branch-and-prune",
        }
    }
}

impl fmt::Display for Proof {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ClosedForm => write!(f, "closed form"),
            Self::Enclosures { intervals } => write!(f, "enclosures on {intervals} intervals"),
            Self::BranchAndPrune { boxes } => write!(f, "branch and prune in the plane, {boxes} boxes"),
        }
    }
}

/// What is known of a list of orbits.
///
/// It is the list of what was asked for ([`Finder::find_symmetric`](crate::Finder::find_symmetric) leaves a part out), and
/// of orbits that can be told apart: a doubled orbit, or an asymmetric double-sided one, from the simple or symmetric one that
/// it branches from as soon as its φ is 1e-7 of half the period away (conservative: 1e-6, and as far from two instants that are one), and two impacts on
/// one barrier from one as soon as they are 1e-7 of half the period apart, with a dashpot 1e-4 of the period.
///
/// ```
/// use vibrochain_breather::{Completeness, Family, NoBreather, Proof, breathers};
/// use vibrochain_lattice::{Chain, Model, Point};
/// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
/// let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model()?;
/// assert_eq!(breathers(&model, Family::SingleSided)?.completeness, Completeness::All(Proof::ClosedForm));
/// let searched = breathers(&model, Family::DoubleSided)?.completeness;
/// assert!(matches!(searched, Completeness::All(Proof::Enclosures { intervals }) if intervals < 1000));
/// let weak = model.chain().point().omega(1.5).asymmetry(0.4).amplitude(1e-6).restitution(0.9).model()?;
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
    /// ([`Scope::SymmetricCandidates`](crate::Scope)).
    Asked {
        /// Intervals of φ where they could.
        left_out: usize,
    },
    /// A word of which starts have led to these: Newton's method at the point, and branches from masses without coupling, or with hardly any,
    /// whose orbits are all known. Others may exist.
    Followed {
        /// Starts at the point, and combinations of orbits of the masses alone that were followed.
        starts: usize,
        /// Combinations, of phases as well, that were not tried, because there are too many or they take too much work, and branches
        /// that were not followed to an event that ends them.
        left: usize,
    },
    /// The list holds the orbits without a force whose instants are half a period apart, by closed form. Others were not sought.
    HalfPeriod,
    /// The search has looked for zeros of a function of one variable in so many places. It may have missed two orbits between neighbouring places.
    Scanned {
        /// How many.
        places: usize,
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

/// What a search has done for its list: all that [`Completeness::of`] looks at.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Searched {
    /// Orbits that are listed.
    pub(crate) listed: usize,
    /// Solutions that are not, because they cannot be physical.
    pub(crate) refused: usize,
    /// Solutions of which no orbit of finite numbers could be made.
    pub(crate) lost: usize,
    /// Intervals enclosed, and boxes.
    pub(crate) intervals: usize,
    pub(crate) boxes: usize,
    /// Places where two orbits may have merged, and those not searched because the budget was spent.
    pub(crate) unresolved: usize,
    pub(crate) exhausted: usize,
    /// Places of physical orbits that were not asked for.
    pub(crate) left_out: usize,
    /// Why there is none.
    pub(crate) reason: Option<NoBreather>,
    /// How many times as large loads have to be for a phase to exist.
    pub(crate) too_weak: Option<f64>,
    /// What has been looked at, where others may exist.
    pub(crate) partial: Option<Partial>,
}

/// What a search has looked at that does not cover all orbits of its kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Partial {
    /// Instants half a period apart.
    HalfPeriod,
    /// A function of one variable in so many places.
    Places(usize),
    /// What so many starts lead to.
    Starts(usize),
}

impl Searched {
    /// A search that covers a part of the orbits.
    pub(crate) fn partial(partial: Partial) -> Self {
        Self { partial: Some(partial), ..Self::default() }
    }

    /// Places left open; `None` where they are not known.
    pub(crate) fn left_open(&self) -> Option<usize> {
        self.partial.is_none().then_some(self.unresolved + self.exhausted)
    }

    /// No orbit can be missing.
    pub(crate) fn is_complete(&self) -> bool {
        self.left_open() == Some(0)
    }
}

impl NoBreather {
    /// A search that ends with this reason has looked everywhere, or need not have: no orbit can be there.
    fn is_conclusive(self) -> bool {
        match self {
            Self::LossWithoutForce
            | Self::NeedsForce
            | Self::NetImpulse
            | Self::ForceTooWeak { .. }
            | Self::NoPhase
            | Self::NoTimes
            | Self::NothingPushes
            | Self::RepeatsSooner => true,
            Self::Singular | Self::NoStart | Self::BranchesEnded | Self::NotSearched(_) => false,
        }
    }
}

impl Completeness {
    /// What is known of the list of a search.
    pub(crate) fn of(searched: &Searched) -> Self {
        let &Searched {
            listed, refused, lost, intervals, boxes, unresolved, exhausted, left_out, reason, partial, ..
        } = searched;
        match partial {
            Some(Partial::HalfPeriod) => return Self::HalfPeriod,
            Some(Partial::Places(places)) => return Self::Scanned { places },
            Some(Partial::Starts(starts)) => return Self::Followed { starts, left: 0 },
            None => {}
        }
        let proof = match (intervals, boxes) {
            (0, 0) => Proof::ClosedForm,
            (intervals, 0) => Proof::Enclosures { intervals },
            (_, boxes) => Proof::BranchAndPrune { boxes },
        };
        let solved = listed + refused > 0;
        // Where the conditions are singular, solutions can be lost.
        let lost = lost > 0 || reason.is_some_and(|reason| !reason.is_conclusive());
        match reason {
            _ if unresolved + exhausted > 0 => Self::Open { unresolved, exhausted },
            _ if left_out > 0 => Self::Asked { left_out },
            _ if solved && lost => Self::default(),
            _ if solved => Self::All(proof),
            Some(reason) if !lost => Self::None { reason, by: Some(proof) },
            Some(reason) if !reason.is_conclusive() => Self::None { reason, by: None },
            _ => Self::None { reason: NoBreather::Singular, by: None },
        }
    }

    /// Of a list that needs no search, because there can be none.
    pub(crate) fn none(reason: NoBreather) -> Self {
        Self::of(&Searched { reason: Some(reason), ..Searched::default() })
    }

    /// Of a list that is empty for a reason that does not hold for all orbits of its kind.
    pub(crate) fn not_reached(reason: NoBreather) -> Self {
        Self::None { reason, by: None }
    }

    /// Of a list of so many orbits that so many starts have led to, others being `left`.
    pub(crate) fn followed(listed: usize, starts: usize, left: usize) -> Self {
        match (listed, left, starts) {
            (0, 0, 0) => Self::not_reached(NoBreather::NoStart),
            (0, 0, _) => Self::not_reached(NoBreather::BranchesEnded),
            _ => Self::Followed { starts, left },
        }
    }
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
            Self::Asked { .. }
            | Self::Followed { .. }
            | Self::HalfPeriod
            | Self::Scanned { .. }
            | Self::Open { .. } => None,
        }
    }

    /// The name in files of what the list rests on; `None` where that is nothing, or not all of it.
    pub fn means(self) -> Option<&'static str> {
        match self {
            Self::Followed { .. } => Some("followed"),
            Self::HalfPeriod => Some("half-period"),
            Self::Scanned { .. } => Some("scan"),
            _ => self.proof().map(Proof::name),
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
                let (what, lead) = if *starts == 1 { ("start", "leads") } else { ("starts", "lead") };
                write!(f, "what {starts} {what} {lead} to: others may exist")
            }
            (Self::HalfPeriod, _) => write!(f, "of instants half a period apart alone: others may exist"),
            (Self::Scanned { places }, _) => {
                write!(f, "what a function of one variable shows in {places} places: others may exist between them")
            }
            (Self::Asked { .. }, _) => write!(f, "complete but for orbits that were not asked for"),
            _ => write!(f, "not shown to be complete"),
        }
    }
}
