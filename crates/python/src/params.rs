//! Chains, forces, and what a model is; what can be asked of one is in `model`.

use std::fmt::Write as _;

use pyo3::prelude::*;
use pyo3::types::{PyCFunction, PyDict, PyTuple};
use serde::{Deserialize, Serialize};
use vibrochain_lattice::{
    Chain, Ends, Force, Harmonic, Layout, MAX_HARMONIC, MAX_HARMONICS, MAX_SITES, Model, Parameter, Short,
};

use crate::failure::{Failure, named, whole};
use crate::lengths::items;

fn ends(what: &str, name: &str) -> Result<Ends, Failure> {
    named(what, name, Ends::ALL.map(|ends| (ends.name(), ends)))
}

/// The parameter of that name.
pub(crate) fn parameter(what: &str, name: &str) -> Result<Parameter, Failure> {
    named(what, name, Parameter::ALL.map(|parameter| (parameter.name(), parameter)))
}

/// Gives chains and models their parameters as properties.
pub(crate) fn register(py: Python<'_>) -> PyResult<()> {
    let property = py.import("builtins")?.getattr("property")?;
    for parameter in Parameter::ALL {
        let get = move |arguments: &Bound<'_, PyTuple>, _: Option<&Bound<'_, PyDict>>| -> PyResult<f64> {
            let whose = arguments.get_item(0)?;
            match whose.cast::<PyModel>() {
                Ok(model) => Ok(model.get().0.get(parameter)),
                Err(_) => Ok(whose.cast::<PyChain>()?.get().0.point().get(parameter)),
            }
        };
        let class = if parameter.is_of_lattice() { py.get_type::<PyChain>() } else { py.get_type::<PyModel>() };
        let doc = format!("float : {}.", parameter.meaning());
        let get = PyCFunction::new_closure(py, None, None, get)?;
        class.setattr(parameter.name(), property.call1((get, py.None(), py.None(), doc))?)?;
    }
    Ok(())
}

/// The lattice: unit masses in a ring, in a row with ends, or in several equal rows.
///
/// Parameters
/// ----------
/// sites : int
///     Masses of one row (the paper's N + 1), 1 to 10 000 000.
/// gamma1, gamma2 : float
///     On-site stiffness, and stiffness of the springs between neighbours; 0 to 1e100, not both 0.
/// ends : {"closed", "free", "fixed"}
///     What stands at the ends of a row: each other (a ring), nothing, or walls with a spring.
/// layers : int
///     Number of rows.
/// gamma3 : float
///     Stiffness of the springs between neighbouring rows.
/// layer_ends : {"free", "closed", "fixed"}
///     Whether the last row is the first one's neighbour, too, or both stand beside walls.
///
/// Raises
/// ------
/// RequestError
///     For a value out of range.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> vc.Chain(21, 0.2, 0.1)
/// Chain(21, 0.2, 0.1)
/// >>> vc.Chain(11, 0.2, 0.1, ends="free", layers=2, gamma3=0.05).masses
/// 22
#[pyclass(frozen, eq, name = "Chain", module = "vibrochain")]
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PyChain(pub(crate) Chain);

#[pymethods]
impl PyChain {
    #[new]
    #[pyo3(signature = (sites, gamma1, gamma2, *, ends = "closed", layers = None, gamma3 = 0.0, layer_ends = "free"))]
    fn new(
        sites: &Bound<'_, PyAny>,
        gamma1: f64,
        gamma2: f64,
        ends: &str,
        layers: Option<&Bound<'_, PyAny>>,
        gamma3: f64,
        layer_ends: &str,
    ) -> PyResult<Self> {
        let length = whole("sites", sites, 1, MAX_SITES as i64)? as usize;
        let most = (MAX_SITES / length) as i64;
        let layers = layers.map_or(Ok(1), |layers| whole("layers", layers, 1, most))? as usize;
        let layout = Layout {
            length,
            ends: self::ends("ends", ends)?,
            layers,
            layer_ends: self::ends("layer_ends", layer_ends)?,
        };
        Ok(Self(Chain::on(layout, gamma1, gamma2, gamma3).map_err(Failure::from)?))
    }

    /// int : masses of one row, as in scenes.
    #[getter]
    fn sites(&self) -> usize {
        self.0.length()
    }

    /// int : masses of all rows together; arrays over masses are so long.
    #[getter]
    fn masses(&self) -> usize {
        self.0.sites()
    }

    /// str : "closed", "free" or "fixed".
    #[getter]
    fn ends(&self) -> &'static str {
        self.0.ends().name()
    }

    /// int : number of rows.
    #[getter]
    fn layers(&self) -> usize {
        self.0.layers()
    }

    /// str : "closed", "free" or "fixed".
    #[getter]
    fn layer_ends(&self) -> &'static str {
        // Of one row nothing is said.
        if self.0.layers() == 1 { Ends::Free.name() } else { self.0.layer_ends().name() }
    }

    fn __len__(&self) -> usize {
        self.0.sites()
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    pub(crate) fn __repr__(&self) -> String {
        let (chain, point) = (&self.0, self.0.point());
        let mut text = format!("Chain({}, {}, {}", chain.length(), Short(chain.gamma1()), Short(chain.gamma2()));
        // Writing to a String cannot fail.
        if chain.ends() != Ends::Closed {
            let _ = write!(text, ", ends=\"{}\"", chain.ends());
        }
        if chain.layers() > 1 {
            let _ = write!(text, ", layers={}", chain.layers());
        }
        let named = |one: &Parameter| one.is_of_lattice() && one.row().default.is_some() && point.tells(*one);
        for parameter in Parameter::ALL.into_iter().filter(named) {
            let _ = write!(text, ", {parameter}={}", Short(point.get(parameter)));
        }
        if chain.layers() > 1 && chain.layer_ends() != Ends::Free {
            let _ = write!(text, ", layer_ends=\"{}\"", chain.layer_ends());
        }
        text + ")"
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        let chain = &self.0;
        let rows = (chain.length(), chain.ends().name(), chain.layers(), self.layer_ends());
        (rows, PyTuple::new(py, chain.point().values)?).into_pyobject(py)?.hash()
    }
}

