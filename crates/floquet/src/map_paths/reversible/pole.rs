//! Poles e^{iφ}, by φ/2, and those of F with their residues.

use vibrochain_lattice::simd::lanes::{Lane, TWO, all, four};
use wide::f64x4;

use crate::map_paths::modes::Mode;

/// The half angle of a pole that pads a group of four: so far away that its residue, 0, is never heard of.
pub(crate) const FAR_ROOT: f64 = 1e50;

/// Where a pole is: d = cos φ, and |cos|, |sin| of φ/2, which know more digits of its distance from others.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Angle {
    pub(crate) d: f64,
    pub(crate) cos: f64,
    pub(crate) sin: f64,
}

impl Angle {
    pub(crate) fn new(cos: f64, sin: f64) -> Self {
        Self { d: (cos - sin) * (cos + sin), cos: cos.abs(), sin: sin.abs() }
    }

    /// By rising d.
    pub(crate) fn order(&self, other: &Self) -> std::cmp::Ordering {
        match (self.d < 0.0, other.d < 0.0) {
            (true, false) => std::cmp::Ordering::Less,
            (false, true) => std::cmp::Ordering::Greater,
            (true, true) => self.cos.total_cmp(&other.cos),
            (false, false) => other.sin.total_cmp(&self.sin),
        }
    }

    /// self − other, as a product of a sum and a difference of the smaller of sine and cosine, like in the residues: of
    /// opposite residues that grow as their poles come together only the product with the distance matters.
    pub(crate) fn distance(&self, other: &Self) -> f64 {
        if self.d < 0.0 {
            2.0 * (self.cos - other.cos) * (self.cos + other.cos)
        } else {
            2.0 * (other.sin - self.sin) * (other.sin + self.sin)
        }
    }

    /// self − others, given by their |c| and |s|.
    pub(crate) fn distances(&self, cos: &[Lane], sin: &[Lane], out: &mut Vec<Lane>) {
        out.clear();
        if self.d < 0.0 {
            let own = all(self.cos);
            out.extend(cos.iter().map(|other| (TWO * (own - four(*other)) * (own + four(*other))).to_array()));
        } else {
            let own = all(self.sin);
            out.extend(sin.iter().map(|other| (TWO * (four(*other) - own) * (four(*other) + own)).to_array()));
        }
    }
}

/// One pole of F before sorting.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pole {
    pub(crate) mode: u32,
    pub(crate) at: Angle,
    /// 2s² = 1 − d and 2c² = 1 + d, to full relative accuracy.
    pub(crate) below_one: f64,
    pub(crate) above_minus_one: f64,
    /// Error of the pole; it leaves 1 ∓ d their relative accuracy.
    pub(crate) shift: f64,
    pub(crate) residue: f64,
    pub(crate) error: f64,
}

impl Pole {
    pub(crate) fn new(mode: usize, cos: f64, sin: f64, shift: f64, residue: f64, error: f64) -> Self {
        let (below_one, above_minus_one) = (2.0 * sin * sin, 2.0 * cos * cos);
        let (at, shift) = (Angle::new(cos, sin), f64::EPSILON * shift);
        Self { mode: mode as u32, at, below_one, above_minus_one, shift, residue, error }
    }

    /// As [`Pole::new`], for the first `count` modes of a group that begins with mode `first`.
    pub(crate) fn push_group(
        poles: &mut Vec<Self>,
        first: usize,
        count: usize,
        modes: &Mode<f64x4>,
        residue: f64x4,
        error: f64x4,
    ) {
        let [cos, sin, shift] = [modes.cos, modes.sin, modes.shift].map(f64x4::to_array);
        let (residue, error) = (residue.to_array(), error.to_array());
        for i in 0..count {
            poles.push(Self::new(first + i, cos[i], sin[i], shift[i], residue[i], error[i]));
        }
    }
}
