//! `mapgen branch` and `mapgen locate` of a structure: the branch of an orbit as one of its numbers varies, with the events on it.

use std::fmt::Write as _;

use serde::Serialize;
use serde_json::Value;
use vibrochain_breather::StructureOrbit;
use vibrochain_floquet::{
    Diagram, DiagramPoint, End, Event, FollowedBranch, Origin, Station, Unresolved, structure_branch, structure_diagram,
};
use vibrochain_maps::files::{CsvFile, distinct};
use vibrochain_maps::followed::{BranchName, branch_row};
use vibrochain_maps::numbers::Number;
use vibrochain_maps::structure::along::{EventEntry, Named, family};
use vibrochain_maps::structure::answer::structure;
use vibrochain_maps::structure::{Setting, StructureScene};

use super::{Start, course, events_text, range, start};
use crate::args::{BranchArgs, LocateArgs, QuantityName, of_orbits};
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
    let files = [("--out", args.out.as_deref()), ("--plot", args.plot.as_deref())];
    let taken = distinct(&args.along.reads(), &files)?;
    nothing_else(args.json, taken)?;
    let stop = (console.interrupt)()?;
    let file = args.out.as_deref().map(|path| CsvFile::create("--out", path, HEADER)).transpose()?;
    let pictures = PictureFiles::one("--plot", args.plot.as_deref(), &args.page)?;
    let start = start(&args.along, scene)?;
    let range = range(scene, start.free, [args.along.from, args.along.to])?;
    let events = Event::ALL.into_iter().filter(|one| args.events.is_empty() || args.events.contains(one)).collect();
    let mut course = course(&start, range, events, args.threshold)?;
    course.generations = if args.switch { args.generations } else { 0 };
    let models = family(scene, &[start.free]);
    let found = structure_diagram(&start.orbit, &models, start.value, &course, &stop)?;
    let text = if args.json {
        let leaving = args.switch.then(|| Leaving::of(start.free, &found));
        json(&start, range, &found.branches[0], true, leaving)?
    } else {
        as_text(&start, &found, args.all)
    };
    console.answer(&text, args.json, taken)?;
    if let Some(file) = file {
        write(file, &found.branches)?;
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
        json(&start, range, &found, false, None)?
    } else {
        let mut out = format!("{} of {}\n", args.event, start.heading());
        let count = found.events().count();
        let _ = match count {
            0 => writeln!(out, "\nno {} between {free} = {} and {}", args.event, range[0], range[1]),
            count => writeln!(out, "\n{}", counted(count, "event")),
        };
        let events =
            found.events().map(|event| (event, event.physical != Some(false) || event.event == Event::Grazing));
        let ends: Vec<String> =
            found.ends.iter().map(|(value, end)| ending_of(start.free, &found, *value, end)).collect();
        events_text(&mut out, start.free, events, &found.unresolved, &ends);
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
    #[serde(flatten)]
    leaving: Option<Leaving<'a>>,
}

/// The branches that leave that of the start, and each other.
#[derive(Serialize)]
struct Leaving<'a> {
    branches: Vec<BranchEntry<'a>>,
    dead_ends: Vec<OriginEntry>,
    complete: bool,
}

#[derive(Serialize)]
struct BranchEntry<'a> {
    generation: u32,
    origin: Option<OriginEntry>,
    word: String,
    force_periods: u32,
    points: Vec<&'a DiagramPoint<StructureOrbit>>,
    events: Vec<EventEntry>,
    unresolved: &'a [Unresolved],
    ends: Vec<EndAnswer>,
}

/// The event at which a branch leaves another, numbered from 1.
#[derive(Serialize)]
struct OriginEntry {
    branch: usize,
    event: Option<Event>,
    value: Option<f64>,
}

/// The first orbit of a branch.
fn head(branch: &FollowedBranch<StructureOrbit>) -> Option<&StructureOrbit> {
    branch.points().next().map(|point| &point.orbit)
}

/// How a branch ended. Orbits of several periods of the load that come to be their own images repeat themselves sooner.
fn ending_of(free: Setting, branch: &FollowedBranch<StructureOrbit>, value: f64, end: &End) -> String {
    if *end == End::Pitchfork && head(branch).is_some_and(|orbit| orbit.force_periods() > 1) {
        return format!("the branch ends at {free} = {}, on orbits of half its period", Number(value));
    }
    ending(&free.to_string(), value, end)
}

