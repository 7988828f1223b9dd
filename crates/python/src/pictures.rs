//! What pictures are made of, for Python: colours and words as `mapgen`'s pictures have them, and small drawings as SVG.

use std::path::Path;

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use vibrochain_breather::admissibility;
use vibrochain_floquet::{Event, FloquetError, Mechanism, Stability, Tolerance, stability};
use vibrochain_lattice::{Parameter, Spectrum, Stop};
use vibrochain_maps::caption::{describe, in_common, in_words};
use vibrochain_maps::cell::Class;
use vibrochain_maps::followed::{BranchName, BranchRow, CurveRow, title};
use vibrochain_maps::scene::Values;
use vibrochain_maps::structure::StructureScene;
use vibrochain_plot::palette::{self, BORDERS, LINES};
use vibrochain_plot::{
    Curves, Diagram, EndsPicture, Format, MapAxis, Mapped, Mark, ModulusAxis, OrbitQuantity, Page, Palette, Pane,
    PlotError, Quantity, Scale, Series, Stroke, Tile, class_words, contact_panes, curves_picture, diagram_curves,
    diverging, ends_picture, event_curves, loss, modulus_axis, multiplier_pane, orbit_flights, orbit_panes, run_trace,
    state,
};

use crate::call::long;
use crate::failure::{Failure, named};
use crate::lengths::Items;
use crate::orbits::PyOrbit;
use crate::params::PyModel;
use crate::structures::{Hit, structure_orbit};

type Rgb = [u8; 3];

/// Letters and width of what stands in a notebook, in units of 1/96 inch.
const LETTERS: f64 = 11.0;
const PANE: f64 = 430.0;

/// The colours of a map of displacements.
const SHADES: i32 = 128;

/// A class by its name; that of no class is one that is not known.
fn class(name: &str) -> Option<Class> {
    Class::ALL.into_iter().find(|class| class.name() == name)
}

/// The colour of a class without a texture.
fn colour(class: Option<Class>) -> Rgb {
    Palette::Colour.pixel(Tile { class, mechanism: None }, 1, 0)
}

/// Colours by their meaning, and the words of legends and axes.
#[pyfunction]
pub(crate) fn _style(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let style = PyDict::new(py);
    let dict = |name: &str, items: Vec<(&str, Bound<'_, PyAny>)>| {
        let dict = PyDict::new(py);
        items.into_iter().try_for_each(|(key, value)| dict.set_item(key, value))?;
        style.set_item(name, dict)
    };
    let any = |value: Rgb| value.into_pyobject(py).map(Bound::into_any);
    let classes = Class::ALL.into_iter().map(|class| Ok((class.name(), any(colour(Some(class)))?)));
    dict("classes", classes.collect::<PyResult<_>>()?)?;
    let text = |text: &str| text.into_pyobject(py).map(Bound::into_any);
    let losses = Mechanism::ALL.into_iter().map(|mechanism| Ok((mechanism.name(), text(loss(mechanism))?)));
    dict("mechanisms", losses.collect::<PyResult<_>>()?)?;
    let axis = |parameter: Parameter| text(&format!("{} {}", parameter.meaning(), parameter.symbol()));
    let labels = Parameter::ALL.into_iter().map(|parameter| Ok((parameter.name(), axis(parameter)?)));
    dict("labels", labels.collect::<PyResult<_>>()?)?;
    let symbols = Parameter::ALL.into_iter().map(|parameter| Ok((parameter.name(), text(parameter.symbol())?)));
    dict("symbols", symbols.collect::<PyResult<_>>()?)?;
    style.set_item("lines", [&LINES[..], &BORDERS[..]].concat())?;
    style.set_item("unknown", colour(None))?;
    style.set_item("below", Palette::Colour.below())?;
    style.set_item("loss", palette::sample(Mechanism::NeimarkSacker, 0, 0))?;
    let shades = (-SHADES..=SHADES).map(|i| diverging(f64::from(i) / f64::from(SHADES)));
    style.set_item("diverging", shades.collect::<Vec<_>>())?;
    Ok(style)
}

/// What the legend of a picture with these classes calls each of them; an empty name is of no class.
#[pyfunction]
pub(crate) fn _class_words(names: Items<String>) -> Vec<&'static str> {
    let classes: Vec<_> = names.0.iter().map(|name| class(name)).collect();
    classes.iter().map(|one| class_words(*one, || classes.iter().copied().flatten())).collect()
}

/// The name of an event in the words of a legend.
#[pyfunction]
pub(crate) fn _in_words(name: &str) -> String {
    in_words(name)
}

