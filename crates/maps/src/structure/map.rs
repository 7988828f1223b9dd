//! What lives at each point of a structure's map: a row a point, every word asked for.

use rayon::prelude::*;
use vibrochain_breather::{StructureModel, structure_candidates, structure_is_physical};
use vibrochain_floquet::{Verdict, structure_verdict};
use vibrochain_lattice::Stop;

use super::scene::StructureScene;
use super::setting::Setting;

/// What a point says.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureCell {
    /// Values of the axes.
    pub at: [Option<f64>; 2],
    /// Number of physical orbits of the words asked for.
    pub solutions: usize,
    /// The word of the best of them, with its periods of the load where these are several: a stable one if there is one, of several the first;
    /// its verdict and its margin.
    pub best: Option<(String, Option<Verdict>, Option<f64>)>,
    /// Why something could not be worked out.
    pub trouble: Option<String>,
}

impl StructureCell {
    /// `none`, `unknown` where something could not be worked out, or `stable`, `marginal`, `unstable`, `physical` with the word behind it.
    #[must_use]
    pub fn class(&self) -> String {
        match &self.best {
            None if self.trouble.is_some() => "unknown".to_owned(),
            None => "none".to_owned(),
            Some((word, verdict, _)) => {
                let how = match verdict {
                    None => "physical",
                    Some(verdict) if verdict.stable => "stable",
                    Some(verdict) if verdict.marginal => "marginal",
                    Some(_) => "unstable",
                };
                format!("{how} {word}")
            }
        }
    }
}

/// The map of a scene.
#[derive(Debug)]
pub struct StructureMap<'a> {
    scene: &'a StructureScene,
}

impl<'a> StructureMap<'a> {
    /// The map of a scene that has axes and words.
    ///
    /// # Errors
    /// What is missing.
    pub fn new(scene: &'a StructureScene) -> Result<Self, String> {
        if scene.axes.is_empty() {
            return Err("the scene sweeps nothing: give [sweep] with an axis x".to_owned());
        }
        if scene.words.is_empty() {
            return Err("the scene asks for no words: give [compute] with families = [\"0+\", …]".to_owned());
        }
        Ok(Self { scene })
    }

    /// Number of points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.scene.axes.iter().map(|axis| axis.points).product()
    }

    /// All points of one value of the slow axis, or of the only one.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.scene.axes.get(1).map_or(1, |axis| axis.points)
    }

    /// One row, its points in parallel; `None` once `stop` is raised.
    #[must_use]
    pub fn row(&self, row: usize, stop: &Stop) -> Option<Vec<StructureCell>> {
        // What is slow to change is changed once.
        let mut scene = self.scene.clone();
        let slow = self.scene.axes.get(1).map(|axis| (axis.value(row), scene.set(axis.setting, axis.value(row))));
        let (value, set) = slow.map_or((None, Ok(())), |(value, set)| (Some(value), set));
        let fast = self.scene.axes[0];
        // Of another frequency alone the structure is the same all along.
        let base = if fast.setting == Setting::Omega { set.clone().and_then(|()| scene.model()).ok() } else { None };
        let model = |column: usize| -> Result<StructureModel, String> {
            if let Some(base) = &base {
                return base.at(fast.value(column)).map_err(|error| error.to_string());
            }
            set.clone()?;
            let mut scene = scene.clone();
            scene.set(fast.setting, fast.value(column))?;
            scene.model()
        };
        let cell = |column: usize| {
            (!stop.is_raised()).then(|| {
                let at = [Some(fast.value(column)), value];
                match model(column) {
                    Ok(model) => self.cell(&model, at),
                    Err(why) => StructureCell { at, solutions: 0, best: None, trouble: Some(why) },
                }
            })
        };
        (0..fast.points).into_par_iter().map(cell).collect()
    }

    /// One point.
    fn cell(&self, model: &StructureModel, at: [Option<f64>; 2]) -> StructureCell {
        let scene = self.scene;
        let mut cell = StructureCell { at, solutions: 0, best: None, trouble: None };
        for asked in &scene.words {
            let found = match structure_candidates(model, &asked.0, asked.1) {
                Ok(found) => found,
                Err(error) => {
                    cell.trouble = Some(error.to_string());
                    continue;
                }
            };
            for orbit in &found.orbits {
                let physical = match structure_is_physical(orbit) {
                    Ok(answer) if answer.is_physical() => answer,
                    Ok(_) => continue,
                    Err(error) => {
                        cell.trouble = Some(error.to_string());
                        continue;
                    }
                };
                cell.solutions += 1;
                let verdict = if scene.stability {
                    match structure_verdict(orbit, scene.tolerance) {
                        Ok(verdict) => Some(verdict),
                        Err(error) => {
                            cell.trouble = Some(error.to_string());
                            None
                        }
                    }
                } else {
                    None
                };
                let rank = |verdict: &Option<Verdict>| {
                    verdict.map_or(0, |verdict| if verdict.stable { 2 } else { usize::from(verdict.marginal) })
                };
                let better = cell.best.as_ref().is_none_or(|(_, other, _)| rank(&verdict) > rank(other));
                if better {
                    cell.best = Some((StructureScene::name_of(asked), verdict, physical.margin));
                }
            }
        }
        cell
    }
}
