//! What is looked for, and what is found.

use std::fmt;

use nalgebra::Complex;
use thiserror::Error;
use vibrochain_breather::{Approach, BranchError, BreatherError, ContactOrbit, Orbit};
use vibrochain_lattice::{Parameter, Resonance, Short, Stopped};

use crate::error::FloquetError;
use crate::verdict::Verdict;

/// What is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Event {
    /// A mass touches a barrier from inside, or the velocity before an impact vanishes.
    Grazing,
    /// A multiplier +1 where the branch goes on. Another one branches off, unless a conservative orbit's energy is extreme.
    Pitchfork,
    /// A multiplier −1.
    PeriodDoubling,
    /// A complex pair of multipliers crosses the circle (without loss: two pairs collide on it).
    NeimarkSacker,
    /// The branch turns back in the parameter; a multiplier +1.
    Fold,
    /// The acceleration after a plastic impact turns: the contact begins to rest on its barrier.
    Sticking,
}

vibrochain_lattice::names!(Event {
    Grazing "grazing", Pitchfork "pitchfork", PeriodDoubling "period-doubling", NeimarkSacker "neimark-sacker", Fold "fold",
    Sticking "sticking",
});

/// A search: what, in which parameter, how far.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
pub struct Search {
    /// What is looked for.
    pub event: Event,
    /// The parameter that is varied; the orbit has its start.
    pub free: Parameter,
    /// Least value to go to.
    pub from: f64,
    /// Largest value to go to.
    pub to: f64,
}

impl Search {
    /// A search over the default range of the parameter: half to twice the start of a stiffness, frequency or amplitude (0
    /// to 1 for one that starts at 0), 0 to 0.99 of the asymmetry, 0.05 to 1 of the restitution; in any case with the
    /// start inside.
    pub fn new(orbit: &Orbit, event: Event, free: Parameter) -> Self {
        // An orbit of no lattice has no such parameter: it is refused when it is searched for.
        let start = orbit.model().map_or(0.0, |model| model.get(free));
        let (from, to) = match free {
            Parameter::Asymmetry => (0.0, 0.99),
            Parameter::Restitution => (0.05, 1.0),
            _ if start == 0.0 => (0.0, 1.0),
            _ => (0.5 * start, 2.0 * start),
        };
        Self { event, free, from: start.min(from), to: start.max(to) }
    }
}

/// What shows the event at the point found.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Evidence {
    /// The multiplier that meets the circle, as computed at the point.
    Multiplier(
        #[cfg_attr(
            feature = "serde",
            serde(serialize_with = "crate::serde_impl::complex", deserialize_with = "crate::serde_impl::read_complex")
        )]
        Complex<f64>,
    ),
    /// The mass that touches a barrier, and when.
    Touch(Approach),
    /// Index of the impact whose velocity vanishes, or after which the acceleration does.
    Impact(usize),
}

impl Evidence {
    /// The same of the orbit begun with another one of its impacts.
    pub(super) fn begun_with(self, first: usize, orbit: &ContactOrbit) -> Self {
        let impacts = orbit.impacts();
        let since = impacts.get(first).map_or(0.0, |impact| impact.time);
        match self {
            Self::Impact(impact) => Self::Impact((impact + impacts.len() - first) % impacts.len()),
            Self::Touch(touch) if since > 0.0 => {
                Self::Touch(Approach { time: (touch.time - since).rem_euclid(orbit.period()), ..touch })
            }
            other => other,
        }
    }
}

/// An orbit that branches off.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct BranchedOrbit {
    /// The orbit.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub orbit: Orbit,
    /// Whether it is physical there; `None` where that cannot be told.
    pub physical: Option<bool>,
    /// Its stability, where it can be judged.
    #[cfg_attr(feature = "serde", serde(rename = "stability"))]
    pub verdict: Option<Verdict>,
}

/// The orbits that branch off, at one value of the parameter.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Branching {
    /// The value, a small step from the bifurcation.
    pub value: f64,
    /// They exist for larger values (otherwise for smaller ones).
    #[cfg_attr(feature = "serde", serde(rename = "side", serialize_with = "crate::serde_impl::side"))]
    pub above: bool,
    /// The doubled orbit, or the asymmetric pair.
    pub orbits: Vec<BranchedOrbit>,
}

/// The orbit beside an event.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct EventSide {
    /// Value of the free parameter.
    pub value: f64,
    /// Whether it is stable, if it is physical at all.
    pub stability: Verdict,
    /// Whether it is physical, where that can be told.
    pub physical: Option<bool>,
}

impl fmt::Display for EventSide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let not = if self.physical == Some(false) { "not physical, " } else { "" };
        write!(f, "{not}{}", self.stability)
    }
}

