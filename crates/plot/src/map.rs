//! The picture of a map: classes as colours, mechanisms as textures, or a number as a scale of colours; every cell the same whole
//! number of pixels.

use std::fmt::Write;
use std::ops::Range;

use vibrochain_maps::scene::{Axis, Scene};

use crate::canvas::{Format, PlotError};
use crate::coverage::Place;
pub use crate::lines::MapLine;
use crate::palette::{BORDERS, Palette, Tile};
use crate::quantity::{Bar, Quantity, Shade};
use crate::sheet::{Ground, Sheet};
use crate::strokes::{Stroke, hex, path, shares};
use crate::ticks::places;

/// About this many pixels wide and high the map itself becomes.
pub(crate) const TARGET: usize = 900;

/// A map wider or higher than this in cells shows every second (third …) one only.
const MOST: usize = 6000;

/// What is drawn.
#[derive(Debug)]
pub struct MapPicture<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The cells that are [shown](is_shown), by rows, the first row at the bottom.
    pub cells: Cells<'a>,
    /// The colours.
    pub palette: Palette,
    /// Borders over the cells.
    pub borders: &'a [MapBorder],
}

/// What the cells of a map show.
#[derive(Debug, Clone, Copy)]
pub enum Cells<'a> {
    /// Their classes.
    Classes(&'a [Tile]),
    /// A number.
    Numbers(Quantity, &'a [Shade]),
}

/// A border over a map.
#[derive(Debug, Clone, PartialEq)]
pub struct MapBorder {
    /// What happens on it; borders of one kind have one colour and one entry in the legend.
    pub kind: String,
    /// What an SVG says of it when one hovers over it.
    pub title: String,
    /// Its points, in units of the axes.
    pub points: Vec<[f64; 2]>,
}

/// Whether the picture of a sweep over one or two axes shows cell number `cell`: all do, unless there are thousands along an axis.
pub fn is_shown(scene: &Scene, cell: u64) -> bool {
    let among = |number: u64, axis: &Axis| number.is_multiple_of(stride(axis.points()) as u64);
    match scene.axes.as_slice() {
        [x] => among(cell, x),
        [x, y] => {
            let columns = x.points() as u64;
            among(cell % columns, x) && among(cell / columns, y)
        }
        _ => false,
    }
}

fn stride(points: usize) -> usize {
    points.div_ceil(MOST).max(1)
}

/// The bytes of a map's picture.
///
/// # Errors
/// [`PlotError`].
pub fn map_picture(picture: &MapPicture<'_>, format: Format) -> Result<Vec<u8>, PlotError> {
    map_with_lines(picture, &[], format)
}

/// The same with lines over the cells.
///
/// # Errors
/// [`PlotError`].
pub fn map_with_lines(picture: &MapPicture<'_>, lines: &[MapLine], format: Format) -> Result<Vec<u8>, PlotError> {
    let Some([x, y]) = picture.scene.plane() else {
        return Err(PlotError("a map has two axes".to_owned()));
    };
    let grids = [Grid::new(x.points()), Grid::new(y.points())];
    // A cell covers half a step on either side of its value.
    let span = |axis: &Axis, grid: Grid| {
        let (from, step) = places(axis);
        from - 0.5 * step..from - 0.5 * step + step * (grid.shown * grid.stride) as f64
    };
    let spans = [span(x, grids[0]), span(y, grids[1])];
    let size = grids.map(|grid| grid.pixels());
    let palette = picture.palette;
    let (mut tiles, mut bar): (Vec<Tile>, _) = (Vec::new(), None);
    let mut pixels = match picture.cells {
        Cells::Classes(cells) => {
            for tile in cells {
                if !tiles.contains(tile) {
                    tiles.push(*tile);
                }
            }
            let unknown = Tile { class: None, mechanism: None };
            let tile = |cell: usize| cells.get(cell).copied().unwrap_or(unknown);
            raster(grids, |cell, x, y| palette.pixel(tile(cell), x, y))
        }
        Cells::Numbers(quantity, cells) => {
            let Bar { colours, .. } = *bar.insert(Bar::of(quantity, cells));
            let shade = |cell: usize| cells.get(cell).copied().unwrap_or(Shade::Unknown);
            raster(grids, |cell, x, y| colours.pixel(palette, shade(cell), x, y))
        }
    };
    let strokes = strokes(picture.borders, &spans, size);
    let mut overlay = String::new();
    match format {
        Format::Png => strokes.iter().for_each(|stroke| paint(&mut pixels, stroke, size)),
        Format::Svg => overlay = paths(picture.borders, &strokes),
    }
    let key: Vec<(&str, [u8; 3])> = strokes.iter().map(|stroke| (stroke.kind, stroke.colour)).collect();
    let ground = Ground::Raster(pixels);
    let (scene, axes, key) = (picture.scene, [x, y], key.as_slice());
    Sheet { scene, palette, axes, tiles, bar, lines, key, spans, size, ground, overlay }.bytes(format)
}

/// The pixels of a map's cells, of each by its number and the place of the pixel.
fn raster([columns, rows]: [Grid; 2], colour: impl Fn(usize, u32, u32) -> [u8; 3]) -> Vec<u8> {
    let (width, height) = (columns.pixels(), rows.pixels());
    let mut pixels = Vec::with_capacity(3 * (width * height) as usize);
    for py in 0..height {
        let row = (rows.shown as u32 - 1 - py / rows.cell) as usize;
        for px in 0..width {
            let column = (px / columns.cell) as usize;
            pixels.extend(colour(row * columns.shown + column, px, py));
        }
    }
    pixels
}

/// Width of a border, and of the light line under it that sets it off from dark cells, in pixels; and how much of that is seen.
const BORDER: f64 = 0.9;
const HALO: f64 = 2.2;
const FAINT: f64 = 0.5;

/// The borders of each kind, in pixels.
fn strokes<'a>(borders: &'a [MapBorder], [x, y]: &[Range<f64>; 2], size: [u32; 2]) -> Vec<Stroke<'a>> {
    let part = |value: f64, span: &Range<f64>| (value - span.start) / (span.end - span.start);
    let pixel = |point: &[f64; 2]| -> Place {
        [part(point[0], x) * f64::from(size[0]), (1.0 - part(point[1], y)) * f64::from(size[1])]
    };
    let mut strokes: Vec<Stroke<'a>> = Vec::new();
    for border in borders {
        let line: Vec<Place> = border.points.iter().map(pixel).collect();
        match strokes.iter_mut().find(|stroke| stroke.kind == border.kind) {
            Some(stroke) => stroke.lines.push(line),
            None => {
                let colour = BORDERS[strokes.len() % BORDERS.len()];
                strokes.push(Stroke { kind: &border.kind, colour, lines: vec![line] });
            }
        }
    }
    strokes
}

