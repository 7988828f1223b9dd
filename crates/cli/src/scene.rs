//! Scene files: what to sweep and what to compute, checked before anything is computed.

use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;
use vibrochain_breather::Family;
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Force, Harmonic, MAX_HARMONIC};

use crate::cell::Task;
use crate::error::CliError;
use crate::parameter::{Parameter, Point};

/// The most points of one axis.
pub const MAX_POINTS: usize = 1_000_000;

/// One axis of a sweep: equally spaced values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// What is varied.
    pub parameter: Parameter,
    /// First value.
    pub from: f64,
    /// Last value.
    pub to: f64,
    /// Number of values.
    pub points: usize,
}

impl Axis {
    /// Value number `i`, by index: steps never add up.
    pub fn value(&self, i: usize) -> f64 {
        if i + 1 == self.points {
            self.to
        } else {
            self.from + i as f64 * (self.to - self.from) / (self.points - 1) as f64
        }
    }

    /// Distance between neighbouring values.
    pub fn step(&self) -> f64 {
        (self.to - self.from) / (self.points - 1) as f64
    }
}

/// A checked scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Title of pictures, if the scene gives one.
    pub title: Option<String>,
    /// The fixed parameters (swept ones hold their first value).
    pub base: Point,
    /// Inner axis, along a row.
    pub x: Axis,
    /// Outer axis, from row to row.
    pub y: Axis,
    /// What to compute.
    pub task: Task,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    title: Option<String>,
    model: ModelTable,
    sweep: SweepTable,
    compute: ComputeTable,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelTable {
    sites: Spanned<i64>,
    gamma1: Option<Spanned<f64>>,
    gamma2: Option<Spanned<f64>>,
    omega: Option<Spanned<f64>>,
    asymmetry: Option<Spanned<f64>>,
    forcing: Option<ForcingTable>,
    force: Option<Spanned<Vec<HarmonicTable>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HarmonicTable {
    harmonic: Spanned<i64>,
    amplitude: f64,
    #[serde(default)]
    phase: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ForcingTable {
    amplitude: Option<Spanned<f64>>,
    restitution: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepTable {
    x: Spanned<AxisTable>,
    y: Spanned<AxisTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AxisTable {
    parameter: Spanned<String>,
    from: Spanned<f64>,
    to: Spanned<f64>,
    points: Spanned<i64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ComputeTable {
    families: Spanned<Vec<Spanned<String>>>,
    #[serde(default)]
    stability: bool,
    threshold: Option<Spanned<f64>>,
}

/// A scene's text, for errors that point into it.
pub(crate) struct Source<'a> {
    pub(crate) path: &'a Path,
    pub(crate) text: &'a str,
}

impl Source<'_> {
    pub(crate) fn error(&self, span: Range<usize>, message: impl std::fmt::Display) -> CliError {
        let start = span.start.min(self.text.len());
        let before = self.text.get(..start).unwrap_or_default();
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
        let shown = self.text.lines().nth(line - 1).unwrap_or_default();
        let width = line.to_string().len();
        CliError::Request(format!(
            "{}:{line}:{column}: {message}\n{line} | {shown}\n{:width$} | {:indent$}^",
            self.path.display(),
            "",
            "",
            indent = column - 1
        ))
    }

    fn force(&self, list: &Spanned<Vec<HarmonicTable>>) -> Result<Force, CliError> {
        let harmonic = |table: &HarmonicTable| {
            let number = *table.harmonic.get_ref();
            let number = u32::try_from(number).map_err(|_| {
                let message =
                    format!("harmonic = {number} is out of range: give an odd number from 1 to {MAX_HARMONIC}");
                self.error(table.harmonic.span(), message)
            })?;
            Ok(Harmonic { number, amplitude: table.amplitude, phase: table.phase })
        };
        let harmonics = list.get_ref().iter().map(harmonic).collect::<Result<Vec<_>, CliError>>()?;
        Force::new(&harmonics).map_err(|error| self.error(list.span(), error))
    }

    fn axis(&self, table: &AxisTable) -> Result<Axis, CliError> {
        let name = table.parameter.get_ref();
        let parameter = Parameter::from_name(name).ok_or_else(|| {
            let known = Parameter::ALL.map(Parameter::name).join(", ");
            self.error(table.parameter.span(), format!("`{name}` cannot be swept: give one of {known}"))
        })?;
        let points = *table.points.get_ref();
        let count = usize::try_from(points).ok().filter(|count| (2..=MAX_POINTS).contains(count));
        let points = count.ok_or_else(|| {
            let range = format!("points = {points} is out of range: give a whole number from 2 to {MAX_POINTS}");
            self.error(table.points.span(), range)
        })?;
        let (from, to) = (*table.from.get_ref(), *table.to.get_ref());
        if !from.is_finite() || !to.is_finite() || from >= to {
            let message = format!("from = {from}, to = {to} is not a range: give finite values with from < to");
            return Err(self.error(table.from.span(), message));
        }
        Ok(Axis { parameter, from, to, points })
    }
}

impl Scene {
    /// Reads and checks a scene file.
    ///
    /// # Errors
    /// [`CliError::Request`], pointing at the line: a file that cannot be read, unknown or missing keys, a parameter
    /// given twice or not at all, a value out of range.
    pub fn read(path: &Path) -> Result<Self, CliError> {
        let text = std::fs::read_to_string(path).map_err(|error| CliError::file("cannot read scene", path, &error))?;
        Self::parse(path, &text)
    }

    /// Checks a scene's text; `path` is for messages.
    ///
    /// # Errors
    /// As [`Scene::read`].
    ///
    /// ```
    /// use std::path::Path;
    /// use vibrochain_cli::scene::Scene;
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
    pub fn parse(path: &Path, text: &str) -> Result<Self, CliError> {
        let source = Source { path, text };
        let file: File =
            toml::from_str(text).map_err(|error| source.error(error.span().unwrap_or(0..0), error.message().trim()))?;
        let (x, y) = (source.axis(file.sweep.x.get_ref())?, source.axis(file.sweep.y.get_ref())?);
        if x.parameter == y.parameter {
            let message = format!("{} is swept twice: give two different parameters", y.parameter.name());
            return Err(source.error(file.sweep.y.get_ref().parameter.span(), message));
        }
        let sites = *file.model.sites.get_ref();
        let sites = usize::try_from(sites)
            .ok()
            .filter(|&sites| (1..=vibrochain_lattice::MAX_SITES).contains(&sites))
            .ok_or_else(|| {
            let limit = vibrochain_lattice::MAX_SITES;
            let message = format!("sites = {sites} is out of range: give a whole number from 1 to {limit}");
            source.error(file.model.sites.span(), message)
        })?;
        let mut base = Point { sites, values: [0.0; 6], force: None };
        let forcing = file.model.forcing.as_ref();
        let force = file.model.force.as_ref().map(|list| source.force(list)).transpose()?;
        let given = [
            (Parameter::Gamma1, &file.model.gamma1),
            (Parameter::Gamma2, &file.model.gamma2),
            (Parameter::Omega, &file.model.omega),
            (Parameter::Asymmetry, &file.model.asymmetry),
            (Parameter::Amplitude, forcing.map_or(&None, |forcing| &forcing.amplitude)),
            (Parameter::Restitution, forcing.map_or(&None, |forcing| &forcing.restitution)),
        ];
        let is_swept = |parameter| x.parameter == parameter || y.parameter == parameter;
        // Without any word of force or restitution the model is conservative.
        let conservative = forcing.is_none()
            && force.is_none()
            && !is_swept(Parameter::Amplitude)
            && !is_swept(Parameter::Restitution);
        let mut spans = [const { None }; 6];
        for (parameter, value) in given {
            let name = parameter.name();
            let forcing = matches!(parameter, Parameter::Amplitude | Parameter::Restitution);
            let place = if forcing { "[model] forcing" } else { "[model]" };
            if parameter == Parameter::Amplitude
                && let Some(force) = &force
            {
                let message = "amplitude and force are both given, but the harmonics of force have their own amplitudes: remove one of the two";
                let axes = [file.sweep.x.get_ref(), file.sweep.y.get_ref()];
                let axis = axes.iter().find(|axis| axis.parameter.get_ref() == name).map(|axis| &axis.parameter);
                if let Some(span) = value.as_ref().map(Spanned::span).or(axis.map(Spanned::span)) {
                    return Err(source.error(span, message));
                }
                base = base.under(force);
                continue;
            }
            let value = match (value, is_swept(parameter)) {
                (Some(value), true) => {
                    let message = format!("{name} is given twice, here and as an axis of [sweep]: remove one of them");
                    return Err(source.error(value.span(), message));
                }
                (Some(value), false) => {
                    spans[parameter as usize] = Some(value.span());
                    *value.get_ref()
                }
                (None, true) => {
                    if x.parameter == parameter {
                        x.from
                    } else {
                        y.from
                    }
                }
                (None, false) if conservative && parameter == Parameter::Amplitude => 0.0,
                (None, false) if conservative && parameter == Parameter::Restitution => 1.0,
                (None, false) => {
                    let message = format!("{name} is missing: set it in {place}, or sweep it");
                    return Err(source.error(file.model.sites.span(), message));
                }
            };
            base = base.with(parameter, value);
        }
        // Ranges are intervals, so that the corners stand for all cells.
        for x_value in [x.from, x.to] {
            for y_value in [y.from, y.to] {
                if let Err(error) = base.with(x.parameter, x_value).with(y.parameter, y_value).model() {
                    // The end of the axis that is out of range, or the fixed value.
                    let end = |axis: &Axis, table: &Spanned<AxisTable>, value: f64| {
                        let end = if value == axis.from { &table.get_ref().from } else { &table.get_ref().to };
                        (axis.parameter.name() == error.name).then(|| end.span())
                    };
                    let span = end(&x, &file.sweep.x, x_value).or(end(&y, &file.sweep.y, y_value));
                    let span = span.or(Parameter::from_name(error.name).and_then(|p| spans[p as usize].clone()));
                    return Err(source.error(span.unwrap_or_else(|| file.model.sites.span()), error));
                }
            }
        }
        let task = source.task(&file.compute)?;
        Ok(Self { title: file.title, base, x, y, task })
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.x.points * self.y.points
    }

    /// The point of column `i` and row `j`.
    pub fn point(&self, i: usize, j: usize) -> Point {
        self.base.with(self.x.parameter, self.x.value(i)).with(self.y.parameter, self.y.value(j))
    }

    /// No force and elastic impacts in every cell.
    pub fn is_conservative(&self) -> bool {
        let swept = |parameter| self.x.parameter == parameter || self.y.parameter == parameter;
        let forced = swept(Parameter::Amplitude) || self.base.get(Parameter::Amplitude) > 0.0;
        !forced && !swept(Parameter::Restitution) && self.base.get(Parameter::Restitution) == 1.0
    }
}

impl Source<'_> {
    fn task(&self, table: &ComputeTable) -> Result<Task, CliError> {
        let mut families = Vec::new();
        for name in table.families.get_ref() {
            let family = match name.get_ref().as_str() {
                "double-sided" => Family::DoubleSided,
                "single-sided" => Family::SingleSided,
                "period-doubled" => {
                    let message = "period-doubled orbits have no class on a map: leave them out here and look at single points with `mapgen orbit --family period-doubled`";
                    return Err(self.error(name.span(), message));
                }
                other => {
                    let message = format!("`{other}` is not a family: give \"double-sided\", \"single-sided\" or both");
                    return Err(self.error(name.span(), message));
                }
            };
            if families.contains(&family) {
                return Err(self.error(name.span(), format!("{} is given twice: remove one", name.get_ref())));
            }
            families.push(family);
        }
        if families.is_empty() {
            return Err(
                self.error(table.families.span(), "families is empty: give \"double-sided\", \"single-sided\" or both")
            );
        }
        // A fixed order, so that equal scenes give equal tables.
        families.sort_by_key(|family| *family == Family::SingleSided);
        let tolerance = match &table.threshold {
            None => Tolerance::Rounding,
            Some(threshold) => {
                let span = threshold.span();
                if !table.stability {
                    return Err(self.error(span, "threshold needs stability = true: it decides what counts as stable"));
                }
                tolerance_from(*threshold.get_ref()).map_err(|message| self.error(span, message))?
            }
        };
        Ok(Task { families, stability: table.stability, tolerance })
    }
}

/// The tolerance of a threshold given by the user, or what is wrong with it.
pub fn tolerance_from(threshold: f64) -> Result<Tolerance, String> {
    if threshold.is_finite() && threshold >= 0.0 {
        Ok(Tolerance::Growth(threshold))
    } else {
        Err(format!("threshold = {threshold} is out of range: give a finite growth per period of 0 or more"))
    }
}
