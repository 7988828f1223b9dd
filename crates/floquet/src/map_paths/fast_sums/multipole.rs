//! Many sums Σ q_j/(x − y_j) at once, in time proportional to the number of points: a one-dimensional fast multipole
//! method by interpolation.
//!
//! Points, sorted, are halved by number into a binary tree. A node's charges act from afar like charges at the Chebyshev
//! nodes of its interval, and fields of far nodes are polynomials on it. Two nodes are far from each other if the gap
//! between them is at least as wide as the wider one: interpolation in 18 nodes then errs by (3+√8)^−18 ≈ 2e-14 of the
//! kernel. What is not far from a leaf is left to the caller as a range of sources.

use std::ops::Range;

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_lattice::simd::lanes::{TWO, ZERO, all, four};
use wide::f64x4;

/// Chebyshev nodes.
pub(crate) const NODES: usize = 18;
/// Most points in a leaf.
const LEAF: usize = 48;

/// Ranges of sources, fewer than 2³².
pub(crate) type Ranges = SmallVec<[Range<u32>; 3]>;

/// One value per Chebyshev node, or one Chebyshev coefficient per degree.
pub(crate) type Nodal = [f64; NODES];

#[derive(Debug, Clone)]
struct TreeNode {
    low: f64,
    high: f64,
    points: Range<usize>,
    children: Option<(usize, usize)>,
}

/// A binary tree over sorted points.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tree {
    nodes: Vec<TreeNode>,
    /// Nodes that are leaves, in order of their points.
    leaves: Vec<usize>,
}

/// Field of far sources on a target leaf, `CHANNELS` kinds of charges, and the sources that are near.
#[derive(Debug, Clone)]
pub(crate) struct Field<const CHANNELS: usize> {
    pub(crate) targets: Range<usize>,
    /// What is near; a wide leaf may be near where a narrow one in between is far.
    pub(crate) near: Ranges,
    pub(crate) middle: f64,
    pub(crate) half: f64,
    /// Chebyshev coefficients.
    pub(crate) far: [Nodal; CHANNELS],
}

/// What all interpolation in Chebyshev nodes needs, worked out once.
#[derive(Debug, Clone)]
struct Interpolation {
    nodes: Nodal,
    /// Barycentric weights.
    weights: Nodal,
    /// For each degree, the share of each node's value in the Chebyshev coefficient.
    shares: [Nodal; NODES],
}

impl Interpolation {
    fn new() -> Self {
        let angle = |j: usize| std::f64::consts::PI * (j as f64 + 0.5) / NODES as f64;
        let weight = |j: usize| if j.is_multiple_of(2) { angle(j).sin() } else { -angle(j).sin() };
        let share = |degree: usize, j: usize| {
            let size = if degree == 0 { 1.0 } else { 2.0 } / NODES as f64;
            (degree as f64 * angle(j)).cos() * size
        };
        Self {
            nodes: chebyshev(),
            weights: std::array::from_fn(weight),
            shares: std::array::from_fn(|degree| std::array::from_fn(|j| share(degree, j))),
        }
    }

    /// Values of the Lagrange polynomials of the nodes at u, by the barycentric formula.
    fn lagrange(&self, u: f64) -> Nodal {
        let distances = self.nodes.map(|node| u - node);
        if let Some(here) = distances.iter().position(|distance| *distance == 0.0) {
            return std::array::from_fn(|j| if j == here { 1.0 } else { 0.0 });
        }
        let basis: Nodal = std::array::from_fn(|j| self.weights[j] / distances[j]);
        let scale = 1.0 / dot(&basis, &[1.0; NODES]);
        basis.map(|b| b * scale)
    }

    /// Chebyshev coefficients of the polynomial with these values at the nodes.
    fn coefficients(&self, values: &Nodal) -> Nodal {
        self.shares.each_ref().map(|shares| dot(values, shares))
    }
}