/// What these models have in common, as captions say it.
#[pyfunction]
pub(crate) fn _caption(models: Items<PyRef<'_, PyModel>>) -> String {
    in_common(&models.0.iter().map(|model| &model.0).collect::<Vec<_>>())
}

/// The frequencies of a model's modes, by their numbers.
#[pyfunction]
pub(crate) fn _frequencies<'py>(py: Python<'py>, model: PyRef<'_, PyModel>) -> Bound<'py, PyArray1<f64>> {
    Spectrum::new(*model.0.chain()).frequencies().to_vec().into_pyarray(py)
}

/// The frequencies of a structure's modes that swing, rising.
#[pyfunction]
pub(crate) fn _structure_frequencies(py: Python<'_>, scene: String) -> PyResult<Vec<f64>> {
    let work = move |_: &Stop| {
        let scene = StructureScene::of_text(&scene, Path::new("."))?;
        let structure = scene.structure()?;
        let swinging = structure.modes().iter().filter(|mode| mode.turn.sign() > 0.0);
        let mut rates: Vec<f64> = swinging.map(|mode| mode.rate).collect();
        rates.sort_by(f64::total_cmp);
        Ok::<_, Failure>(rates)
    };
    long(py, |_| Ok(()), work)
}

/// A panel: its words, its axes and its curves.
#[pyclass(frozen, name = "_Pane", module = "vibrochain._vibrochain")]
#[derive(Clone)]
pub(crate) struct PyPane(Pane);

/// Name, colour, width of the line (negative of dashes, 0 of none), mark and its shape, points.
type Curve<'py> = (String, usize, i32, &'static str, usize, Bound<'py, PyArray2<f64>>);

/// The same as it is given.
type GivenCurve = (String, usize, i32, String, usize, Items<(f64, f64)>);

fn given((name, colour, stroke, mark, shape, points): GivenCurve) -> Series {
    let width = stroke.unsigned_abs();
    let stroke = match stroke.signum() {
        0 => Stroke::None,
        1 => Stroke::Solid(width),
        _ => Stroke::Dashed(width),
    };
    let mark = match mark.as_str() {
        "filled" => Mark::Filled(shape),
        "small" => Mark::Small(shape),
        "hollow" => Mark::Hollow(shape),
        "dot" => Mark::Dot,
        _ => Mark::None,
    };
    Series { name, colour, stroke, mark, points: points.0 }
}

#[pymethods]
impl PyPane {
    #[new]
    #[pyo3(signature = (caption, x, y, series, *, x_range = None, levels = Items(Vec::new()), moduli = false))]
    fn new(
        caption: &str,
        x: &str,
        y: &str,
        series: Items<GivenCurve>,
        x_range: Option<(f64, f64)>,
        levels: Items<f64>,
        moduli: bool,
    ) -> Self {
        let x_range = x_range.map(|(low, high)| low..high);
        let series: Vec<Series> = series.0.into_iter().map(given).collect();
        let scale = if moduli { Scale::Moduli } else { Scale::Linear };
        Self(Pane { x_range, levels: levels.0, scale, ..Pane::titled(caption, x, y, series) })
    }

    /// The words above, below and beside it.
    fn words(&self) -> (&str, &str, &str) {
        (&self.0.caption, &self.0.x, &self.0.y)
    }

    /// Ends of the horizontal and of the vertical axis, where they are given; whether the latter is one of moduli.
    #[allow(clippy::type_complexity, reason = "three parts for Python")]
    fn axes(&self) -> (Option<(f64, f64)>, Option<(f64, f64)>, bool) {
        let ends = |range: &std::ops::Range<f64>| (range.start, range.end);
        let y = if let Scale::Between(range) = &self.0.scale { Some(ends(range)) } else { None };
        (self.0.x_range.as_ref().map(ends), y, self.0.scale == Scale::Moduli)
    }

    /// Heights of thin lines across it, places of upright ones, and whether a circle is round.
    fn lines(&self) -> (Vec<f64>, Vec<f64>, bool) {
        (self.0.levels.clone(), self.0.uprights.clone(), self.0.round)
    }

