//! The picture of a sweep over one parameter: numbers of the breather that gives each cell its class, against the parameter.

use vibrochain_maps::cell::{Cell, Class};
use vibrochain_maps::scene::Values;

use crate::axes::axis::place;
use crate::backend::format::PlotError;
use crate::backend::page::Page;
use crate::map::classes::{UNKNOWN, parts};
use crate::map::mapped::{MapAxis, Mapped, about};
use crate::map::quantity::Quantity;
use crate::panels::curves::{Curves, Mark, Pane, Scale, Series, Stroke};
use crate::panels::curves_picture;

/// What is drawn.
#[derive(Debug)]
pub struct OneAxisPicture<'a> {
    /// The scene, of one axis.
    pub scene: &'a dyn Mapped,
    /// The cells that are [shown](crate::is_shown).
    pub cells: &'a [Cell],
}

/// Width and height of a panel, in pixels.
const PANE: (u32, u32) = (1100, 400);

/// The colour of what has no family.
const UNKNOWN_COLOUR: usize = 5;

/// How breathers of a class are drawn: stable ones by solid lines, unstable ones by dashed ones, the families in a colour each.
fn look(class: Option<Class>) -> (usize, Stroke) {
    match class.and_then(parts) {
        Some((family, Some(false))) => (family, Stroke::Dashed(2)),
        Some((family, _)) => (family, Stroke::Solid(3)),
        None => (UNKNOWN_COLOUR, Stroke::Solid(1)),
    }
}

/// The bytes of the picture of a sweep over one parameter: a panel each for the largest multiplier, the margin and the strongest
/// impulse, as far as its cells have them.
///
/// # Errors
/// [`PlotError`].
pub fn one_axis_picture(picture: &OneAxisPicture<'_>, page: impl Into<Page>) -> Result<Vec<u8>, PlotError> {
    let axes = picture.scene.axes();
    let [axis] = axes.as_slice() else {
        return Err(PlotError("curves are drawn over one axis".to_owned()));
    };
    let cells = ordered(&axis.values, picture.cells);
    let there = [Quantity::SpectralRadius, Quantity::Margin, Quantity::Impulse]
        .into_iter()
        .filter(|quantity| picture.scene.has(*quantity).is_ok());
    let mut panes: Vec<Pane> = there.map(|quantity| pane(quantity, picture.scene, axis, &cells)).collect();
    // One above the other they share what stands below the last one, and names.
    if let Some((_, above)) = panes.split_last_mut() {
        above.iter_mut().for_each(|pane| pane.x = String::new());
    }
    let picture =
        Curves { title: about(picture.scene), columns: 1, panes, pane: PANE, one_legend: true, ..Curves::default() };
    curves_picture(&picture, page)
}

/// Cells with their places along the axis, from left to right.
fn ordered<'a>(axis: &Values, cells: &'a [Cell]) -> Vec<(f64, &'a Cell)> {
    let stride = axis.points().div_ceil(cells.len().max(1));
    let mut placed: Vec<(f64, &Cell)> =
        (0..axis.points()).step_by(stride.max(1)).map(|i| place(axis, axis.value(i))).zip(cells).collect();
    placed.sort_by(|one, other| one.0.total_cmp(&other.0));
    placed
}

fn pane(quantity: Quantity, scene: &dyn Mapped, axis: &MapAxis, cells: &[(f64, &Cell)]) -> Pane {
    // Where stability changes the largest multiplier is 1.
    let change = (quantity == Quantity::SpectralRadius).then_some(1.0);
    let drawn = |(place, cell): &(f64, &Cell)| Drawn {
        place: *place,
        class: cell.class,
        solutions: cell.solutions,
        height: quantity.of(cell),
    };
    let points: Vec<Drawn> = cells.iter().map(drawn).collect();
    let mut series = Vec::new();
    let all: Vec<Class> = cells.iter().filter_map(|(_, cell)| cell.class).collect();
    for class in Class::ALL.into_iter().filter(|class| *class != Class::None).map(Some).chain([None]) {
        let named = points.iter().any(|point| point.class == class && point.height.is_some());
        let (colour, stroke) = look(class);
        if named {
            let name = class.map_or("class not known".to_owned(), |class| scene.class(class, &all));
            series.push(Series::line(name, colour, stroke, line(&points, class, change)));
        }
        let lone = lone(&points, class);
        if !lone.is_empty() {
            series.push(Series::marks("", colour, Mark::Small(0), lone));
        }
    }
    series.extend(missing(&points));
    let (scale, levels) = match quantity {
        Quantity::SpectralRadius => (Scale::Moduli, vec![1.0]),
        _ => (Scale::Linear, Vec::new()),
    };
    let ends = cells.first().zip(cells.last()).filter(|(first, last)| first.0 < last.0);
    let x_range = ends.map(|(first, last)| first.0..last.0);
    let y =
        if scale == Scale::Moduli { format!("{}, logarithmic", quantity.label()) } else { quantity.label().to_owned() };
    Pane { y, x_range, scale, levels, series, ..Pane::over(axis) }
}

