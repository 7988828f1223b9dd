//! Kernels and their derivatives against sums, differences and bounds.

use super::*;
use crate::model::chain::Chain;
use crate::modes::spectrum::Spectrum;

fn response(sites: usize, g1: f64, g2: f64, omega: f64) -> ImpulseResponse {
    ImpulseResponse::new(&Spectrum::new(Chain::new(sites, g1, g2).unwrap()), omega).unwrap()
}

#[test]
fn jet_and_shortcuts_agree_with_the_plain_sum() {
    for omega in [0.21, 1.5, 60.0] {
        let r = response(9, 0.2, 0.1, omega);
        let s: f64 = (0..r.modes()).map(|k| r.weights[k] * r.mode_static(k)).sum();
        assert!((r.static_stiffness() * s - 1.0).abs() < 1e-14);
        assert!((r.dynamic_at_impulse() + s - r.value(0, 0.0)).abs() < 1e-13 * s);
        assert!((r.dynamic_at_half() + s - r.value(0, 0.5 * r.period)).abs() < 1e-13 * s);
        for fraction in [-0.41, -0.1, 0.0, 0.3] {
            let (offset, h) = (fraction * r.period, 1e-4 * r.period);
            let jet = r.jet_from_half(offset);
            let t = 0.5 * r.period + offset;
            assert!((jet.value + s - r.value(0, t)).abs() < 1e-13 * s);
            assert!((jet.slope - r.derivative(0, t)).abs() < 1e-14);
            let curvature = (r.derivative(0, t + h) - r.derivative(0, t - h)) / (2.0 * h);
            assert!((jet.curvature - curvature).abs() < 1e-5 * omega, "{omega} {fraction}");
            let step = |o: f64| r.jet_from_half(offset + o).curvature;
            assert!((jet.third - (step(h) - step(-h)) / (2.0 * h)).abs() < 1e-5 * omega.max(1.0).powi(2));
            let bounds = r.derivative_bounds_of(&r.squares);
            for (value, bound) in [jet.slope, jet.curvature, jet.third].iter().zip(bounds) {
                assert!(value.abs() <= bound * (1.0 + 1e-14), "{omega} {fraction}");
            }
        }
    }
}

#[test]
fn modes_four_at_a_time_are_as_one_by_one() {
    let mut compared = 0;
    for (sites, g1) in [(1, 0.2), (2, 0.0), (5, 1e-4), (9, 0.2), (21, 0.0), (40, 3.0), (126, 0.2)] {
        for omega in [0.021, 0.21, 0.83, 1.5, 3.0, 60.0] {
            let r = response(sites, g1, 0.1, omega);
            for part in -40..=40 {
                let offset = f64::from(part) / 80.0 * r.period;
                // Modes or times by fours.
                let jets = r.jets_of(&r.squares, [0.0, offset, -offset, 0.3 * offset]);
                let [value, slope, curvature, third] = jets.map(|jets| jets[1]);
                let of_times = KernelJet { value, slope, curvature, third };
                let (fours, ones) = (r.jet_by_fours(&r.squares, offset), r.jet_one_by_one(&r.squares, offset));
                let own = r.own_weights();
                let size = |power: i32| -> f64 {
                    let term = |k: usize| {
                        let sine = r.sin_half[k].abs().min(0.5 * r.frequencies[k] * r.period);
                        let scale = if sine > 0.0 { r.frequencies[k] / sine } else { 1.0 / r.period };
                        own[k] * scale * (1.0 + r.frequencies[k].powi(power))
                    };
                    (0..r.modes()).map(term).sum()
                };
                // Terms of K itself are larger by their static part.
                let static_part =
                    r.period * r.at_half().iter().chain(r.at_impulse()).fold(1.0, |m: f64, x| m.max(x.abs()));
                for fours in [fours, of_times] {
                    let pairs = [
                        (fours.value, ones.value, static_part * (1.0 + size(0))),
                        (fours.slope, ones.slope, (1.0 + r.period) * size(0)),
                        (fours.curvature, ones.curvature, size(0)),
                        (fours.third, ones.third, (1.0 + r.period) * size(2)),
                    ];
                    for (four, one, size) in pairs {
                        assert!((four - one).abs() <= 1e-15 * size, "{sites} {omega} {offset}: {four} {one} {size}");
                        compared += 1;
                    }
                }
            }
        }
    }
    assert_eq!(compared, 7 * 6 * 81 * 8);
}