/// An event that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Located {
    /// Which event.
    pub event: Event,
    /// Value of the free parameter.
    pub value: f64,
    /// Its estimated error.
    pub error: f64,
    /// The orbit there.
    pub orbit: Orbit,
    /// What shows the event.
    pub evidence: Evidence,
    /// Whether the orbit there is physical, where that can be told; at grazing a matter of rounding.
    pub physical: Option<bool>,
    /// The orbits a small step away on either side in the parameter, as far as they exist there.
    pub sides: Vec<EventSide>,
    /// The orbits that branch off, at a period doubling or pitchfork.
    pub branching: Option<Branching>,
    /// Orbits assembled between the start and this answer.
    pub evaluations: usize,
}

/// A stretch of the branch over which what vanishes at an event changes its sign, but rounding moves the zero farther than the
/// distance over which the sign was seen to change: no point can be claimed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unresolved {
    /// Least value of the free parameter.
    pub from: f64,
    /// Largest value.
    pub to: f64,
}

/// How the way in one direction ended.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// At the end of the range.
    Range,
    /// The branch turns back in a fold, with its estimated error.
    Fold {
        /// Estimated error of the value.
        error: f64,
    },
    /// It is back where it was started: a closed curve.
    Closed,
    /// The branch of asymmetric orbits ends on the symmetric one.
    Pitchfork,
    /// The branch of doubled orbits ends on those of half their period.
    PeriodDoubling,
    /// A harmonic of the orbit meets a mode.
    Resonance(Resonance),
    /// The impulses grow without bound: the conditions at the impacts become singular.
    Unbounded,
    /// All impulses vanish: the breather ends on the motion that the force drives alone, which touches the barrier there.
    ImpulsesVanish,
    /// Two impacts come together and vanish: the branch ends at a grazing of the orbits without them.
    Grazing,
    /// Newton's method lost the branch.
    Lost(BranchError),
    /// What was to be watched could not be computed any further.
    Unwatched(FloquetError),
}

impl End {
    /// The name used in files: `range`, `fold`, `closed`, `symmetric`, `period-doubling`, `resonance`, `unbounded`,
    /// `impulses-vanish`, `grazing`, `lost` or `unwatched`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Range => "range",
            Self::Fold { .. } => "fold",
            Self::Closed => "closed",
            Self::Pitchfork => "symmetric",
            Self::PeriodDoubling => "period-doubling",
            Self::Resonance(_) => "resonance",
            Self::Unbounded => "unbounded",
            Self::ImpulsesVanish => "impulses-vanish",
            Self::Grazing => "grazing",
            Self::Lost(_) => "lost",
            Self::Unwatched(_) => "unwatched",
        }
    }
}

/// The answer to a search.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct Answer {
    /// All events on the branch between the ends, the one nearest to the start first.
    pub located: Vec<Located>,
    /// Where there may be more, hidden by rounding.
    pub unresolved: Vec<Unresolved>,
    /// Where and how the ways down and up ended.
    pub ends: [(f64, End); 2],
    /// Orbits assembled.
    pub evaluations: usize,
    /// Eigenvalue problems solved.
    pub spectra: usize,
}

/// Why a search could not be made. An event that is not there is an answer, see [`End`].
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LocateError {
    /// The range does not hold the start, or a parameter is out of range.
    #[error("{} = {} is not in a range from {} to {}: search a range with from < to around the start",
        free.name(), Short(*start), Short(*from), Short(*to))]
    Range {
        /// The free parameter.
        free: Parameter,
        /// Where it starts.
        start: f64,
        /// Least value asked for.
        from: f64,
        /// Largest value asked for.
        to: f64,
    },
    /// The range is so short that rounding of the parameter shows in every step.
    #[error("the range of {} from {from} to {to} is shorter than 1e-9 of its start: too short for a branch to be followed, give a longer one",
        free.name())]
    Short {
        /// The free parameter.
        free: Parameter,
        /// Least value asked for.
        from: f64,
        /// Largest value asked for.
        to: f64,
    },
    /// The free parameter is one the orbit does not depend on or must not have.
    #[error("a conservative orbit has no {}: free gamma1, gamma2, omega or asymmetry, or start under a force", free.name())]
    NoForce {
        /// The free parameter.
        free: Parameter,
    },
    /// The ring has no multiplier that could meet the circle.
    #[error("this orbit has no multiplier that moves: a single mass without force keeps its trivial pair alone")]
    NoMultiplier,
    /// Whoever asked does not wait any longer.
    #[error("the search was stopped")]
    Stopped,
    /// The orbit cannot be followed.
    #[error(transparent)]
    Branch(#[from] BranchError),
    /// The multipliers cannot be computed.
    #[error(transparent)]
    Floquet(#[from] FloquetError),
}

impl From<BreatherError> for LocateError {
    fn from(error: BreatherError) -> Self {
        Self::Branch(error.into())
    }
}

impl From<Stopped> for LocateError {
    fn from(Stopped: Stopped) -> Self {
        Self::Stopped
    }
}
