//! The picture of a bifurcation diagram: a quantity of the orbits against the parameter, a panel each.

use vibrochain_breather::Orbit;
use vibrochain_floquet::{Course, Diagram, DiagramPoint, Event, FollowedBranch, Station, Verdict};
use vibrochain_maps::files::Output;
use vibrochain_plot::{Curves, Mark, Page, Pane, Scale, Series, Stroke, curves_picture};

use crate::args::{BranchArgs, QuantityName};
use crate::caption::describe_without;
use crate::error::CliError;
use crate::locate_command::Start;
use crate::which::of_branch as name;

/// Colours of generations of branches, by turns; the last but one marks events, the last what is not physical.
const COLOURS: usize = 4;
const EVENTS: usize = 4;
const GREY: usize = 5;

/// More events than this have small marks.
const CROWD: usize = 40;

/// Multipliers drawn by logarithms leave the picture here.
const HIGHEST: f64 = 1e5;

/// A picture under way.
pub(crate) struct Plot {
    file: Option<(Page, Output)>,
    shown: Vec<QuantityName>,
    all: bool,
}

impl Plot {
    pub(crate) fn open(args: &BranchArgs) -> Result<Self, CliError> {
        Ok(Self { file: args.page.open("--plot", args.plot.as_deref())?, shown: args.show.clone(), all: args.all })
    }

    pub(crate) fn finish(self, start: &Start, course: &Course, diagram: &Diagram) -> Result<(), CliError> {
        let Some((page, file)) = self.file else { return Ok(()) };
        let panes: Vec<Pane> = self.shown.iter().map(|quantity| pane(*quantity, self.all, course, diagram)).collect();
        let title = format!("branches of breathers, {}", describe_without(start.orbit.model(), course.free));
        let picture = Curves { title, columns: panes.len().min(2), panes, pane: (860, 620), ..Curves::default() };
        let bytes = curves_picture(&picture, page).map_err(|error| CliError::Computation(error.to_string()))?;
        Ok(file.finish_with(&bytes)?)
    }
}

fn label(quantity: QuantityName) -> &'static str {
    match quantity {
        QuantityName::Impulse => "impulses |P|",
        QuantityName::Phi => "φ / T",
        QuantityName::Psi => "ψ / T",
        QuantityName::Margin => "smallest distance to a barrier",
        QuantityName::SpectralRadius => "largest |μ|",
    }
}

/// The quantity's values: one, or one for each impact.
fn values(quantity: QuantityName, orbit: &Orbit, point: Option<&DiagramPoint>) -> Vec<f64> {
    let one = |value: Option<f64>| vec![value.unwrap_or(f64::NAN)];
    match quantity {
        QuantityName::Impulse => orbit.impacts().iter().map(|impact| impact.impulse.abs()).collect(),
        QuantityName::Phi => one(orbit.phi().map(|phi| phi / orbit.period())),
        QuantityName::Psi => one(orbit.psi().map(|psi| psi / orbit.model().period())),
        QuantityName::Margin => one(point.and_then(|point| point.margin)),
        QuantityName::SpectralRadius => one(point.and_then(|point| Some(point.verdict?.spectral_radius))),
    }
}

/// How an orbit is drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Stable,
    Unstable,
    NotPhysical,
}

fn kind(point: &DiagramPoint) -> Kind {
    match (point.physical, point.verdict.as_ref()) {
        (Some(true), Some(Verdict { stable: true, .. })) => Kind::Stable,
        (Some(true), _) => Kind::Unstable,
        _ => Kind::NotPhysical,
    }
}

/// What the branches of a generation are called.
fn title(generation: u32, branches: &[&FollowedBranch], taken: &[Series]) -> String {
    let origin = if generation < 2 { "it" } else { "these" };
    match branches {
        [branch] => {
            let name = name(branch);
            if taken.iter().any(|series| series.name == name) { format!("{name}, leaves {origin}") } else { name }
        }
        branches => format!("{} branches that leave {origin}", branches.len()),
    }
}

fn pane(quantity: QuantityName, all: bool, course: &Course, diagram: &Diagram) -> Pane {
    let mut series: Vec<Series> = Vec::new();
    let plain = |name: &str, colour, stroke| Series {
        name: name.to_owned(),
        colour,
        stroke,
        mark: Mark::None,
        points: Vec::new(),
    };
    for generation in 0..=diagram.branches.iter().map(|branch| branch.generation).max().unwrap_or(0) {
        let colour = generation as usize % COLOURS;
        let of_it: Vec<&FollowedBranch> = diagram.branches.iter().filter(|one| one.generation == generation).collect();
        let title = title(generation, &of_it, &series);
        series.push(plain(&title, colour, Stroke::Solid(3)));
        series.extend(of_it.into_iter().flat_map(|branch| curves(quantity, colour, branch, all)));
    }
    let used =
        |wanted: Kind| diagram.branches.iter().flat_map(FollowedBranch::points).any(|point| kind(point) == wanted);
    if used(Kind::Unstable) {
        series.push(plain("unstable", GREY, Stroke::Dashed(2)));
    }
    if all && used(Kind::NotPhysical) {
        series.push(plain("not physical", GREY, Stroke::Solid(1)));
    }
    let count: usize = diagram.branches.iter().map(|branch| branch.events().count()).sum();
    let mark = if count > CROWD { Mark::Small } else { Mark::Filled };
    series.extend(
        Event::ALL.into_iter().enumerate().filter_map(|(shape, event)| events(quantity, event, mark(shape), diagram)),
    );
    let (scale, levels) = match quantity {
        QuantityName::SpectralRadius => (Scale::about_one(&series), vec![1.0]),
        _ => (Scale::Linear, Vec::new()),
    };
    if matches!(scale, Scale::Logarithmic) {
        let points = series.iter_mut().flat_map(|series| &mut series.points);
        points.filter(|point| point.1 > HIGHEST).for_each(|point| point.1 = f64::NAN);
    }
    Pane {
        caption: String::new(),
        x: format!("{} {}", course.free.meaning(), course.free.symbol()),
        y: label(quantity).to_owned(),
        x_range: None,
        x_log: false,
        scale,
        levels,
        round: false,
        series,
    }
}

