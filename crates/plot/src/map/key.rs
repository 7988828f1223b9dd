//! What stands beside a map and tells its colours: samples, lines and a bar.

use crate::backend::drawing::{Across, BLACK, DIM, Drawing, Line, Place, Rgb, Upright, sides};
use crate::backend::page::Page;
use crate::map::classes::{NOTHING, UNKNOWN};
use crate::map::palette::Palette;
use crate::map::quantity::{Bar, Shade};
use crate::text::font::width;

/// An entry.
pub(crate) enum Entry<'a> {
    /// What the entries after it have in common.
    Heading(String),
    /// A sample of a raster, and what it means.
    Sample(Box<dyn Fn(u32, u32) -> Rgb + 'a>, String),
    /// A line, and what it means.
    Stroke(Rgb, Option<[f64; 2]>, String),
}

/// In em: the sample of an entry, the air beside it, the heights of entries and of headings.
const SAMPLE: [f64; 2] = [2.1, 1.6];
const BESIDE: f64 = 0.7;
const ROW: f64 = 2.25;
const HEADING: f64 = 2.4;
/// Between entries that stand side by side.
const BETWEEN: f64 = 1.6;

/// Sizes of letters against those of legends.
const TEXT: f64 = 1.1;
const SMALL: f64 = 1.0;

impl Entry<'_> {
    /// Its size in em.
    fn size(&self) -> [f64; 2] {
        match self {
            Self::Heading(text) => [SMALL * width(text), HEADING],
            Self::Sample(_, text) => [SAMPLE[0] + BESIDE + TEXT * width(text), ROW],
            Self::Stroke(.., text) => [SAMPLE[0] + BESIDE + TEXT * width(text), ROW],
        }
    }

    fn draw(&self, drawing: &mut Drawing, [x, y]: Place, page: &Page) {
        let em = page.font;
        let middle = y + 0.5 * ROW * em;
        match self {
            Self::Heading(text) => drawing.words(text, [x, y + 0.62 * HEADING * em], SMALL * em, DIM),
            Self::Sample(pixel, text) => {
                sample(drawing, pixel, [x, middle - 0.5 * SAMPLE[1] * em], page);
                drawing.words(text, [x + (SAMPLE[0] + BESIDE) * em, middle], TEXT * em, BLACK);
            }
            Self::Stroke(colour, dash, text) => {
                let mut line = Line::new(*colour, page.px(if dash.is_some() { 1.4 } else { 2.0 }));
                line.dash = dash.map(|dash| dash.map(|part| page.px(part)));
                drawing.line(vec![[x, middle], [x + SAMPLE[0] * em, middle]], line);
                drawing.words(text, [x + (SAMPLE[0] + BESIDE) * em, middle], TEXT * em, BLACK);
            }
        }
    }
}

/// How many pixels of a raster make one of a texture: it keeps its size on paper.
pub(crate) fn texture(page: &Page) -> u32 {
    (page.scale() * page.px(1.0)).round().max(1.0) as u32
}

fn sample(drawing: &mut Drawing, pixel: &dyn Fn(u32, u32) -> Rgb, [x, y]: Place, page: &Page) {
    let at = [page.snap(x), page.snap(y)];
    let pixels = page.pixels(SAMPLE.map(|side| side * page.font));
    let [wide, high] = pixels.map(|side| f64::from(side) / page.scale());
    let corners = [at, [at[0] + wide, at[1] + high]];
    let times = texture(page);
    let rgb = (0..pixels[1]).flat_map(|py| (0..pixels[0]).flat_map(move |px| pixel(px / times, py / times)));
    drawing.image(corners, pixels, rgb.collect());
    drawing.frame(corners, Line::new(BLACK, page.px(1.0)).crisp());
}

