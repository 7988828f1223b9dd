//! The next derivative of coordinates from those of their neighbours.
//!
//! ```text
//! d_{k+2}[n] = γ₂ ((d_k[n−1] + d_k[n+1]) − 2 d_k[n]) − γ₁ d_k[n] + c₂ ((…) of d_{k+1}) − c d_{k+1}[n] + F_k
//! ```
//!
//! and γ₃ times the like of the neighbouring layers. The neighbours enter as one sum, so a mirror-symmetric ring stays symmetric to the bit.
//! (d₋ + d₊) − 2d keeps soft rings exact: γ₁ is never added to a larger γ₂.

use wide::f64x4;

use crate::series::Rows;
use crate::units::{MAX_ORDER, Units};
use vibrochain_lattice::{Chain, Ends};

/// What an expansion covers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Extent<'a> {
    pub(crate) columns: usize,
    /// What stands beyond the first and the last column; `None`: a neighbour whose series is in [`Rows::edges`].
    pub(crate) beyond: [Option<Ends>; 2],
    /// The columns of all masses' neighbours, ghosts counted, where they are not simply the columns beside: see [`links`].
    pub(crate) links: &'a [[u32; 4]],
    pub(crate) resting: &'a [usize],
    pub(crate) soft: &'a [(usize, u8)],
}

/// Columns of the neighbours of all masses of several layers, ghosts counted; empty for one row.
pub(crate) fn links(chain: &Chain) -> Vec<[u32; 4]> {
    if chain.layers() == 1 {
        return Vec::new();
    }
    // At most 10⁷ masses.
    let column = |side: Option<usize>| side.map_or(0, |m| m as u32 + 1);
    (0..chain.sites()).map(|n| chain.neighbours(n).map(column)).collect()
}

/// What masses in a row have alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stencil {
    /// γ₁ and γ₂
    pub(crate) stiffness: [f64; 2],
    /// c and c₂
    pub(crate) damping: [f64; 2],
}

impl Stencil {
    /// d_{k+2} of the first `columns` columns from d_k, d_{k+1} and their ghosts, four at a time: up to three columns beyond the last get
    /// what nobody reads.
    #[inline(always)]
    pub(crate) fn advance<const DAMPED: bool>(&self, from: [&[f64]; 2], to: &mut [f64], columns: usize, force: f64) {
        let groups = columns.div_ceil(4);
        let [place, speed] = from.map(|row| [0, 1, 2].map(|shift| &row[shift..].as_chunks::<4>().0[..groups]));
        let to = &mut to[1..].as_chunks_mut::<4>().0[..groups];
        let [stiffness, damping] = [self.stiffness, self.damping].map(|pair| pair.map(f64x4::splat));
        let force = f64x4::splat(force);
        let pull = |[left, own, right]: [&[[f64; 4]]; 3], [ground, between]: [f64x4; 2], i: usize| {
            let own = f64x4::from(own[i]);
            let stretch = (f64x4::from(left[i]) + f64x4::from(right[i])) - (own + own);
            between * stretch - ground * own
        };
        // (Slices zipped cost more than the arithmetic.)
        for i in 0..groups {
            let sum = pull(place, stiffness, i) + force;
            to[i] = if DAMPED { sum + pull(speed, damping, i) } else { sum }.to_array();
        }
    }
}

impl Rows {
    /// Fills the rows 2 … `order` of a chain from the rows 0 and 1.
    ///
    /// `resting` and `soft` are columns: of masses at rest, for the i-th of which `pressed(i, k, value)` receives the
    /// k-th derivative of the acceleration it is denied; and of masses that leave a barrier with an order above 1,
    /// whose derivatives below it vanish exactly.
    pub(crate) fn expand_chain(
        &mut self,
        extent: Extent<'_>,
        units: &Units,
        force: &[f64; MAX_ORDER + 1],
        order: usize,
        mut pressed: impl FnMut(usize, usize, f64),
    ) {
        let Extent { columns, beyond, links, resting, soft } = extent;
        let stencil = Stencil { stiffness: [units.gamma1, units.gamma2], damping: [0.0; 2] };
        self.expand(columns, beyond, order, |k, from, to| {
            if links.is_empty() {
                stencil.advance::<false>(from, to, columns, force[k]);
            } else {
                advance_layers(from[0], to, links, units, force[k]);
            }
            for (i, &n) in resting.iter().enumerate() {
                pressed(i, k, to[n + 1]);
                to[n + 1] = 0.0;
            }
            for &(n, first) in soft {
                if k + 2 < usize::from(first) {
                    to[n + 1] = 0.0;
                }
            }
        });
    }
}

/// The same of all masses of several layers.
fn advance_layers(from: &[f64], to: &mut [f64], links: &[[u32; 4]], units: &Units, force: f64) {
    for ((to, own), sides) in to[1..].iter_mut().zip(&from[1..]).zip(links) {
        *to = units.pull(*own, sides.map(|column| from[column as usize])) + force;
    }
}