    /// Its curves.
    fn series<'py>(&self, py: Python<'py>) -> PyResult<Vec<Curve<'py>>> {
        let curve = |series: &Series| {
            let stroke = match series.stroke {
                Stroke::None => 0,
                Stroke::Solid(width) => width as i32,
                Stroke::Dashed(width) => -(width as i32),
            };
            let (mark, shape) = match series.mark {
                Mark::None => ("", 0),
                Mark::Filled(shape) => ("filled", shape),
                Mark::Small(shape) => ("small", shape),
                Mark::Hollow(shape) => ("hollow", shape),
                Mark::Dot => ("dot", 0),
            };
            let points: Vec<f64> = series.points.iter().flat_map(|(x, y)| [*x, *y]).collect();
            let points = points.into_pyarray(py).reshape([series.points.len(), 2])?;
            Ok((series.name.clone(), series.colour, stroke, mark, shape, points))
        };
        self.0.series.iter().map(curve).collect()
    }
}

/// A panel of an orbit, with what captions say of it.
#[pyfunction]
pub(crate) fn _orbit_pane(py: Python<'_>, orbit: PyRef<'_, PyOrbit>, what: &str) -> PyResult<(PyPane, String)> {
    let (orbit, what) = (orbit.0.clone(), what.to_owned());
    let work = move |_: &Stop| {
        let (is_physical, stability) = (admissibility(&orbit)?.is_physical(), stability(&orbit, Tolerance::Rounding));
        let [profile, motion] = orbit_panes(&orbit)?;
        let panes = [("motion", motion), ("profile", profile), ("portrait", orbit_flights(&orbit)?.1)];
        let (pane, state) = asked(&what, is_physical, stability, panes)?;
        Ok::<_, Failure>((
            pane,
            format!("{} breather: {}{state}", title(&orbit), orbit.model().map_or(String::new(), describe)),
        ))
    };
    long(py, |_| Ok(()), work)
}

/// The panel that is asked for, and for its caption how the orbit lives.
fn asked<const N: usize>(
    what: &str,
    is_physical: bool,
    stability: Result<Stability, FloquetError>,
    panes: [(&str, Pane); N],
) -> Result<(PyPane, String), Failure> {
    // The panel of multipliers says it itself.
    if what == "multipliers" {
        let Stability { multipliers, verdict, .. } = stability?;
        return Ok((PyPane(multiplier_pane(&multipliers, &verdict)), String::new()));
    }
    // (A grazing orbit has no verdict, and a picture all the same.)
    let verdict = stability.as_ref().ok().map(|stability| &stability.verdict);
    match panes.into_iter().find(|(name, _)| *name == what) {
        Some((_, pane)) => Ok((PyPane(pane), format!("; {}", state(is_physical, verdict)))),
        None => refuse!(
            "what = {what:?} is unknown: give one of \"motion\", \"profile\", \"portrait\", \"multipliers\" (of structures without \"profile\")"
        ),
    }
}

/// A panel of a structure's orbit, with what captions say of it.
#[pyfunction]
pub(crate) fn _structure_pane(
    py: Python<'_>,
    scene: String,
    near: Items<Hit>,
    psi: f64,
    force_periods: u32,
    what: String,
) -> PyResult<(PyPane, String)> {
    let work = move |_: &Stop| {
        let (scene, orbit) = structure_orbit(&scene, &near.0, psi, force_periods)?;
        let (admissibility, stability) = (admissibility(&orbit)?, stability(&orbit, Tolerance::Rounding));
        let contacts = orbit.at_contacts(&Stop::default())?;
        let [motion, portrait] = contact_panes(&contacts, admissibility.obstruction.as_ref())?.swap_remove(0);
        let panes = [("motion", motion), ("portrait", portrait)];
        let (pane, state) = asked(&what, admissibility.is_physical(), stability, panes)?;
        Ok::<_, Failure>((pane, format!("{}, {}: {}{state}", scene.heading(), orbit.name(), scene.here())))
    };
    long(py, |_| Ok(()), work)
}

/// A point of a branch or an event on it: event, value, impulses, phi, psi, period, margin, physical, stable, spectral radius.
#[allow(clippy::type_complexity, reason = "a row of a table")]
type GivenRow = (
    Option<String>,
    f64,
    Items<f64>,
    Option<f64>,
    Option<f64>,
    f64,
    Option<f64>,
    Option<bool>,
    Option<bool>,
    Option<f64>,
);

fn row((event, value, impulses, phi, psi, period, margin, physical, stable, spectral_radius): GivenRow) -> BranchRow {
    let event = event.and_then(|name| Event::from_name(&name));
    BranchRow { event, value, impulses: impulses.0, phi, psi, period, margin, physical, stable, spectral_radius }
}

