//! A panel: a box with two axes, their names, ticks and a light grid.

use crate::axes::axis::Axis;
use crate::backend::drawing::{Across, BLACK, Drawing, Line, Place, Rgb, Upright, sides};
use crate::backend::page::Page;
use crate::text::font::width;
use crate::text::headings::{CAPTION, STEP};

/// A light grid, and the lines of barriers and levels.
const GRID: Rgb = [230, 230, 230];
pub(crate) const LEVEL: Rgb = [110, 110, 110];

/// Size of the words of ticks against the letters of legends: a little smaller, there are many.
pub(crate) const TICK: f64 = 0.93;

/// Length of a tick, and the air beside it, in em: a third of a letter is seen and no more, and words keep clear of it.
const MARK: f64 = 0.33;
const AIR: f64 = 0.27;
/// Height of the line that names an axis, in em: its letters with the air of a line of text above and below.
const NAMED: f64 = 1.7;

/// Room of ticks in em: between words side by side more than a space, or two numbers read as one; of a line above another, twice
/// its height.
const BETWEEN: f64 = 1.2;
const LINE: f64 = 2.0;

/// A panel.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Frame {
    /// Its upper left and lower right corner.
    pub(crate) corners: [Place; 2],
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    /// The width of the ticks of the vertical axis, where it shares a line for its name with panels above and below it; otherwise 0.
    pub(crate) ticks: f64,
}

/// The ticks of an axis so long, with as many as their words have room for.
fn across(axis: &Axis, length: f64, em: f64) -> Vec<(f64, String)> {
    let size = TICK * em;
    let mut most = ((length / (4.0 * size)) as usize).clamp(2, 10);
    loop {
        let ticks = axis.ticks(most);
        let wide = ticks.iter().map(|(_, words)| width(words)).fold(0.0, f64::max);
        let place = |i: usize| axis.part(ticks[i].0) * length;
        let near = (1..ticks.len()).map(|i| (place(i) - place(i - 1)).abs()).fold(f64::INFINITY, f64::min);
        if near >= (wide + BETWEEN) * size || most <= 2 {
            return ticks;
        }
        most -= 1;
    }
}

fn upright(axis: &Axis, length: f64, em: f64) -> Vec<(f64, String)> {
    axis.ticks(many(length, em))
}

/// How many ticks a vertical axis so long has room for.
fn many(length: f64, em: f64) -> usize {
    ((length / (LINE * em)) as usize).clamp(2, 10)
}

/// The width of the ticks of a vertical axis so long.
pub(crate) fn ticks_of(axis: &Axis, length: f64, page: &Page) -> f64 {
    let em = page.font;
    let wide = upright(axis, length, em).iter().map(|(_, words)| width(words)).fold(0.0, f64::max);
    (wide * TICK + MARK + AIR) * em
}

/// The width that the name of a vertical axis so long takes.
pub(crate) fn name_of(name: &str, length: f64, page: &Page) -> f64 {
    let lines = named(name, length, page.font).len() as f64;
    if lines > 0.0 { (NAMED + (lines - 1.0) * STEP * CAPTION) * page.font } else { 0.0 }
}

/// The width that ticks and name of a vertical axis so long take.
pub(crate) fn left_of(axis: &Axis, name: &str, length: f64, page: &Page) -> f64 {
    ticks_of(axis, length, page) + name_of(name, length, page) + 0.3 * page.font
}

/// The lines of the name of a vertical axis so long: two where it does not fit, broken where they are most alike.
fn named(name: &str, length: f64, em: f64) -> Vec<&str> {
    if name.is_empty() {
        return Vec::new();
    }
    let longer = |(one, other): &(&str, &str)| width(one).max(width(other));
    let broken = name.match_indices(' ').map(|(i, _)| (&name[..i], &name[i + 1..]));
    match broken.min_by(|one, other| longer(one).total_cmp(&longer(other))) {
        Some((one, other)) if width(name) * CAPTION * em > room(length, em) => vec![one, other],
        _ => vec![name],
    }
}

/// What the name of a vertical axis may take: it may stand out a little at either end.
fn room(length: f64, em: f64) -> f64 {
    length + 1.6 * em
}

/// The height that ticks and name of a horizontal axis take.
pub(crate) fn below(named: bool, page: &Page) -> f64 {
    (MARK + 1.5 * TICK + if named { NAMED } else { 0.0 }) * page.font
}

impl Frame {
    /// Where a point lies, in units.
    pub(crate) fn place(&self, (x, y): (f64, f64)) -> Place {
        let [[left, top], [right, bottom]] = self.corners;
        [left + self.x.part(x) * (right - left), bottom - self.y.part(y) * (bottom - top)]
    }

    pub(crate) fn size(&self) -> [f64; 2] {
        sides(self.corners)
    }

    /// Draws a grid under what is to come.
    pub(crate) fn grid(&self, drawing: &mut Drawing, page: &Page) {
        let ([width, height], [[left, top], [right, bottom]]) = (self.size(), self.corners);
        let light = Line::new(GRID, page.px(1.0)).crisp();
        for (place, _) in across(&self.x, width, page.font) {
            let x = left + self.x.part(place) * width;
            drawing.line(vec![[x, top], [x, bottom]], light);
        }
        for (place, _) in upright(&self.y, height, page.font) {
            let y = bottom - self.y.part(place) * height;
            drawing.line(vec![[left, y], [right, y]], light);
        }
    }

