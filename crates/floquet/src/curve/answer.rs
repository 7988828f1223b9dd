//! What is asked of a curve, and what it holds.

use std::fmt;

use thiserror::Error;
use vibrochain_breather::{BranchError, BreatherError, Orbit};
use vibrochain_lattice::{Resonance, Short, Stop, Stopped};

use crate::locate::{Event, Evidence};

/// A point within this many tolerances of a curve, with impulses that agree to this part, is one of it.
const ON_IT: f64 = 2.0;
const ALIKE: f64 = 1e-3;

/// A rectangle in the plane of two numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Window {
    /// Least values.
    pub from: [f64; 2],
    /// Largest values.
    pub to: [f64; 2],
}

impl Window {
    /// The lengths of its sides.
    #[must_use]
    pub fn sides(&self) -> [f64; 2] {
        [0, 1].map(|i| self.to[i] - self.from[i])
    }

    /// A place as parts of both sides.
    #[must_use]
    pub fn parts(&self, values: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| (values[i] - self.from[i]) / (self.to[i] - self.from[i]))
    }

    /// Whether a place is in it.
    #[must_use]
    pub fn holds(&self, values: [f64; 2]) -> bool {
        (0..2).all(|i| (self.from[i]..=self.to[i]).contains(&values[i]))
    }
}

/// How a curve is followed.
#[derive(Clone)]
#[must_use]
pub struct Walk<'a> {
    /// Where to.
    pub window: Window,
    /// How far a straight line between neighbouring points may be from the curve, as a part of the window's sides.
    pub tolerance: f64,
    /// Whether points of codimension two are looked for on the way. Without them a curve takes a fraction of the time.
    pub special: bool,
    /// Told of each point its values and whether the orbit there is physical: whether the curve need go no farther.
    pub until: &'a dyn Fn([f64; 2], Option<bool>) -> bool,
    /// Ends the work, looked at before every orbit and every eigenvalue problem: there is no curve then.
    pub stop: Stop,
}

impl Walk<'_> {
    /// Through the whole window, with all points of codimension two.
    pub fn new(window: Window, tolerance: f64) -> Self {
        Self { window, tolerance, special: true, until: &|_, _| false, stop: Stop::default() }
    }
}

impl fmt::Debug for Walk<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { window, tolerance, special, .. } = self;
        let mut shown = f.debug_struct("Walk");
        shown.field("window", window).field("tolerance", tolerance).field("special", special).finish_non_exhaustive()
    }
}

/// A point of a curve.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CurvePoint {
    /// Values of both parameters.
    pub values: [f64; 2],
    /// Estimated error: how far the curve may pass from it, as a part of the window's sides.
    pub error: f64,
    /// The angle, over π, of the pair of multipliers that meets the circle, at a Neimark–Sacker point.
    pub angle: Option<f64>,
    /// Whether the orbit is physical, touches of the event itself aside; `None` where that cannot be told.
    pub physical: Option<bool>,
    /// The orbit there.
    #[cfg_attr(feature = "serde", serde(flatten, serialize_with = "crate::serde_impl::of_curve"))]
    pub orbit: Orbit,
}

/// What else happens at a point of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Special {
    /// Two multipliers +1.
    OneToOne,
    /// Two multipliers −1.
    OneToTwo,
    /// A pair e^{±2πi/3}.
    OneToThree,
    /// A pair ±i.
    OneToFour,
    /// Two folds meet; the curve stands still in both parameters.
    Cusp,
    /// Another event happens at the same orbit.
    With(Event),
}

impl fmt::Display for Special {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::OneToOne => "1:1",
            Self::OneToTwo => "1:2",
            Self::OneToThree => "1:3",
            Self::OneToFour => "1:4",
            Self::Cusp => "cusp",
            Self::With(event) => event.name(),
        })
    }
}

/// A point of codimension two.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SpecialPoint {
    /// What happens there besides.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::serde_impl::text"))]
    pub special: Special,
    /// Which of the curve's points it is.
    pub point: usize,
    /// Values of both parameters.
    pub values: [f64; 2],
    /// Between which two lengths of the curve it was enclosed, as a part of the window's sides.
    pub error: f64,
}

/// How a curve ends.
#[derive(Debug, Clone, PartialEq)]
pub enum CurveEnd {
    /// At the edge of the window.
    Edge,
    /// At the edge of the window where masses are not coupled, γ₂ = 0, or within 1e-4 of it, a part of the window's side: multipliers of
    /// modes become as one there, and no curve of theirs is known any nearer.
    Uncoupled,
    /// Where it began: a closed curve.
    Closed,
    /// At a point of codimension two, beyond which no such event is: the pair of multipliers becomes real.
    Special(Special),
    /// A harmonic of the orbit meets a mode.
    Resonance(Resonance),
    /// Both edges of a stripe are so near to each other that they cannot be told apart.
    Thin,
    /// All impulses vanish.
    ImpulsesVanish,
    /// The impulses grow without bound.
    Unbounded,
    /// Where it need go no farther.
    Halted,
    /// It is followed no farther than so many points.
    Long,
    /// Newton's method lost the orbit.
    Lost(BranchError),
}

