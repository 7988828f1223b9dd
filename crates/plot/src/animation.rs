//! The chain between its barriers, moving: GIF, APNG, or an SVG that moves by itself.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

use tiny_skia::Pixmap;

use crate::axis::Axis;
use crate::curves::EDGE;
use crate::drawing::{BLACK, DIM, Drawing, Line, Place, Rgb};
use crate::format::PlotError;
use crate::frame::{Frame, below, left_of};
use crate::page::Page;
use crate::palette::LINES;
use crate::pixels::{over, raster};
use crate::svg::{number, with_elements};
use crate::words::Heading;

/// Kinds of files that move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moving {
    /// Pixels of at most 256 colours; everything shows them.
    Gif,
    /// Pixels; what does not know how shows the first picture.
    Png,
    /// Vectors.
    Svg,
}

impl Moving {
    /// By the file's ending, `.gif`, `.png` or `.svg`.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "gif" => Some(Self::Gif),
            "png" => Some(Self::Png),
            "svg" => Some(Self::Svg),
            _ => None,
        }
    }
}

/// All masses at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Instant {
    /// Displacements, layer by layer.
    pub displacement: Vec<f64>,
    /// Masses that have met a barrier since the instant before: site through all layers, and whether it was the upper one.
    pub impacts: Vec<(usize, bool)>,
}

/// A chain that moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// Line above it.
    pub title: String,
    /// Positions of the two barriers.
    pub barriers: (f64, f64),
    /// Masses of one layer.
    pub length: usize,
    /// The site on the left, −⌊(M−1)/2⌋ on a ring, otherwise 0.
    pub lowest: i64,
    /// What is shown, at equal distances in time; at the end it begins again.
    pub instants: Vec<Instant>,
}

/// The most masses that can be told apart, and the most layers.
pub const MOST_MASSES: usize = 400;
const MOST_LAYERS: usize = 8;

/// Pictures a second.
const RATE: f64 = 25.0;

/// Pictures for which an impact glows, each weaker.
const GLOW: usize = 4;

/// Width, and height of the panel of a layer.
const WIDTH: f64 = 860.0;
const BAND: f64 = 250.0;

/// More masses than this are not joined by lines: they lie close enough.
const JOINED: usize = 64;

const HIT: Rgb = [214, 60, 40];

/// The bytes of the file.
///
/// # Errors
/// [`PlotError`] of no instants, or more masses than can be told apart.
pub fn animation(picture: &Animation, moving: Moving, page: impl Into<Page>) -> Result<Vec<u8>, PlotError> {
    let page = page.into();
    let masses = picture.instants.first().map_or(0, |instant| instant.displacement.len());
    let layers = masses.checked_div(picture.length).unwrap_or(0);
    if masses == 0 || masses > MOST_MASSES || layers > MOST_LAYERS {
        let message =
            format!("{masses} masses in {layers} layers cannot be told apart: at most {MOST_MASSES} in {MOST_LAYERS}");
        return Err(PlotError(message));
    }
    let stage = Stage::new(picture, layers, page);
    page.holds(stage.ground.size)?;
    match moving {
        Moving::Svg => Ok(stage.svg()),
        Moving::Gif => stage.gif(),
        Moving::Png => stage.png(),
    }
}

/// What stands still, and where masses move.
struct Stage<'a> {
    picture: &'a Animation,
    page: Page,
    ground: Drawing,
    frames: Vec<Frame>,
    radius: f64,
    /// Where the time that has passed is shown: from, to, and how high.
    clock: [f64; 3],
}

