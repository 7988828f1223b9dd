//! What happens to a breather as parameters vary: events, branches, curves.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyComplex;
use vibrochain_breather::Approach;
use vibrochain_floquet::{
    BranchedOrbit, Branching, Course, DiagramPoint, End, Event, EventCurve, Evidence, FollowedBranch, Located,
    Mechanism, Search, Station, Window, diagram,
};
use vibrochain_lattice::Parameter;
use vibrochain_maps::scene::tolerance_from;

use crate::answers::{PyVerdict, complex};
use crate::call::long;
use crate::failure::{Failure, named, whole};
use crate::orbits::PyOrbit;
use crate::params::parameter;

fn event(name: &str) -> Result<Event, Failure> {
    named("event", name, Event::ALL.map(|event| (event.name(), event)))
}

/// How a way ended: a value of the parameter, and why there.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4)
/// >>> orbit = model.breathers("double-sided").physical()
/// >>> [end.reason for end in vc.locate(orbit, "grazing", "asymmetry", from_=0.3, to=0.5).ends]
/// ['range', 'range']
#[pyclass(frozen, eq, name = "End", module = "vibrochain")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyEnd {
    /// float : value of the parameter.
    #[pyo3(get)]
    value: f64,
    /// str : "range", "fold", "closed", "symmetric" (it meets its own mirror image), "resonance", "unbounded", "impulses-vanish",
    /// "lost" or "unwatched".
    #[pyo3(get)]
    reason: &'static str,
    /// str or None : what there is to say besides.
    #[pyo3(get)]
    detail: Option<String>,
}

#[pymethods]
impl PyEnd {
    fn __repr__(&self) -> String {
        let detail = self.detail.as_ref().map_or_else(String::new, |detail| format!(": {detail}"));
        format!("<{} at {}{detail}>", self.reason, self.value)
    }
}

impl From<&(f64, End)> for PyEnd {
    fn from((value, end): &(f64, End)) -> Self {
        let detail = match end {
            End::Fold { error } => Some(format!("known to {error:.0e}")),
            End::Resonance(resonance) => Some(resonance.to_string()),
            End::Lost(error) => Some(error.to_string()),
            End::Unwatched(error) => Some(error.to_string()),
            End::Range | End::Closed | End::Pitchfork | End::Unbounded | End::ImpulsesVanish => None,
        };
        Self { value: *value, reason: end.name(), detail }
    }
}

/// An event on a branch: a grazing, pitchfork, period doubling, Neimark-Sacker or fold.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
/// >>> orbit = model.breathers("single-sided").physical()
/// >>> point = vc.locate(orbit, "period-doubling", "amplitude").points[0]
/// >>> point.event, round(point.value, 6), abs(point.multiplier + 1) < 1e-9
/// ('period-doubling', 0.158908, True)
/// >>> point.branching[0].orbit.family
/// 'period-doubled'
#[pyclass(frozen, name = "Located", module = "vibrochain")]
#[derive(Clone)]
pub(crate) struct PyLocated {
    located: Located,
    free: Parameter,
}

