//! A structure's scene as a grid: what lives at each point of its map, every word asked for.

use std::ops::Range;
use std::path::Path;

use serde_json::{Map, Value as Json};
use vibrochain_breather::{Admissibility, ContactOrbit, Finder, LoadedStructure, MapSearch, Word};
use vibrochain_floquet::{Analyser, BlochProblem, Tolerance};
use vibrochain_lattice::Stop;

use super::answer;
use super::cell::{COLUMNS, StructureCell, StructureClass};
use super::named::MOST_FILE_BYTES;
use super::scene::StructureScene;
use super::setting::Setting;
use crate::absence::Absence;
use crate::cell::{Cell, Class, Status};
use crate::error::MapError;
use crate::first_obstruction::FirstObstruction;
use crate::grid::{Files, Grid};
use crate::scene::{Axis, MAX_BYTES};
use crate::standing::{Standing, unstable_beyond};
use crate::table::columns::{Column, common};

/// Work of a chunk, in cells of one mode and one word of one impact, each some five microseconds.
const CHUNK_WORK: u64 = 1 << 15;

/// What a word of one impact costs, one of two, whose list is proved complete, and a longer one, which is sought from many starts.
const OF_WORDS: [u64; 3] = [1, 8, 1024];

/// The least cells of a chunk, and the most.
const CHUNK_CELLS: [u64; 2] = [16, 4096];

/// Times that threads take cells of a chunk: some milliseconds of work each.
const TAKES: u64 = 16;

/// The scene of the row that a thread is in: what is slow to change is changed once.
#[derive(Debug, Default)]
pub struct RowOfModels {
    row: Option<u64>,
    /// With the slow axes where they are.
    scene: Option<Result<StructureScene, String>>,
    /// Along a row of frequencies the structure is the same: its model at one of them.
    base: Option<LoadedStructure>,
    finder: Finder,
    analyser: Analyser,
    stop: Stop,
}

impl RowOfModels {
    /// The model of cell number `cell` of a scene.
    ///
    /// # Errors
    /// Why there is none.
    pub fn model(&mut self, whole: &StructureScene, cell: u64) -> Result<LoadedStructure, String> {
        let fast = whole.axes.first();
        let points = fast.map_or(1, |axis| axis.points() as u64);
        let (column, row) = ((cell % points) as usize, cell / points);
        if self.row != Some(row) {
            let point = whole.point(cell).into_iter().skip(1);
            let whole = whole.clone().until(&self.stop);
            let scene = point.into_iter().try_fold(whole, |mut scene, (parameter, value)| {
                scene.set(parameter, value)?;
                Ok(scene)
            });
            let omega_alone = fast.is_some_and(|axis| axis.parameter == Setting::Omega);
            (self.row, self.base, self.scene) = (Some(row), None, None);
            match scene {
                Ok(scene) if omega_alone && scene.omega().is_some() => match scene.into_model() {
                    Ok(base) => self.base = Some(base),
                    Err(error) => self.scene = Some(Err(error)),
                },
                scene => self.scene = Some(scene),
            }
        }
        if let (Some(base), Some(fast)) = (&self.base, fast) {
            return base.at(fast.value(column)).map_err(|error| error.to_string());
        }
        let mut scene = self.scene.clone().unwrap_or_else(|| Ok(whole.clone()))?;
        if let Some(fast) = fast {
            scene.set(fast.parameter, fast.value(column))?;
        }
        scene.model()
    }
}

/// A physical orbit of a cell.
struct Candidate<'a> {
    /// The number of its word.
    word: usize,
    margin: Option<f64>,
    orbit: &'a ContactOrbit,
}

