//! Bounds of one flight: of modes, of accelerations, of places, and polynomials on windows.

use vibrochain_lattice::{ModeFlow, Turn, Turned};
use vibrochain_testkit::Random;

use super::orbits;
use crate::motion::modal::view::reach;
use crate::motion::modal::windows::{Room, Windows};
use crate::structures::flight::ContactMotion;
use crate::structures::periodic_kernel::length;

/// The length of a mode's state or of a derivative stays below its bound on a flight, and comes near it on some.
#[test]
fn a_mode_stays_within_its_reach() {
    let mut random = Random(41);
    let mut nearest = [[0.0_f64; 3]; 2];
    for round in 0..3000 {
        let turn = [Turn::Circular, Turn::Hyperbolic, Turn::Parabolic][round % 3];
        let grows = random.chance(0.4);
        let decay = random.log(1e-3, 2.0) * if grows { -1.0 } else { 1.0 };
        let flow = ModeFlow { turn, decay, rate: random.log(0.1, 4.0) };
        let (state, left) = ([random.between(-1.0, 1.0), random.between(-1.0, 1.0)], random.log(0.01, 4.0));
        let order = random.below(5) as u32;
        let bound = reach(flow, state, left, order);
        let generator = Turned { even: -decay, odd: flow.rate };
        let mut most = 0.0_f64;
        for i in 0..=200 {
            let flown = turn.act(turn.flight(decay, flow.rate, left * f64::from(i) / 200.0), state);
            most = most.max(length((0..order).fold(flown, |xi, _| turn.act(generator, xi))));
        }
        assert!(most <= bound * (1.0 + 1e-12), "{flow:?} {state:?} {left} {order}: {most} {bound}");
        let near = &mut nearest[usize::from(grows)][round % 3];
        *near = near.max(most / bound);
    }
    // A circle is met; along two real poles the bound of the length has a factor √2, and shear adds its own.
    assert!(
        nearest.iter().all(|[circle, stretch, shear]| *circle > 0.999 && *stretch > 0.69 && *shear > 0.8),
        "{nearest:?}"
    );
}

/// No acceleration in what is left of a flight is beyond its bound, which is the sum of few terms: on some it is nearly met.
#[test]
fn accelerations_stay_within_their_bound() {
    let mut random = Random(43);
    let (mut checked, mut near) = (0, 0);
    orbits(&mut random, 200, |orbit, random| {
        let motion = ContactMotion::new(orbit).unwrap();
        for i in 0..orbit.impacts().len() {
            let whole = motion.until_next(i);
            for contact in 0..2 {
                let s = random.between(0.0, 0.9) * whole;
                let end = random.between(s, whole);
                let bound = motion.bound(contact, 2, i, [s, end]);
                let at = |k: i32| motion.contact(contact, i, s + (end - s) * f64::from(k) / 100.0)[2].abs();
                let most = (0..=100).map(at).fold(0.0, f64::max);
                assert!(most <= bound * (1.0 + 1e-12), "{most} {bound}");
                checked += 1;
                near += usize::from(most > 0.5 * bound);
            }
        }
    });
    assert!(checked > 500 && near > 50, "{checked} {near}");
}