impl<'a> Leaving<'a> {
    fn of(free: Setting, found: &'a Diagram<StructureOrbit>) -> Self {
        let origin = |origin: &Origin| {
            let at = found.event_at(*origin);
            OriginEntry {
                branch: origin.branch + 1,
                event: at.map(|event| event.event),
                value: at.map(|event| event.value),
            }
        };
        let entry = |branch: &'a FollowedBranch<StructureOrbit>| BranchEntry {
            generation: branch.generation,
            origin: branch.origin.as_ref().map(origin),
            word: head(branch).map_or(String::new(), StructureOrbit::word),
            force_periods: head(branch).map_or(1, StructureOrbit::force_periods),
            points: branch.points().collect(),
            events: branch.events().map(EventEntry::of).collect(),
            unresolved: &branch.unresolved,
            ends: EndAnswer::of(&branch.ends, |value, end| ending_of(free, branch, value, end)),
        };
        Self {
            branches: found.branches.iter().skip(1).map(entry).collect(),
            dead_ends: found.dead_ends.iter().map(origin).collect(),
            complete: found.complete,
        }
    }
}

fn json(
    start: &Start<'_>,
    range: [f64; 2],
    found: &FollowedBranch<StructureOrbit>,
    points: bool,
    leaving: Option<Leaving<'_>>,
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
        ends: EndAnswer::of(&found.ends, |value, end| ending_of(start.free, found, value, end)),
        leaving,
    };
    printed(&answer)
}

/// The answer for people. Writing to a String cannot fail.
fn as_text(start: &Start<'_>, found: &Diagram<StructureOrbit>, all: bool) -> String {
    let free = start.free;
    let mut out = format!("{}\n", start.heading());
    for (number, branch) in found.branches.iter().enumerate() {
        let _ = write!(out, "\nbranch");
        if found.branches.len() > 1 {
            let _ = write!(out, " {}", number + 1);
        }
        if let Some(origin) = branch.origin
            && let (Some(at), Some(orbit)) = (found.event_at(origin), head(branch))
        {
            let (name, value) = (orbit.name(), Number(at.value));
            let _ = write!(out, ", {name}, leaves branch {} at {free} = {value} ({})", origin.branch + 1, at.event);
        }
        let _ = writeln!(out, ": {}", counted(branch.points().count(), "point"));
        let stations = branch.stations.iter().enumerate();
        let events: Vec<_> = stations
            .filter_map(|(at, station)| match station {
                Station::Event(event) => Some((event, branch.is_physical_about(at))),
                Station::Point(_) => None,
            })
            .collect();
        let hidden = if all { 0 } else { events.iter().filter(|(_, physical)| !physical).count() };
        let shown = events.into_iter().filter(|(_, physical)| all || *physical);
        let ends: Vec<String> = branch.ends.iter().map(|(value, end)| ending_of(free, branch, *value, end)).collect();
        events_text(&mut out, free, shown, &branch.unresolved, &ends);
        if hidden > 0 {
            let _ =
                writeln!(out, "  and {} of orbits that are not physical (--all lists them)", counted(hidden, "event"));
        }
    }
    for origin in &found.dead_ends {
        if let Some(at) = found.event_at(*origin) {
            let (branch, value) = (origin.branch + 1, Number(at.value));
            let _ = writeln!(out, "\nno branch was found to leave branch {branch} at {free} = {value} ({})", at.event);
        }
    }
    if !found.complete {
        let _ = writeln!(out, "\nmore branches leave these than are followed ({})", found.branches.len());
    }
    out
}

fn draw(
    files: PictureFiles,
    start: &Start<'_>,
    found: &Diagram<StructureOrbit>,
    show: &[QuantityName],
    all: bool,
) -> Result<(), CliError> {
    if files.is_empty() {
        return Ok(());
    }
    let name = |branch: &FollowedBranch<StructureOrbit>| BranchName {
        name: head(branch).map_or(String::new(), StructureOrbit::name),
        generation: branch.generation,
        force_periods: head(branch).map_or(1, StructureOrbit::force_periods),
    };
    let names: Vec<BranchName> = found.branches.iter().map(name).collect();
    let rows: Vec<Vec<_>> =
        found.branches.iter().map(|branch| branch.stations.iter().map(branch_row).collect()).collect();
    let drawn = vibrochain_plot::Diagram {
        heading: start.fixed(&[start.free]),
        x: start.scene.label(start.free),
        names: &names,
        rows: &rows,
    };
    let picture = vibrochain_plot::diagram_curves(&drawn, &of_orbits(show), all);
    files.draw(|page| vibrochain_plot::curves_picture(&picture, page))
}
