//! The picture of a map by its regions: shapes with what they are when one hovers over them, or pixels that show each region by
//! its share, however thin it is.

use vibrochain_maps::regions::{Region, Regions};
use vibrochain_maps::scene::Scene;

use crate::backend::coverage::Coverage;
use crate::backend::drawing::{Fill, Pattern, Place, Rgb, Shape, sides};
use crate::backend::format::{Format, PlotError};
use crate::backend::page::Page;
use crate::backend::strokes::{Borders, thinned};
use crate::map::classes::{class_words, loss};
use crate::map::key::texture;
use crate::map::mapped::plane;
use crate::map::palette::{Palette, Tile};
use crate::map::sheet::Sheet;

/// What is drawn.
#[derive(Debug)]
pub struct RegionsPicture<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The regions of its window.
    pub regions: &'a Regions<Tile>,
    /// What happens on each border, by the number of the border; one without a name is not drawn, and no more those beyond the end
    /// of the list.
    pub borders: &'a [&'a str],
    /// The colours.
    pub palette: Palette,
}

/// The map is as if it had so many cells along each axis: a square.
const SIDE: usize = 100;

/// All textures come again after so many pixels.
const TEXTURE: u32 = 12;

/// Makes sure that a page holds the picture of a scene's regions, before there are any.
///
/// # Errors
/// [`PlotError`].
pub fn regions_fit(scene: &Scene, page: Page) -> Result<Vec<u8>, PlotError> {
    let axes = plane(scene)?;
    let spans = axes.each_ref().map(|axis| axis.spanned(0.0));
    let sheet = Sheet::new(scene, axes, spans);
    sheet.bytes(&sheet.placed([SIDE; 2], page), Vec::new(), |_| {})
}

/// The bytes of a map's picture by its regions. Of borders the parts are drawn that separate something.
///
/// # Errors
/// [`PlotError`].
pub fn regions_picture(picture: &RegionsPicture<'_>, page: impl Into<Page>) -> Result<Vec<u8>, PlotError> {
    let page = page.into();
    let axes = plane(picture.scene)?;
    let spans = axes.each_ref().map(|axis| axis.spanned(0.0));
    let mut tiles: Vec<Tile> = Vec::new();
    for region in picture.regions.regions() {
        if !tiles.contains(&region.class) {
            tiles.push(region.class);
        }
    }
    let borders = borders(picture);
    let mut sheet = Sheet::new(picture.scene, axes, spans);
    sheet.tell_classes(&tiles, picture.palette);
    sheet.tell_borders(&borders);
    let placed = sheet.placed([SIDE; 2], page);
    let corners = placed.corners();
    let (fills, patterns) = fills(picture.palette, &tiles);
    sheet.bytes(&placed, patterns, |drawing| {
        if page.format == Format::Png {
            let pixels = page.pixels(sides(corners));
            drawing.image(corners, pixels, raster(picture, pixels, texture(&page)));
        } else {
            let within = |place: &[f64; 2]| placed.within([place[0], 1.0 - place[1]]);
            for Region { class: tile, share, outlines } in picture.regions.regions() {
                let mechanism = tile.mechanism.map_or(String::new(), |mechanism| format!(", {}", loss(mechanism)));
                let words = class_words(tile.class, || tiles.iter().filter_map(|tile| tile.class));
                let title = format!("{words}{mechanism}: {} of the window", percent(*share));
                let fill = tiles.iter().position(|other| other == tile).map(|number| fills[number]);
                let around = |outline: &Vec<[f64; 2]>| {
                    let mut line: Vec<Place> = outline.iter().map(within).collect();
                    line.extend(line.first().copied());
                    thinned(&line)
                };
                let outlines = outlines.iter().map(around).collect();
                drawing.shape(Shape { outlines, closed: true, fill, line: None, title });
            }
        }
        drawing.clipped(corners, |drawing| Borders::draw(&borders, drawing, |at| placed.within(at), &page));
    })
}

/// The lines of borders that separate something, as parts of the map from its upper left corner.
fn borders<'a>(picture: &RegionsPicture<'a>) -> Vec<Borders<'a>> {
    let mut all = Vec::new();
    for (border, &kind) in picture.borders.iter().enumerate().take(picture.regions.borders()) {
        for part in picture.regions.border(border).iter().filter(|part| part.separates && !kind.is_empty()) {
            Borders::add(&mut all, kind, part.points.iter().map(|[x, y]| [*x, 1.0 - y]).collect(), "");
        }
    }
    all
}

