//! A function by poles d and charges q, Σ q/(ν−d), in the neighbourhood of some poles of a large ring: these one by one, the others as a
//! polynomial (see [`super::cauchy`]), so that a value costs the same for any number of modes.

use std::ops::Range;

use nalgebra::Complex;

use super::cauchy::{NODES, Nodal, Tree, derivative};
use super::pole::{Angle, FAR_ROOT};
use vibrochain_breather::lanes::{Lane, room};

/// One pole as a source of `N − 1` fields.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChargedPole<const N: usize> {
    pub(super) at: Angle,
    /// What the error of the pole is known by.
    pub(super) shift: f64,
    /// One charge a field and, last, the error of the charges.
    pub(super) charges: [f64; N],
}

/// Poles one by one, in groups of four, and the field of those left out. Of a tree over many poles it serves the gaps of one leaf, each
/// gap named by the place of its left pole.
#[derive(Debug, Clone)]
pub(crate) struct Leaf<const N: usize> {
    pub(super) gaps: Range<usize>,
    pub(super) charges: [Vec<Lane>; N],
    pub(super) shifts: Vec<Lane>,
    cos: Vec<Lane>,
    sin: Vec<Lane>,
    pub(super) middle: f64,
    /// The field of far poles and its derivatives in u = (ν − middle)·scale, and its error.
    pub(super) scale: f64,
    pub(super) far: [[Nodal; 3]; N],
    pub(super) noise: f64,
    /// The part of it that is not due to errors of the charges.
    pub(super) rounding: f64,
}

impl<const N: usize> Default for Leaf<N> {
    fn default() -> Self {
        let (shifts, cos, sin) = Default::default();
        let (charges, far) = ([const { Vec::new() }; N], [[[0.0; NODES]; 3]; N]);
        Self { gaps: 0..0, charges, shifts, cos, sin, middle: 0.0, scale: 0.0, far, noise: 0.0, rounding: 0.0 }
    }
}

impl<const N: usize> Leaf<N> {
    /// Takes over the poles that are counted one by one.
    pub(super) fn fill(&mut self, sources: impl ExactSizeIterator<Item = ChargedPole<N>>) {
        let count = sources.len();
        let mut charges = self.charges.each_mut().map(|charges| room(charges, count, 0.0));
        let [shifts, cos, sin] = [(&mut self.shifts, 0.0), (&mut self.cos, FAR_ROOT), (&mut self.sin, FAR_ROOT)]
            .map(|(list, pad)| room(list, count, pad));
        for (i, source) in sources.enumerate() {
            charges.iter_mut().zip(source.charges).for_each(|(charges, charge)| charges[i] = charge);
            (shifts[i], cos[i], sin[i]) = (source.shift, source.at.cos, source.at.sin);
        }
    }

    /// The field's polynomial is good at u: within an ellipse about its interval on which it still converges fast.
    pub(super) fn holds(&self, u: Complex<f64>) -> bool {
        u.re.abs() <= 1.2 && u.im.abs() <= 0.5
    }

    /// Distances of a pole from all that are counted one by one.
    pub(super) fn distances(&self, from: &Angle, out: &mut Vec<Lane>) {
        from.distances(&self.cos, &self.sin, out);
    }
}

/// Divides poles, by rising d, into leaves.
pub(super) fn divide<const N: usize>(sources: &[ChargedPole<N>]) -> Vec<Leaf<N>> {
    let points: Vec<f64> = sources.iter().map(|source| source.at.d).collect();
    let charges: Vec<[f64; N]> = sources.iter().map(|source| source.charges).collect();
    let total_error: f64 = charges.iter().map(|charges| charges[N - 1]).sum();
    let fields = Tree::new(&points, false).fields(&points, &charges, &Tree::new(&points, true));
    let leaf = fields.into_iter().map(|field| {
        // Interpolation errs by 2e-14 of the kernels, which the sum of moduli overestimates rather than under.
        let rounding = 1e-14 * field.far[..N - 1].iter().flatten().map(|c| c.abs()).sum::<f64>();
        let mut leaf = Leaf {
            gaps: field.targets.clone(),
            middle: field.middle,
            scale: if field.half > 0.0 { 1.0 / field.half } else { 0.0 },
            noise: rounding + field.far[N - 1][0].abs() + total_error,
            rounding,
            far: field.far.map(|value| [value, derivative(&value), derivative(&derivative(&value))]),
            ..Leaf::default()
        };
        let places: Vec<usize> = field.near.into_iter().flatten().collect();
        leaf.fill(places.iter().map(|&place| sources[place]));
        leaf
    });
    leaf.collect()
}
