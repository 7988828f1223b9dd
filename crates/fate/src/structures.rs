//! Ensembles over a structure's scene: many runs from the orbits of every point, or from rest.

use std::ops::Range;

use rayon::ThreadPool;
use vibrochain_breather::{StructureModel, structure_is_physical, structure_orbits};
use vibrochain_floquet::structure_stability;
use vibrochain_lattice::Stop;
use vibrochain_maps::cell::{Cell, Class, Status};
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::sweep::Ended;

use crate::ensemble::Ensemble;
use crate::fates::{CellFates, Cells, Departure, Found, From, of_parts, predicted};
use crate::origin::OfStructure;
use crate::run::Home;

/// An orbit as runs start from it, and whether it is stable where that is decided.
type Judged = (Departure<OfStructure>, Option<bool>);

/// The fates of a structure's scene: its point, or all points of its axes, the first of which is the fastest.
#[derive(Debug)]
pub struct StructureFates<'a> {
    scene: &'a StructureScene,
    ensemble: Ensemble,
    from: From,
}

impl<'a> StructureFates<'a> {
    /// Of a scene and what is asked.
    #[must_use]
    pub fn new(scene: &'a StructureScene, ensemble: Ensemble, from: From) -> Self {
        Self { scene, ensemble, from }
    }

    /// Number of points.
    #[must_use]
    pub fn cells(&self) -> u64 {
        self.scene.axes.iter().map(|axis| axis.points as u64).product()
    }

    /// Computes all points and hands them to `sink` in order. `tick` is called with each number of runs that is done.
    pub fn compute<E>(
        &self,
        (pool, stop): (&ThreadPool, &Stop),
        tick: impl Fn(u64) + Sync,
        mut sink: impl FnMut(CellFates<Vec<f64>>) -> Result<(), E>,
    ) -> Ended<E> {
        let whole: Range<u64> = 0..self.cells();
        of_parts(self, (pool, stop), &self.ensemble, &[whole], tick, |_, _, cell| sink(cell))
    }

    /// The model of a point.
    fn model(&self, number: u64) -> Result<StructureModel, String> {
        let mut scene = self.scene.clone();
        for (axis, value) in self.scene.axes.iter().zip(self.point(number)) {
            scene.set(axis.setting, value)?;
        }
        scene.model()
    }

    /// The physical orbits of all words that are asked for.
    fn departures(&self, model: &StructureModel) -> (Vec<Judged>, Status) {
        let (mut all, mut status) = (Vec::new(), Status::Ok);
        for (word, periods) in self.scene.asked() {
            let Ok(found) = structure_orbits(model, &word, periods) else {
                status = Status::NotConverged;
                continue;
            };
            for orbit in &found.orbits {
                if !structure_is_physical(orbit).is_ok_and(|answer| answer.is_physical()) {
                    continue;
                }
                let Ok(home) = Home::of_structure(orbit) else { continue };
                let known = structure_stability(orbit, self.scene.tolerance).ok();
                let verdict = known.as_ref().map(|known| known.verdict);
                let departure = Departure {
                    number: all.len() as u32 + 1,
                    name: orbit.name(),
                    spectral_radius: verdict.map(|verdict| verdict.spectral_radius),
                    predicted: known.and_then(|known| predicted(&known, orbit.period())),
                    measured: true,
                    home,
                };
                all.push((departure, verdict.filter(|verdict| !verdict.marginal).map(|verdict| verdict.stable)));
            }
        }
        (all, status)
    }
}

impl Cells for StructureFates<'_> {
    type Origin = OfStructure;
    type Point = Vec<f64>;
    type Worker = ();

    fn worker(&self) {}

    fn point(&self, number: u64) -> Vec<f64> {
        let mut rest = number as usize;
        let value = |axis: &vibrochain_maps::structure::scene::StructureAxis| {
            let at = rest % axis.points;
            rest /= axis.points;
            axis.value(at)
        };
        self.scene.axes.iter().map(value).collect()
    }

    fn find(&self, number: u64, (): &mut ()) -> Option<Found<OfStructure>> {
        let Ok(model) = self.model(number) else {
            let cell = Cell { class: None, status: Status::IllConditioned, ..Cell::EMPTY };
            return Some(Found { cell, departures: Vec::new() });
        };
        if self.from == From::Rest {
            let rest = Departure {
                number: 1,
                name: "rest".to_owned(),
                spectral_radius: None,
                predicted: None,
                measured: false,
                home: Home::at_rest(&model),
            };
            return Some(Found { cell: Cell::EMPTY, departures: vec![rest] });
        }
        let (mut all, status) = self.departures(&model);
        let solutions = all.len() as u32;
        match self.from {
            From::Unstable => all.retain(|(_, stable)| *stable == Some(false)),
            From::Class => {
                let best = all.iter().position(|(_, stable)| *stable == Some(true)).unwrap_or(0);
                all = all.into_iter().skip(best).take(1).collect();
            }
            From::Every | From::Rest => {}
        }
        let class = if solutions == 0 { Some(Class::None) } else { Some(Class::Word) };
        let departures = all.into_iter().map(|(departure, _)| departure).collect();
        Some(Found { cell: Cell { class, solutions, status, ..Cell::EMPTY }, departures })
    }
}
