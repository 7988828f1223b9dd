//! What the picture of a map shows of its cells, collected as they come.
//!
//! Of more than thousands along an axis a few share a place, and none of them is left out, or a stripe one cell wide would be there or
//! not as its column happens to be. Classes have their shares of the place; of a number the one that stands out is kept.

use vibrochain_maps::cell::Cell;
use vibrochain_maps::scene::Values;

use crate::backend::drawing::Rgb;
use crate::map::mapped::{Mapped, plane};
use crate::map::palette::{Palette, Tile};
use crate::map::quantity::{Bar, Quantity, Shade};

/// Places along an axis, at most: viewers open a picture of so many pixels.
const MOST: usize = 6000;

/// How many cells along an axis share a place.
pub(crate) fn sharing(values: &Values) -> usize {
    values.points().div_ceil(MOST).max(1)
}

/// Places along an axis.
pub(crate) fn places(values: &Values) -> usize {
    values.points().div_ceil(sharing(values))
}

/// Whether the picture of a sweep over one axis shows cell number `cell`: all do, unless there are thousands.
pub fn is_shown(values: &Values, cell: u64) -> bool {
    cell.is_multiple_of(sharing(values) as u64)
}

/// The cells of a map on a grid of places. Where a row has thousands of cells, several share a place.
#[derive(Debug, Clone)]
pub struct MapCells {
    /// Columns and rows of cells, how many of each share a place, and places.
    points: [usize; 2],
    sharing: [usize; 2],
    places: [usize; 2],
    kept: Kept,
}

/// By places, the lowest row first; without any until the first cell comes.
#[derive(Debug, Clone)]
enum Kept {
    /// What is drawn in each cell, by its number among those that have occurred.
    Tiles(Vec<Tile>, Vec<u8>),
    /// The same where several cells share a place.
    Mixed(Vec<Tile>, Vec<Mix>),
    Numbers(Quantity, Vec<Shade>),
}

/// The tiles of a place, by their numbers, and how many cells have each: a million cells along an axis are 167 a place, whose square is
/// less than 65 536.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Mix {
    tiles: [u8; KINDS],
    cells: [u16; KINDS],
}

/// Kinds of tiles that a place can have. Where five meet, the last one counts as the fourth.
const KINDS: usize = 4;

/// What no cell has been.
const UNSEEN: u8 = u8::MAX;

impl Mix {
    fn add(&mut self, tile: u8) {
        let free = |i: &usize| self.cells[*i] == 0 || self.tiles[*i] == tile;
        let i = (0..KINDS).find(free).unwrap_or(KINDS - 1);
        if self.cells[i] == 0 {
            self.tiles[i] = tile;
        }
        self.cells[i] = self.cells[i].saturating_add(1);
    }

    /// The tiles with their shares of the place.
    fn shares(&self) -> impl Iterator<Item = (u8, f32)> {
        let all: f32 = self.cells.map(f32::from).iter().sum();
        let pairs = self.tiles.into_iter().zip(self.cells);
        pairs.filter(|(_, cells)| *cells > 0).map(move |(tile, cells)| (tile, f32::from(cells) / all))
    }
}

/// The number of a tile among those that have occurred: there are fewer kinds than numbers.
fn number(known: &mut Vec<Tile>, tile: Tile) -> u8 {
    let at = known.iter().position(|other| *other == tile).unwrap_or_else(|| {
        known.push(tile);
        known.len() - 1
    });
    u8::try_from(at).unwrap_or(UNSEEN)
}

impl MapCells {
    /// Of the classes of a scene's cells; of no cell of one that has not two axes.
    pub fn classes(scene: &dyn Mapped) -> Self {
        Self::of(scene, |is_shared| {
            if is_shared { Kept::Mixed(Vec::new(), Vec::new()) } else { Kept::Tiles(Vec::new(), Vec::new()) }
        })
    }

    /// Of a number.
    pub fn numbers(scene: &dyn Mapped, quantity: Quantity) -> Self {
        Self::of(scene, |_| Kept::Numbers(quantity, Vec::new()))
    }

    fn of(scene: &dyn Mapped, kept: impl FnOnce(bool) -> Kept) -> Self {
        let axes = plane(scene).ok();
        let each = |count: fn(&Values) -> usize| {
            axes.as_ref().map_or([0; 2], |axes| axes.each_ref().map(|axis| count(&axis.values)))
        };
        let sharing = each(sharing);
        Self { points: each(Values::points), sharing, places: each(places), kept: kept(sharing != [1; 2]) }
    }