/// The pixels of the map, of which so many make one of a texture: of each the mean of what lies in it, by area.
fn raster(picture: &RegionsPicture<'_>, size: [u32; 2], grain: u32) -> Vec<u8> {
    let mut mean = vec![[0.0_f32; 3]; size[0] as usize * size[1] as usize];
    let place = |i: usize| (i as u32 % size[0] / grain, i as u32 / size[0] / grain);
    let mut done: Vec<Tile> = Vec::new();
    let regions = picture.regions.regions();
    for Region { class: tile, .. } in regions {
        if done.contains(tile) {
            continue;
        }
        done.push(*tile);
        let covers = covered(regions.iter().filter(|region| region.class == *tile), size);
        for (i, (share, mean)) in covers.into_iter().zip(&mut mean).enumerate() {
            if share != 0.0 {
                let (x, y) = place(i);
                let colour = picture.palette.pixel(*tile, x, y);
                *mean = [0, 1, 2].map(|k| mean[k] + share as f32 * f32::from(colour[k]));
            }
        }
    }
    mean.into_iter().flatten().map(|part: f32| part.round().clamp(0.0, 255.0) as u8).collect()
}

/// The share of each pixel that regions cover.
fn covered<'a>(regions: impl Iterator<Item = &'a Region<Tile>>, size: [u32; 2]) -> Vec<f64> {
    let mut coverage = Coverage::new(size);
    let pixel = |[x, y]: [f64; 2]| [x * f64::from(size[0]), (1.0 - y) * f64::from(size[1])];
    for outline in regions.flat_map(|region| &region.outlines) {
        coverage.add(outline.iter().copied().map(pixel));
    }
    coverage.shares()
}

/// A part of the window in as many digits as it needs.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent >= 0.01 { format!("{percent:.2} %") } else { format!("{percent:.1e} %") }
}

