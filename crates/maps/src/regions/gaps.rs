//! Where a face holds more than one class: the way from one to the other, and the neck that it passes through.
//!
//! Two borders that should meet may end a little short of each other. The face then reaches through the gap between them to what lives
//! on the other side. The widest way from a place to one where something else lives has its narrowest side in that gap.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use crate::regions::noding::{GRID, place};
use crate::regions::subdivision::{Subdivision, THIN};

/// A gap between ends of borders, as a part of the window, that may be closed where it is narrowest.
pub(crate) const GAP: f64 = 1e-4;

/// Where a face changes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Neck {
    /// The narrowest side between two triangles where different classes live.
    pub(crate) side: u32,
    /// Its length, as a part of the window.
    pub(crate) length: f64,
    /// Places on either side of it, in units of the axes.
    pub(crate) between: [[f64; 2]; 2],
}

/// A place in a triangle, in units of the axes, and what lives there.
pub(crate) struct Spot<T> {
    pub(crate) triangle: u32,
    pub(crate) point: [f64; 2],
    pub(crate) lives: T,
}

/// What is taken up the widest first, of as wide ones the least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Widest<T> {
    pub(crate) width: f64,
    pub(crate) what: T,
}

impl<T: PartialEq> Eq for Widest<T> {}

impl<T: Ord> Ord for Widest<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.width.total_cmp(&other.width).then_with(|| other.what.cmp(&self.what))
    }
}

impl<T: Ord> PartialOrd for Widest<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Subdivision {
    fn corners(&self, side: u32) -> [u32; 3] {
        let second = self.sides[side as usize].next;
        [side, second, self.sides[second as usize].next]
    }

    /// One name for a triangle, whichever of its sides it is called by.
    fn name(&self, side: u32) -> u32 {
        self.corners(side).into_iter().min().unwrap_or(side)
    }

    /// The sides crossed on the widest way through a face from one triangle to another, seen from where it comes from.
    fn way(&self, from: u32, to: u32) -> Vec<u32> {
        let (from, to) = (self.name(from), self.name(to));
        let mut came: HashMap<u32, u32> = HashMap::new();
        let mut next = BinaryHeap::from([Widest { width: f64::INFINITY, what: from }]);
        let mut done = std::collections::HashSet::new();
        let mut widths: HashMap<u32, f64> = HashMap::from([(from, f64::INFINITY)]);
        while let Some(Widest { width, what: triangle }) = next.pop() {
            if triangle == to {
                break;
            }
            if !done.insert(triangle) {
                continue;
            }
            for side in self.corners(triangle) {
                if self.sides[side as usize].border {
                    continue;
                }
                let other = self.name(self.sides[side as usize].twin);
                let width = width.min(self.length(side));
                if widths.get(&other).is_none_or(|known| *known < width) {
                    widths.insert(other, width);
                    came.insert(other, side);
                    next.push(Widest { width, what: other });
                }
            }
        }
        let (mut sides, mut at) = (Vec::new(), to);
        while at != from {
            let Some(&side) = came.get(&at) else { return Vec::new() };
            sides.push(side);
            at = self.name(side);
        }
        sides.reverse();
        sides
    }

    /// Where what lives in a face changes between two places of it.
    pub(crate) fn neck<T: PartialEq>(
        &self,
        from: Spot<T>,
        to: Spot<T>,
        mut class: impl FnMut([f64; 2]) -> Option<T>,
    ) -> Option<Neck> {
        let way = self.way(from.triangle, to.triangle);
        // Nearer to a border than its error a triangle may be on its other side.
        let clear = THIN.max(2.0 * self.tolerance * GRID as f64);
        let last = from.lives;
        let mut line = vec![from.point];
        let mut narrowest: Option<(f64, u32)> = None;
        for (i, &side) in way.iter().enumerate() {
            let length = self.length(side);
            if narrowest.is_none_or(|(other, _)| length < other) {
                narrowest = Some((length, side));
            }
            // From triangle to triangle through the sides between, so that no border is crossed.
            line.push(self.middle(side));
            let triangle = self.triangle(self.sides[side as usize].twin);
            let (point, here) = if i + 1 == way.len() {
                (to.point, None)
            } else if triangle.radius() < clear {
                continue;
            } else {
                let point = self.window.point(triangle.centre());
                let Some(here) = class(point) else { continue };
                (point, Some(here))
            };
            line.push(point);
            let here = here.as_ref().unwrap_or(&to.lives);
            if *here != last {
                let (length, side) = narrowest?;
                let changes = |point: &[f64; 2]| class(*point).is_some_and(|one| one != last);
                let changed = line.iter().skip(1).position(changes).unwrap_or(line.len() - 2);
                return Some(Neck { side, length, between: [line[changed], line[changed + 1]] });
            }
            (line, narrowest) = (vec![point], None);
        }
        None
    }

    /// Closes gaps: these sides are borders from now on.
    pub(crate) fn close(&mut self, gaps: &[u32]) {
        for &side in gaps {
            let twin = self.sides[side as usize].twin;
            let ends = [side, twin].map(|side| self.sides[side as usize].from);
            self.sides[side as usize].border = true;
            self.sides[twin as usize].border = true;
            // With the edge of the window: no curve of anyone's.
            if let Some(edge) = self.paths.last_mut() {
                edge.push(ends.to_vec());
            }
        }
        self.find_faces();
    }

    /// The middle of a side, in units of the axes.
    pub(crate) fn middle(&self, side: u32) -> [f64; 2] {
        let [a, b] = self.ends(side).map(place);
        self.window.point([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])])
    }
}
