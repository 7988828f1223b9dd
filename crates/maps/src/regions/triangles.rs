//! Triangles between the corners of borders, no side of which crosses a border.

use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use crate::error::MapError;
use crate::regions::noding::{GRID, Node, doubled};
use crate::regions::smooth::Place;

/// A side of a triangle, seen from the triangle on its left; sides are named by number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Side {
    /// The node it comes from.
    pub(crate) from: u32,
    /// The next side of the triangle, counterclockwise.
    pub(crate) next: u32,
    /// The same seen from the other triangle.
    pub(crate) twin: u32,
    /// Whether a border runs along it.
    pub(crate) border: bool,
    /// Whether it is seen from outside the window.
    pub(crate) outer: bool,
}

/// The triangles of all nodes, with borders along `pieces`, which meet at their ends alone.
///
/// # Errors
/// [`MapError::Computation`] if they do not.
pub(crate) fn triangulated(nodes: &[Node], pieces: &[[u32; 2]]) -> Result<Vec<Side>, MapError> {
    let failed = |what: String| MapError::Computation(format!("the borders could not be triangulated: {what}"));
    // Whole numbers that f64 holds exactly; what decides are exact predicates.
    let points: Vec<Point2<f64>> = nodes.iter().map(|&[x, y]| Point2::new(x as f64, y as f64)).collect();
    let pieces: Vec<[usize; 2]> = pieces.iter().map(|pair| pair.map(|node| node as usize)).collect();
    let (corners, count, mut refused) = (points.len(), pieces.len(), 0);
    let triangles: ConstrainedDelaunayTriangulation<Point2<f64>> =
        ConstrainedDelaunayTriangulation::try_bulk_load_cdt(points, pieces, |_| refused += 1)
            .map_err(|error| failed(error.to_string()))?;
    if refused > 0 || triangles.num_vertices() != corners || triangles.num_constraints() != count {
        return Err(failed(format!("{refused} of {count} pieces of borders cross others")));
    }
    let side = |edge: spade::handles::DirectedEdgeHandle<'_, Point2<f64>, (), spade::CdtEdge<()>, ()>| Side {
        from: edge.from().index() as u32,
        next: edge.next().index() as u32,
        twin: edge.rev().index() as u32,
        border: edge.is_constraint_edge(),
        outer: edge.is_outer_edge(),
    };
    Ok(triangles.directed_edges().map(side).collect())
}

/// A triangle by its corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Triangle(pub(crate) [Node; 3]);

impl Triangle {
    /// Twice its area, in steps of the grid.
    pub(crate) fn doubled(&self) -> f64 {
        doubled(self.0) as f64
    }

    /// Lengths of the sides, each opposite to the corner of the same number.
    fn sides(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| {
            let (a, b) = (self.0[(k + 1) % 3], self.0[(k + 2) % 3]);
            ((b[0] - a[0]) as f64).hypot((b[1] - a[1]) as f64)
        })
    }

    /// Radius of the circle that touches all sides, in steps.
    pub(crate) fn radius(&self) -> f64 {
        self.doubled() / self.sides().iter().sum::<f64>()
    }

    /// Its centre. In a needle it lies beside the short side, where corners are on the curves, whatever the error of the long
    /// chords.
    pub(crate) fn centre(&self) -> Place {
        self.mean(self.sides())
    }

    /// The mean of the corners with these weights.
    fn mean(&self, weights: [f64; 3]) -> Place {
        let all: f64 = weights.iter().sum();
        // From the first corner on: a narrow triangle has no room for rounding.
        [0, 1].map(|k| {
            let off = |i: usize| (self.0[i][k] - self.0[0][k]) as f64 * weights[i];
            (self.0[0][k] as f64 + (off(1) + off(2)) / all) / GRID as f64
        })
    }

    /// The point with two coordinates of the unit square, which fill the triangle evenly, if it keeps a distance (a part of the
    /// window) from all sides; the centre of the circle if not.
    pub(crate) fn point(&self, [s, t]: Place, distance: f64) -> Place {
        let [s, t] = if s + t > 1.0 { [1.0 - s, 1.0 - t] } else { [s, t] };
        let weights = [1.0 - s - t, s, t];
        let (sides, doubled) = (self.sides(), self.doubled());
        let clear = (0..3).all(|k| weights[k] * doubled >= distance * GRID as f64 * sides[k]);
        if clear { self.mean(weights) } else { self.centre() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centre_of_a_needle_lies_beside_its_short_side() {
        let needle = Triangle([[1000, 0], [GRID, 500], [0, 1000]]);
        let [x, y] = needle.centre().map(|part| part * GRID as f64);
        // About as far from both long sides as half the short one.
        assert!(x < 1500.0 && (y - 500.0).abs() < 500.0, "{x} {y}");
        let distance = |[a, b]: [Node; 2]| {
            let (dx, dy) = ((b[0] - a[0]) as f64, (b[1] - a[1]) as f64);
            (dx * (y - a[1] as f64) - dy * (x - a[0] as f64)) / dx.hypot(dy)
        };
        let [a, b, c] = needle.0;
        for side in [[a, b], [b, c], [c, a]] {
            assert!((distance(side) / needle.radius() - 1.0).abs() < 1e-3, "{} {}", distance(side), needle.radius());
        }
    }

    #[test]
    fn points_keep_their_distance_and_fill_the_triangle() {
        let large = Triangle([[0, 0], [GRID, 0], [0, GRID]]);
        let mut random = fastrand::Rng::with_seed(2);
        let mut sum = [0.0; 2];
        for _ in 0..10_000 {
            let [x, y] = large.point([random.f64(), random.f64()], 0.01);
            assert!(x >= 0.01 && y >= 0.01 && x + y <= 1.0 - 0.014, "{x} {y}");
            sum = [sum[0] + x, sum[1] + y];
        }
        assert!(sum.iter().all(|sum| (sum / 10_000.0 - 1.0 / 3.0).abs() < 0.01), "{sum:?}");
        assert_eq!(large.point([0.001, 0.5], 0.01), large.centre());
    }
}
