//! The picture of a bifurcation diagram: a quantity of the orbits against the parameter, a panel each.

use std::collections::BTreeSet;

use vibrochain_floquet::Event;
use vibrochain_maps::caption::in_words;
use vibrochain_maps::followed::{BranchName, BranchRow as Row};

use crate::figures::mark;
use crate::map::palette::{FAMILIES, GREY, MARKS, WORDS};
use crate::panels::curves::{Curves, Mark, Pane, Scale, Series, Stroke};

/// What a diagram shows of orbits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OrbitQuantity {
    /// Modulus of every impulse.
    Impulse,
    /// Time of the second impact, in periods.
    Phi,
    /// Phase of the force, in its periods.
    Psi,
    /// Smallest distance to a barrier.
    Margin,
    /// Largest modulus of the multipliers.
    SpectralRadius,
}

vibrochain_lattice::names!(OrbitQuantity {
    Impulse "impulse", Phi "phi", Psi "psi", Margin "margin", SpectralRadius "spectral_radius",
});

/// Multipliers beyond this are outside the circle, however much excess counts as stable: rounding moves double ones by less.
const ON_CIRCLE: f64 = 1.0 + 1e-6;

/// More events than this have small marks.
const CROWD: usize = 40;

/// What is drawn of branches: their rows, in the order of the way, with their names, over what varies.
#[derive(Debug)]
pub struct Diagram<'a> {
    /// Line above the panels.
    pub heading: String,
    /// What stands at the axis of what varies.
    pub x: String,
    /// What the rows do not say, of each branch.
    pub names: &'a [BranchName],
    /// Points and events of each branch.
    pub rows: &'a [Vec<Row>],
}

/// The picture of branches: a panel a quantity, with `all` also what is not physical.
#[must_use]
pub fn diagram_curves(table: &Diagram<'_>, shown: &[OrbitQuantity], all: bool) -> Curves {
    let panes: Vec<Pane> = shown.iter().map(|quantity| pane(*quantity, all, table)).collect();
    let title = table.heading.clone();
    // Panels differ in what they show, not in what their lines mean.
    Curves { title, columns: panes.len().min(2), panes, pane: (860, 620), one_legend: true, ..Curves::default() }
}

fn label(quantity: OrbitQuantity) -> &'static str {
    match quantity {
        OrbitQuantity::Impulse => "impulses |P|",
        OrbitQuantity::Phi => "second impact φ/T",
        OrbitQuantity::Psi => "phase of the force ψ/T",
        OrbitQuantity::Margin => "smallest distance to a barrier",
        OrbitQuantity::SpectralRadius => "largest |μ|, logarithmic",
    }
}

/// The quantity's values: one, or one for each impact.
fn values(quantity: OrbitQuantity, row: &Row, force_periods: u32) -> Vec<f64> {
    let one = |value: Option<f64>| vec![value.unwrap_or(f64::NAN)];
    match quantity {
        OrbitQuantity::Impulse => row.impulses.iter().map(|impulse| impulse.abs()).collect(),
        OrbitQuantity::Phi => one(row.phi.map(|phi| phi / row.period)),
        OrbitQuantity::Psi => one(row.psi.map(|psi| psi / (row.period / f64::from(force_periods)))),
        OrbitQuantity::Margin => one(row.margin),
        OrbitQuantity::SpectralRadius => one(row.spectral_radius),
    }
}

/// How an orbit is drawn, the best first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Stable,
    Unstable,
    NotPhysical,
}

/// That of a point; an event is of none.
fn kind(row: &Row) -> Option<Kind> {
    Some(match (row.event, row.physical, row.stable) {
        (Some(_), ..) => return None,
        (None, Some(true), Some(true)) => Kind::Stable,
        (None, Some(true), _) => Kind::Unstable,
        _ => Kind::NotPhysical,
    })
}

/// A branch of a table.
#[derive(Clone, Copy)]
struct Branch<'a> {
    about: &'a BranchName,
    rows: &'a [Row],
}

fn branches<'a>(table: &'a Diagram<'_>) -> impl Iterator<Item = Branch<'a>> {
    table.names.iter().zip(table.rows).map(|(about, rows)| Branch { about, rows })
}

/// The colour of what orbits of this name are.
fn colour(name: &str) -> usize {
    FAMILIES.into_iter().find(|(family, _)| family.name() == name).map_or(WORDS, |(_, colour)| colour)
}

