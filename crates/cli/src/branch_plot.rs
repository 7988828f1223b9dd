//! The picture of a bifurcation diagram: a quantity of the orbits against the parameter, a panel each.

use vibrochain_breather::Orbit;
use vibrochain_floquet::{Course, Diagram, DiagramPoint, Event, FollowedBranch, Station, Verdict};
use vibrochain_lattice::Parameter;
use vibrochain_maps::files::Output;
use vibrochain_plot::{Curves, Format, Mark, Pane, Scale, Series, Stroke, curves_picture, open};

use crate::args::{BranchArgs, QuantityName};
use crate::branch_command::name;
use crate::caption::describe_without;
use crate::error::CliError;
use crate::locate_command::Start;

/// Colours of generations of branches, by turns; the last but one marks events, the last what is not physical.
const COLOURS: usize = 4;
const EVENTS: usize = 4;
const GREY: usize = 5;

/// A picture under way.
pub(crate) struct Plot {
    file: Option<(Format, Output)>,
    shown: Vec<QuantityName>,
    all: bool,
}

impl Plot {
    pub(crate) fn open(args: &BranchArgs) -> Result<Self, CliError> {
        Ok(Self { file: open(args.plot.as_deref())?, shown: args.show.clone(), all: args.all })
    }

    pub(crate) fn finish(self, start: &Start, course: &Course, diagram: &Diagram) -> Result<(), CliError> {
        let Some((format, file)) = self.file else { return Ok(()) };
        let panes: Vec<Pane> = self.shown.iter().map(|quantity| pane(*quantity, self.all, course, diagram)).collect();
        let title = format!("branches of breathers, {}", describe_without(start.orbit.model(), course.free));
        let picture = Curves { title, columns: panes.len().min(2), panes, pane: (860, 620) };
        let bytes = curves_picture(&picture, format).map_err(|error| CliError::Computation(error.to_string()))?;
        Ok(file.finish_with(&bytes)?)
    }
}

fn symbol(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::Gamma1 => "γ₁",
        Parameter::Gamma2 => "γ₂",
        Parameter::Gamma3 => "γ₃",
        Parameter::Omega => "ω",
        Parameter::Asymmetry => "a",
        Parameter::Amplitude => "A",
        Parameter::Restitution => "e",
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

/// "once", "twice", "3 times".
fn times(count: u32) -> String {
    match count {
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        count => format!("{count} times"),
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
        let title = match (of_it.as_slice(), generation) {
            ([branch], _) => name(branch),
            (branches, generation) => format!("{} branches, {} off", branches.len(), times(generation)),
        };
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
    series.extend(
        Event::ALL.into_iter().enumerate().filter_map(|(shape, event)| events(quantity, event, shape, diagram)),
    );
    let levels = if quantity == QuantityName::SpectralRadius { vec![1.0] } else { Vec::new() };
    Pane {
        caption: String::new(),
        x: symbol(course.free).to_owned(),
        y: label(quantity).to_owned(),
        x_range: None,
        // Multipliers grow without bound next to a grazing impact.
        scale: if quantity == QuantityName::SpectralRadius { Scale::Logarithmic } else { Scale::Linear },
        levels,
        round: false,
        series,
    }
}

/// The curves of a branch: of each impact where impulses are asked for, cut where the kind of orbit changes.
fn curves(quantity: QuantityName, colour: usize, branch: &FollowedBranch, all: bool) -> Vec<Series> {
    let points: Vec<&DiagramPoint> = branch.points().collect();
    let count = points.first().map_or(0, |point| values(quantity, &point.orbit, Some(point)).len());
    let styles = [
        (Kind::NotPhysical, GREY, Stroke::Solid(1)),
        (Kind::Unstable, colour, Stroke::Dashed(2)),
        (Kind::Stable, colour, Stroke::Solid(3)),
    ];
    let mut series = Vec::new();
    for (wanted, colour, stroke) in styles.into_iter().filter(|(wanted, ..)| all || *wanted != Kind::NotPhysical) {
        for i in 0..count {
            let mut drawn: Vec<(f64, f64)> = Vec::new();
            for pair in points.windows(2) {
                let ends: Vec<(f64, f64)> = pair
                    .iter()
                    .map(|point| {
                        (point.value, values(quantity, &point.orbit, Some(point)).get(i).copied().unwrap_or(f64::NAN))
                    })
                    .collect();
                // A piece between two kinds belongs to the one behind it.
                if kind(pair[1]) != wanted {
                    if drawn.last().is_some_and(|last| last.0.is_finite()) {
                        drawn.push((f64::NAN, f64::NAN));
                    }
                    continue;
                }
                if drawn.last().is_none_or(|last| !last.0.is_finite()) {
                    drawn.push(ends[0]);
                }
                drawn.push(ends[1]);
            }
            if !drawn.is_empty() {
                series.push(Series { name: String::new(), colour, stroke, mark: Mark::None, points: drawn });
            }
        }
    }
    series
}

/// What only points know, at an event: between its neighbours, as the curve is drawn.
fn between(quantity: QuantityName, branch: &FollowedBranch, at: usize) -> Vec<f64> {
    let Station::Event(found) = &branch.stations[at] else { return Vec::new() };
    let (before, behind) = branch.stations.split_at(at);
    let near = |station: &Station| match station {
        Station::Point(point) => Some((point.value, values(quantity, &point.orbit, Some(point)))),
        Station::Event(_) => None,
    };
    match (before.iter().rev().find_map(near), behind.iter().find_map(near)) {
        (Some((low, from)), Some((high, to))) if low != high => {
            let share = ((found.value - low) / (high - low)).clamp(0.0, 1.0);
            from.iter().zip(&to).map(|(from, to)| from + share * (to - from)).collect()
        }
        (one, other) => one.or(other).map(|(_, values)| values).unwrap_or_default(),
    }
}

/// The places of one kind of event, of physical orbits.
fn events(quantity: QuantityName, event: Event, shape: usize, diagram: &Diagram) -> Option<Series> {
    let mut points = Vec::new();
    for branch in &diagram.branches {
        for (at, station) in branch.stations.iter().enumerate() {
            let Station::Event(found) = station else { continue };
            if found.event != event || !branch.is_physical_about(at) {
                continue;
            }
            let known = values(quantity, &found.orbit, None);
            let heights =
                if known.iter().all(|value| value.is_finite()) { known } else { between(quantity, branch, at) };
            points.extend(heights.into_iter().map(|y| (found.value, y)));
        }
    }
    let name = event.name().to_owned();
    (!points.is_empty()).then_some(Series {
        name,
        colour: EVENTS,
        stroke: Stroke::None,
        mark: Mark::Filled(shape),
        points,
    })
}
