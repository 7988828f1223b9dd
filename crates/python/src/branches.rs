//! Branches of breathers as one parameter varies, and the diagrams they make.

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use vibrochain_floquet::{Course, Event, FollowedBranch, Mechanism, Station, diagram_until};
use vibrochain_lattice::{Parameter, Stop};
use vibrochain_maps::followed::title;
use vibrochain_maps::scene::tolerance_from;

use crate::call::long;
use crate::events::{PyBranchPoint, PyEnd, PyLocated, event};
use crate::failure::{Failure, whole};
use crate::lengths::items;
use crate::orbits::PyOrbit;
use crate::params::parameter;
use crate::structures::places;

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
#[pyclass(frozen, get_all, name = "Branch", module = "vibrochain")]
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct PyBranch {
    /// list of BranchPoint : its points in the order of the way.
    points: Vec<PyBranchPoint>,
    /// list of Located : the events on it, in the same order.
    events: Vec<PyLocated>,
    /// list of int : how many of the points lie before each event.
    places: Vec<usize>,
    /// str : the parameter that varies.
    free: String,
    /// str : what its orbits are: the family, or the word.
    name: String,
    /// int : how many branches lie between it and the orbit's own.
    generation: u32,
    /// tuple of (int, float), or None : the branch that it leaves, by its place in the diagram, and the value there.
    origin: Option<(usize, f64)>,
    /// list of (float, float) : ranges in which rounding may hide more events.
    unresolved: Vec<(f64, f64)>,
    /// int : steps in which a thin stripe of instability may hide.
    untold: usize,
    /// list of End : how it ends before the first and behind the last point; one that leaves another has its origin first.
    ends: Vec<PyEnd>,
}

impl PyBranch {
    fn new(branch: FollowedBranch, origin: Option<(usize, f64)>, free: Parameter) -> Self {
        let FollowedBranch { generation, stations, unresolved, untold, ends, .. } = branch;
        let places = places(&stations);
        let (mut points, mut events) = (Vec::<PyBranchPoint>::new(), Vec::new());
        for station in stations {
            match station {
                Station::Point(point) => points.push(point.into()),
                Station::Event(located) => events.push(PyLocated::new(located, free)),
            }
        }
        let name = points.first().map_or_else(String::new, |point| title(&point.orbit.0));
        let unresolved = unresolved.iter().map(|place| (place.from, place.to)).collect();
        let (free, ends) = (free.name().to_owned(), ends.iter().map(PyEnd::from).collect());
        Self { points, events, places, free, name, generation, origin, unresolved, untold, ends }
    }

    fn column<'py>(&self, py: Python<'py>, value: impl Fn(&PyBranchPoint) -> Option<f64>) -> Bound<'py, PyArray1<f64>> {
        let values: Vec<f64> = self.points.iter().map(|point| value(point).unwrap_or(f64::NAN)).collect();
        values.into_pyarray(py)
    }
}

#[pymethods]
impl PyBranch {
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
        self.column(py, |point| point.verdict.as_ref().map(|verdict| verdict.spectral_radius))
    }

    /// numpy.ndarray of bool, shape (k,) : known to be physical.
    #[getter]
    fn physical<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.points.iter().map(|point| point.physical == Some(true)).collect::<Vec<_>>().into_pyarray(py)
    }

    /// numpy.ndarray of bool, shape (k,) : known to be stable.
    #[getter]
    fn stable<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        let stable = |point: &PyBranchPoint| point.verdict.as_ref().is_some_and(|verdict| verdict.stable);
        self.points.iter().map(stable).collect::<Vec<_>>().into_pyarray(py)
    }

    /// list of str or None : how stability is lost at the points.
    #[getter]
    fn mechanism(&self) -> Vec<Option<&'static str>> {
        let mechanism = |point: &PyBranchPoint| point.verdict.as_ref()?.mechanism.map(Mechanism::name);
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
#[pyclass(frozen, get_all, name = "Diagram", module = "vibrochain")]
#[derive(Serialize, Deserialize)]
pub(crate) struct PyDiagram {
    /// str : the parameter that varies.
    free: String,
    /// list of Branch : the orbit's own first, then those that leave it, then those that leave these.
    branches: Vec<PyBranch>,
    /// list of (int, float) : branch and value of events at which no branch could be taken up, though one was looked for.
    dead_ends: Vec<(usize, f64)>,
    /// bool : all branches were followed.
    complete: bool,
    /// int : orbits assembled.
    evaluations: usize,
    /// int : eigenvalue problems solved.
    spectra: usize,
}

#[pymethods]
impl PyDiagram {
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
///     Excess per period below which an orbit counts as stable; strict if not given.
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
    events: Option<&Bound<'_, PyAny>>,
    generations: Option<&Bound<'_, PyAny>>,
    threshold: Option<f64>,
) -> PyResult<PyDiagram> {
    let (orbit, free) = (orbit.0.clone(), parameter("free", free)?);
    let mut course = Course::new(&orbit, free);
    course.from = from_.unwrap_or(course.from);
    course.to = to.unwrap_or(course.to);
    if let Some(names) = events {
        let asked = items("events", names, Event::ALL.len())?;
        let asked = asked.iter().map(|name| Ok(event(&name.extract::<String>()?)?)).collect::<PyResult<Vec<_>>>()?;
        course.events.retain(|event| asked.contains(event));
    }
    let generations = generations.map_or(Ok(0), |count| whole("generations", count, 0, i64::from(u32::MAX)))?;
    course.generations = generations as u32;
    if let Some(threshold) = threshold {
        course.tolerance = tolerance_from(threshold).map_err(Failure::from)?;
    }
    let follow = move |stop: &Stop| diagram_until(&orbit, &course, stop);
    let answer = long(py, |_| Ok(()), follow)?;
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
        free: free.name().to_owned(),
        branches: branches.map(|(branch, origin)| PyBranch::new(branch, origin, free)).collect(),
        dead_ends,
        complete: answer.complete,
        evaluations: answer.evaluations,
        spectra: answer.spectra,
    })
}