/// What the branches of one colour are called: those that bifurcate from the primary branch are secondary ones, and so on.
fn title(branches: &[Branch<'_>]) -> String {
    let mut names: Vec<&str> = branches.iter().map(|branch| branch.about.name.as_str()).collect();
    names.dedup();
    let name = if let [name] = names[..] { name } else { "words" };
    let mut generations: Vec<u32> = branches.iter().map(|branch| branch.about.generation).collect();
    generations.sort_unstable();
    let of_generation = |same: &[u32]| {
        let order = match same[0] {
            0 => "primary branch".to_owned(),
            1 => "secondary branch".to_owned(),
            2 => "tertiary branch".to_owned(),
            generation => format!("branch of generation {generation}"),
        };
        if same.len() == 1 { order } else { format!("{} {}", same.len(), order.replace("branch", "branches")) }
    };
    let orders: Vec<String> = generations.chunk_by(|a, b| a == b).map(of_generation).collect();
    format!("{name}: {}", orders.join(", "))
}

fn pane(quantity: OrbitQuantity, all: bool, table: &Diagram<'_>) -> Pane {
    let mut series: Vec<Series> = Vec::new();
    let colours: BTreeSet<usize> = branches(table).map(|branch| colour(&branch.about.name)).collect();
    let alone = table.rows.len() == 1;
    for one in colours {
        let of_it: Vec<Branch<'_>> = branches(table).filter(|branch| colour(&branch.about.name) == one).collect();
        let title = if alone { of_it[0].about.name.clone() } else { title(&of_it) };
        series.push(Series::line(title, one, Stroke::Solid(3), []));
        series.extend(of_it.into_iter().flat_map(|branch| curves(quantity, one, branch, all)));
    }
    let used = |wanted: Kind| branches(table).flat_map(|branch| branch.rows).any(|row| kind(row) == Some(wanted));
    if used(Kind::Unstable) {
        series.push(Series::line("unstable", GREY, Stroke::Dashed(2), []));
    }
    if all && used(Kind::NotPhysical) {
        series.push(Series::line("not physical", GREY, Stroke::Solid(1), []));
    }
    let count = branches(table).flat_map(|branch| branch.rows).filter(|row| row.event.is_some()).count();
    let sized = |event: Event| match mark(event.name()) {
        Mark::Filled(shape) if count > CROWD => Mark::Small(shape),
        mark => mark,
    };
    series.extend(Event::ALL.into_iter().filter_map(|event| events(quantity, event, sized(event), table)));
    let (scale, levels) = match quantity {
        OrbitQuantity::SpectralRadius => (Scale::Moduli, vec![1.0]),
        _ => (Scale::Linear, Vec::new()),
    };
    Pane { x: table.x.clone(), y: label(quantity).to_owned(), scale, levels, series, ..Pane::default() }
}

/// The quantity at a row of a branch: what only points know of an event is 1 or between its neighbours.
fn heights(quantity: OrbitQuantity, branch: Branch<'_>, at: usize) -> Vec<f64> {
    let Branch { about, rows } = branch;
    let of = |row: &Row| values(quantity, row, about.force_periods);
    let found = &rows[at];
    let known = of(found);
    if found.event.is_none() || known.iter().all(|value| value.is_finite()) {
        return known;
    }
    let (before, behind) = rows.split_at(at);
    let is_point = |row: &&Row| row.event.is_none();
    let (before, behind) = (before.iter().rev().find(is_point), behind.iter().find(is_point));
    let within = |row: &Row| row.spectral_radius.is_some_and(|radius| radius < ON_CIRCLE);
    let stable = |point: Option<&Row>| point.is_some_and(|row| kind(row) == Some(Kind::Stable) && within(row));
    // Next to stable orbits it is the leading multiplier that is on the circle.
    let grazes = matches!(found.event, Some(Event::Grazing | Event::Sticking));
    if quantity == OrbitQuantity::SpectralRadius && !grazes && (stable(before) || stable(behind)) {
        return vec![1.0];
    }
    let told = |point: &Row| (point.value, of(point));
    match (before.map(told), behind.map(told)) {
        (Some((low, from)), Some((high, to))) if low != high => {
            let share = ((found.value - low) / (high - low)).clamp(0.0, 1.0);
            from.iter().zip(&to).map(|(from, to)| from + share * (to - from)).collect()
        }
        (one, other) => one.or(other).map(|(_, values)| values).unwrap_or_default(),
    }
}

/// A row as it is drawn.
struct Passed {
    value: f64,
    kind: Option<Kind>,
    heights: Vec<f64>,
}

/// The curves of a branch: of each impact where impulses are asked for, cut where the kind of orbit changes.
fn curves(quantity: OrbitQuantity, colour: usize, branch: Branch<'_>, all: bool) -> Vec<Series> {
    let drawn =
        |(at, row): (usize, &Row)| Passed { value: row.value, kind: kind(row), heights: heights(quantity, branch, at) };
    let passed: Vec<Passed> = branch.rows.iter().enumerate().map(drawn).collect();
    let count = passed.first().map_or(0, |first| first.heights.len());
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
            // Between two kinds without an event that was asked for, nobody knows where the better one ends.
            last = pair[0].kind.max(pair[1].kind).or(last);
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
                let height = |row: &Passed| row.heights.get(i).copied().unwrap_or(f64::NAN);
                let [from, to] = [&pair[0], &pair[1]].map(|row| (row.value, height(row)));
                if drawn.last().is_none_or(|last| !last.0.is_finite()) {
                    drawn.push(from);
                }
                drawn.push(to);
            }
            if !drawn.is_empty() {
                series.push(Series::line("", colour, stroke, drawn));
            }
        }
    }
    series
}