/// Draws borders into pixels.
fn paint(pixels: &mut [u8], stroke: &Stroke<'_>, size: [u32; 2]) {
    for (width, colour, seen) in [(HALO, [255; 3], FAINT), (BORDER, stroke.colour, 1.0)] {
        for (share, pixel) in shares(&stroke.lines, width, size).zip(pixels.chunks_exact_mut(3)) {
            for (part, colour) in pixel.iter_mut().zip(colour) {
                let mixed = f64::from(*part) + seen * share * (f64::from(colour) - f64::from(*part));
                *part = mixed.round() as u8;
            }
        }
    }
}

/// The same as elements of an SVG, from the upper left corner of the map.
fn paths(borders: &[MapBorder], strokes: &[Stroke<'_>]) -> String {
    let mut text = String::new();
    for stroke in strokes {
        let lines = || stroke.lines.iter().map(|line| path(line.iter().copied(), false));
        let style = "fill=\"none\" stroke-linejoin=\"round\"";
        let (under, colour) = (lines().collect::<String>(), hex(stroke.colour));
        let _ = writeln!(
            text,
            "<path {style} stroke=\"#ffffff\" stroke-opacity=\"{FAINT}\" stroke-width=\"{HALO}\" d=\"{under}\"/>"
        );
        let of_kind = borders.iter().filter(|border| border.kind == stroke.kind);
        for (border, d) in of_kind.zip(lines()).filter(|(_, d)| !d.is_empty()) {
            let title = escaped(&border.title);
            let _ = writeln!(
                text,
                "<path {style} stroke=\"{colour}\" stroke-width=\"{BORDER}\" d=\"{d}\"><title>{title}</title></path>"
            );
        }
    }
    text
}

/// A text within XML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Cells along one axis.
#[derive(Debug, Clone, Copy)]
struct Grid {
    shown: usize,
    stride: usize,
    cell: u32,
}

impl Grid {
    fn new(points: usize) -> Self {
        let stride = stride(points);
        let shown = points.div_ceil(stride);
        Self { shown, stride, cell: (TARGET / shown.max(1)).clamp(1, 60) as u32 }
    }

    fn pixels(&self) -> u32 {
        self.shown as u32 * self.cell
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn scene(x: &str, y: &str) -> Scene {
        let text = format!(
            "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\nx = {{ parameter = \"omega\", {x} }}\n\
             y = {{ parameter = \"gamma2\", {y} }}\n[compute]\nfamilies = [\"double-sided\"]\n"
        );
        Scene::parse(Path::new("scene.toml"), &text).unwrap()
    }

    #[test]
    fn a_map_with_thousands_of_columns_shows_as_many_as_it_can() {
        let scene = scene("from = 0.4, to = 3.0, points = 12001", "values = [0.1, 0.2]");
        let shown: Vec<u64> = (0..scene.cells()).filter(|&cell| is_shown(&scene, cell)).collect();
        let expected: Vec<u64> = (0..2).flat_map(|row| (0..4001).map(move |i| 12_001 * row + 3 * i)).collect();
        assert_eq!(shown, expected);
        assert_eq!(Grid::new(12_001).shown, 4001);
    }
}