/// What fills the shapes of each tile: a colour, or a pattern, pixel for pixel that of a raster.
fn fills(palette: Palette, tiles: &[Tile]) -> (Vec<Fill>, Vec<Pattern>) {
    let mut patterns = Vec::new();
    let fill = |tile: &Tile| {
        let pixel = |x: u32, y: u32| palette.pixel(*tile, x, y);
        let places = || (0..TEXTURE).flat_map(|y| (0..TEXTURE).map(move |x| (x, y)));
        // The lighter one is the ground.
        let ground: Rgb = places().map(|(x, y)| pixel(x, y)).max().unwrap_or([255; 3]);
        let squares: Vec<(u32, u32)> = places().filter(|&(x, y)| pixel(x, y) != ground).collect();
        let Some(&(x, y)) = squares.first() else { return Fill::Colour(ground) };
        let squares = squares.into_iter().map(|(x, y)| [f64::from(x), f64::from(y)]).collect();
        patterns.push(Pattern { ground, marks: pixel(x, y), squares, period: f64::from(TEXTURE) });
        Fill::Pattern(patterns.len() - 1)
    };
    (tiles.iter().map(fill).collect(), patterns)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use vibrochain_floquet::Mechanism;
    use vibrochain_maps::cell::Class;
    use vibrochain_maps::regions::{Subdivision, Window};

    use super::*;

    fn scene() -> Scene {
        let text = "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
                    x = { parameter = \"omega\", from = 1, to = 3, points = 3 }\n\
                    y = { parameter = \"gamma2\", from = 0, to = 1, points = 3 }\n\
                    [compute]\nfamilies = [\"double-sided\"]\n";
        Scene::parse(Path::new("scene.toml"), text).unwrap()
    }

    const PLAIN: Tile = Tile { class: Some(Class::StableDouble), mechanism: None };
    const HATCHED: Tile = Tile { class: Some(Class::UnstableDouble), mechanism: Some(Mechanism::PeriodDoubling) };
    const EMPTY: Tile = Tile { class: Some(Class::None), mechanism: None };

    /// A disc in the middle, and a slanted stripe so wide on the left.
    fn regions(width: f64) -> Regions<Tile> {
        let angle = |i: i32| f64::from(i % 720).to_radians() / 2.0;
        let disc = (0..=720).map(|i| [2.0 + 0.4 * angle(i).cos(), 0.5 + 0.2 * angle(i).sin()]).collect();
        let edge = |x: f64| vec![[x, 0.0], [x + 0.2, 1.0]];
        let borders = [disc, edge(1.1), edge(1.1 + width)];
        let subdivision = Subdivision::new(Window::of(&scene()).unwrap(), &borders, 1e-7).unwrap();
        subdivision.classified(
            100,
            || (),
            move |(), [x, y]| {
                let off = x - 1.1 - 0.2 * y;
                if ((x - 2.0) / 0.4).hypot((y - 0.5) / 0.2) < 1.0 {
                    HATCHED
                } else if off > 0.0 && off < width {
                    EMPTY
                } else {
                    PLAIN
                }
            },
        )
    }

    /// Pixels of the map along each axis.
    const SIZE: [u32; 2] = [900; 2];

    fn picture(regions: &Regions<Tile>, format: Format) -> Vec<u8> {
        let (scene, borders, palette) = (scene(), ["period doubling", "grazing", "grazing"], Palette::Colour);
        regions_picture(&RegionsPicture { scene: &scene, regions, borders: &borders, palette }, format).unwrap()
    }

    #[test]
    fn a_region_is_a_shape_with_a_title_and_its_own_area() {
        let svg = String::from_utf8(picture(&regions(0.05), Format::Svg)).unwrap();
        assert!(svg.contains("<title>unstable double-sided, period doubling: 12.57 % of the window</title>"));
        assert!(svg.contains("<title>no physical breather: 2.50 % of the window</title>"));
        assert_eq!(svg.matches("<title>stable double-sided").count(), 2);
        assert!(picture(&regions(0.05), Format::Png).starts_with(b"\x89PNG"));
        assert_eq!((svg.matches("<pattern").count(), svg.matches("</pattern>").count()), (1, 1));
        assert!(svg.contains("aria-label=\"grazing\""), "no key");
        // The area of each shape from its commands, in pixels.
        let mut areas = Vec::new();
        for shape in svg.split("<path").skip(1).filter(|shape| shape.contains("<title>")) {
            let d = shape.split(" d=\"").nth(1).unwrap().split('"').next().unwrap();
            let loops = d.split('M').skip(1).map(|part| {
                let places: Vec<Place> = part
                    .trim_end_matches('Z')
                    .split('L')
                    .map(|place| place.split_once(' ').unwrap())
                    .map(|(x, y)| [x.parse().unwrap(), y.parse().unwrap()])
                    .collect();
                let next = places.iter().cycle().skip(1);
                -0.5 * places.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
            });
            areas.push(loops.sum::<f64>() / f64::from(SIZE[0] * SIZE[1]));
        }
        let expected = [0.0, 0.04 * std::f64::consts::PI, 0.1, 0.025];
        assert_eq!(areas.len(), 4);
        // The largest first; what is left is its own.
        let largest = 1.0 - expected.iter().sum::<f64>();
        for (area, expected) in areas.iter().zip([largest, expected[1], expected[2], expected[3]]) {
            assert!((area - expected).abs() < 3e-5, "{areas:?}");
        }
    }

    #[test]
    fn a_stripe_is_drawn_by_its_share_however_thin() {
        for width in [0.05, 1e-4, 1e-7] {
            let regions = regions(width);
            let stripe = |region: &&Region<Tile>| region.class == EMPTY;
            let shares = covered(regions.regions().iter().filter(stripe), SIZE);
            let pixels = f64::from(SIZE[0] * SIZE[1]);
            assert!((shares.iter().sum::<f64>() / pixels / (0.5 * width) - 1.0).abs() < 1e-4, "{width}");
            let all = covered(regions.regions().iter(), SIZE);
            assert!(all.iter().all(|share| (share - 1.0).abs() < 1e-9));
        }
        // A tenth of a pixel wide, white on dark blue: each pixel it passes is a little lighter.
        let thin = regions(0.1 * 2.0 / f64::from(SIZE[0]));
        let (scene, palette) = (scene(), Palette::Colour);
        let all = raster(&RegionsPicture { scene: &scene, regions: &thin, borders: &[], palette }, SIZE, 1);
        let [dark, white] = [PLAIN, EMPTY].map(|tile| f64::from(palette.pixel(tile, 0, 0)[0]));
        let row = &all[3 * 100 * SIZE[0] as usize..3 * 101 * SIZE[0] as usize];
        let light: f64 = row.chunks(3).map(|pixel| (f64::from(pixel[0]) - dark) / (white - dark)).sum();
        assert!((light - 0.1).abs() < 0.01, "{light}");
        assert!(row.chunks(3).all(|pixel| f64::from(pixel[0]) < 0.2 * white));
    }
}
