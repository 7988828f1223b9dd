//! `mapgen branch` and `mapgen locate` of a structure: the branch of an orbit as one of its numbers varies, with the events on it.

use std::fmt::Write as _;

use serde::Serialize;
use serde_json::Value;
use vibrochain_breather::StructureOrbit;
use vibrochain_floquet::{DiagramPoint, Event, FollowedBranch, Station, Unresolved, structure_branch};
use vibrochain_maps::files::{CsvFile, distinct};
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::structure::along::{EventEntry, Named, family};
use vibrochain_maps::structure::answer::structure;

use super::{Start, course, events_text, range, start};
use crate::args::{BranchArgs, LocateArgs, QuantityName};
#[cfg(feature = "plot")]
use crate::branch::table::{BranchName, row};
use crate::branch::table::{HEADER, write};
use crate::common::answer::{EndAnswer, printed};
use crate::common::console::{Console, nothing_else};
use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;
use crate::common::schemas::STRUCTURE_BRANCH;
use crate::locate::{ending, fields, header};
use crate::sweep::report::counted;

/// Runs `mapgen branch` for a structure.
///
/// # Errors
/// [`CliError`]; that there is no event is an answer.
pub(crate) fn branch(args: &BranchArgs, scene: &StructureScene, console: &mut Console<'_>) -> Result<(), CliError> {
    if args.switch {
        let message =
            "--switch is of chains without dashpots: of a structure take up what branches off by --word or --near";
        return Err(CliError::Request(message.to_owned()));
    }
    let files = [("--out", args.out.as_deref()), ("--plot", args.plot.as_deref())];
    let taken = distinct(&args.along.reads(), &files)?;
    nothing_else(args.json, taken)?;
    let stop = (console.interrupt)()?;
    let file = args.out.as_deref().map(|path| CsvFile::create("--out", path, HEADER)).transpose()?;
    let pictures = PictureFiles::one("--plot", args.plot.as_deref(), &args.page)?;
    let start = start(&args.along, scene)?;
    let range = range(scene, start.free, [args.along.from, args.along.to])?;
    let events = Event::ALL.into_iter().filter(|one| args.events.is_empty() || args.events.contains(one)).collect();
    let course = course(&start, range, events, args.threshold)?;
    let models = family(scene, &[start.free]);
    let found = structure_branch(&start.orbit, &models, start.value, &course, &stop)?;
    let text = if args.json { json(&start, range, &found, true)? } else { as_text(&start, &found, args.all) };
    console.answer(&text, args.json, taken)?;
    if let Some(file) = file {
        write(file, std::slice::from_ref(&found))?;
    }
    draw(pictures, &start, &found, &args.show, args.all)
}

/// Runs `mapgen locate` for a structure.
///
/// # Errors
/// [`CliError`]; that there is no event is an answer.
pub(crate) fn locate(args: &LocateArgs, scene: &StructureScene, console: &mut Console<'_>) -> Result<(), CliError> {
    let taken = distinct(&args.along.reads(), &[("--out", args.out.as_deref())])?;
    nothing_else(args.json, taken)?;
    let stop = (console.interrupt)()?;
    let start = start(&args.along, scene)?;
    let free = start.free.to_string();
    let header = header(&free);
    let table = args.out.as_deref().map(|path| CsvFile::create("--out", path, header)).transpose()?;
    let range = range(scene, start.free, [args.along.from, args.along.to])?;
    let course = course(&start, range, vec![args.event], None)?;
    let found = structure_branch(&start.orbit, &family(scene, &[start.free]), start.value, &course, &stop)?;
    let text = if args.json {
        json(&start, range, &found, false)?
    } else {
        let mut out = format!("{} of {}\n", args.event, start.heading());
        let count = found.events().count();
        let _ = match count {
            0 => writeln!(out, "\nno {} between {free} = {} and {}", args.event, range[0], range[1]),
            count => writeln!(out, "\n{}", counted(count, "event")),
        };
        let events =
            found.events().map(|event| (event, event.physical != Some(false) || event.event == Event::Grazing));
        events_text(&mut out, start.free, events, &found.unresolved, &found.ends);
        out
    };
    console.answer(&text, args.json, taken)?;
    let Some(mut table) = table else { return Ok(()) };
    found.events().try_for_each(|event| table.record(&fields(event)))?;
    Ok(table.finish()?)
}

/// The answer as JSON.
#[derive(Serialize)]
struct Answer<'a> {
    schema: &'static str,
    structure: Value,
    free: Named,
    word: &'a str,
    solution: usize,
    range: [f64; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    points: Option<Vec<&'a DiagramPoint<StructureOrbit>>>,
    events: Vec<EventEntry>,
    unresolved: &'a [Unresolved],
    ends: Vec<EndAnswer>,
}

fn json(
    start: &Start<'_>,
    range: [f64; 2],
    found: &FollowedBranch<StructureOrbit>,
    points: bool,
) -> Result<String, CliError> {
    let answer = Answer {
        schema: STRUCTURE_BRANCH,
        structure: structure(start.scene, start.orbit.model()),
        free: Named(start.free),
        word: &start.word,
        solution: start.solution,
        range,
        points: points.then(|| found.points().collect()),
        events: found.events().map(EventEntry::of).collect(),
        unresolved: &found.unresolved,
        ends: EndAnswer::of(&found.ends, |value, end| ending(&start.free.to_string(), value, end)),
    };
    printed(&answer)
}

/// The answer for people. Writing to a String cannot fail.
fn as_text(start: &Start<'_>, found: &FollowedBranch<StructureOrbit>, all: bool) -> String {
    let mut out = format!("{}\n", start.heading());
    let _ = writeln!(out, "\nbranch: {}", counted(found.points().count(), "point"));
    let stations = found.stations.iter().enumerate();
    let events: Vec<_> = stations
        .filter_map(|(at, station)| match station {
            Station::Event(event) => Some((event, found.is_physical_about(at))),
            Station::Point(_) => None,
        })
        .collect();
    let hidden = if all { 0 } else { events.iter().filter(|(_, physical)| !physical).count() };
    let shown = events.into_iter().filter(|(_, physical)| all || *physical);
    events_text(&mut out, start.free, shown, &found.unresolved, &found.ends);
    if hidden > 0 {
        let _ = writeln!(out, "  and {} of orbits that are not physical (--all lists them)", counted(hidden, "event"));
    }
    out
}

#[cfg(feature = "plot")]
fn draw(
    files: PictureFiles,
    start: &Start<'_>,
    found: &FollowedBranch<StructureOrbit>,
    show: &[QuantityName],
    all: bool,
) -> Result<(), CliError> {
    if files.is_empty() {
        return Ok(());
    }
    let names = [BranchName { name: start.word.clone(), generation: 0, force_periods: start.orbit.force_periods() }];
    let drawn = crate::branch::plot::Drawn {
        heading: start.fixed(&[start.free]),
        x: start.scene.label(start.free),
        names: &names,
        rows: &[found.stations.iter().map(row).collect()],
    };
    let picture = crate::branch::plot::picture(&drawn, show, all);
    files.draw(|page| vibrochain_plot::curves_picture(&picture, page))
}

#[cfg(not(feature = "plot"))]
fn draw(
    _: PictureFiles,
    _: &Start<'_>,
    _: &FollowedBranch<StructureOrbit>,
    _: &[QuantityName],
    _: bool,
) -> Result<(), CliError> {
    Ok(())
}
