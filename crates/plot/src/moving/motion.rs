//! A chain that moves, as values.

use std::path::Path;

/// Kinds of files that move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moving {
    /// Pixels of at most 256 colours; everything shows them.
    Gif,
    /// Pixels; what does not know how shows the first picture.
    Png,
    /// Vectors.
    Svg,
}

vibrochain_lattice::names!(Moving { Gif "gif", Png "png", Svg "svg" });

impl Moving {
    /// By the file's ending, `.gif`, `.png` or `.svg`.
    pub fn of(path: &Path) -> Option<Self> {
        Self::from_name(&path.extension()?.to_str()?.to_ascii_lowercase())
    }
}

/// All masses at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Instant {
    /// Displacements, layer by layer.
    pub displacement: Vec<f64>,
    /// Masses that have met a barrier since the instant before: site through all layers, and whether it was the upper one.
    pub impacts: Vec<(usize, bool)>,
}

/// A chain that moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// Line above it.
    pub title: String,
    /// Positions of the two barriers.
    pub barriers: (f64, f64),
    /// Masses of one layer.
    pub length: usize,
    /// The site on the left, −⌊(M−1)/2⌋ on a ring, otherwise 0.
    pub lowest: i64,
    /// What is shown, at equal distances in time; at the end it begins again.
    pub instants: Vec<Instant>,
}

/// The most masses that can be told apart, and the most layers.
pub const MOST_MASSES: usize = 400;
pub(crate) const MOST_LAYERS: usize = 8;

/// Pictures a second.
pub(crate) const RATE: f64 = 25.0;
