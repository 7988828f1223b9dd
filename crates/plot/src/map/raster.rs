//! The pixels of a map: every cell the same whole number of them, or, where there are more cells than pixels, the mean of the cells that
//! lie in a pixel.

use crate::backend::coverage::parts;
use crate::backend::drawing::{Rgb, sides};
use crate::map::key::texture;
use crate::map::sheet::Placed;

/// The pixels of a map.
pub(crate) struct Raster {
    pub(crate) size: [u32; 2],
    pub(crate) rgb: Vec<u8>,
}

/// Hands on the colours of a cell at a pixel of textures, with their shares of it.
pub(crate) type Colours<'a> = dyn Fn(usize, [u32; 2], &mut dyn FnMut(Rgb, f32)) + 'a;

impl Raster {
    /// Of so many cells along the axes, by their numbers, the lowest row first.
    pub(crate) fn of([columns, rows]: [usize; 2], placed: &Placed, colours: &Colours<'_>) -> Self {
        if placed.page.measures {
            return Self { size: [0; 2], rgb: Vec::new() };
        }
        let [wide, high] = placed.page.pixels(sides(placed.corners()));
        let (across, down) = (cells_of_pixels(columns, wide), cells_of_pixels(rows, high));
        let grain = texture(&placed.page);
        let mut rgb = Vec::with_capacity(3 * across.len() * down.len());
        for (py, down) in (0..).zip(&down) {
            for (px, across) in (0..).zip(&across) {
                let at = [px / grain, py / grain];
                let mut mean = [0.0_f32; 3];
                for &(row, high) in down {
                    for &(column, wide) in across {
                        colours((rows - 1 - row) * columns + column, at, &mut |colour, share| {
                            let share = share * wide * high;
                            mean.iter_mut().zip(colour).for_each(|(sum, part)| *sum += share * f32::from(part));
                        });
                    }
                }
                rgb.extend(mean.map(|part| part.round() as u8));
            }
        }
        Self { size: [across.len() as u32, down.len() as u32], rgb }
    }

    /// Whether it is dark at a place, given by its parts.
    pub(crate) fn is_dark(&self, parts: [f64; 2]) -> bool {
        let [x, y] = [0, 1].map(|i| {
            let last = self.size[i].saturating_sub(1);
            (parts[i] * f64::from(self.size[i])).clamp(0.0, f64::from(last)) as usize
        });
        let first = 3 * (y * self.size[0] as usize + x);
        let grey =
            |rgb: &[u8]| rgb.iter().zip([0.3, 0.59, 0.11]).map(|(c, weight)| f64::from(*c) * weight).sum::<f64>();
        self.rgb.get(first..first + 3).is_some_and(|rgb| grey(rgb) < 110.0)
    }
}

/// Of each pixel along an axis that has about so many, the cells that lie in it, with their shares.
fn cells_of_pixels(cells: usize, pixels: u32) -> Vec<Vec<(usize, f32)>> {
    let cells = cells.max(1) as u32;
    let times = (f64::from(pixels) / f64::from(cells)).round().max(1.0) as u32;
    parts(cells, if cells > pixels { pixels } else { cells * times })
}
