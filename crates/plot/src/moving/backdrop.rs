//! What stands still in a moving picture, and where masses are at each instant.

use crate::axes::axis::Axis;
use crate::axes::frame::{Frame, below, left_of};
use crate::backend::drawing::{DIM, Drawing, Line, Place, Rgb};
use crate::backend::page::Page;
use crate::moving::motion::Animation;
use crate::text::headings::{CAPTION, Title};

/// Pictures for which an impact glows, each weaker.
const GLOW: usize = 4;

/// Width, and height of the panel of a layer.
const WIDTH: f64 = 860.0;
const BAND: f64 = 250.0;

/// More masses than this are not joined by lines: they lie close enough.
pub(crate) const JOINED: usize = 64;

/// Of impacts: red enough to be seen beside the masses.
pub(crate) const HIT: Rgb = [214, 60, 40];

/// The part of an animation that stays the same in all its pictures, and the place in which its masses move.
pub(crate) struct Backdrop<'a> {
    pub(crate) picture: &'a Animation,
    pub(crate) page: Page,
    pub(crate) background: Drawing,
    frames: Vec<Frame>,
    pub(crate) radius: f64,
    /// Where the time that has passed is shown: from, to, and how high.
    pub(crate) clock: [f64; 3],
}

impl<'a> Backdrop<'a> {
    pub(crate) fn new(picture: &'a Animation, layers: usize, page: Page) -> Self {
        let (em, wide) = (page.font, page.width.unwrap_or(page.px(WIDTH)));
        let title = Title::new(&picture.title, CAPTION, wide, em);
        let (lower, upper) = picture.barriers;
        let air = 0.12 * (upper - lower);
        let y = Axis::numbers(lower - air..upper + air);
        let x = Axis::numbers(picture.lowest as f64 - 0.8..(picture.lowest + picture.length as i64) as f64 - 0.2);
        let band = wide * BAND / WIDTH;
        let left = page.snap(left_of(&y, "displacement u", band, &page) + 0.3 * em);
        let top = title.foot();
        let mut background =
            Drawing::new([wide, top + (layers as f64) * (band + below(true, &page)) + 0.6 * em], &picture.title);
        title.draw(&mut background);
        let mut frames = Vec::new();
        for layer in 0..layers {
            let above = top + layer as f64 * (band + below(true, &page)) + 0.7 * em;
            let corners = [[left, page.snap(above)], [page.snap(wide - 1.4 * em), page.snap(above + band - 0.7 * em)]];
            let frame = Frame { corners, x: x.clone(), y: y.clone(), ticks: 0.0 };
            for barrier in [lower, upper] {
                let y = frame.place((0.0, barrier))[1];
                background.line(vec![[corners[0][0], y], [corners[1][0], y]], Line::new(DIM, page.px(2.0)).crisp());
            }
            let name = if layers == 1 { "site".to_owned() } else { format!("site, layer {layer}") };
            frame.axes(&mut background, [&name, "displacement u"], &page);
            frames.push(frame);
        }
        let spacing = frames.first().map_or(wide, |frame| frame.size()[0]) / picture.length as f64;
        let clock = [left, wide - 1.4 * em, top + 0.25 * em];
        Self { picture, page, background, frames, radius: (0.4 * spacing).clamp(page.px(1.0), page.px(7.0)), clock }
    }

    /// Where a mass stands.
    pub(crate) fn place(&self, mass: usize, u: f64) -> Option<Place> {
        let Animation { length, lowest, .. } = self.picture;
        let frame = self.frames.get(mass / length)?;
        let site = (mass % length) as i64;
        // A ring is cut open across from site 0.
        let n = if site >= lowest + *length as i64 { site - *length as i64 } else { site };
        Some(frame.place((n as f64, u)))
    }

    /// The masses of each layer from left to right.
    pub(crate) fn rows(&self) -> impl Iterator<Item = Vec<usize>> {
        let Animation { length, lowest, .. } = self.picture;
        let (length, lowest) = (*length, *lowest);
        (0..self.frames.len()).map(move |layer| {
            let from = lowest..lowest + length as i64;
            from.map(|n| layer * length + n.rem_euclid(length as i64) as usize).collect()
        })
    }

    /// How brightly an impact of a mass on a barrier glows at an instant, from 0 to 1.
    pub(crate) fn glow(&self, at: usize, impact: (usize, bool)) -> f64 {
        let instants = &self.picture.instants;
        let since = (0..GLOW.min(instants.len())).find(|since| {
            // What happened at the end glows at the beginning: it goes round.
            instants[(at + instants.len() - since) % instants.len()].impacts.contains(&impact)
        });
        since.map_or(0.0, |since| 1.0 - since as f64 / GLOW as f64)
    }

    /// All impacts there are, each once.
    pub(crate) fn impacts(&self) -> Vec<(usize, bool)> {
        let mut all: Vec<(usize, bool)> =
            self.picture.instants.iter().flat_map(|instant| instant.impacts.iter().copied()).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    pub(crate) fn barrier(&self, (mass, upper): (usize, bool)) -> Option<Place> {
        self.place(mass, if upper { self.picture.barriers.1 } else { self.picture.barriers.0 })
    }
}