/// A cell in a panel.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Drawn {
    place: f64,
    class: Option<Class>,
    /// How many breathers are there.
    solutions: u32,
    height: Option<f64>,
}

/// Where the line from one cell to the next ends to be drawn as the first one; nowhere if no line joins them: breathers of two
/// families are two orbits, and where there is one more or less another one may give the class. Between a stable and an unstable one the
/// line passes `change`, if that is known, or else the mean.
fn joined(from: &Drawn, to: &Drawn, change: Option<f64>) -> Option<(f64, f64)> {
    let (one, other) = (from.height?, to.height?);
    if look(from.class).0 != look(to.class).0 || from.solutions != to.solutions {
        return None;
    }
    if from.class == to.class {
        return Some((to.place, other));
    }
    // Stability changes in between, nobody knows where.
    let height = change.map_or(0.5 * (one + other), |change| change.clamp(one.min(other), one.max(other)));
    Some((0.5 * (from.place + to.place), height))
}

/// The line through the cells of a class, with breaks.
fn line(cells: &[Drawn], class: Option<Class>, change: Option<f64>) -> Vec<(f64, f64)> {
    let mut line: Vec<(f64, f64)> = Vec::new();
    for (i, cell) in cells.iter().enumerate().filter(|(_, cell)| cell.class == class) {
        let Some(height) = cell.height else { continue };
        let before = i.checked_sub(1).and_then(|i| cells.get(i));
        let reached = before.and_then(|before| joined(before, cell, change));
        if reached.is_none() || before.is_some_and(|before| before.class != class) {
            line.push((f64::NAN, f64::NAN));
            line.extend(reached);
        }
        line.push((cell.place, height));
        let behind = cells.get(i + 1).filter(|behind| behind.class != class);
        line.extend(behind.and_then(|behind| joined(cell, behind, change)));
    }
    line
}

/// Cells of a class that no line reaches.
fn lone(cells: &[Drawn], class: Option<Class>) -> Vec<(f64, f64)> {
    let meets = |i: usize, j: Option<usize>| {
        j.and_then(|j| cells.get(j)).is_some_and(|other| joined(&cells[i], other, None).is_some())
    };
    let alone = |i: &usize| cells[*i].class == class && !meets(*i, i.checked_sub(1)) && !meets(*i, Some(i + 1));
    (0..cells.len()).filter(alone).filter_map(|i| Some((cells[i].place, cells[i].height?))).collect()
}

