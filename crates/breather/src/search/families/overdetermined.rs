//! Words of two instants without force whose impacts no symmetry makes alike: where Newton's law cannot hold for φ ≠ T/2.
//!
//! With the impulses P(δ) of `positions`, Newton's law is several rows R_i(δ) = Σ_j P_j s_ij, s = −K′, for one unknown, δ. As a rule
//! nothing solves them but δ = 0, where all s vanish; to show it an interval is discarded as soon as one row cannot vanish on it, and
//! halved otherwise. As P grows without bound where the positions are singular, x = τ (P, s, 1) takes its place, with c·x = 1 for c
//! about the direction of x: M(δ) x = (0, …, 0, 1) is regular. About the centre of an interval, with radius r and bounds B₂, B₃ on |K″|,
//! |K‴|,
//!
//! ```text
//! |K̂_ij − K̂_ij(c)| ≤ e_ij = |s_ij(c)| r + ½B₂r²           hence  |x − x(c)| ≤ 2u,  u = |M⁻¹| e |x|,  where |M⁻¹| e u ≤ ½u
//! |s_ij/δ − s_ij(c)/c| ≤ ½B₃r                                (s/δ is the mean of s′ on 0 … δ)
//! ```
//!
//! Impacts that symmetries turn into each other, with the instants exchanged in time where that leaves the word as it is, have one
//! impulse but for signs σ and are one unknown: where the other combinations of impulses are undetermined, Newton's law summed over the
//! symmetries does not feel them.
//!
//! The rows of s/δ do not vanish at δ = 0. If no mass is hit at both instants all s vanish at φ = 0, too, and s/(T/2−δ) takes the place
//! of s/δ in the outer half.

use smallvec::SmallVec;
use vibrochain_lattice::KernelJet;

use crate::equations::System;
use crate::equations::linear::{Matrix, USUAL, Vector, dot};
use crate::orbit::WRONG_SIGN;
use crate::roots::interval::Zeros;
use crate::search::families::positions::Positions;
use crate::search::families::two_instants::{APART, UNFELT, pieces};

/// Intervals are not halved below this part of half a period.
const FINEST: f64 = 1e-9;

/// Terms of modes' sums that a search may take, some seconds; a cell of a map takes a ten-thousandth of it.
const MOST_TERMS: usize = 100_000_000;

/// Rounding of the rows relative to their terms, with a lot to spare.
const ROUNDING: f64 = 1e-12;

/// Adds the places of 0 < δ < T/2 where all rows may vanish to the unresolved ones; with `judged` those alone where every impulse can
/// have the right sign.
pub(crate) fn search(positions: &Positions<'_>, classes: &[usize], judged: bool, zeros: &mut Zeros) {
    let response = positions.response();
    let (half, count) = (0.5 * response.period(), pieces(response));
    let rows = Rows::new(positions, classes, judged);
    if rows.apart && !rows.are_felt() {
        zeros.exhausted += 1;
        return;
    }
    let most = zeros.intervals + (MOST_TERMS / (response.modes() * rows.bounds.len())).max(count);
    let (from, to) = (APART * half, half * (1.0 - APART));
    let end = |i: usize| from + (to - from) * (i as f64 / count as f64);
    let mut stack: Vec<(f64, f64)> = (0..count).rev().map(|i| (end(i), end(i + 1))).collect();
    while let Some((low, high)) = stack.pop() {
        if zeros.intervals >= most || zeros.stop.is_raised() {
            zeros.exhausted += stack.len() + 1;
            return;
        }
        zeros.intervals += 1;
        let (centre, radius) = (0.5 * (low + high), 0.5 * (high - low));
        if rows.exclude(centre, radius) {
            continue;
        }
        if radius > FINEST * half {
            stack.extend([(centre, high), (low, centre)]);
        } else if zeros.unresolved.last().is_none_or(|&last| centre - last > 8.0 * radius) {
            zeros.unresolved.push(centre);
        }
    }
}

/// What the rows of a word are made of.
struct Rows<'a, 'b> {
    positions: &'a Positions<'b>,
    /// The class of each impact, and the first impact of each class.
    classes: &'a [usize],
    heads: Vec<usize>,
    judged: bool,
    /// No mass is hit at both instants.
    apart: bool,
    /// B₁ to B₄ of each pair of masses.
    bounds: SmallVec<[[f64; 4]; USUAL]>,
    half: f64,
}

impl<'a, 'b> Rows<'a, 'b> {
    fn new(positions: &'a Positions<'b>, classes: &'a [usize], judged: bool) -> Self {
        let response = positions.response();
        let bounds = positions.each_pair(|one, other| {
            let shapes: Vec<f64> = response.shapes().evens(one, other).collect();
            response.derivative_bounds_of(&shapes)
        });
        let (apart, half) = (!positions.share_masses(), 0.5 * response.period());
        let count = classes.iter().max().map_or(0, |last| last + 1);
        let heads = (0..count).filter_map(|class| classes.iter().position(|other| *other == class)).collect();
        Self { positions, classes, heads, judged, apart, bounds, half }
    }

