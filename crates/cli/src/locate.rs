//! `mapgen locate`: where an orbit bifurcates or grazes as one number varies.

use std::fmt::Write as _;

use serde::Serialize;
use serde_json::{Map, Value, json};
use vibrochain_floquet::{BranchedOrbit, Event, Evidence, Located, Verdict};
use vibrochain_maps::files::CsvFile;
use vibrochain_maps::numbers::Number;

use crate::along::{
    self, Along, ChainAlong, Events, FIRST, StructureAlong, answer, checked_range, ending, ends, evidence_text,
    value_text,
};
use crate::args::LocateArgs;
use crate::common::answer::printed;
use crate::common::console::{Console, destinations};
use crate::common::error::CliError;
use crate::common::schemas::{LOCATE, STRUCTURE_BRANCH};
use crate::structures;
use crate::sweep::report::counted;
use vibrochain_maps::manifest::object;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`]; that there is no event is an answer.
pub fn run(args: &LocateArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    match structures::asked(&args.along.model)? {
        Some(scene) => locate::<StructureAlong>(args, scene, console),
        None => locate::<ChainAlong>(args, (), console),
    }
}

fn locate<A: Along>(args: &LocateArgs, scene: A::Scene, console: &mut Console<'_>) -> Result<(), CliError> {
    let taken = destinations(args.json, &args.along.reads(), &[("--out", args.out.as_deref())])?;
    let free = A::free(&args.along.free)?;
    let name = A::name(free);
    let stop = (console.interrupt)()?;
    let table = args.out.as_deref().map(|path| CsvFile::create("--out", path, header(&name))).transpose()?;
    let along = A::begin(&args.along, scene, &stop, console)?;
    let range = checked_range(&along, free, FIRST, [args.along.from, args.along.to])?;
    let mut found = along.located(args.event, free, range, &stop)?;
    found.located.sort_by(|one, other| one.value.total_cmp(&other.value));
    let text = if args.json {
        printed(&json_of(&along, args.event, &name, range, &found))?
    } else {
        as_text(&along, args.event, free, &found)?
    };
    console.answer(&text, args.json, taken)?;
    let Some(mut table) = table else { return Ok(()) };
    found.located.iter().try_for_each(|found| table.record(&fields(found)))?;
    Ok(table.finish()?)
}

/// The names of the columns where this varies.
fn header(free: &str) -> [&str; 9] {
    ["event", free, "error", "impulses", "phi", "psi", "period", "physical", "multiplier"]
}

/// A row of the table.
fn fields(found: &Located) -> impl Serialize + use<> {
    let (orbit, multiplier) = (
        &found.orbit,
        match found.evidence {
            Evidence::Multiplier(mu) => Some([mu.re, mu.im]),
            Evidence::Touch(_) | Evidence::Impact(_) => None,
        },
    );
    let (phi, psi, period) = (orbit.phi(), orbit.psi(), orbit.period());
    (found.event, found.value, found.error, orbit.impulses(), phi, psi, period, found.physical, multiplier)
}

/// The answer as JSON.
fn json_of<A: Along>(along: &A, event: Event, free: &str, range: [f64; 2], found: &Events) -> Map<String, Value> {
    let mut told = answer(along, if A::OF_CHAINS { LOCATE } else { STRUCTURE_BRANCH }, json!(free));
    told.extend(object([
        ("range", json!(range)),
        (if A::OF_CHAINS { "points" } else { "events" }, found.located.iter().map(along::event).collect()),
        ("unresolved", json!(found.unresolved)),
        ("ends", ends(free, &found.ends)),
    ]));
    if A::OF_CHAINS {
        let [evaluations, spectra] = found.counts.map(|count| json!(count));
        told.extend(object([("event", json!(event)), ("evaluations", evaluations), ("spectra", spectra)]));
    }
    told
}

/// The answer for people. Writing to a String cannot fail.
fn as_text<A: Along>(along: &A, event: Event, free: A::Free, found: &Events) -> Result<String, CliError> {
    let name = A::name(free);
    let mut out = format!("{event} of {}\n", along.heading(free)?);
    let count = found.located.len();
    if count > 0 {
        let _ = writeln!(out, "{}{}", counted(count, "event"), if count > 1 { ", along the parameter" } else { "" });
    }
    for one in &found.located {
        located_text(&mut out, &name, one);
    }
    for place in &found.unresolved {
        let (from, to) = (Number(place.from), Number(place.to));
        let _ =
            writeln!(out, "\na sign of one between {name} = {from} and {to}: rounding hides where, none is claimed");
    }
    if let ([], [], [(down, _), (up, _), ..]) = (&found.located[..], &found.unresolved[..], &found.ends[..]) {
        let _ = writeln!(out, "\nno {event} between {name} = {} and {}", Number(*down), Number(*up));
    }
    let _ = writeln!(out);
    for (direction, (value, end)) in ["down", "up"].into_iter().zip(&found.ends) {
        let _ = writeln!(out, "{direction}: {}", ending(&name, *value, end));
    }
    let [evaluations, spectra] = found.counts;
    let _ = writeln!(out, "{evaluations} orbits assembled, {spectra} eigenvalue problems");
    Ok(out)
}

fn located_text(out: &mut String, name: &str, found: &Located) {
    let _ = writeln!(out, "\n{}", value_text(name, found));
    let _ = writeln!(out, "  {}", evidence_text(found));
    let _ = writeln!(out, "  {}", found.orbit);
    if found.physical == Some(false) && matches!(found.evidence, Evidence::Multiplier(_)) {
        let _ = writeln!(out, "  not physical there");
    }
    for side in &found.sides {
        let _ = writeln!(out, "  at {name} = {}: {side}", Number(side.value));
    }
    if let Some(branching) = &found.branching {
        let which = if branching.orbits.len() == 1 { "the doubled orbit" } else { "the asymmetric pair" };
        let side = if branching.above { "above" } else { "below" };
        let _ = writeln!(out, "  {which} exists {side} it; at {name} = {}:", Number(branching.value));
        branching.orbits.iter().for_each(|branched| branched_text(out, branched));
    }
}

fn branched_text(out: &mut String, branched: &BranchedOrbit) {
    let _ = writeln!(out, "    {}", branched.orbit);
    let physical = match branched.physical {
        Some(true) => "physical",
        Some(false) => "not physical",
        None => "not checked",
    };
    let stability = branched.verdict.as_ref().map_or("stability unknown".to_owned(), Verdict::to_string);
    let _ = writeln!(out, "    {physical}, {stability}");
}
