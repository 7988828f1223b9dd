//! Maps: the cells of a scene as columns.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::available_parallelism;

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::{ThreadPool, ThreadPoolBuilder};
use vibrochain_lattice::Stop;
use vibrochain_maps::cell::{Cell, Class, Status};
use vibrochain_maps::manifest::scene_parts;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::summary::Summary;
use vibrochain_maps::sweep::{Ended, sweep};
use vibrochain_maps::table::{Column, Kind, Value, columns, parameters};

use crate::call::long;
use crate::failure::{Failure, whole};

/// The most cells of a map in memory: 3 GB, beyond which tables belong into files.
const MOST_CELLS: u64 = 100_000_000;

/// The most threads that may be asked for, as of `mapgen`.
const MOST_THREADS: i64 = 1024;

/// The code of a word that a cell does not have, as pandas has it.
pub(crate) const NO_WORD: i8 = -1;

/// The values of a column, as they grow.
enum Values {
    /// Numbers, and counts that may be missing: NaN there.
    Numbers(Vec<f64>),
    Counts(Vec<u32>),
    /// Codes of words, and the words.
    Words(Vec<i8>, Vec<&'static str>),
}

/// A column as it grows.
struct Growing {
    column: Column,
    values: Values,
}

impl Growing {
    fn new(column: Column, cells: usize) -> Result<Self, Failure> {
        fn room<T>(cells: usize) -> Result<Vec<T>, Failure> {
            let mut values = Vec::new();
            values.try_reserve_exact(cells).map_err(|_| too_large(cells as u64))?;
            Ok(values)
        }
        let values = match (column.kind, column.optional) {
            (Kind::Word, _) => Values::Words(room(cells)?, Vec::new()),
            (Kind::Count, false) => Values::Counts(room(cells)?),
            (Kind::Number, _) | (Kind::Count, true) => Values::Numbers(room(cells)?),
        };
        Ok(Self { column, values })
    }

    fn push(&mut self, cell: &Cell) {
        let value = (self.column.get)(cell);
        match (&mut self.values, value) {
            (Values::Numbers(numbers), Some(Value::Number(number))) => numbers.push(number),
            (Values::Numbers(numbers), Some(Value::Count(count))) => numbers.push(count as f64),
            (Values::Numbers(numbers), _) => numbers.push(f64::NAN),
            // No cell has 2³² solutions.
            (Values::Counts(counts), Some(Value::Count(count))) => {
                counts.push(u32::try_from(count).unwrap_or(u32::MAX))
            }
            (Values::Counts(counts), _) => counts.push(0),
            (Values::Words(codes, words), Some(Value::Word(word))) => {
                let known = words.iter().position(|known| *known == word);
                codes.push(known.unwrap_or_else(|| {
                    words.push(word);
                    words.len() - 1
                }) as i8);
            }
            (Values::Words(codes, _), _) => codes.push(NO_WORD),
        }
    }

