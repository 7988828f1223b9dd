//! Borders cut where they meet, on a grid of whole numbers.
//!
//! The crossing of two chords is rounded to the grid, and rounding could push a chord across a corner beside it. So every chord is
//! bent through all corners whose squares of the grid it passes (snap rounding, after Hobby): then no two pieces meet but at their
//! ends, and all decisions are made in whole numbers, none of them by rounding.

use crate::error::MapError;
use crate::regions::boxes::{BoxTree, bounds};
use crate::regions::smooth::Place;

/// A corner, in steps of the grid.
pub(crate) type Node = [i64; 2];

/// Steps of the grid across the window: about 1e-12 each, as near as an event is found. Whole numbers of this size are exact in
/// `f64`, too, and products of three of them in `i128`.
pub(crate) const GRID: i64 = 1 << 40;

/// The most crossings, some hundred times what maps have: random scribble would otherwise take all memory.
const MOST: usize = 2_000_000;

pub(crate) fn node(place: Place) -> Node {
    place.map(|part| (part * GRID as f64).round() as i64)
}

pub(crate) fn place(node: Node) -> Place {
    node.map(|steps| steps as f64 / GRID as f64)
}

/// Corners, and paths of borders through them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Noded {
    pub(crate) nodes: Vec<Node>,
    /// The paths of each border by numbers of nodes. No two pieces of any paths meet but at their ends, or are the same.
    pub(crate) paths: Vec<Vec<u32>>,
}

fn cross(a: Node, b: Node) -> i128 {
    i128::from(a[0]) * i128::from(b[1]) - i128::from(a[1]) * i128::from(b[0])
}

fn minus(a: Node, b: Node) -> Node {
    [a[0] - b[0], a[1] - b[1]]
}

/// Twice the area of a triangle, positive counterclockwise.
pub(crate) fn doubled([a, b, c]: [Node; 3]) -> i128 {
    cross(minus(b, a), minus(c, a))
}

/// Where two chords cross inside both, rounded to the grid.
fn crossing([a, b]: [Node; 2], [c, d]: [Node; 2]) -> Option<Node> {
    let sides = [doubled([a, b, c]), doubled([a, b, d]), doubled([c, d, a]), doubled([c, d, b])].map(i128::signum);
    if sides[0] * sides[1] >= 0 || sides[2] * sides[3] >= 0 {
        return None;
    }
    let (r, s) = (minus(b, a), minus(d, c));
    let (over, under) = (cross(minus(c, a), s), cross(r, s));
    let (over, under) = if under < 0 { (-over, -under) } else { (over, under) };
    // Halves are rounded up, as squares are open above.
    let step = |r: i64| (2 * over * i128::from(r) + under).div_euclid(2 * under) as i64;
    Some([a[0] + step(r[0]), a[1] + step(r[1])])
}

/// Whether a chord passes the square of half a step about a node, whose left and lower sides belong to it.
fn passes([a, b]: [Node; 2], centre: Node) -> bool {
    // In half steps the corners are odd and the chord's ends even: none lies on a side.
    let inside = |k: usize| a[k].min(b[k]) <= centre[k] && a[k].max(b[k]) >= centre[k];
    if !(inside(0) && inside(1)) {
        return false;
    }
    let chord = minus(b, a);
    let middle = 2 * cross(chord, minus(centre, a));
    let reach = i128::from(chord[0].abs()) + i128::from(chord[1].abs());
    // Through the inside, or through the lower left corner alone.
    middle.abs() < reach || (middle.abs() == reach && middle == i128::from(chord[0]) - i128::from(chord[1]))
}

