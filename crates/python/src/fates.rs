//! Ensembles: what becomes of perturbed breathers, as columns of a scene's cells.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use vibrochain_fate::{BreatherFates, CellFates, End, Ensemble, From, fates};
use vibrochain_lattice::Stop;
use vibrochain_maps::cell::Status;
use vibrochain_maps::grid::Grid;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::sweep::{Ended, Job};

use crate::call::counted;
use crate::failure::{Failure, named, natural, whole};
use crate::scenes::{CellsScene, grid, is_of_structure, scene};
use crate::sweep::{NO_WORD, pool, thread_count};

/// The most cells in memory: a gigabyte, and more runs than a machine makes in weeks.
const MOST_CELLS: u64 = 1_000_000;

/// A number of a breather, if it has one.
type NumberOf = fn(&BreatherFates) -> Option<f64>;

/// Numbers of every breather, by the names of the table's columns.
const NUMBERS: [(&str, NumberOf); 7] = [
    ("spectral_radius", |of| of.spectral_radius),
    ("predicted_exponent", |of| of.predicted),
    ("measured_exponent", |of| of.measured.map(|(value, _)| value)),
    ("measured_error", |of| of.measured.map(|(_, error)| error)),
    ("leave_time", |of| of.leave_time.map(|(mean, _)| mean)),
    ("leave_error", |of| of.leave_time.and_then(|(_, error)| error)),
    ("chaos_exponent", |of| of.chaos_exponent),
];

/// Runs the ensembles of a scene: what it was made of, its axes (the slowest first), its columns, its counts.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn _fate<'py>(
    py: Python<'py>,
    text: Option<String>,
    path: PathBuf,
    breathers: &str,
    starts: &Bound<'py, PyAny>,
    perturb: f64,
    seed: &Bound<'py, PyAny>,
    periods: &Bound<'py, PyAny>,
    transient: f64,
    tolerance: f64,
    leave: f64,
    in_sequence: bool,
    threads: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let count = thread_count(threads)?;
    let from = named("breathers", breathers, From::ALL.map(|from| (from.name(), from)))?;
    // (Out of range they are told by the ensemble.)
    let [starts, periods] =
        [("starts", starts), ("periods", periods)].map(|(name, value)| whole(name, value, 0, i64::MAX));
    let (starts, periods) = (starts? as u64, periods? as u64);
    let seed = natural("seed", seed)?;
    let ensemble = Ensemble { starts, size: perturb, seed, periods, transient, tolerance, leave, in_sequence };
    let asked = FateRequest { ensemble, from, threads: count, progress };
    if is_of_structure(text.as_deref(), &path)? {
        fates_of(py, scene::<StructureScene>(text.as_deref(), &path)?, asked)
    } else {
        fates_of(py, scene::<Scene>(text.as_deref(), &path)?, asked)
    }
}

/// How many runs of a scene, from where, and on how many threads.
struct FateRequest<'a, 'py> {
    ensemble: Ensemble,
    from: From,
    threads: usize,
    progress: Option<&'a Bound<'py, PyAny>>,
}

fn fates_of<'py, S: CellsScene>(
    py: Python<'py>,
    scene: S,
    asked: FateRequest<'_, 'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let FateRequest { ensemble, from, threads: count, progress } = asked;
    let starts = ensemble.starts;
    scene.takes(&ensemble, from).map_err(|error| Failure::request(error.trim_start_matches('-')))?;
    let (cells, scene) = (Grid::cells(&scene), Arc::new(scene));
    if cells > MOST_CELLS {
        let message = format!(
            "an ensemble of {cells} cells is too large for memory, the limit is {MOST_CELLS}: give fewer points, or write a table with \
             `mapgen fate`"
        );
        return Err(Failure::TooLarge(message).into());
    }
    let computed = scene.clone();
    let work = move |stop: &Stop, [done, _]: &[AtomicU64; 2]| compute(&*computed, &ensemble, from, count, done, stop);
    let found = counted(py, progress, cells * starts, work)?;
    let parts = PyDict::new(py);
    grid(&parts, &*scene)?;
    let places = places(&found, from);
    parts.set_item("places", (!is_alone(from)).then_some(places))?;
    parts.set_item("columns", columns(py, &found, from, places)?)?;
    let mut ends = [0; End::NAMES.len()];
    for breather in found.iter().flat_map(|cell| &cell.breathers) {
        ends.iter_mut().zip(breather.ends).for_each(|(sum, count)| *sum += u64::from(count));
    }
    let counted = PyDict::new(py);
    End::NAMES.iter().zip(ends).try_for_each(|(name, count)| counted.set_item(name, count))?;
    parts.set_item("ends", counted)?;
    Ok(parts)
}

