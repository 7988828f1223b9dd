//! What is said of an orbit: physical or not, how well known, stable or not.

use numpy::{Complex64, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyComplex;
use serde::{Deserialize, Serialize};
use vibrochain_breather::{Admissibility, Condition, Obstruction};
use vibrochain_floquet::{Mechanism, Verdict};
use vibrochain_lattice::Layout;

/// Whether an orbit is physical, and what is in the way.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=0.3, asymmetry=0.4)
/// >>> answer = model.breathers("double-sided").orbits[0].admissibility()
/// >>> answer.physical, answer.obstruction.kind
/// (False, 'crossing')
#[pyclass(frozen, eq, name = "Admissibility", module = "vibrochain")]
#[derive(PartialEq, Serialize, Deserialize)]
pub(crate) struct PyAdmissibility {
    /// bool : nothing is in the way.
    #[pyo3(get)]
    physical: bool,
    /// float or None : smallest distance of any mass to a barrier at a turning point, negative if a mass crosses; None if an
    /// impact has the wrong sign, which makes distances moot.
    #[pyo3(get)]
    margin: Option<f64>,
    /// Obstruction or None : what is in the way.
    #[pyo3(get)]
    obstruction: Option<PyObstruction>,
    text: String,
}

impl PyAdmissibility {
    pub(crate) fn new(answer: &Admissibility, layout: Layout) -> Self {
        Self {
            physical: answer.is_physical(),
            margin: answer.margin,
            obstruction: answer.obstruction.map(|found| PyObstruction::new(&found, layout)),
            text: answer.to_string(),
        }
    }
}

#[pymethods]
impl PyAdmissibility {
    fn __bool__(&self) -> bool {
        self.physical
    }

    fn __str__(&self) -> &str {
        &self.text
    }

    fn __repr__(&self) -> String {
        format!("<Admissibility: {}>", self.text)
    }
}

/// What keeps a solution from being an orbit of the real chain.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=0.3, asymmetry=0.4)
/// >>> obstruction = model.breathers("double-sided").orbits[0].admissibility().obstruction
/// >>> obstruction.excess > 0
/// True
#[pyclass(frozen, eq, name = "Obstruction", module = "vibrochain")]
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PyObstruction {
    /// str : "crossing" (a mass beyond a barrier) or "wrong-sign" (an impact from behind).
    #[pyo3(get)]
    kind: String,
    /// int : the mass, in its layer.
    #[pyo3(get)]
    site: usize,
    /// int : its layer.
    #[pyo3(get)]
    layer: usize,
    /// float : when, within the period.
    #[pyo3(get)]
    time: f64,
    /// str or None : the barrier that is crossed.
    #[pyo3(get)]
    barrier: Option<String>,
    /// float or None : how far beyond the barrier the mass is.
    #[pyo3(get)]
    excess: Option<f64>,
    /// int or None : index of the impact of the wrong sign.
    #[pyo3(get)]
    impact: Option<usize>,
    /// float or None : the velocity before that impact.
    #[pyo3(get)]
    velocity_before: Option<f64>,
    text: String,
}

impl PyObstruction {
    fn new(found: &Obstruction, layout: Layout) -> Self {
        let (kind, barrier, excess, impact, velocity_before) = match *found {
            Obstruction::WrongSign { impact, velocity_before, .. } => {
                ("wrong-sign", None, None, Some(impact), Some(velocity_before))
            }
            Obstruction::Crossing { barrier, excess, .. } => {
                ("crossing", Some(barrier.to_string()), Some(excess), None, None)
            }
            // Of chains, whose impacts are never plastic, there is none.
            Obstruction::Sticking { impact, .. } => ("sticking", None, None, Some(impact), None),
        };
        let ((site, layer), time, kind, text) =
            (layout.place(found.site()), found.time(), kind.to_owned(), found.to_string());
        Self { kind, site, layer, time, barrier, excess, impact, velocity_before, text }
    }
}

#[pymethods]
impl PyObstruction {
    fn __str__(&self) -> &str {
        &self.text
    }

    fn __repr__(&self) -> String {
        format!("<Obstruction: {}>", self.text)
    }
}

/// How far an orbit can be trusted.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1, restitution=0.9)
/// >>> condition = model.breathers("double-sided").orbits[0].condition()
/// >>> condition.resonance > 1e-3, condition.time_error < 1e-13
/// (True, True)
#[pyclass(frozen, eq, name = "Condition", module = "vibrochain")]
#[derive(PartialEq, Serialize, Deserialize)]
pub(crate) struct PyCondition {
    /// float : distance to resonance, the smallest relative one of a mode to a harmonic, at most 1.
    #[pyo3(get)]
    resonance: f64,
    /// float : distance to grazing, the smallest velocity before an impact over omega.
    #[pyo3(get)]
    grazing: f64,
    /// float : reciprocal condition number of the orbit's equations, 0 at a fold.
    #[pyo3(get)]
    fold: f64,
    /// float : a bound of the error of the impulses, relative to the largest; inf where none is known.
    #[pyo3(get)]
    impulse_error: f64,
    /// float : a bound of the error of the times, relative to the period; inf where none is known.
    #[pyo3(get)]
    time_error: f64,
    text: String,
}

impl PyCondition {
    pub(crate) fn new(condition: &Condition) -> Self {
        let Condition { resonance, grazing, fold, .. } = *condition;
        let (impulse_error, time_error) = (condition.impulse_error(), condition.time_error());
        Self { resonance, grazing, fold, impulse_error, time_error, text: condition.to_string() }
    }
}

#[pymethods]
impl PyCondition {
    fn __str__(&self) -> &str {
        &self.text
    }

    fn __repr__(&self) -> String {
        format!("<Condition: {}>", self.text)
    }
}

/// The verdict on an orbit: stable, unstable, or too close to the border to be told (undecided).
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=0.8, asymmetry=0.4)
/// >>> isinstance(model.breathers("single-sided").orbits[0].stability(), vc.Verdict)
/// True
#[pyclass(frozen, subclass, eq, name = "Verdict", module = "vibrochain")]
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PyVerdict {
    /// bool : no perturbation grows by more than the threshold, errors allowed for.
    #[pyo3(get)]
    pub(crate) stable: bool,
    /// bool : the excess is closer to the threshold than its own error.
    #[pyo3(get)]
    undecided: bool,
    pub(crate) mechanism: Option<Mechanism>,
    /// float : largest modulus of the multipliers that feel the impacts, per period of the orbit.
    #[pyo3(get)]
    pub(crate) spectral_radius: f64,
    leading: [f64; 2],
    /// float : spectral_radius - 1, with its own relative accuracy.
    #[pyo3(get)]
    excess: f64,
    /// float : estimated error of the spectral radius; 0 where structure decides.
    #[pyo3(get)]
    resolution: f64,
    /// str : "secular" or "dense", where the answer comes from.
    #[pyo3(get)]
    method: String,
    text: String,
}