/// The width of entries below each other.
pub(crate) fn list_width(entries: &[Entry<'_>], page: &Page) -> f64 {
    entries.iter().map(|entry| entry.size()[0]).fold(0.0, f64::max) * page.font
}

pub(crate) fn list_height(entries: &[Entry<'_>], page: &Page) -> f64 {
    entries.iter().map(|entry| entry.size()[1]).sum::<f64>() * page.font
}

/// Draws entries below each other.
pub(crate) fn draw_list(drawing: &mut Drawing, entries: &[Entry<'_>], [x, mut y]: Place, page: &Page) {
    for entry in entries {
        entry.draw(drawing, [x, y], page);
        y += entry.size()[1] * page.font;
    }
}

/// Places of entries side by side, in rows of no more than a width; and their height.
pub(crate) fn flow(entries: &[Entry<'_>], room: f64, page: &Page) -> (Vec<Place>, f64) {
    let em = page.font;
    let (mut x, mut y, mut places) = (0.0, 0.0, Vec::new());
    for entry in entries {
        let [wide, _] = entry.size();
        if x > 0.0 && (x + wide * em > room || matches!(entry, Entry::Heading(_))) {
            (x, y) = (0.0, y + ROW * em);
        }
        places.push([x, y]);
        x += (wide + BETWEEN) * em;
    }
    let height = if places.is_empty() { 0.0 } else { y + ROW * em };
    (places, height)
}

pub(crate) fn draw_flow(drawing: &mut Drawing, entries: &[Entry<'_>], [x, y]: Place, room: f64, page: &Page) {
    for (entry, [dx, dy]) in entries.iter().zip(flow(entries, room, page).0) {
        let at = [x + dx, y + dy];
        match entry {
            // On one line with what stands beside it.
            Entry::Heading(text) => {
                drawing.words(text, [at[0], at[1] + 0.5 * ROW * page.font], SMALL * page.font, DIM);
            }
            _ => entry.draw(drawing, at, page),
        }
    }
}

/// Draws a bar of colours into a box, along its longer side from 0 at the left or at its foot to 1, and hands back what its edges are drawn
/// with.
pub(crate) fn colour_bar(drawing: &mut Drawing, corners: [Place; 2], colour: impl Fn(f64) -> Rgb, page: &Page) -> Line {
    let [columns, rows] = page.pixels(sides(corners));
    let lies = columns > rows;
    let count = columns.max(rows);
    let part = |i: u32| (f64::from(i) + 0.5) / f64::from(count);
    let colours = (0..count).flat_map(|i| colour(if lies { part(i) } else { 1.0 - part(i) }));
    drawing.image(corners, if lies { [count, 1] } else { [1, count] }, colours.collect());
    let line = Line::new(BLACK, page.px(1.0)).crisp();
    drawing.frame(corners, line);
    line
}

/// Width and height of a bar of colours, and the height of its heading, in em.
const BAR: [f64; 2] = [1.7, 15.0];
/// Its length where it lies below a map, so that ten ticks have room; and the height of those with some air.
const LYING: f64 = 28.0;
const BELOW: f64 = 2.6;
const NAME: f64 = 2.0;

impl Bar {
    /// Entries for what is not on the bar; of few whole numbers, for all.
    pub(crate) fn entries(self, palette: Palette) -> Vec<Entry<'static>> {
        let colours = self.colours;
        let patch = |shade: Shade, words: String| {
            Entry::Sample(Box::new(move |x, y| colours.pixel(palette, shade, x, y)), words)
        };
        let mut all = Vec::new();
        if let Some(most) = self.patches() {
            all.push(Entry::Heading(self.heading().to_owned()));
            all.extend((1..=most).map(|number| patch(Shade::Number(number as f32), number.to_string())));
        }
        if self.below {
            // Any number that is below.
            all.push(patch(Shade::Number(f32::NEG_INFINITY), self.below_words()));
        }
        if self.nothing {
            all.push(patch(Shade::Nothing, NOTHING.to_owned()));
        }
        if self.unknown {
            all.push(patch(Shade::Unknown, UNKNOWN.to_owned()));
        }
        all
    }

    /// Width and height of the bar itself with its ticks and its name; none if it has patches.
    pub(crate) fn size(&self, page: &Page) -> [f64; 2] {
        if self.patches().is_some() {
            return [0.0; 2];
        }
        let ticks = self.ticks().iter().map(|(_, words)| width(words)).fold(0.0, f64::max);
        let wide = (BAR[0] + 0.7 + ticks).max(SMALL * width(self.heading()));
        [wide * page.font, (NAME + BAR[1] + 1.0) * page.font]
    }

    /// The height of the bar as it lies below a map, with its name and its ticks; none if it has patches.
    pub(crate) fn lying(&self, page: &Page) -> f64 {
        if self.patches().is_some() { 0.0 } else { (NAME + BAR[0] + BELOW) * page.font }
    }

    /// Draws it so from a place down, no longer than `room`.
    pub(crate) fn draw_lying(&self, drawing: &mut Drawing, palette: Palette, [x, y]: Place, room: f64, page: &Page) {
        if self.patches().is_some() {
            return;
        }
        let em = page.font;
        drawing.words(self.heading(), [x, y + 0.4 * NAME * em], SMALL * em, DIM);
        // The words of ticks at its ends stand out by half of their length.
        let ticks = self.ticks();
        let air = ticks.iter().map(|(_, words)| 0.5 * em * width(words)).fold(0.0, f64::max);
        let (left, top) = (page.snap(x + air), y + NAME * em);
        let (wide, foot) = ((room - 2.0 * air).min(LYING * em), top + BAR[0] * em);
        let line = colour_bar(drawing, [[left, top], [left + wide, foot]], |part| palette.scale(part), page);
        for (part, words) in ticks {
            let at = left + part * wide;
            drawing.line(vec![[at, foot], [at, foot + 0.3 * em]], line);
            drawing.anchored(&words, [at, foot + 0.5 * em], em, BLACK, (Across::Centre, Upright::Top));
        }
    }

    /// Draws it from a place down.
    pub(crate) fn draw(&self, drawing: &mut Drawing, palette: Palette, [x, y]: Place, page: &Page) {
        if self.patches().is_some() {
            return;
        }
        let em = page.font;
        drawing.words(self.heading(), [x, y + 0.4 * NAME * em], SMALL * em, DIM);
        let (top, [wide, high]) = (y + NAME * em, BAR.map(|side| side * em));
        let line = colour_bar(drawing, [[x, top], [x + wide, top + high]], |part| palette.scale(part), page);
        for (part, words) in self.ticks() {
            let at = top + (1.0 - part) * high;
            drawing.line(vec![[x + wide, at], [x + wide + 0.3 * em, at]], line);
            drawing.words(&words, [x + wide + 0.6 * em, at], em, BLACK);
        }
    }
}
