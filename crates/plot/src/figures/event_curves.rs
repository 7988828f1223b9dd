//! The picture of curves of events in the plane of two parameters.

use std::collections::BTreeMap;

use vibrochain_maps::caption::in_words;
use vibrochain_maps::followed::CurveRow as Row;

use crate::figures::mark;
use crate::map::palette::{CURVES, GREY, MARKS};
use crate::panels::curves::{Curves, Pane, Scale, Series, Stroke};

/// What a legend calls points whose orbit is none that can live.
const NOT_PHYSICAL: &str = "not physical";

/// The picture of the curves in a window from some values to others. `touches` says of each what its orbits have in common; it may be empty, or
/// shorter.
#[must_use]
pub fn event_curves(
    heading: &str,
    [x, y]: [String; 2],
    (from, to): ([f64; 2], [f64; 2]),
    (curves, touches): (&[Vec<Row>], &[String]),
) -> Curves {
    let pane = Pane {
        x,
        y,
        x_range: Some(from[0]..to[0]),
        scale: Scale::Between(from[1]..to[1]),
        series: series(curves, touches),
        ..Pane::default()
    };
    Curves { title: heading.to_owned(), columns: 1, panes: vec![pane], pane: (1000, 720), ..Curves::default() }
}

/// The lines of each curve, physical parts and others, then marks for what is special.
fn series(curves: &[Vec<Row>], touches: &[String]) -> Vec<Series> {
    let mut all = Vec::new();
    let mut marks: BTreeMap<&str, Vec<(f64, f64)>> = BTreeMap::new();
    for (i, curve) in curves.iter().enumerate() {
        let line = |physical: bool| part(curve, physical);
        let is_seen = |points: &[(f64, f64)]| points.iter().any(|point| point.0.is_finite());
        let touch = touches.get(i).filter(|touch| !touch.is_empty());
        let touch = touch.map_or(String::new(), |touch| format!(": {touch}"));
        let name = if is_seen(&line(true)) { format!("curve {}{touch}", i + 1) } else { String::new() };
        // Of two curves of one colour the later is thicker.
        let (turn, place) = (i / CURVES.len(), i % CURVES.len());
        let (colour, stroke) = (CURVES[place], Stroke::Solid(2 + 2 * turn.min(3) as u32));
        all.push(Series::line(name, colour, stroke, line(true)));
        // All of them have one entry.
        let is_told = all.iter().any(|series| series.name == NOT_PHYSICAL);
        let name = if is_seen(&line(false)) && !is_told { NOT_PHYSICAL } else { "" };
        all.push(Series::line(name, GREY, Stroke::Dashed(2), line(false)));
        for Row { values: [x, y], special, .. } in curve {
            for name in special {
                marks.entry(name).or_default().push((*x, *y));
            }
        }
    }
    all.extend(marks.into_iter().map(|(name, points)| Series::marks(in_words(name), MARKS, mark(name), points)));
    all
}

/// The points whose orbits are physical, or those whose are not, with breaks between.
fn part(curve: &[Row], physical: bool) -> Vec<(f64, f64)> {
    let of = |pair: &[Row]| {
        let is = pair.iter().all(|point| point.physical) == physical;
        let [from, to] = [&pair[0], &pair[1]].map(|point| (point.values[0], point.values[1]));
        if is { vec![from, to] } else { vec![(f64::NAN, f64::NAN)] }
    };
    curve.windows(2).flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use vibrochain_floquet::{Event, Special};

    use super::*;
    use crate::panels::curves::Mark;

    /// Whatever else is in a picture, a kind of point has its own shape and its name in the legend.
    #[test]
    fn a_shape_is_a_kind() {
        let resonances = [Special::OneToOne, Special::OneToTwo, Special::OneToThree, Special::OneToFour, Special::Cusp];
        let kinds: Vec<String> =
            resonances.into_iter().chain(Event::ALL.map(Special::With)).map(|one| one.to_string()).collect();
        let marks = |names: &[String]| -> BTreeMap<String, String> {
            let point = |name: &String| Row { values: [0.5, 0.5], physical: true, special: vec![name.clone()] };
            let all = series(&[names.iter().map(point).collect()], &[]);
            let marked = all.into_iter().filter(|series| series.mark != Mark::None);
            marked.map(|series| (series.name, format!("{:?} {}", series.mark, series.colour))).collect()
        };
        let whole = marks(&kinds);
        assert!(
            kinds.len() == 11
                && whole.keys().eq(kinds
                    .iter()
                    .map(|name| in_words(name))
                    .collect::<std::collections::BTreeSet<_>>()
                    .iter()),
            "{whole:?}"
        );
        let shapes: std::collections::BTreeSet<_> = whole.values().collect();
        assert_eq!(shapes.len(), 11, "{whole:?}");
        for name in &kinds {
            assert_eq!(marks(std::slice::from_ref(name)), [(in_words(name), whole[&in_words(name)].clone())].into());
        }
    }
}
