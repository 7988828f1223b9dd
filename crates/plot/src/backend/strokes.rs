//! Borders by their kinds, and lines without the points that they pass anyway.

use crate::backend::drawing::{Drawing, Line, Place, Rgb, Shape};
use crate::backend::page::Page;
use crate::map::palette::BORDERS;

/// Points of shapes and strokes may be so many pixels off: no eye, and no print, sees less.
pub(crate) const FINE: f64 = 0.005;

/// Width of a border, and of the white line under it that sets it off from dark cells.
const BORDER: f64 = 1.1;
const CASING: f64 = 2.6;

/// Dashes of every second kind in order of lightness: on grey paper neighbours differ.
const DASH: [f64; 2] = [5.0, 2.5];

/// Borders of one kind.
pub(crate) struct Borders<'a> {
    pub(crate) kind: &'a str,
    pub(crate) colour: Rgb,
    pub(crate) dash: Option<[f64; 2]>,
    /// Each as parts of the map from its upper left corner, and what it is when one hovers over it.
    pub(crate) lines: Vec<(Vec<Place>, &'a str)>,
}

impl<'a> Borders<'a> {
    /// Adds a line to those of its kind.
    pub(crate) fn add(all: &mut Vec<Self>, kind: &'a str, line: Vec<Place>, title: &'a str) {
        if let Some(borders) = all.iter_mut().find(|borders| borders.kind == kind) {
            borders.lines.push((line, title));
            return;
        }
        let number = all.len() % BORDERS.len();
        let dash = matches!(number, 2 | 3 | 5).then_some(DASH);
        all.push(Self { kind, colour: BORDERS[number], dash, lines: vec![(line, title)] });
    }

    /// Draws all kinds over a map: white under every line first, so that no kind hides another.
    pub(crate) fn draw(all: &[Self], drawing: &mut Drawing, within: impl Fn(Place) -> Place, page: &Page) {
        if all.is_empty() {
            return;
        }
        let outline = |line: &[Place]| thinned(&line.iter().map(|place| within(*place)).collect::<Vec<_>>());
        let outlines = all.iter().flat_map(|borders| &borders.lines).map(|(line, _)| outline(line)).collect();
        let casing = Some(Line::new([255; 3], page.px(CASING)));
        drawing.shape(Shape { outlines, line: casing, ..Shape::default() });
        for Self { colour, dash, lines, .. } in all {
            let mut stroke = Line::new(*colour, page.px(BORDER));
            stroke.dash = dash.map(|dash| dash.map(|part| page.px(part)));
            for alike in lines.chunk_by(|one, other| one.1 == other.1) {
                let outlines = alike.iter().map(|(line, _)| outline(line)).collect();
                let title = alike.first().map_or(String::new(), |(_, title)| (*title).to_owned());
                drawing.shape(Shape { outlines, line: Some(stroke), title, ..Shape::default() });
            }
        }
    }
}

/// A line without the points that it passes anyway.
pub(crate) fn thinned(line: &[Place]) -> Vec<Place> {
    if line.len() < 3 {
        return line.to_vec();
    }
    let mut kept = vec![false; line.len()];
    let mut ranges = vec![(0, line.len() - 1)];
    while let Some((first, last)) = ranges.pop() {
        (kept[first], kept[last]) = (true, true);
        let [ax, ay] = line[first];
        let [dx, dy] = [line[last][0] - ax, line[last][1] - ay];
        let chord = dx.hypot(dy);
        let off = |i: usize| {
            let [x, y] = [line[i][0] - ax, line[i][1] - ay];
            if chord > FINE { (dx * y - dy * x).abs() / chord } else { x.hypot(y) }
        };
        let farthest = (first + 1..last).map(|i| (off(i), i)).max_by(|one, two| one.0.total_cmp(&two.0));
        if let Some((distance, i)) = farthest
            && distance > FINE
        {
            ranges.extend([(first, i), (i, last)]);
        }
    }
    line.iter().zip(kept).filter_map(|(place, kept)| kept.then_some(*place)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::drawing::Element;
    use crate::backend::format::Format;

    #[test]
    fn borders_lie_on_white_that_hides_none_of_them() {
        let mut all = Vec::new();
        for (kind, title, x) in [("fold", "a", 0.1), ("grazing", "b", 0.2), ("fold", "c", 0.3), ("fold", "c", 0.4)] {
            Borders::add(&mut all, kind, vec![[x, 0.0], [x, 1.0]], title);
        }
        assert!(all.len() == 2 && all[0].colour != all[1].colour);
        let mut drawing = Drawing::new([100.0; 2], "");
        Borders::draw(&all, &mut drawing, |[x, y]| [100.0 * x, 100.0 * y], &Page::from(Format::Svg));
        let drawn: Vec<_> = drawing
            .elements
            .iter()
            .map(|element| match element {
                Element::Shape(shape) => (shape.line.unwrap(), shape.outlines.len(), shape.title.as_str()),
                other => panic!("{other:?}"),
            })
            .collect();
        // All white first, and wider than what lies on it.
        assert_eq!((drawn[0].0.colour, drawn[0].1), ([255; 3], 4));
        let lines: Vec<_> = drawn[1..].iter().map(|(line, count, title)| (line.colour, *count, *title)).collect();
        assert_eq!(lines, [(BORDERS[0], 1, "a"), (BORDERS[0], 2, "c"), (BORDERS[1], 1, "b")]);
        assert!(drawn[1..].iter().all(|(line, ..)| line.width < 0.6 * drawn[0].0.width && line.opacity == 1.0));
    }

    #[test]
    fn what_is_thinned_stays_within_a_hundredth_of_a_pixel() {
        let wave: Vec<Place> =
            (0..20_000).map(|i| f64::from(i) / 20.0).map(|x| [x, 300.0 + 200.0 * (x / 40.0).sin()]).collect();
        let thin = thinned(&wave);
        assert!(thin.len() < 3000 && thin.first() == wave.first() && thin.last() == wave.last(), "{}", thin.len());
        let mut checked = 0;
        for pair in thin.windows(2) {
            for [x, y] in wave.iter().filter(|place| place[0] > pair[0][0] && place[0] < pair[1][0]) {
                let part = (x - pair[0][0]) / (pair[1][0] - pair[0][0]);
                let slope = (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]);
                assert!((pair[0][1] + part * (pair[1][1] - pair[0][1]) - y).abs() / slope.hypot(1.0) < 2.0 * FINE);
                checked += 1;
            }
        }
        assert!(checked > 10_000);
    }
}