impl<'a> Stage<'a> {
    fn new(picture: &'a Animation, layers: usize, page: Page) -> Self {
        let (em, wide) = (page.font, page.width.unwrap_or(page.px(WIDTH)));
        let heading = Heading::new(&picture.title, wide - 2.0 * EDGE * em, 1.07 * em);
        let (lower, upper) = picture.barriers;
        let air = 0.12 * (upper - lower);
        let y = Axis::numbers(lower - air..upper + air);
        let x = Axis::numbers(picture.lowest as f64 - 0.8..(picture.lowest + picture.length as i64) as f64 - 0.2);
        let band = wide * BAND / WIDTH;
        let left = page.snap(left_of(&y, true, band, &page) + 0.3 * em);
        let top = 1.5 * EDGE * em + heading.height();
        let mut ground =
            Drawing::new([wide, top + (layers as f64) * (band + below(true, &page)) + 0.6 * em], &picture.title);
        heading.draw(&mut ground, [EDGE * em, EDGE * em], BLACK);
        let mut frames = Vec::new();
        for layer in 0..layers {
            let above = top + layer as f64 * (band + below(true, &page)) + 0.7 * em;
            let corners = [[left, page.snap(above)], [page.snap(wide - 1.4 * em), page.snap(above + band - 0.7 * em)]];
            let frame = Frame { corners, x: x.clone(), y: y.clone() };
            for barrier in [lower, upper] {
                let y = frame.place((0.0, barrier))[1];
                ground.line(vec![[corners[0][0], y], [corners[1][0], y]], Line::new(DIM, page.px(2.0)).crisp());
            }
            let name = if layers == 1 { "site".to_owned() } else { format!("site, layer {layer}") };
            frame.axes(&mut ground, [&name, "displacement u"], &page);
            frames.push(frame);
        }
        let spacing =
            frames.first().map_or(wide, |frame| frame.corners[1][0] - frame.corners[0][0]) / picture.length as f64;
        let clock = [left, wide - 1.4 * em, top + 0.25 * em];
        Self { picture, page, ground, frames, radius: (0.4 * spacing).clamp(page.px(1.0), page.px(7.0)), clock }
    }

    /// Where a mass stands.
    fn place(&self, mass: usize, u: f64) -> Option<Place> {
        let Animation { length, lowest, .. } = self.picture;
        let frame = self.frames.get(mass / length)?;
        let site = (mass % length) as i64;
        // A ring is cut open across from site 0.
        let n = if site >= lowest + *length as i64 { site - *length as i64 } else { site };
        Some(frame.place((n as f64, u)))
    }

    /// The masses of each layer from left to right.
    fn rows(&self) -> impl Iterator<Item = Vec<usize>> {
        let Animation { length, lowest, .. } = self.picture;
        let (length, lowest) = (*length, *lowest);
        (0..self.frames.len()).map(move |layer| {
            let from = lowest..lowest + length as i64;
            from.map(|n| layer * length + n.rem_euclid(length as i64) as usize).collect()
        })
    }

    /// How brightly an impact of a mass on a barrier glows at an instant, from 0 to 1.
    fn glow(&self, at: usize, impact: (usize, bool)) -> f64 {
        let instants = &self.picture.instants;
        let since = (0..GLOW.min(instants.len())).find(|since| {
            // What happened at the end glows at the beginning: it goes round.
            instants[(at + instants.len() - since) % instants.len()].impacts.contains(&impact)
        });
        since.map_or(0.0, |since| 1.0 - since as f64 / GLOW as f64)
    }

    /// All impacts there are, each once.
    fn impacts(&self) -> Vec<(usize, bool)> {
        let mut all: Vec<(usize, bool)> =
            self.picture.instants.iter().flat_map(|instant| instant.impacts.iter().copied()).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    fn barrier(&self, (mass, upper): (usize, bool)) -> Option<Place> {
        self.place(mass, if upper { self.picture.barriers.1 } else { self.picture.barriers.0 })
    }

    /// What moves, at an instant.
    fn drawing(&self, at: usize, impacts: &[(usize, bool)]) -> Drawing {
        let mut drawing = Drawing::new(self.ground.size, "");
        let u = &self.picture.instants[at].displacement;
        let place = |mass: usize| self.place(mass, u.get(mass).copied().unwrap_or(0.0));
        if self.picture.length <= JOINED {
            for row in self.rows() {
                drawing
                    .line(row.iter().filter_map(|mass| place(*mass)).collect(), Line::new(LINES[5], self.page.px(1.0)));
            }
        }
        for &impact in impacts {
            let glow = self.glow(at, impact);
            if let (true, Some(centre)) = (glow > 0.0, self.barrier(impact)) {
                let ring = Line { opacity: glow, ..Line::new(HIT, self.page.px(3.0)) };
                drawing.circle(centre, self.radius + self.page.px(4.0), None, Some(ring));
            }
        }
        for mass in 0..u.len() {
            if let Some(centre) = place(mass) {
                drawing.circle(centre, self.radius, Some(LINES[0]), None);
            }
        }
        let [from, to, y] = self.clock;
        let part = (at + 1) as f64 / self.picture.instants.len() as f64;
        drawing.line(vec![[from, y], [from + part * (to - from), y]], Line::new(LINES[1], self.page.px(2.0)));
        drawing
    }

    /// All pictures, as pixels.
    fn pixmaps(&self) -> Result<impl Iterator<Item = Pixmap> + '_, PlotError> {
        let (ground, impacts) = (raster(&self.ground, self.page.scale())?, self.impacts());
        let scale = self.page.scale();
        Ok((0..self.picture.instants.len()).map(move |at| over(&ground, &self.drawing(at, &impacts), scale)))
    }