impl From<&Verdict> for PyVerdict {
    fn from(verdict: &Verdict) -> Self {
        Self {
            stable: verdict.stable,
            undecided: verdict.undecided,
            mechanism: verdict.mechanism,
            spectral_radius: verdict.spectral_radius,
            leading: [verdict.leading.re, verdict.leading.im],
            excess: verdict.excess(),
            resolution: verdict.resolution,
            method: verdict.method.name().to_owned(),
            text: verdict.to_string(),
        }
    }
}

#[pymethods]
impl PyVerdict {
    /// str or None : how stability is lost: "plus-one", "pitchfork", "period-doubling" or "neimark-sacker".
    #[getter]
    fn mechanism(&self) -> Option<&'static str> {
        self.mechanism.map(Mechanism::name)
    }

    /// complex : the multiplier of that modulus.
    #[getter]
    fn leading<'py>(&self, py: Python<'py>) -> Bound<'py, PyComplex> {
        let [re, im] = self.leading;
        PyComplex::from_doubles(py, re, im)
    }

    fn __str__(&self) -> &str {
        &self.text
    }

    fn __repr__(&self) -> String {
        format!("<{}>", self.text)
    }
}

/// A verdict with all multipliers.
///
/// Examples
/// --------
/// >>> import numpy as np, vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1, restitution=0.9)
/// >>> answer = model.breathers("double-sided").orbits[0].stability()
/// >>> answer.multipliers.dtype, bool(np.isclose(abs(answer.multipliers).max(), answer.spectral_radius))
/// (dtype('complex128'), True)
#[pyclass(frozen, extends = PyVerdict, name = "Stability", module = "vibrochain")]
pub(crate) struct PyStability {
    /// numpy.ndarray of complex128, shape (2 * masses,) : the multipliers by falling modulus, then by argument.
    #[pyo3(get)]
    pub(crate) multipliers: Py<PyArray1<Complex64>>,
}

#[pymethods]
impl PyStability {
    /// Verdict : the verdict alone.
    #[getter]
    fn verdict(self_: PyRef<'_, Self>) -> PyVerdict {
        self_.into_super().clone()
    }

    /// (A class with a base is made from its two parts.)
    #[allow(clippy::type_complexity, reason = "what pickle asks for: a callable and its arguments")]
    fn __reduce__<'py>(
        self_: PyRef<'py, Self>,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (PyVerdict, Py<PyArray1<Complex64>>))> {
        let multipliers = self_.multipliers.clone_ref(py);
        Ok((py.import("vibrochain._vibrochain")?.getattr("_stability")?, (Self::verdict(self_), multipliers)))
    }
}

/// A verdict with its multipliers.
#[pyfunction]
pub(crate) fn _stability(
    py: Python<'_>,
    verdict: PyRef<'_, PyVerdict>,
    multipliers: Py<PyArray1<Complex64>>,
) -> PyResult<Py<PyStability>> {
    Py::new(py, PyClassInitializer::from(verdict.clone()).add_subclass(PyStability { multipliers }))
}