    /// The vector itself becomes the array's memory.
    fn into_python(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(match self.values {
            Values::Numbers(numbers) => numbers.into_pyarray(py).into_any(),
            Values::Counts(counts) => counts.into_pyarray(py).into_any(),
            Values::Words(codes, words) => (codes.into_pyarray(py), words).into_pyobject(py)?.into_any(),
        })
    }
}

fn too_large(cells: u64) -> Failure {
    Failure::TooLarge(format!(
        "a map of {cells} cells is too large for memory, the limit is {MOST_CELLS}: give fewer points, or write a table with \
         `mapgen sweep`"
    ))
}

/// A scene from its file, or from a text with a name for messages.
pub(crate) fn scene(text: Option<&str>, path: &Path) -> Result<Scene, Failure> {
    Ok(match text {
        Some(text) => Scene::parse(path, text)?,
        None => {
            Failure::unless_there(path)?;
            Scene::read(path)?
        }
    })
}

/// Refuses a scene that is refined: its leaves are no array.
pub(crate) fn unrefined(scene: &Scene) -> Result<(), Failure> {
    match scene.refine {
        None => Ok(()),
        Some(_) => Err(Failure::request(
            "the leaves of a map that is refined are no array: leave refine out, or write them as a table with `mapgen sweep`, which \
             pandas reads",
        )),
    }
}

/// All of a scene that decides what its map holds, as JSON.
pub(crate) fn parts(scene: &Scene) -> String {
    let mut parts = scene_parts(scene);
    parts.extend(scene.title.iter().map(|title| ("title".to_owned(), title.as_str().into())));
    serde_json::Value::from(parts).to_string()
}

/// Computes the map of a scene: what it was made of, its axes (the slowest first), its columns, its counts.
#[pyfunction]
pub(crate) fn _sweep<'py>(
    py: Python<'py>,
    text: Option<String>,
    path: PathBuf,
    threads: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let count = thread_count(threads)?;
    let scene = Arc::new(scene(text.as_deref(), &path)?);
    unrefined(&scene)?;
    let cells = scene.cells();
    if cells > MOST_CELLS {
        return Err(too_large(cells).into());
    }
    let done = Arc::new(AtomicU64::new(0));
    let work = {
        let (scene, done) = (scene.clone(), done.clone());
        move |stop: &Stop| compute(&scene, count, &done, stop)
    };
    let look = |_: Python<'_>| match progress {
        Some(progress) => progress.call1((done.load(Ordering::Relaxed), cells)).map(drop),
        None => Ok(()),
    };
    let (columns, summary) = long(py, look, work)?;
    let map = PyDict::new(py);
    grid(&map, &scene)?;
    let columns = columns.into_iter().map(|column| Ok((column.column.name, column.into_python(py)?)));
    map.set_item("columns", columns.collect::<PyResult<Vec<_>>>()?)?;
    let counted = |names: &mut dyn Iterator<Item = (&'static str, u64)>| -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        names.filter(|(_, count)| *count > 0).try_for_each(|(name, count)| dict.set_item(name, count)).map(|()| dict)
    };
    map.set_item("classes", counted(&mut Class::ALL.iter().map(|class| class.name()).zip(summary.classes))?)?;
    map.set_item("statuses", counted(&mut Status::ALL.iter().map(|status| status.name()).zip(summary.statuses))?)?;
    map.set_item("worst_residual", summary.worst_residual)?;
    Ok(map)
}

/// What a scene's cells were made of, and its axes, the slowest first.
pub(crate) fn grid(map: &Bound<'_, PyDict>, scene: &Scene) -> PyResult<()> {
    let py = map.py();
    map.set_item("scene", parts(scene))?;
    map.set_item("caption", (scene.heading(), scene.fixed(), scene.criterion()))?;
    let axes: Vec<_> = scene
        .axes
        .iter()
        .rev()
        .map(|axis| {
            let values: Vec<f64> = (0..axis.points()).map(|i| axis.value(i)).collect();
            let parameter = axis.parameter;
            (parameter.name(), values.into_pyarray(py), format!("{} {}", parameter.meaning(), parameter.symbol()))
        })
        .collect();
    map.set_item("axes", axes)?;
    let fixed: Vec<_> = parameters(scene).into_iter().map(|which| (which.name(), scene.base.get(which))).collect();
    map.set_item("parameters", fixed)
}

/// The threads asked for, 0 if their number is left open.
pub(crate) fn thread_count(threads: Option<&Bound<'_, PyAny>>) -> PyResult<usize> {
    threads.map_or(Ok(0), |threads| whole("threads", threads, 1, MOST_THREADS)).map(|count| count as usize)
}

/// So many threads of their own, one a core if 0.
pub(crate) fn pool(threads: usize) -> Result<ThreadPool, Failure> {
    let threads = if threads > 0 { threads } else { available_parallelism().map_or(1, usize::from) };
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| Failure::Other(format!("cannot start {threads} threads: {error}")))
}

/// All cells, on threads of their own.
fn compute(scene: &Scene, threads: usize, done: &AtomicU64, stop: &Stop) -> Result<(Vec<Growing>, Summary), Failure> {
    let pool = pool(threads)?;
    let mut growing = columns(scene)
        .map(|column| Growing::new(column, scene.cells() as usize))
        .collect::<Result<Vec<_>, Failure>>()?;
    let tick = |cells| {
        done.fetch_add(cells, Ordering::Relaxed);
    };
    let ended = sweep(scene, &pool, stop, tick, |_, cells| {
        for column in &mut growing {
            cells.iter().for_each(|cell| column.push(cell));
        }
        Ok::<_, Failure>(())
    });
    match ended {
        Ended::Complete(summary) => Ok((growing, summary)),
        Ended::Stopped => Err(Failure::Other("the sweep was stopped".to_owned())),
        Ended::Failed(failure) => Err(failure),
    }
}
