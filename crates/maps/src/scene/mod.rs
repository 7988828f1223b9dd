//! Scene files: what to sweep and what to compute, checked before anything is computed.

mod axis;
mod compute;
mod data;
mod file;
mod given;
mod slice;
mod source;

use std::ops::Range;
use std::path::Path;

use serde_json::Value;
use toml::Spanned;
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Model, Parameter, Part, Point, Row};

pub(crate) use crate::scene::axis::AxisTable;
pub use crate::scene::axis::{Axis, MAX_POINTS, Values};
pub use crate::scene::compute::tolerance_from;
pub(crate) use crate::scene::data::Places;
pub(crate) use crate::scene::file::ModelTable;
pub use crate::scene::file::{MAX_BYTES, damped_keys};
pub use crate::scene::given::Given;
pub use crate::scene::slice::Slice;
pub use crate::scene::source::Source;
pub(crate) use crate::scene::source::is_json;

use crate::cell::Task;
use crate::error::MapError;
use crate::scene::file::{File, ReadFile};
use crate::scene::given::Parts;
use crate::text::read_text;

/// The most cells of one sweep.
pub const MAX_CELLS: u64 = 1_000_000_000_000;

/// A checked scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Title of pictures, if the scene gives one.
    pub title: Option<String>,
    /// The fixed parameters (swept ones hold their first value).
    pub base: Point,
    /// The axes, the fastest first; each parameter once.
    pub axes: Vec<Axis>,
    /// What to compute.
    pub task: Task,
}

impl Scene {
    /// Reads and checks a scene file.
    ///
    /// # Errors
    /// [`MapError::Request`], pointing at the line: a file that cannot be read or is too long, unknown or missing keys, a parameter
    /// given twice or not at all, a value out of range.
    pub fn read(path: &Path) -> Result<Self, MapError> {
        Self::parse(path, &read_text("scene", path, MAX_BYTES)?)
    }

    /// Checks a scene's text, or that of a manifest, whose table it then describes once more; `path` is for messages.
    ///
    /// # Errors
    /// As [`Scene::read`].
    ///
    /// ```
    /// use std::path::Path;
    /// use vibrochain_maps::scene::Scene;
    /// let text = r#"
    ///     [model]
    ///     sites = 21
    ///     gamma1 = 0.2
    ///     asymmetry = 0.4
    ///     [sweep]
    ///     x = { parameter = "omega", from = 0.4, to = 3.0, points = 40 }
    ///     y = { parameter = "gamma2", from = 0.0, to = 0.3, points = 30 }
    ///     [compute]
    ///     families = ["double-sided", "single-sided"]
    /// "#;
    /// assert_eq!(Scene::parse(Path::new("map.toml"), text).unwrap().cells(), 1200);
    /// assert!(Scene::parse(Path::new("map.toml"), &text.replace("0.4,", "-0.4,")).is_err());
    /// ```
    pub fn parse(path: &Path, text: &str) -> Result<Self, MapError> {
        let ReadFile { file, source, .. } = File::read(path, text)?;
        Self::checked(file, &source)
    }

    /// Checks a scene that is data already, as a manifest has it; `path` is for messages.
    ///
    /// # Errors
    /// As [`Scene::read`], with the key of what is wrong.
    pub fn of_data(path: &Path, scene: &Value) -> Result<Self, MapError> {
        let (file, source) = File::of_data(path, scene)?;
        Self::checked(file, &source)
    }