    /// Forgets what was seen.
    pub fn clear(&mut self) {
        match &mut self.kept {
            Kept::Tiles(known, all) => (known.clear(), all.clear()),
            Kept::Mixed(known, all) => (known.clear(), all.clear()),
            Kept::Numbers(_, all) => ((), all.clear()),
        };
    }

    /// Takes cell number `number` of the scene.
    pub fn cell(&mut self, number: u64, cell: &Cell) {
        self.put(number, || Tile::from(cell), |quantity| quantity.shade(cell));
    }

    /// The same, of which the tile is known alone.
    pub fn tile(&mut self, number: u64, tile: Tile) {
        self.put(number, || tile, |_| Shade::Unknown);
    }

    fn put(&mut self, cell: u64, tile: impl FnOnce() -> Tile, shade: impl FnOnce(Quantity) -> Shade) {
        let wide = self.points[0].max(1);
        let (column, row) = (cell as usize % wide, cell as usize / wide);
        if row >= self.points[1] {
            return;
        }
        let all = self.places[0] * self.places[1];
        let [x, y] = self.sharing.map(|sharing| sharing.max(1));
        let place = row / y * self.places[0] + column / x;
        match &mut self.kept {
            Kept::Tiles(known, kept) => {
                kept.resize(all, UNSEEN);
                kept[place] = number(known, tile());
            }
            Kept::Mixed(known, kept) => {
                kept.resize(all, Mix::default());
                kept[place].add(number(known, tile()));
            }
            Kept::Numbers(quantity, kept) => {
                kept.resize(all, Shade::Nothing);
                kept[place] = quantity.outstanding(kept[place], shade(*quantity));
            }
        }
    }

    /// Columns and rows of places.
    pub(crate) fn places(&self) -> [usize; 2] {
        self.places
    }

    /// What has occurred, if classes are shown.
    pub(crate) fn tiles(&self) -> &[Tile] {
        match &self.kept {
            Kept::Tiles(known, _) | Kept::Mixed(known, _) => known,
            Kept::Numbers(..) => &[],
        }
    }

    /// The scale of the number, if one is shown.
    pub(crate) fn bar(&self) -> Option<Bar> {
        match &self.kept {
            Kept::Tiles(..) | Kept::Mixed(..) => None,
            Kept::Numbers(quantity, kept) => Some(Bar::of(*quantity, kept)),
        }
    }

