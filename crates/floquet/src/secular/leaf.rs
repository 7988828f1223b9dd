//! A neighbourhood of poles of a large ring, and the field of all others in it.

use std::ops::Range;

use super::cauchy::Nodal;
use vibrochain_breather::lanes::Lane;

/// The gaps of one leaf of the tree over the poles, each gap named by the place of its left pole.
#[derive(Debug, Clone)]
pub(crate) struct Leaf {
    pub(super) gaps: Range<usize>,
    pub(super) residues: Vec<Lane>,
    pub(super) errors: Vec<Lane>,
    pub(super) shifts: Vec<Lane>,
    pub(super) cos: Vec<Lane>,
    pub(super) sin: Vec<Lane>,
    pub(super) middle: f64,
    /// The field of far poles and its derivatives in u = (ν − middle)·scale, and the error of the field.
    pub(crate) scale: f64,
    pub(crate) value: Nodal,
    pub(crate) slope: Nodal,
    pub(crate) bend: Nodal,
    pub(crate) noise: f64,
    /// The part of it that is not due to errors of the residues.
    pub(crate) rounding: f64,
}
