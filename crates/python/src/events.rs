//! Events on the branch of a breather as one parameter varies.

use pyo3::prelude::*;
use pyo3::types::PyComplex;
use serde::{Deserialize, Serialize};
use vibrochain_breather::Approach;
use vibrochain_floquet::{BranchedOrbit, Branching, DiagramPoint, End, Event, Evidence, Located, Search, locate_until};
use vibrochain_lattice::{Parameter, Stop};

use crate::answers::PyVerdict;
use crate::call::long;
use crate::failure::{Failure, named};
use crate::orbits::PyOrbit;
use crate::params::parameter;

/// The event of that name.
pub(crate) fn event(name: &str) -> Result<Event, Failure> {
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
#[pyclass(frozen, eq, get_all, name = "End", module = "vibrochain")]
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PyEnd {
    /// float : value of the parameter.
    value: f64,
    /// str : "range", "fold", "closed", "symmetric" (it meets its own mirror image), "period-doubling" (it ends on orbits of half
    /// its period), "resonance", "unbounded", "impulses-vanish", "grazing" (two impacts vanish together), "lost" or "unwatched".
    reason: String,
    /// str or None : what there is to say besides.
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
            End::Range
            | End::Closed
            | End::Pitchfork
            | End::PeriodDoubling
            | End::Unbounded
            | End::ImpulsesVanish
            | End::Grazing => None,
        };
        Self { value: *value, reason: end.name().to_owned(), detail }
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
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct PyLocated {
    pub(crate) event: Event,
    pub(crate) free: Parameter,
    /// float : its value.
    #[pyo3(get)]
    value: f64,
    /// float : its estimated error; inf where no bound is known.
    #[pyo3(get)]
    error: f64,
    /// Orbit : the orbit there.
    #[pyo3(get)]
    pub(crate) orbit: PyOrbit,
    pub(crate) evidence: Evidence,
    /// bool or None : whether it is physical, where that can be told; at grazing a matter of rounding.
    #[pyo3(get)]
    physical: Option<bool>,
    /// list of (float, Verdict, bool or None) : the orbits a small step away on either side, as far as they exist there: where, whether they are
    /// stable, and whether they are physical.
    #[pyo3(get)]
    sides: Vec<(f64, PyVerdict, Option<bool>)>,
    /// list of BranchPoint : the orbits that branch off, a small step from the event.
    #[pyo3(get)]
    branching: Vec<PyBranchPoint>,
}

impl PyLocated {
    pub(crate) fn new(located: Located, free: Parameter) -> Self {
        let Located { event, value, error, orbit, evidence, physical, sides, branching, .. } = located;
        let off = |Branching { value, orbits, .. }: Branching| {
            let point = move |BranchedOrbit { orbit, physical, verdict }| PyBranchPoint {
                value,
                orbit: PyOrbit::new(orbit),
                margin: None,
                physical,
                verdict: verdict.as_ref().map(PyVerdict::from),
            };
            orbits.into_iter().map(point).collect()
        };
        Self {
            event,
            free,
            value,
            error,
            orbit: PyOrbit::new(orbit),
            evidence,
            physical,
            sides: sides.iter().map(|side| (side.value, (&side.stability).into(), side.physical)).collect(),
            branching: branching.map_or_else(Vec::new, off),
        }
    }
}

#[pymethods]
impl PyLocated {
    /// str : "grazing", "pitchfork", "period-doubling", "neimark-sacker" or "fold".
    #[getter]
    fn event(&self) -> &'static str {
        self.event.name()
    }

    /// str : the parameter that varies.
    #[getter]
    fn free(&self) -> &'static str {
        self.free.name()
    }

    /// complex or None : the multiplier that meets the circle.
    #[getter]
    fn multiplier<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyComplex>> {
        match self.evidence {
            Evidence::Multiplier(multiplier) => Some(PyComplex::from_doubles(py, multiplier.re, multiplier.im)),
            Evidence::Touch(_) | Evidence::Impact(_) => None,
        }
    }

    /// tuple of (int, str, float), or None : mass, barrier and time of a touch, at grazing.
    #[getter]
    fn touch(&self) -> Option<(usize, &'static str, f64)> {
        match self.evidence {
            Evidence::Touch(Approach { site, barrier, time }) => Some((site, barrier.name(), time)),
            Evidence::Multiplier(_) | Evidence::Impact(_) => None,
        }
    }

    /// int or None : index of the impact that has lost its velocity, at grazing.
    #[getter]
    fn impact(&self) -> Option<usize> {
        match self.evidence {
            Evidence::Impact(impact) => Some(impact),
            Evidence::Multiplier(_) | Evidence::Touch(_) => None,
        }
    }

    fn __repr__(&self) -> String {
        format!("<{} at {} = {}>", self.event, self.free, self.value)
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
#[pyclass(frozen, get_all, name = "Events", module = "vibrochain")]
#[derive(Serialize, Deserialize)]
pub(crate) struct PyEvents {
    /// list of Located : the events, the one nearest to the start first.
    points: Vec<PyLocated>,
    /// list of (float, float) : ranges of the parameter in which rounding may hide more.
    unresolved: Vec<(f64, f64)>,
    /// list of End : how the ways down and up ended.
    ends: Vec<PyEnd>,
    /// tuple of (float, float) : the range that was searched.
    range: (f64, f64),
    /// int : orbits assembled.
    evaluations: usize,
    /// int : eigenvalue problems solved.
    spectra: usize,
}

#[pymethods]
impl PyEvents {
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
    let find = move |stop: &Stop| locate_until(&orbit, &search, stop);
    let answer = long(py, |_| Ok(()), find)?;
    Ok(PyEvents {
        points: answer.located.into_iter().map(|located| PyLocated::new(located, free)).collect(),
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
#[pyclass(frozen, get_all, name = "BranchPoint", module = "vibrochain")]
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct PyBranchPoint {
    /// float : value of the parameter.
    pub(crate) value: f64,
    /// Orbit : the orbit.
    pub(crate) orbit: PyOrbit,
    /// float or None : smallest distance of any mass to a barrier.
    pub(crate) margin: Option<f64>,
    /// bool or None : whether it is physical, where that can be told.
    pub(crate) physical: Option<bool>,
    /// Verdict or None : its stability, where it can be judged.
    pub(crate) verdict: Option<PyVerdict>,
}

impl From<DiagramPoint> for PyBranchPoint {
    fn from(DiagramPoint { value, orbit, margin, physical, verdict }: DiagramPoint) -> Self {
        Self { value, orbit: PyOrbit::new(orbit), margin, physical, verdict: verdict.as_ref().map(PyVerdict::from) }
    }
}

#[pymethods]
impl PyBranchPoint {
    fn __repr__(&self) -> String {
        format!("<BranchPoint at {}: {}>", self.value, self.orbit.0)
    }
}