#[test]
fn jets_between_sites_are_the_kernel_but_for_what_the_net_impulse_holds_up() {
    for (sites, omega) in [(2, 0.6), (9, 1.5), (8, 0.21), (5, 40.0)] {
        let r = response(sites, 0.2, 0.1, omega);
        let still: f64 = (0..r.modes()).map(|k| r.weights[k] * r.mode_static(k)).sum();
        for (to, from) in [(1, 0), (0, sites - 1), (sites / 2, 0)] {
            for fraction in [-0.5, -0.3, 0.0, 0.21] {
                let offset = fraction * r.period;
                let (jet, t) = (r.jet_between(to, from, offset), 0.5 * r.period + offset);
                let distance = to.abs_diff(from);
                assert!((jet.value + still - r.value(distance, t)).abs() < 1e-13 * still, "{sites} {to} {from}");
                assert!((jet.slope - r.derivative(distance, t)).abs() < 1e-14);
                let h = 1e-4 * r.period;
                let step = |o: f64| r.jet_between(to, from, offset + o);
                assert!((jet.curvature - (step(h).slope - step(-h).slope) / (2.0 * h)).abs() < 1e-5 * omega.max(1.0));
            }
        }
    }
    // A ring that nothing holds: the mean displacement apart, finite.
    let spectrum = Spectrum::new(Chain::new(5, 0.0, 0.1).unwrap());
    let free = ImpulseResponse::new(&spectrum, 1.5).unwrap();
    let held = response(5, 1e-9, 0.1, 1.5);
    for offset in [-0.3, 0.1] {
        let (free, held) = (free.jet_between(2, 0, offset), held.jet_between(2, 0, offset));
        assert!((free.value - held.value).abs() < 1e-7, "{free:?} {held:?}");
    }
}

/// Over the whole period no derivative is beyond its bound, and of one mode each comes near: a soft mode at the ends of the period, a fast one at
/// the crests of its sine and cosine.
#[test]
fn derivatives_stay_within_their_bounds_and_reach_them() {
    let (mut checked, mut near) = (0, 0);
    for (sites, gamma1) in [(1, 0.0), (1, 1e-3), (1, 0.2), (1, 7.0), (2, 0.2), (9, 0.2), (9, 0.0), (80, 0.2)] {
        for omega in [0.23, 0.9, 1.5, 60.0] {
            let r = response(sites, gamma1, 0.1, omega);
            let bounds = r.derivative_bounds_of(&r.squares);
            let mut most = [0.0_f64; 4];
            let h = 1e-5 * r.period;
            for i in -400..=400 {
                let offset = 0.4999 * r.period * f64::from(i) / 400.0;
                let jet = r.jet_from_half(offset);
                let [before, after] = [offset - h, offset + h].map(|at| r.jet_from_half(at).third);
                let all = [jet.slope, jet.curvature, jet.third, (after - before) / (2.0 * h)];
                most.iter_mut().zip(all).for_each(|(most, own)| *most = most.max(own.abs()));
            }
            for (order, (most, bound)) in most.into_iter().zip(bounds).enumerate() {
                // Of the difference: a rounding of the third derivative over h.
                let rounding = if order == 3 { 1e-14 * bounds[2] / h } else { 1e-14 * bound };
                assert!(most <= bound * (1.0 + 1e-6) + rounding, "{sites} {gamma1} {omega} {order}: {most} {bound}");
                // A mode whose sine does not reach its crest within half a period is bounded by one that does: 1/sin 1.
                let least = if bound > 0.0 { bound / 1.2 } else { 0.0 };
                if sites == 1 && most > 1e3 * rounding {
                    assert!(most >= least * 0.99, "{gamma1} {omega} {order}: {most} {bound}");
                    near += 1;
                }
                checked += 1;
            }
        }
    }
    assert!(checked == 8 * 4 * 4 && near > 40, "{checked} {near}");
}
