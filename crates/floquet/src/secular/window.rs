//! F in one gap of a large ring: the poles near it one by one, the others as a polynomial (see [`super::cauchy`]), so that a
//! value costs the same for any number of modes.

use super::cauchy::{Tree, derivative};
use super::evaluate::{Far, Local};
use super::leaf::Leaf;
use super::pole::FAR_ROOT;
use super::residues::Residues;
use vibrochain_breather::lanes::{Lane, fill};

impl Residues {
    /// Divides the poles into leaves; for few of them there is nothing to divide.
    pub(crate) fn divide(&mut self, large: bool) {
        self.leaves.clear();
        if !large {
            return;
        }
        let poles = self.poles().to_vec();
        let charges: Vec<[f64; 2]> = self.residues().iter().zip(self.errors()).map(|(r, e)| [*r, *e]).collect();
        let total_error: f64 = self.errors().iter().sum();
        for field in Tree::new(&poles, false).fields(&poles, &charges, &Tree::new(&poles, true)) {
            let places: Vec<usize> = field.near.iter().flat_map(Clone::clone).collect();
            // Interpolation errs by 2e-14 of the kernels, which the sum of moduli overestimates rather than under.
            let rounding = 1e-14 * field.far[0].iter().map(|c| c.abs()).sum::<f64>();
            let mut leaf = Leaf {
                gaps: field.targets.clone(),
                middle: field.middle,
                scale: if field.half > 0.0 { 1.0 / field.half } else { 0.0 },
                value: field.far[0],
                slope: derivative(&field.far[0]),
                bend: derivative(&derivative(&field.far[0])),
                noise: rounding + field.far[1][0].abs() + total_error,
                rounding,
                residues: Vec::new(),
                errors: Vec::new(),
                shifts: Vec::new(),
                cos: Vec::new(),
                sin: Vec::new(),
            };
            for (own, all, pad) in [
                (&mut leaf.residues, &self.residues, 0.0),
                (&mut leaf.errors, &self.errors, 0.0),
                (&mut leaf.shifts, &self.shifts, 0.0),
                (&mut leaf.cos, &self.cos, FAR_ROOT),
                (&mut leaf.sin, &self.sin, FAR_ROOT),
            ] {
                fill(own, places.iter().map(|&place| all.as_flattened()[place]), pad);
            }
            self.leaves.push(leaf);
        }
    }

    /// A gap in the middle of a leaf, the offset of the leaf's middle from its left pole, and half the leaf's width.
    pub(crate) fn above(&self, leaf: usize) -> (usize, f64, f64) {
        let Leaf { gaps, middle, scale, .. } = &self.leaves[leaf];
        let gap = (gaps.start + gaps.len() / 2).min(self.count().saturating_sub(2));
        (gap, middle - self.poles()[gap], if *scale > 0.0 { 1.0 / scale } else { 0.0 })
    }

    /// F about the pole at `place`, for use in the gap right of the pole at `gap`. `distances` is scratch space.
    pub(crate) fn window<'a>(&'a self, gap: usize, place: usize, distances: &'a mut Vec<Lane>) -> Local<'a> {
        let leaf = self.leaves.partition_point(|leaf| leaf.gaps.end <= gap);
        let Some(leaf) = self.leaves.get(leaf) else {
            self.distances(place, distances);
            return self.about(distances);
        };
        self.table[place].distances(&leaf.cos, &leaf.sin, distances);
        let origin = (self.poles()[place] - leaf.middle) * leaf.scale;
        let far = Some(Far { leaf, origin });
        Local { residues: &leaf.residues, errors: &leaf.errors, shifts: &leaf.shifts, distances, far }
    }
}
