//! What can be asked of a model: its parameters, and its breathers. (Orbits know their model and models their orbits; the type is in
//! `params`, below both.)

use std::fmt::Write as _;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use vibrochain_breather::{BreatherError, Family, Finder, MAX_IMPACTS, OrbitList, Scope, Word, breathers};
use vibrochain_lattice::{Model, Parameter, Short};

use crate::breathers::PyBreathers;
use crate::call::{call, long};
use crate::failure::{Failure, named_error, whole};
use crate::params::{PyChain, PyForce, PyModel, parameter};

#[pymethods]
impl PyModel {
    #[new]
    #[pyo3(signature = (chain, omega, asymmetry, *, amplitude = None, force = None, restitution = None, damping = 0.0, coupling_damping = 0.0))]
    #[expect(clippy::too_many_arguments, reason = "those of a call in Python, by their names")]
    fn new(
        chain: PyRef<'_, PyChain>,
        omega: f64,
        asymmetry: f64,
        amplitude: Option<f64>,
        force: Option<PyRef<'_, PyForce>>,
        restitution: Option<f64>,
        damping: f64,
        coupling_damping: f64,
    ) -> PyResult<Self> {
        let restitution = match restitution {
            Some(restitution) => restitution,
            None if amplitude.is_none() && force.is_none() => 1.0,
            None => return Err(without_restitution().into()),
        };
        let point = chain.0.point().omega(omega).asymmetry(asymmetry).restitution(restitution);
        let point = point.damping(damping).coupling_damping(coupling_damping);
        let point = match (amplitude, force) {
            (Some(amplitude), Some(_)) => {
                let message = format!(
                    "amplitude = {} and force are both given, but a force has amplitudes of its own: remove one of the two",
                    Short(amplitude)
                );
                return Err(Failure::request(message).into());
            }
            (None, Some(force)) => point.under(&force.0),
            (amplitude, None) => point.amplitude(amplitude.unwrap_or(0.0)),
        };
        Ok(Self(point.model().map_err(Failure::from)?))
    }

    /// Chain : the lattice.
    #[getter]
    fn chain(&self) -> PyChain {
        PyChain(*self.0.chain())
    }

    /// float : period of the force, 2 pi / omega.
    #[getter]
    fn period(&self) -> f64 {
        self.0.period()
    }

    /// Force : the force.
    #[getter]
    fn force(&self) -> PyForce {
        PyForce(*self.0.force())
    }

    /// bool : no force, elastic impacts and no dashpots.
    #[getter]
    fn conservative(&self) -> bool {
        self.0.is_conservative()
    }

    /// The same model with some parameters changed.
    ///
    /// Parameters
    /// ----------
    /// **values : float
    ///     Any of gamma1, gamma2, gamma3, omega, asymmetry, amplitude, restitution, damping, coupling_damping. The amplitude of a force of several harmonics
    ///     is the sum of their moduli: all are scaled alike. What had no force and gets one needs restitution, too.
    ///
    /// Returns
    /// -------
    /// Model
    ///
    /// Examples
    /// --------
    /// >>> import vibrochain as vc
    /// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4)
    /// >>> model.replace(gamma2=0.05, asymmetry=0)
    /// Model(Chain(21, 0.2, 0.05), omega=1.5, asymmetry=0)
    #[pyo3(signature = (**values))]
    fn replace(&self, values: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut model = self.0;
        // Of a force that is there already it was told.
        let mut is_told = model.amplitude() > 0.0 || !model.is_conservative();
        for (name, value) in values.into_iter().flatten() {
            let parameter = parameter("parameter", &name.extract::<String>()?)?;
            is_told |= parameter == Parameter::Restitution;
            let value = value.extract().map_err(|error: PyErr| named_error(parameter.name(), error, value.py()))?;
            model = model.with(parameter, value).map_err(Failure::from)?;
        }
        match model.amplitude() > 0.0 && !is_told {
            true => Err(without_restitution().into()),
            false => Ok(Self(model)),
        }
    }

