//! Colours and textures of a map's cells.

use vibrochain_breather::Family;
use vibrochain_floquet::Mechanism;

use vibrochain_maps::cell::{Cell, Class};

/// A set of colours for the classes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Palette {
    /// Blues for stable, orange and yellow for unstable: told apart by colour-blind eyes, and by their lightness in grey.
    #[default]
    Colour,
    /// The greys of the paper's maps.
    Paper,
}

vibrochain_lattice::names!(Palette { Colour "colour", Paper "paper" });

/// What is drawn in one cell: its class, and the mechanism of instability as a texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tile {
    /// `None` where the class is not known.
    pub class: Option<Class>,
    /// For unstable classes.
    pub mechanism: Option<Mechanism>,
}

impl From<&Cell> for Tile {
    fn from(cell: &Cell) -> Self {
        Self { class: cell.class, mechanism: cell.mechanism }
    }
}

type Rgb = [u8; 3];

impl Palette {
    /// Where no breather is.
    pub(crate) fn nothing(self) -> Rgb {
        self.class(Some(Class::None))
    }

    /// Pixel (x, y) where nothing is known.
    pub(crate) fn unknown(self, x: u32, y: u32) -> Rgb {
        self.pixel(Tile { class: None, mechanism: None }, x, y)
    }

    /// A place on the scale of numbers, from 0 to 1: viridis, even in lightness and told apart by colour-blind eyes; or greys.
    pub fn scale(self, part: f64) -> Rgb {
        let part = part.clamp(0.0, 1.0);
        match self {
            Self::Colour => colorous::VIRIDIS.eval_continuous(part).as_array(),
            Self::Paper => [(90.0 + 165.0 * part).round() as u8; 3],
        }
    }

    /// Below the scale of numbers.
    pub fn below(self) -> Rgb {
        match self {
            Self::Colour => [215, 215, 215],
            Self::Paper => [55, 55, 55],
        }
    }

    fn class(self, class: Option<Class>) -> Rgb {
        match (self, class) {
            (Self::Colour, Some(Class::None)) => [255, 255, 255],
            (Self::Colour, Some(Class::StableDouble | Class::Double)) => [16, 50, 98],
            (Self::Colour, Some(Class::StableSingle | Class::Single)) => [46, 134, 171],
            (Self::Colour, Some(Class::UnstableDouble)) => [236, 138, 60],
            (Self::Colour, Some(Class::UnstableSingle)) => [250, 224, 120],
            (Self::Colour, Some(Class::StableWord | Class::Word)) => [0, 110, 84],
            (Self::Colour, Some(Class::UnstableWord)) => [235, 168, 204],
            (Self::Paper, Some(Class::StableWord | Class::Word)) => [35, 35, 35],
            (Self::Paper, Some(Class::UnstableWord)) => [227, 227, 227],
            (Self::Paper, Some(Class::None)) => [0, 0, 0],
            (Self::Paper, Some(Class::StableDouble | Class::Double)) => [70, 70, 70],
            (Self::Paper, Some(Class::StableSingle | Class::Single)) => [135, 135, 135],
            (Self::Paper, Some(Class::UnstableDouble)) => [200, 200, 200],
            (Self::Paper, Some(Class::UnstableSingle)) => [255, 255, 255],
            (_, None) => [204, 121, 167],
        }
    }

    /// Colour of the pixel (x, y) of a tile.
    pub fn pixel(self, tile: Tile, x: u32, y: u32) -> Rgb {
        let marked = match (tile.class, tile.mechanism) {
            (None, _) => (x + y) % 4 < 1,
            (_, mechanism) => mechanism.is_some_and(|mechanism| is_marked(mechanism, x, y)),
        };
        shaded(self.class(tile.class), marked)
    }
}

/// Colour of the pixel (x, y) of a mechanism in a legend: on a grey that is no class's, as textures are the same on all of them.
pub fn sample(mechanism: Mechanism, x: u32, y: u32) -> Rgb {
    shaded([225, 225, 225], is_marked(mechanism, x, y))
}