/// Σ ab, in six sums side by side.
fn dot(a: &Nodal, b: &Nodal) -> f64 {
    let mut sums = [0.0; 6];
    for (a, b) in a.as_chunks::<6>().0.iter().zip(b.as_chunks::<6>().0) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
    }
    let [a, b, c, d, e, f] = sums;
    (a + b) + (c + d) + (e + f)
}

fn chebyshev() -> Nodal {
    std::array::from_fn(|j| (std::f64::consts::PI * (j as f64 + 0.5) / NODES as f64).cos())
}

impl Tree {
    /// The tree of sorted points. If `gaps`, a node's interval reaches to the first point of its successor, so that the leaves
    /// cover the gaps between points, too.
    pub(crate) fn new(points: &[f64], gaps: bool) -> Self {
        let mut tree = Self::default();
        if !points.is_empty() {
            tree.grow(points, gaps, 0..points.len());
        }
        tree
    }

    fn grow(&mut self, points: &[f64], gaps: bool, range: Range<usize>) -> usize {
        let index = self.nodes.len();
        let last = if gaps { range.end.min(points.len() - 1) } else { range.end - 1 };
        let (low, high) = (points[range.start], points[last]);
        self.nodes.push(TreeNode { low, high, points: range.clone(), children: None });
        if range.len() > LEAF {
            let middle = range.start + range.len() / 2;
            let left = self.grow(points, gaps, range.start..middle);
            let right = self.grow(points, gaps, middle..range.end);
            self.nodes[index].children = Some((left, right));
        } else {
            self.leaves.push(index);
        }
        index
    }

    fn middle_and_half(&self, index: usize) -> (f64, f64) {
        let node = &self.nodes[index];
        (0.5 * (node.low + node.high), 0.5 * (node.high - node.low))
    }