    /// Whether masses hit at one instant feel those hit at the other: else all hit whenever they like.
    fn are_felt(&self) -> bool {
        let positions = self.positions;
        let felt = |jet: &KernelJet, bounds: &[f64; 4]| jet.slope.abs() > UNFELT * bounds[0];
        (1..8).any(|i| {
            let jets = positions.jets(self.half * f64::from(i) / 8.0);
            let across = |i: usize, j: usize| positions.is_across(i, j).then(|| positions.pair(i, j));
            let mut pairs = (0..positions.hits.len()).flat_map(|i| (0..i).filter_map(move |j| across(i, j)));
            pairs.any(|pair| felt(&jets[pair], &self.bounds[pair]))
        })
    }

    /// Whether no orbit of the word has its δ within `radius` of `centre`.
    fn exclude(&self, centre: f64, radius: f64) -> bool {
        let positions = self.positions;
        let jets = positions.jets(centre);
        let n = self.heads.len();
        let sign = |i: usize| positions.hits[i].0.barrier.sign();
        // Of what acts from each impact on each, what acts on the head of a class from all of another.
        let summed = |of: &dyn Fn(usize, usize) -> f64| {
            let mut sums = Matrix::zeros(n);
            for (row, &i) in self.heads.iter().enumerate() {
                (0..self.classes.len()).for_each(|j| sums[(row, self.classes[j])] += sign(i) * sign(j) * of(i, j));
            }
            sums
        };
        let worst_of = |of: &dyn Fn(usize, usize) -> f64| {
            summed(&|i, j| if positions.is_across(i, j) { sign(i) * sign(j) * of(i, j) } else { 0.0 })
        };
        let full = positions.matrix(|pair| jets[pair].value);
        let (kernels, count) = (summed(&|i, j| full[(i, j)]), self.classes.len());
        let net = |class: usize| (0..count).filter(|&j| self.classes[j] == class).map(sign).sum::<f64>();
        let matrix = Matrix::from_fn(n + 1, |i, j| match (i < n, j < n) {
            (true, true) => kernels[(i, j)],
            (true, false) => sign(self.heads[i]),
            (false, true) => net(j),
            (false, false) => full[(count, count)],
        });
        let stops: Vector = self.heads.iter().map(|&i| sign(i) * positions.stops[i]).chain([0.0]).collect();
        let mut units: Vector = (0..n).map(|_| positions.response().omega()).collect();
        units.push(1.0);
        let system = System::new(matrix, units);
        // (P, s, τ), of length 1.
        let mut solution = system.solve(&stops);
        solution.push(1.0);
        let units: Vector = system.units.iter().copied().chain([1.0]).collect();
        let length = solution.iter().zip(&units).map(|(x, unit)| (x / unit).powi(2)).sum::<f64>().sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return false;
        }
        solution.iter_mut().for_each(|x| *x /= length);
        let border: Vector = solution.iter().zip(&units).map(|(x, unit)| x / (unit * unit)).collect();
        let stops: Vector = stops.iter().map(|stop| -stop).collect();
        let system = System::new(system.matrix.bordered(&stops, &border), units);
        // e, summed with the worst signs, times a vector.
        let changes = worst_of(&|i, j| {
            let pair = positions.pair(i, j);
            let change = jets[pair].slope.abs() * radius + 0.5 * self.bounds[pair][1] * radius * radius;
            change + ROUNDING * jets[pair].value.abs()
        });
        let moved = |by: &[f64]| -> Vector {
            (0..n + 2)
                .map(|i| {
                    if i < n { dot(changes.row(i), &by.iter().map(|x| x.abs()).collect::<Vector>()[..n]) } else { 0.0 }
                })
                .collect()
        };
        let first = system.spread(&moved(&solution));
        if system.spread(&moved(&first)).iter().zip(&first).any(|(second, first)| *second > 0.5 * first) {
            return false;
        }
        let doubt = |j: usize| 2.0 * first[j];
        if self.judged {
            let room = 2.0 * WRONG_SIGN * (0..n).map(|j| solution[j].abs() + doubt(j)).fold(0.0, f64::max);
            // How each surely points, with τ > 0 or < 0: P = σ times the class's.
            let outward = (0..n).map(|class| -solution[class]);
            let surely = |size: f64, j: usize| size.abs() > doubt(j) + room;
            let ways = outward.enumerate().filter(|&(j, size)| surely(size, j)).map(|(_, size)| size > 0.0);
            let forward = solution[n + 1].abs() > doubt(n + 1);
            let [mut inside, mut outside] = [false, forward && solution[n + 1] > 0.0];
            ways.for_each(|out| if out { outside = true } else { inside = true });
            if inside && outside {
                return true;
            }
        }
        let scale = if self.apart && centre > 0.5 * self.half { self.half - centre } else { centre };
        let slopes =
            summed(&|i, j| if positions.is_across(i, j) { jets[positions.pair(i, j)].slope / scale } else { 0.0 });
        let wide = worst_of(&|i, j| {
            let (pair, slope) = (positions.pair(i, j), jets[positions.pair(i, j)].slope / scale);
            0.5 * self.bounds[pair][2] * radius + ROUNDING * (slope.abs() + self.bounds[pair][1])
        });
        (0..n).any(|i| {
            let doubts = |j: usize| wide[(i, j)] * solution[j].abs() + (slopes[(i, j)].abs() + wide[(i, j)]) * doubt(j);
            dot(slopes.row(i), &solution[..n]).abs() > (0..n).map(doubts).sum()
        })
    }
}
