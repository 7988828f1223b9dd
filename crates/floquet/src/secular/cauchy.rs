//! Many sums Σ q_j/(x − y_j) at once, in time proportional to the number of points: a one-dimensional fast multipole
//! method by interpolation.
//!
//! Points, sorted, are halved by number into a binary tree. A node's charges act from afar like charges at the Chebyshev
//! nodes of its interval, and fields of far nodes are polynomials on it. Two nodes are far from each other if the gap
//! between them is at least as wide as the wider one: interpolation in 18 nodes then errs by (3+√8)^−18 ≈ 2e-14 of the
//! kernel. What is not far from a leaf is left to the caller as a range of sources.

use std::ops::Range;

use nalgebra::Complex;

/// Chebyshev nodes.
pub(crate) const NODES: usize = 18;
/// Most points in a leaf.
const LEAF: usize = 48;

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
    /// Ranges of sources; a wide leaf may be near where a narrow one in between is far.
    pub(crate) near: Vec<Range<usize>>,
    pub(crate) middle: f64,
    pub(crate) half: f64,
    /// Chebyshev coefficients.
    pub(crate) far: [Nodal; CHANNELS],
}

fn chebyshev() -> Nodal {
    std::array::from_fn(|j| (std::f64::consts::PI * (j as f64 + 0.5) / NODES as f64).cos())
}

/// Values of the Lagrange polynomials of the nodes at u, by the barycentric formula.
fn lagrange(nodes: &Nodal, u: f64) -> Nodal {
    let mut basis = [0.0; NODES];
    let mut sum = 0.0;
    for j in 0..NODES {
        let distance = u - nodes[j];
        if distance == 0.0 {
            basis = [0.0; NODES];
            basis[j] = 1.0;
            return basis;
        }
        let weight = (std::f64::consts::PI * (j as f64 + 0.5) / NODES as f64).sin() / distance;
        basis[j] = if j % 2 == 0 { weight } else { -weight };
        sum += basis[j];
    }
    basis.map(|b| b / sum)
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

    /// The field of charges at the sorted `sources` of this tree on the leaves of `targets`, in order.
    pub(crate) fn fields<const CHANNELS: usize>(
        &self,
        sources: &[f64],
        charges: &[[f64; CHANNELS]],
        targets: &Tree,
    ) -> Vec<Field<CHANNELS>> {
        let nodes = chebyshev();
        let scaled = |(middle, half): (f64, f64), x: f64| if half > 0.0 { (x - middle) / half } else { 0.0 };
        // Upwards: children come after their parents.
        let mut moments = vec![[[0.0; NODES]; CHANNELS]; self.nodes.len()];
        for index in (0..self.nodes.len()).rev() {
            let interval = self.middle_and_half(index);
            let mut moment = [[0.0; NODES]; CHANNELS];
            if let Some((left, right)) = self.nodes[index].children {
                for child in [left, right] {
                    let (middle, half) = self.middle_and_half(child);
                    for (j, node) in nodes.iter().enumerate() {
                        let basis = lagrange(&nodes, scaled(interval, middle + half * node));
                        for channel in 0..CHANNELS {
                            let charge = moments[child][channel][j];
                            moment[channel].iter_mut().zip(&basis).for_each(|(m, b)| *m += charge * b);
                        }
                    }
                }
            } else {
                for j in self.nodes[index].points.clone() {
                    let basis = lagrange(&nodes, scaled(interval, sources[j]));
                    for channel in 0..CHANNELS {
                        moment[channel].iter_mut().zip(&basis).for_each(|(m, b)| *m += charges[j][channel] * b);
                    }
                }
            }
            moments[index] = moment;
        }
        // Across.
        let mut locals = vec![[[0.0; NODES]; CHANNELS]; targets.nodes.len()];
        let mut near: Vec<Vec<Range<usize>>> = vec![Vec::new(); targets.nodes.len()];
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
                for (i, node) in nodes.iter().enumerate() {
                    let x = middle + half * node;
                    for j in 0..NODES {
                        let kernel = 1.0 / (x - (centre + radius * nodes[j]));
                        for channel in 0..CHANNELS {
                            locals[target][channel][i] += kernel * moments[source][channel][j];
                        }
                    }
                }
                continue;
            }
            match (t.children, s.children) {
                (None, None) => {
                    near[target].push(s.points.clone());
                }
                (Some((a, b)), None) => stack.extend([(a, source), (b, source)]),
                (Some((a, b)), Some(_)) if wide_t >= wide_s => stack.extend([(a, source), (b, source)]),
                (_, Some((a, b))) => stack.extend([(target, a), (target, b)]),
            }
        }
        // Downwards.
        for index in 0..targets.nodes.len() {
            let Some((left, right)) = targets.nodes[index].children else { continue };
            let interval = targets.middle_and_half(index);
            let parent = locals[index];
            for child in [left, right] {
                let (middle, half) = targets.middle_and_half(child);
                for (i, node) in nodes.iter().enumerate() {
                    let basis = lagrange(&nodes, scaled(interval, middle + half * node));
                    for channel in 0..CHANNELS {
                        let value: f64 = parent[channel].iter().zip(&basis).map(|(p, b)| p * b).sum();
                        locals[child][channel][i] += value;
                    }
                }
            }
        }
        let field = |&leaf: &usize| {
            let (middle, half) = targets.middle_and_half(leaf);
            let mut near = near[leaf].clone();
            near.sort_unstable_by_key(|range| range.start);
            Field {
                targets: targets.nodes[leaf].points.clone(),
                near,
                middle,
                half,
                far: locals[leaf].map(coefficients),
            }
        };
        targets.leaves.iter().map(field).collect()
    }
}

