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
}

/// Of each pixel along an axis that has about so many, the cells that lie in it, with their shares.
fn cells_of_pixels(cells: usize, pixels: u32) -> Vec<Vec<(usize, f32)>> {
    let cells = cells.max(1) as u32;
    let times = (f64::from(pixels) / f64::from(cells)).round().max(1.0) as u32;
    parts(cells, if cells > pixels { pixels } else { cells * times })
}
