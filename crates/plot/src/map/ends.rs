//! What becomes of perturbed breathers over a map: the most frequent end of each cell as its colour.

use crate::backend::drawing::Rgb;
use crate::backend::format::PlotError;
use crate::backend::page::Page;
use crate::map::key::Entry;
use crate::map::mapped::{Mapped, plane};
use crate::map::raster::Raster;
use crate::map::sheet::Sheet;
use crate::map::span;

/// Colours of the ends in their order: blues for what stays periodic, white for quiet, warm ones for what does not repeat, greys for what is
/// not known. Apart for colour-blind eyes and in grey.
pub const ENDS: [Rgb; 7] =
    [[16, 50, 98], [46, 134, 171], [252, 253, 238], [195, 41, 26], [241, 192, 82], [150, 150, 150], [79, 79, 79]];

/// Of cells from which no run has started.
const NONE: Rgb = [225, 225, 225];

/// The most cells along an axis that are drawn.
pub const MOST_VALUES: usize = 6000;

/// What is drawn.
#[derive(Debug)]
pub struct EndsPicture<'a> {
    /// The scene, over two axes.
    pub scene: &'a dyn Mapped,
    /// The line under the title.
    pub caption: String,
    /// What the ends are called, in the order of the legend, and their colours.
    pub names: &'a [(String, Rgb)],
    /// Of each cell the number of its most frequent end; none without runs.
    pub cells: &'a [Option<usize>],
}

/// The bytes of the picture.
///
/// # Errors
/// [`PlotError`]; also of a scene that has not two axes, or more than 6000 values along one.
pub fn ends_picture(picture: &EndsPicture<'_>, page: impl Into<Page>) -> Result<Vec<u8>, PlotError> {
    let axes = plane(picture.scene)?;
    let cells = axes.each_ref().map(|axis| axis.values.points());
    if cells.into_iter().max() > Some(MOST_VALUES) {
        return Err(PlotError(format!("more than {MOST_VALUES} values along an axis")));
    }
    let mut sheet = Sheet::new(picture.scene, axes.clone(), axes.map(|axis| span(&axis.values)));
    sheet.notes.push(picture.caption.clone());
    let ends = (0..picture.names.len()).map(Some).chain([None]);
    let colour = |end: Option<usize>| end.and_then(|end| picture.names.get(end)).map_or(NONE, |(_, colour)| *colour);
    for end in ends.filter(|end| picture.cells.contains(end)) {
        let name = end
            .map_or_else(|| format!("no {} to start from", picture.scene.orbit()), |end| picture.names[end].0.clone());
        sheet.entries.push(Entry::Sample(Box::new(move |_, _| colour(end)), name));
    }
    let placed = sheet.placed(cells, page.into());
    let raster =
        Raster::of(cells, &placed, &|cell, _, each| each(colour(picture.cells.get(cell).copied().flatten()), 1.0));
    sheet.bytes(&placed, Vec::new(), |drawing| {
        drawing.image(placed.corners(), raster.size, raster.rgb);
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::palette::LINES;
    use crate::tests::sight::confused;

    /// Words have the colours of lines.
    #[test]
    fn words_are_told_apart_and_from_what_is_quiet() {
        let legend: Vec<_> = ["0", "1", "2", "3", "4"].into_iter().zip(LINES).chain([("quiet", ENDS[2])]).collect();
        let (pairs, found) = confused(&legend);
        assert!(pairs == 5 * 15 && found.is_empty(), "{found:#?}");
    }

    #[test]
    fn ends_are_told_apart_by_all_eyes_and_in_grey() {
        let names = ["0", "1", "2", "3", "4", "5", "6", "none"];
        let legend: Vec<_> = names.into_iter().zip(ENDS.into_iter().chain([NONE])).collect();
        let (pairs, found) = confused(&legend);
        assert!(pairs == 5 * 28 && found.is_empty(), "{found:#?}");
    }
}
