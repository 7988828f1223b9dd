//! A chain that moves, in pixels: GIF and APNG, each picture no more than what has changed.

use std::borrow::Cow;
use std::collections::HashMap;

use tiny_skia::Pixmap;

use crate::backend::drawing::{Drawing, Line, Rgb};
use crate::backend::format::PlotError;
use crate::backend::pixels::{over, raster};
use crate::map::palette::LINES;
use crate::moving::backdrop::{Backdrop, HIT, JOINED};
use crate::moving::motion::RATE;

impl Backdrop<'_> {
    /// What moves, at an instant.
    fn drawing(&self, at: usize, impacts: &[(usize, bool)]) -> Drawing {
        let mut drawing = Drawing::new(self.background.size, "");
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
        let (background, impacts) = (raster(&self.background, self.page.scale())?, self.impacts());
        let scale = self.page.scale();
        Ok((0..self.picture.instants.len()).map(move |at| over(&background, &self.drawing(at, &impacts), scale)))
    }

    /// The bytes of an APNG.
    pub(crate) fn png(&self) -> Result<Vec<u8>, PlotError> {
        let failed = |error: png::EncodingError| PlotError(error.to_string());
        let (mut file, mut before): (Vec<u8>, Option<Pixmap>) = (Vec::new(), None);
        let pixmaps = self.pixmaps()?;
        let [width, height] = self.page.pixels(self.background.size);
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

    /// The bytes of a GIF.
    pub(crate) fn gif(&self) -> Result<Vec<u8>, PlotError> {
        let failed = |error: gif::EncodingError| PlotError(error.to_string());
        let [width, height] = self.page.pixels(self.background.size);
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
