//! What becomes of perturbed breathers over a map: the most frequent end of each cell as its colour.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::element::{BitMapElement, Rectangle, Text};
use plotters::prelude::{BLACK, ChartBuilder, Color, DrawingArea, DrawingBackend, IntoFont, RGBColor, WHITE};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use vibrochain_maps::scene::{Axis, Scene};

use crate::axes::labelled_axes;
use crate::canvas::{Drawing, Format, PlotError, render};
use crate::map::TARGET;
use crate::sheet::{fixed, label, swatch};
use crate::ticks::{places, tick_at};
use crate::words::Heading;

/// Colours of the ends in their order: blues for what stays periodic, white for quiet, warm ones for what does not repeat, greys for what is
/// not known. Apart for colour-blind eyes.
const COLOURS: [[u8; 3]; 7] =
    [[16, 50, 98], [46, 134, 171], [250, 250, 235], [214, 60, 40], [250, 200, 90], [150, 150, 150], [90, 90, 90]];

/// Of cells from which no run has started.
const NONE: [u8; 3] = [225, 225, 225];

/// Pixels about the map.
const LEFT: u32 = 90;
const RIGHT: u32 = 260;
const BOTTOM: u32 = 74;
const EDGE: u32 = 12;

/// The least height, for the legend.
const LEAST: u32 = 360;

/// The most cells along an axis that are drawn.
pub const MOST_VALUES: usize = 6000;

/// What is drawn.
#[derive(Debug)]
pub struct EndsPicture<'a> {
    /// The scene, over two axes.
    pub scene: &'a Scene,
    /// The line under the title.
    pub caption: String,
    /// What the ends are called, at most seven.
    pub names: &'a [&'a str],
    /// Of each cell the number of its most frequent end; none without runs.
    pub cells: &'a [Option<usize>],
}

/// The bytes of the picture.
///
/// # Errors
/// [`PlotError`]; also of a scene that has not two axes, or more than 6000 values along one.
pub fn ends_picture(picture: &EndsPicture<'_>, format: Format) -> Result<Vec<u8>, PlotError> {
    let Some([x, y]) = picture.scene.plane() else {
        return Err(PlotError("a map has two axes".to_owned()));
    };
    if x.points().max(y.points()) > MOST_VALUES {
        return Err(PlotError(format!("more than {MOST_VALUES} values along an axis")));
    }
    let cell = [x, y].map(|axis| (TARGET / axis.points()).clamp(1, 60) as u32);
    let size = [x.points() as u32 * cell[0], y.points() as u32 * cell[1]];
    let width = size[0] + LEFT + RIGHT;
    let texts = [(picture.scene.heading(), 22), (fixed(picture.scene), 16), (picture.caption.clone(), 16)];
    let headings = texts.map(|(text, letters)| Heading::new(&text, width - LEFT - EDGE, letters));
    let top = 22 + headings.iter().map(Heading::height).sum::<u32>();
    let sheet = Sheet { picture, axes: [x, y], cell, size, headings, top };
    render(&sheet, format, (width, size[1].max(LEAST) + top + BOTTOM))
}

struct Sheet<'a> {
    picture: &'a EndsPicture<'a>,
    axes: [&'a Axis; 2],
    cell: [u32; 2],
    size: [u32; 2],
    headings: [Heading; 3],
    top: u32,
}

fn colour(end: Option<usize>) -> [u8; 3] {
    end.and_then(|end| COLOURS.get(end)).copied().unwrap_or(NONE)
}

impl Sheet<'_> {
    fn raster(&self) -> Vec<u8> {
        let (columns, rows) = (self.axes[0].points(), self.axes[1].points());
        let mut pixels = Vec::with_capacity(3 * (self.size[0] * self.size[1]) as usize);
        for py in 0..self.size[1] {
            let row = rows - 1 - (py / self.cell[1]) as usize;
            for px in 0..self.size[0] {
                let place = row * columns + (px / self.cell[0]) as usize;
                pixels.extend(colour(self.picture.cells.get(place).copied().flatten()));
            }
        }
        pixels
    }

    /// A cell covers half a step on either side of its value.
    fn span(&self, i: usize) -> Range<f64> {
        let (from, step) = places(self.axes[i]);
        from - 0.5 * step..from + step * (self.axes[i].points() as f64 - 0.5)
    }
}

impl Drawing for Sheet<'_> {
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        area.fill(&WHITE).map_err(PlotError::from)?;
        let (left, mut line) = (LEFT as i32, 10);
        for (heading, colour) in self.headings.iter().zip([BLACK, RGBColor(60, 60, 60), RGBColor(60, 60, 60)]) {
            heading.draw(area, (left, line), colour)?;
            line += heading.height() as i32;
        }
        let ([x, y], [width, height], top) = (self.axes, self.size, self.top as i32);
        let (_, total) = area.dim_in_pixel();
        let mut chart = ChartBuilder::on(area)
            .margin_top(self.top)
            .margin_right(RIGHT)
            .margin_bottom(total - self.top - BOTTOM - height)
            .x_label_area_size(BOTTOM)
            .margin_left(EDGE)
            .y_label_area_size(LEFT - EDGE)
            .build_cartesian_2d(self.span(0), self.span(1))
            .map_err(PlotError::from)?;
        let ticks: [&dyn Fn(&f64) -> String; 2] = [&|place| tick_at(x, *place), &|place| tick_at(y, *place)];
        labelled_axes(&mut chart, &label(x), &label(y), false, ticks)?;
        let raster = BitMapElement::with_owned_buffer((left, top), (width, height), self.raster())
            .ok_or_else(|| PlotError("the raster does not fit its frame".to_owned()))?;
        area.draw(&raster).map_err(PlotError::from)?;
        let frame = [(left - 1, top - 1), (left + width as i32, top + height as i32)];
        area.draw(&Rectangle::new(frame, BLACK.stroke_width(1))).map_err(PlotError::from)?;
        let (x, mut y) = (left + width as i32 + 24, top);
        let text = ("sans-serif", 17).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
        let ends = (0..self.picture.names.len()).map(Some).chain([None]);
        for end in ends.filter(|end| self.picture.cells.contains(end)) {
            let name = end.map_or("no breather to start from", |end| self.picture.names[end]);
            swatch(area, |_, _| colour(end), (x, y))?;
            area.draw(&Text::new(name.to_owned(), (x + 44, y + 12), text.clone())).map_err(PlotError::from)?;
            y += 34;
        }
        Ok(())
    }
}