#[pymethods]
impl PyLocated {
    /// str : "grazing", "pitchfork", "period-doubling", "neimark-sacker" or "fold".
    #[getter]
    fn event(&self) -> &'static str {
        self.located.event.name()
    }

    /// str : the parameter that varies.
    #[getter]
    fn free(&self) -> &'static str {
        self.free.name()
    }

    /// float : its value.
    #[getter]
    fn value(&self) -> f64 {
        self.located.value
    }

    /// float : its estimated error; inf where no bound is known.
    #[getter]
    fn error(&self) -> f64 {
        self.located.error
    }

    /// Orbit : the orbit there.
    #[getter]
    fn orbit(&self) -> PyOrbit {
        PyOrbit::new(self.located.orbit.clone())
    }

    /// bool or None : whether it is physical, where that can be told; at grazing a matter of rounding.
    #[getter]
    fn physical(&self) -> Option<bool> {
        self.located.physical
    }

    /// complex or None : the multiplier that meets the circle.
    #[getter]
    fn multiplier<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyComplex>> {
        match self.located.evidence {
            Evidence::Multiplier(multiplier) => Some(complex(py, multiplier)),
            Evidence::Touch(_) | Evidence::Impact(_) => None,
        }
    }

    /// tuple of (int, str, float), or None : mass, barrier and time of a touch, at grazing.
    #[getter]
    fn touch(&self) -> Option<(usize, &'static str, f64)> {
        match self.located.evidence {
            Evidence::Touch(Approach { site, barrier, time }) => Some((site, barrier.name(), time)),
            Evidence::Multiplier(_) | Evidence::Impact(_) => None,
        }
    }

    /// int or None : index of the impact that has lost its velocity, at grazing.
    #[getter]
    fn impact(&self) -> Option<usize> {
        match self.located.evidence {
            Evidence::Impact(impact) => Some(impact),
            Evidence::Multiplier(_) | Evidence::Touch(_) => None,
        }
    }

    /// list of (float, Verdict) : the verdict a small step away on either side, as far as the orbit exists there.
    #[getter]
    fn sides(&self) -> Vec<(f64, PyVerdict)> {
        self.located.verdicts.iter().map(|(value, verdict)| (*value, PyVerdict(*verdict))).collect()
    }

    /// list of BranchPoint : the orbits that branch off, a small step from the event.
    #[getter]
    fn branching(&self) -> Vec<PyBranchPoint> {
        let orbits = |Branching { value, orbits, .. }: &Branching| {
            let point = |BranchedOrbit { orbit, physical, verdict }: &BranchedOrbit| PyBranchPoint {
                value: *value,
                orbit: PyOrbit::new(orbit.clone()),
                margin: None,
                physical: *physical,
                verdict: verdict.map(PyVerdict),
            };
            orbits.iter().map(point).collect()
        };
        self.located.branching.as_ref().map_or_else(Vec::new, orbits)
    }

    fn __repr__(&self) -> String {
        format!("<{} at {} = {}>", self.located.event, self.free, self.located.value)
    }
}

/// The answer of `locate`: all events of a kind on a branch.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4)
/// >>> orbit = model.breathers("double-sided").physical()
/// >>> vc.locate(orbit, "grazing", "asymmetry", from_=0.3, to=0.5).points
/// []
#[pyclass(frozen, name = "Events", module = "vibrochain")]
pub(crate) struct PyEvents {
    points: Vec<PyLocated>,
    /// list of (float, float) : ranges of the parameter in which rounding may hide more.
    #[pyo3(get)]
    unresolved: Vec<(f64, f64)>,
    /// list of End : how the ways down and up ended.
    #[pyo3(get)]
    ends: Vec<PyEnd>,
    /// tuple of (float, float) : the range that was searched.
    #[pyo3(get)]
    range: (f64, f64),
    /// int : orbits assembled.
    #[pyo3(get)]
    evaluations: usize,
    /// int : eigenvalue problems solved.
    #[pyo3(get)]
    spectra: usize,
}

#[pymethods]
impl PyEvents {
    /// list of Located : the events, the one nearest to the start first.
    #[getter]
    fn points(&self) -> Vec<PyLocated> {
        self.points.clone()
    }

    fn __repr__(&self) -> String {
        let points: Vec<String> = self.points.iter().map(PyLocated::__repr__).collect();
        format!("<Events between {} and {}: [{}]>", self.range.0, self.range.1, points.join(", "))
    }
}

