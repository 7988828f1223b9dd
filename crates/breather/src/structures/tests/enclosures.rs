//! What enclosures of two impacts and of three are made of: kernels with bounds of their derivatives and of rounding.

use std::f64::consts::TAU;
use std::sync::Arc;

use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};
use vibrochain_testkit::Random;

use super::model;
use crate::structures::between::Between;
use crate::structures::equations::Equations;
use crate::structures::model::LoadedStructure;

/// Kernels there and back are those of the sums over modes, and their fourth derivatives within the radius are below their bounds, and near
/// them on small radii where one mode is all there is.
#[test]
fn kernels_between_contacts_have_derivatives_within_their_bounds() {
    let mut random = Random(61);
    let (mut checked, mut near) = (0, 0);
    for _ in 0..120 {
        let model = model(&mut random);
        let (from, to) = (random.below(2), random.below(2));
        let equations = Equations::new(&model, 1, [from, to].into_iter()).unwrap();
        let (kernel, period) = (equations.kernel(), equations.period());
        let Some(between) = Between::new(kernel, from, to) else { continue };
        let fast = kernel.regular().map(|(mode, _)| mode.rate + mode.decay).fold(0.0, f64::max);
        for _ in 0..10 {
            let phi = period * random.between(0.02, 0.98);
            let radius = random.log(1e-4, 1.0) * phi.min(period - phi);
            let (jets, fourths) = between.jets([phi, 0.5 * period, phi, 0.3 * period], [0.0, 0.0, radius, 0.0]);
            let plain = between.jets_at(phi);
            for (way, (a, b, t)) in [(to, from, phi), (from, to, period - phi)].into_iter().enumerate() {
                let (mut jet, sizes) = kernel.jet(a, b, t);
                if way == 1 {
                    // Back, derivatives are by φ.
                    (jet[1], jet[3]) = (-jet[1], -jet[3]);
                }
                for order in 0..4 {
                    let size = 1e-12 * sizes[order.min(2)] * if order == 3 { fast } else { 1.0 };
                    let own = jets[way][order].to_array();
                    assert!(
                        (own[0] - jet[order]).abs() <= size && (own[2] - jet[order]).abs() <= size,
                        "{order} {own:?} {jet:?} {size:e}"
                    );
                    if order < 3 {
                        assert!((plain[way][order] - jet[order]).abs() <= size);
                    }
                }
                let bound = fourths[way].to_array()[2];
                // Differences of third derivatives.
                let h = 1e-3 * radius;
                let third = |s: f64| kernel.jet(a, b, s).0[3];
                let fourth = |k: i32| {
                    let s = t + (radius - h) * f64::from(k) / 20.0;
                    ((third(s + h) - third(s - h)) / (2.0 * h)).abs()
                };
                let most = (-20..=20).map(fourth).fold(0.0, f64::max);
                let rounding = 1e-13 * jet[3].abs().max(bound * radius) / h;
                assert!(most <= bound * (1.0 + 1e-6) + rounding, "{most} {bound} {rounding}");
                checked += 1;
                near += usize::from(most > 0.3 * bound);
            }
        }
    }
    assert!(checked > 1000 && near > 200, "{checked} {near}");
}