/// The places of one kind of event, of physical orbits.
fn events(quantity: OrbitQuantity, event: Event, mark: Mark, table: &Diagram<'_>) -> Option<Series> {
    let mut points = Vec::new();
    for branch in branches(table) {
        for (at, found) in branch.rows.iter().enumerate().filter(|(_, row)| row.event == Some(event)) {
            if !Row::is_physical_about(branch.rows, at) {
                continue;
            }
            // One mark an event, on the uppermost of its curves.
            points.extend(heights(quantity, branch, at).into_iter().reduce(f64::max).map(|y| (found.value, y)));
        }
    }
    (!points.is_empty()).then(|| Series::marks(in_words(event.name()), MARKS, mark, points))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point, stable below an excess of 0.01.
    fn point(value: f64, radius: f64) -> Row {
        Row {
            event: None,
            value,
            impulses: vec![1.0],
            phi: None,
            psi: None,
            period: 1.0,
            margin: Some(0.1),
            physical: Some(true),
            stable: Some(radius < 1.01),
            spectral_radius: Some(radius),
        }
    }

    /// The leading multiplier is on the circle only where nothing grows beside it.
    #[test]
    fn an_event_is_at_1_if_its_neighbours_are_within_the_circle() {
        let about = BranchName { name: String::new(), generation: 0, force_periods: 1 };
        let event = |value| Row { event: Some(Event::PeriodDoubling), stable: None, ..point(value, f64::NAN) };
        for (beside, at) in [([1.0, 1.3], 1.0), ([0.9, 0.8], 1.0), ([1.004, 1.002], 1.003)] {
            let rows = [point(0.0, beside[0]), event(0.5), point(1.0, beside[1])];
            let found = heights(OrbitQuantity::SpectralRadius, Branch { about: &about, rows: &rows }, 1);
            assert!(found.len() == 1 && (found[0] - at).abs() < 1e-12, "{beside:?} {found:?}");
        }
    }

    /// A family has one colour, whichever branch is the first; branches of it are counted by generations.
    #[test]
    fn a_colour_is_a_family() {
        let branch = |name: &str, generation| BranchName { name: name.to_owned(), generation, force_periods: 1 };
        let about = [
            branch("single-sided", 0),
            branch("period-doubled", 1),
            branch("0-,0-,0-,0- in 4 periods of the force", 2),
            branch("period-doubled", 1),
            branch("single-sided", 2),
        ];
        let named = |wanted: usize| {
            let of: Vec<_> = about.iter().filter(|one| colour(&one.name) == wanted).collect();
            title(&of.iter().map(|about| Branch { about, rows: &[] }).collect::<Vec<_>>())
        };
        assert_eq!(named(1), "single-sided: primary branch, tertiary branch");
        assert_eq!(named(3), "period-doubled: 2 secondary branches");
        assert_eq!(named(WORDS), "0-,0-,0-,0- in 4 periods of the force: tertiary branch");
        assert_eq!(colour("double-sided"), 0);
    }

    /// Stripes whose borders nobody has asked for: no orbit that grows is drawn as a stable one.
    #[test]
    fn between_a_stable_and_an_unstable_point_a_branch_is_unstable() {
        let radii = [1.0, 1.0, 1.5, 1.0, 1.0];
        let rows: Vec<Row> = radii.iter().enumerate().map(|(i, radius)| point(i as f64, *radius)).collect();
        let about = BranchName { name: String::new(), generation: 0, force_periods: 1 };
        let drawn = curves(OrbitQuantity::SpectralRadius, 0, Branch { about: &about, rows: &rows }, false);
        let heights = |stroke: Stroke| -> Vec<f64> {
            let points = drawn.iter().filter(|series| series.stroke == stroke).flat_map(|series| &series.points);
            points.map(|point| point.1).filter(|height| height.is_finite()).collect()
        };
        assert_eq!(heights(Stroke::Dashed(2)), [1.0, 1.5, 1.0]);
        assert_eq!(heights(Stroke::Solid(3)), [1.0; 4]);
    }
}
