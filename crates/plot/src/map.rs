//! The picture of a map: classes as colours, mechanisms as textures, or a number as a scale of colours; every cell the same whole
//! number of pixels.

use std::ops::Range;

use vibrochain_maps::extent::Extent;
use vibrochain_maps::scene::{Axis, Scene};

use crate::axis::spanned;
use crate::drawing::Rgb;
use crate::format::PlotError;
use crate::key::Entry;
pub use crate::lines::MapLine;
use crate::lines::{draw_lines, key};
use crate::page::Page;
use crate::palette::{BORDERS, Palette, Tile};
use crate::quantity::{Bar, Quantity, Shade};
use crate::raster::Raster;
use crate::sheet::{Sheet, draw_borders};
use crate::strokes::thinned;

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

/// How many cells the picture of a map shows.
pub fn shown_cells(scene: &Scene) -> usize {
    scene.axes.iter().map(|axis| axis.points().div_ceil(stride(axis.points()))).product()
}

/// Which of the cells that the picture of a map shows are in a square of its cells: their places among those shown.
pub fn shown_within(scene: &Scene, square: Extent) -> impl Iterator<Item = usize> + use<> {
    let points = scene.plane().map_or([0, 0], |plane| plane.map(Axis::points));
    let strides = points.map(stride);
    let size = square.size as usize;
    let places = |first: u32, i: usize| {
        (first as usize).div_ceil(strides[i])..(first as usize + size).min(points[i]).div_ceil(strides[i])
    };
    let (columns, rows) = (places(square.column, 0), places(square.row, 1));
    let wide = points[0].div_ceil(strides[0]);
    rows.flat_map(move |row| columns.clone().map(move |column| row * wide + column))
}

fn stride(points: usize) -> usize {
    points.div_ceil(MOST).max(1)
}

/// The bytes of a map's picture.
///
/// # Errors
/// [`PlotError`].
pub fn map_picture(picture: &MapPicture<'_>, page: impl Into<Page>) -> Result<Vec<u8>, PlotError> {
    map_with_lines(picture, &[], page)
}

/// The same with lines over the cells.
///
/// # Errors
/// [`PlotError`].
pub fn map_with_lines(
    picture: &MapPicture<'_>,
    lines: &[MapLine],
    page: impl Into<Page>,
) -> Result<Vec<u8>, PlotError> {
    let Some([x, y]) = picture.scene.plane() else {
        return Err(PlotError("a map has two axes".to_owned()));
    };
    let shown = [x, y].map(|axis| axis.points().div_ceil(stride(axis.points())));
    let spans = [span(x), span(y)];
    let palette = picture.palette;
    let mut sheet = Sheet::new(picture.scene, [x, y], spans.clone());
    let colour: Box<dyn Fn(usize, u32, u32) -> Rgb> = match picture.cells {
        Cells::Classes(cells) => {
            let mut tiles: Vec<Tile> = Vec::new();
            for tile in cells {
                if !tiles.contains(tile) {
                    tiles.push(*tile);
                }
            }
            sheet.tell_classes(&tiles, palette);
            let unknown = Tile { class: None, mechanism: None };
            Box::new(move |cell, x, y| palette.pixel(cells.get(cell).copied().unwrap_or(unknown), x, y))
        }
        Cells::Numbers(quantity, cells) => {
            let bar = Bar::of(quantity, cells);
            sheet.entries.extend(bar.entries(palette));
            sheet.bar = Some((bar, palette));
            let shade = move |cell: usize| cells.get(cell).copied().unwrap_or(Shade::Unknown);
            Box::new(move |cell, x, y| bar.colours.pixel(palette, shade(cell), x, y))
        }
    };
    let kinds = kinds(picture.borders);
    if !kinds.is_empty() {
        sheet.entries.push(Entry::Heading("borders".to_owned()));
    }
    sheet.entries.extend(kinds.iter().map(|(kind, colour)| Entry::Stroke(*colour, None, (*kind).to_owned())));
    sheet.entries.extend(key(lines));
    let placed = sheet.placed(shown, page.into());
    let raster = Raster::of(shown, &placed, &colour);
    sheet.bytes(&placed, Vec::new(), |drawing| {
        let (corners, part) = (placed.corners(), parts(&spans));
        drawing.image(corners, raster.size, raster.rgb.clone());
        drawing.clipped(corners, |drawing| {
            for (kind, colour) in &kinds {
                let of_kind = picture.borders.iter().filter(|border| border.kind == *kind);
                let line = |border: &MapBorder| {
                    thinned(&border.points.iter().map(|point| placed.within(part(*point))).collect::<Vec<_>>())
                };
                let lines: Vec<_> = of_kind.map(|border| (line(border), border.title.as_str())).collect();
                draw_borders(drawing, *colour, &lines, &placed.page);
            }
        });
        draw_lines(drawing, &placed, &raster, lines, &part);
    })
}

/// Places along both axes as parts of the map, from its upper left corner.
fn parts([x, y]: &[Range<f64>; 2]) -> impl Fn([f64; 2]) -> [f64; 2] + use<> {
    let (x, y) = (x.clone(), y.clone());
    let part = |value: f64, span: &Range<f64>| (value - span.start) / (span.end - span.start);
    move |point| [part(point[0], &x), 1.0 - part(point[1], &y)]
}

/// What a map spans of an axis: a cell covers half a step on either side of its value.
pub(crate) fn span(axis: &Axis) -> Range<f64> {
    let stride = stride(axis.points());
    let shown = axis.points().div_ceil(stride);
    spanned(axis, shown * stride, 0.5)
}

/// Kinds of borders and their colours.
fn kinds(borders: &[MapBorder]) -> Vec<(&str, Rgb)> {
    let mut kinds: Vec<(&str, Rgb)> = Vec::new();
    for border in borders.iter().filter(|border| !border.points.is_empty()) {
        if kinds.iter().all(|(kind, _)| *kind != border.kind) {
            kinds.push((&border.kind, BORDERS[kinds.len() % BORDERS.len()]));
        }
    }
    kinds
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
        assert_eq!(12_001_usize.div_ceil(stride(12_001)), 4001);
    }

    #[test]
    fn squares_show_those_of_their_cells_that_are_shown() {
        let scene = scene("from = 0.4, to = 3.0, points = 12800", "from = 0.1, to = 0.2, points = 64");
        let shown: Vec<u64> = (0..scene.cells()).filter(|&cell| is_shown(&scene, cell)).collect();
        assert_eq!(shown_cells(&scene), shown.len());
        let mut compared = 0;
        for square in [(0, 0, 64), (12_736, 0, 64), (17, 3, 1), (18, 3, 1), (9600, 32, 8)] {
            let (column, row, size) = square;
            let places: Vec<usize> = shown_within(&scene, Extent { column, row, size }).collect();
            let inside = |cell: u64| {
                let (x, y) = ((cell % 12_800) as u32, (cell / 12_800) as u32);
                (column..column + size).contains(&x) && (row..row + size).contains(&y)
            };
            let expected: Vec<usize> = (0..shown.len()).filter(|&place| inside(shown[place])).collect();
            assert_eq!(places, expected);
            compared += places.len();
        }
        assert!(compared > 2000, "{compared}");
    }
}