/// What rounding of a mode's frequency and of the period does to kernels is within what is told of it, and not far below.
#[test]
fn doubts_of_kernels_cover_what_rounding_does() {
    let mut random = Random(67);
    let mut checked = 0;
    let stop = Contact { lower: None, upper: Some(1.0), restitution: 0.8 };
    for away in [1e-1, 1e-2, 1e-3] {
        for _ in 0..10 {
            let (shape, decay) = (random.between(0.3, 1.0), random.of(&[0.0, 1e-6]));
            let kernels = |step: f64| {
                let shape = ModeShape { contacts: vec![shape], coordinates: Vec::new(), still: 0.0 };
                let frequency = (1.0 + away) * (1.0 + step);
                let mode = LinearMode::oscillator(decay, frequency * frequency, &shape, &[]);
                let structure = ModalStructure::new(vec![stop], Vec::new(), vec![mode]).unwrap();
                LoadedStructure::new(Arc::new(structure), 1.0).unwrap()
            };
            let step = 1e-9;
            let models = [kernels(0.0), kernels(step)];
            let [one, other] = models.each_ref().map(|model| Equations::new(model, 1, [0, 0].into_iter()).unwrap());
            let [one, other] = [one, other].map(|equations| Between::new(equations.kernel(), 0, 0).unwrap());
            let mut most = [[0.0_f64; 3]; 2];
            for i in 1..40 {
                let phi = TAU * f64::from(i) / 40.0;
                let [a, b] = [one.jets_at(phi), other.jets_at(phi)];
                for (way, order) in (0..2).flat_map(|way| (0..3).map(move |order| (way, order))) {
                    most[way][order] = most[way][order].max((a[way][order] - b[way][order]).abs());
                }
            }
            for (most, doubts) in most.iter().flatten().zip(one.doubts.iter().flatten()) {
                // As much as one rounding of the frequency does.
                let rounding = most * f64::EPSILON / step;
                assert!(rounding <= *doubts && *doubts < 40.0 * rounding, "{away}: {rounding:e} {doubts:e}");
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 3 * 10 * 6);
}

/// Closer to a resonance the kernels, both ways and all derivatives, are those of one mode nearby to within their doubts: all have the same
/// (1−R)⁻¹, whose error is that of a rounding of the frequency. So what is proved of them is proved of that mode.
#[test]
fn kernels_next_to_a_resonance_are_those_of_a_mode_nearby() {
    let mut random = Random(68);
    let (mut checked, mut beyond) = (0, 0);
    let stop = Contact { lower: None, upper: Some(1.0), restitution: 0.8 };
    for away in [9e-5, 1e-5, 1e-6, 1e-7, 1e-8] {
        for _ in 0..10 {
            let (shape, decay) = (random.between(0.3, 1.0), random.of(&[0.0, 1e-9]));
            let frequency = 1.0 + away * random.between(0.5, 1.0);
            let contacts = ModeShape { contacts: vec![shape], coordinates: Vec::new(), still: 0.0 };
            let mode = LinearMode::oscillator(decay, frequency * frequency, &contacts, &[]);
            let rate = mode.rate;
            let structure = ModalStructure::new(vec![stop], Vec::new(), vec![mode]).unwrap();
            let model = LoadedStructure::new(Arc::new(structure), 1.0).unwrap();
            let equations = Equations::new(&model, 1, [0, 0].into_iter()).unwrap();
            let between = Between::new(equations.kernel(), 0, 0).unwrap();
            // 1 − e^z of z = λT, whose angle is small but for a turn: rate − 1 is exact.
            let (a, b) = (-decay * TAU, TAU * (rate - 1.0));
            let half = (0.5 * b).sin();
            let one_less = Complex::new(2.0 * half * half - a.exp_m1() * b.cos(), -a.exp() * b.sin());
            let pole = Complex::new(-decay, rate);
            // K and two derivatives at φ, of the exact sum times a number.
            let exact = |phi: f64, times: Complex<f64>| -> [[f64; 3]; 2] {
                let way = |t: f64, sign: f64| {
                    let motion = (pole * t).exp() / one_less * times * (shape * shape / rate);
                    [motion.im, sign * (pole * motion).im, (pole * pole * motion).im]
                };
                [way(phi, 1.0), way(TAU - phi, -1.0)]
            };
            let [one, i] = [Complex::new(1.0, 0.0), Complex::new(0.0, 1.0)];
            // The relative error of the sum from the kernel at two φ.
            let off = |phi: f64| between.jets_at(phi)[0][0] - exact(phi, one)[0][0];
            let (p, q) = (0.4, 2.0);
            let by = |phi: f64| [exact(phi, one)[0][0], exact(phi, i)[0][0]];
            let ([a, b], [c, d]) = (by(p), by(q));
            let determinant = a * d - b * c;
            let error = Complex::new(d * off(p) - b * off(q), a * off(q) - c * off(p)) / determinant;
            assert!(error.norm() * one_less.norm() < 20.0 * f64::EPSILON, "{away:e}: {error}");
            for k in 1..40 {
                let phi = TAU * f64::from(k) / 40.0;
                let (told, plain) = (between.jets_at(phi), exact(phi, one));
                let nearby = exact(phi, one + error);
                for (way, order) in (0..2).flat_map(|way| (0..3).map(move |order| (way, order))) {
                    let doubt = 2.0 * between.doubts[way][order];
                    let apart = (told[way][order] - nearby[way][order]).abs();
                    assert!(apart <= doubt, "{away:e} {phi} {way} {order}: {apart:e} {doubt:e}");
                    checked += 1;
                    beyond += usize::from((told[way][order] - plain[way][order]).abs() > doubt);
                }
            }
        }
    }
    // They are not those of the mode itself.
    assert!(checked == 5 * 10 * 39 * 6 && beyond > 1000, "{checked} {beyond}");
}