    fn svg(&self) -> Vec<u8> {
        let instants = &self.picture.instants;
        let seconds = number(instants.len() as f64 / RATE);
        let moves = |name: &str, mode: &str, values: String| {
            format!(
                "<animate attributeName=\"{name}\" dur=\"{seconds}s\" repeatCount=\"indefinite\"{mode} values=\"{values}\"/>"
            )
        };
        // The last value is the first again, so that nothing jumps that does not.
        let over_time = |value: &dyn Fn(usize) -> String| {
            (0..=instants.len()).map(|at| value(at % instants.len())).collect::<Vec<_>>().join(";")
        };
        let place = |at: usize, mass: usize| {
            self.place(mass, instants[at].displacement.get(mass).copied().unwrap_or(0.0)).unwrap_or([0.0; 2])
        };
        let tenth = |value: f64| number((10.0 * value).round() / 10.0);
        let mut text = String::new();
        let hex = |[r, g, b]: Rgb| format!("#{r:02x}{g:02x}{b:02x}");
        if self.picture.length <= JOINED {
            for row in self.rows() {
                let points = |at: usize| {
                    let place = |mass: &usize| place(at, *mass).map(tenth).join(",");
                    row.iter().map(place).collect::<Vec<_>>().join(" ")
                };
                let (colour, moving) = (hex(LINES[5]), moves("points", "", over_time(&points)));
                let _ = writeln!(
                    text,
                    "<polyline fill=\"none\" stroke=\"{colour}\" points=\"{}\">{moving}</polyline>",
                    points(0)
                );
            }
        }
        for impact in self.impacts() {
            let Some([x, y]) = self.barrier(impact).map(|place| place.map(number)) else { continue };
            let glow = over_time(&|at| number(self.glow(at, impact)));
            let (colour, radius) = (hex(HIT), number(self.radius + self.page.px(4.0)));
            let moving = moves("opacity", " calcMode=\"discrete\"", glow);
            let _ = writeln!(
                text,
                "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"3\" opacity=\"0\">{moving}</circle>"
            );
        }
        for mass in 0..instants[0].displacement.len() {
            let [x, y] = place(0, mass).map(number);
            let moving = moves("cy", "", over_time(&|at| tenth(place(at, mass)[1])));
            let (colour, radius) = (hex(LINES[0]), number(self.radius));
            let _ = writeln!(text, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{colour}\">{moving}</circle>");
        }
        let [from, to, y] = self.clock.map(number);
        let moving = moves("x2", "", format!("{from};{to}"));
        let colour = hex(LINES[1]);
        let _ = writeln!(
            text,
            "<line x1=\"{from}\" y1=\"{y}\" x2=\"{from}\" y2=\"{y}\" stroke=\"{colour}\" stroke-width=\"2\">{moving}</line>"
        );
        with_elements(&self.ground, &text)
    }

    fn png(&self) -> Result<Vec<u8>, PlotError> {
        let failed = |error: png::EncodingError| PlotError(error.to_string());
        let (mut file, mut before): (Vec<u8>, Option<Pixmap>) = (Vec::new(), None);
        let pixmaps = self.pixmaps()?;
        let [width, height] = self.ground.size.map(|side| (side * self.page.scale()).round().max(1.0) as u32);
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_animated(self.picture.instants.len() as u32, 0).map_err(failed)?;
        encoder.set_frame_delay(1, RATE as u16).map_err(failed)?;
        let mut writer = encoder.write_header().map_err(failed)?;
        for pixmap in pixmaps {
            let [x, y, w, h] = before.as_ref().map_or([0, 0, width, height], |before| changed(before, &pixmap));
            writer.reset_frame_position().map_err(failed)?;
            writer.set_frame_dimension(w, h).map_err(failed)?;
            writer.set_frame_position(x, y).map_err(failed)?;
            writer.set_blend_op(png::BlendOp::Over).map_err(failed)?;
            let shown =
                |(now, before): (&[u8], &[u8])| if now == before { [0; 4] } else { [now[0], now[1], now[2], 255] };
            let rgba: Vec<u8> = match &before {
                Some(before) => {
                    within(&pixmap, [x, y, w, h]).zip(within(before, [x, y, w, h])).flat_map(shown).collect()
                }
                None => pixmap.data().to_vec(),
            };
            writer.write_image_data(&rgba).map_err(failed)?;
            before = Some(pixmap);
        }
        writer.finish().map_err(failed)?;
        Ok(file)
    }