    fn checked(file: File, source: &Source<'_>) -> Result<Self, MapError> {
        let missing = |key: &str| source.error(0..0, format!("the table [{key}] is missing"));
        let sweep = file.sweep.as_ref().ok_or_else(|| missing("sweep"))?;
        let compute = file.compute.as_ref().ok_or_else(|| missing("compute"))?;
        let tables = sweep.get_ref().axes(source)?;
        if tables.is_empty() {
            let message = "[sweep] has no axis: give x and y, and any others in the list axes";
            return Err(source.error(sweep.span(), message));
        }
        let Parts { layout, force, axes, values } = Parts::of(&file, source)?;
        let cells = axes.iter().try_fold(1_u64, |cells, axis| cells.checked_mul(axis.points() as u64));
        if cells.is_none_or(|cells| cells > MAX_CELLS) {
            let message = format!("the axes have more than {MAX_CELLS} cells together: give fewer points");
            return Err(source.error(sweep.span(), message));
        }
        let mut base = Point::of(layout);
        let axis_of = |parameter| axes.iter().find(|axis| axis.parameter == parameter);
        let is_swept = |parameter| axis_of(parameter).is_some();
        let [amplitude, restitution] = [Parameter::Amplitude, Parameter::Restitution].map(|p| values[p as usize]);
        // Without any word of force or restitution the model is conservative.
        let conservative = file.model.get_ref().forcing.is_none()
            && amplitude.is_none()
            && restitution.is_none()
            && force.is_none()
            && !is_swept(Parameter::Amplitude)
            && !is_swept(Parameter::Restitution);
        // A restitution of 1 needs no force either.
        let elastic = restitution.is_some_and(|value| *value.get_ref() == 1.0);
        let default = |parameter: Parameter| {
            let Row { default, part, .. } = parameter.row();
            default.filter(|_| match part {
                Part::Lattice | Part::Motion | Part::Dashpots => true,
                Part::Layers => layout.layers == 1,
                Part::Driving => conservative || elastic && parameter == Parameter::Amplitude,
            })
        };
        for (parameter, value) in Parameter::ALL.into_iter().zip(values) {
            if let (Parameter::Amplitude, Some(force)) = (parameter, &force) {
                base = base.under(force);
                continue;
            }
            let value = match (value, axis_of(parameter)) {
                (Some(value), _) => *value.get_ref(),
                (None, Some(axis)) => axis.first(),
                (None, None) if let Some(default) = default(parameter) => default,
                (None, None) => {
                    let message = format!("{} is missing: set it in [model], or sweep it", parameter.name());
                    // What asks for it: a restitution is needed with a force, an amplitude with losses.
                    let other = |parameter| {
                        let at = axes.iter().position(|axis| axis.parameter == parameter);
                        let axis = at.map(|at| tables[at].get_ref().parameter.span());
                        values[parameter as usize].map(Spanned::span).or(axis)
                    };
                    let asks = match parameter {
                        Parameter::Restitution => {
                            file.model.get_ref().force.as_ref().map(Spanned::span).or(other(Parameter::Amplitude))
                        }
                        Parameter::Amplitude => other(Parameter::Restitution),
                        _ => None,
                    };
                    return Err(source.error(asks.unwrap_or_else(|| file.model.span()), message));
                }
            };
            base = base.with(parameter, value);
        }
        // Ranges are intervals, so that the corners stand for all cells.
        for corner in 0..1_usize << axes.len() {
            let limit = |(bit, axis): (usize, &Axis)| (axis.parameter, axis.limits()[corner >> bit & 1]);
            let ends: Vec<_> = axes.iter().enumerate().map(limit).collect();
            let point = ends.iter().fold(base, |point, &(parameter, value)| point.with(parameter, value));
            if let Err(error) = point.model() {
                // The end of the axis that is out of range, or the fixed value.
                let end = ends.iter().zip(&tables).find(|((parameter, _), _)| parameter.name() == error.name);
                let span = end.and_then(|((_, value), table)| table.get_ref().place(*value));
                let span =
                    span.or(Parameter::from_name(error.name).and_then(|p| values[p as usize]).map(Spanned::span));
                return Err(source.error(span.unwrap_or_else(|| file.model.span()), error));
            }
        }
        // What two words have in common must hold in all cells.
        let general = [(Parameter::Asymmetry, 0.5), (Parameter::Amplitude, 1.0), (Parameter::Restitution, 0.5)];
        let dashpots = [Parameter::Damping, Parameter::CouplingDamping].map(|parameter| (parameter, 0.5));
        let varied = general.into_iter().chain(dashpots).filter(|&(parameter, _)| is_swept(parameter));
        let anywhere = varied.fold(base, |point, (parameter, value)| point.with(parameter, value));
        let anywhere = anywhere.model().map_err(|error| source.error(file.model.span(), error))?;
        let task = source.task(compute, &anywhere)?;
        let scene = Self { title: file.title, base, axes, task };
        if let Some(span) = compute.collisions.as_ref().map(Spanned::span)
            && scene.task.collisions
            && !scene.is_conservative()
        {
            let message = "collisions are told of conservative orbits only: remove the force, or collisions";
            return Err(source.error(span, message));
        }
        Ok(scene)
    }

    /// Number of cells.
    pub fn cells(&self) -> u64 {
        self.axes.iter().map(|axis| axis.points() as u64).product()
    }

    /// The point of cell number `cell`, counted along the first axis first.
    pub fn point(&self, cell: u64) -> Point {
        let mut rest = cell;
        let mut point = self.base;
        for axis in &self.axes {
            let points = axis.points() as u64;
            point = point.with(axis.parameter, axis.value((rest % points) as usize));
            rest /= points;
        }
        point
    }

    /// Shows the points of some neighbouring cells, in order, as long as it is told to go on.
    pub fn walk(&self, cells: Range<u64>, mut go_on: impl FnMut(&Point) -> bool) {
        self.walk_rows(cells, |point, _| go_on(point));
    }

    /// The same, of the models there; it ends at a point that has none.
    pub fn walk_models(&self, cells: Range<u64>, mut go_on: impl FnMut(&Model) -> bool) {
        let omega_alone = self.axes.first().is_some_and(|axis| axis.parameter == Parameter::Omega);
        let mut model: Option<Model> = None;
        self.walk_rows(cells, |point, begins| {
            let valid = match &mut model {
                Some(model) if omega_alone && !begins => model.set_omega(point.get(Parameter::Omega)),
                model => point.model().map(|here| *model = Some(here)),
            };
            valid.is_ok() && model.as_ref().is_some_and(&mut go_on)
        });
    }

