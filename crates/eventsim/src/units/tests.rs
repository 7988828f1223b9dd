//! Units of models from the softest to the stiffest, and what series of a window leave out.

use super::*;
use vibrochain_lattice::{Harmonic, Point};

fn units(g1: f64, g2: f64, omega: f64, amplitude: f64) -> Units {
    Units::new(&Point::ring(21).gamma1(g1).gamma2(g2).omega(omega).asymmetry(0.4).amplitude(amplitude).model().unwrap())
}

#[test]
fn rates_are_of_order_one_for_any_model() {
    for (g1, g2, omega, amplitude) in
        [(0.2, 0.1, 1.5, 0.0), (1e100, 1e99, 1.0, 0.0), (0.0, 1e-300, 1e-100, 0.0), (0.2, 0.1, 1e100, 1.0)]
    {
        let u = units(g1, g2, omega, amplitude);
        assert!((1.0..2.0).contains(&u.rate), "{u:?}");
        let horizons = u.horizons(1.0);
        assert!(horizons.windows(2).all(|h| 0.0 < h[0] && h[0] < h[1]) && horizons[7] < 2.0);
    }
}

#[test]
fn derivatives_of_a_force_of_several_harmonics_are_those_of_its_sum_and_bounded() {
    let harmonic = |number, amplitude, phase| Harmonic { number, amplitude, phase };
    let force = Force::new(&[harmonic(1, 0.7, 0.4), harmonic(5, -0.2, 1.0)]).unwrap();
    let model = Point::ring(3).gamma1(0.2).gamma2(0.1).omega(13.0).asymmetry(0.4).under(&force).model().unwrap();
    let u = Units::new(&model);
    assert!((u.scale * u.rate - 65.0).abs() < 1e-12);
    for i in 0..30 {
        let t = 0.11 * f64::from(i);
        let mut derivatives = [0.0; MAX_ORDER + 1];
        u.force(t * u.scale, &mut derivatives);
        let direct = 0.7 * (13.0 * t + 0.4).cos() - 0.2 * (65.0 * t + 1.0).cos();
        assert!((derivatives[0] * u.scale * u.scale - direct).abs() < 1e-12);
        let third = 0.7 * 13f64.powi(3) * (13.0 * t + 0.4).sin() - 0.2 * 65f64.powi(3) * (65.0 * t + 1.0).sin();
        assert!((derivatives[3] * u.scale.powi(5) - third).abs() < 1e-12 * 65f64.powi(3));
        for (k, derivative) in derivatives.iter().enumerate() {
            assert!(derivative.abs() <= u.amplitude * u.rate.powi(k as i32) * (1.0 + 1e-13));
        }
    }
}

#[test]
fn reach_covers_the_response_and_stops() {
    let u = units(0.2, 0.1, 1.5, 0.0);
    assert!(u.reach(0.3, 1.0) < u.reach(1.0, 1.0) && u.reach(1.9, 1.0) <= 12);
    assert_eq!(units(0.2, 0.0, 1.5, 0.0).reach(1.0, 1.0), 1);
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

/// The motion that a force in resonance drives from the largest displacement and velocity: what its series leaves out beyond an order is below the
/// rounding of the gap at the end of that order's window, and no window is much shorter than that asks for.
#[test]
fn what_a_series_leaves_out_is_below_rounding() {
    for (g1, g2, omega, amplitude) in
        [(0.2, 0.1, 1.5, 0.0), (0.2, 0.1, 0.3, 0.5), (1.0, 0.0, 1.0, 3.0), (0.2, 0.1, 7.0, 0.1)]
    {
        let u = units(g1, g2, omega, amplitude);
        let fastest = 1.7;
        for (order, horizon) in ORDERS.into_iter().zip(u.horizons(fastest)) {
            // Sizes of the derivatives of U cos rs + V/r sin rs + A/2r · s sin rs.
            let d = |k: i32| {
                let own = (u.upper + fastest / u.rate) * u.rate.powi(k);
                own + 0.5 * f64::from(k) * u.amplitude * u.rate.powi(k - 2)
            };
            let (mut place, mut velocity, mut weight) = (0.0, 0.0, 1.0);
            for k in 1..order as i32 + 40 {
                if k > order as i32 {
                    velocity += d(k) * weight;
                }
                weight *= horizon / f64::from(k);
                if k > order as i32 {
                    place += d(k) * weight;
                }
            }
            let velocity = velocity / u.rate;
            assert!(place <= REMAINDER && velocity <= 1.2 * REMAINDER, "{order} {horizon}: {place:e} {velocity:e}");
            assert!(velocity > REMAINDER / 8.0, "{order} {horizon}: {velocity:e}");
        }
        // Of perturbations of size one, with room for their growth.
        for (order, horizon) in ORDERS.into_iter().zip(u.free_horizons()) {
            let left = (u.rate * horizon).powi(order as i32) * inverse_factorials()[order];
            assert!((4.0 * left / REMAINDER - 1.0).abs() < 1e-9, "{order}: {left:e}");
        }
    }
}
