//! A tree of boxes over pieces of curves: which of them may meet a box.

use serde::{Deserialize, Serialize};

/// Left, bottom, right, top.
pub(crate) type Bounds = [f64; 4];

/// Children of a node: few enough that a level more costs little, many enough that the tree is a tenth of its leaves.
const FAN: usize = 8;

/// The box of two points, wider by `air` on all sides.
pub(crate) fn bounds([a, b]: [[f64; 2]; 2], air: f64) -> Bounds {
    [a[0].min(b[0]) - air, a[1].min(b[1]) - air, a[0].max(b[0]) + air, a[1].max(b[1]) + air]
}

/// Boxes in levels, each a box of eight below it. Pieces of a curve follow one another in space as in number, so that no sorting
/// is needed.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(from = "Vec<Bounds>", into = "Vec<Bounds>")]
pub(crate) struct BoxTree {
    levels: Vec<Vec<Bounds>>,
}

impl From<Vec<Bounds>> for BoxTree {
    fn from(leaves: Vec<Bounds>) -> Self {
        Self::new(leaves)
    }
}

impl From<BoxTree> for Vec<Bounds> {
    fn from(mut tree: BoxTree) -> Self {
        tree.levels.swap_remove(0)
    }
}

impl BoxTree {
    pub(crate) fn new(leaves: Vec<Bounds>) -> Self {
        let mut levels = vec![leaves];
        while let Some(last) = levels.last().filter(|last| last.len() > FAN) {
            let hull = |all: &[Bounds]| {
                all.iter().fold([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY], |hull, one| {
                    [hull[0].min(one[0]), hull[1].min(one[1]), hull[2].max(one[2]), hull[3].max(one[3])]
                })
            };
            let next = last.chunks(FAN).map(hull).collect();
            levels.push(next);
        }
        Self { levels }
    }

    /// Calls `each` with the number of every leaf that meets the box, borders included, in rising order.
    pub(crate) fn meeting(&self, wanted: Bounds, mut each: impl FnMut(usize)) {
        let top = self.levels.len() - 1;
        self.visit(top, 0..self.levels[top].len(), &wanted, &mut each);
    }

    fn visit(&self, level: usize, range: std::ops::Range<usize>, wanted: &Bounds, each: &mut impl FnMut(usize)) {
        for i in range {
            let own = &self.levels[level][i];
            if own[0] > wanted[2] || own[2] < wanted[0] || own[1] > wanted[3] || own[3] < wanted[1] {
                continue;
            }
            if level == 0 {
                each(i);
            } else {
                let last = self.levels[level - 1].len().min(FAN * (i + 1));
                self.visit(level - 1, FAN * i..last, wanted, each);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_what_a_walk_over_all_boxes_finds() {
        let mut random = fastrand::Rng::with_seed(5);
        let mut met = 0;
        for leaves in [0, 1, 7, 8, 9, 64, 65, 1000] {
            let mut point = || [random.f64(), random.f64()];
            let all: Vec<Bounds> = (0..leaves).map(|_| bounds([point(), point()], -0.02)).collect();
            let tree = BoxTree::new(all.clone());
            for _ in 0..50 {
                let wanted = bounds([point(), point()], 0.0);
                let mut found = Vec::new();
                tree.meeting(wanted, |i| found.push(i));
                let meets = |own: &Bounds| {
                    own[0] <= wanted[2] && wanted[0] <= own[2] && own[1] <= wanted[3] && wanted[1] <= own[3]
                };
                let expected: Vec<usize> = (0..leaves).filter(|&i| meets(&all[i])).collect();
                assert_eq!(found, expected);
                met += found.len();
            }
        }
        assert!(met > 10_000, "{met}");
    }
}
