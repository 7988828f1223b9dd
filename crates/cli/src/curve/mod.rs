//! `mapgen curve`: the curve of an event as two parameters vary.

pub(crate) mod table;

use std::fmt::Write as _;

use serde::Serialize;
use serde_json::json;
use vibrochain_floquet::{EventCurve, Located, Search, Walk, Window, curve_along, locate_until};
use vibrochain_lattice::{Parameter, Short};
use vibrochain_maps::caption::{in_common, in_words};
use vibrochain_maps::files::{CsvFile, distinct};
use vibrochain_maps::followed::curve_rows;
use vibrochain_maps::numbers::Number;

use crate::args::CurveArgs;
use crate::common::answer::{StartAnswer, printed};
use crate::common::console::{Console, nothing_else};
use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;
use crate::common::schemas::CURVE;
use crate::common::table_manifest::{Manifest, beside};
use crate::curve::table::{About, header, write};
use crate::locate::{Start, message, range, start};
use crate::structures;

/// The curves, and the window they are in.
struct Curves {
    window: Window,
    list: Vec<EventCurve>,
}

/// The answer as JSON.
#[derive(Serialize)]
struct CurveAnswer<'a> {
    schema: &'static str,
    #[serde(flatten)]
    start: StartAnswer<'a>,
    #[serde(flatten)]
    window: Window,
    curves: &'a [EventCurve],
    #[serde(skip_serializing_if = "Option::is_none")]
    word: Option<String>,
}

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`]; that there is no event is an answer.
pub fn run(args: &CurveArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    if let Some(scene) = structures::asked(&args.along.model)? {
        return structures::along::curve::run(args, &scene, console);
    }
    let manifest = beside(args.out.as_deref())?;
    let files = [
        ("--out", args.out.as_deref()),
        ("the manifest of --out", manifest.as_deref()),
        ("--plot", args.plot.as_deref()),
    ];
    let taken = distinct(&args.along.reads(), &files)?;
    nothing_else(args.json, taken)?;
    let [first, second] = [args.along.free.parameter()?, args.and.parameter()?];
    if first == second {
        return Err(CliError::Request(format!("--free and --and are both {}: give two parameters", first.name())));
    }
    let stop = (console.interrupt)()?;
    let header = header([first.name(), second.name()]);
    let file = args.out.as_deref().map(|path| CsvFile::create("--out", path, header)).transpose()?;
    let manifest = Manifest::create(manifest.as_deref())?;
    let pictures = PictureFiles::one("--plot", args.plot.as_deref(), &args.page)?;
    let start = start(&args.along, &stop, console)?;
    let window = window(args, &start)?;
    let search = Search { event: args.event, free: first, from: window.from[0], to: window.to[0] };
    let mut curves = Curves { window, list: Vec::new() };
    fits(&pictures, &curves)?;
    let answer = locate_until(&start.orbit, &search, &stop)?;
    for located in &answer.located {
        if !curves.holds(located, args.tolerance) {
            let walk = Walk { stop: stop.clone(), ..Walk::new(curves.window, args.tolerance) };
            curves.list.push(curve_along(&located.orbit, located.event, located.evidence, &walk)?);
        }
    }
    let text = if args.json { printed(&curves.answer(&start))? } else { curves.as_text(&start, &search, &answer.ends) };
    console.answer(&text, args.json, taken)?;
    let heading = curves.heading(&start);
    if let Some(file) = file {
        write(file, &curves.list)?;
        let count: usize = curves.list.iter().map(|curve| curve.points.len()).sum();
        let (window, parameters) = (curves.window, json!(start.orbit.model()));
        let about = About { window, heading: heading.clone(), parameters };
        manifest.finish("curve", count as u64, &about)?;
    }
    draw(pictures, &heading, &curves)
}

/// The ranges of both parameters.
fn window(args: &CurveArgs, start: &Start) -> Result<Window, CliError> {
    let parameters = [args.along.free.parameter()?, args.and.parameter()?];
    let asked = [[args.along.from, args.along.to], [args.and_from, args.and_to]];
    let (mut from, mut to) = ([0.0; 2], [0.0; 2]);
    for i in 0..2 {
        let usual = Search::new(&start.orbit, args.event, parameters[i]);
        let [least, most] = range(&start.chosen, parameters[i], asked[i]);
        (from[i], to[i]) = (least.unwrap_or(usual.from), most.unwrap_or(usual.to));
    }
    for (flag, value) in [("--and-from", args.and_from), ("--and-to", args.and_to)] {
        let Some(value) = value else { continue };
        let model = start.orbit.model().with(parameters[1], value);
        let _ = model.map_err(|error| CliError::Request(format!("{flag}: {error}")))?;
    }
    let value = start.orbit.model().get(parameters[1]);
    if !(from[1] <= value && value <= to[1] && from[1] < to[1]) {
        let here = format!("{} = {}, where the search starts", parameters[1].name(), Short(value));
        let message = format!(
            "--and-from {} and --and-to {} are no range around {here}: give one that holds it",
            Short(from[1]),
            Short(to[1])
        );
        return Err(CliError::Request(message));
    }
    Ok(Window { parameters, from, to })
}

impl Curves {
    /// Whether an event lies on one of the curves that were followed already.
    fn holds(&self, located: &Located, tolerance: f64) -> bool {
        let place = self.window.place(located.orbit.model());
        let passes =
            |curve: &EventCurve| curve.passes((place, &located.orbit), tolerance, |values| self.window.parts(values));
        self.list.iter().any(passes)
    }

    /// What is in the heading of a picture: the event, and what all points of all curves have in common.
    fn heading(&self, start: &Start) -> String {
        let event = self.list.first().map_or(String::new(), |curve| {
            format!("{} of {} breathers, ", in_words(curve.event.name()), start.orbit.name())
        });
        let ends = self.list.iter().flat_map(|curve| [curve.points.first(), curve.points.last()]).flatten();
        let mut models: Vec<_> = ends.map(|point| point.orbit.model()).collect();
        models.push(start.orbit.model());
        format!("{event}{}", in_common(&models))
    }

    fn answer<'a>(&'a self, start: &'a Start) -> CurveAnswer<'a> {
        let (window, curves, word) = (self.window, &self.list, start.orbit.word());
        CurveAnswer { schema: CURVE, start: start.answer(), window, curves, word }
    }

    /// The answer for people. Writing to a String cannot fail.
    fn as_text(&self, start: &Start, search: &Search, ends: &[(f64, vibrochain_floquet::End); 2]) -> String {
        let [first, second] = self.window.parameters.map(Parameter::name);
        let mut out = String::new();
        let _ = writeln!(out, "{} of {}", search.event, start.heading(search.free));
        if self.list.is_empty() {
            let _ = writeln!(out, "\nno {} along {first}: nothing to follow", search.event);
            for (way, (value, end)) in ["down", "up"].into_iter().zip(ends) {
                let _ = writeln!(out, "{way}: {}", message(search.free, *value, end));
            }
        }
        told(&mut out, [first, second], &self.list);
        let (orbits, spectra) = self.list.iter().fold((0, 0), |(a, b), one| (a + one.evaluations, b + one.spectra));
        let _ = writeln!(out, "\n{orbits} orbits assembled, {spectra} eigenvalue problems");
        out
    }
}

/// Curves of two numbers for people: points of codimension two, and ends. Writing to a String cannot fail.
pub(crate) fn told<O>(out: &mut String, [first, second]: [&str; 2], curves: &[EventCurve<O>]) {
    let place = |values: [f64; 2]| format!("{first} = {}, {second} = {}", Number(values[0]), Number(values[1]));
    for (i, curve) in curves.iter().enumerate() {
        let worst = curve.points.iter().map(|point| point.error).fold(0.0, f64::max);
        let count = curve.points.len();
        let _ = writeln!(out, "\ncurve {}: {count} points, known to {worst:.0e} of the window or better", i + 1);
        for one in &curve.special {
            let at = &curve.points[one.point];
            let aside = if at.physical == Some(false) { "; not physical" } else { "" };
            let _ = writeln!(out, "  {} ± {:.0e}  {}{aside}", place(at.values), one.error, one.special);
        }
        for (point, end) in [curve.points.first(), curve.points.last()].into_iter().zip(&curve.ends) {
            let Some(point) = point else { continue };
            let _ = writeln!(out, "  end: {}, {end}", place(point.values));
        }
    }
}

/// What stands at the axes of a window.
pub(crate) fn labels(window: &Window) -> [String; 2] {
    window.parameters.map(|parameter| format!("{} {}", parameter.meaning(), parameter.symbol()))
}

fn draw(files: PictureFiles, heading: &str, curves: &Curves) -> Result<(), CliError> {
    if files.is_empty() {
        return Ok(());
    }
    let picture = vibrochain_plot::event_curves(
        heading,
        labels(&curves.window),
        (curves.window.from, curves.window.to),
        &curve_rows(&curves.list),
    );
    files.draw(|page| vibrochain_plot::curves_picture(&picture, page))
}

/// Makes sure that the picture can be made.
fn fits(files: &PictureFiles, curves: &Curves) -> Result<(), CliError> {
    files.fit(|page| {
        vibrochain_plot::curves_picture(
            &vibrochain_plot::event_curves("", labels(&curves.window), (curves.window.from, curves.window.to), &[]),
            page,
        )
    })
}