/// A periodic force of several odd harmonics, the sum of A_j cos(j omega (t + psi) + theta_j).
///
/// Parameters
/// ----------
/// harmonics : sequence of tuples
///     (j, A_j) or (j, A_j, theta_j) for each of up to eight harmonics; j odd, theta_j in radians.
///
/// Raises
/// ------
/// RequestError
///     For a harmonic that is even or given twice, or a value out of range.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> force = vc.Force([(1, 0.1), (3, -0.03, 0.5)])
/// >>> force.harmonics
/// [(1, 0.1, 0.0), (3, -0.03, 0.5)]
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4, force=force, restitution=0.9)
/// >>> model.force == force
/// True
#[pyclass(frozen, eq, name = "Force", module = "vibrochain")]
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PyForce(pub(crate) Force);

#[pymethods]
impl PyForce {
    #[new]
    fn new(harmonics: &Bound<'_, PyAny>) -> PyResult<Self> {
        let harmonic = |part: &Bound<'_, PyAny>| {
            let part = part.cast::<PyTuple>()?;
            let number = whole("harmonic", &part.get_item(0)?, 1, i64::from(MAX_HARMONIC))? as u32;
            let (amplitude, phase) = match part.len() {
                2 => (part.get_item(1)?.extract()?, 0.0),
                3 => (part.get_item(1)?.extract()?, part.get_item(2)?.extract()?),
                length => {
                    let message = format!(
                        "a harmonic has {length} parts: give its number and amplitude, and perhaps its phase, as in (3, -0.03, 0.5)"
                    );
                    return Err(Failure::request(message).into());
                }
            };
            Ok::<_, PyErr>(Harmonic { number, amplitude, phase })
        };
        let harmonics = items("harmonics", harmonics, MAX_HARMONICS)?;
        let harmonics = harmonics.iter().map(harmonic).collect::<PyResult<Vec<_>>>()?;
        Ok(Self(Force::new(&harmonics).map_err(Failure::from)?))
    }

    /// list of (int, float, float) : number, amplitude and phase of each harmonic, rising in number.
    #[getter]
    fn harmonics(&self) -> Vec<(u32, f64, f64)> {
        self.0.harmonics().iter().map(|harmonic| (harmonic.number, harmonic.amplitude, harmonic.phase)).collect()
    }

    /// float : the sum of the moduli of all amplitudes.
    #[getter]
    fn amplitude(&self) -> f64 {
        self.0.amplitude()
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    pub(crate) fn __repr__(&self) -> String {
        let term = |&(number, amplitude, phase): &(u32, f64, f64)| {
            if phase == 0.0 {
                format!("({number}, {})", Short(amplitude))
            } else {
                format!("({number}, {}, {})", Short(amplitude), Short(phase))
            }
        };
        let terms: Vec<String> = self.harmonics().iter().map(term).collect();
        format!("Force([{}])", terms.join(", "))
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        PyTuple::new(py, self.harmonics())?.hash()
    }
}

/// A chain with its barriers, its force and its law of impact.
///
/// Each mass n moves by u'' = -gamma1 u - gamma2 (2u - left - right) + F(t + psi), with dashpots less c u' + c2 (2u' - left' - right'),
/// between barriers at a - 1 and a + 1, where its velocity v becomes -e v. All is dimensionless.
///
/// Parameters
/// ----------
/// chain : Chain
///     The lattice.
/// omega : float
///     Frequency of the force, or, without one, of the breathers that are asked for.
/// asymmetry : float
///     Centre a of the gap, 0 up to but not including 1.
/// amplitude : float
///     Amplitude A of the force A cos(omega (t + psi)); 0 is none.
/// force : Force, optional
///     Instead of `amplitude`: a force of several harmonics.
/// restitution : float
///     Coefficient e of restitution, above 0 and up to 1. A force needs one; without a force it is 1 unless it is given.
/// damping, coupling_damping : float
///     Dashpots c between each mass and the ground, and c2 in each spring along the rows.
///
/// Raises
/// ------
/// RequestError
///     For a value out of range; the message says which, and what to give.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1, restitution=0.9)
/// >>> model
/// Model(Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1, restitution=0.9)
/// >>> model.replace(omega=1.6).omega
/// 1.6
/// >>> vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=1.4)
/// Traceback (most recent call last):
///     ...
/// vibrochain._errors.RequestError: asymmetry = 1.4 is out of range: give a number from 0 up to but not including 1
/// >>> vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1)
/// Traceback (most recent call last):
///     ...
/// vibrochain._errors.RequestError: restitution is missing: a force needs restitution
#[pyclass(frozen, eq, name = "Model", module = "vibrochain")]
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PyModel(pub(crate) Model);
