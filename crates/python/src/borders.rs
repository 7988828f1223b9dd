//! All borders of a scene's window, and what lives between them.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use vibrochain_lattice::{Parameter, Stop};
use vibrochain_maps::borders::{Asked, Border, Borders};
use vibrochain_maps::cell::Class;
use vibrochain_maps::regions::Regions;

use crate::call::long;
use crate::failure::{Failure, whole};
use crate::sweep::{pool, scene, thread_count};

/// A curve on which what lives there changes.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> border = vc.curves("scenes/conservative-n5.toml", places=2000).borders[0]
/// >>> border.family, border.event, border.values.shape == (len(border.errors), 2)
/// ('double-sided', 'period-doubling', True)
#[pyclass(frozen, name = "Border", module = "vibrochain")]
pub(crate) struct PyBorder {
    border: Border,
}

#[pymethods]
impl PyBorder {
    /// str : of which family, or which impact word, as the scene names it.
    #[getter]
    fn family(&self) -> &str {
        &self.border.family
    }

    /// str : what happens on it: "grazing", "pitchfork", "period-doubling", "neimark-sacker", "fold", "resonance", "unbounded",
    /// "impulses-vanish", "threshold" or "change".
    #[getter]
    fn event(&self) -> &'static str {
        self.border.kind.name()
    }

    /// numpy.ndarray of float64, shape (k, 2) : values of both parameters; a closed border has its first point once more at the end.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let values: Vec<f64> = self.border.points.iter().flat_map(|point| point.values).collect();
        values.into_pyarray(py).reshape([self.border.points.len(), 2])
    }

    /// numpy.ndarray of float64, shape (k,) : how far the border may pass from the points, as a part of the window's sides.
    #[getter]
    fn errors<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.border.points.iter().map(|point| point.error).collect::<Vec<_>>().into_pyarray(py)
    }

    /// numpy.ndarray of float64, shape (k,) : half the width of the stripe whose edge it is, in the parameter along x; otherwise NaN.
    #[getter]
    fn half_widths<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let widths = self.border.points.iter().map(|point| point.half_width.unwrap_or(f64::NAN));
        widths.collect::<Vec<_>>().into_pyarray(py)
    }

    /// tuple of (int, int, int, bool) or None : the stripe whose edge it is: the two modes that meet, at which harmonic, and whether it is
    /// the edge with the larger values along x.
    #[getter]
    fn stripe(&self) -> Option<(usize, usize, usize, bool)> {
        self.border.stripe.map(|stripe| (stripe.modes.0, stripe.modes.1, stripe.harmonic, stripe.upper))
    }

    /// list of (str, int, float) : points of codimension two, if they were asked for: what, which of the points, its error.
    #[getter]
    fn special(&self) -> Vec<(String, usize, f64)> {
        self.border.special.iter().map(|(special, point, error)| (special.to_string(), *point, *error)).collect()
    }

    /// tuple of (str, str) : how it ends before the first and behind the last point.
    #[getter]
    fn ends(&self) -> (&str, &str) {
        let [first, last] = &self.border.ends;
        (first, last)
    }

    fn __repr__(&self) -> String {
        format!("<Border of {}: {}, {} points>", self.border.family, self.border.kind, self.border.points.len())
    }
}

/// All borders of a scene's window, and what lives between them.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> found = vc.curves("scenes/conservative-n5.toml", places=2000)
/// >>> found.free, found.stripes, found.class_at(1.5, 0.1)
/// (('omega', 'gamma2'), 8, 'stable-double')
#[pyclass(frozen, name = "Borders", module = "vibrochain")]
pub(crate) struct PyBorders {
    found: Borders,
    regions: Regions<Option<Class>>,
}

/// What could not be told has no class.
fn name(class: Option<Class>) -> &'static str {
    class.map_or("unknown", Class::name)
}

#[pymethods]
impl PyBorders {
    /// tuple of (str, str) : the parameters along x and y.
    #[getter]
    fn free(&self) -> (&'static str, &'static str) {
        let [x, y] = self.found.parameters.map(Parameter::name);
        (x, y)
    }

    /// list of Border : all of them.
    #[getter]
    fn borders(&self) -> Vec<PyBorder> {
        self.found.borders.iter().map(|border| PyBorder { border: border.clone() }).collect()
    }

    /// int : stripes among them, each with both edges.
    #[getter]
    fn stripes(&self) -> usize {
        self.found.stripes()
    }

    /// dict of str to (float, float) : the share of the window of each class ("unknown" where it could not be told), and its error.
    #[getter]
    fn areas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let areas = PyDict::new(py);
        self.regions.areas().iter().try_for_each(|area| areas.set_item(name(area.class), (area.share, area.error)))?;
        Ok(areas)
    }

    /// list of (str, [[float, float], [float, float]]) : places between which the breathers of a family change, and no border is known.
    #[getter]
    fn unexplained(&self) -> Vec<(&str, [[f64; 2]; 2])> {
        self.found.unexplained.iter().map(|(family, places)| (family.as_str(), *places)).collect()
    }

    /// The class of what lives at a point of the window.
    ///
    /// Parameters
    /// ----------
    /// x, y : float
    ///     Values of the two parameters. Nearer to a border than the tolerance, it may be the class on its other side.
    ///
    /// Returns
    /// -------
    /// str
    ///     As in tables, or "unknown".
    ///
    /// Raises
    /// ------
    /// RequestError
    ///     Outside the window.
    ///
    /// Examples
    /// --------
    /// >>> import vibrochain as vc
    /// >>> vc.curves("scenes/conservative-n5.toml", places=2000).class_at(0.5, 0.25)
    /// 'none'
    fn class_at(&self, x: f64, y: f64) -> PyResult<&'static str> {
        let outside = || Failure::request(format!("({x}, {y}) is outside the window: give a point in it"));
        Ok(self.regions.at([x, y]).map(|class| name(*class)).ok_or_else(outside)?)
    }

    fn __repr__(&self) -> String {
        let (x, y) = self.free();
        format!("<Borders: {} over {x} and {y}, {} stripes among them>", self.found.borders.len(), self.found.stripes())
    }
}

/// Finds all borders of a scene's window.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn _curves(
    py: Python<'_>,
    text: Option<String>,
    path: PathBuf,
    tolerance: f64,
    places: &Bound<'_, PyAny>,
    special: bool,
    threads: Option<&Bound<'_, PyAny>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyBorders> {
    let count = thread_count(threads)?;
    let places = whole("places", places, 0, i64::MAX)? as usize;
    let scene = scene(text.as_deref(), &path)?;
    let told = Arc::new([AtomicU64::new(0), AtomicU64::new(0)]);
    let work = {
        let told = told.clone();
        move |stop: &Stop| -> Result<_, Failure> {
            let tell = |done: usize, all: usize| {
                told[0].store(done as u64, Ordering::Relaxed);
                told[1].store(all as u64, Ordering::Relaxed);
            };
            let asked = Asked { tolerance, places, special, stop, told: &|_, _, done, all| tell(done, all) };
            Ok(pool(count)?.install(|| Borders::of_scene(&scene, &asked))?)
        }
    };
    let look = |_: Python<'_>| match progress {
        Some(progress) => {
            let [done, all] = [0, 1].map(|i| told[i].load(Ordering::Relaxed));
            progress.call1((done.min(all), all.max(1))).map(drop)
        }
        None => Ok(()),
    };
    let (found, regions) = long(py, look, work)?;
    Ok(PyBorders { found, regions })
}