    /// Draws a dashed line across at a height.
    pub(crate) fn level(&self, drawing: &mut Drawing, y: f64, page: &Page) {
        let [[left, _], [right, _]] = self.corners;
        let y = self.place((self.x.range.start, y))[1];
        let line = Line::new(LEVEL, page.px(1.0)).dashed(page.px(6.0), page.px(4.0)).crisp();
        drawing.line(vec![[left, y], [right, y]], line);
    }

    /// Draws a dashed line upright at a place along the horizontal axis.
    pub(crate) fn upright(&self, drawing: &mut Drawing, x: f64, page: &Page) {
        let [[_, top], [_, bottom]] = self.corners;
        let x = self.place((x, self.y.range.start))[0];
        let line = Line::new(LEVEL, page.px(1.0)).dashed(page.px(6.0), page.px(4.0)).crisp();
        drawing.line(vec![[x, top], [x, bottom]], line);
    }

    /// Draws the box, ticks and names; an empty name takes no room.
    pub(crate) fn axes(&self, drawing: &mut Drawing, [x_name, y_name]: [&str; 2], page: &Page) {
        let ([width_of, height], [[left, top], [right, bottom]]) = (self.size(), self.corners);
        let em = page.font;
        let (tick, mark, air) = (TICK * em, MARK * em, AIR * em);
        let line = Line::new(BLACK, page.px(1.0)).crisp();
        for (place, words) in across(&self.x, width_of, em) {
            let x = left + self.x.part(place) * width_of;
            drawing.line(vec![[x, bottom], [x, bottom + mark]], line);
            let at = [x, bottom + mark + 0.7 * air];
            drawing.anchored(&words, at, tick, BLACK, (Across::Centre, Upright::Top));
        }
        let ticks = upright(&self.y, height, em);
        let wide = ticks.iter().map(|(_, words)| width(words)).fold(0.0, f64::max) * tick;
        for (place, words) in ticks {
            let y = bottom - self.y.part(place) * height;
            drawing.line(vec![[left - mark, y], [left, y]], line);
            drawing.anchored(&words, [left - mark - air, y], tick, BLACK, (Across::Right, Upright::Middle));
        }
        for place in self.y.marks(many(height, em)) {
            let y = bottom - self.y.part(place) * height;
            drawing.line(vec![[left - 0.5 * mark, y], [left, y]], line);
        }
        // About the panel, not on it: a map keeps all its pixels.
        let half = 0.5 / page.scale();
        drawing.frame([[left - half, top - half], [right + half, bottom + half]], line);
        let centred = |room: f64, name: &str| (CAPTION * em).min(room / width(name).max(1e-9));
        if !x_name.is_empty() {
            let at = [0.5 * (left + right), bottom + below(true, page) - 0.2 * em];
            let anchor = (Across::Centre, Upright::Base);
            drawing.anchored(x_name, at, centred(width_of + 1.5 * em, x_name), BLACK, anchor);
        }
        if !y_name.is_empty() {
            let first = left - self.ticks.max(mark + air + wide) - 0.55 * em;
            for (i, line) in named(y_name, height, em).into_iter().rev().enumerate() {
                let words = crate::backend::drawing::Words {
                    text: line.to_owned(),
                    at: [first - i as f64 * STEP * CAPTION * em, 0.5 * (top + bottom)],
                    // What is too long in two lines, too, is set in smaller letters: it must not run into its neighbours.
                    size: centred(room(height, em), line),
                    colour: BLACK,
                    anchor: (Across::Centre, Upright::Base),
                    upwards: true,
                };
                drawing.elements.push(crate::backend::drawing::Element::Words(words));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::format::Format;

    #[test]
    fn ticks_do_not_meet_at_any_width() {
        let mut checked = 0;
        for range in [0.0..1.0, -1e-5..3e-5, 1234.5..1234.6, 0.0..3000.0] {
            let axis = Axis::numbers(range);
            for length in [60.0, 100.0, 250.0, 900.0] {
                for em in [10.0, 15.0] {
                    let ticks = across(&axis, length, em);
                    let place = |tick: &(f64, String)| axis.part(tick.0) * length;
                    for pair in ticks.windows(2).filter(|_| ticks.len() > 3) {
                        let half = 0.5 * TICK * em * (width(&pair[0].1) + width(&pair[1].1));
                        assert!(place(&pair[1]) - place(&pair[0]) > half, "{pair:?} {length}");
                        checked += 1;
                    }
                }
            }
        }
        assert!(checked > 40, "{checked}");
    }

    #[test]
    fn a_point_lies_in_proportion() {
        let corners = [[10.0, 20.0], [110.0, 220.0]];
        let frame = Frame { corners, x: Axis::numbers(0.0..2.0), y: Axis::numbers(-1.0..1.0), ticks: 0.0 };
        assert_eq!(frame.place((0.5, 0.5)), [35.0, 70.0]);
        let page = Page::from(Format::Svg);
        let mut drawing = Drawing::new([150.0, 260.0], "");
        frame.grid(&mut drawing, &page);
        frame.axes(&mut drawing, ["ω", "γ₂"], &page);
        assert!(drawing.elements.len() > 15);
        let of = |name: &str| left_of(&frame.y, name, 200.0, &page);
        assert!(of("γ₂") > of(""));
        // A name that does not fit stands in two lines, both of them in letters of the usual size.
        let long = "margin, the smallest distance to a barrier";
        assert_eq!(named(long, 200.0, page.font), ["margin, the smallest", "distance to a barrier"]);
        assert_eq!((named(long, 900.0, page.font), named("", 9.0, page.font).len()), (vec![long], 0));
        assert!(of(long) > of("γ₂") + page.font);
    }
}
