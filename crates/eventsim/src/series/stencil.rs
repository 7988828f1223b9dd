//! The next derivative of coordinates from those of their neighbours.
//!
//! ```text
//! d_{k+2}[n] = γ₂ ((d_k[n−1] + d_k[n+1]) − 2 d_k[n]) − γ₁ d_k[n] + c₂ ((…) of d_{k+1}) − c d_{k+1}[n] + F_k
//! ```
//!
//! and γ₃ times the like of the neighbouring layers. The neighbours enter as one sum, so a mirror-symmetric ring stays symmetric to the bit.
//! (d₋ + d₊) − 2d keeps soft rings exact: γ₁ is never added to a larger γ₂.

use wide::f64x4;

use crate::time::two_sum;

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
        // (Closures over arrays cost as much as the arithmetic of a short row.)
        let [left, own, right] = beside(from[0], groups);
        let to = &mut to[1..].as_chunks_mut::<4>().0[..groups];
        let [ground, between] = self.stiffness;
        let stiffness = [f64x4::splat(ground), f64x4::splat(between)];
        let [ground, between] = self.damping;
        let damping = [f64x4::splat(ground), f64x4::splat(between)];
        let force = f64x4::splat(force);
        // (Slices zipped cost more than the arithmetic.)
        if DAMPED {
            let [slow, speed, fast] = beside(from[1], groups);
            for i in 0..groups {
                let sum = pull([left[i], own[i], right[i]], stiffness) + force;
                to[i] = (sum + pull([slow[i], speed[i], fast[i]], damping)).to_array();
            }
        } else {
            for i in 0..groups {
                to[i] = (pull([left[i], own[i], right[i]], stiffness) + force).to_array();
            }
        }
    }
}

/// The columns before, at and behind each of a row, four at a time.
#[inline(always)]
fn beside(row: &[f64], groups: usize) -> [&[[f64; 4]]; 3] {
    let from = |shift: usize| &row[shift..].as_chunks::<4>().0[..groups];
    [from(0), from(1), from(2)]
}

#[inline(always)]
fn pull([left, own, right]: [[f64; 4]; 3], [ground, between]: [f64x4; 2]) -> f64x4 {
    let own = f64x4::from(own);
    let stretch = (f64x4::from(left) + f64x4::from(right)) - (own + own);
    between * stretch - ground * own
}

/// Rows side by side: neighbours are looked up.
#[derive(Debug, Clone)]
pub(crate) struct Links {
    stencil: Stencil,
    /// γ₃
    across: f64,
    /// The columns of all masses' neighbours, ghosts counted; ghost column 0 is the wall.
    columns: Vec<[u32; 4]>,
}

impl Links {
    /// At most 10⁷ masses.
    pub(crate) fn new(
        stencil: Stencil,
        across: f64,
        masses: usize,
        sides: impl Fn(usize) -> [Option<usize>; 4],
    ) -> Self {
        let column = |side: Option<usize>| side.map_or(0, |m| m as u32 + 1);
        Self { stencil, across, columns: (0..masses).map(|n| sides(n).map(column)).collect() }
    }

    /// The stencil of a mass along its row, γ₃ of its springs to other rows, and the columns of its neighbours.
    pub(crate) fn of(&self, n: usize) -> (&Stencil, f64, [usize; 4]) {
        (&self.stencil, self.across, self.columns[n].map(|column| column as usize))
    }

    /// d_{k+2} of all columns from d_k, d_{k+1} and the wall.
    pub(crate) fn advance(&self, from: [&[f64]; 2], to: &mut [f64], force: f64) {
        let Self { stencil: Stencil { stiffness, damping }, across, columns } = self;
        let is_damped = *damping != [0.0; 2];
        let pull = |row: &[f64], n: usize, [ground, between]: [f64; 2], across: f64, sides: &[u32; 4]| {
            let (own, [left, right, below, above]) = (row[n + 1], sides.map(|column| row[column as usize]));
            let along = between * ((left + right) - 2.0 * own) - ground * own;
            along + across * ((below + above) - 2.0 * own)
        };
        for (n, (to, sides)) in to[1..].iter_mut().zip(columns).enumerate() {
            let sum = pull(from[0], n, *stiffness, *across, sides) + force;
            *to = if is_damped { sum + pull(from[1], n, *damping, 0.0, sides) } else { sum };
        }
    }
}

/// What rounding has taken from what the springs of a mass do to it: of γ to the ground, and of pairs of springs with the rows of their ends.
pub(crate) fn lost_of_springs(own: f64, ground: f64, pairs: [(f64, [f64; 2]); 2]) -> f64 {
    let hold = ground * own;
    let [along, across] = pairs.map(|(gamma, [a, b])| {
        if gamma == 0.0 {
            return (0.0, 0.0);
        }
        let (sum, of_sum) = two_sum(a, b);
        let (stretch, of_stretch) = two_sum(sum, -2.0 * own);
        let force = gamma * stretch;
        (force, gamma.mul_add(stretch, -force) + gamma * (of_sum + of_stretch))
    });
    let (row, of_row) = two_sum(along.0, -hold);
    let of_hold = ground.mul_add(own, -hold);
    let of_both = if across.0 == 0.0 { 0.0 } else { two_sum(row, across.0).1 };
    along.1 + across.1 + of_row + of_both - of_hold
}
