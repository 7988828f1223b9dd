//! The list of breathers at a point, and what is known of how complete it is; the words that a model can be asked for.

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyIterator;
use serde::{Deserialize, Serialize};
use vibrochain_breather::{Completeness, Family, Finder, OrbitList, Proof, Word};

use crate::call::call;
use crate::failure::{Failure, named};
use crate::lengths::Items;
use crate::orbits::PyOrbit;
use crate::params::PyModel;

/// All breathers of a family or word at a point: a sequence of orbits.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4, restitution=0.9)
/// >>> found = model.breathers("single-sided")
/// >>> found.orbits, found.completeness.established
/// ([], True)
/// >>> found.reason
/// 'impacts lose energy (restitution < 1), or dashpots do, and no force restores it: give an amplitude, or restitution 1 and no dashpots'
#[pyclass(frozen, sequence, name = "Breathers", module = "vibrochain")]
#[derive(Serialize, Deserialize)]
pub(crate) struct PyBreathers {
    name: String,
    orbits: Vec<PyOrbit>,
    completeness: Completeness,
    ended: Vec<String>,
}

impl PyBreathers {
    pub(crate) fn new(name: String, found: OrbitList) -> Self {
        let ended = found.ended.iter().map(ToString::to_string).collect();
        let orbits = found.orbits.into_iter().map(PyOrbit::new).collect();
        Self { name, orbits, completeness: found.completeness, ended }
    }
}

#[pymethods]
impl PyBreathers {
    /// str : the family, or the word in the form that is the same for all words that mean the same.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// list of Orbit : the orbits, physical or not, in order of phi.
    #[getter]
    fn orbits(&self) -> Vec<PyOrbit> {
        self.orbits.clone()
    }

    /// Completeness : whether these are all, and how that is known.
    #[getter]
    fn completeness(&self) -> PyCompleteness {
        PyCompleteness(self.completeness)
    }

    /// str or None : why there are none, where there are none.
    #[getter]
    fn reason(&self) -> Option<String> {
        self.completeness.reason().map(|reason| reason.to_string())
    }

    /// list of str : where branches of a word ended that were followed from masses without coupling.
    #[getter]
    fn ended(&self) -> Vec<String> {
        self.ended.clone()
    }

    /// The first orbit that is physical.
    ///
    /// Returns
    /// -------
    /// Orbit
    ///
    /// Raises
    /// ------
    /// NoBreatherError
    ///     If none is; the message says why.
    ///
    /// Examples
    /// --------
    /// >>> import vibrochain as vc
    /// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4)
    /// >>> model.breathers("double-sided").physical().admissibility().physical
    /// True
    /// >>> model.breathers("period-doubled").physical()
    /// Traceback (most recent call last):
    ///     ...
    /// vibrochain._errors.NoBreatherError: this family exists under a force only: give amplitude and restitution
    fn physical(&self, py: Python<'_>) -> PyResult<PyOrbit> {
        if let Some(reason) = self.reason() {
            return Err(Failure::NoBreather(reason).into());
        }
        let (orbits, name) = (self.orbits.clone(), self.name.clone());
        let Some(first) = orbits.first().cloned() else {
            return Err(
                Failure::NoBreather(format!("no {name} orbit was found; the list is {}", self.completeness)).into()
            );
        };
        call(py, first.0.model(), move || {
            let count = orbits.len();
            for orbit in orbits {
                let mut finder = Finder::default();
                if finder.quick_admissibility(&orbit.0)?.is_physical() {
                    return Ok(orbit);
                }
            }
            let message = format!(
                "none of the {count} {name} orbits is physical; admissibility() of each tells what is in its way"
            );
            Err(Failure::NoBreather(message))
        })
    }

    fn __len__(&self) -> usize {
        self.orbits.len()
    }

    fn __getitem__(&self, index: usize) -> PyResult<PyOrbit> {
        self.orbits.get(index).cloned().ok_or_else(|| {
            let message = format!("orbit {index} of {}", self.orbits.len());
            PyIndexError::new_err(message)
        })
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        self.orbits().into_pyobject(py)?.try_iter()
    }

    fn __repr__(&self) -> String {
        format!("<{} {} breathers, {}>", self.orbits.len(), self.name, self.completeness)
    }
}

/// What is known of a list of breathers: that it is complete, and how, or what it may lack.
///
/// Examples
/// --------
/// >>> import vibrochain as vc
/// >>> model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4)
/// >>> known = model.breathers("single-sided").completeness
/// >>> known.established, known.by
/// (True, 'closed-form')
#[pyclass(frozen, eq, name = "Completeness", module = "vibrochain")]
#[derive(PartialEq, Serialize, Deserialize)]
pub(crate) struct PyCompleteness(pub(crate) Completeness);

#[pymethods]
impl PyCompleteness {
    /// bool : the list is known to hold all orbits.
    #[getter]
    fn established(&self) -> bool {
        self.0.is_established()
    }

    /// str or None : "closed-form", "enclosures", "branch-and-prune"; "followed", "scan" or "half-period", which need not have all.
    #[getter]
    fn by(&self) -> Option<&'static str> {
        self.0.means()
    }

    /// int or None : intervals or boxes enclosed, starts or branches followed, places looked at.
    #[getter]
    fn effort(&self) -> Option<usize> {
        match (self.0, self.0.proof()) {
            (Completeness::Followed { starts: count, .. } | Completeness::Scanned { places: count }, _) => Some(count),
            (_, Some(Proof::Enclosures { intervals: count } | Proof::BranchAndPrune { boxes: count })) => Some(count),
            _ => None,
        }
    }

    /// int : places where two orbits may have merged closer than rounding can tell.
    #[getter]
    fn unresolved(&self) -> usize {
        self.0.open().0
    }

    /// int : places that were not searched because there are too many.
    #[getter]
    fn exhausted(&self) -> usize {
        self.0.open().1
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    fn __repr__(&self) -> String {
        format!("<Completeness: {}>", self.0)
    }
}

/// The most words that are looked at before symmetry makes them fewer.
const MOST: f64 = 1e6;

/// Words on so many sites, each of which hits as one of the families does.
#[pyfunction]
pub(crate) fn _words(
    model: PyRef<'_, PyModel>,
    sites_used: u32,
    reach: u32,
    families: Items<String>,
) -> PyResult<Vec<String>> {
    let (model, sites, reach) = (&model.0, sites_used as usize, reach as usize);
    let known = [Family::DoubleSided, Family::SingleSided];
    let families = families.0.iter().map(|name| named("families", name, known.map(|family| (family.name(), family))));
    let families = families.collect::<Result<Vec<_>, Failure>>()?;
    let layout = model.chain().layout();
    let most = (reach.min(layout.length.saturating_sub(1)) + 1) * layout.layers;
    if sites == 0 || sites > most {
        let message = format!("sites_used = {sites} is out of range: a reach of {reach} has room for 1 to {most}");
        return Err(Failure::request(message).into());
    }
    if Word::combinations(&layout, sites, reach, &families) > MOST {
        let message = "these are more than a million words: give fewer sites, a smaller reach or one family";
        return Err(Failure::TooLarge(message.to_owned()).into());
    }
    let words = Word::enumerate(model, sites, reach, &families).map_err(Failure::from)?;
    Ok(words.iter().map(Word::to_string).collect())
}
