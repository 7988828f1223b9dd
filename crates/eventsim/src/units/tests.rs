//! How far a blow is felt.

use super::*;

#[test]
fn reach_covers_the_response_and_stops() {
    let reach = |time: f64| super::reach([0.1, 0.0], time, 1.0);
    assert!(reach(0.3) < reach(1.0) && reach(1.9) <= 12);
    assert_eq!(super::reach([0.0; 2], 1.0, 1.0), 1);
}

/// A mass in a long row is struck, with springs and dashpots between neighbours: beyond the reach of that nobody has moved by more than rounding, and
/// without dashpots the last but one of those within has.
#[test]
fn beyond_its_reach_a_blow_moves_nobody() {
    let (n, mut cases) = (61, 0);
    for (spring, dashpot) in [(0.3, 0.0), (-0.05, 0.0), (0.3, 0.2), (0.0, 0.3), (0.05, 0.6)] {
        for time in [0.1, 0.5, 1.3, 1.9] {
            let (mut place, mut speed) = (vec![0.0; n], vec![0.0; n]);
            speed[n / 2] = 1.0;
            let (mut moved, mut power) = (vec![0.0; n], 1.0);
            let stretch = |d: &[f64], i: usize| {
                d.get(i.wrapping_sub(1)).unwrap_or(&0.0) + d.get(i + 1).unwrap_or(&0.0) - 2.0 * d[i]
            };
            for k in 1..90 {
                power *= time / f64::from(k);
                moved.iter_mut().zip(&speed).for_each(|(moved, d)| *moved += power * d);
                let next = (0..n).map(|i| spring * stretch(&place, i) + dashpot * stretch(&speed, i)).collect();
                place = std::mem::replace(&mut speed, next);
            }
            let far = reach([spring, dashpot], time, 1.0);
            assert!(far < 25 && moved[n / 2 + far + 1].abs() <= REMAINDER, "{spring} {dashpot} {time}: {far}");
            assert!(dashpot > 0.0 || moved[n / 2 + far - 1].abs() > REMAINDER, "{spring} {dashpot} {time}: {far}");
            cases += 1;
        }
    }
    assert_eq!(cases, 20);
}