/// Polynomials on windows are the motion to rounding; on the whole flight places and fourth derivatives are within their bounds, and often
/// no farther from them than a few modes with different phases are.
#[test]
fn windows_hold_the_motion_and_bound_it() {
    let mut random = Random(47);
    let (mut flights, mut near, mut rows, mut room) = (0, [0, 0], Vec::new(), Room::default());
    orbits(&mut random, 150, |orbit, random| {
        let motion = ContactMotion::new(orbit).unwrap();
        let order = if random.chance(0.5) { vec![0, 1] } else { vec![1, 0] };
        let Some(view) = &motion.response().view_of(&order) else { return };
        for i in 0..orbit.impacts().len() {
            let whole = motion.until_next(i);
            let begin = |both: [&mut [f64]; 2]| motion.begin(view, i, both);
            let Some(mut windows) = Windows::new(view, begin, whole, &mut room) else { continue };
            windows.rows(&mut rows);
            let bounds = windows.bounds();
            let (mut excursions, mut fourths) = ([0.0_f64; 2], [0.0_f64; 2]);
            for number in 0..rows.len() / 2 - 1 {
                let start = windows.start(number);
                for (place, &contact) in order.iter().enumerate() {
                    let polynomial = windows.polynomial(number, place);
                    let still = motion.response().still(contact);
                    for k in 0..=8 {
                        // In windows, as all rates are.
                        let s = f64::from(k) / 8.0;
                        let there = motion.contact(contact, i, start + s * windows.length);
                        let (value, slope) = polynomial.evaluate(s);
                        let size = 1.0 + bounds[0].as_flattened()[place];
                        assert!((value - there[0]).abs() < 1e-12 * size, "{value} {there:?}");
                        assert!((slope - there[1] * windows.length).abs() < 1e-11 * size, "{slope} {there:?}");
                        excursions[place] = excursions[place].max((there[0] - still).abs());
                        // The fourth derivative of the polynomial, by Horner's rule.
                        let terms = polynomial.coefficients.iter().enumerate().skip(4).rev();
                        let fourth =
                            terms.fold(0.0, |sum, (k, c)| sum * s + c * (k * (k - 1) * (k - 2) * (k - 3)) as f64);
                        fourths[place] = fourths[place].max(fourth.abs());
                    }
                }
                let [places, velocities] = [rows[2 * number + 2], rows[2 * number + 3]];
                for (place, &contact) in order.iter().enumerate() {
                    let there = motion.contact(contact, i, start + windows.length);
                    let size = 1.0 + bounds[0].as_flattened()[place];
                    assert!((places[place] - there[0]).abs() < 1e-12 * size, "{places:?} {there:?}");
                    assert!((velocities[place] - there[1] * windows.length).abs() < 1e-11 * size, "{there:?}");
                }
            }
            assert!((windows.start(rows.len() / 2 - 1) - whole).abs() < 1e-12 * whole);
            for place in 0..2 {
                for (n, most) in [excursions[place], fourths[place]].into_iter().enumerate() {
                    let bound = bounds[n].as_flattened()[place];
                    assert!(most <= bound * (1.0 + 1e-9), "{n}: {most} {bound} {orbit:?}");
                    near[n] += usize::from(most > 0.5 * bound);
                }
            }
            flights += 1;
        }
    });
    assert!(flights > 200 && near.iter().all(|near| *near > 60), "{flights} {near:?}");
}

/// The contacts that are looked at on are those that were, in their new places.
#[test]
fn contacts_that_are_kept_are_seen_as_before() {
    let mut random = Random(53);
    let mut compared = 0;
    orbits(&mut random, 60, |orbit, _| {
        let motion = ContactMotion::new(orbit).unwrap();
        // Eight places in the lists: two groups of four.
        let order = [0, 1, 0, 0, 0, 0, 1, 0];
        let Some(view) = &motion.response().view_of(&order) else { return };
        let (begin, mut room) = (|both: [&mut [f64]; 2]| motion.begin(view, 0, both), Room::default());
        let Some(mut windows) = Windows::new(view, begin, motion.until_next(0), &mut room) else { return };
        let mut places = [1, 6];
        windows.keep(&mut places.iter_mut());
        assert_eq!(places, [0, 1]);
        let mut rows = Vec::new();
        windows.rows(&mut rows);
        let [place, velocity] = [rows[2][1], rows[3][1]];
        let there = motion.contact(1, 0, windows.length);
        assert!((place - there[0]).abs() < 1e-12 * (1.0 + there[0].abs()), "{place} {there:?}");
        let speed = there[1] * windows.length;
        assert!((velocity - speed).abs() < 1e-11 * (1.0 + speed.abs()), "{velocity} {there:?}");
        compared += 1;
    });
    assert!(compared > 20, "{compared}");
}