/// Where a breather bifurcates or grazes as one parameter varies.
///
/// Parameters
/// ----------
/// orbit : Orbit
///     Where to start.
/// event : str
///     "grazing", "pitchfork", "period-doubling", "neimark-sacker" or "fold".
/// free : str
///     The parameter that varies: "gamma1", "gamma2", "gamma3", "omega", "asymmetry", "amplitude" or "restitution".
/// from_, to : float, optional
///     The range; half to twice the start if not given (asymmetry 0 to 0.99, restitution 0.05 to 1).
///
/// Returns
/// -------
/// Events
///     That there is none is an answer.
///
/// Raises
/// ------
/// RequestError
///     For a range that does not hold the start, or a parameter that the orbit does not have.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
/// >>> orbit = model.breathers("single-sided").physical()
/// >>> vc.locate(orbit, "fold", "amplitude").points[0].error < 1e-9
/// True
#[pyfunction]
#[pyo3(signature = (orbit, event, free, *, from_ = None, to = None))]
pub(crate) fn locate(
    py: Python<'_>,
    orbit: PyRef<'_, PyOrbit>,
    event: &str,
    free: &str,
    from_: Option<f64>,
    to: Option<f64>,
) -> PyResult<PyEvents> {
    let (orbit, event, free) = (orbit.0.clone(), self::event(event)?, parameter("free", free)?);
    let usual = Search::new(&orbit, event, free);
    let search = Search { from: from_.unwrap_or(usual.from), to: to.unwrap_or(usual.to), ..usual };
    let answer = long(py, |_| Ok(()), move |_| vibrochain_floquet::locate(&orbit, &search))?;
    Ok(PyEvents {
        points: answer.located.into_iter().map(|located| PyLocated { located, free }).collect(),
        unresolved: answer.unresolved.iter().map(|place| (place.from, place.to)).collect(),
        ends: answer.ends.iter().map(PyEnd::from).collect(),
        range: (search.from, search.to),
        evaluations: answer.evaluations,
        spectra: answer.spectra,
    })
}

/// A point of a branch.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4)
/// >>> orbit = model.breathers("double-sided").physical()
/// >>> diagram = vc.branch(orbit, "asymmetry", from_=0.39, to=0.41, events=["grazing"])
/// >>> point = diagram.branches[0].points[0]
/// >>> point.orbit.model.asymmetry == point.value, point.physical
/// (True, True)
#[pyclass(frozen, name = "BranchPoint", module = "vibrochain")]
#[derive(Clone)]
pub(crate) struct PyBranchPoint {
    /// float : value of the parameter.
    #[pyo3(get)]
    value: f64,
    /// Orbit : the orbit.
    #[pyo3(get)]
    orbit: PyOrbit,
    /// float or None : smallest distance of any mass to a barrier.
    #[pyo3(get)]
    margin: Option<f64>,
    /// bool or None : whether it is physical, where that can be told.
    #[pyo3(get)]
    physical: Option<bool>,
    /// Verdict or None : its stability, where it can be judged.
    #[pyo3(get)]
    verdict: Option<PyVerdict>,
}

impl From<DiagramPoint> for PyBranchPoint {
    fn from(DiagramPoint { value, orbit, margin, physical, verdict }: DiagramPoint) -> Self {
        Self { value, orbit: PyOrbit::new(orbit), margin, physical, verdict: verdict.map(PyVerdict) }
    }
}

#[pymethods]
impl PyBranchPoint {
    fn __repr__(&self) -> String {
        format!("<BranchPoint at {}: {}>", self.value, self.orbit.0)
    }
}

/// A branch of breathers as one parameter varies.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
/// >>> diagram = vc.branch(model.breathers("single-sided").physical(), "amplitude", from_=0.15, to=0.17)
/// >>> branch = diagram.branches[0]
/// >>> branch.values.shape == branch.spectral_radius.shape == (len(branch.points),)
/// True
/// >>> sorted({point.event for point in branch.events})
/// ['fold', 'neimark-sacker', 'period-doubling']
#[pyclass(frozen, name = "Branch", module = "vibrochain")]
#[derive(Clone)]
pub(crate) struct PyBranch {
    points: Vec<PyBranchPoint>,
    events: Vec<PyLocated>,
    /// int : how many branches lie between it and the orbit's own.
    #[pyo3(get)]
    generation: u32,
    /// tuple of (int, float), or None : the branch that it leaves, by its place in the diagram, and the value there.
    #[pyo3(get)]
    origin: Option<(usize, f64)>,
    /// list of (float, float) : ranges in which rounding may hide more events.
    #[pyo3(get)]
    unresolved: Vec<(f64, f64)>,
    /// int : steps in which a thin stripe of instability may hide.
    #[pyo3(get)]
    untold: usize,
    /// list of End : how it ends before the first and behind the last point; one that leaves another has its origin first.
    #[pyo3(get)]
    ends: Vec<PyEnd>,
}

