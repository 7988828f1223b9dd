//! The finest grid of a scene that is refined.

use vibrochain_floquet::Tolerance;
use vibrochain_lattice::Point;

use crate::cell::Cell;
use crate::extent::Extent;
use crate::scene::Scene;
use crate::scene::axis::{Axis, Values};
use crate::scene::refine::Refine;

impl Scene {
    /// The scene whose cells are those of the finest grid, all of them; the scene itself if it is not refined.
    #[must_use]
    pub fn finest(&self) -> Self {
        let axes = self.axes.iter().map(|axis| self.finer(axis)).collect();
        Self { axes, refine: None, ..self.clone() }
    }

    /// An axis of the finest grid: between the same ends.
    fn finer(&self, axis: &Axis) -> Axis {
        let values = match (&axis.values, self.refine) {
            (Values::Linear { from, to, points }, Some(refine)) => {
                Values::Linear { from: *from, to: *to, points: points << refine.depth }
            }
            (values, _) => values.clone(),
        };
        Axis { parameter: axis.parameter, values }
    }

    /// How many cells of the finest grid a cell is.
    #[must_use]
    pub fn cells_within(&self) -> u64 {
        self.refine.map_or(1, |refine| u64::from(refine.size()).pow(2))
    }

    /// The whole of cell number `cell`; nothing where the grid is not refined.
    #[must_use]
    pub fn extent(&self, cell: u64) -> Option<Extent> {
        let size = self.refine?.size();
        let columns = self.axes.first()?.points() as u64;
        // A million cells at most, and a million columns and rows of the finest grid.
        let [column, row] = [cell % columns, cell / columns].map(|place| place as u32 * size);
        Some(Extent { column, row, size })
    }

    /// What a refined map may lack, in words; nothing of one that is not refined.
    #[must_use]
    pub fn may_miss(&self) -> Option<String> {
        let Refine { depth } = self.refine?;
        let sizes = self.axes.iter().map(|axis| {
            let [from, to] = axis.limits();
            let step = (to - from) / ((axis.points() << depth) - 1) as f64;
            format!("{:.2e} in {}", step * f64::from(1 << depth), axis.parameter.name())
        });
        let sizes: Vec<String> = sizes.collect();
        let sizes = sizes.join(", ");
        let [families, words] = [!self.task.families.is_empty(), !self.task.words.is_empty()];
        let besides = match (self.loses_stability_in_stripes(), families, words) {
            (false, ..) | (true, false, false) => "",
            (true, true, false) => "; thin stripes where two modes meet were followed, others not",
            (true, true, true) => "; thin stripes of families were followed where two modes meet, those of words not",
            (true, false, true) => "; thin stripes of words were not followed",
        };
        Some(format!(
            "what lies within cells of the grid ({sizes}) and meets none of the points computed, such as islands, tips, and bands \
             thinner than that{besides}"
        ))
    }

    /// Whether breathers lose stability in stripes, however thin: conservative ones, of which no growth is allowed.
    fn loses_stability_in_stripes(&self) -> bool {
        self.is_conservative() && self.task.stability && self.task.tolerance == Tolerance::Rounding
    }

    /// The point at which a cell of the grid, or a leaf of it, is computed.
    #[must_use]
    pub fn point_of(&self, number: u64, cell: &Cell) -> Point {
        cell.extent.map_or_else(|| self.point(number), |extent| self.sample(extent))
    }

    /// Moves a point to these places along the axes.
    pub(crate) fn set(&self, point: &mut Point, at: [u32; 2]) {
        self.axes.iter().zip(at).for_each(|(axis, place)| point.set(axis.parameter, axis.value(place as usize)));
    }

    /// The point at which a leaf is computed.
    #[must_use]
    pub fn sample(&self, extent: Extent) -> Point {
        let pairs = self.axes.iter().zip(extent.sample());
        pairs.fold(self.base, |point, (axis, i)| point.with(axis.parameter, self.finer(axis).value(i as usize)))
    }
}
