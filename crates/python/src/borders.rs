//! All borders of a scene's window, and what lives between them.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::{Deserialize, Serialize};
use vibrochain_lattice::{Parameter, Stop};
use vibrochain_maps::borders::{Border, BorderRequest, Borders};
use vibrochain_maps::cell::Class;
use vibrochain_maps::regions::{Region, Regions};

use crate::call::counted;
use crate::failure::{Failure, whole};
use crate::scenes::scene;
use crate::sweep::{pool, thread_count};

/// A curve on which what lives there changes.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> border = vc.curves("scenes/conservative-n5.toml", places=2000).borders[0]
/// >>> border.family, border.event, border.values.shape == (len(border.errors), 2)
/// ('double-sided', 'period-doubling', True)
#[pyclass(frozen, name = "Border", module = "vibrochain")]
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct PyBorder {
    /// str : of which family, or which impact word, as the scene names it.
    #[pyo3(get)]
    family: String,
    /// str : what happens on it: "grazing", "pitchfork", "period-doubling", "neimark-sacker", "fold", "resonance", "unbounded",
    /// "impulses-vanish", "threshold" or "change".
    #[pyo3(get)]
    event: String,
    /// Values, error, and half the width of a stripe.
    points: Vec<([f64; 2], f64, Option<f64>)>,
    /// tuple of (int, int, int, bool) or None : the stripe whose edge it is: the two modes that meet, at which harmonic, and whether it is
    /// the edge with the larger values along x.
    #[pyo3(get)]
    stripe: Option<(usize, usize, usize, bool)>,
    /// list of (str, int, float) : points of codimension two, if they were asked for: what, which of the points, its error.
    #[pyo3(get)]
    special: Vec<(String, usize, f64)>,
    /// tuple of (str, str) : how it ends before the first and behind the last point.
    #[pyo3(get)]
    ends: (String, String),
}

impl From<Border> for PyBorder {
    fn from(border: Border) -> Self {
        let Border { family, kind, stripe, points, special, ends: [first, last] } = border;
        Self {
            family,
            event: kind.name().to_owned(),
            points: points.iter().map(|point| (point.values, point.error, point.half_width)).collect(),
            stripe: stripe.map(|stripe| (stripe.modes.0, stripe.modes.1, stripe.harmonic, stripe.upper)),
            special: special.iter().map(|one| (one.special.to_string(), one.point, one.error)).collect(),
            ends: (first, last),
        }
    }
}

#[pymethods]
impl PyBorder {
    /// numpy.ndarray of float64, shape (k, 2) : values of both parameters; a closed border has its first point once more at the end.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let values: Vec<f64> = self.points.iter().flat_map(|(values, ..)| *values).collect();
        values.into_pyarray(py).reshape([self.points.len(), 2])
    }

    /// numpy.ndarray of float64, shape (k,) : how far the border may pass from the points, as a part of the window's sides.
    #[getter]
    fn errors<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.points.iter().map(|(_, error, _)| *error).collect::<Vec<_>>().into_pyarray(py)
    }

    /// numpy.ndarray of float64, shape (k,) : half the width of the stripe whose edge it is, in the parameter along x; otherwise NaN.
    #[getter]
    fn half_widths<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.points.iter().map(|(.., width)| width.unwrap_or(f64::NAN)).collect::<Vec<_>>().into_pyarray(py)
    }

    fn __repr__(&self) -> String {
        format!("<Border of {}: {}, {} points>", self.family, self.event, self.points.len())
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
#[derive(Serialize, Deserialize)]
pub(crate) struct PyBorders {
    free: [Parameter; 2],
    /// list of Border : all of them.
    #[pyo3(get)]
    borders: Vec<PyBorder>,
    /// int : stripes among them, each with both edges.
    #[pyo3(get)]
    stripes: usize,
    /// list of (str, [[float, float], [float, float]]) : places between which the breathers of a family change, and no border is known.
    #[pyo3(get)]
    unexplained: Vec<(String, [[f64; 2]; 2])>,
    regions: Regions<String>,
    caption: [String; 3],
}

/// A region: its class, its share of the window, its outlines.
type Outlined<'a, 'py> = (&'a str, f64, Vec<Bound<'py, PyArray2<f64>>>);

#[pymethods]
impl PyBorders {
    /// tuple of (str, str) : the parameters along x and y.
    #[getter]
    fn free(&self) -> (&'static str, &'static str) {
        let [x, y] = self.free.map(Parameter::name);
        (x, y)
    }

    /// dict of str to (float, float) : the share of the window of each class ("unknown" where it could not be told), and its error.
    #[getter]
    fn areas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let areas = PyDict::new(py);
        self.regions.areas().iter().try_for_each(|area| areas.set_item(&area.class, (area.share, area.error)))?;
        Ok(areas)
    }

    /// list of (str, float, list of numpy.ndarray of float64, shape (k, 2)) : regions: the class, its share of the window, and outlines in
    /// values of both parameters, counterclockwise around it and clockwise around what it leaves out.
    #[getter]
    fn regions<'py>(&self, py: Python<'py>) -> PyResult<Vec<Outlined<'_, 'py>>> {
        let window = self.regions.window();
        let outline = |outline: &Vec<[f64; 2]>| {
            let values: Vec<f64> = outline.iter().flat_map(|part| window.point(*part)).collect();
            values.into_pyarray(py).reshape([outline.len(), 2])
        };
        let region = |region: &'_ Region<String>| region.outlines.iter().map(outline).collect::<PyResult<Vec<_>>>();
        self.regions.regions().iter().map(|one| Ok((one.class.as_str(), one.share, region(one)?))).collect()
    }

    /// tuple of (str, str, str) : what stands above the picture: the title, all that is fixed, what counts as stable.
    #[getter]
    fn caption(&self) -> (&str, &str, &str) {
        let [heading, fixed, criterion] = &self.caption;
        (heading, fixed, criterion)
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
    fn class_at(&self, x: f64, y: f64) -> PyResult<&str> {
        let outside = || Failure::request(format!("({x}, {y}) is outside the window: give a point in it"));
        Ok(self.regions.at([x, y]).ok_or_else(outside)?)
    }

    fn __repr__(&self) -> String {
        let (x, y) = self.free();
        format!("<Borders: {} over {x} and {y}, {} stripes among them>", self.borders.len(), self.stripes)
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
    let scene = scene::<vibrochain_maps::scene::Scene>(text.as_deref(), &path)?;
    let caption = [scene.heading(), scene.fixed(), scene.criterion()];
    let work = move |stop: &Stop, told: &[AtomicU64; 2]| -> Result<_, Failure> {
        let tell = |done: usize, all: usize| {
            told[0].store(done as u64, Ordering::Relaxed);
            told[1].store(all as u64, Ordering::Relaxed);
        };
        let asked = BorderRequest { tolerance, places, special, stop, told: &|_, _, done, all| tell(done, all) };
        Ok(pool(count)?.install(|| Borders::of_scene(&scene, &asked))?)
    };
    let (found, regions): (Borders, Regions<Option<Class>>) = counted(py, progress, 0, work)?;
    Ok(PyBorders {
        free: found.parameters,
        stripes: found.stripes(),
        borders: found.borders.into_iter().map(PyBorder::from).collect(),
        unexplained: found.unexplained.into_iter().map(|change| (change.family, change.between)).collect(),
        // What could not be told has no class.
        regions: regions.named(|class| class.map_or("unknown", Class::name).to_owned()),
        caption,
    })
}