impl PyBranch {
    fn new(branch: FollowedBranch, origin: Option<(usize, f64)>, free: Parameter) -> Self {
        let FollowedBranch { generation, stations, unresolved, untold, ends, .. } = branch;
        let (mut points, mut events) = (Vec::new(), Vec::new());
        for station in stations {
            match station {
                Station::Point(point) => points.push(point.into()),
                Station::Event(located) => events.push(PyLocated { located, free }),
            }
        }
        let unresolved = unresolved.iter().map(|place| (place.from, place.to)).collect();
        Self { points, events, generation, origin, unresolved, untold, ends: ends.iter().map(PyEnd::from).collect() }
    }

    fn column<'py>(&self, py: Python<'py>, value: impl Fn(&PyBranchPoint) -> Option<f64>) -> Bound<'py, PyArray1<f64>> {
        let values: Vec<f64> = self.points.iter().map(|point| value(point).unwrap_or(f64::NAN)).collect();
        values.into_pyarray(py)
    }
}

#[pymethods]
impl PyBranch {
    /// list of BranchPoint : its points in the order of the way.
    #[getter]
    fn points(&self) -> Vec<PyBranchPoint> {
        self.points.clone()
    }

    /// list of Located : the events on it, in the same order.
    #[getter]
    fn events(&self) -> Vec<PyLocated> {
        self.events.clone()
    }

    /// numpy.ndarray of float64, shape (k,) : values of the parameter at the points.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |point| Some(point.value))
    }

    /// numpy.ndarray of float64, shape (k,) : the largest modulus of an impulse.
    #[getter]
    fn impulse<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |point| point.orbit.0.impacts().iter().map(|impact| impact.impulse.abs()).reduce(f64::max))
    }

    /// numpy.ndarray of float64, shape (k,) : smallest distances to a barrier; NaN where an impact has the wrong sign.
    #[getter]
    fn margin<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |point| point.margin)
    }

    /// numpy.ndarray of float64, shape (k,) : spectral radii; NaN where stability cannot be judged.
    #[getter]
    fn spectral_radius<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |point| point.verdict.as_ref().map(|verdict| verdict.0.spectral_radius))
    }

    /// numpy.ndarray of bool, shape (k,) : known to be physical.
    #[getter]
    fn physical<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.points.iter().map(|point| point.physical == Some(true)).collect::<Vec<_>>().into_pyarray(py)
    }

    /// numpy.ndarray of bool, shape (k,) : known to be stable.
    #[getter]
    fn stable<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        let stable = |point: &PyBranchPoint| point.verdict.as_ref().is_some_and(|verdict| verdict.0.stable);
        self.points.iter().map(stable).collect::<Vec<_>>().into_pyarray(py)
    }

    /// list of str or None : how stability is lost at the points.
    #[getter]
    fn mechanism(&self) -> Vec<Option<&'static str>> {
        let mechanism = |point: &PyBranchPoint| point.verdict.as_ref()?.0.mechanism.map(Mechanism::name);
        self.points.iter().map(mechanism).collect()
    }

    fn __repr__(&self) -> String {
        let (points, events) = (self.points.len(), self.events.len());
        format!("<Branch of generation {}: {points} points, {events} events>", self.generation)
    }
}

