//! `mapgen curve`: the curve of an event as two numbers vary.

pub(crate) mod table;

use std::fmt::Write as _;

use serde_json::json;
use vibrochain_floquet::{CurveError, Event, EventCurve, Walk, Window, event_curves as event_curves_of};
use vibrochain_maps::followed::{curve_rows, touch};
use vibrochain_maps::numbers::Number;
use vibrochain_plot::{curves_picture, event_curves};

use crate::along::{
    Along, ChainAlong, Events, FIRST, Outputs, SECOND, StructureAlong, Wanted, answer, checked_range, ending,
};
use crate::args::CurveArgs;
use crate::common::answer::printed;
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::schemas::{CURVE, STRUCTURE_CURVE};
use crate::curve::table::{About, header, write};
use crate::structures;
use vibrochain_maps::manifest::object;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`]; that there is no event is an answer.
pub fn run(args: &CurveArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    match structures::asked(&args.along.model)? {
        Some(scene) => follow::<StructureAlong>(args, scene, console),
        None => follow::<ChainAlong>(args, (), console),
    }
}

fn follow<A: Along>(args: &CurveArgs, scene: A::Scene, console: &mut Console<'_>) -> Result<(), CliError> {
    let free = [A::free(&args.along.free)?, A::free(&args.and)?];
    let names = free.map(A::name);
    let [first, second] = [names[0].as_str(), names[1].as_str()];
    ensure!(first != second, "--free and --and are both {first}: give two parameters");
    ensure!((1e-12..=0.01).contains(&args.tolerance), CurveError::Tolerance(args.tolerance).into());
    let CurveArgs { along, json, out, plot, page, .. } = args;
    let wanted = Wanted { along, json: *json, out: out.as_deref(), plot: plot.as_deref(), page };
    let outputs = Outputs::open::<A>(&wanted, header([first, second]), console)?;
    let Outputs { taken, stop, file, manifest, pictures } = outputs;
    let along = A::begin(&args.along, scene, &stop, console)?;
    let range = checked_range(&along, free[0], FIRST, [args.along.from, args.along.to])?;
    let and = checked_range(&along, free[1], SECOND, [args.and_from, args.and_to])?;
    let (from, to) = ([range[0], and[0]], [range[1], and[1]]);
    let labels = free.map(|free| along.label(free));
    let nothing = event_curves("", labels.clone(), (from, to), (&[], &[]));
    pictures.fit(|page| curves_picture(&nothing, page))?;
    let found = along.located(args.event, free[0], range, &stop)?;
    let walk = Walk { stop: stop.clone(), ..Walk::new(Window { from, to }, args.tolerance) };
    let curves = event_curves_of(&found.located, &along.numbers(free, &stop)?, &walk)?;
    let touches: Vec<String> = curves.iter().map(touch).collect();
    let text = if args.json {
        let mut told = answer(&along, if A::OF_CHAINS { CURVE } else { STRUCTURE_CURVE }, json!(names));
        told.extend(object([("from", json!(from)), ("to", json!(to)), ("curves", json!(curves))]));
        printed(&told)?
    } else {
        as_text(&along, args.event, free[0], [first, second], &found, (&curves, &touches))?
    };
    console.answer(&text, args.json, taken)?;
    let heading = along.over_curves(free, &curves);
    if let Some(file) = file {
        write(file, &curves)?;
        let count: usize = curves.iter().map(|curve| curve.points.len()).sum();
        let window = object([("free", json!(names)), ("from", json!(from)), ("to", json!(to))]);
        let parameters = along.head().remove("parameters").unwrap_or_default();
        manifest.finish(
            "curve",
            count as u64,
            &About { window, heading: heading.clone(), parameters, touches: touches.clone() },
        )?;
    }
    if pictures.is_empty() {
        return Ok(());
    }
    let picture = event_curves(&heading, labels, (from, to), (&curve_rows(&curves), &touches));
    pictures.draw(|page| curves_picture(&picture, page))
}

/// The answer for people: points of codimension two, and ends. Writing to a String cannot fail.
fn as_text<A: Along>(
    along: &A,
    event: Event,
    free: A::Free,
    [first, second]: [&str; 2],
    found: &Events,
    (curves, touches): (&[EventCurve], &[String]),
) -> Result<String, CliError> {
    let mut out = format!("{event} of {}\n", along.heading(free)?);
    if curves.is_empty() {
        let _ = writeln!(out, "\nno {event} along {first}: nothing to follow");
        for (way, (value, end)) in ["down", "up"].into_iter().zip(&found.ends) {
            let _ = writeln!(out, "{way}: {}", ending(first, *value, end));
        }
    }
    let place = |values: [f64; 2]| format!("{first} = {}, {second} = {}", Number(values[0]), Number(values[1]));
    for (i, (curve, touch)) in curves.iter().zip(touches).enumerate() {
        let touch = if touch.is_empty() { String::new() } else { format!("{touch}, ") };
        let worst = curve.points.iter().map(|point| point.error).fold(0.0, f64::max);
        let count = curve.points.len();
        let _ = writeln!(out, "\ncurve {}: {touch}{count} points, known to {worst:.0e} of the window or better", i + 1);
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
    let (orbits, spectra) = curves.iter().fold((0, 0), |(a, b), one| (a + one.evaluations, b + one.spectra));
    let _ = writeln!(out, "\n{orbits} orbits assembled, {spectra} eigenvalue problems");
    Ok(out)
}
