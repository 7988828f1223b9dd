//! A map with all that stands about it: headings, frame, axes, legend.

use std::ops::Range;

use vibrochain_floquet::Mechanism;
use vibrochain_maps::cell::Class;

use crate::axes::axis::Axis;
use crate::axes::frame::{Frame, below, left_of};
use crate::backend::canvas::render;
use crate::backend::drawing::{BLACK, DIM, Drawing, Pattern, Place};
use crate::backend::format::PlotError;
use crate::backend::page::Page;
use crate::backend::strokes::Borders;
use crate::map::classes::{UNKNOWN, loss};
use crate::map::key::{Entry, draw_flow, draw_list, flow, list_height, list_width};
use crate::map::mapped::{MapAxis, Mapped};
use crate::map::palette::{Palette, Tile, sample};
use crate::map::quantity::Bar;
use crate::text::headings::{CAPTION, EDGE, Heading};

/// About this wide and high the map itself becomes on a screen.
pub(crate) const TARGET: f64 = 900.0;

/// Size of the title against the letters of legends: a map is as large as two panels.
const TITLE: f64 = 1.45;

/// A page so many em wide has its legend beside the map; on a narrower one it stands below.
const WIDE: f64 = 46.0;

/// Air between map and legend, and at the right edge, in em.
const GAP: f64 = 1.6;
const RIGHT: f64 = 1.3;

/// A map with all that stands about it.
pub(crate) struct Sheet<'a> {
    pub(crate) scene: &'a dyn Mapped,
    pub(crate) axes: [MapAxis; 2],
    /// What the map spans of each axis.
    pub(crate) spans: [Range<f64>; 2],
    /// A line under the heading that says what is fixed; others, if there are any.
    pub(crate) notes: Vec<String>,
    /// A bar of colours, and the palette it is from.
    pub(crate) bar: Option<(Bar, Palette)>,
    pub(crate) entries: Vec<Entry<'a>>,
}

/// Where the map of a sheet goes.
pub(crate) struct Placed {
    frame: Frame,
    headings: Vec<Heading>,
    size: Place,
    beside: bool,
    pub(crate) page: Page,
}

impl Placed {
    /// The upper left and lower right corner of the map.
    pub(crate) fn corners(&self) -> [Place; 2] {
        self.frame.corners
    }

    /// A place of the map, from its parts from the left and from above.
    pub(crate) fn within(&self, [x, y]: [f64; 2]) -> Place {
        let [[left, top], [right, bottom]] = self.frame.corners;
        [left + x * (right - left), top + y * (bottom - top)]
    }
}

impl<'a> Sheet<'a> {
    /// Of a scene, the map alone: nothing of its legend yet.
    pub(crate) fn new(scene: &'a dyn Mapped, axes: [MapAxis; 2], spans: [Range<f64>; 2]) -> Self {
        Self { scene, axes, spans, notes: scene.notes(), bar: None, entries: Vec::new() }
    }

    /// Adds entries for classes and mechanisms that occur.
    pub(crate) fn tell_classes(&mut self, tiles: &[Tile], palette: Palette) {
        let classes = Class::ALL.into_iter().map(Some).chain([None]);
        for class in classes.filter(|class| tiles.iter().any(|tile| tile.class == *class)) {
            let all: Vec<Class> = tiles.iter().filter_map(|tile| tile.class).collect();
            let words = class.map_or(UNKNOWN.to_owned(), |class| self.scene.class(class, &all));
            let tile = Tile { class, mechanism: None };
            self.entries.push(Entry::Sample(Box::new(move |x, y| palette.pixel(tile, x, y)), words));
        }
        let all = [Mechanism::NeimarkSacker, Mechanism::PeriodDoubling, Mechanism::PlusOne, Mechanism::Pitchfork];
        let mut occur = all.into_iter().filter(|one| tiles.iter().any(|tile| tile.mechanism == Some(*one))).peekable();
        if occur.peek().is_some() {
            self.entries.push(Entry::Heading("stability is lost by".to_owned()));
        }
        for mechanism in occur {
            let texture = Box::new(move |x, y| sample(mechanism, x, y));
            self.entries.push(Entry::Sample(texture, loss(mechanism).to_owned()));
        }
    }

