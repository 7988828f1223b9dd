//! The finest grid of a scene that is refined.

use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Parameter, Point};

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
    pub(crate) fn finer(&self, axis: &Axis) -> Axis {
        let values = match (&axis.values, self.refine) {
            (Values::Linear { from, to, points }, Some(refine)) => {
                Values::Linear { from: *from, to: *to, points: points << refine.depth }
            }
            (values, _) => values.clone(),
        };
        Axis { parameter: axis.parameter, values }
    }

    /// What a refined map may lack, in words; nothing of one that is not refined.
    pub(crate) fn may_miss(&self) -> Option<String> {
        let Refine { depth } = self.refine?;
        let sizes = self.axes.iter().map(|axis| {
            let [from, to] = axis.limits();
            let step = (to - from) / ((axis.points() << depth) - 1) as f64;
            format!("{:.2e} in {}", step * f64::from(1 << depth), axis.parameter.name())
        });
        let sizes: Vec<String> = sizes.collect();
        let sizes = sizes.join(", ");
        let besides = if self.follows_orders() {
            "; stripes of instability that pass between such points were followed, however thin"
        } else if !self.loses_stability_in_stripes() || self.task.families.is_empty() {
            ""
        } else if self.is_conservative() {
            "; thin stripes where two modes meet were followed, others not"
        } else {
            "; thin stripes were not followed"
        };
        Some(format!(
            "what lies within cells of the grid ({sizes}) and meets none of the points computed, such as islands, tips, and bands \
             thinner than that{besides}"
        ))
    }

    /// Whether breathers lose stability in stripes, however thin: without losses, and if no excess is allowed.
    fn loses_stability_in_stripes(&self) -> bool {
        let elastic = !self.sweeps(Parameter::Restitution) && self.base.get(Parameter::Restitution) == 1.0;
        elastic && self.task.stability && self.task.tolerance == Tolerance::Rounding
    }

    /// Whether stripes are found by the order of signatures. Maps of families alone, whose cells take far less time than an order, follow
    /// stripes by the modes that meet.
    pub(crate) fn follows_orders(&self) -> bool {
        self.loses_stability_in_stripes() && !self.task.words.is_empty()
    }

    /// Moves a point to these places along the axes.
    pub(crate) fn set(&self, point: &mut Point, at: [u32; 2]) {
        self.axes.iter().zip(at).for_each(|(axis, place)| point.set(axis.parameter, axis.value(place as usize)));
    }
}