/// The quantity at a station of a branch: what only points know of an event is 1 or between its neighbours.
fn heights(quantity: QuantityName, branch: &FollowedBranch, at: usize) -> Vec<f64> {
    let found = match &branch.stations[at] {
        Station::Point(point) => return values(quantity, &point.orbit, Some(point)),
        Station::Event(found) => found,
    };
    let known = values(quantity, &found.orbit, None);
    if known.iter().all(|value| value.is_finite()) {
        return known;
    }
    let (before, behind) = branch.stations.split_at(at);
    let near = |station: &Station| match station {
        Station::Point(point) => Some(point.clone()),
        Station::Event(_) => None,
    };
    let (before, behind) = (before.iter().rev().find_map(near), behind.iter().find_map(near));
    let stable = |point: &Option<DiagramPoint>| point.as_ref().is_some_and(|point| kind(point) == Kind::Stable);
    // Next to stable orbits it is the leading multiplier that is on the circle.
    if quantity == QuantityName::SpectralRadius && found.event != Event::Grazing && (stable(&before) || stable(&behind))
    {
        return vec![1.0];
    }
    let told = |point: DiagramPoint| (point.value, values(quantity, &point.orbit, Some(&point)));
    match (before.map(told), behind.map(told)) {
        (Some((low, from)), Some((high, to))) if low != high => {
            let share = ((found.value - low) / (high - low)).clamp(0.0, 1.0);
            from.iter().zip(&to).map(|(from, to)| from + share * (to - from)).collect()
        }
        (one, other) => one.or(other).map(|(_, values)| values).unwrap_or_default(),
    }
}

/// The curves of a branch: of each impact where impulses are asked for, cut where the kind of orbit changes.
fn curves(quantity: QuantityName, colour: usize, branch: &FollowedBranch, all: bool) -> Vec<Series> {
    let place = |at: usize| match &branch.stations[at] {
        Station::Point(point) => (point.value, Some(kind(point))),
        Station::Event(found) => (found.value, None),
    };
    let passed: Vec<(_, Vec<f64>)> =
        (0..branch.stations.len()).map(|at| (place(at), heights(quantity, branch, at))).collect();
    let count = passed.first().map_or(0, |(_, values)| values.len());
    let styles = [
        (Kind::NotPhysical, GREY, Stroke::Solid(1)),
        (Kind::Unstable, colour, Stroke::Dashed(2)),
        (Kind::Stable, colour, Stroke::Solid(3)),
    ];
    // Of a piece between two events the orbits next to it tell; that is no longer than a stripe.
    let mut last = None;
    let kinds: Vec<Option<Kind>> = passed
        .windows(2)
        .map(|pair| {
            last = pair[1].0.1.or(pair[0].0.1).or(last);
            last
        })
        .collect();
    let mut series = Vec::new();
    for (wanted, colour, stroke) in styles.into_iter().filter(|(wanted, ..)| all || *wanted != Kind::NotPhysical) {
        for i in 0..count {
            let mut drawn: Vec<(f64, f64)> = Vec::new();
            for (pair, kind) in passed.windows(2).zip(&kinds) {
                if *kind != Some(wanted) {
                    if drawn.last().is_some_and(|last| last.0.is_finite()) {
                        drawn.push((f64::NAN, f64::NAN));
                    }
                    continue;
                }
                let [from, to] =
                    [&pair[0], &pair[1]].map(|(place, values)| (place.0, values.get(i).copied().unwrap_or(f64::NAN)));
                if drawn.last().is_none_or(|last| !last.0.is_finite()) {
                    drawn.push(from);
                }
                drawn.push(to);
            }
            if !drawn.is_empty() {
                series.push(Series { name: String::new(), colour, stroke, mark: Mark::None, points: drawn });
            }
        }
    }
    series
}

/// The places of one kind of event, of physical orbits.
fn events(quantity: QuantityName, event: Event, mark: Mark, diagram: &Diagram) -> Option<Series> {
    let mut points = Vec::new();
    for branch in &diagram.branches {
        for (at, station) in branch.stations.iter().enumerate() {
            let Station::Event(found) = station else { continue };
            if found.event != event || !branch.is_physical_about(at) {
                continue;
            }
            // One mark an event, on the uppermost of its curves.
            points.extend(heights(quantity, branch, at).into_iter().reduce(f64::max).map(|y| (found.value, y)));
        }
    }
    let name = event.name().to_owned();
    (!points.is_empty()).then_some(Series { name, colour: EVENTS, stroke: Stroke::None, mark, points })
}