    /// The colours of a place at a pixel, with their shares; its numbers on the scale `bar`.
    pub(crate) fn colours(
        &self,
        place: usize,
        [x, y]: [u32; 2],
        palette: Palette,
        bar: Option<Bar>,
        mut each: impl FnMut(Rgb, f32),
    ) {
        let of = |known: &[Tile], tile: u8| match known.get(usize::from(tile)) {
            Some(tile) => palette.pixel(*tile, x, y),
            None => palette.unknown(x, y),
        };
        match &self.kept {
            Kept::Tiles(known, kept) => each(of(known, kept.get(place).copied().unwrap_or(UNSEEN)), 1.0),
            Kept::Mixed(known, kept) => match kept.get(place).filter(|mix| **mix != Mix::default()) {
                Some(mix) => mix.shares().for_each(|(tile, share)| each(of(known, tile), share)),
                None => each(palette.unknown(x, y), 1.0),
            },
            Kept::Numbers(_, kept) => {
                let shade = kept.get(place).copied().unwrap_or(Shade::Unknown);
                each(bar.map_or(palette.unknown(x, y), |bar| bar.colours.pixel(palette, shade, x, y)), 1.0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use vibrochain_maps::cell::Class;
    use vibrochain_maps::scene::Scene;

    use super::*;
    use crate::backend::format::Format;
    use crate::backend::page::{Page, Purpose};
    use crate::map::raster::Raster;
    use crate::map::sheet::Sheet;
    use crate::map::span;

    fn scene(columns: usize, rows: usize) -> Scene {
        let text = format!(
            "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
             x = {{ parameter = \"omega\", from = 0.4, to = 3.0, points = {columns} }}\n\
             y = {{ parameter = \"gamma2\", from = 0.1, to = 0.2, points = {rows} }}\n[compute]\nfamilies = [\"double-sided\"]\n"
        );
        Scene::parse(Path::new("scene.toml"), &text).unwrap()
    }

    const EMPTY: Tile = Tile { class: Some(Class::None), mechanism: None };
    const STABLE: Tile = Tile { class: Some(Class::StableDouble), mechanism: None };

    fn raster(scene: &Scene, shown: &MapCells, page: Page) -> Raster {
        let axes = plane(scene).unwrap();
        let spans = axes.each_ref().map(|axis| span(&axis.values));
        let placed = Sheet::new(scene, axes, spans).placed(shown.places(), page);
        let colours = |place: usize, at: [u32; 2], each: &mut dyn FnMut(Rgb, f32)| {
            shown.colours(place, at, Palette::Colour, None, each);
        };
        Raster::of(shown.places(), &placed, &colours)
    }

    #[test]
    fn a_stripe_of_one_cell_is_as_dark_wherever_it_lies() {
        let columns = 12_801;
        let scene = scene(columns, 2);
        let [light, dark] = [EMPTY, STABLE].map(|tile| f64::from(Palette::Colour.pixel(tile, 0, 0)[0]));
        let mut looked = 0;
        for page in [Page::from(Format::Png), Purpose::Column.page(Format::Pdf), Purpose::Slide.page(Format::Svg)] {
            for stripe in [0, 1, 2, 3, 4, 5, 4000, 6401, 8765, 12_799, 12_800] {
                let mut shown = MapCells::classes(&scene);
                let tile = |cell: usize| if cell % columns == stripe { STABLE } else { EMPTY };
                (0..2 * columns).for_each(|cell| shown.tile(cell as u64, tile(cell)));
                let raster = raster(&scene, &shown, page);
                let [wide, high] = raster.size.map(|side| side as usize);
                assert!((1000..=4267).contains(&wide), "{wide}");
                let row = &raster.rgb[3 * wide * (high / 2)..][..3 * wide];
                let found: f64 = row.chunks(3).map(|pixel| (light - f64::from(pixel[0])) / (light - dark)).sum();
                let expected = wide as f64 / columns as f64;
                // Each of the pixels that it meets is rounded.
                assert!((found - expected).abs() < 0.01, "{wide} {stripe}: {found} {expected}");
                looked += 1;
            }
        }
        assert_eq!(looked, 33);
    }

    #[test]
    fn of_numbers_the_one_that_stands_out_is_kept() {
        let scene = scene(2, 18_000);
        let cell = |value: f64| Cell { spectral_radius: Some(1.0 + value), margin: Some(value), ..Cell::EMPTY };
        for (quantity, expected) in [(Quantity::SpectralRadius, 0.5), (Quantity::Margin, 0.125)] {
            for at in [0, 1, 2, 9001, 17_999_u64] {
                let mut shown = MapCells::numbers(&scene, quantity);
                for row in 0..18_000 {
                    let value = if row == at { expected } else { 0.25 };
                    // What has none hides none.
                    shown.cell(2 * row, &cell(value));
                    shown.cell(2 * row + 1, &if row == at { cell(value) } else { Cell::EMPTY });
                }
                let Kept::Numbers(_, kept) = &shown.kept else { panic!("{shown:?}") };
                assert_eq!((shown.places, kept.len()), ([2, 6000], 12_000));
                let place = 2 * (at / 3) as usize;
                assert_eq!(kept[place..place + 2], [Shade::Number(expected as f32); 2]);
                let others = kept.iter().enumerate().filter(|(i, _)| i / 2 != place / 2);
                let usual = |i: usize| if i.is_multiple_of(2) { Shade::Number(0.25) } else { Shade::Nothing };
                assert!(others.clone().count() == 11_998 && others.clone().all(|(i, shade)| *shade == usual(i)));
            }
        }
        let unknown = Shade::Unknown;
        assert_eq!(Quantity::Margin.outstanding(Shade::Nothing, unknown), unknown);
        assert_eq!(Quantity::Margin.outstanding(unknown, Shade::Nothing), unknown);
        assert_eq!(Quantity::Margin.outstanding(unknown, Shade::Number(0.0)), Shade::Number(0.0));
    }

    #[test]
    fn a_place_has_four_kinds_and_a_fifth_counts_as_the_last() {
        let mut mix = Mix::default();
        [3, 1, 3, 2, 7, 9, 9].into_iter().for_each(|tile| mix.add(tile));
        assert_eq!((mix.tiles, mix.cells), ([3, 1, 2, 7], [2, 1, 1, 3]));
        assert_eq!(mix.shares().map(|(_, share)| share).sum::<f32>(), 1.0);
        mix.cells[1] = u16::MAX;
        mix.add(1);
        assert_eq!(mix.cells[1], u16::MAX);
    }

    #[test]
    fn a_line_of_thousands_of_cells_shows_as_many_as_it_can() {
        let scene = scene(12_001, 2);
        let axis = &scene.axes[0].values;
        let shown: Vec<u64> = (0..12_001).filter(|&cell| is_shown(axis, cell)).collect();
        assert_eq!(shown, (0..4001).map(|i| 3 * i).collect::<Vec<u64>>());
        assert_eq!((sharing(axis), places(axis), sharing(&scene.axes[1].values)), (3, 4001, 1));
    }
}