    fn gif(&self) -> Result<Vec<u8>, PlotError> {
        let failed = |error: gif::EncodingError| PlotError(error.to_string());
        let [width, height] = self.ground.size.map(|side| (side * self.page.scale()).round().max(1.0) as u32);
        let (Ok(columns), Ok(rows)) = (u16::try_from(width), u16::try_from(height)) else {
            return Err(PlotError(format!("a GIF has at most 65535 pixels along a side, not {width} x {height}")));
        };
        let mut colours = Colours::of(self.pixmaps()?);
        let mut file = Vec::new();
        let mut encoder = gif::Encoder::new(&mut file, columns, rows, &colours.palette()).map_err(failed)?;
        encoder.set_repeat(gif::Repeat::Infinite).map_err(failed)?;
        let mut before: Option<Pixmap> = None;
        for pixmap in self.pixmaps()? {
            let bounds = before.as_ref().map_or([0, 0, width, height], |before| changed(before, &pixmap));
            let [left, top, wide, high] = bounds.map(|side| side as u16);
            let mut index = |pixel: &[u8]| colours.index([pixel[0], pixel[1], pixel[2]]);
            let buffer: Vec<u8> = match &before {
                // What does not change is left: that packs well.
                Some(before) => within(&pixmap, bounds)
                    .zip(within(before, bounds))
                    .map(|(now, before)| if now == before { LEFT } else { index(now) })
                    .collect(),
                None => within(&pixmap, bounds).map(index).collect(),
            };
            let delay = (100.0 / RATE) as u16;
            let frame = gif::Frame {
                delay,
                transparent: Some(LEFT),
                left,
                top,
                width: wide,
                height: high,
                buffer: Cow::Owned(buffer),
                ..gif::Frame::default()
            };
            encoder.write_frame(&frame).map_err(failed)?;
            before = Some(pixmap);
        }
        drop(encoder);
        Ok(file)
    }
}

/// The box, left, top, width and height, outside of which two pictures are the same; one pixel at least.
fn changed(before: &Pixmap, now: &Pixmap) -> [u32; 4] {
    let width = now.width();
    let differs = |i: &usize| before.data()[4 * i..4 * i + 3] != now.data()[4 * i..4 * i + 3];
    let (mut low, mut high) = ([u32::MAX; 2], [0_u32; 2]);
    for i in (0..now.pixels().len()).filter(differs) {
        let place = [i as u32 % width, i as u32 / width];
        (low, high) = ([0, 1].map(|k| low[k].min(place[k])), [0, 1].map(|k| high[k].max(place[k])));
    }
    if low[0] > high[0] { [0, 0, 1, 1] } else { [low[0], low[1], high[0] - low[0] + 1, high[1] - low[1] + 1] }
}

fn within(pixmap: &Pixmap, [x, y, w, h]: [u32; 4]) -> impl Iterator<Item = &[u8]> {
    let width = pixmap.width();
    (y..y + h)
        .flat_map(move |row| (x..x + w).map(move |column| &pixmap.data()[4 * (row * width + column) as usize..][..4]))
}

/// The number that stands for no colour.
const LEFT: u8 = 255;

/// At most 255 colours of many, the most frequent ones; others are the nearest of these.
struct Colours {
    chosen: Vec<Rgb>,
    known: HashMap<Rgb, u8>,
}

impl Colours {
    fn of(pixmaps: impl Iterator<Item = Pixmap>) -> Self {
        let mut counts: HashMap<Rgb, u64> = HashMap::new();
        for pixmap in pixmaps {
            for pixel in pixmap.data().chunks_exact(4) {
                *counts.entry([pixel[0], pixel[1], pixel[2]]).or_default() += 1;
            }
        }
        let mut all: Vec<(u64, Rgb)> = counts.into_iter().map(|(colour, count)| (count, colour)).collect();
        // Equal counts in the order of colours, so that the file is the same every time.
        all.sort_unstable_by(|one, other| other.cmp(one));
        Self { chosen: all.into_iter().take(LEFT.into()).map(|(_, colour)| colour).collect(), known: HashMap::new() }
    }

    fn palette(&self) -> Vec<u8> {
        // As many as there are numbers, or a reader might not know the last.
        self.chosen.iter().copied().chain(std::iter::repeat([255; 3])).take(256).flatten().collect()
    }

