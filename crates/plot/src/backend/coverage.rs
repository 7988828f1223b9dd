//! How much of each pixel shapes cover, exactly: from the edges of their outlines, each of which adds to all pixels on its right.

use crate::backend::drawing::Place;

/// The shares of the pixels of a picture.
#[derive(Debug, Clone)]
pub(crate) struct Coverage {
    width: usize,
    height: usize,
    /// By rows, differences from the pixel on the left; one more for edges on the right border.
    steps: Vec<f64>,
}

impl Coverage {
    pub(crate) fn new([width, height]: [u32; 2]) -> Self {
        let (width, height) = (width as usize, height as usize);
        Self { width, height, steps: vec![0.0; (width + 2) * height] }
    }

    /// Adds a closed shape, counterclockwise as seen; clockwise it is taken away. What lies beyond the picture is drawn to its edge.
    pub(crate) fn add(&mut self, outline: impl IntoIterator<Item = Place>) {
        let limits = [self.width as f64, self.height as f64];
        let clamped = |place: Place| [place[0].clamp(0.0, limits[0]), place[1].clamp(0.0, limits[1])];
        let mut places = outline.into_iter().map(clamped);
        let Some(first) = places.next() else { return };
        let mut last = first;
        for place in places {
            self.edge(last, place);
            last = place;
        }
        self.edge(last, first);
    }

    fn edge(&mut self, a: Place, b: Place) {
        // An edge that goes down has its shape on the right.
        let (sign, [x0, y0], [x1, y1]) = if a[1] < b[1] { (1.0, a, b) } else { (-1.0, b, a) };
        let slope = (x1 - x0) / (y1 - y0);
        let last = (y1.ceil() as usize).min(self.height);
        for row in y0.floor() as usize..last {
            let (upper, lower) = (y0.max(row as f64), y1.min((row + 1) as f64));
            if lower <= upper {
                continue;
            }
            let at = |y: f64| if y == y1 { x1 } else { (x0 + (y - y0) * slope).clamp(x0.min(x1), x0.max(x1)) };
            let (left, right) = (at(upper).min(at(lower)), at(upper).max(at(lower)));
            let whole = sign * (lower - upper);
            let cells = &mut self.steps[row * (self.width + 2)..(row + 1) * (self.width + 2)];
            for column in left.floor() as usize..=right.floor() as usize {
                let (from, to) = (left.max(column as f64), right.min((column + 1) as f64));
                let part = if right > left { whole * (to - from) / (right - left) } else { whole };
                // Of the pixel it crosses an edge covers what is on its right.
                let passed = 0.5 * (from + to) - column as f64;
                cells[column] += part * (1.0 - passed);
                cells[column + 1] += part * passed;
            }
        }
    }

    /// The shares by rows.
    pub(crate) fn shares(self) -> Vec<f64> {
        let mut shares = Vec::with_capacity(self.width * self.height);
        for row in self.steps.chunks(self.width + 2) {
            let mut sum = 0.0;
            shares.extend(row[..self.width].iter().map(|step| {
                sum += step;
                sum
            }));
        }
        shares
    }
}

/// For each of `to` equal parts of a line, the `from` equal parts in it and their shares.
pub(crate) fn parts(from: u32, to: u32) -> Vec<Vec<(usize, f32)>> {
    let ratio = f64::from(from) / f64::from(to);
    let part = |i: u32| {
        let (low, high) = (f64::from(i) * ratio, f64::from(i + 1) * ratio);
        let inside = low.floor() as usize..(high.ceil() as usize).min(from as usize);
        let share = |k: usize| ((high.min((k + 1) as f64) - low.max(k as f64)) / ratio) as f32;
        inside.map(|k| (k, share(k))).filter(|(_, share)| *share > 1e-6).collect()
    };
    (0..to).map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shares(size: [u32; 2], outlines: &[Vec<Place>]) -> Vec<f64> {
        let mut coverage = Coverage::new(size);
        for outline in outlines {
            coverage.add(outline.iter().copied());
        }
        coverage.shares()
    }

    #[test]
    fn rectangles_cover_what_they_should() {
        let rectangle = |[l, t]: Place, [r, b]: Place| vec![[l, t], [l, b], [r, b], [r, t]];
        let all = shares([4, 3], &[rectangle([0.5, 0.25], [2.75, 2.0])]);
        let row = |part: f64| [0.5 * part, part, 0.75 * part, 0.0];
        let expected: Vec<f64> = [row(0.75), row(1.0), row(0.0)].concat();
        assert!(all.iter().zip(&expected).all(|(one, two)| (one - two).abs() < 1e-15), "{all:?}");
        // The whole picture, and beyond, with a hole.
        let mut hole = rectangle([1.0, 1.0], [2.0, 2.0]);
        hole.reverse();
        let all = shares([4, 3], &[rectangle([-3.0, -1.0], [9.0, 4.0]), hole]);
        assert!(all.iter().enumerate().all(|(i, share)| *share == f64::from(u8::from(i != 5))), "{all:?}");
    }

    #[test]
    fn a_disc_covers_its_pixels_as_fine_points_say() {
        let disc: Vec<Place> = (0..20_000)
            .map(|i| (-std::f64::consts::TAU * f64::from(i) / 20_000.0).sin_cos())
            .map(|(sin, cos)| [6.3 + 4.7 * cos, 5.1 + 4.7 * sin])
            .collect();
        let all = shares([13, 11], &[disc]);
        let mut borders = 0;
        for (i, share) in all.iter().enumerate() {
            let (x, y) = ((i % 13) as f64, (i / 13) as f64);
            let places = (0..200 * 200)
                .map(|k| (x + f64::from(k % 200) / 200.0 + 0.0025, y + f64::from(k / 200) / 200.0 + 0.0025));
            let inside = places.filter(|(x, y)| (x - 6.3).hypot(y - 5.1) < 4.7).count() as f64 / 40_000.0;
            assert!((share - inside).abs() < 1e-3, "{i} {share} {inside}");
            borders += usize::from(inside > 0.0 && inside < 1.0);
        }
        assert!(borders > 30, "{borders}");
        assert!((all.iter().sum::<f64>() - 4.7 * 4.7 * std::f64::consts::PI).abs() < 1e-5);
    }

    #[test]
    fn a_stripe_thinner_than_any_pixel_covers_its_area() {
        for width in [1e-3, 1e-7, 1e-10] {
            // Slanted, and through corners of pixels.
            for (x, slant) in [(2.0, 0.0), (1.0, 5.0), (7.3, -3.1), (0.0, 9.0 - width)] {
                let all =
                    shares([10, 8], &[vec![[x, 0.0], [x + slant, 8.0], [x + slant + width, 8.0], [x + width, 0.0]]]);
                assert!((all.iter().sum::<f64>() - 8.0 * width).abs() < 1e-14, "{width:e} {x} {slant}");
                assert!(all.iter().all(|share| (-1e-14..=1.5 * width + 1e-14).contains(share)));
            }
        }
    }
}
