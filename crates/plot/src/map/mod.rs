//! The picture of a map: classes as colours, mechanisms as textures, or a number as a scale of colours.

pub(crate) mod classes;
pub(crate) mod ends;
pub(crate) mod key;
pub(crate) mod map_cells;
pub(crate) mod mapped;
pub(crate) mod one_axis;
pub mod palette;
pub(crate) mod quantity;
pub(crate) mod raster;
pub(crate) mod regions;
pub(crate) mod sheet;

use std::ops::Range;

use vibrochain_maps::scene::Values;

use crate::axes::axis::spanned;
use crate::backend::format::PlotError;
use crate::backend::page::Page;
use crate::backend::strokes::Borders;
use crate::map::map_cells::{MapCells, places, sharing};
use crate::map::mapped::{Mapped, plane};
use crate::map::palette::Palette;
use crate::map::raster::Raster;
use crate::map::sheet::Sheet;

/// What is drawn.
#[derive(Debug)]
pub struct MapPicture<'a> {
    /// The scene.
    pub scene: &'a dyn Mapped,
    /// What it shows of its cells.
    pub cells: &'a MapCells,
    /// The colours.
    pub palette: Palette,
    /// Borders over the cells.
    pub borders: &'a [MapBorder],
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

/// The bytes of a map's picture.
///
/// # Errors
/// [`PlotError`].
pub fn map_picture(picture: &MapPicture<'_>, page: impl Into<Page>) -> Result<Vec<u8>, PlotError> {
    let axes = plane(picture.scene)?;
    let spans = axes.each_ref().map(|axis| span(&axis.values));
    let (palette, cells) = (picture.palette, picture.cells);
    let mut sheet = Sheet::new(picture.scene, axes, spans.clone());
    sheet.tell_classes(cells.tiles(), palette);
    let bar = cells.bar();
    if let Some(bar) = bar {
        sheet.entries.extend(bar.entries(palette));
        sheet.bar = Some((bar, palette));
    }
    let part = parts(&spans);
    let mut borders = Vec::new();
    for border in picture.borders.iter().filter(|border| !border.points.is_empty()) {
        Borders::add(&mut borders, &border.kind, border.points.iter().copied().map(&part).collect(), &border.title);
    }
    sheet.tell_borders(&borders);
    let placed = sheet.placed(cells.places(), page.into());
    let raster = Raster::of(cells.places(), &placed, &|place, at, each| cells.colours(place, at, palette, bar, each));
    sheet.bytes(&placed, Vec::new(), |drawing| {
        let corners = placed.corners();
        drawing.image(corners, raster.size, raster.rgb.clone());
        drawing.clipped(corners, |drawing| Borders::draw(&borders, drawing, |at| placed.within(at), &placed.page));
    })
}

/// Places along both axes as parts of the map, from its upper left corner.
fn parts([x, y]: &[Range<f64>; 2]) -> impl Fn([f64; 2]) -> [f64; 2] + use<> {
    let (x, y) = (x.clone(), y.clone());
    let part = |value: f64, span: &Range<f64>| (value - span.start) / (span.end - span.start);
    move |point| [part(point[0], &x), 1.0 - part(point[1], &y)]
}

/// What a map spans of an axis: a cell covers half a step on either side of its value, and places are whole.
pub(crate) fn span(values: &Values) -> Range<f64> {
    spanned(values, places(values) * sharing(values), 0.5)
}