    /// Adds entries for kinds of borders.
    pub(crate) fn tell_borders(&mut self, all: &[Borders<'_>]) {
        if !all.is_empty() {
            self.entries.push(Entry::Heading("borders".to_owned()));
        }
        let entry = |borders: &Borders<'_>| Entry::Stroke(borders.colour, borders.dash, borders.kind.to_owned());
        self.entries.extend(all.iter().map(entry));
    }

    /// Finds a place for a map of so many cells along its axes: each cell the same whole number of pixels as far as the page has
    /// that many.
    pub(crate) fn placed(&self, cells: [usize; 2], page: Page) -> Placed {
        let em = page.font;
        let y_axis = Axis::swept(&self.axes[1].values, self.spans[1].clone());
        let left =
            page.snap(left_of(&y_axis, &self.axes[1].label, 0.6 * page.width.unwrap_or(TARGET), &page) + 0.3 * em);
        let bar = self.bar.map_or([0.0; 2], |(bar, _)| bar.size(&page));
        let list = list_width(&self.entries, &page);
        let beside = page.width.is_none_or(|wide| wide >= WIDE * em);
        let legend = if beside { GAP * em + bar[0].max(list) } else { 0.0 };
        let room = page.width.map_or(page.px(TARGET), |wide| (wide - left - legend - RIGHT * em).max(8.0 * em));
        let pixels = |cells: usize| {
            let most = (room * page.scale()).floor();
            let cells = cells.max(1) as f64;
            // A page that has fewer pixels than the map has cells shows their mean; on a screen the picture grows.
            if cells > most { if page.width.is_some() { most } else { cells } } else { cells * (most / cells).floor() }
        };
        let map = cells.map(|cells| pixels(cells) / page.scale());
        let wide = page.width.unwrap_or(left + map[0] + legend + RIGHT * em);
        let lines =
            [(self.scene.heading(), TITLE)].into_iter().chain(self.notes.iter().map(|note| (note.clone(), CAPTION)));
        // On a narrow page headings begin at its edge.
        let indent = if beside { left } else { EDGE * em };
        let headings: Vec<Heading> =
            lines.map(|(text, size)| Heading::new(&text, wide - indent - EDGE * em, size * em)).collect();
        let top = page.snap(EDGE * em + headings.iter().map(Heading::height).sum::<f64>() + 0.8 * em);
        let corners = [[left, top], [left + map[0], top + map[1]]];
        let foot = corners[1][1] + below(true, &page) + 0.5 * em;
        let height = if beside {
            foot.max(top + bar[1] + list_height(&self.entries, &page) + em)
        } else {
            let lying = self.bar.map_or(0.0, |(bar, _)| bar.lying(&page));
            foot + lying + flow(&self.entries, wide - 2.0 * EDGE * em, &page).1 + 0.5 * em
        };
        let x = Axis::swept(&self.axes[0].values, self.spans[0].clone());
        Placed { frame: Frame { corners, x, y: y_axis, ticks: 0.0 }, headings, size: [wide, height], beside, page }
    }

    /// The bytes of the picture: what `ground` draws, then all that stands about it.
    pub(crate) fn bytes(
        &self,
        placed: &Placed,
        patterns: Vec<Pattern>,
        ground: impl FnOnce(&mut Drawing),
    ) -> Result<Vec<u8>, PlotError> {
        let Placed { frame, headings, size, beside, page } = placed;
        page.holds(*size)?;
        if page.measures {
            return Ok(Vec::new());
        }
        let em = page.font;
        let told: Vec<String> = [self.scene.heading()].into_iter().chain(self.notes.iter().cloned()).collect();
        let mut drawing = Drawing::new(*size, &told.join(", "));
        drawing.patterns = patterns;
        let [[left, top], [right, _]] = frame.corners;
        let mut y = EDGE * em;
        for (i, heading) in headings.iter().enumerate() {
            heading.draw(&mut drawing, [if *beside { left } else { EDGE * em }, y], if i == 0 { BLACK } else { DIM });
            y += heading.height();
        }
        ground(&mut drawing);
        frame.axes(&mut drawing, [&self.axes[0].label, &self.axes[1].label], page);
        let (x, mut y) = (right + GAP * em, top);
        if let Some((bar, palette)) = self.bar.as_ref().filter(|_| *beside) {
            bar.draw(&mut drawing, *palette, [x, y], page);
            y += bar.size(page)[1];
        }
        if *beside {
            draw_list(&mut drawing, &self.entries, [x, y], page);
        } else {
            let room = size[0] - 2.0 * EDGE * em;
            let at = [EDGE * em, size[1] - 0.5 * em - flow(&self.entries, room, page).1];
            draw_flow(&mut drawing, &self.entries, at, room, page);
            if let Some((bar, palette)) = &self.bar {
                bar.draw_lying(&mut drawing, *palette, [at[0], at[1] - bar.lying(page)], room, page);
            }
        }
        render(&drawing, page)
    }
}