    /// All breathers of a family, or of an impact word.
    ///
    /// Parameters
    /// ----------
    /// which : str
    ///     "double-sided" (one impact on each barrier a period), "single-sided" (one on the nearer barrier), "period-doubled", or
    ///     a word of impacts: instants separated by commas or spaces, in each the sites that hit the upper (+) or lower (-)
    ///     barrier, as in "0+3+,0-3-"; SITE:LAYER where there are layers.
    /// force_periods : int
    ///     Periods of the force in one period of a word; 1 unless it is given, of "0-,0-" under a force 2. No meaning for families.
    ///
    /// Returns
    /// -------
    /// Breathers
    ///     The orbits, physical or not, and what is known of how complete the list is. That there are none is an answer.
    ///
    /// Raises
    /// ------
    /// RequestError
    ///     For a name that is none, or a word with a site that the chain does not have.
    /// ResonanceError
    ///     Where a harmonic of omega meets a mode: no periodic motion is defined there.
    ///
    /// Examples
    /// --------
    /// >>> import vibrochain as vc
    /// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4)
    /// >>> found = model.breathers("double-sided")
    /// >>> len(found.orbits), str(found.completeness)
    /// (1, 'complete, by closed form')
    /// >>> pair = model.replace(asymmetry=0.2, gamma2=0.05).breathers("0+3-,0-3+")
    /// >>> pair.name
    /// '0+3-,0-3+'
    #[pyo3(signature = (which, *, force_periods = None))]
    fn breathers(
        &self,
        py: Python<'_>,
        which: &str,
        force_periods: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyBreathers> {
        let model = self.0;
        let most = i64::try_from(MAX_IMPACTS).unwrap_or(i64::MAX);
        let periods = force_periods.map(|value| whole("force_periods", value, 1, most)).transpose()?;
        let families = [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled];
        let (name, found) = match families.into_iter().find(|family| family.name() == which) {
            Some(family) => (which.to_owned(), call(py, &model, move || breathers(&model, family))?),
            None => {
                let word = word(which, &model)?;
                let name = word.to_string();
                if model.is_conservative() && periods.is_some_and(|periods| periods > 1) {
                    let message = "force_periods counts periods of a force: without one the word's period is 2π/omega, give omega/N";
                    return Err(Failure::request(message).into());
                }
                let search = move |_: &_| {
                    let (mut finder, mut found) = (Finder::new(model.chain().sites()), OrbitList::default());
                    match periods {
                        Some(periods) => finder.find_word_over(&model, &word, periods as u32, &mut found)?,
                        None => finder.find_word(&model, &word, Scope::All, &mut found)?,
                    }
                    Ok::<_, BreatherError>(found)
                };
                (name, long(py, |_| Ok(()), search)?)
            }
        };
        Ok(PyBreathers::new(name, found))
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    fn __repr__(&self) -> String {
        let (model, point) = (&self.0, self.0.point());
        let mut text = format!("Model({}", self.chain().__repr__());
        for parameter in Parameter::told().filter(|parameter| !parameter.is_of_lattice()) {
            let value = point.get(parameter);
            // Writing to a String cannot fail.
            let _ = match (parameter, &point.force) {
                (Parameter::Amplitude, Some(_)) => write!(text, ", force={}", self.force().__repr__()),
                (Parameter::Amplitude | Parameter::Restitution, _) if model.is_conservative() => Ok(()),
                (Parameter::Amplitude, None) if value == 0.0 => Ok(()),
                _ if point.tells(parameter) => write!(text, ", {parameter}={}", Short(value)),
                _ => Ok(()),
            };
        }
        text + ")"
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        (self.chain(), self.force(), PyTuple::new(py, self.0.point().values)?).into_pyobject(py)?.hash()
    }
}

fn without_restitution() -> Failure {
    Failure::request("restitution is missing: a force needs restitution")
}

/// The word of that text, the smallest that says the same of the model.
fn word(text: &str, model: &Model) -> Result<Word, Failure> {
    let word: Word = text.parse().map_err(|error| {
        Failure::request(format!(
            "{text:?} is no family and no impact word ({error}): give \"double-sided\", \"single-sided\", \"period-doubled\" or a word"
        ))
    })?;
    word.check(&model.chain().layout())?;
    Ok(word.canonical(model))
}