/// A line across the panel at each cell of which nothing is known, so that it is not taken for one without a breather.
fn missing(cells: &[Drawn]) -> Option<Series> {
    let heights = || cells.iter().filter_map(|cell| cell.height);
    let (low, high) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
    let (low, high) = if low < high { (low, high) } else { (0.5, 1.5) };
    let unknown = cells.iter().filter(|cell| cell.class.is_none() && cell.height.is_none());
    let points: Vec<(f64, f64)> =
        unknown.flat_map(|cell| [(cell.place, low), (cell.place, high), (f64::NAN, f64::NAN)]).collect();
    (!points.is_empty()).then(|| Series::line(UNKNOWN, UNKNOWN_COLOUR, Stroke::Solid(1), points))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use vibrochain_maps::scene::Scene;

    use super::*;
    use crate::backend::format::Format;

    fn scene(axis: &str) -> Scene {
        let text = format!(
            "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\ngamma2 = 0.1\n[sweep]\n\
             x = {{ parameter = \"omega\", {axis} }}\n[compute]\nfamilies = [\"double-sided\"]\nstability = true\n"
        );
        Scene::parse(Path::new("scene.toml"), &text).unwrap()
    }

    fn cell(class: Class, radius: f64) -> Cell {
        Cell { class: Some(class), spectral_radius: Some(radius), margin: Some(0.5), solutions: 1, ..Cell::EMPTY }
    }

    fn drawn(classes: &[(Option<Class>, Option<f64>)]) -> Vec<Drawn> {
        let cell = |(i, (class, height)): (usize, &(Option<Class>, Option<f64>))| Drawn {
            place: i as f64,
            class: *class,
            solutions: 1,
            height: *height,
        };
        classes.iter().enumerate().map(cell).collect()
    }

    /// The pieces of a line between its breaks.
    fn pieces(line: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
        let pieces = line.split(|point| point.0.is_nan()).filter(|piece| !piece.is_empty());
        pieces.map(<[_]>::to_vec).collect()
    }

    #[test]
    fn lines_break_where_no_breather_is_and_change_halfway_where_stability_does() {
        let [stable, unstable, single] = [Class::StableDouble, Class::UnstableDouble, Class::StableSingle].map(Some);
        let nothing = (Some(Class::None), None);
        let cells = drawn(&[
            (stable, Some(1.0)),
            (stable, Some(2.0)),
            (unstable, Some(4.0)),
            nothing,
            (unstable, Some(3.0)),
            (single, Some(1.0)),
            (single, Some(1.5)),
            (None, None),
        ]);
        assert_eq!(pieces(&line(&cells, stable, None)), [[(0.0, 1.0), (1.0, 2.0), (1.5, 3.0)]]);
        assert_eq!(pieces(&line(&cells, unstable, None)), [vec![(1.5, 3.0), (2.0, 4.0)], vec![(4.0, 3.0)]]);
        assert_eq!(pieces(&line(&cells, single, None)), [[(5.0, 1.0), (6.0, 1.5)]]);
        // What is known of the change is kept, as far as it lies between.
        let changing = |at: f64| pieces(&line(&cells, stable, Some(at)))[0][2];
        assert_eq!([changing(2.5), changing(1.0), changing(9.0)], [(1.5, 2.5), (1.5, 2.0), (1.5, 4.0)]);
        assert_eq!((lone(&cells, unstable), lone(&cells, stable)), (vec![(4.0, 3.0)], vec![]));
        // One more breather may be another one.
        let mut more = cells[..2].to_vec();
        more[1].solutions = 2;
        assert_eq!(pieces(&line(&more, stable, None)), [[(0.0, 1.0)], [(1.0, 2.0)]]);
        let across = missing(&cells).unwrap().points;
        assert_eq!(pieces(&across), [[(7.0, 1.0), (7.0, 4.0)]]);
        assert!(missing(&cells[..7]).is_none());
    }

    #[test]
    fn lists_are_drawn_in_order_of_their_values_and_logarithms_as_such() {
        let cells = [0.5, 0.6, 0.7].map(|radius| cell(Class::StableDouble, radius));
        let list = scene("values = [2.0, 1.0, 1.5]");
        let radii: Vec<_> =
            ordered(&list.axes[0].values, &cells).iter().map(|(x, c)| (*x, c.spectral_radius)).collect();
        assert_eq!(radii, [(1.0, Some(0.6)), (1.5, Some(0.7)), (2.0, Some(0.5))]);
        let log = scene("from = 0.1, to = 10, points = 3, spacing = \"log\"");
        let places: Vec<f64> = ordered(&log.axes[0].values, &cells).iter().map(|(x, _)| *x).collect();
        assert_eq!(places, [-1.0, 0.0, 1.0]);
        let svg =
            String::from_utf8(one_axis_picture(&OneAxisPicture { scene: &log, cells: &cells }, Format::Svg).unwrap())
                .unwrap();
        assert!(["0.1", "1", "10"].iter().all(|tick| svg.contains(&format!("aria-label=\"{tick}\""))), "{svg}");
        assert!(svg.contains("frequency ω") && svg.contains("stable double-sided") && !svg.contains("unstable"));
    }

    #[test]
    fn moduli_are_drawn_by_logarithms_and_what_is_stable_at_1() {
        let scene = scene("from = 1, to = 2, points = 5");
        let axis = MapAxis::from(&scene.axes[0]);
        let cells: Vec<Cell> = [1.0, 1.0 + 3e-4, 1.02, 3.0, 0.9]
            .map(|radius| cell(if radius > 1.0 { Class::UnstableDouble } else { Class::StableDouble }, radius))
            .to_vec();
        let drawn = pane(Quantity::SpectralRadius, &scene, &axis, &ordered(&axis.values, &cells));
        assert_eq!((drawn.scale.clone(), drawn.y.as_str()), (Scale::Moduli, "largest |μ|, logarithmic"));
        assert_eq!(drawn.levels, [1.0]);
        let named = |name: &str| drawn.series.iter().find(|series| series.name == name).unwrap();
        let (stable, unstable) = (named("stable double-sided"), named("unstable double-sided"));
        // No height that is none of a cell's: it changes at 1.
        assert_eq!(pieces(&stable.points), [[(1.0, 1.0), (1.125, 1.0)], [(1.875, 1.0), (2.0, 0.9)]]);
        let heights: Vec<f64> = pieces(&unstable.points)[0].iter().map(|point| point.1).collect();
        assert_eq!(heights, [1.0, 1.0 + 3e-4, 1.02, 3.0, 1.0]);
        assert_eq!((stable.stroke, unstable.stroke), (Stroke::Solid(3), Stroke::Dashed(2)));
        let few = &cells[1..2];
        let drawn = pane(Quantity::SpectralRadius, &scene, &axis, &ordered(&axis.values, few));
        assert!(drawn.scale == Scale::Moduli && drawn.levels == [1.0]);
        assert_eq!(pane(Quantity::Margin, &scene, &axis, &ordered(&axis.values, &cells)).scale, Scale::Linear);
    }
}
