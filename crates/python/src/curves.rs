//! Curves of events as two parameters vary.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use vibrochain_breather::BranchError;
use vibrochain_floquet::{CurveError, CurvePoint, Event, EventCurve, Search, Walk, Window, event_curve};
use vibrochain_lattice::{Parameter, Stop};
use vibrochain_maps::followed::touch;

use crate::call::long;
use crate::events::PyLocated;
use crate::orbits::PyOrbit;
use crate::params::parameter;

/// The curve of an event in the plane of two parameters.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
/// >>> point = vc.locate(model.breathers("single-sided").physical(), "period-doubling", "amplitude").points[0]
/// >>> curve = vc.curve(point, "restitution", from_=0.1, to=0.3, and_from=0.2, and_to=0.3, tolerance=1e-3)
/// >>> curve.free, curve.values.shape == (len(curve.orbits), 2), bool(curve.errors.max() < 1e-9)
/// (('amplitude', 'restitution'), True, True)
#[pyclass(frozen, name = "EventCurve", module = "vibrochain")]
#[derive(Serialize, Deserialize)]
pub(crate) struct PyEventCurve {
    event: Event,
    free: [Parameter; 2],
    points: Vec<Point>,
    /// list of Orbit : the orbits.
    #[pyo3(get)]
    orbits: Vec<PyOrbit>,
    /// list of (str, int, float) : points of codimension two: "1:1", "1:2", "1:3", "1:4", "cusp" or another event; which of the
    /// points; its error.
    #[pyo3(get)]
    special: Vec<(String, usize, f64)>,
    /// tuple of (str, str) : how it ends before the first and behind the last point.
    #[pyo3(get)]
    ends: (String, String),
    /// str : of a curve of grazing, which site touches which barrier; empty of other events.
    #[pyo3(get)]
    touch: String,
}

/// What a point of a curve has besides its orbit.
#[derive(Serialize, Deserialize)]
struct Point {
    values: [f64; 2],
    error: f64,
    angle: Option<f64>,
    physical: Option<bool>,
}

impl PyEventCurve {
    fn new(curve: EventCurve, free: [Parameter; 2]) -> Self {
        let touch = touch(&curve);
        let EventCurve { event, points, special, ends: [first, last], .. } = curve;
        let point = |CurvePoint { values, error, orbit, angle, physical }: CurvePoint| {
            (Point { values, error, angle, physical }, PyOrbit::new(orbit))
        };
        let (points, orbits) = points.into_iter().map(point).unzip();
        let special =
            special.iter().map(|special| (special.special.to_string(), special.point, special.error)).collect();
        Self { event, free, points, orbits, special, ends: (first.to_string(), last.to_string()), touch }
    }
}

#[pymethods]
impl PyEventCurve {
    /// str : which event.
    #[getter]
    fn event(&self) -> &'static str {
        self.event.name()
    }

    /// tuple of (str, str) : the two parameters.
    #[getter]
    fn free(&self) -> (&'static str, &'static str) {
        let [first, second] = self.free.map(Parameter::name);
        (first, second)
    }

    /// numpy.ndarray of float64, shape (k, 2) : values of both parameters; a closed curve has its first point once more at the end.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let values: Vec<f64> = self.points.iter().flat_map(|point| point.values).collect();
        values.into_pyarray(py).reshape([self.points.len(), 2])
    }

    /// numpy.ndarray of float64, shape (k,) : how far the curve may pass from the points, as a part of the window's sides.
    #[getter]
    fn errors<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.points.iter().map(|point| point.error).collect::<Vec<_>>().into_pyarray(py)
    }

    /// numpy.ndarray of float64, shape (k,) : angle over pi of the pair that meets the circle, of Neimark-Sacker; otherwise NaN.
    #[getter]
    fn angles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.points.iter().map(|point| point.angle.unwrap_or(f64::NAN)).collect::<Vec<_>>().into_pyarray(py)
    }

    /// numpy.ndarray of bool, shape (k,) : the orbit is known to be physical, touches of the event itself aside.
    #[getter]
    fn physical<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.points.iter().map(|point| point.physical == Some(true)).collect::<Vec<_>>().into_pyarray(py)
    }

    fn __repr__(&self) -> String {
        let [first, second] = self.free;
        format!("<EventCurve of {} in {first} and {second}: {} points>", self.event, self.points.len())
    }
}

/// The curve of an event as two parameters vary.
///
/// Parameters
/// ----------
/// point : Located
///     An event that `locate` or `branch` has found; its parameter is the first.
/// and_ : str
///     The second parameter.
/// from_, to : float, optional
///     The range of the first parameter, as of `locate`.
/// and_from, and_to : float, optional
///     The range of the second.
/// tolerance : float
///     How far a straight line between two neighbouring points may be from the curve, as a part of the window's sides.
///
/// Returns
/// -------
/// EventCurve
///
/// Raises
/// ------
/// RequestError
///     For a window that does not hold the event, the same parameter twice, or one that the orbit does not have.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
/// >>> point = vc.locate(model.breathers("single-sided").physical(), "period-doubling", "amplitude").points[0]
/// >>> vc.curve(point, "restitution", from_=0.1, to=0.3, and_from=0.2, and_to=0.3, tolerance=1e-3).ends
/// ('at the edge of the window', 'at the edge of the window')
#[pyfunction]
#[pyo3(signature = (point, and_, *, from_ = None, to = None, and_from = None, and_to = None, tolerance = 1e-6))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn curve(
    py: Python<'_>,
    point: PyRef<'_, PyLocated>,
    and_: &str,
    from_: Option<f64>,
    to: Option<f64>,
    and_from: Option<f64>,
    and_to: Option<f64>,
    tolerance: f64,
) -> PyResult<PyEventCurve> {
    let (event, evidence, orbit) = (point.event, point.evidence, point.orbit.0.clone());
    let free = [point.free, parameter("and_", and_)?];
    let usual = free.map(|parameter| Search::new(&orbit, event, parameter));
    let window = Window {
        from: [from_.unwrap_or(usual[0].from), and_from.unwrap_or(usual[1].from)],
        to: [to.unwrap_or(usual[0].to), and_to.unwrap_or(usual[1].to)],
    };
    let follow = move |stop: &Stop| {
        let lattice = orbit.lattice().map_err(BranchError::from).map_err(CurveError::from)?;
        let numbers = lattice.numbers(&free, stop);
        event_curve(&orbit, event, evidence, &numbers, &Walk { stop: stop.clone(), ..Walk::new(window, tolerance) })
    };
    Ok(PyEventCurve::new(long(py, |_| Ok(()), follow)?, free))
}