/// Textures go by the pixel's place in the picture, so that they run through neighbouring cells: period doubling is hatched, what
/// leaves through +1 dotted, or striped where it is known to be a pitchfork, Neimark–Sacker plain.
fn is_marked(mechanism: Mechanism, x: u32, y: u32) -> bool {
    match mechanism {
        Mechanism::PeriodDoubling => (x + y) % 6 < 2,
        Mechanism::PlusOne => x % 4 < 2 && y % 4 < 2,
        Mechanism::Pitchfork => x % 6 < 2,
        Mechanism::NeimarkSacker => false,
    }
}

fn shaded(colour: Rgb, marked: bool) -> Rgb {
    if marked { colour.map(|c| (f64::from(c) * 0.55) as u8) } else { colour }
}

/// Colours of lines in a diagram, in order of use: neighbours in a legend are told apart at a glance in grey, any two by
/// colour-blind eyes and in grey. The first three are the families' own, as their stable classes have them in a map; that of an
/// unstable class is none, so that orange says *unstable* wherever it stands.
pub const LINES: [Rgb; 6] =
    [[16, 50, 98], [46, 134, 171], [0, 110, 84], [116, 197, 242], [120, 24, 144], [157, 157, 157]];

/// The colour of lines of each family, one of [`LINES`]: that of its stable class in maps. Maps have no period-doubled family; it has
/// a colour of its own.
pub const FAMILIES: [(Family, usize); 3] =
    [(Family::DoubleSided, 0), (Family::SingleSided, 1), (Family::PeriodDoubled, 3)];
/// That of words.
pub const WORDS: usize = 2;
/// That of marks of events.
pub const MARKS: usize = 4;
/// That of what is not physical.
pub const GREY: usize = 5;
/// Those of curves of events, by turns: of borders in maps, as none is a family's; without violet, which marks have.
pub const CURVES: [usize; 5] = [6, 7, 8, 10, 11];