    /// Points, each with whether more than the first axis' value is another than before.
    fn walk_rows(&self, cells: Range<u64>, mut go_on: impl FnMut(&Point, bool) -> bool) {
        let (mut point, row, mut column) = (self.base, self.axes.first(), None);
        for cell in cells {
            let begins = match (row, column) {
                // Along a row one value changes alone.
                (Some(axis), Some(column)) if column < axis.points() => {
                    point.set(axis.parameter, axis.value(column));
                    false
                }
                _ => {
                    point = self.point(cell);
                    column = row.map(|axis| (cell % axis.points() as u64) as usize);
                    true
                }
            };
            column = column.map(|column| column + 1);
            if !go_on(&point, begins) {
                return;
            }
        }
    }

    /// The point at these values along its axes, the first axes' values; what lies between the ends of an axis is a valid model.
    pub fn at(&self, values: &[f64]) -> Point {
        let pairs = self.axes.iter().zip(values);
        pairs.fold(self.base, |point, (axis, &value)| point.with(axis.parameter, value))
    }

    /// The axes x and y of a sweep over just two.
    pub fn plane(&self) -> Option<[&Axis; 2]> {
        match self.axes.as_slice() {
            [x, y] => Some([x, y]),
            _ => None,
        }
    }

    /// The names of the axes, the fastest first: "omega, gamma2 and asymmetry".
    pub fn axis_names(&self) -> String {
        let mut names: Vec<&str> = self.axes.iter().map(|axis| axis.parameter.name()).collect();
        let last = names.pop().unwrap_or_default();
        if names.is_empty() { last.to_owned() } else { format!("{} and {last}", names.join(", ")) }
    }

    /// Whether `parameter` is an axis.
    pub fn sweeps(&self, parameter: Parameter) -> bool {
        self.axes.iter().any(|axis| axis.parameter == parameter)
    }

    /// No force, elastic impacts and no dashpots in every cell.
    pub fn is_conservative(&self) -> bool {
        let forced = self.sweeps(Parameter::Amplitude) || self.base.get(Parameter::Amplitude) > 0.0;
        let is_fixed =
            |(parameter, value): (Parameter, f64)| !self.sweeps(parameter) && self.base.get(parameter) == value;
        let lossless = [(Parameter::Restitution, 1.0), (Parameter::Damping, 0.0), (Parameter::CouplingDamping, 0.0)];
        !forced && lossless.into_iter().all(is_fixed)
    }

    /// The title of pictures: the scene's own, or what is swept.
    pub fn heading(&self) -> String {
        let kind = if self.is_conservative() { "Conservative breathers" } else { "Forced breathers" };
        let words: Vec<String> = self.task.words.iter().map(ToString::to_string).collect();
        let kind = if words.is_empty() { kind.to_owned() } else { format!("{kind}: {}", words.join("; ")) };
        self.title.clone().unwrap_or(kind)
    }

    /// "21 masses (N = 20), γ₁ = 0.2, …": what is fixed.
    pub fn fixed(&self) -> String {
        let layout = self.base.layout;
        let mut text = layout.to_string();
        for &parameter in Parameter::of(self.base.layout.layers) {
            let swept = self.sweeps(parameter);
            let forced = matches!(parameter, Parameter::Amplitude | Parameter::Restitution);
            if let (Parameter::Amplitude, Some(force)) = (parameter, &self.base.force) {
                text += &format!(", force {force}");
            } else if self.base.tells(parameter) && !(swept || forced && self.is_conservative()) {
                text += &format!(", {} = {}", parameter.symbol(), self.base.get(parameter));
            }
        }
        text
    }

    /// What was looked for, and what counts as stable: "double-sided and single-sided breathers, stable: no |μ| above 1 by more than rounding".
    pub fn criterion(&self) -> String {
        let names: Vec<String> = self.task.family_names().collect();
        let mut text = match names.split_last() {
            Some((last, [])) => format!("{last} breathers"),
            Some((last, others)) => format!("{} and {last} breathers", others.join(", ")),
            // The heading names the words.
            None => String::new(),
        };
        if self.task.stability {
            if !text.is_empty() {
                text += ", ";
            }
            text += &criterion(self.task.tolerance);
        }
        text
    }
}

/// What counts as stable, in words.
#[must_use]
pub fn criterion(tolerance: Tolerance) -> String {
    match tolerance {
        Tolerance::Rounding => "stable: no |μ| above 1 by more than rounding".to_owned(),
        Tolerance::Excess(excess) => format!("stable: excess |μ| − 1 below {excess} a period"),
    }
}
