//! What a file says of a model: all of it, or all but what a sweep varies.

use std::path::{Path, PathBuf};

use toml::Spanned;
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Force, Layout, MAX_SITES, Parameter};

use crate::error::MapError;
use crate::scene::axis::Axis;
use crate::scene::compute::tolerance_from;
use crate::scene::file::{File, MAX_BYTES, ModelTable, ReadFile, Values};
use crate::scene::source::Source;
use crate::text::read_text;

/// The model of a file, as far as it goes: of a scene, a manifest, an answer of `mapgen orbit --json` and its like, of a figure of the
/// paper, or of a file that holds nothing but `[model]`. Nothing is checked yet that depends on what is left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Given {
    /// The file, for messages.
    pub path: PathBuf,
    /// Where the masses stand.
    pub layout: Layout,
    /// A force that the file gives by its harmonics.
    pub force: Option<Force>,
    /// What is swept, the fastest first.
    pub axes: Vec<Axis>,
    /// Names of families, and impact words, as written; of a figure its family.
    pub families: Vec<String>,
    /// The excess from which on an orbit counts as unstable, if the file says it.
    pub tolerance: Option<Tolerance>,
    /// Whether it is an answer that holds orbits.
    pub has_orbits: bool,
    values: Values<f64>,
}

impl Given {
    /// Reads such a file.
    ///
    /// # Errors
    /// [`MapError::Request`], pointing at the line: a file that cannot be read or is too long, unknown keys, a parameter given twice.
    pub fn read(path: &Path) -> Result<Self, MapError> {
        Self::parse(path, &read_text("scene", path, MAX_BYTES)?)
    }

    /// The same of its text; `path` is for messages.
    ///
    /// # Errors
    /// As [`Given::read`].
    ///
    /// ```
    /// use std::path::Path;
    /// use vibrochain_lattice::Parameter;
    /// use vibrochain_maps::scene::Given;
    /// let given = Given::parse(Path::new("model.toml"), "model = { sites = 21, gamma1 = 0.2 }").unwrap();
    /// assert_eq!((given.layout.length, given.get(Parameter::Gamma1)), (21, Some(0.2)));
    /// assert_eq!(given.get(Parameter::Omega), None);
    /// ```
    pub fn parse(path: &Path, text: &str) -> Result<Self, MapError> {
        let ReadFile { file, source, has_orbits, family } = File::read_model(path, text)?;
        let parts = Parts::of(&file, &source)?;
        let compute = file.compute.as_ref();
        let threshold = compute.and_then(|compute| compute.threshold.as_ref());
        let tolerance = |excess: &Spanned<f64>| {
            tolerance_from(*excess.get_ref()).map_err(|message| source.error(excess.span(), message))
        };
        let families = compute.map_or(&[][..], |compute| compute.families.get_ref());
        Ok(Self {
            path: path.to_owned(),
            layout: parts.layout,
            force: parts.force,
            families: families.iter().map(|name| name.get_ref().clone()).chain(family).collect(),
            tolerance: threshold.map(tolerance).transpose()?,
            has_orbits,
            values: parts.values.map(|value| value.map(|value| *value.get_ref())),
            axes: parts.axes,
        })
    }

    /// The value of a parameter; `None` where the file has none, or sweeps it.
    pub fn get(&self, parameter: Parameter) -> Option<f64> {
        self.values[parameter as usize]
    }

    /// The axis along which a parameter is swept.
    pub fn axis(&self, parameter: Parameter) -> Option<&Axis> {
        self.axes.iter().find(|axis| axis.parameter == parameter)
    }
}

/// The model and the axes of a scene's file: nothing is given twice, and each axis has its values.
pub(super) struct Parts<'a> {
    pub(super) layout: Layout,
    pub(super) force: Option<Force>,
    pub(super) axes: Vec<Axis>,
    /// In the order of [`Parameter::ALL`].
    pub(super) values: Values<&'a Spanned<f64>>,
}

impl<'a> Parts<'a> {
    pub(super) fn of(file: &'a File, source: &Source<'_>) -> Result<Self, MapError> {
        let tables = match &file.sweep {
            Some(sweep) => sweep.get_ref().axes(source)?,
            None => Vec::new(),
        };
        let axes = tables.iter().map(|table| source.axis(table)).collect::<Result<Vec<_>, MapError>>()?;
        for (i, axis) in axes.iter().enumerate() {
            if axes[..i].iter().any(|earlier| earlier.parameter == axis.parameter) {
                let message = format!("{} is swept twice: give different parameters", axis.parameter.name());
                return Err(source.error(tables[i].get_ref().parameter.span(), message));
            }
        }
        let model = file.model.get_ref();
        let layout = model.layout(sites(model, source)?, source)?;
        let force = model.force.as_ref().map(|list| source.force(list)).transpose()?;
        let values = model.values(source)?;
        for (parameter, value) in Parameter::ALL.into_iter().zip(values) {
            let axis =
                tables.iter().map(|table| &table.get_ref().parameter).find(|axis| axis.get_ref() == parameter.name());
            let name = parameter.name();
            if parameter == Parameter::Amplitude && force.is_some() {
                let message = "amplitude and force are both given, but the harmonics of force have their own amplitudes: remove one of the two";
                if let Some(span) = value.map(Spanned::span).or(axis.map(Spanned::span)) {
                    return Err(source.error(span, message));
                }
            }
            if let (Some(value), Some(_)) = (value, axis) {
                let message = format!("{name} is given twice, here and as an axis of [sweep]: remove one of them");
                return Err(source.error(value.span(), message));
            }
        }
        Ok(Self { layout, force, axes, values })
    }
}

fn sites(model: &ModelTable, source: &Source<'_>) -> Result<usize, MapError> {
    let sites = *model.sites.get_ref();
    usize::try_from(sites).ok().filter(|&sites| (1..=MAX_SITES).contains(&sites)).ok_or_else(|| {
        let message = format!("sites = {sites} is out of range: give a whole number from 1 to {MAX_SITES}");
        source.error(model.sites.span(), message)
    })
}
