//! Maps of structures: the points of a scene as columns.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;
use vibrochain_lattice::Stop;
use vibrochain_maps::cell::{Cell, Class, Status};
use vibrochain_maps::structure::map::StructureCell;
use vibrochain_maps::structure::{StructureMap, StructureScene};
use vibrochain_maps::text::read_text;
use vibrochain_plot::Mapped;

use crate::call::long;
use crate::failure::Failure;
use crate::sweep::{NO_WORD, parts, pool, scene, thread_count};

/// The most bytes of a scene, as of `mapgen`.
const MOST_BYTES: u64 = 64 << 20;

/// The scene of a structure, if it is one, with all it says: of a text in JSON, or of a file.
fn structure_scene(text: Option<&str>, path: &Path) -> Result<Option<(StructureScene, Value)>, Failure> {
    let Some(text) = text else {
        Failure::unless_there(path)?;
        let Some(scene) = StructureScene::read(path)? else { return Ok(None) };
        let told = toml::from_str(&read_text("the scene", path, MOST_BYTES)?);
        return Ok(Some((scene, told.map_err(|error| Failure::Request(error.to_string()))?)));
    };
    let Ok(told) = serde_json::from_str::<Value>(text) else { return Ok(None) };
    if told.get("structure").is_none() {
        return Ok(None);
    }
    Ok(Some((StructureScene::of_text(text, Path::new(".")).map_err(Failure::Request)?, told)))
}

/// The parts of a scene in a file, of a chain or of a structure, as JSON.
#[pyfunction]
pub(crate) fn _scene(path: PathBuf) -> PyResult<String> {
    Ok(match structure_scene(None, &path)? {
        Some((_, told)) => told.to_string(),
        None => parts(&scene(None, &path)?),
    })
}

/// Words as codes, in the order in which they come.
#[derive(Default)]
struct Coded {
    codes: Vec<i8>,
    words: Vec<String>,
}

impl Coded {
    fn push(&mut self, word: &str) {
        if word.is_empty() {
            self.codes.push(NO_WORD);
            return;
        }
        let place = self.words.iter().position(|known| known == word).unwrap_or_else(|| {
            self.words.push(word.to_owned());
            self.words.len() - 1
        });
        self.codes.push(place as i8);
    }

    fn into_python(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok((self.codes.into_pyarray(py), self.words).into_pyobject(py)?.into_any())
    }
}

/// All points of the map, and how many are done.
fn compute(
    scene: &StructureScene,
    threads: usize,
    done: &AtomicU64,
    stop: &Stop,
) -> Result<Vec<StructureCell>, Failure> {
    let (map, pool) = (StructureMap::new(scene).map_err(Failure::Request)?, pool(threads)?);
    let mut cells = Vec::with_capacity(map.points());
    for row in 0..map.rows() {
        let stopped = || Failure::Other("the sweep was stopped".to_owned());
        cells.extend(pool.install(|| map.row(row, stop)).ok_or_else(stopped)?);
        done.store(cells.len() as u64, Ordering::Relaxed);
    }
    Ok(cells)
}

/// Computes the map of a structure's scene, as `_sweep` does that of a chain's; None if it is not one.
#[pyfunction]
pub(crate) fn _structure_sweep<'py>(
    py: Python<'py>,
    text: Option<String>,
    path: PathBuf,
    threads: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let count = thread_count(threads)?;
    let Some((scene, told)) = structure_scene(text.as_deref(), &path)? else { return Ok(None) };
    let scene = Arc::new(scene);
    let points = StructureMap::new(&scene).map_err(Failure::Request)?.points() as u64;
    let done = Arc::new(AtomicU64::new(0));
    let work = {
        let (scene, done) = (scene.clone(), done.clone());
        move |stop: &Stop| compute(&scene, count, &done, stop)
    };
    let look = |_: Python<'_>| match progress {
        Some(progress) => progress.call1((done.load(Ordering::Relaxed), points)).map(drop),
        None => Ok(()),
    };
    let cells = long(py, look, work)?;
    let map = PyDict::new(py);
    map.set_item("scene", told.to_string())?;
    map.set_item("caption", (scene.heading(), scene.fixed(), scene.criterion()))?;
    let axis = |axis: vibrochain_plot::MapAxis| {
        let values: Vec<f64> = (0..axis.values.points()).map(|i| axis.values.value(i)).collect();
        (axis.name, values.into_pyarray(py), axis.label)
    };
    let axes: Vec<_> = scene.axes().into_iter().rev().map(axis).collect();
    map.set_item("parameters", axes.iter().map(|(name, ..)| (name.clone(), 0.0)).collect::<Vec<_>>())?;
    map.set_item("axes", axes)?;
    let shown: Vec<Cell> = cells.iter().map(|cell| cell.cell(&scene.words)).collect();
    map.set_item("columns", columns(py, &cells, &shown)?)?;
    let (mut classes, counts) = (Coded::default(), PyDict::new(py));
    shown.iter().for_each(|cell| classes.push(cell.class.map_or("", Class::name)));
    let there: Vec<Class> =
        Class::ALL.into_iter().filter(|class| shown.iter().any(|cell| cell.class == Some(*class))).collect();
    let words = classes.words.iter().filter_map(|name| Class::ALL.into_iter().find(|class| class.name() == name));
    let words: Vec<String> = words.map(|class| scene.class(class, &there)).collect();
    map.set_item("shown", (classes.codes.into_pyarray(py), classes.words, words))?;
    let statuses =
        Status::ALL.iter().map(|status| (status.name(), shown.iter().filter(|cell| cell.status == *status).count()));
    statuses.filter(|(_, count)| *count > 0).try_for_each(|(name, count)| counts.set_item(name, count))?;
    map.set_item("statuses", counts)?;
    Ok(Some(map))
}

/// The columns of `mapgen`'s table of a structure, but for the axes.
fn columns<'py>(
    py: Python<'py>,
    cells: &[StructureCell],
    shown: &[Cell],
) -> PyResult<Vec<(&'static str, Bound<'py, PyAny>)>> {
    let (mut classes, mut words, mut mechanisms) = (Coded::default(), Coded::default(), Coded::default());
    for (cell, shown) in cells.iter().zip(shown) {
        classes.push(cell.class().split(' ').next().unwrap_or_default());
        words.push(cell.best.as_ref().map_or("", |(word, ..)| word));
        mechanisms.push(shown.mechanism.map_or("", |mechanism| mechanism.name()));
    }
    let numbers = |of: fn(&Cell) -> Option<f64>| {
        shown.iter().map(|cell| of(cell).unwrap_or(f64::NAN)).collect::<Vec<_>>().into_pyarray(py).into_any()
    };
    let solutions = shown.iter().map(|cell| cell.solutions).collect::<Vec<_>>().into_pyarray(py).into_any();
    let trouble: Vec<String> = cells.iter().map(|cell| cell.trouble.clone().unwrap_or_default()).collect();
    Ok(vec![
        ("class", classes.into_python(py)?),
        ("word", words.into_python(py)?),
        ("mechanism", mechanisms.into_python(py)?),
        ("spectral_radius", numbers(|cell| cell.spectral_radius)),
        ("margin", numbers(|cell| cell.margin)),
        ("solutions", solutions),
        ("trouble", trouble.into_pyobject(py)?.into_any()),
    ])
}
