//! The pixels of a map: every cell the same whole number of them.

use crate::drawing::Rgb;
use crate::key::texture;
use crate::sheet::Placed;

/// The pixels of a map.
pub(crate) struct Raster {
    pub(crate) size: [u32; 2],
    pub(crate) rgb: Vec<u8>,
}

impl Raster {
    /// Of so many cells along the axes, each by its number and the place of the pixel; one pixel each at least.
    pub(crate) fn of([columns, rows]: [usize; 2], placed: &Placed, colour: &dyn Fn(usize, u32, u32) -> Rgb) -> Self {
        let [[left, top], [right, bottom]] = placed.corners();
        let times = |length: f64, cells: usize| {
            let pixels = (length * placed.page.scale()).round();
            (pixels / cells.max(1) as f64).round().max(1.0) as u32
        };
        let (wide, high) = (times(right - left, columns), times(bottom - top, rows));
        let size = [columns as u32 * wide, rows as u32 * high];
        let grain = texture(&placed.page);
        let mut rgb = Vec::with_capacity(3 * size[0] as usize * size[1] as usize);
        for py in 0..size[1] {
            let row = rows - 1 - (py / high) as usize;
            for px in 0..size[0] {
                let column = (px / wide) as usize;
                rgb.extend(colour(row * columns + column, px / grain, py / grain));
            }
        }
        Self { size, rgb }
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
