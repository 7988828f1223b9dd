//! What is asked of borders, and what is told of the search.

use vibrochain_lattice::Stop;

/// What is under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The coarse look: places.
    Places,
    /// Stripes by themselves: rows.
    Rows,
    /// Changes between places: those explained.
    Changes,
    /// What is left in the faces between borders: faces.
    Faces,
}

/// How well, how far and how long borders are searched for.
#[derive(Clone, Copy)]
pub struct BorderRequest<'a> {
    /// How far a straight line between neighbouring points may be from the border, as a part of the window's sides.
    pub tolerance: f64,
    /// Places of the window, spread by area, that are asked what lives there to find what is missing.
    pub places: usize,
    /// Whether points of codimension two are wanted.
    pub special: bool,
    /// Raised to end the search; what is found by then is told.
    pub stop: &'a Stop,
    /// Told of the family, the stage, and how much of it is done.
    pub told: &'a (dyn Fn(&str, Stage, usize, usize) + Sync),
}
