//! Colours and textures of a map's cells.

use vibrochain_floquet::Mechanism;

use crate::cell::{Cell, Class};

/// A set of colours for the classes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Palette {
    /// Blues for stable, orange and yellow for unstable: told apart by colour-blind eyes, and by their lightness in grey.
    #[default]
    Colour,
    /// The greys of the paper's maps.
    Paper,
}

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
    fn class(self, class: Option<Class>) -> Rgb {
        match (self, class) {
            (Self::Colour, Some(Class::None)) => [255, 255, 255],
            (Self::Colour, Some(Class::StableDouble | Class::Double)) => [16, 50, 98],
            (Self::Colour, Some(Class::StableSingle | Class::Single)) => [46, 134, 171],
            (Self::Colour, Some(Class::UnstableDouble)) => [236, 138, 60],
            (Self::Colour, Some(Class::UnstableSingle)) => [250, 224, 120],
            (Self::Paper, Some(Class::None)) => [0, 0, 0],
            (Self::Paper, Some(Class::StableDouble | Class::Double)) => [70, 70, 70],
            (Self::Paper, Some(Class::StableSingle | Class::Single)) => [135, 135, 135],
            (Self::Paper, Some(Class::UnstableDouble)) => [200, 200, 200],
            (Self::Paper, Some(Class::UnstableSingle)) => [255, 255, 255],
            (_, None) => [204, 121, 167],
        }
    }

    /// Colour of the pixel (x, y) of a tile. Textures go by the pixel's place in the picture, so that they run through
    /// neighbouring cells: period doubling is hatched, a pitchfork dotted, Neimark–Sacker plain.
    pub fn pixel(self, tile: Tile, x: u32, y: u32) -> Rgb {
        let marked = match (tile.class, tile.mechanism) {
            (None, _) => (x + y) % 4 < 1,
            (_, Some(Mechanism::PeriodDoubling)) => (x + y) % 6 < 2,
            (_, Some(Mechanism::Pitchfork)) => x % 4 < 2 && y % 4 < 2,
            (_, Some(Mechanism::NeimarkSacker) | None) => false,
        };
        let colour = self.class(tile.class);
        if marked { colour.map(|c| (f64::from(c) * 0.55) as u8) } else { colour }
    }
}

/// Colours of lines in a diagram, in order of use: dark and light take turns, so that neighbours in a legend are told
/// apart in grey; the hues are apart for colour-blind eyes.
pub(crate) const LINES: [Rgb; 6] =
    [[16, 50, 98], [236, 138, 60], [0, 120, 90], [110, 190, 235], [150, 40, 90], [150, 150, 150]];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_told_apart_in_grey() {
        for palette in [Palette::Colour, Palette::Paper] {
            let five = &Class::ALL[..5];
            let mut greys: Vec<f64> = five
                .iter()
                .map(|&class| {
                    let [r, g, b] = palette.class(Some(class)).map(f64::from);
                    0.299 * r + 0.587 * g + 0.114 * b
                })
                .collect();
            greys.sort_by(f64::total_cmp);
            assert!(greys.windows(2).all(|pair| pair[1] - pair[0] > 30.0), "{palette:?} {greys:?}");
        }
    }

    #[test]
    fn neighbouring_lines_are_told_apart_in_grey() {
        let grey = |[r, g, b]: Rgb| 0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b);
        assert!(LINES.windows(2).all(|pair| (grey(pair[0]) - grey(pair[1])).abs() > 30.0));
    }

    #[test]
    fn mechanisms_have_textures() {
        let tile = |mechanism| Tile { class: Some(Class::UnstableSingle), mechanism: Some(mechanism) };
        let dark = |mechanism| {
            (0..12)
                .flat_map(|x| (0..12).map(move |y| (x, y)))
                .filter(|&(x, y)| Palette::Colour.pixel(tile(mechanism), x, y) != [250, 224, 120])
                .count()
        };
        assert_eq!(dark(Mechanism::NeimarkSacker), 0);
        assert_eq!((dark(Mechanism::PeriodDoubling), dark(Mechanism::Pitchfork)), (48, 36));
    }
}