/// A bifurcation diagram: the branch of an orbit, and those that leave it.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4)
/// >>> orbit = model.breathers("double-sided").physical()
/// >>> vc.branch(orbit, "asymmetry", from_=0.39, to=0.41, events=["grazing"]).complete
/// True
#[pyclass(frozen, name = "Diagram", module = "vibrochain")]
pub(crate) struct PyDiagram {
    /// str : the parameter that varies.
    #[pyo3(get)]
    free: &'static str,
    branches: Vec<PyBranch>,
    /// list of (int, float) : branch and value of events at which no branch could be taken up, though one was looked for.
    #[pyo3(get)]
    dead_ends: Vec<(usize, f64)>,
    /// bool : all branches were followed.
    #[pyo3(get)]
    complete: bool,
    /// int : orbits assembled.
    #[pyo3(get)]
    evaluations: usize,
    /// int : eigenvalue problems solved.
    #[pyo3(get)]
    spectra: usize,
}

#[pymethods]
impl PyDiagram {
    /// list of Branch : the orbit's own first, then those that leave it, then those that leave these.
    #[getter]
    fn branches(&self) -> Vec<PyBranch> {
        self.branches.clone()
    }

    fn __repr__(&self) -> String {
        format!("<Diagram in {}: {} branches>", self.free, self.branches.len())
    }
}

/// The branch of a breather as one parameter varies, through its folds, with every event on it, and the branches that leave it.
///
/// Parameters
/// ----------
/// orbit : Orbit
///     Where to start.
/// free : str
///     The parameter that varies.
/// from_, to : float, optional
///     The range, as of `locate`.
/// events : sequence of str, optional
///     What to look for; everything if not given. Multipliers come from dense matrices, which takes long from a hundred masses on;
///     ["grazing", "fold"] needs none.
/// generations : int
///     How often a branch may leave another; 0 is the orbit's own alone.
/// threshold : float, optional
///     Growth per period below which an orbit counts as stable; strict if not given.
///
/// Returns
/// -------
/// Diagram
///
/// Raises
/// ------
/// RequestError
///     For a range that does not hold the start, or a parameter that the orbit does not have.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
/// >>> orbit = model.breathers("single-sided").physical()
/// >>> diagram = vc.branch(orbit, "amplitude", from_=0.158, to=0.166, generations=1)
/// >>> [branch.points[0].orbit.force_periods for branch in diagram.branches][:2]
/// [1, 2]
#[pyfunction]
#[pyo3(signature = (orbit, free, *, from_ = None, to = None, events = None, generations = None, threshold = None))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn branch(
    py: Python<'_>,
    orbit: PyRef<'_, PyOrbit>,
    free: &str,
    from_: Option<f64>,
    to: Option<f64>,
    events: Option<Vec<String>>,
    generations: Option<&Bound<'_, PyAny>>,
    threshold: Option<f64>,
) -> PyResult<PyDiagram> {
    let (orbit, free) = (orbit.0.clone(), parameter("free", free)?);
    let mut course = Course::new(&orbit, free);
    course.from = from_.unwrap_or(course.from);
    course.to = to.unwrap_or(course.to);
    if let Some(names) = events {
        let asked = names.iter().map(|name| event(name)).collect::<Result<Vec<_>, _>>()?;
        course.events.retain(|event| asked.contains(event));
    }
    let generations = generations.map_or(Ok(0), |count| whole("generations", count, 0, i64::from(u32::MAX)))?;
    course.generations = generations as u32;
    if let Some(threshold) = threshold {
        course.tolerance = tolerance_from(threshold).map_err(Failure::Request)?;
    }
    let answer = long(py, |_| Ok(()), move |_| diagram(&orbit, &course))?;
    // An origin is always an event.
    let value = |branch: usize, station: usize| match answer.branches.get(branch)?.stations.get(station)? {
        Station::Event(located) => Some((branch, located.value)),
        Station::Point(point) => Some((branch, point.value)),
    };
    let origins: Vec<_> =
        answer.branches.iter().map(|branch| branch.origin.and_then(|from| value(from.branch, from.station))).collect();
    let dead_ends = answer.dead_ends.iter().filter_map(|end| value(end.branch, end.station)).collect();
    let branches = answer.branches.into_iter().zip(origins);
    Ok(PyDiagram {
        free: free.name(),
        branches: branches.map(|(branch, origin)| PyBranch::new(branch, origin, free)).collect(),
        dead_ends,
        complete: answer.complete,
        evaluations: answer.evaluations,
        spectra: answer.spectra,
    })
}

