//! Multipliers of elastic impacts come with 1/μ̄: one on the unit circle to within its error lies on it exactly unless another is so
//! near that the two may have met and left it.

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

use super::growth::excess;

type C = Complex<f64>;

/// The part of the circle in which others may meet one multiplier.
#[derive(Debug, Clone, Copy)]
struct Arc {
    place: usize,
    start: f64,
    end: f64,
}

/// What may have met on the circle.
pub(crate) struct Meetings {
    /// All that may have, by rising place.
    pub(crate) places: Vec<usize>,
    /// Some who may have met each other, nobody twice.
    pub(crate) pairs: Vec<(usize, usize)>,
}

/// All that may have met on the circle: one of the two is within `room` times its error of the circle, and they
/// are within twice that of each other. O(M log M), and what meets.
pub(crate) fn meetings(values: &[C], errors: &[f64], room: f64) -> Meetings {
    let reach = |place: usize| room * errors[place];
    let on_circle = |place: usize| excess(values[place]).abs() <= reach(place);
    let near = |i: usize, j: usize| (values[i] - values[j]).norm() <= 2.0 * (reach(i) + reach(j));
    let arc = |(place, z): (usize, &C)| {
        let angle = z.im.atan2(z.re);
        // Chords c of a point at least ½ from the centre span no more than the angle πc.
        let half = 2.0 * PI * reach(place);
        // Not a number is anywhere.
        let half = if half < PI { half } else { PI };
        Arc { place, start: angle - half, end: angle + half }
    };
    let mut arcs: Vec<Arc> = values.iter().enumerate().map(arc).collect();
    // What begins behind −π goes on before π, where any other reaches as far.
    let last = arcs.iter().fold(-PI, |last, arc| last.max(arc.end));
    let turned = |arc: &Arc| Arc { start: arc.start + TAU, end: arc.end + TAU, ..*arc };
    let turned: Vec<Arc> = arcs.iter().map(turned).filter(|arc| arc.start <= last).collect();
    arcs.reserve_exact(turned.len());
    arcs.extend(turned);
    arcs.sort_unstable_by(|a, b| a.start.total_cmp(&b.start));
    let mut met = vec![false; values.len()];
    let mut pairs = Vec::new();
    for (i, arc) in arcs.iter().enumerate() {
        for other in arcs[i + 1..].iter().take_while(|other| other.start <= arc.end) {
            let (a, b) = (arc.place, other.place);
            if a != b && !(met[a] && met[b]) && (on_circle(a) || on_circle(b)) && near(a, b) {
                if !met[a] && !met[b] {
                    pairs.push((a, b));
                }
                (met[a], met[b]) = (true, true);
            }
        }
    }
    Meetings { places: (0..values.len()).filter(|place| met[*place]).collect(), pairs }
}

#[cfg(test)]
mod tests {
    use super::super::tests::Random;
    use super::*;

    /// Crowds on and off the circle, across −1 too, against all pairs.
    #[test]
    fn what_meets_is_what_all_pairs_say() {
        let mut random = Random(5);
        let (mut some, mut none) = (0, 0);
        for case in 0..600 {
            let count = 1 + (random.unit() * 60.0) as usize;
            let crowd = [3.2, 0.3, 1e-6][case % 3];
            let centre = [std::f64::consts::PI, 0.4, -1.0][(case / 3) % 3];
            let scale = random.log(1e-5, 0.5) * crowd / count as f64;
            let (mut values, mut errors) = (Vec::new(), Vec::new());
            for _ in 0..count {
                let radius = if random.unit() < 0.5 { 1.0 } else { 1.0 + (random.unit() - 0.7) * crowd.min(0.6) };
                values.push(C::from_polar(radius, centre + crowd * (random.unit() - 0.5)));
                errors.push(scale * random.log(1e-3, 1.0));
            }
            let room = 4.0;
            let on = |k: usize| (values[k].norm() - 1.0).abs() <= room * errors[k];
            let near = |i: usize, j: usize| (values[i] - values[j]).norm() <= 2.0 * room * (errors[i] + errors[j]);
            let meet = |i: usize, j: usize| j != i && near(i, j) && (on(i) || on(j));
            let plain: Vec<usize> = (0..count).filter(|&i| (0..count).any(|j| meet(i, j))).collect();
            let met = meetings(&values, &errors, room);
            assert_eq!(met.places, plain, "{case}");
            let mut paired: Vec<usize> = met.pairs.iter().flat_map(|&(i, j)| [i, j]).collect();
            paired.sort_unstable();
            assert!(paired.iter().all(|place| plain.contains(place)) && paired.windows(2).all(|two| two[0] < two[1]));
            assert_eq!(paired.is_empty(), plain.is_empty(), "{case}");
            assert!(met.pairs.iter().all(|&(i, j)| meet(i, j)), "{case}");
            *(if plain.is_empty() { &mut none } else { &mut some }) += 1;
        }
        assert!(some > 50 && none > 50, "{some} {none}");
    }
}
