//! Thin lines over a map, as shares of its pixels or as the paths of an SVG.

use crate::coverage::{Coverage, Place};

/// Points of shapes and strokes may be so many pixels off: no eye, and no print, sees less.
pub(crate) const FINE: f64 = 0.005;

/// Lines of one kind.
pub(crate) struct Stroke<'a> {
    pub(crate) kind: &'a str,
    pub(crate) colour: [u8; 3],
    pub(crate) lines: Vec<Vec<Place>>,
}

/// The shares of the pixels of a picture that lines so many pixels wide cover.
pub(crate) fn shares(lines: &[Vec<Place>], width: f64, size: [u32; 2]) -> impl Iterator<Item = f64> {
    let mut coverage = Coverage::new(size);
    for pair in lines.iter().flat_map(|line| line.windows(2)) {
        let [dx, dy] = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
        let length = dx.hypot(dy);
        if length > 0.0 {
            let [nx, ny] = [0.5 * width * dy / length, -0.5 * width * dx / length];
            let beside = |[x, y]: Place, side: f64| [x + side * nx, y + side * ny];
            coverage.add([beside(pair[0], 1.0), beside(pair[0], -1.0), beside(pair[1], -1.0), beside(pair[1], 1.0)]);
        }
    }
    // Pieces overlap where a line bends.
    coverage.shares().into_iter().map(|share| share.clamp(0.0, 1.0))
}

/// A line without the points that it passes anyway.
pub(crate) fn thinned(line: &[Place]) -> Vec<Place> {
    if line.len() < 3 {
        return line.to_vec();
    }
    let mut kept = vec![false; line.len()];
    let mut ranges = vec![(0, line.len() - 1)];
    while let Some((first, last)) = ranges.pop() {
        (kept[first], kept[last]) = (true, true);
        let [ax, ay] = line[first];
        let [dx, dy] = [line[last][0] - ax, line[last][1] - ay];
        let chord = dx.hypot(dy);
        let off = |i: usize| {
            let [x, y] = [line[i][0] - ax, line[i][1] - ay];
            if chord > FINE { (dx * y - dy * x).abs() / chord } else { x.hypot(y) }
        };
        let farthest = (first + 1..last).map(|i| (off(i), i)).max_by(|one, two| one.0.total_cmp(&two.0));
        if let Some((distance, i)) = farthest
            && distance > FINE
        {
            ranges.extend([(first, i), (i, last)]);
        }
    }
    line.iter().zip(kept).filter_map(|(place, kept)| kept.then_some(*place)).collect()
}

/// The commands of a line, in thousandths of a pixel; none if it is no longer than that.
pub(crate) fn path(line: impl Iterator<Item = Place>, closed: bool) -> String {
    let mut line: Vec<Place> = line.collect();
    if closed {
        line.extend(line.first().copied());
    }
    let mut places: Vec<String> = thinned(&line).iter().map(|[x, y]| format!("{x:.3} {y:.3}")).collect();
    places.dedup();
    if closed {
        places.pop();
    }
    if places.len() < if closed { 3 } else { 2 } {
        return String::new();
    }
    format!("M{}{}", places.join("L"), if closed { "Z" } else { "" })
}

/// A colour as an SVG has it.
pub(crate) fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_thinned_stays_within_a_hundredth_of_a_pixel() {
        let wave: Vec<Place> =
            (0..20_000).map(|i| f64::from(i) / 20.0).map(|x| [x, 300.0 + 200.0 * (x / 40.0).sin()]).collect();
        let thin = thinned(&wave);
        assert!(thin.len() < 3000 && thin.first() == wave.first() && thin.last() == wave.last(), "{}", thin.len());
        let mut checked = 0;
        for pair in thin.windows(2) {
            for [x, y] in wave.iter().filter(|place| place[0] > pair[0][0] && place[0] < pair[1][0]) {
                let part = (x - pair[0][0]) / (pair[1][0] - pair[0][0]);
                let slope = (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]);
                assert!((pair[0][1] + part * (pair[1][1] - pair[0][1]) - y).abs() / slope.hypot(1.0) < 2.0 * FINE);
                checked += 1;
            }
        }
        assert!(checked > 10_000);
    }

    #[test]
    fn a_line_covers_its_length_times_its_width() {
        for width in [0.5, 1.0, 2.5] {
            let lines = [vec![[10.0, 12.0], [40.0, 52.0]], vec![[60.0, 90.0], [20.0, 90.0]]];
            let covered: f64 = shares(&lines, width, [100, 100]).sum();
            assert!((covered - width * (50.0 + 40.0)).abs() < 1e-9, "{width} {covered}");
        }
    }
}