/// The curve of an event in the plane of two parameters.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
/// >>> point = vc.locate(model.breathers("single-sided").physical(), "period-doubling", "amplitude").points[0]
/// >>> curve = vc.curve(point, "restitution", from_=0.1, to=0.3, and_from=0.2, and_to=0.3, tolerance=1e-3)
/// >>> curve.parameters, curve.values.shape == (len(curve.orbits), 2), bool(curve.errors.max() < 1e-9)
/// (('amplitude', 'restitution'), True, True)
#[pyclass(frozen, name = "EventCurve", module = "vibrochain")]
pub(crate) struct PyEventCurve {
    /// str : which event.
    #[pyo3(get)]
    event: &'static str,
    /// tuple of (str, str) : the two parameters.
    #[pyo3(get)]
    parameters: (&'static str, &'static str),
    curve: EventCurve,
    orbits: Vec<PyOrbit>,
}

#[pymethods]
impl PyEventCurve {
    /// numpy.ndarray of float64, shape (k, 2) : values of both parameters; a closed curve has its first point once more at the end.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let values: Vec<f64> = self.curve.points.iter().flat_map(|point| point.values).collect();
        values.into_pyarray(py).reshape([self.curve.points.len(), 2])
    }

    /// numpy.ndarray of float64, shape (k,) : how far the curve may pass from the points, as a part of the window's sides.
    #[getter]
    fn errors<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.curve.points.iter().map(|point| point.error).collect::<Vec<_>>().into_pyarray(py)
    }

    /// numpy.ndarray of float64, shape (k,) : angle over pi of the pair that meets the circle, of Neimark-Sacker; otherwise NaN.
    #[getter]
    fn angles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.curve.points.iter().map(|point| point.angle.unwrap_or(f64::NAN)).collect::<Vec<_>>().into_pyarray(py)
    }

    /// numpy.ndarray of bool, shape (k,) : the orbit is known to be physical, touches of the event itself aside.
    #[getter]
    fn physical<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.curve.points.iter().map(|point| point.physical == Some(true)).collect::<Vec<_>>().into_pyarray(py)
    }

    /// list of Orbit : the orbits.
    #[getter]
    fn orbits(&self) -> Vec<PyOrbit> {
        self.orbits.clone()
    }

    /// list of (str, int, float) : points of codimension two: "1:1", "1:2", "1:3", "1:4", "cusp" or another event; which of the
    /// points; its error.
    #[getter]
    fn special(&self) -> Vec<(String, usize, f64)> {
        self.curve.special.iter().map(|special| (special.special.to_string(), special.point, special.error)).collect()
    }

    /// tuple of (str, str) : how it ends before the first and behind the last point.
    #[getter]
    fn ends(&self) -> (String, String) {
        let [first, last] = &self.curve.ends;
        (first.to_string(), last.to_string())
    }

    fn __repr__(&self) -> String {
        let (first, second) = self.parameters;
        format!("<EventCurve of {} in {first} and {second}: {} points>", self.event, self.curve.points.len())
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
    let Located { event, evidence, orbit, .. } = point.located.clone();
    let parameters = [point.free, parameter("and_", and_)?];
    let usual = parameters.map(|parameter| Search::new(&orbit, event, parameter));
    let window = Window {
        parameters,
        from: [from_.unwrap_or(usual[0].from), and_from.unwrap_or(usual[1].from)],
        to: [to.unwrap_or(usual[0].to), and_to.unwrap_or(usual[1].to)],
    };
    let follow = move |_: &_| vibrochain_floquet::curve(&orbit, event, evidence, &window, tolerance);
    let curve = long(py, |_| Ok(()), follow)?;
    let orbits = curve.points.iter().map(|point| PyOrbit::new(point.orbit.clone())).collect();
    let [first, second] = parameters.map(Parameter::name);
    Ok(PyEventCurve { event: event.name(), parameters: (first, second), curve, orbits })
}