/// A panel of branches, each with its name, its generation, and the periods of the force in its orbits'.
#[pyfunction]
pub(crate) fn _branch_pane(
    x: String,
    branches: Items<(String, u32, u32, Items<GivenRow>)>,
    show: &str,
    all: bool,
) -> PyResult<PyPane> {
    let shown = named("show", show, OrbitQuantity::ALL.map(|one| (one.name(), one)))?;
    let (mut names, mut rows) = (Vec::new(), Vec::new());
    for (name, generation, force_periods, points) in branches.0 {
        names.push(BranchName { name, generation, force_periods });
        rows.push(points.0.into_iter().map(row).collect::<Vec<_>>());
    }
    let diagram = Diagram { heading: String::new(), x, names: &names, rows: &rows };
    Ok(PyPane(diagram_curves(&diagram, &[shown], all).panes.swap_remove(0)))
}

/// A point of a curve: values, whether its orbit is physical, what happens there besides.
type GivenPoint = ([f64; 2], bool, Items<String>);

/// A panel of curves of events over two parameters.
#[pyfunction]
pub(crate) fn _curve_pane(
    labels: [String; 2],
    low: [f64; 2],
    high: [f64; 2],
    curves: Items<Items<GivenPoint>>,
    touches: Items<String>,
) -> PyPane {
    let row = |(values, physical, special): GivenPoint| CurveRow { values, physical, special: special.0 };
    let curves: Vec<Vec<CurveRow>> =
        curves.0.into_iter().map(|points| points.0.into_iter().map(row).collect()).collect();
    PyPane(event_curves("", labels, (low, high), (&curves, &touches.0)).panes.swap_remove(0))
}

/// The axis of these moduli, as `mapgen` draws it: its ends, its ticks with their words, and the marks between them.
#[pyfunction]
pub(crate) fn _modulus_axis(moduli: Items<f64>) -> ModulusAxis {
    modulus_axis(moduli.0, TICKS)
}

/// Ticks of a vertical axis of matplotlib's usual height.
const TICKS: usize = 8;

/// A panel of a run over the orbit that it began on.
#[pyfunction]
pub(crate) fn _run_pane(
    y: &str,
    simulated: Items<(f64, f64)>,
    analytic: Items<(f64, f64)>,
    levels: Items<f64>,
) -> PyPane {
    PyPane(run_trace(y, &simulated.0, &analytic.0, levels.0))
}

fn page(columns: usize) -> Page {
    Page { width: Some(PANE * columns as f64), font: LETTERS, ..Page::from(Format::Svg) }
}

fn svg(bytes: Result<Vec<u8>, PlotError>) -> PyResult<String> {
    let bytes = bytes.map_err(Failure::from)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Panels side by side as SVG.
#[pyfunction]
pub(crate) fn _svg(panes: Items<PyRef<'_, PyPane>>) -> PyResult<String> {
    let columns = panes.0.len();
    let panes = panes.0.iter().map(|pane| pane.0.clone()).collect();
    svg(curves_picture(&Curves { panes, columns, pane: (600, 400), ..Curves::default() }, page(columns)))
}

/// What a picture says of a map that is not a scene here.
#[derive(Debug)]
struct Told {
    heading: String,
    axes: Vec<MapAxis>,
}

impl Mapped for Told {
    fn heading(&self) -> String {
        self.heading.clone()
    }

    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    fn axes(&self) -> Vec<MapAxis> {
        self.axes.clone()
    }

    fn class(&self, _: Class, _: &[Class]) -> String {
        String::new()
    }

    fn has(&self, _: Quantity) -> Result<(), &'static str> {
        Ok(())
    }
}

/// Values in equal steps as such: the axis of a list has no other places.
fn spaced(values: Vec<f64>) -> Values {
    let points = values.len();
    if let [from, .., to] = values[..] {
        let even = Values::Linear { from, to, points };
        let near = 1e-9 * (to - from).abs();
        if (0..points).all(|i| (even.value(i) - values[i]).abs() <= near) {
            return even;
        }
    }
    Values::List(values)
}

/// A map over two axes, the fastest first, as SVG: of each cell the number of a name with its colour.
#[pyfunction]
pub(crate) fn _map_svg(
    heading: String,
    caption: String,
    axes: Items<(String, String, Items<f64>)>,
    codes: PyReadonlyArray1<'_, i8>,
    names: Items<(String, Rgb)>,
) -> PyResult<String> {
    let axis = |(name, label, values): (String, String, Items<f64>)| MapAxis { name, label, values: spaced(values.0) };
    let scene = Told { heading, axes: axes.0.into_iter().map(axis).collect() };
    let cells: Vec<Option<usize>> = codes.as_array().iter().map(|code| usize::try_from(*code).ok()).collect();
    svg(ends_picture(&EndsPicture { scene: &scene, caption, names: &names.0, cells: &cells }, page(1)))
}