/// The best of these, and how it stands; into `trouble` why the verdict of one is not known.
fn best_of<'a>(
    candidates: &'a [Candidate<'a>],
    scene: &StructureScene,
    analyser: &mut Analyser,
    trouble: &mut Option<String>,
) -> Option<(&'a Candidate<'a>, Standing)> {
    let unknown = |candidate: &Candidate<'_>| Standing { word: candidate.word, verdict: None };
    if !scene.stability {
        return candidates.first().map(|first| (first, unknown(first)));
    }
    let least = unstable_beyond(scene.tolerance);
    // Those that are surely unstable come last: where another one is stable, they need no verdict.
    let (surely, open): (Vec<_>, Vec<_>) = candidates
        .iter()
        .map(|candidate| (candidate, BlochProblem::of(candidate.orbit)))
        .partition(|(_, multipliers)| multipliers.surely_exceeds(least));
    let mut best: Option<(&Candidate<'_>, Standing)> = None;
    for (candidate, multipliers) in open.into_iter().chain(surely) {
        let other = (candidate.word, candidate.orbit.is_conservative());
        let exceeds = |reach| multipliers.surely_exceeds(reach);
        if best.as_ref().is_some_and(|(_, best)| best.keeps_its_place(other, scene.tolerance, exceeds)) {
            continue;
        }
        let verdict =
            multipliers.quick_verdict(analyser, scene.tolerance).map_err(|error| *trouble = Some(error.to_string()));
        let standing = Standing { verdict: verdict.ok(), ..unknown(candidate) };
        if best.as_ref().is_none_or(|(_, best)| standing.beats(best)) {
            best = Some((candidate, standing));
        }
    }
    best
}

/// One point.
fn cell_of(
    scene: &StructureScene,
    model: &LoadedStructure,
    finder: &mut Finder,
    analyser: &mut Analyser,
) -> StructureCell {
    in_closed_form(scene, model, finder, analyser).unwrap_or_else(|| by_search(scene, model, finder, analyser))
}

/// The cell from [`vibrochain_breather::MapOrbit`]s, which take a tenth of the time of a search; `None` where they cannot tell all of it.
/// [`by_search`], which this is held against, always can.
fn in_closed_form(
    scene: &StructureScene,
    model: &LoadedStructure,
    finder: &mut Finder,
    analyser: &mut Analyser,
) -> Option<StructureCell> {
    let mut cell = StructureCell::EMPTY;
    let mut best: Option<(Option<f64>, Standing)> = None;
    let mut way = None;
    for (number, (word, periods)) in scene.words.iter().enumerate() {
        let orbit = match finder.map_orbit(model, word, *periods) {
            MapSearch::Open => return None,
            MapSearch::None => continue,
            MapSearch::One(orbit) => orbit,
        };
        if let Some(obstruction) = orbit.obstruction() {
            way.get_or_insert_with(|| FirstObstruction::of(orbit.period(), orbit.times(), &obstruction));
            continue;
        }
        cell.found.solutions += 1;
        cell.found.residual = cell.found.residual.max(orbit.residual());
        let keeps = |best: &Standing| best.keeps_its_place((number, true), scene.tolerance, |_| false);
        if scene.stability && best.as_ref().is_some_and(|(_, best)| keeps(best)) {
            continue;
        }
        let verdict = match scene.stability {
            true => Some(analyser.map_orbit_verdict(&orbit, scene.tolerance)?),
            false => None,
        };
        let standing = Standing { word: number, verdict };
        if best.as_ref().is_none_or(|(_, best)| standing.beats(best)) {
            best = Some((orbit.margin(), standing));
        }
    }
    Some(match best {
        Some((margin, standing)) => told(scene, cell, (margin, standing)),
        None => absent(cell, way),
    })
}

fn by_search(
    scene: &StructureScene,
    model: &LoadedStructure,
    finder: &mut Finder,
    analyser: &mut Analyser,
) -> StructureCell {
    let mut cell = StructureCell::EMPTY;
    let lists: Vec<_> = scene.words.iter().map(|(word, periods)| model.candidates(word, *periods)).collect();
    let mut candidates = Vec::new();
    let mut way: Option<(Absence, FirstObstruction)> = None;
    for (word, found) in lists.iter().enumerate() {
        let found = match found {
            Ok(found) => found,
            Err(error) => {
                cell.trouble = Some(error.to_string());
                continue;
            }
        };
        cell.found.status = cell.found.status.max(Status::of_list(found.completeness));
        for orbit in &found.orbits {
            let Some(contacts) = orbit.contacts() else { continue };
            let physical = match finder.quick_admissibility(orbit) {
                Ok(Admissibility { obstruction: Some(obstruction), .. }) => {
                    let times = orbit.impacts().iter().map(|impact| impact.time);
                    way.get_or_insert_with(|| FirstObstruction::of(orbit.period(), times, &obstruction));
                    continue;
                }
                Ok(answer) => answer,
                Err(error) => {
                    cell.trouble = Some(error.to_string());
                    continue;
                }
            };
            cell.found.solutions += 1;
            cell.found.residual = cell.found.residual.max(orbit.residual());
            candidates.push(Candidate { word, margin: physical.margin, orbit: contacts });
        }
    }
    let Some((best, standing)) = best_of(&candidates, scene, analyser, &mut cell.trouble) else {
        if cell.trouble.is_some() {
            return StructureCell { class: StructureClass::Unknown, ..cell };
        }
        return absent(cell, way);
    };
    told(scene, cell, (best.margin, standing))
}

/// The cell without a physical orbit, and what is in the way of the first candidate.
fn absent(cell: StructureCell, way: Option<(Absence, FirstObstruction)>) -> StructureCell {
    let missed = if cell.found.status == Status::Ok { Absence::NoOrbit } else { Absence::NotFound };
    let absence = Some(way.map_or(missed, |(reason, _)| reason));
    let found = Cell { absence, obstruction: way.map(|(_, way)| way), ..cell.found };
    StructureCell { class: StructureClass::None, found, ..cell }
}

/// The cell of an orbit of this margin.
fn told(scene: &StructureScene, cell: StructureCell, (margin, best): (Option<f64>, Standing)) -> StructureCell {
    let Standing { word, verdict } = best;
    let class = match verdict {
        None => StructureClass::Physical,
        Some(verdict) if verdict.stable => StructureClass::Stable,
        Some(verdict) if verdict.undecided => StructureClass::Undecided,
        Some(_) => StructureClass::Unstable,
    };
    let found = Cell {
        mechanism: verdict.and_then(|verdict| verdict.mechanism),
        spectral_radius: verdict.map(|verdict| verdict.spectral_radius),
        margin,
        ..cell.found
    };
    StructureCell { class, word: scene.names().get(word).cloned(), found, ..cell }
}

impl Grid for StructureScene {
    type Parameter = Setting;
    type Point = Vec<(Setting, f64)>;
    type Cell = StructureCell;
    type Worker = RowOfModels;

    const MOST_BYTES: u64 = MAX_BYTES;
    const MOST_FILE_BYTES: u64 = MOST_FILE_BYTES;

    fn is_one(text: &str) -> bool {
        Self::is_scene(text)
    }

    fn parse(path: &Path, text: &str, kept: &Files) -> Result<Self, MapError> {
        Self::checked(path, text, kept)
    }

    fn files(&self) -> Files {
        self.named().clone()
    }

    fn title(&self) -> Option<&str> {
        self.title.as_deref()
    }

    fn parts(&self) -> Map<String, Json> {
        Self::parts(self)
    }

    /// Effective masses, where only some modes are kept.
    fn explained(&self) -> (Map<String, Json>, Vec<String>) {
        let told =
            |(own, all): (f64, f64)| serde_json::json!({ "effective_mass": own, "effective_mass_of_all_modes": all });
        let contacts: Vec<Json> = self.kept_masses().into_iter().map(told).collect();
        let keys = (!contacts.is_empty()).then(|| ("contacts".to_owned(), contacts.into()));
        (keys.into_iter().collect(), answer::kept(self).lines().map(str::to_owned).collect())
    }

    fn meaning(&self) -> Map<String, Json> {
        [("scene".to_owned(), Self::meaning(self).into())].into_iter().collect()
    }

    fn axes(&self) -> &[Axis<Setting>] {
        &self.axes
    }

    fn chunk_cells(&self) -> u64 {
        let of_word = |(word, _): &(Word, u32)| OF_WORDS[word.letters().count().clamp(1, 3) - 1];
        let cost = (self.modes() as u64).max(1).saturating_mul(self.words.iter().map(of_word).sum::<u64>().max(1));
        let [least, most] = CHUNK_CELLS;
        (CHUNK_WORK / cost.next_power_of_two()).clamp(least, most)
    }

    fn block(&self) -> u64 {
        Grid::chunk_cells(self) / TAKES
    }

    fn is_map(&self) -> Result<(), String> {
        let missing = if self.axes.is_empty() {
            "the scene sweeps nothing: give [sweep] with an axis x"
        } else if self.words.is_empty() {
            "the scene asks for no words: give [compute] with families = [\"0+\", …]"
        } else if self.omega().is_none() && !self.structure()?.has_own_period() {
            "omega is missing: give omega = … in the scene, or sweep it"
        } else {
            return Ok(());
        };
        Err(missing.to_owned())
    }

    fn tolerance(&self) -> Option<Tolerance> {
        self.stability.then_some(self.tolerance)
    }

    fn set_tolerance(&mut self, tolerance: Tolerance) {
        self.with_tolerance(tolerance);
    }

    fn places(&self) -> Vec<Setting> {
        self.axes.iter().map(|axis| axis.parameter).collect()
    }

    fn name_of(&self, parameter: Setting) -> String {
        let place = self.axes.iter().position(|axis| axis.parameter == parameter);
        place.and_then(|place| self.axis_names.get(place).cloned()).unwrap_or_else(|| parameter.to_string())
    }

    fn value(point: &Self::Point, parameter: Setting) -> f64 {
        point.iter().find(|(known, _)| *known == parameter).map_or(f64::NAN, |(_, value)| *value)
    }

    fn point(&self, cell: u64) -> Self::Point {
        let mut rest = cell as usize;
        let value = |axis: &Axis<Setting>| {
            let at = rest % axis.points();
            rest /= axis.points();
            (axis.parameter, axis.value(at))
        };
        self.axes.iter().map(value).collect()
    }

    fn columns(&self) -> Vec<Column<StructureCell>> {
        let [class, word, further @ ..] = COLUMNS;
        [class, word].into_iter().chain(common()).chain(further).collect()
    }

    fn untold() -> StructureCell {
        StructureCell::EMPTY
    }

    /// The first word has the classes of double-sided breathers, the second those of single-sided ones, all others those of words.
    fn shown(&self, cell: &StructureCell) -> Cell {
        let place = self.names().iter().position(|known| Some(known) == cell.word.as_ref()).unwrap_or(2);
        let of = |classes: [Class; 3]| Some(classes[place.min(2)]);
        let class = match cell.class {
            StructureClass::None => Some(Class::None),
            StructureClass::Unknown | StructureClass::Undecided => None,
            StructureClass::Physical => of([Class::Double, Class::Single, Class::Word]),
            StructureClass::Stable => of([Class::StableDouble, Class::StableSingle, Class::StableWord]),
            StructureClass::Unstable => of([Class::UnstableDouble, Class::UnstableSingle, Class::UnstableWord]),
        };
        Cell { class, ..cell.found }
    }

    fn class_name(class: Class) -> &'static str {
        let class = match class {
            Class::None => StructureClass::None,
            Class::StableDouble | Class::StableSingle | Class::StableWord => StructureClass::Stable,
            Class::UnstableDouble | Class::UnstableSingle | Class::UnstableWord => StructureClass::Unstable,
            Class::Double | Class::Single | Class::Word => StructureClass::Physical,
        };
        class.name()
    }

    fn worker(&self, stop: &Stop) -> RowOfModels {
        RowOfModels { stop: stop.clone(), ..RowOfModels::default() }
    }

    fn compute(
        &self,
        row: &mut RowOfModels,
        range: Range<u64>,
        stop: &Stop,
        cells: &mut Vec<StructureCell>,
    ) -> Option<()> {
        cells.clear();
        for number in range {
            if stop.is_raised() {
                return None;
            }
            let model = row.model(self, number);
            let RowOfModels { finder, analyser, .. } = row;
            let cell = |model| cell_of(self, &model, finder, analyser);
            cells.push(model.map_or_else(StructureCell::troubled, cell).judged());
        }
        // What was stopped has no answer.
        if stop.is_raised() {
            return None;
        }
        Some(())
    }
}
