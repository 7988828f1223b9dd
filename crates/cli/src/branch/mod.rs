//! `mapgen branch`: a branch of orbits as one number varies, with all events on it and what branches off.

pub(crate) mod table;

use std::fmt::Write as _;

use serde_json::{Map, Value, json};
use vibrochain_breather::Orbit;
use vibrochain_floquet::{BranchRequest, Diagram, Event, FollowedBranch, Origin, Station};
use vibrochain_maps::followed::{BranchName, BranchRow, branch_row, title};
use vibrochain_plot::curves_picture;

use crate::along::{
    self, Along, ChainAlong, FIRST, Outputs, StructureAlong, Wanted, answer, checked_range, ending, ends,
    evidence_text, value_text,
};
use crate::args::{BranchArgs, QuantityName, of_orbits};
use crate::branch::table::{About, HEADER, write};
use crate::common::answer::printed;
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::schemas::{BRANCH, STRUCTURE_BRANCH};
use crate::structures;
use crate::sweep::report::counted;
use vibrochain_maps::manifest::object;
use vibrochain_maps::numbers::Number;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`]; that there is no event is an answer.
pub fn run(args: &BranchArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    match structures::asked(&args.along.model)? {
        Some(scene) => follow::<StructureAlong>(args, scene, console),
        None => follow::<ChainAlong>(args, (), console),
    }
}

fn follow<A: Along>(args: &BranchArgs, scene: A::Scene, console: &mut Console<'_>) -> Result<(), CliError> {
    let BranchArgs { along, json, out, plot, page, .. } = args;
    let wanted = Wanted { along, json: *json, out: out.as_deref(), plot: plot.as_deref(), page };
    let outputs = Outputs::open::<A>(&wanted, HEADER.split(','), console)?;
    let Outputs { taken, stop, file, manifest, pictures } = outputs;
    let free = A::free(&args.along.free)?;
    let along = A::begin(&args.along, scene, &stop, console)?;
    ensure!(
        args.plot.is_none() || !args.show.contains(&QuantityName::Psi) || !along.start().orbit.is_conservative(),
        "--show psi: there is no force whose phase could be shown; give impulse, phi, margin or spectral_radius"
    );
    let [from, to] = checked_range(&along, free, FIRST, [args.along.from, args.along.to])?;
    let events = Event::ALL.into_iter().filter(|one| args.events.is_empty() || args.events.contains(one)).collect();
    let generations = if args.switch { args.generations } else { 0 };
    let course = BranchRequest { from, to, events, generations, tolerance: along.tolerance(args.threshold)? };
    let label = along.label(free);
    let nothing = drawn((String::new(), label.clone()), (&[], &[]), &args.show, args.all);
    pictures.fit(|page| curves_picture(&nothing, page))?;
    let diagram = along.diagram(free, &course, &stop)?;
    let name = A::name(free);
    let text = if args.json {
        printed(&json_of(&along, &name, args.switch, &course, &diagram))?
    } else {
        as_text::<A>(along.heading(free)?, &name, &diagram, args.all)
    };
    console.answer(&text, args.json, taken)?;
    let heading = along.over_branches(free, course.tolerance);
    let named = |branch: &FollowedBranch| BranchName {
        name: head(branch).map_or_else(String::new, title),
        generation: branch.generation,
        force_periods: periods(branch),
    };
    let names: Vec<BranchName> = diagram.branches.iter().map(named).collect();
    let rows = |branch: &FollowedBranch| branch.stations.iter().map(branch_row).collect();
    let rows: Vec<Vec<BranchRow>> = diagram.branches.iter().map(rows).collect();
    if let Some(file) = file {
        write(file, &diagram.branches)?;
        let count: usize = rows.iter().map(Vec::len).sum();
        let parameters = along.head().remove("parameters").unwrap_or_default();
        let about = About { free: &name, heading: heading.clone(), parameters, branches: names.clone() };
        manifest.finish("branch", count as u64, &about)?;
    }
    if pictures.is_empty() {
        return Ok(());
    }
    let picture = drawn((heading, label), (&names, &rows), &args.show, args.all);
    pictures.draw(|page| curves_picture(&picture, page))
}

/// The orbit with which a branch begins.
fn head(branch: &FollowedBranch) -> Option<&Orbit> {
    branch.points().next().map(|point| &point.orbit)
}

/// Periods of the force in one of its orbits'.
fn periods(branch: &FollowedBranch) -> u32 {
    head(branch).map_or(1, Orbit::force_periods)
}

/// The event at which a branch leaves another, numbered from 1, as JSON has it.
fn origin(diagram: &Diagram, origin: Origin) -> Value {
    let found = diagram.event_at(origin);
    let (event, value) = (found.map(|found| found.event), found.map(|found| found.value));
    json!({ "branch": origin.branch + 1, "event": event, "value": value })
}

/// What is on a branch, as JSON has it.
fn on_branch<A: Along>(free: &str, branch: &FollowedBranch) -> Map<String, Value> {
    object([
        ("points", json!(branch.points().collect::<Vec<_>>())),
        ("events", branch.events().map(along::event).collect()),
        ("unresolved", json!(branch.unresolved)),
        ("ends", ends(free, &branch.ends)),
    ])
}

/// A branch, as JSON has it.
fn entry<A: Along>(free: &str, diagram: &Diagram, branch: &FollowedBranch) -> Map<String, Value> {
    let mut told = object([
        ("generation", json!(branch.generation)),
        ("origin", branch.origin.map_or(Value::Null, |from| origin(diagram, from))),
        ("force_periods", json!(periods(branch))),
    ]);
    told.extend(head(branch).map(along::kind).into_iter().flatten());
    told.extend(on_branch::<A>(free, branch));
    told.extend(A::OF_CHAINS.then(|| ("untold".to_owned(), json!(branch.untold))));
    told
}

/// The answer as JSON. Of a structure the branch of the start stands outside the list.
fn json_of<A: Along>(
    along: &A,
    free: &str,
    switch: bool,
    course: &BranchRequest,
    diagram: &Diagram,
) -> Map<String, Value> {
    let schema = if A::OF_CHAINS { BRANCH } else { STRUCTURE_BRANCH };
    let mut told = answer(along, schema, json!(free));
    told.insert("range".to_owned(), json!([course.from, course.to]));
    if !A::OF_CHAINS {
        told.extend(on_branch::<A>(free, &diagram.branches[0]));
    }
    if A::OF_CHAINS || switch {
        let listed = diagram.branches.iter().skip(usize::from(!A::OF_CHAINS));
        told.extend(object([
            ("branches", listed.map(|branch| entry::<A>(free, diagram, branch)).collect()),
            ("dead_ends", diagram.dead_ends.iter().map(|from| origin(diagram, *from)).collect()),
            ("complete", json!(diagram.complete)),
        ]));
    }
    if A::OF_CHAINS {
        let Diagram { evaluations, spectra, .. } = diagram;
        told.extend(object([("evaluations", json!(evaluations)), ("spectra", json!(spectra))]));
    }
    told
}

/// The answer for people. Writing to a String cannot fail.
fn as_text<A: Along>(heading: String, free: &str, diagram: &Diagram, all: bool) -> String {
    let left = |from: Origin| {
        let found = diagram.event_at(from)?;
        Some(format!("branch {} at {free} = {} ({})", from.branch + 1, Number(found.value), found.event))
    };
    let mut out = heading + "\n";
    for (branch, number) in diagram.branches.iter().zip(1..) {
        let _ = write!(out, "\nbranch {number}");
        if let Some(left) = branch.origin.and_then(left) {
            let _ = write!(out, ", {}, leaves {left}", head(branch).map_or_else(String::new, title));
        }
        let _ = writeln!(out, ": {}", counted(branch.points().count(), "point"));
        let mut hidden = 0;
        for (station, found) in branch.stations.iter().enumerate() {
            let Station::Event(found) = found else { continue };
            let is_physical = branch.is_physical_about(station);
            if !all && !is_physical {
                hidden += 1;
                continue;
            }
            let aside = if is_physical { "" } else { "; not physical" };
            let (value, evidence) = (value_text(free, found), evidence_text(found));
            let _ = writeln!(out, "  {value}  {}: {evidence}{aside}", found.event);
        }
        if hidden > 0 {
            let hidden = counted(hidden, "event");
            let _ = writeln!(out, "  and {hidden} of orbits that are not physical (--all lists them)");
        }
        for place in &branch.unresolved {
            let (from, to) = (Number(place.from), Number(place.to));
            let _ = writeln!(out, "  between {free} = {from} and {to} a sign of more that rounding hides");
        }
        for (value, end) in &branch.ends {
            let _ = writeln!(out, "  end: {}", ending(free, *value, end));
        }
    }
    for left in diagram.dead_ends.iter().filter_map(|from| left(*from)) {
        let _ = writeln!(out, "\nno branch was found to leave {left}");
    }
    if !diagram.complete {
        let _ = writeln!(out, "\nmore branches leave these than are followed ({})", diagram.branches.len());
    }
    let untold: usize = diagram.branches.iter().map(|branch| branch.untold).sum();
    if untold > 0 {
        let _ = writeln!(
            out,
            "\nin {} stripes thinner than the step may be missing: neither Krein signatures nor, with losses, slopes of multipliers tell of them there",
            counted(untold, "step")
        );
    }
    let _ = writeln!(out, "\n{} orbits assembled, {} eigenvalue problems", diagram.evaluations, diagram.spectra);
    out
}

/// The picture of branches under a heading, over what stands at its axis.
pub(crate) fn drawn(
    (heading, x): (String, String),
    (names, rows): (&[BranchName], &[Vec<BranchRow>]),
    shown: &[QuantityName],
    all: bool,
) -> vibrochain_plot::Curves {
    vibrochain_plot::diagram_curves(&vibrochain_plot::Diagram { heading, x, names, rows }, &of_orbits(shown), all)
}