    /// The field of charges at the sorted `sources` of this tree on the leaves of `targets`, in order, one at a time; each charge is
    /// asked for once.
    pub(crate) fn fields<'a, const CHANNELS: usize, Q: Fn(usize) -> [f64; CHANNELS]>(
        &self,
        sources: &[f64],
        charge: Q,
        targets: &'a Tree,
    ) -> impl Iterator<Item = Field<CHANNELS>> + use<'a, CHANNELS, Q> {
        let table = Interpolation::new();
        let (mut locals, mut near) = self.across(&self.moments(&table, sources, charge), &table, targets);
        // Downwards.
        for index in 0..targets.nodes.len() {
            let Some((left, right)) = targets.nodes[index].children else { continue };
            let interval = targets.middle_and_half(index);
            let parent = locals[index];
            for child in [left, right] {
                let (middle, half) = targets.middle_and_half(child);
                for (i, node) in table.nodes.iter().enumerate() {
                    let basis = table.lagrange(scaled(interval, middle + half * node));
                    for channel in 0..CHANNELS {
                        locals[child][channel][i] += dot(&parent[channel], &basis);
                    }
                }
            }
        }
        targets.leaves.iter().map(move |&leaf| {
            let (middle, half) = targets.middle_and_half(leaf);
            let mut near = std::mem::take(&mut near[leaf]);
            near.sort_unstable_by_key(|range| range.start);
            let far = locals[leaf].each_ref().map(|values| table.coefficients(values));
            Field { targets: targets.nodes[leaf].points.clone(), near, middle, half, far }
        })
    }

    /// Upwards: the charges of each node as charges at its Chebyshev nodes.
    fn moments<const CHANNELS: usize>(
        &self,
        table: &Interpolation,
        sources: &[f64],
        charge: impl Fn(usize) -> [f64; CHANNELS],
    ) -> Vec<[Nodal; CHANNELS]> {
        let mut moments = vec![[[0.0; NODES]; CHANNELS]; self.nodes.len()];
        // Children come after their parents.
        for index in (0..self.nodes.len()).rev() {
            let interval = self.middle_and_half(index);
            let mut moment = [[0.0; NODES]; CHANNELS];
            let mut add = |x: f64, charges: [f64; CHANNELS]| {
                let basis = table.lagrange(scaled(interval, x));
                for (moment, charge) in moment.iter_mut().zip(charges) {
                    moment.iter_mut().zip(&basis).for_each(|(m, b)| *m += charge * b);
                }
            };
            if let Some((left, right)) = self.nodes[index].children {
                for child in [left, right] {
                    let (middle, half) = self.middle_and_half(child);
                    for (j, node) in table.nodes.iter().enumerate() {
                        add(middle + half * node, moments[child].each_ref().map(|moment| moment[j]));
                    }
                }
            } else {
                self.nodes[index].points.clone().for_each(|j| add(sources[j], charge(j)));
            }
            moments[index] = moment;
        }
        moments
    }

    /// Across: the fields of far nodes on each node of `targets`, and what is near its leaves.
    fn across<const CHANNELS: usize>(
        &self,
        moments: &[[Nodal; CHANNELS]],
        table: &Interpolation,
        targets: &Tree,
    ) -> (Vec<[Nodal; CHANNELS]>, Vec<Ranges>) {
        let nodes = &table.nodes;
        let mut locals = vec![[[0.0; NODES]; CHANNELS]; targets.nodes.len()];
        let mut near: Vec<Ranges> = vec![Ranges::new(); targets.nodes.len()];
        let mut stack = vec![];
        if !self.nodes.is_empty() && !targets.nodes.is_empty() {
            stack.push((0, 0));
        }
        while let Some((target, source)) = stack.pop() {
            let (t, s) = (&targets.nodes[target], &self.nodes[source]);
            let gap = (t.low - s.high).max(s.low - t.high);
            let (wide_t, wide_s) = (t.high - t.low, s.high - s.low);
            if gap > 0.0 && gap >= wide_t.max(wide_s) {
                let ((middle, half), (centre, radius)) =
                    (targets.middle_and_half(target), self.middle_and_half(source));
                let places = nodes.map(|node| middle + half * node);
                for (j, node) in nodes.iter().enumerate() {
                    let x = centre + radius * node;
                    let kernel = places.map(|place| 1.0 / (place - x));
                    for (local, moment) in locals[target].iter_mut().zip(&moments[source]) {
                        local.iter_mut().zip(&kernel).for_each(|(local, kernel)| *local += kernel * moment[j]);
                    }
                }
                continue;
            }
            match (t.children, s.children) {
                (None, None) => near[target].push(s.points.start as u32..s.points.end as u32),
                (Some((a, b)), None) => stack.extend([(a, source), (b, source)]),
                (Some((a, b)), Some(_)) if wide_t >= wide_s => stack.extend([(a, source), (b, source)]),
                (_, Some((a, b))) => stack.extend([(target, a), (target, b)]),
            }
        }
        (locals, near)
    }
}

/// The coordinate −1 … 1 on an interval, of which `middle` and half the width are given.
fn scaled((middle, half): (f64, f64), x: f64) -> f64 {
    if half > 0.0 { (x - middle) / half } else { 0.0 }
}

/// Value of a Chebyshev series.
pub(crate) fn series(coefficients: &Nodal, u: f64) -> f64 {
    let (mut a, mut b) = (0.0, 0.0);
    for c in coefficients.iter().skip(1).rev() {
        (a, b) = (2.0 * u * a - b + c, a);
    }
    u * a - b + coefficients[0]
}

/// Values of up to four Chebyshev series next to the real axis, worked out together: each step waits for the one before.
pub(crate) fn complex_series<const N: usize>(coefficients: [&Nodal; N], u: Complex<f64>) -> [Complex<f64>; N] {
    let (re, im) = (all(u.re), all(u.im));
    let times = |[x, y]: [f64x4; 2]| [re * x - im * y, re * y + im * x];
    let order = |k: usize| four(std::array::from_fn(|i| coefficients.get(i).map_or(0.0, |series| series[k])));
    let (mut a, mut b) = ([ZERO; 2], [ZERO; 2]);
    for k in (1..NODES).rev() {
        let [x, y] = times(a);
        (a, b) = ([x * TWO - b[0] + order(k), y * TWO - b[1]], a);
    }
    let [x, y] = times(a);
    let (x, y) = ((x - b[0] + order(0)).to_array(), (y - b[1]).to_array());
    std::array::from_fn(|i| Complex::new(x[i], y[i]))
}