/// Cuts borders, given by their corners, where they meet.
///
/// # Errors
/// [`MapError::Request`] for millions of crossings.
pub(crate) fn noded(borders: &[Vec<Node>]) -> Result<Noded, MapError> {
    let mut chords: Vec<[Node; 2]> = Vec::new();
    let mut ranges = Vec::with_capacity(borders.len());
    for border in borders {
        let first = chords.len();
        chords.extend(border.windows(2).map(|pair| [pair[0], pair[1]]).filter(|[a, b]| a != b));
        ranges.push(first..chords.len());
    }
    let real = |[x, y]: Node| [x as f64, y as f64];
    let boxes: Vec<_> = chords.iter().map(|&[a, b]| bounds([real(a), real(b)], 0.0)).collect();
    let tree = BoxTree::new(boxes.clone());
    let mut nodes: Vec<Node> = chords.iter().flatten().copied().collect();
    let ends = nodes.len();
    for (i, &chord) in chords.iter().enumerate() {
        tree.meeting(boxes[i], |j| {
            if j > i && nodes.len() <= ends + MOST {
                nodes.extend(crossing(chord, chords[j]));
            }
        });
        ensure!(nodes.len() <= ends + MOST, "the borders cross more than {MOST} times: give fewer curves");
    }
    nodes.sort_unstable();
    nodes.dedup();
    // By chord, then in the order in which the chord passes them: from square to square no coordinate turns back.
    let mut passed: Vec<(u32, i64, u32)> = Vec::with_capacity(3 * chords.len());
    for (number, &node) in nodes.iter().enumerate() {
        tree.meeting(bounds([real(node); 2], 0.0), |i| {
            let chord = chords[i];
            if passes(chord, node) {
                let [dx, dy] = minus(chord[1], chord[0]).map(i64::signum);
                passed.push((i as u32, dx * node[0] + dy * node[1], number as u32));
            }
        });
    }
    passed.sort_unstable();
    let mut first = 0;
    let paths = ranges.into_iter().map(|range| {
        let count = passed[first..].partition_point(|&(chord, ..)| (chord as usize) < range.end);
        let mut path: Vec<u32> = passed[first..first + count].iter().map(|&(.., node)| node).collect();
        first += count;
        path.dedup();
        path
    });
    let paths = paths.collect();
    Ok(Noded { nodes, paths })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Whether two pieces share a point besides a common end, by whole numbers alone.
    fn meet([a, b]: [Node; 2], [c, d]: [Node; 2]) -> bool {
        let on = |p: Node, [a, b]: [Node; 2]| {
            doubled([a, b, p]) == 0
                && p != a
                && p != b
                && (0..2).all(|k| p[k] >= a[k].min(b[k]) && p[k] <= a[k].max(b[k]))
        };
        crossing([a, b], [c, d]).is_some() || on(a, [c, d]) || on(b, [c, d]) || on(c, [a, b]) || on(d, [a, b])
    }

    fn pieces(noded: &Noded) -> Vec<[Node; 2]> {
        let ordered = |pair: &[u32]| [pair[0].min(pair[1]), pair[0].max(pair[1])];
        let all: BTreeSet<[u32; 2]> = noded.paths.iter().flat_map(|path| path.windows(2).map(ordered)).collect();
        all.into_iter().map(|pair| pair.map(|i| noded.nodes[i as usize])).collect()
    }

    #[test]
    fn pieces_meet_at_their_ends_alone_however_dense_the_scribble() {
        let mut random = fastrand::Rng::with_seed(11);
        let mut checked = 0;
        // On grids so coarse that every rounding moves a crossing across its neighbours, and on the real one.
        for (span, lines) in [(4, 5), (8, 10), (20, 12), (60, 25), (1000, 30), (GRID, 30)] {
            for _ in 0..60 {
                let mut point = || [random.i64(0..=span), random.i64(0..=span)];
                let borders: Vec<Vec<Node>> = (0..lines).map(|_| (0..3).map(|_| point()).collect()).collect();
                let noded = noded(&borders).unwrap();
                let pieces = pieces(&noded);
                for (i, &one) in pieces.iter().enumerate() {
                    assert!(pieces[..i].iter().all(|&two| !meet(one, two)), "{span} {one:?}");
                    checked += i;
                }
                // No path strays by more than a step, and none loses an end.
                for (border, path) in borders.iter().zip(&noded.paths) {
                    let distinct = border.windows(2).any(|pair| pair[0] != pair[1]);
                    assert_eq!(distinct, !path.is_empty());
                    if distinct {
                        let ends = [path[0], path[path.len() - 1]].map(|i| noded.nodes[i as usize]);
                        assert_eq!(ends, [border[0], border[2]]);
                    }
                }
            }
        }
        assert!(checked > 100_000, "{checked}");
    }

    #[test]
    fn a_square_of_the_grid_has_its_left_and_lower_sides() {
        // Through the corners of the square about (0, 0): of them the lower left one alone belongs to it.
        let touching =
            [([-1, 0], [0, -1], true), ([1, 0], [0, 1], false), ([-1, 0], [0, 1], false), ([0, -1], [1, 0], false)];
        for (a, b, expected) in touching {
            assert_eq!([passes([a, b], [0, 0]), passes([b, a], [0, 0])], [expected; 2], "{a:?} {b:?}");
        }
        assert!(passes([[-3, -2], [3, 2]], [0, 0]) && passes([[-2, 1], [3, -1]], [0, 0]));
        assert!(
            !passes([[-2, 1], [2, 1]], [0, 0]) && !passes([[1, 0], [5, 0]], [0, 0]) && passes([[0, 0], [5, 7]], [0, 0])
        );
    }

    #[test]
    fn the_longest_chords_cross_without_overflow() {
        let cross = noded(&[vec![[0, 0], [GRID, GRID]], vec![[0, GRID], [GRID, 0]]]).unwrap();
        assert_eq!(cross.nodes, [[0, 0], [0, GRID], [GRID / 2, GRID / 2], [GRID, 0], [GRID, GRID]]);
        assert_eq!(cross.paths, [vec![0, 2, 4], vec![1, 2, 3]]);
    }
}
