//! `mapgen branch`: a branch of breathers as one parameter varies, with all events on it and what branches off.

pub(crate) mod table;

use std::fmt::Write as _;

use serde::Serialize;
use vibrochain_breather::{Family, Orbit};
use vibrochain_floquet::{
    Course, Diagram, DiagramPoint, End, Event, FollowedBranch, Located, Origin, Station, Unresolved, diagram_until,
};
use vibrochain_lattice::Parameter;
use vibrochain_maps::caption::describe_without;
use vibrochain_maps::files::{CsvFile, distinct};
use vibrochain_maps::followed::title;
use vibrochain_maps::numbers::Number;
use vibrochain_maps::scene::criterion;

use crate::args::{BranchArgs, QuantityName, of_orbits};
use crate::branch::table::{HEADER, Table, write};
use crate::common::answer::{EndAnswer, StartAnswer, printed};
use crate::common::console::{Console, nothing_else};
use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;
use crate::common::schemas::BRANCH;
use crate::common::table_manifest::{Manifest, beside};
use crate::locate::{Start, error_text, evidence_text, message, range, start};
use crate::structures;
use crate::sweep::report::counted;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`]; that there is no event is an answer.
pub fn run(args: &BranchArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    if let Some(scene) = structures::asked(&args.along.model)? {
        return structures::along::branch::branch(args, &scene, console);
    }
    let manifest = beside(args.out.as_deref())?;
    let files = [
        ("--out", args.out.as_deref()),
        ("the manifest of --out", manifest.as_deref()),
        ("--plot", args.plot.as_deref()),
    ];
    let taken = distinct(&args.along.reads(), &files)?;
    nothing_else(args.json, taken)?;
    let stop = (console.interrupt)()?;
    let file = args.out.as_deref().map(|path| CsvFile::create("--out", path, HEADER)).transpose()?;
    let manifest = Manifest::create(manifest.as_deref())?;
    let pictures = PictureFiles::one("--plot", args.plot.as_deref(), &args.page)?;
    let start = start(&args.along, &stop, console)?;
    if args.plot.is_some() && args.show.contains(&QuantityName::Psi) && start.orbit.model().is_conservative() {
        let message =
            "--show psi: there is no force whose phase could be shown; give impulse, phi, margin or spectral_radius";
        return Err(CliError::Request(message.to_owned()));
    }
    let mut course = Course::new(&start.orbit, args.along.free.parameter()?);
    let [from, to] = range(&start.chosen, course.free, [args.along.from, args.along.to]);
    (course.from, course.to) = (from.unwrap_or(course.from), to.unwrap_or(course.to));
    if !args.events.is_empty() {
        course.events = Event::ALL.into_iter().filter(|one| args.events.contains(one)).collect();
    }
    course.generations = if args.switch { args.generations } else { 0 };
    course.tolerance = start.chosen.tolerance(args.threshold)?;
    fits(&pictures, args, &course)?;
    let diagram = diagram_until(&start.orbit, &course, &stop)?;
    let text = if args.json {
        printed(&BranchAnswer::new(&start, &course, &diagram))?
    } else {
        as_text(&start, &course, &diagram, args.all)
    };
    console.answer(&text, args.json, taken)?;
    let fixed = describe_without(start.orbit.model(), course.free);
    let heading = format!("branches of breathers, {fixed}, {}", criterion(course.tolerance));
    let table = Table::new(course.free, heading, start.orbit.model(), &diagram);
    if let Some(file) = file {
        write(file, &diagram.branches)?;
        manifest.finish("branch", table.rows(), &table.about)?;
    }
    draw(pictures, args, &course, &table)
}

/// The orbit with which a branch begins.
fn head(branch: &FollowedBranch) -> Option<&Orbit> {
    branch.points().next().map(|point| &point.orbit)
}

/// How a branch ended, as a sentence. Doubled orbits are no mirror images of each other: begun a period later they are.
fn ending(branch: &FollowedBranch, course: &Course, value: f64, end: &End) -> String {
    let doubled = head(branch).is_some_and(|orbit| orbit.force_periods() > 1);
    if *end == End::Pitchfork && doubled {
        let free = course.free.name();
        return format!("the branch ends at {free} = {}, on orbits of half its period", Number(value));
    }
    message(course.free, value, end)
}

/// The answer as JSON.
#[derive(Serialize)]
struct BranchAnswer<'a> {
    schema: &'static str,
    free: Parameter,
    #[serde(flatten)]
    start: StartAnswer<'a>,
    range: [f64; 2],
    branches: Vec<BranchEntry<'a>>,
    dead_ends: Vec<OriginEntry>,
    complete: bool,
    evaluations: usize,
    spectra: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    word: Option<String>,
}

#[derive(Serialize)]
struct BranchEntry<'a> {
    generation: u32,
    origin: Option<OriginEntry>,
    family: Option<Family>,
    force_periods: Option<u32>,
    points: Vec<&'a DiagramPoint>,
    events: Vec<&'a Located>,
    untold: usize,
    unresolved: &'a [Unresolved],
    ends: Vec<EndAnswer>,
    #[serde(skip_serializing_if = "Option::is_none")]
    word: Option<String>,
}

/// The event at which a branch leaves another, numbered from 1.
#[derive(Serialize)]
struct OriginEntry {
    branch: usize,
    event: Option<Event>,
    value: Option<f64>,
}

impl<'a> BranchAnswer<'a> {
    fn new(start: &'a Start, course: &Course, diagram: &'a Diagram) -> Self {
        let origin = |origin: &Origin| {
            let found = event_at(diagram, origin.branch, origin.station);
            let (event, value) = (found.map(|found| found.event), found.map(|found| found.value));
            OriginEntry { branch: origin.branch + 1, event, value }
        };
        let entry = |branch: &'a FollowedBranch| BranchEntry {
            generation: branch.generation,
            origin: branch.origin.as_ref().map(origin),
            family: head(branch).map(Orbit::family),
            force_periods: head(branch).map(Orbit::force_periods),
            points: branch.points().collect(),
            events: branch.events().collect(),
            untold: branch.untold,
            unresolved: &branch.unresolved,
            ends: EndAnswer::of(&branch.ends, |value, end| ending(branch, course, value, end)),
            word: head(branch).and_then(Orbit::word),
        };
        Self {
            schema: BRANCH,
            free: course.free,
            start: start.answer(),
            range: [course.from, course.to],
            branches: diagram.branches.iter().map(entry).collect(),
            dead_ends: diagram.dead_ends.iter().map(origin).collect(),
            complete: diagram.complete,
            evaluations: diagram.evaluations,
            spectra: diagram.spectra,
            word: start.orbit.word(),
        }
    }
}

fn event_at(diagram: &Diagram, branch: usize, station: usize) -> Option<&Located> {
    match diagram.branches.get(branch)?.stations.get(station)? {
        Station::Event(located) => Some(located),
        Station::Point(_) => None,
    }
}

/// The answer for people. Writing to a String cannot fail.
fn as_text(start: &Start, course: &Course, diagram: &Diagram, all: bool) -> String {
    let free = course.free.name();
    let mut out = String::new();
    let _ = writeln!(out, "{}", start.heading(course.free));
    for (i, branch) in diagram.branches.iter().enumerate() {
        let _ = write!(out, "\nbranch {}", i + 1);
        if let Some(origin) = branch.origin
            && let Some(found) = event_at(diagram, origin.branch, origin.station)
        {
            let _ = write!(
                out,
                ", {}, leaves branch {} at {free} = {} ({})",
                branch.points().next().map_or_else(String::new, |point| title(&point.orbit)),
                origin.branch + 1,
                Number(found.value),
                found.event
            );
        }
        let _ = writeln!(out, ": {}", counted(branch.points().count(), "point"));
        let mut hidden = 0;
        for (station, found) in branch.stations.iter().enumerate() {
            let Station::Event(found) = found else { continue };
            if !all && !branch.is_physical_about(station) {
                hidden += 1;
                continue;
            }
            let aside = if branch.is_physical_about(station) { "" } else { "; not physical" };
            let _ = writeln!(
                out,
                "  {free} = {} {}  {}: {}{aside}",
                Number(found.value),
                error_text(found),
                found.event,
                evidence_text(found)
            );
        }
        if hidden > 0 {
            let events = if hidden == 1 { "event" } else { "events" };
            let _ = writeln!(out, "  and {hidden} {events} of orbits that are not physical (--all lists them)");
        }
        for place in &branch.unresolved {
            let (from, to) = (Number(place.from), Number(place.to));
            let _ = writeln!(out, "  between {free} = {from} and {to} a sign of more that rounding hides");
        }
        for (value, end) in &branch.ends {
            let _ = writeln!(out, "  end: {}", ending(branch, course, *value, end));
        }
    }
    for origin in &diagram.dead_ends {
        let Some(found) = event_at(diagram, origin.branch, origin.station) else { continue };
        let _ = writeln!(
            out,
            "\nno branch was found to leave branch {} at {free} = {} ({})",
            origin.branch + 1,
            Number(found.value),
            found.event
        );
    }
    if !diagram.complete {
        let _ = writeln!(out, "\nmore branches leave these than are followed ({})", diagram.branches.len());
    }
    let untold: usize = diagram.branches.iter().map(|branch| branch.untold).sum();
    if untold > 0 {
        let steps = if untold == 1 { "step" } else { "steps" };
        let _ = writeln!(
            out,
            "\nin {untold} {steps} stripes thinner than the step may be missing: Krein signatures, which tell of them, are not known there"
        );
    }
    let _ = writeln!(out, "\n{} orbits assembled, {} eigenvalue problems", diagram.evaluations, diagram.spectra);
    out
}

/// The picture of a table.
pub(crate) fn picture(table: &Table, free: Parameter, shown: &[QuantityName], all: bool) -> vibrochain_plot::Curves {
    let Table { about, branches } = table;
    let (heading, x) = (about.heading.clone(), format!("{} {}", free.meaning(), free.symbol()));
    let diagram = vibrochain_plot::Diagram { heading, x, names: &about.branches, rows: branches };
    vibrochain_plot::diagram_curves(&diagram, &of_orbits(shown), all)
}

fn draw(files: PictureFiles, args: &BranchArgs, course: &Course, table: &Table) -> Result<(), CliError> {
    if files.is_empty() {
        return Ok(());
    }
    let picture = picture(table, course.free, &args.show, args.all);
    files.draw(|page| vibrochain_plot::curves_picture(&picture, page))
}

/// Makes sure that the picture can be made.
fn fits(files: &PictureFiles, args: &BranchArgs, course: &Course) -> Result<(), CliError> {
    let about = crate::branch::table::About {
        free: course.free,
        heading: String::new(),
        parameters: serde_json::Value::Null,
        branches: Vec::new(),
    };
    let nothing = Table { about, branches: Vec::new() };
    let picture = picture(&nothing, course.free, &args.show, args.all);
    files.fit(|page| vibrochain_plot::curves_picture(&picture, page))
}
