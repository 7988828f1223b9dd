//! Maps: the cells of a scene as columns.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::available_parallelism;

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::{ThreadPool, ThreadPoolBuilder};
use vibrochain_lattice::Stop;
use vibrochain_maps::cell::{Class, Status};
use vibrochain_maps::grid::Grid;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::summary::Summary;
use vibrochain_maps::sweep::{Ended, sweep};
use vibrochain_maps::table::{Codes, Column, Kind, Numbers, Value};

use crate::call::counted;
use crate::failure::{Failure, whole};
use crate::scenes::{CellsScene, grid, is_of_structure, scene};

/// The most cells of a map in memory: 3 GB, beyond which tables belong into files.
const MOST_CELLS: u64 = 100_000_000;

/// The most threads that may be asked for, as of `mapgen`.
const MOST_THREADS: i64 = 1024;

/// The code of a class that a cell does not have, as of a word: as pandas has it.
pub(crate) const NO_WORD: i8 = -1;

/// The values of a column, as they grow.
enum Values {
    /// Numbers, and counts that may be missing: NaN there.
    Numbers(Vec<f64>),
    Counts(Vec<u32>),
    Words(Codes),
    Texts(Vec<String>),
}

/// A column as it grows.
struct Growing<T> {
    column: Column<T>,
    values: Values,
}

impl<T> Growing<T> {
    fn new(column: Column<T>, cells: usize) -> Result<Self, Failure> {
        fn room<T>(cells: usize) -> Result<Vec<T>, Failure> {
            let mut values = Vec::new();
            values.try_reserve_exact(cells).map_err(|_| too_large(cells as u64))?;
            Ok(values)
        }
        let values = match (column.kind, column.optional) {
            (Kind::Word, _) => Values::Words(Codes::with_room(cells).map_err(|_| too_large(cells as u64))?),
            (Kind::Text, _) => Values::Texts(room(cells)?),
            (Kind::Count, false) => Values::Counts(room(cells)?),
            (Kind::Number, _) | (Kind::Count, true) => Values::Numbers(room(cells)?),
        };
        Ok(Self { column, values })
    }

    fn push(&mut self, cell: &T) {
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
            (Values::Words(codes), Some(Value::Word(word))) => codes.push(Some(word)),
            (Values::Words(codes), _) => codes.push(None),
            (Values::Texts(texts), Some(Value::Text(text))) => texts.push(text.to_owned()),
            (Values::Texts(texts), _) => texts.push(String::new()),
        }
    }

    /// The vector itself becomes the array's memory.
    fn into_python(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(match self.values {
            Values::Numbers(numbers) => numbers.into_pyarray(py).into_any(),
            Values::Counts(counts) => counts.into_pyarray(py).into_any(),
            Values::Words(codes) => match codes.into_parts() {
                (Numbers::Small(codes), words) => (codes.into_pyarray(py), words).into_pyobject(py)?.into_any(),
                (Numbers::Large(codes), words) => (codes.into_pyarray(py), words).into_pyobject(py)?.into_any(),
            },
            Values::Texts(texts) => texts.into_pyobject(py)?.into_any(),
        })
    }
}

fn too_large(cells: u64) -> Failure {
    Failure::TooLarge(format!(
        "a map of {cells} cells is too large for memory, the limit is {MOST_CELLS}: give fewer points, or write a table with \
         `mapgen sweep`"
    ))
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
    if is_of_structure(text.as_deref(), &path)? {
        map_of(py, scene::<StructureScene>(text.as_deref(), &path)?, count, progress)
    } else {
        map_of(py, scene::<Scene>(text.as_deref(), &path)?, count, progress)
    }
}

fn map_of<'py, S: CellsScene>(
    py: Python<'py>,
    scene: S,
    count: usize,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    scene.is_map().map_err(Failure::from)?;
    let (cells, scene) = (Grid::cells(&scene), Arc::new(scene));
    ensure!(cells <= MOST_CELLS, too_large(cells).into());
    let computed = scene.clone();
    let work = move |stop: &Stop, [done, _]: &[AtomicU64; 2]| compute(&*computed, count, done, stop);
    let Computed { columns, classes, summary } = counted(py, progress, cells, work)?;
    let map = PyDict::new(py);
    grid(&map, &*scene)?;
    let columns = columns.into_iter().map(|column| Ok((column.column.name, column.into_python(py)?)));
    map.set_item("columns", columns.collect::<PyResult<Vec<_>>>()?)?;
    let there: Vec<Class> = Class::ALL.into_iter().filter(|class| summary.classes[*class as usize] > 0).collect();
    let legend: Option<Vec<String>> = Class::ALL.iter().map(|class| scene.legend(*class, &there)).collect();
    if let Some(legend) = legend {
        map.set_item("shown", (classes.into_pyarray(py), Class::ALL.map(Class::name), legend))?;
    }
    let statuses = PyDict::new(py);
    let counts = Status::ALL.iter().map(|status| status.name()).zip(summary.statuses);
    counts.filter(|(_, count)| *count > 0).try_for_each(|(name, count)| statuses.set_item(name, count))?;
    map.set_item("statuses", statuses)?;
    map.set_item("worst_residual", summary.worst_residual)?;
    Ok(map)
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

/// A map, computed.
struct Computed<T> {
    columns: Vec<Growing<T>>,
    /// The class of each cell as pictures have it, by its place in [`Class::ALL`].
    classes: Vec<i8>,
    summary: Summary,
}

/// All cells, on threads of their own.
fn compute<S: CellsScene>(
    scene: &S,
    threads: usize,
    done: &AtomicU64,
    stop: &Stop,
) -> Result<Computed<S::Cell>, Failure> {
    let pool = pool(threads)?;
    let cells = Grid::cells(scene) as usize;
    let mut columns =
        scene.columns().into_iter().map(|column| Growing::new(column, cells)).collect::<Result<Vec<_>, Failure>>()?;
    // Where the class itself says it, pictures need nothing else.
    let mut classes = scene.legend(Class::None, &[]).map(|_| Vec::with_capacity(cells));
    let tick = |cells| {
        done.fetch_add(cells, Ordering::Relaxed);
    };
    let ended = sweep(scene, &pool, stop, tick, |_, cells| {
        for column in &mut columns {
            cells.iter().for_each(|cell| column.push(cell));
        }
        if let Some(classes) = &mut classes {
            classes.extend(cells.iter().map(|cell| scene.shown(cell).class.map_or(NO_WORD, |class| class as i8)));
        }
        Ok::<_, Failure>(())
    });
    match ended {
        Ended::Complete(summary) => Ok(Computed { columns, classes: classes.unwrap_or_default(), summary }),
        Ended::Stopped => Err(Failure::Other("the sweep was stopped".to_owned())),
        Ended::Failed(failure) => Err(failure),
    }
}
