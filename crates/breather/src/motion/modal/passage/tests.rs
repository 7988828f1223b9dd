//! Bounds of a contact between two places and velocities.

use std::f64::consts::{FRAC_PI_2, TAU};

use vibrochain_testkit::Random;

use super::*;

/// F t²(t−h)²/24 + v t: no place nor velocity at either end but the drift v, and |g⁗| = F all along. In the middle it is F h⁴/384 away from
/// the cubic of its ends, and its velocity is √3 F h³/216 away from v: both bounds are attained.
#[test]
fn bounds_between_two_ends_are_attained() {
    let mut random = Random(3);
    let mut checked = 0;
    for _ in 0..200 {
        let (length, fourth) = (random.log(1e-2, 3.0), random.log(1e-3, 1e3));
        let truth = fourth * length.powi(4) / 384.0;
        let still = Passage::new([0.0; 2], [0.0; 2], length, fourth);
        for barrier in [Barrier::Lower, Barrier::Upper] {
            let stop = barrier.sign() * random.log(0.1, 10.0) * truth;
            let off = barrier.sign() * stop - still.room(barrier, stop);
            assert!(off >= truth && off < truth * (1.0 + 1e-6), "{off:e} {truth:e}");
            checked += 1;
        }
        let most = fourth * length.powi(3) * 3f64.sqrt() / 216.0;
        for (part, turns) in [(0.999, true), (1.01, false), (-0.999, true), (-1.01, false)] {
            let drift = part * most;
            let passage = Passage::new([0.0, drift], [drift * length, drift], length, fourth);
            assert_eq!(passage.may_turn([false; 2]), turns, "{part} {length} {fourth}");
            checked += 1;
        }
    }
    assert_eq!(checked, 200 * 6);
}

/// Sums of sines keep the room that is told, and turn only where they may; four contacts at a time as one by one.
#[test]
fn a_contact_has_the_room_that_is_told() {
    let mut random = Random(5);
    let (mut straight, mut near) = (0, 0);
    for _ in 0..400 {
        let terms: [[f64; 3]; 3] =
            std::array::from_fn(|_| [random.between(-1.0, 1.0), random.log(0.3, 2.0), random.between(0.0, TAU)]);
        let length = random.log(0.05, 1.5);
        let at = |order: i32, t: f64| -> f64 {
            let turn = f64::from(order) * FRAC_PI_2;
            terms.iter().map(|[size, rate, phase]| size * rate.powi(order) * (rate * t + phase + turn).sin()).sum()
        };
        let samples = |order: i32| (0..=300).map(move |i| length * f64::from(i) / 300.0).map(move |t| at(order, t));
        let fourth = samples(4).fold(0.0, |most: f64, x| most.max(x.abs())) * 1.001;
        let (begin, end) = ([at(0, 0.0), at(1, 0.0)], [at(0, length), at(1, length)]);
        let passage = Passage::new(begin, end, length, fourth);
        for barrier in [Barrier::Lower, Barrier::Upper] {
            let stop = barrier.sign() * random.between(0.0, 2.0);
            let least = samples(0).map(|x| barrier.sign() * (stop - x)).fold(f64::INFINITY, f64::min);
            let room = passage.room(barrier, stop);
            assert!(room <= least, "{room} {least}");
            near += usize::from(least - room < 0.1 * length);
            let other = [random.unit(), 0.0];
            let four_of = |own: f64, other: f64| f64x4::from([other, own, other, other]);
            let all = Passage::new(
                [four_of(begin[0], other[0]), four_of(begin[1], other[1])],
                [four_of(end[0], other[0]), four_of(end[1], other[1])],
                length,
                four_of(fourth, 1.0),
            );
            let lane = all.room(barrier, f64x4::splat(stop)).to_array()[1];
            assert!((lane - room).abs() < 1e-15 && (all.of(1).room(barrier, stop) - room).abs() < 1e-15);
        }
        if !passage.may_turn([false; 2]) {
            let (low, high) =
                samples(1).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            assert!(low * high > 0.0, "{low} {high}");
            straight += 1;
        }
    }
    assert!(straight > 100 && near > 400, "{straight} {near}");
}

/// Where a contact turns at an end of its flight it is told to turn nowhere else only if it does not.
#[test]
fn a_contact_that_turns_at_an_end_may_turn_nowhere_else() {
    let mut random = Random(7);
    let (mut nowhere, mut again) = (0, 0);
    for _ in 0..2000 {
        let terms: [[f64; 2]; 3] = std::array::from_fn(|_| [random.between(-1.0, 1.0), random.log(0.3, 2.0)]);
        let length = random.log(0.05, 2.0);
        let at = |order: i32, t: f64| -> f64 {
            let turn = f64::from(order) * FRAC_PI_2;
            terms.iter().map(|[size, rate]| size * rate.powi(order) * (rate * t + turn).cos()).sum()
        };
        let fourth = terms.iter().map(|[size, rate]| size.abs() * rate.powi(4)).sum();
        let ends = [0.0, length].map(|t| [at(0, t), at(1, t)]);
        let backwards = random.chance(0.5);
        let passage = if backwards {
            Passage::new([ends[1][0], -ends[1][1]], [ends[0][0], 0.0], length, fourth)
        } else {
            Passage::new([ends[0][0], 0.0], ends[1], length, fourth)
        };
        let inside: Vec<f64> = (1..=300).map(|i| at(1, length * f64::from(i) / 300.0)).collect();
        let turns = !(inside.iter().all(|v| *v > 0.0) || inside.iter().all(|v| *v < 0.0));
        let told = passage.may_turn([!backwards, backwards]);
        assert!(told || !turns, "{terms:?} {length}");
        assert!(passage.may_turn([backwards, !backwards]));
        nowhere += usize::from(!told);
        again += usize::from(turns);
    }
    assert!(nowhere > 1000 && again > 30, "{nowhere} {again}");
}