fn compute<S: CellsScene>(
    scene: &S,
    ensemble: &Ensemble,
    from: From,
    threads: usize,
    done: &AtomicU64,
    stop: &Stop,
) -> Result<Vec<CellFates>, Failure> {
    let pool = pool(threads)?;
    let tick = |runs| {
        done.fetch_add(runs, Ordering::Relaxed);
    };
    let mut cells = Vec::new();
    let ended = fates(&Job { scene, pool: &pool, stop }, ensemble, from, tick, |cell| {
        cells.push(cell);
        Ok::<_, Failure>(())
    });
    match ended {
        Ended::Complete(_) => Ok(cells),
        Ended::Stopped => Err(Failure::Other("the ensemble was stopped".to_owned())),
        Ended::Failed(failure) => Err(failure),
    }
}

/// Whether runs of a cell start from one breather at most, or from rest.
fn is_alone(from: From) -> bool {
    matches!(from, From::Class | From::Rest)
}

/// Places for breathers in each cell: one where runs start from one at most.
fn places(cells: &[CellFates], from: From) -> usize {
    let numbers = cells.iter().flat_map(|cell| &cell.breathers).map(|breather| breather.number as usize);
    if is_alone(from) { 1 } else { numbers.max().unwrap_or(0) }
}

/// Columns of all cells, and of their breathers.
fn columns<'py>(py: Python<'py>, cells: &[CellFates], from: From, places: usize) -> PyResult<Bound<'py, PyList>> {
    // Where a cell's breathers stand.
    let mut table: Vec<Option<&BreatherFates>> = vec![None; cells.len() * places];
    for (i, cell) in cells.iter().enumerate() {
        for breather in &cell.breathers {
            let place = if is_alone(from) { 0 } else { breather.number as usize - 1 };
            table[i * places + place] = Some(breather);
        }
    }
    let list = PyList::empty(py);
    let solutions: Vec<u32> = cells.iter().map(|cell| cell.cell.solutions).collect();
    list.append(("solutions", solutions.into_pyarray(py)))?;
    let statuses = cells.iter().map(|cell| cell.cell.status as i8).collect::<Vec<_>>();
    list.append(("status", (statuses.into_pyarray(py), Status::ALL.map(Status::name))))?;
    let counts = |count: &dyn Fn(&BreatherFates) -> u32| {
        table.iter().map(|breather| breather.map_or(0, count)).collect::<Vec<u32>>().into_pyarray(py)
    };
    let texts = |text: &dyn Fn(&BreatherFates) -> String| {
        table.iter().map(|breather| breather.map_or(String::new(), text)).collect::<Vec<_>>()
    };
    let reals = |number: &dyn Fn(&BreatherFates) -> Option<f64>| {
        table.iter().map(|breather| breather.and_then(number).unwrap_or(f64::NAN)).collect::<Vec<_>>().into_pyarray(py)
    };
    list.append(("number", counts(&|of| of.number)))?;
    list.append(("breather", texts(&|of| of.name.clone())))?;
    list.append(("starts", counts(&BreatherFates::runs)))?;
    let end = |breather: &Option<&BreatherFates>| {
        breather.and_then(BreatherFates::dominant).map_or(NO_WORD, |kind| kind as i8)
    };
    list.append(("end", (table.iter().map(end).collect::<Vec<i8>>().into_pyarray(py), End::NAMES)))?;
    for (kind, name) in End::NAMES.iter().enumerate() {
        list.append((format!("share_{}", name.replace('-', "_")), reals(&|of| Some(of.share(kind)))))?;
    }
    list.append(("words", texts(&BreatherFates::words_text)))?;
    list.append(("left", counts(&|of| of.left)))?;
    NUMBERS.iter().try_for_each(|(name, number)| list.append((name, reals(number))))?;
    Ok(list)
}
