//! `mapgen curve` of a structure: an event along one of its numbers, followed through a window of two.

use std::fmt::Write as _;

use serde::Serialize;
use serde_json::Value;
use vibrochain_floquet::{CurveError, Event, StructureCurve, StructureWindow, structure_branch};
use vibrochain_maps::caption::in_words;
use vibrochain_maps::files::{CsvFile, distinct};
use vibrochain_maps::followed::curve_rows;
use vibrochain_maps::structure::along::{Named, curves, family};
use vibrochain_maps::structure::answer::structure;
use vibrochain_maps::structure::{Setting, StructureScene};

use super::{Start, course, range, start, value_of};
use crate::args::CurveArgs;
use crate::common::answer::printed;
use crate::common::console::{Console, nothing_else};
use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;
use crate::common::schemas::STRUCTURE_CURVE;
use crate::curve::table::{header, write};
use crate::curve::told;

/// Runs the subcommand for a structure.
///
/// # Errors
/// [`CliError`]; that there is no event is an answer.
pub(crate) fn run(args: &CurveArgs, scene: &StructureScene, console: &mut Console<'_>) -> Result<(), CliError> {
    let files = [("--out", args.out.as_deref()), ("--plot", args.plot.as_deref())];
    let taken = distinct(&args.along.reads(), &files)?;
    nothing_else(args.json, taken)?;
    let settings = [args.along.free.setting()?, args.and.setting()?];
    let [first, second] = settings;
    if first == second {
        return Err(CliError::Request(format!("--free and --and are both {first}: give two numbers")));
    }
    if !(1e-12..=0.01).contains(&args.tolerance) {
        return Err(CurveError::Tolerance(args.tolerance).into());
    }
    let stop = (console.interrupt)()?;
    let names = settings.map(|setting| setting.to_string());
    let file =
        args.out.as_deref().map(|path| CsvFile::create("--out", path, header([&names[0], &names[1]]))).transpose()?;
    let pictures = PictureFiles::one("--plot", args.plot.as_deref(), &args.page)?;
    let start = start(&args.along, scene)?;
    let [from, to] = range(scene, first, [args.along.from, args.along.to])?;
    let [and_from, and_to] = range(scene, second, [args.and_from, args.and_to])?;
    let window = StructureWindow { from: [from, and_from], to: [to, and_to] };
    let course = course(&start, [from, to], vec![args.event], None)?;
    let found = structure_branch(&start.orbit, &family(scene, &[first]), start.value, &course, &stop)?;
    let value = value_of(scene, second)?;
    let curves = curves(scene, (settings, value), &found, (window, args.tolerance), &stop)?;
    let text = if args.json {
        json(&start, settings, &window, &curves)?
    } else {
        as_text(args.event, &start, &names, &curves)
    };
    console.answer(&text, args.json, taken)?;
    if let Some(file) = file {
        write(file, &curves)?;
    }
    draw(pictures, &start, settings, &window, &curves)
}

/// The answer as JSON.
#[derive(Serialize)]
struct Answer<'a> {
    schema: &'static str,
    structure: Value,
    word: &'a str,
    solution: usize,
    free: [Named; 2],
    from: [f64; 2],
    to: [f64; 2],
    curves: &'a [StructureCurve],
}

fn json(
    start: &Start<'_>,
    settings: [Setting; 2],
    window: &StructureWindow,
    curves: &[StructureCurve],
) -> Result<String, CliError> {
    let answer = Answer {
        schema: STRUCTURE_CURVE,
        structure: structure(start.scene, start.orbit.model()),
        word: &start.word,
        solution: start.solution,
        free: settings.map(Named),
        from: window.from,
        to: window.to,
        curves,
    };
    printed(&answer)
}

/// The answer for people. Writing to a String cannot fail.
fn as_text(event: Event, start: &Start<'_>, [first, second]: &[String; 2], curves: &[StructureCurve]) -> String {
    let mut out = format!("{event} of {}\n", start.heading());
    if curves.is_empty() {
        let _ = writeln!(out, "\nno {event} along {first}: nothing to follow");
    }
    told(&mut out, [first, second], curves);
    out
}

fn draw(
    files: PictureFiles,
    start: &Start<'_>,
    settings: [Setting; 2],
    window: &StructureWindow,
    curves: &[StructureCurve],
) -> Result<(), CliError> {
    if files.is_empty() {
        return Ok(());
    }
    let labels = settings.map(|setting| start.scene.label(setting));
    let event = curves.first().map_or(String::new(), |curve| format!("{}, ", in_words(curve.event.name())));
    let heading = format!("{event}{}", start.fixed(&settings));
    let picture = vibrochain_plot::event_curves(&heading, labels, (window.from, window.to), &curve_rows(curves));
    files.draw(|page| vibrochain_plot::curves_picture(&picture, page))
}