    fn index(&mut self, colour: Rgb) -> u8 {
        let chosen = &self.chosen;
        *self.known.entry(colour).or_insert_with(|| {
            let far =
                |other: &Rgb| other.iter().zip(colour).map(|(a, b)| (i32::from(*a) - i32::from(b)).pow(2)).sum::<i32>();
            let nearest = chosen.iter().enumerate().min_by_key(|(_, other)| far(other));
            // There are 255 at most.
            nearest.map_or(0, |(i, _)| i as u8)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Format;

    fn swing(length: usize, layers: usize, count: usize) -> Animation {
        let instant = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / count as f64;
            let mut displacement = vec![0.1; length * layers];
            displacement[0] = 0.4 + angle.cos();
            let impacts = if k == 0 { vec![(0, true)] } else { Vec::new() };
            Instant { displacement, impacts }
        };
        let lowest = -((length - 1) as i64 / 2);
        let instants = (0..count).map(instant).collect();
        Animation { title: "γ₂ = 0.1".to_owned(), barriers: (-0.6, 1.4), length, lowest, instants }
    }

    /// The frames of a GIF as whole pictures.
    fn frames(file: &[u8]) -> Vec<Vec<u8>> {
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(file).unwrap();
        let (width, height) = (decoder.width() as usize, decoder.height() as usize);
        let (mut canvas, mut all) = (vec![0; 4 * width * height], Vec::new());
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            for row in 0..frame.height as usize {
                let wide = 4 * frame.width as usize;
                let to = 4 * ((frame.top as usize + row) * width + frame.left as usize);
                for (to, from) in canvas[to..to + wide].chunks_mut(4).zip(frame.buffer[wide * row..].chunks(4)) {
                    if from[3] > 0 {
                        to.copy_from_slice(from);
                    }
                }
            }
            all.push(canvas.clone());
        }
        all
    }

    #[test]
    fn masses_are_where_they_are_at_each_instant_and_impacts_glow() {
        let picture = swing(5, 1, 16);
        let page = Page::from(Format::Png);
        let all = frames(&animation(&picture, Moving::Gif, page).unwrap());
        assert_eq!(all.len(), 16);
        let stage = Stage::new(&picture, 1, page);
        let width = stage.ground.size[0].round() as usize;
        let colour = |at: usize, [x, y]: Place| {
            let first = 4 * (y.round() as usize * width + x.round() as usize);
            [all[at][first], all[at][first + 1], all[at][first + 2]]
        };
        for (at, instant) in picture.instants.iter().enumerate() {
            for (mass, u) in instant.displacement.iter().enumerate() {
                let found = colour(at, stage.place(mass, *u).unwrap());
                assert!(found.iter().zip(LINES[0]).all(|(a, b)| a.abs_diff(b) < 8), "{at} {mass} {found:?}");
            }
        }
        let glowing: Vec<usize> = (0..16).filter(|at| stage.glow(*at, (0, true)) > 0.0).collect();
        assert_eq!(glowing, [0, 1, 2, 3]);
        let [x, y] = stage.barrier((0, true)).unwrap();
        let ring = [x, y - stage.radius - 4.0];
        assert!(colour(0, ring)[0] > 180 && colour(0, ring)[2] < 90 && colour(8, ring) == [255; 3]);
    }

    #[test]
    fn files_are_small_and_of_their_kinds() {
        for (length, layers, most) in [(21, 1, 150_000), (200, 1, 400_000), (9, 3, 200_000)] {
            let picture = swing(length, layers, 64);
            let of = |moving| animation(&picture, moving, Format::Png).unwrap();
            let (gif, png, svg) = (of(Moving::Gif), of(Moving::Png), of(Moving::Svg));
            assert!(gif.starts_with(b"GIF89a") && png.starts_with(b"\x89PNG") && svg.starts_with(b"<svg"));
            assert!(png.windows(4).filter(|name| *name == b"fcTL").count() == 64);
            let sizes = [gif.len(), png.len(), svg.len()];
            assert!(sizes.iter().all(|size| *size < most), "{length} {sizes:?}");
            let svg = String::from_utf8(svg).unwrap();
            assert_eq!(svg.matches("attributeName=\"cy\"").count(), length * layers);
        }
        let none = Animation { instants: Vec::new(), ..swing(3, 1, 4) };
        assert!(animation(&none, Moving::Gif, Format::Png).is_err());
        assert!(animation(&swing(401, 1, 2), Moving::Svg, Format::Svg).unwrap_err().0.contains("at most 400"));
    }
}
