#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use crate::flight::system::System;
use crate::series::tests::empty;
use crate::units::{MAX_ORDER, ORDERS, REMAINDER};
use vibrochain_lattice::{Force, Harmonic, Model, Point};

fn model(g1: f64, g2: f64, omega: f64, amplitude: f64) -> Model {
    Point::ring(21).gamma1(g1).gamma2(g2).omega(omega).asymmetry(0.4).amplitude(amplitude).model().unwrap()
}

/// From the softest to the stiffest.
#[test]
fn rates_are_of_order_one_for_any_model() {
    for (g1, g2, omega, amplitude) in
        [(0.2, 0.1, 1.5, 0.0), (1e100, 1e99, 1.0, 0.0), (0.0, 1e-300, 1e-100, 0.0), (0.2, 0.1, 1e100, 1.0)]
    {
        let system = System::of_chain(&model(g1, g2, omega, amplitude), 0.0);
        let local = system.local.as_ref().unwrap();
        assert!((1.0..2.0).contains(&(system.fastest / local.scale)), "{} {}", system.fastest, local.scale);
        let horizons = local.horizons;
        assert!(horizons.windows(2).all(|h| 0.0 < h[0] && h[0] < h[1]) && horizons[7] < 2.0, "{horizons:?}");
    }
}

#[test]
fn derivatives_of_a_force_of_several_harmonics_are_those_of_its_sum() {
    let harmonic = |number, amplitude, phase| Harmonic { number, amplitude, phase };
    let force = Force::new(&[harmonic(1, 0.7, 0.4), harmonic(5, -0.2, 1.0)]).unwrap();
    let model = Point::ring(3).gamma1(0.2).gamma2(0.1).omega(13.0).asymmetry(0.4).under(&force).model().unwrap();
    let system = System::of_chain(&model, 0.0);
    let local = system.local.as_ref().unwrap();
    assert!((system.fastest - 65.0).abs() < 1e-12);
    for i in 0..30 {
        let t = 0.11 * f64::from(i);
        let turned = system.loads.turned(t);
        let direct = 0.7 * (13.0 * t + 0.4).cos() - 0.2 * (65.0 * t + 1.0).cos();
        assert!((local.load(&turned, 1, 0) - direct).abs() < 1e-12);
        let third = 0.7 * 13f64.powi(3) * (13.0 * t + 0.4).sin() - 0.2 * 65f64.powi(3) * (65.0 * t + 1.0).sin();
        assert!((local.load(&turned, 1, 3) - third).abs() < 1e-12 * 65f64.powi(3));
    }
}

/// The motion that a force in resonance drives: what its series leaves out beyond an order is below the rounding of its size at the end of
/// that order's window, and no window is much shorter than that asks for.
#[test]
fn what_a_series_leaves_out_is_below_rounding() {
    for (g1, g2, omega, forced) in
        [(0.2, 0.1, 1.5, 0.0), (0.2, 0.1, 0.3, 0.5), (1.0, 0.0, 1.0, 3.0), (0.2, 0.1, 7.0, 0.1)]
    {
        let system = System::of_chain(&model(g1, g2, omega, forced), 0.0);
        let local = system.local.as_ref().unwrap();
        let rate = local.growth.rate;
        // Sizes of the derivatives of U cos rs + V/r sin rs + A/2r · s sin rs.
        let d = |k: i32| 3.1 * rate.powi(k) + 0.5 * f64::from(k) * forced * rate.powi(k - 2);
        let mut rows = empty(1);
        for k in 0..=MAX_ORDER {
            let entry = k * rows.stride + 1;
            rows.data[entry] = d(k as i32);
        }
        for (order, longest) in ORDERS.into_iter().zip(local.horizons) {
            rows.order = order;
            let horizon = local.certified(&rows, longest, system.fastest);
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
            let size = (0..4).map(|k| d(k) / rate.powi(k)).fold(0.0, f64::max);
            let (place, velocity) = (place / size, velocity / rate / size);
            assert!(place <= REMAINDER && velocity <= 1.2 * REMAINDER, "{order} {horizon}: {place:e} {velocity:e}");
            assert!(velocity > REMAINDER / 8.0, "{order} {horizon}: {velocity:e}");
        }
    }
}
