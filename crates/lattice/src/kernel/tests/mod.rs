//! Against the series that the kernel sums, the periodic kernel of the lattice, and differences.

use rustfft::num_complex::Complex;

use super::{BlochKernel, Coordinates, ModeFlow, Turn};
use crate::{Chain, Ends, ImpulseResponse, LinearMode, ModeShape, Model, Spectrum};

type C = Complex<f64>;

/// Evenly from 0 to 1.
fn unit(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64
}

/// h, h′, h″, h‴ of one oscillator, by the sine or hyperbolic sine over its argument and the equation of motion.
fn answer(decay: f64, square: f64, t: f64) -> [f64; 4] {
    let x = square.abs().sqrt() * t;
    let decayed = |rate: f64| ((rate - decay * t).exp(), (-rate - decay * t).exp());
    let (h, even) = if square.abs() * t * t < 1e-8 {
        let decayed = (-decay * t).exp();
        (decayed * t * (1.0 - square * t * t / 6.0), decayed * (1.0 - 0.5 * square * t * t))
    } else if square < 0.0 {
        let (slow, fast) = decayed(x);
        let over = if x < 1.0 { (-decay * t).exp() * x.sinh() / x } else { 0.5 * (slow - fast) / x };
        (t * over, 0.5 * (slow + fast))
    } else {
        let decayed = (-decay * t).exp();
        (decayed * t * x.sin() / x, decayed * x.cos())
    };
    let first = even - decay * h;
    let stiffness = square + decay * decay;
    let second = -2.0 * decay * first - stiffness * h;
    [h, first, second, -2.0 * decay * second - stiffness * first]
}

#[test]
fn the_kernel_is_the_series_it_sums_whatever_the_damping() {
    let mut seed = 1;
    let (mut kinds, mut checked) = (Vec::new(), 0);
    for damping in [-0.05, 0.0, 1e-9, 0.1, 0.7, 0.999_999, 1.0 - 1e-13, 1.0, 1.0 + 1e-13, 1.000_001, 1.4, 5.0] {
        for frequency in [0.0, 1e-6, 0.03, 0.9, 4.0] {
            let period = 2.0 + 4.0 * unit(&mut seed);
            let mut kernel = BlochKernel::new(period, 2);
            let shapes = [0.7, -0.4];
            kernel.push_oscillator(frequency, damping, &shapes);
            kinds.push(kernel.modes()[0].coordinates);
            let (decay, square) = (damping * frequency, frequency * frequency * (1.0 - damping) * (1.0 + damping));
            // Far enough out that few terms are left.
            let slowest = kernel.modes()[0].poles().iter().map(|pole| pole.norm()).fold(0.0, f64::max);
            let z = C::from_polar(1.6 * slowest.max(0.5), 6.3 * unit(&mut seed));
            for t in [-0.9, -0.3, 0.0, 0.1, 0.6, 1.0].map(|part| part * period) {
                let jet = kernel.jet(0, 1, t, z);
                let mut sum = [C::default(); 4];
                for n in i32::from(t <= 0.0)..140 {
                    let terms = answer(decay, square, t + period * f64::from(n));
                    for (sum, term) in sum.iter_mut().zip(terms) {
                        *sum += z.powi(-n) * term * shapes[0] * shapes[1];
                    }
                }
                let scale = sum.iter().map(|x| x.norm()).fold(1.0, f64::max);
                for (order, (found, expected)) in jet.kernel.iter().zip(sum).enumerate() {
                    let off = (found - expected).norm();
                    assert!(off < 2e-13 * scale, "{damping} {frequency} {t} {order}: {found} {expected}");
                }
                let h = 1e-5;
                let [plus, minus] = [h, -h].map(|h| kernel.jet(0, 1, t, z + h).kernel);
                for ((slope, plus), minus) in jet.slope.iter().zip(plus).zip(minus) {
                    assert!((slope - (plus - minus) / (2.0 * h)).norm() < 1e-8 * scale, "{damping} {frequency} {t}");
                }
                checked += 1;
            }
        }
    }
    let count = |kind: Coordinates| kinds.iter().filter(|other| **other == kind).count();
    let shared = [Turn::Circular, Turn::Hyperbolic, Turn::Parabolic].map(|turn| count(Coordinates::Shared(turn)));
    assert!(checked == 360 && shared[0] > 20 && shared[1] > 5 && shared[2] > 10, "{shared:?}");
    assert!(count(Coordinates::Apart) > 3, "{kinds:?}");
}

#[test]
fn flights_of_many_modes_are_those_of_each() {
    let mut seed = 7;
    let mut checked = 0;
    for count in [0, 1, 3, 4, 5, 11] {
        let turns = [Turn::Circular, Turn::Circular, Turn::Hyperbolic, Turn::Circular, Turn::Parabolic];
        // The first few lose alike.
        let modes: Vec<_> = (0..count)
            .map(|k| ModeFlow {
                turn: turns[k % 5],
                decay: if k < 3 { 0.1 } else { unit(&mut seed) - 0.3 },
                rate: 0.2 + 3.0 * unit(&mut seed),
            })
            .collect();
        let t = 5.0 * unit(&mut seed);
        let flights = Turn::flights(modes.iter().copied(), t);
        assert_eq!(flights.len(), count);
        for (flight, ModeFlow { turn, decay, rate }) in flights.into_iter().zip(modes) {
            let own = turn.flight(decay, rate, t);
            let size = own.even.hypot(own.odd);
            assert!((flight.even - own.even).abs() + (flight.odd - own.odd).abs() < 4.0 * f64::EPSILON * size);
            checked += 1;
        }
    }
    assert_eq!(checked, 24);
}