/// Coefficients of a Chebyshev series' derivative.
pub(crate) fn derivative(coefficients: &Nodal) -> Nodal {
    let mut slope = [0.0; NODES];
    for k in (0..NODES - 1).rev() {
        let above = if k + 2 < NODES { slope[k + 2] } else { 0.0 };
        slope[k] = above + 2.0 * (k as f64 + 1.0) * coefficients[k + 1];
    }
    slope[0] *= 0.5;
    slope
}

impl<const CHANNELS: usize> Field<CHANNELS> {
    /// The sources that are near, by number.
    pub(crate) fn near(&self) -> impl Iterator<Item = usize> + '_ {
        self.near.iter().flat_map(|range| range.start as usize..range.end as usize)
    }

    /// The far field at x, one value a channel.
    pub(crate) fn at(&self, x: f64) -> [f64; CHANNELS] {
        let u = scaled((self.middle, self.half), x);
        std::array::from_fn(|channel| series(&self.far[channel], u))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map_paths::tests::Random;

    #[test]
    fn fields_are_the_plain_sums() {
        let mut random = Random(31);
        for (count, others, power) in [(1, 1, 1), (40, 70, 1), (1000, 900, 1), (5000, 3000, 1), (2000, 2000, 3)] {
            let mut draw = |n: usize| {
                // Crowded at the ends, as cosines are, or at one place.
                let mut points: Vec<f64> =
                    (0..n).map(|_| (std::f64::consts::PI * random.unit()).cos().powi(power)).collect();
                points.sort_unstable_by(f64::total_cmp);
                points
            };
            let (sources, targets) = (draw(count), draw(others));
            let charges: Vec<[f64; 2]> = (0..count).map(|_| [random.unit(), random.unit() - 0.5]).collect();
            let (from, to) = (Tree::new(&sources, false), Tree::new(&targets, true));
            let fields: Vec<_> = from.fields(&sources, |j| charges[j], &to).collect();
            assert_eq!(fields.iter().map(|field| field.targets.len()).sum::<usize>(), others);
            let mut near = 0;
            for field in &fields {
                let is_near = |j: &usize| field.near.iter().any(|range| range.contains(&(*j as u32)));
                near += field.near().count() * field.targets.len();
                for i in field.targets.clone() {
                    let x = targets[i];
                    let far = field.at(x);
                    for channel in 0..2 {
                        let (mut sum, mut size) = (0.0, 0.0);
                        for j in (0..count).filter(|j| !is_near(j)) {
                            sum += charges[j][channel] / (x - sources[j]);
                            size += (charges[j][channel] / (x - sources[j])).abs();
                        }
                        assert!((far[channel] - sum).abs() <= 1e-13 * size, "{count} {i}: {} {sum}", far[channel]);
                    }
                }
            }
            // The near part stays a band.
            assert!(near <= others * (LEAF * 12), "{near}");
        }
    }

    #[test]
    fn series_and_derivative() {
        let values = chebyshev().map(|u| (2.0 * u).exp());
        let c = Interpolation::new().coefficients(&values);
        let slope = derivative(&c);
        for u in [-1.0_f64, -0.3, 0.0, 0.7, 1.0] {
            assert!((series(&c, u) - (2.0 * u).exp()).abs() < 1e-13);
            let [at, beside] = complex_series([&c, &slope], Complex::new(u, 0.1));
            let expected = Complex::new(2.0 * u, 0.2).exp();
            assert!((at - expected).norm() < 1e-12 && (beside - expected * 2.0).norm() < 1e-10, "{at} {beside}");
            assert_eq!(complex_series([&c], Complex::new(u, 0.0)).map(|z| z.re), [series(&c, u)]);
            assert!((series(&slope, u) - 2.0 * (2.0 * u).exp()).abs() < 1e-11);
        }
    }
}