impl fmt::Display for CurveEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Edge => f.write_str("at the edge of the window"),
            Self::Uncoupled => f.write_str("where masses are not coupled"),
            Self::Closed => f.write_str("where it began: it is closed"),
            Self::Special(special) => write!(f, "where the pair becomes real ({special})"),
            Self::Resonance(resonance) => write!(f, "at a resonance: {resonance}"),
            Self::Thin => f.write_str("where the stripe is too thin for its edges to be told apart"),
            Self::ImpulsesVanish => f.write_str("where all impulses vanish"),
            Self::Unbounded => f.write_str("where impulses grow without bound"),
            Self::Halted => f.write_str("where it need go no farther"),
            Self::Long => f.write_str("unfinished: it is too long"),
            Self::Lost(error) => write!(f, "lost: {error}"),
        }
    }
}

/// The curve of an event in a window.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[must_use]
pub struct EventCurve {
    /// Which event.
    pub event: Event,
    /// What showed it where the curve was taken up.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub evidence: Evidence,
    /// Points in their order; a closed curve has its first one once more at the end.
    pub points: Vec<CurvePoint>,
    /// Points of codimension two among them, in their order.
    pub special: Vec<SpecialPoint>,
    /// How it ends before the first and behind the last point.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::serde_impl::texts"))]
    pub ends: [CurveEnd; 2],
    /// Orbits assembled.
    pub evaluations: usize,
    /// Eigenvalue problems solved.
    pub spectra: usize,
}

impl EventCurve {
    /// Whether an orbit at a place is one of it, as far as places and impulses tell: within a few tolerances.
    pub fn passes(&self, (place, orbit): ([f64; 2], &Orbit), &Walk { window, tolerance, .. }: &Walk<'_>) -> bool {
        let parts = |values: [f64; 2]| window.parts(values);
        let (place, own) = (parts(place), orbit.impulses());
        let strongest = own.iter().fold(0.0_f64, |most, one| most.max(one.abs()));
        self.points.windows(2).any(|pair| {
            let [from, to] = [&pair[0], &pair[1]].map(|point| parts(point.values));
            let (chord, away) = ([to[0] - from[0], to[1] - from[1]], [place[0] - from[0], place[1] - from[1]]);
            let square = chord[0] * chord[0] + chord[1] * chord[1];
            let share = ((away[0] * chord[0] + away[1] * chord[1]) / square).clamp(0.0, 1.0);
            let apart = (away[0] - share * chord[0]).hypot(away[1] - share * chord[1]);
            let (a, b) = (pair[0].orbit.impulses(), pair[1].orbit.impulses());
            apart <= ON_IT * tolerance
                && own.len() == a.len()
                && own.len() == b.len()
                && own
                    .iter()
                    .zip(a.iter().zip(&b))
                    .all(|(own, (a, b))| (a + share * (b - a) - own).abs() <= ALIKE * strongest)
        })
    }
}

/// Why a curve could not be followed at all.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CurveError {
    /// The event is not in the window.
    #[error("{name} = {} is not in the window from {} to {}: give one around the start", Short(*value), Short(*from), Short(*to))]
    Outside {
        /// The number that is not.
        name: String,
        /// Its value.
        value: f64,
        /// Least value of the window.
        from: f64,
        /// Largest value.
        to: f64,
    },
    /// Both axes have the same number.
    #[error("both parameters are {0}: a curve needs two")]
    Same(String),
    /// It brings a load to an orbit without one, which has no phase to begin with.
    #[error(
        "an orbit without a load has no {0}: vary what brings none, as a stiffness, a frequency or a barrier, or start under a load"
    )]
    NoLoad(String),
    /// Not two numbers vary.
    #[error("{0} numbers vary: a curve needs two")]
    Numbers(usize),
    /// The tolerance is no number that steps could keep to.
    #[error("a tolerance of {0} is out of range: give one from 1e-12 to 0.01 of the window's sides")]
    Tolerance(f64),
    /// The start is not on the curve.
    #[error("no {} could be found next to the start", .0.name())]
    NotThere(Event),
    /// There are no orbits to follow.
    #[error(transparent)]
    Branch(#[from] BranchError),
}

impl From<Stopped> for CurveError {
    fn from(stopped: Stopped) -> Self {
        Self::Branch(BranchError::from(BreatherError::from(stopped)))
    }
}
