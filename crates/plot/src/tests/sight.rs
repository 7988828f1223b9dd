//! How colours look to other eyes and on grey paper: for tests that what a legend tells apart can be told apart.

use crate::backend::drawing::Rgb;

/// Who looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sight {
    All,
    Protanopia,
    Deuteranopia,
    Tritanopia,
    Grey,
}

impl Sight {
    pub(crate) const EACH: [Self; 5] = [Self::All, Self::Protanopia, Self::Deuteranopia, Self::Tritanopia, Self::Grey];

    /// G. M. Machado, M. M. Oliveira, L. A. F. Fernandes, A physiologically-based model for simulation of color vision deficiency,
    /// IEEE Transactions on Visualization and Computer Graphics 15 (2009) 1291, at severity 1, for linear RGB. Grey is the luminance
    /// of sRGB.
    fn matrix(self) -> [[f64; 3]; 3] {
        match self {
            Self::All => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            Self::Protanopia => {
                [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
            }
            Self::Deuteranopia => {
                [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
            }
            Self::Tritanopia => {
                [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
            }
            Self::Grey => [LUMINANCE; 3],
        }
    }
}

/// Y of the CIE from linear sRGB.
const LUMINANCE: [f64; 3] = [0.2126729, 0.7151522, 0.0721750];

/// Least distance of two colours of a legend in CIE Lab: about four times what is just noticed side by side, as they do not lie side by
/// side.
const APART: f64 = 9.0;

fn times(matrix: [[f64; 3]; 3], colour: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row.iter().zip(colour).map(|(a, b)| a * b).sum())
}

/// L*, a*, b* of the CIE, for daylight D65, as a colour is seen.
pub(crate) fn lab(rgb: Rgb, sight: Sight) -> [f64; 3] {
    let linear = |c: u8| {
        let c = f64::from(c) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    };
    let seen = times(sight.matrix(), rgb.map(linear)).map(|c| c.clamp(0.0, 1.0));
    let xyz = times([[0.4124564, 0.3575761, 0.1804375], LUMINANCE, [0.0193339, 0.1191920, 0.9503041]], seen);
    let f = |t: f64| if t > 216.0 / 24389.0 { t.cbrt() } else { (24389.0 / 27.0 * t + 16.0) / 116.0 };
    let [x, y, z] = [f(xyz[0] / 0.95047), f(xyz[1]), f(xyz[2] / 1.08883)];
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Pairs of a legend that somebody cannot tell apart, and how many pairs were looked at.
pub(crate) fn confused(legend: &[(&str, Rgb)]) -> (usize, Vec<String>) {
    let (mut pairs, mut found) = (0, Vec::new());
    for sight in Sight::EACH {
        for (i, (one, a)) in legend.iter().enumerate() {
            for (other, b) in &legend[..i] {
                pairs += 1;
                let [a, b] = [*a, *b].map(|colour| lab(colour, sight));
                let distance = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
                if distance < APART {
                    found.push(format!("{one} and {other}, {sight:?}: {distance:.1}"));
                }
            }
        }
    }
    (pairs, found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_have_the_coordinates_of_the_books() {
        // Red, green and blue of sRGB in CIE Lab.
        for (rgb, known) in [
            ([255, 0, 0], [53.24, 80.09, 67.20]),
            ([0, 255, 0], [87.73, -86.18, 83.18]),
            ([0, 0, 255], [32.30, 79.19, -107.86]),
            ([119, 119, 119], [50.03, 0.0, 0.0]),
        ] {
            let found = lab(rgb, Sight::All);
            assert!(found.iter().zip(known).all(|(a, b)| (a - b).abs() < 0.02), "{rgb:?} {found:?}");
        }
        // Who lacks a kind of cones sees greys as all do, and no two of the three see all colours alike.
        for sight in Sight::EACH {
            for grey in [0, 60, 128, 200, 255] {
                let [a, b] = [lab([grey; 3], sight), lab([grey; 3], Sight::All)];
                assert!((0..3).all(|k| (a[k] - b[k]).abs() < 0.02), "{sight:?} {grey} {a:?}");
            }
        }
        // Red and green of one lightness: the classical confusion; blue and green are that of others.
        let near = |sight: Sight, one: Rgb, other: Rgb| {
            let [a, b] = [lab(one, sight), lab(other, sight)];
            (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
        };
        let (red, green) = ([178, 84, 60], [110, 112, 62]);
        assert!(near(Sight::All, red, green) > 40.0 && near(Sight::Deuteranopia, red, green) < 15.0);
        assert!(near(Sight::Tritanopia, red, green) > 30.0);
        let (teal, blue) = ([0, 140, 140], [40, 130, 175]);
        assert!(near(Sight::Tritanopia, teal, blue) < near(Sight::All, teal, blue) / 2.0);
    }

    #[test]
    fn the_colours_of_one_confusion_are_found() {
        let (pairs, found) = confused(&[("plum", [150, 40, 90]), ("green", [0, 120, 90]), ("white", [255; 3])]);
        assert!(pairs == 15 && found[0].starts_with("green and plum, Deuteranopia: "), "{found:?}");
        assert!(found.iter().all(|pair| !pair.contains("white")), "{found:?}");
    }
}
