//! Breathers: their impacts, their motion.

use std::sync::Arc;

use numpy::{IntoPyArray, IxDyn, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PySequence;
use serde::{Deserialize, Serialize};
use vibrochain_breather::{Family, Finder, Hit, Impact, Motion, Orbit, Word, admissibility, condition};
use vibrochain_floquet::{Tolerance, stability};
use vibrochain_lattice::{Barrier, Layout, MAX_SITES, Short, Stop};
use vibrochain_maps::scene::tolerance_from;

use crate::answers::{PyAdmissibility, PyCondition, PyStability, PyVerdict};
use crate::call::{call, long};
use crate::failure::{Failure, named, whole};
use crate::lengths::{items, numbers, room};
use crate::params::PyModel;

/// The most impacts that an orbit is polished with: Newton's matrix of twice as many rows takes 32 MB.
const MOST_HITS: usize = 1000;

/// One impact of an orbit.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(1, 0.0, 1.0), omega=3.141592653589793, asymmetry=0.5)
/// >>> first, second = model.breathers("double-sided").orbits[0].impacts
/// >>> second
/// Impact(site=0, barrier='lower', time=1, impulse=4, velocity_before=-2, velocity_after=2)
#[pyclass(frozen, eq, get_all, name = "Impact", module = "vibrochain")]
#[derive(PartialEq, Serialize, Deserialize)]
pub(crate) struct PyImpact {
    /// int : the mass that hits, in its layer.
    site: usize,
    /// int : its layer.
    layer: usize,
    /// int : the mass counted through all layers, as arrays over masses have it.
    mass: usize,
    /// str : "lower" or "upper".
    barrier: String,
    /// float : time within the period, 0 <= time < period.
    time: f64,
    /// float : momentum that the barrier gives to the mass, signed.
    impulse: f64,
    /// float : velocity just before.
    velocity_before: f64,
    /// float : velocity just after.
    velocity_after: f64,
    /// float : acceleration of the mass, force included; the impact does not change it.
    acceleration: f64,
}

impl PyImpact {
    fn new(impact: &Impact, layout: &Layout) -> Self {
        let Impact { site: mass, barrier, time, impulse, velocity_before, velocity_after, acceleration, .. } = *impact;
        let ((site, layer), barrier) = (layout.place(mass), barrier.to_string());
        Self { site, layer, mass, barrier, time, impulse, velocity_before, velocity_after, acceleration }
    }
}

#[pymethods]
impl PyImpact {
    fn __repr__(&self) -> String {
        let Self { site, barrier, .. } = self;
        let layer = if self.layer > 0 { format!(", layer={}", self.layer) } else { String::new() };
        let [time, impulse, before, after] =
            [self.time, self.impulse, self.velocity_before, self.velocity_after].map(Short);
        format!(
            "Impact(site={site}{layer}, barrier='{barrier}', time={time}, impulse={impulse}, velocity_before={before}, velocity_after={after})"
        )
    }
}

/// A periodic orbit with impacts: a breather.
///
/// Orbits come from `Model.breathers`, `Orbit.near`, `locate` and `branch`. Time 0 is the impact on the upper barrier of a
/// double-sided orbit, the first or only one of the others.
///
/// Examples
/// --------
/// >>> import numpy as np, vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1, restitution=0.9)
/// >>> orbit = model.breathers("double-sided").orbits[0]
/// >>> orbit.displacement(np.linspace(0, orbit.period, 200)).shape
/// (200, 21)
/// >>> [impact.barrier for impact in orbit.impacts]
/// ['upper', 'lower']
#[pyclass(frozen, eq, name = "Orbit", module = "vibrochain")]
#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "Orbit", into = "Orbit")]
pub(crate) struct PyOrbit(pub(crate) Arc<Orbit>);

impl From<Orbit> for PyOrbit {
    fn from(orbit: Orbit) -> Self {
        Self::new(orbit)
    }
}

impl From<PyOrbit> for Orbit {
    fn from(PyOrbit(orbit): PyOrbit) -> Self {
        Arc::unwrap_or_clone(orbit)
    }
}

impl PyOrbit {
    pub(crate) fn new(orbit: Orbit) -> Self {
        Self(Arc::new(orbit))
    }
}

/// Which of the two a trajectory is of.
#[derive(Clone, Copy)]
enum Part {
    Displacement,
    Velocity,
}

#[pymethods]
impl PyOrbit {
    /// The orbit near impacts that are known roughly, by Newton's method.
    ///
    /// Parameters
    /// ----------
    /// model : Model
    ///     The parameters.
    /// impacts : sequence of tuples
    ///     (mass, barrier, time, impulse) of each impact, rising in time; barrier is "lower" or "upper".
    /// psi : float
    ///     Phase of the force at time 0, as a time.
    /// force_periods : int
    ///     Periods of the force in one of the orbit.
    ///
    /// Returns
    /// -------
    /// Orbit
    ///
    /// Raises
    /// ------
    /// NotConvergedError
    ///     If the impacts are not near enough to those of an orbit.
    ///
    /// Examples
    /// --------
    /// >>> import vibrochain as vc
    /// >>> model = vc.Model(vc.Chain(21, 0.2, 0.05), omega=1.5, asymmetry=0.2)
    /// >>> half = model.period / 2
    /// >>> hits = [(0, "upper", 0, -1.9), (1, "upper", 0, -1.9), (0, "lower", half, 1.9), (1, "lower", half, 1.9)]
    /// >>> vc.Orbit.near(model, hits).word
    /// '0+1+,0-1-'
    #[staticmethod]
    #[pyo3(signature = (model, impacts, *, psi = 0.0, force_periods = None))]
    fn near(
        py: Python<'_>,
        model: PyRef<'_, PyModel>,
        impacts: &Bound<'_, PyAny>,
        psi: f64,
        force_periods: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let periods = force_periods.map_or(Ok(1), |value| whole("force_periods", value, 1, i64::from(u16::MAX)))?;
        let barriers = [Barrier::Lower, Barrier::Upper].map(|barrier| (barrier.name(), barrier));
        let hit = |impact: &Bound<'_, PyAny>| {
            let (site, barrier, time, impulse): (usize, String, f64, f64) = impact.extract()?;
            Ok(Hit::new(site, named("barrier", &barrier, barriers)?, time, impulse))
        };
        let hits = items("impacts", impacts, MOST_HITS)?.iter().map(hit).collect::<PyResult<Vec<_>>>()?;
        let model = model.0;
        call(py, &model.clone(), move || {
            let rough = Orbit::from_impulses(&model, periods as u32, psi, &hits)?;
            Finder::new(model.chain().sites()).polish(&rough).map(Self::new)
        })
    }

    /// Model : the parameters.
    #[getter]
    fn model(&self) -> PyResult<PyModel> {
        Ok(PyModel(*self.0.lattice().map_err(Failure::from)?.model()))
    }

    /// str : "double-sided", "single-sided", "period-doubled" or "word".
    #[getter]
    fn family(&self) -> &'static str {
        self.0.family().name()
    }

    /// str : which mass meets which barrier, in which order.
    #[getter]
    fn word(&self) -> String {
        Word::of(&self.0).to_string()
    }

    /// float : period of the orbit.
    #[getter]
    fn period(&self) -> f64 {
        self.0.period()
    }

    /// int : periods of the force in one of the orbit.
    #[getter]
    fn force_periods(&self) -> u32 {
        self.0.force_periods()
    }

    /// float or None : time of the second impact, of families with two.
    #[getter]
    fn phi(&self) -> Option<f64> {
        self.0.phi()
    }

    /// float or None : phase of the force at time 0, as a time; None without force.
    #[getter]
    fn psi(&self) -> Option<f64> {
        self.0.psi()
    }

    /// list of Impact : the impacts in order of time.
    #[getter]
    fn impacts(&self) -> Vec<PyImpact> {
        let layout = self.layout();
        self.0.impacts().iter().map(|impact| PyImpact::new(impact, &layout)).collect()
    }

    /// float : largest violation of the defining equations, relative; rounding level for a sound orbit.
    #[getter]
    fn residual(&self) -> f64 {
        self.0.residual()
    }

    /// Displacements of masses at given times.
    ///
    /// Parameters
    /// ----------
    /// t : array_like of float
    ///     Times, of any shape; the motion repeats with the period.
    /// sites : int or sequence of int, optional
    ///     Masses, counted through all layers; all of them if not given.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray of float64
    ///     Of the shape of `t`, followed by the number of masses (nothing follows for a single int).
    ///
    /// Examples
    /// --------
    /// >>> import vibrochain as vc
    /// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4)
    /// >>> orbit = model.breathers("double-sided").orbits[0]
    /// >>> round(float(orbit.displacement(0.0, 0)), 12)
    /// 1.4
    /// >>> orbit.displacement([0.0, 1.0, 2.0], sites=[0, 1]).shape
    /// (3, 2)
    #[pyo3(signature = (t, sites = None))]
    fn displacement<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        sites: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.trajectory(py, t, sites, Part::Displacement)
    }

    /// Velocities of masses at given times; at an impact those just after it.
    ///
    /// Parameters
    /// ----------
    /// t : array_like of float
    ///     Times, of any shape.
    /// sites : int or sequence of int, optional
    ///     Masses, counted through all layers; all of them if not given.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray of float64
    ///     Of the shape of `t`, followed by the number of masses (nothing follows for a single int).
    ///
    /// Examples
    /// --------
    /// >>> import vibrochain as vc
    /// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4)
    /// >>> orbit = model.breathers("double-sided").orbits[0]
    /// >>> error = orbit.velocity(0.0, 0) - orbit.impacts[0].velocity_after
    /// >>> bool(abs(error) < 1e-12)
    /// True
    #[pyo3(signature = (t, sites = None))]
    fn velocity<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        sites: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.trajectory(py, t, sites, Part::Velocity)
    }

    /// Whether the orbit is physical: every impact from inside, every mass inside its gap otherwise.
    ///
    /// Returns
    /// -------
    /// Admissibility
    ///
    /// Examples
    /// --------
    /// >>> import vibrochain as vc
    /// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4)
    /// >>> answer = model.breathers("double-sided").orbits[0].admissibility()
    /// >>> answer.physical, 0 < answer.margin < 1
    /// (True, True)
    fn admissibility(&self, py: Python<'_>) -> PyResult<PyAdmissibility> {
        let (orbit, layout) = (self.0.clone(), self.layout());
        Ok(PyAdmissibility::new(&call(py, self.0.model(), move || admissibility(&orbit))?, layout))
    }

    /// How far the orbit can be trusted: distances to resonance, grazing and folds, and the errors that follow.
    ///
    /// Returns
    /// -------
    /// Condition
    ///
    /// Examples
    /// --------
    /// >>> import vibrochain as vc
    /// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4)
    /// >>> model.breathers("double-sided").orbits[0].condition().impulse_error < 1e-13
    /// True
    fn condition(&self, py: Python<'_>) -> PyResult<PyCondition> {
        let orbit = self.0.clone();
        call(py, self.0.model(), move || condition(&orbit).map(|condition| PyCondition::new(&condition)))
    }

    /// Floquet multipliers, and whether the orbit is stable.
    ///
    /// Parameters
    /// ----------
    /// threshold : float, optional
    ///     Excess per period below which an orbit counts as stable; strict if not given.
    ///
    /// Returns
    /// -------
    /// Stability
    ///
    /// Raises
    /// ------
    /// IllConditionedError
    ///     Where an impact grazes.
    /// TooLargeError
    ///     Where a dense matrix would be needed that is too large.
    ///
    /// Examples
    /// --------
    /// >>> import vibrochain as vc
    /// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=0.8, asymmetry=0.4)
    /// >>> answer = model.breathers("single-sided").orbits[0].stability()
    /// >>> answer.stable, answer.mechanism, answer.multipliers.shape
    /// (False, 'plus-one', (42,))
    /// >>> round(answer.spectral_radius, 12)
    /// 2.797574412183
    #[pyo3(signature = (threshold = None))]
    fn stability<'py>(&self, py: Python<'py>, threshold: Option<f64>) -> PyResult<Bound<'py, PyStability>> {
        let tolerance = match threshold {
            None => Tolerance::Rounding,
            Some(threshold) => tolerance_from(threshold).map_err(Failure::from)?,
        };
        let orbit = self.0.clone();
        let answer = call(py, self.0.model(), move || stability(&orbit, tolerance))?;
        let multipliers = answer.multipliers.into_pyarray(py).unbind();
        let verdict = PyVerdict::from(&answer.verdict);
        Bound::new(py, PyClassInitializer::from(verdict).add_subclass(PyStability { multipliers }))
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    fn __repr__(&self) -> String {
        let word = if self.0.family() == Family::Word { format!(" {}", self.word()) } else { String::new() };
        format!("<Orbit {}{word}: {}>", self.0.family(), self.0)
    }
}

