//! What is found: borders, and what they leave unexplained.

use serde::Serialize;
use vibrochain_floquet::{Event, SpecialPoint};
use vibrochain_lattice::Parameter;

/// What happens on a border.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
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
    /// The acceleration after a plastic impact turns.
    Sticking,
    /// A harmonic of the orbit meets a mode.
    Resonance,
    /// Impulses grow without bound.
    Unbounded,
    /// All impulses vanish.
    ImpulsesVanish,
    /// The excess passes the threshold below which the scene counts as stable.
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
            Event::Sticking => Self::Sticking,
        }
    }
}

vibrochain_lattice::names!(BorderKind {
    Grazing "grazing", Pitchfork "pitchfork", PeriodDoubling "period-doubling", NeimarkSacker "neimark-sacker", Fold "fold",
    Sticking "sticking", Resonance "resonance", Unbounded "unbounded", ImpulsesVanish "impulses-vanish", Threshold "threshold", Change "change",
});

/// A point of a border.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BorderPoint {
    /// Values of both parameters.
    pub values: [f64; 2],
    /// Estimated error, as a part of the window's sides.
    pub error: f64,
    /// Half the width of the stripe whose edge it is, in the parameter along x, to digits of its own.
    pub half_width: Option<f64>,
}

/// Which stripe a border is an edge of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct StripeEdge {
    /// The two modes that meet, k ≤ l; k = l is one against itself.
    pub modes: (usize, usize),
    /// At which harmonic of the breather's frequency.
    pub harmonic: usize,
    /// Whether it is the edge with the larger values along x.
    pub upper: bool,
}

/// A border.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Border {
    /// Of which family or word, as the scene names it.
    pub family: String,
    /// What happens on it.
    #[serde(rename = "event")]
    pub kind: BorderKind,
    /// The stripe that it bounds, where that was found by its modes.
    pub stripe: Option<StripeEdge>,
    /// Points in their order; a closed border has its first one once more at the end.
    pub points: Vec<BorderPoint>,
    /// Points of codimension two, where they were asked for.
    pub special: Vec<SpecialPoint>,
    /// How it ends before the first and behind the last point.
    pub ends: [String; 2],
}

impl Border {
    /// Its parts with points that are new, from the last that is known to the next.
    pub(super) fn pieces(self, new: &[bool]) -> Vec<Self> {
        if new.iter().all(|new| *new) {
            return vec![self];
        }
        let mut pieces = Vec::new();
        let mut at = 0;
        while let Some(first) = new[at..].iter().position(|new| *new).map(|i| at + i) {
            let behind = new[first..].iter().position(|new| !*new).map_or(new.len(), |i| first + i);
            at = behind;
            let range = first.saturating_sub(1)..(behind + 1).min(new.len());
            let known = || "where it is known".to_owned();
            let begin = if range.start == 0 { self.ends[0].clone() } else { known() };
            let end = if range.end == new.len() { self.ends[1].clone() } else { known() };
            let special = self.special.iter().filter(|one| range.contains(&one.point));
            pieces.push(Self {
                points: self.points[range.clone()].to_vec(),
                special: special.map(|one| SpecialPoint { point: one.point - range.start, ..one.clone() }).collect(),
                ends: [begin, end],
                family: self.family.clone(),
                ..self
            });
        }
        pieces
    }
}

/// Two places that differ, with no border found between them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UnexplainedChange {
    /// Of which family or word, as the scene names it.
    pub family: String,
    /// The two places.
    pub between: [[f64; 2]; 2],
}

/// Stripes that could not be told from one another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MergedStripes {
    /// Of which family or word, as the scene names it.
    pub family: String,
    /// Between these values along x.
    pub range: [f64; 2],
    /// At this value along y.
    pub at: f64,
}

/// The borders of a window.
#[derive(Debug, Clone, PartialEq)]
pub struct Borders {
    /// Parameters along x and y.
    pub parameters: [Parameter; 2],
    /// All of them.
    pub borders: Vec<Border>,
    /// Changes between two places of the window for which there is no border.
    pub unexplained: Vec<UnexplainedChange>,
    /// Where stripes could not be told from one another.
    pub unresolved: Vec<MergedStripes>,
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