/// Colours of borders of regions, in order of use: none is a class's, no two are of one hue, and all show on white, which is drawn under
/// them. Apart for colour-blind eyes and in grey.
pub const BORDERS: [Rgb; 6] = [[0, 0, 0], [222, 36, 36], [0, 160, 84], [120, 40, 190], [255, 125, 205], [80, 52, 10]];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::sight::{Sight, confused, lab};

    #[test]
    fn whatever_stands_in_one_legend_is_told_apart_by_all_eyes_and_in_grey() {
        let mut pairs = 0;
        let mut check = |legend: &[(&str, Rgb)]| {
            let (looked, found) = confused(legend);
            pairs += looked;
            assert!(found.is_empty(), "{found:#?}");
        };
        for palette in [Palette::Colour, Palette::Paper] {
            // Classes without a verdict have the colour of the stable ones, with which they share no legend.
            let without = [Class::Double, Class::Single, Class::Word];
            let of = |class: Class| (class.name(), palette.class(Some(class)));
            let judged: Vec<_> = Class::ALL.into_iter().filter(|class| !without.contains(class)).map(of).collect();
            check(&judged);
            assert!(without.iter().all(|class| judged.iter().any(|(_, colour)| *colour == of(*class).1)));
        }
        for colours in [LINES, BORDERS] {
            let names = ["0", "1", "2", "3", "4", "5"];
            check(&names.into_iter().zip(colours).collect::<Vec<_>>());
        }
        assert_eq!(pairs, 5 * (2 * 21 + 2 * 15));
    }

    #[test]
    fn a_colour_means_the_same_in_maps_and_in_curves() {
        let class = |class| Palette::Colour.class(Some(class));
        let families = [Class::StableDouble, Class::StableSingle, Class::StableWord].map(class);
        assert_eq!(families, LINES[..3]);
        let unstable = [Class::UnstableDouble, Class::UnstableSingle, Class::UnstableWord].map(class);
        assert!(LINES.iter().all(|line| !unstable.contains(line)));
    }

    #[test]
    fn no_two_borders_are_of_one_hue() {
        let seen = BORDERS.map(|colour| lab(colour, Sight::All));
        let hues = seen.iter().filter(|[_, a, b]| a.hypot(*b) > 20.0).map(|[_, a, b]| b.atan2(*a).to_degrees());
        let mut hues: Vec<f64> = hues.collect();
        hues.sort_by(f64::total_cmp);
        let round = hues.iter().zip(hues.iter().skip(1).copied().chain([hues[0] + 360.0]));
        assert!(hues.len() == 5 && round.clone().all(|(one, next)| next - one > 25.0), "{hues:?}");
    }

    /// What is not known is told from all classes by its texture, which no mechanism has.
    #[test]
    fn what_is_not_known_has_a_texture_of_its_own() {
        let places = || (0..12).flat_map(|x| (0..12).map(move |y| (x, y)));
        let marks =
            |pixel: &dyn Fn(u32, u32) -> Rgb| places().map(|(x, y)| pixel(x, y) != pixel(1, 0)).collect::<Vec<_>>();
        for palette in [Palette::Colour, Palette::Paper] {
            let unknown = marks(&|x, y| palette.unknown(x, y));
            assert_eq!(unknown.iter().filter(|marked| **marked).count(), 36);
            assert!(Mechanism::ALL.iter().all(|one| marks(&|x, y| sample(*one, x, y)) != unknown));
            for sight in Sight::EACH {
                let [on, off] = [palette.unknown(0, 0), palette.unknown(1, 0)].map(|colour| lab(colour, sight)[0]);
                assert!(off - on > 20.0, "{palette:?} {sight:?}");
            }
        }
    }

    #[test]
    fn the_scale_of_numbers_rises_evenly_in_lightness() {
        for palette in [Palette::Colour, Palette::Paper] {
            let seen = |sight: Sight| (0..=10).map(move |i| lab(palette.scale(f64::from(i) / 10.0), sight)[0]);
            for sight in Sight::EACH {
                let steps: Vec<f64> = seen(sight).collect();
                assert!(steps.windows(2).all(|pair| pair[1] - pair[0] > 3.0), "{palette:?} {sight:?} {steps:?}");
            }
            let steps: Vec<f64> = seen(Sight::All).collect();
            let rises: Vec<f64> = steps.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let mean = (steps[10] - steps[0]) / 10.0;
            assert!(mean > 5.0 && rises.iter().all(|rise| (rise / mean - 1.0).abs() < 0.25), "{palette:?} {rises:?}");
            // What is not on the scale is none of its colours, in any place of a pixel.
            let beside = [palette.nothing(), palette.below(), palette.unknown(0, 0), palette.unknown(1, 1)];
            let far = |a: Rgb, b: Rgb| a.iter().zip(b).map(|(a, b)| a.abs_diff(b)).max().unwrap() > 20;
            let scale: Vec<Rgb> = (0..=255).map(|i| palette.scale(f64::from(i) / 255.0)).collect();
            assert!(beside.iter().all(|other| scale.iter().all(|colour| far(*colour, *other))), "{palette:?}");
        }
    }

    #[test]
    fn neighbouring_lines_are_told_apart_in_grey() {
        let grey = |[r, g, b]: Rgb| 0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b);
        assert!(LINES.windows(2).all(|pair| (grey(pair[0]) - grey(pair[1])).abs() > 30.0));
    }

    #[test]
    fn mechanisms_have_textures() {
        let places = || (0..12).flat_map(|x| (0..12).map(move |y| (x, y)));
        let plain = |class| Palette::Colour.class(Some(class));
        let dark = |mechanism: Mechanism| {
            let on = |class| {
                let tile = Tile { class: Some(class), mechanism: Some(mechanism) };
                places().map(|(x, y)| Palette::Colour.pixel(tile, x, y) != plain(class)).collect::<Vec<_>>()
            };
            // The same on either class, and in the legend, whose grey is no class's.
            let pattern = on(Class::UnstableDouble);
            assert_eq!(pattern, on(Class::UnstableSingle));
            assert!(places().zip(&pattern).all(|((x, y), &dark)| {
                let [r, g, b] = sample(mechanism, x, y);
                r == g && g == b && (r < 200) == dark
            }));
            pattern
        };
        let patterns = Mechanism::ALL.map(dark);
        let count = patterns.each_ref().map(|pattern| pattern.iter().filter(|dark| **dark).count());
        assert_eq!(count, [36, 48, 48, 0]);
        assert!((0..4).all(|i| (0..i).all(|j| patterns[i] != patterns[j])));
    }
}
