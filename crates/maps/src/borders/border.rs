//! What is found: borders, and what they leave unexplained.

use std::fmt;

use vibrochain_floquet::{Event, Special};
use vibrochain_lattice::Parameter;

/// What happens on a border.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BorderKind {
    /// A mass touches a barrier from inside, or an impact loses its velocity.
    Grazing,
    /// A multiplier +1.
    Pitchfork,
    /// A multiplier −1.
    PeriodDoubling,
    /// A pair of multipliers leaves the circle.
    NeimarkSacker,
    /// Two orbits merge.
    Fold,
    /// A harmonic of the orbit meets a mode.
    Resonance,
    /// Impulses grow without bound.
    Unbounded,
    /// All impulses vanish.
    ImpulsesVanish,
    /// The growth passes the threshold below which the scene counts as stable.
    Threshold,
    /// What lives there changes; by which event is not known.
    Change,
}

impl From<Event> for BorderKind {
    fn from(event: Event) -> Self {
        match event {
            Event::Grazing => Self::Grazing,
            Event::Pitchfork => Self::Pitchfork,
            Event::PeriodDoubling => Self::PeriodDoubling,
            Event::NeimarkSacker => Self::NeimarkSacker,
            Event::Fold => Self::Fold,
        }
    }
}

impl BorderKind {
    /// The name in files, for events that of [`Event`].
    pub fn name(self) -> &'static str {
        match self {
            Self::Grazing => Event::Grazing.name(),
            Self::Pitchfork => Event::Pitchfork.name(),
            Self::PeriodDoubling => Event::PeriodDoubling.name(),
            Self::NeimarkSacker => Event::NeimarkSacker.name(),
            Self::Fold => Event::Fold.name(),
            Self::Resonance => "resonance",
            Self::Unbounded => "unbounded",
            Self::ImpulsesVanish => "impulses-vanish",
            Self::Threshold => "threshold",
            Self::Change => "change",
        }
    }
}

impl fmt::Display for BorderKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A point of a border.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BorderPoint {
    /// Values of both parameters.
    pub values: [f64; 2],
    /// Estimated error, as a part of the window's sides.
    pub error: f64,
    /// Half the width of the stripe whose edge it is, in the parameter along x, to digits of its own.
    pub half_width: Option<f64>,
}

/// Which stripe a border is an edge of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StripeEdge {
    /// The two modes that meet, k ≤ l; k = l is one against itself.
    pub modes: (usize, usize),
    /// At which harmonic of the breather's frequency.
    pub harmonic: usize,
    /// Whether it is the edge with the larger values along x.
    pub upper: bool,
}

/// A border.
#[derive(Debug, Clone, PartialEq)]
pub struct Border {
    /// Of which family or word, as the scene names it.
    pub family: String,
    /// What happens on it.
    pub kind: BorderKind,
    /// The stripe that it bounds, where that was found by its modes.
    pub stripe: Option<StripeEdge>,
    /// Points in their order; a closed border has its first one once more at the end.
    pub points: Vec<BorderPoint>,
    /// Points of codimension two, where they were asked for: what, which of the points, and its error as a part of the window's sides.
    pub special: Vec<(Special, usize, f64)>,
    /// How it ends before the first and behind the last point.
    pub ends: [String; 2],
}

/// The borders of a window.
#[derive(Debug, Clone, PartialEq)]
pub struct Borders {
    /// Parameters along x and y.
    pub parameters: [Parameter; 2],
    /// All of them.
    pub borders: Vec<Border>,
    /// Changes between two places of the window for which there is no border: family, and the two places.
    pub unexplained: Vec<(String, [[f64; 2]; 2])>,
    /// Between these values along x, at that along y, stripes could not be told from one another.
    pub unresolved: Vec<(String, [f64; 2], f64)>,
    /// How many places were looked at.
    pub places: usize,
    /// The search was ended before its end.
    pub interrupted: bool,
}

impl Borders {
    /// Each border as its points, as [`Regions`](crate::regions::Regions) wants them.
    pub fn lines(&self) -> Vec<Vec<[f64; 2]>> {
        self.borders.iter().map(|border| border.points.iter().map(|point| point.values).collect()).collect()
    }

    /// Stripes among them, each with both edges.
    pub fn stripes(&self) -> usize {
        self.borders.iter().filter(|border| border.stripe.is_some_and(|stripe| stripe.upper)).count()
    }
}