/// Chebyshev coefficients of the polynomial with these values at the nodes.
fn coefficients(values: Nodal) -> Nodal {
    std::array::from_fn(|degree| {
        let angle = |j: usize| std::f64::consts::PI * degree as f64 * (j as f64 + 0.5) / NODES as f64;
        let sum: f64 = values.iter().enumerate().map(|(j, value)| value * angle(j).cos()).sum();
        sum * if degree == 0 { 1.0 } else { 2.0 } / NODES as f64
    })
}

/// Value of a Chebyshev series.
pub(crate) fn series(coefficients: &Nodal, u: f64) -> f64 {
    let (mut a, mut b) = (0.0, 0.0);
    for c in coefficients.iter().skip(1).rev() {
        (a, b) = (2.0 * u * a - b + c, a);
    }
    u * a - b + coefficients[0]
}

/// Value of a Chebyshev series next to the real axis.
pub(crate) fn complex_series(coefficients: &Nodal, u: Complex<f64>) -> Complex<f64> {
    let (mut a, mut b) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
    for c in coefficients.iter().skip(1).rev() {
        (a, b) = (u * a * 2.0 - b + c, a);
    }
    u * a - b + coefficients[0]
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
    /// The far field at x, one value a channel.
    pub(crate) fn at(&self, x: f64) -> [f64; CHANNELS] {
        let u = self.scaled(x);
        std::array::from_fn(|channel| series(&self.far[channel], u))
    }

    /// The coordinate in −1 … 1.
    pub(crate) fn scaled(&self, x: f64) -> f64 {
        if self.half > 0.0 { (x - self.middle) / self.half } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::Random;
    use super::*;

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
            let fields = Tree::new(&sources, false).fields(&sources, &charges, &Tree::new(&targets, true));
            assert_eq!(fields.iter().map(|field| field.targets.len()).sum::<usize>(), others);
            let mut near = 0;
            for field in &fields {
                let is_near = |j: &usize| field.near.iter().any(|range| range.contains(j));
                near += field.near.iter().map(Range::len).sum::<usize>() * field.targets.len();
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
        let (c, slope) = (coefficients(values), derivative(&coefficients(values)));
        for u in [-1.0_f64, -0.3, 0.0, 0.7, 1.0] {
            assert!((series(&c, u) - (2.0 * u).exp()).abs() < 1e-13);
            assert!((series(&slope, u) - 2.0 * (2.0 * u).exp()).abs() < 1e-11);
        }
    }
}
