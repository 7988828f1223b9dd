//! Lines without the points that they pass anyway.

use crate::drawing::{Place, Rgb};

/// Points of shapes and strokes may be so many pixels off: no eye, and no print, sees less.
pub(crate) const FINE: f64 = 0.005;

/// Lines of one kind.
pub(crate) struct Stroke<'a> {
    pub(crate) kind: &'a str,
    pub(crate) colour: Rgb,
    pub(crate) lines: Vec<Vec<Place>>,
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
}