#[test]
fn a_dashpot_on_a_rigid_mode_leaves_the_poles_zero_and_minus_c() {
    let (c, period) = (0.3f64, 3.0);
    let mut kernel = BlochKernel::new(period, 1);
    kernel.push_decaying(0.5 * c, -0.25 * c * c, &[1.0]);
    let rates = kernel.modes()[0].rates();
    assert!(rates[0].norm() < 1e-16 && (rates[1].re + c).abs() < 1e-16);
    let z = C::new(1.5, 0.2);
    // h = (1 − e^{−ct})/c
    let sum: C = (0..200).map(|n| z.powi(-n) * (1.0 - (-c * (0.4 + period * f64::from(n))).exp()) / c).sum();
    assert!((kernel.jet(0, 0, 0.4, z).kernel[0] - sum).norm() < 1e-14);
}

#[test]
fn poles_of_any_kind_are_the_oscillators_they_come_from() {
    let (frequency, period, z) = (1.1f64, 3.3, C::new(0.4, 0.9));
    let shapes = [0.8, -0.3];
    let mut checked = 0;
    for damping in [0.0, 0.2, 1.7] {
        let mut oscillator = BlochKernel::new(period, 2);
        oscillator.push_oscillator(frequency, damping, &shapes);
        let [one, other] = oscillator.modes()[0].rates();
        let mode = if one.im > 0.0 {
            let root = (one - one.conj()).sqrt();
            let contacts = shapes.map(|shape| C::new(shape, 0.0) / root).to_vec();
            LinearMode::pole(one, &ModeShape { contacts, ..ModeShape::default() }, &[])
        } else {
            let scale = (one.re - other.re).sqrt();
            let scaled = ModeShape { contacts: shapes.map(|shape| shape / scale).to_vec(), ..ModeShape::default() };
            LinearMode::real_poles([one.re, other.re], [1.0, -1.0], [&scaled, &scaled], &[])
        };
        let poles = BlochKernel::of_modes(&[mode], period, &[0, 1]);
        for t in [-1.0, 0.0, 0.5, 3.3] {
            let [a, b] = [&oscillator, &poles].map(|kernel| kernel.jet(1, 0, t, z));
            for (a, b) in a.kernel.iter().zip(b.kernel) {
                assert!((a - b).norm() < 1e-14, "{damping} {t}: {a} {b}");
            }
            checked += 1;
        }
        assert!((poles.mobility(0, 1) - shapes[0] * shapes[1]).abs() < 1e-15);
    }
    assert_eq!(checked, 12);
}

#[test]
fn at_one_it_is_the_periodic_kernel_of_any_lattice() {
    let (mut seed, mut checked, mut merged) = (7, 0, 0);
    for round in 0..120 {
        let mut chain = Chain::new(2 + round % 7, 0.1 + unit(&mut seed), 0.3 * unit(&mut seed)).unwrap();
        chain = chain.with_ends([Ends::Closed, Ends::Free, Ends::Fixed][round % 3]);
        if round % 4 > 1 {
            // Equal couplings: modes of different directions share a frequency.
            chain = chain.with_layers(2 + round % 2, chain.gamma2(), Ends::Free).unwrap();
        }
        let omega = 0.5 + unit(&mut seed);
        let Ok(response) = ImpulseResponse::new(&Spectrum::new(chain), omega) else { continue };
        if response.condition() > 1e3 {
            continue;
        }
        let mut sites: Vec<usize> =
            (0..1 + round % 4).map(|_| (unit(&mut seed) * chain.sites() as f64) as usize).collect();
        sites.sort_unstable();
        sites.dedup();
        let contacts: Vec<Vec<usize>> = sites.iter().map(|site| vec![*site]).collect();
        let structure = Model::conservative(chain, omega, 0.4).unwrap().felt_structure(&contacts).unwrap();
        let hit: Vec<usize> = (0..sites.len()).collect();
        let kernel = structure.participating_modes(&hit).kernel(response.period(), &hit);
        merged += usize::from(kernel.modes().len() < chain.sites());
        for (i, &to) in sites.iter().enumerate() {
            for (j, &from) in sites.iter().enumerate() {
                assert!((kernel.mobility(i, j) - f64::from(u8::from(i == j))).abs() < 1e-14);
                let t = response.period() * (0.02 + 0.96 * unit(&mut seed));
                let plain = response.jet_between(to, from, t - 0.5 * response.period());
                let plain =
                    [plain.value + 1.0 / response.static_stiffness(), plain.slope, plain.curvature, plain.third];
                let jet = kernel.jet(i, j, t, C::new(1.0, 0.0));
                for (found, expected) in jet.kernel.iter().zip(plain) {
                    let scale = response.condition() * (1.0 + 1.0 / response.static_stiffness().abs());
                    assert!((found - expected).norm() < 2e-14 * scale, "{chain} {to} {from}: {found} {expected}");
                }
                checked += 1;
            }
        }
    }
    assert!(checked > 200 && merged > 20, "{checked} {merged}");
}