impl PyOrbit {
    fn layout(&self) -> Layout {
        self.0.model().map_or(Layout::ONE_ROW, |model| model.chain().layout())
    }

    fn trajectory<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        sites: Option<&Bound<'py, PyAny>>,
        part: Part,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let t = numbers("t", t)?.try_readonly()?;
        let mut shape = t.shape().to_vec();
        let mut times = room(Some(t.len()))?;
        times.extend(t.as_array().iter().copied());
        if let Some(time) = times.iter().find(|time: &&f64| !time.is_finite()) {
            return Err(Failure::request(format!("t = {time} is out of range: give finite times")).into());
        }
        let masses = self.0.lattice().map_err(Failure::from)?.model().chain().sites();
        let sites = sites.map(|sites| self::sites(sites, masses, &mut shape)).transpose()?;
        if sites.is_none() {
            shape.push(masses);
        }
        let mut values = room(shape.iter().try_fold(1, |count: usize, &length| count.checked_mul(length)))?;
        let orbit = self.0.clone();
        let work = move |stop: &Stop| {
            let mut motion = Motion::of(&orbit)?;
            for time in times {
                if stop.is_raised() {
                    break;
                }
                match (&sites, part) {
                    (None, Part::Displacement) => values.extend(motion.state(time).0),
                    (None, Part::Velocity) => values.extend(motion.state(time).1),
                    (Some(sites), _) => {
                        motion.at(0, time);
                        values.extend(sites.iter().map(|&site| {
                            let now = motion.site(site);
                            if matches!(part, Part::Displacement) { now.displacement } else { now.velocity }
                        }));
                    }
                }
            }
            Ok::<_, Failure>(values)
        };
        let values = match shape.iter().product::<usize>() {
            0..=10_000 => call(py, self.0.model(), move || work(&Stop::default()))?,
            _ => long(py, |_| Ok(()), work)?,
        };
        values.into_pyarray(py).reshape(IxDyn(&shape))
    }
}

/// Masses that are asked for; what they add to the shape of an array.
fn sites(sites: &Bound<'_, PyAny>, masses: usize, shape: &mut Vec<usize>) -> PyResult<Vec<usize>> {
    let most = masses.min(MAX_SITES) as i64 - 1;
    let one = |site: &Bound<'_, PyAny>| whole("site", site, 0, most).map(|site| site as usize);
    // An array of NumPy is no sequence by name.
    let is_list = sites.cast::<PySequence>().is_ok() || sites.hasattr("ndim")? && sites.getattr("ndim")?.is_truthy()?;
    if !is_list {
        return Ok(vec![one(sites)?]);
    }
    let list = items("sites", sites, MAX_SITES)?.iter().map(one).collect::<PyResult<Vec<_>>>()?;
    shape.push(list.len());
    Ok(list)
}
