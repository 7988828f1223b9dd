//! Orbits and multipliers of structures in many digits: against dense matrices of `f64`, closed forms of one oscillator, values known from
//! elsewhere, and what must hold of every orbit.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::{Complex as C, DMatrix, DVector};
use vibrochain_breather::{Hit, LoadedStructure};
use vibrochain_lattice::{Barrier, Contact, Structure};
use vibrochain_testkit::{Random, Structure as Dense, structures};
use vibrochain_truth::{Complex, Real, StructureStart, TrueStructureOrbit, TruthError};

const BITS: usize = 128;

fn diagonal(entries: &[f64]) -> DMatrix<f64> {
    DMatrix::from_diagonal(&DVector::from_row_slice(entries))
}

/// Contacts, one for each stop, that are hit by an orbit of `f64`.
fn of_table(dense: &Dense) -> (Structure, Vec<Hit>) {
    let side = |impact: &vibrochain_testkit::StructureImpact| {
        let upper = dense.limits[impact.contact].1 == Some(impact.stop);
        if upper { Barrier::Upper } else { Barrier::Lower }
    };
    let hit = |impact: &vibrochain_testkit::StructureImpact| {
        Hit::new(impact.contact, side(impact), impact.time, impact.impulse)
    };
    (dense.linear(), dense.impacts.iter().map(hit).collect())
}

fn near(structure: &Structure, dense: &Dense, hits: &[Hit]) -> TrueStructureOrbit {
    let force_periods = (dense.period * dense.omega / std::f64::consts::TAU).round() as u32;
    let start = StructureStart { structure, omega: dense.omega, force_periods, psi: dense.psi, impacts: hits };
    TrueStructureOrbit::near(&start, BITS).unwrap()
}

/// Impulses, times, velocities, accelerations and multipliers of every structure of the table, to the digits of the dense matrices.
#[test]
fn orbits_of_the_table_and_their_multipliers() {
    let (mut orbits, mut multipliers) = (0, 0);
    for dense in structures() {
        let (structure, hits) = of_table(&dense);
        let truth = near(&structure, &dense, &hits);
        assert!(
            truth.last_step_log2() < -(BITS as f64) && truth.residual().log2_abs() < -(BITS as f64),
            "{}",
            dense.name
        );
        for ((found, told), before) in truth.impacts().iter().zip(&dense.impacts).zip(dense.before()) {
            let close = |found: &Real, told: f64, room: f64| {
                assert!((found - told).abs().to_f64() < room * (1.0 + told.abs()), "{} {found} {told}", dense.name);
            };
            close(&found.impulse, told.impulse, 1e-10);
            close(&found.time, told.time, 1e-10);
            close(&found.velocity_before, before.velocity, 1e-9);
            close(&found.acceleration_before, before.acceleration, 1e-8);
        }
        for told in dense.multipliers.iter().filter(|told| told.norm() > 1e-3) {
            let (found, moved) = truth.multiplier((told.re, told.im)).unwrap();
            // Dense solvers split a double multiplier by the root of rounding.
            let room = if (told - 1.0).norm() < 1e-3 { 1e-6 } else { 1e-9 };
            assert!(moved < room * (1.0 + told.norm()), "{}: {told} {found:?}", dense.name);
            multipliers += 1;
        }
        let radius = dense.multipliers.iter().map(|told| told.norm()).fold(0.0, f64::max);
        assert!((truth.spectral_radius() - radius).abs() < 1e-6 * (1.0 + radius), "{}", dense.name);
        orbits += 1;
    }
    assert!(orbits == 24 && multipliers > 100, "{orbits} {multipliers}");
}

/// Π μ = Π e² e^{−tr(M⁻¹C)T}, and the radius is that of the multiplier it belongs to, to all digits.
#[test]
fn the_product_of_multipliers_is_what_impacts_and_dashpots_leave() {
    let mut random = Random(83);
    let mut refined = 0;
    for _ in 0..12 {
        let mut dense = random.structure();
        // Each impact has its own stop.
        let contacts = dense.impacts.iter().map(|impact| dense.contacts[impact.contact].clone());
        dense.contacts = contacts.collect();
        for (i, impact) in dense.impacts.iter_mut().enumerate() {
            impact.contact = i;
        }
        dense.limits = dense.impacts.iter().map(|impact| (None, Some(impact.stop), impact.restitution)).collect();
        let (structure, hits) = of_table(&dense);
        let truth = near(&structure, &dense, &hits);
        let largest = dense.impacts.iter().map(|impact| impact.impulse.abs()).fold(0.0, f64::max);
        for (found, told) in truth.impacts().iter().zip(&dense.impacts) {
            assert!((&found.impulse - told.impulse).abs() < 1e-9 * largest, "{found:?} {told:?}");
        }
        let at_zero = truth.characteristic(&Complex::new(0.0, 0.0, 64)).re;
        let losses: f64 = dense.impacts.iter().map(|impact| impact.restitution.powi(2)).product();
        let trace = (dense.mass.clone().try_inverse().unwrap() * &dense.damping).trace();
        let expected = losses.ln() - trace * dense.period;
        let found = at_zero.log2_abs() * std::f64::consts::LN_2;
        assert!((found - expected).abs() < 1e-12 * (1.0 + expected.abs()), "{found} {expected}");
        let all = dense.monodromy().complex_eigenvalues();
        let leading = all.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap();
        let (leading, _) = truth.multiplier((leading.re, leading.im)).unwrap();
        let apart = (leading.abs() / truth.spectral_radius() - 1.0).log2_abs();
        assert!(apart < -100.0, "{apart}");
        refined += 1;
    }
    assert_eq!(refined, 12);
}

/// q″ + c q′ + q = A cos ω(t+ψ), a stop above.
struct Oscillator {
    damping: f64,
    omega: f64,
    load: f64,
    stop: f64,
    restitution: f64,
}

impl Oscillator {
    fn structure(&self) -> Structure {
        let contact = Contact { lower: None, upper: Some(self.stop), restitution: self.restitution };
        Structure {
            mass: diagonal(&[1.0]),
            damping: diagonal(&[self.damping]),
            stiffness: diagonal(&[1.0]),
            contacts: vec![(DVector::from_element(1, 1.0), contact)],
            loads: vec![(1, DVector::from_element(1, C::new(self.load, 0.0)))],
            ..Structure::default()
        }
    }

    fn period(&self) -> f64 {
        std::f64::consts::TAU / self.omega
    }

    /// 1 − c²/4
    fn square(&self) -> f64 {
        1.0 - 0.25 * self.damping * self.damping
    }

    /// K and K′ at T, by e^{λt} of complex rates; those of critical damping by their own limit.
    fn kernel(&self) -> [f64; 2] {
        let (decay, square, period) = (0.5 * self.damping, self.square(), self.period());
        if square.abs() < 1e-8 {
            let left = (-decay * period).exp();
            let once = 1.0 - left;
            // Σ (nT) qⁿ and its derivative.
            return [period * left / (once * once), left / once - decay * period * left / (once * once)];
        }
        let root = C::new(square, 0.0).sqrt();
        let sum = |rate: C<f64>| ((rate * period).exp()) / (C::new(1.0, 0.0) - (rate * period).exp());
        let [one, other] = [root, -root].map(|root| C::new(-decay, 0.0) + C::<f64>::i() * root);
        let both: [C<f64>; 2] = [sum(one), sum(other)];
        let over: C<f64> = C::new(0.0, 2.0) * root;
        [((both[0] - both[1]) / over).re, ((one * both[0] - other * both[1]) / over).re]
    }

    /// Impulse and ψ of both orbits of one impact.
    fn by_hand(&self) -> [(f64, f64); 2] {
        let ([place, slope], omega, loss) = (self.kernel(), self.omega, 1.0 + self.restitution);
        let (size, angle) = (C::new(self.load, 0.0) / C::new(1.0 - omega * omega, omega * self.damping)).to_polar();
        let ratio = omega * size * loss / (1.0 + loss * slope);
        // size cos x + place ratio sin x = stop.
        let (along, turn) = (size.hypot(place * ratio), (place * ratio).atan2(size));
        let open = (self.stop / along).acos();
        [turn + open, turn - open].map(|x| (ratio * x.sin(), (x - angle) / omega))
    }

    fn truth(&self, (impulse, psi): (f64, f64)) -> TrueStructureOrbit {
        let (structure, impacts) = (self.structure(), [Hit::new(0, Barrier::Upper, 0.0, impulse)]);
        let start =
            StructureStart { structure: &structure, omega: self.omega, force_periods: 1, psi, impacts: &impacts };
        TrueStructureOrbit::near(&start, BITS).unwrap()
    }
}

/// All orbits of one impact, with c below, at and above critical damping.
#[test]
fn one_oscillator_by_hand() {
    for (damping, omega) in [(0.0, 2.3), (0.1, 2.325), (2.0, 0.8), (2.0 + 1e-9, 0.8), (7.0, 0.5)] {
        let oscillator = Oscillator { damping, omega, load: 1.0, stop: 0.1, restitution: 0.8 };
        for (impulse, psi) in oscillator.by_hand() {
            let truth = oscillator.truth((impulse, psi));
            let found = &truth.impacts()[0];
            let off = (&found.impulse - impulse).abs().to_f64();
            let square = oscillator.square();
            let room = if square.abs() < 1e-8 && square != 0.0 { 1e-7 } else { 1e-12 };
            assert!(off < room * impulse.abs(), "{damping} {impulse} {found:?}");
            assert!((truth.psi().unwrap() - psi).abs() < room * oscillator.period());
        }
    }
}

/// A load 9e-12 below grazing: of two orbits one hits with 1e-11, the other with .7.
#[test]
fn both_orbits_next_to_grazing() {
    let oscillator = Oscillator { damping: 0.1, omega: 1.2, load: 0.45607017003550, stop: 1.0, restitution: 0.8 };
    let [one, other] = oscillator.by_hand().map(|start| oscillator.truth(start).impacts()[0].impulse.clone());
    let (soft, hard) = if one.abs() < other.abs() { (one, other) } else { (other, one) };
    assert!((&soft / -1.13080763005242e-11 - 1.0).abs() < 1e-13, "{soft}");
    assert!(hard < -0.1);
}

/// q″ + c q′ + q = 0 with c < 0 and one stop: T is found, where 1 + (1+e) K′(T) = 0 (20 digits, for a c that no f64 is).
#[test]
fn a_self_excited_oscillator_finds_its_period() {
    let contact = Contact { lower: Some(-1.0), upper: None, restitution: 0.5 };
    let structure = Structure {
        mass: diagonal(&[1.0]),
        damping: diagonal(&[-0.2]),
        stiffness: diagonal(&[1.0]),
        contacts: vec![(DVector::from_element(1, 1.0), contact)],
        ..Structure::default()
    };
    let impacts = [Hit::new(0, Barrier::Lower, 0.0, 3.6)];
    let omega = std::f64::consts::TAU / 4.2;
    let start = StructureStart { structure: &structure, omega, force_periods: 1, psi: 0.0, impacts: &impacts };
    let truth = TrueStructureOrbit::near(&start, BITS).unwrap();
    let known = |text: &str| Real::parse(text, 256).unwrap();
    assert!((truth.period() - known("4.231628856140046057")).log10_abs() < -15.5);
    assert!((&truth.impacts()[0].impulse - known("3.568534193789094704")).log10_abs() < -15.5);
    assert!(truth.psi().is_none());
    // Along the cycle 1, and by Liouville the other: e² e^{−cT}.
    let other = 0.25 * (0.2_f64 * truth.period().to_f64()).exp();
    let (found, _) = truth.multiplier((other, 0.0)).unwrap();
    assert!((found.re - other).abs() < 1e-14 && truth.spectral_radius().to_f64() == 1.0);
}

/// Without losses the trivial multiplier is double and defective: the radius is 1 all the same, to half the digits.
#[test]
fn a_defective_multiplier_keeps_half_the_digits() {
    let dense = structures().into_iter().find(|dense| dense.name.contains("w = 0.4")).unwrap();
    let (structure, hits) = of_table(&dense);
    let truth = near(&structure, &dense, &hits);
    let (trivial, moved) = truth.multiplier((1.0, 1e-9)).unwrap();
    assert!((trivial.abs() - 1.0).log2_abs() < -60.0 && moved < 1e-8, "{trivial:?}");
    let radius = dense.multipliers[0].norm();
    assert!((truth.spectral_radius() - radius).abs() < 1e-6);
}

/// The orbits that the program finds, refined.
fn refined(structure: &Structure, omega: f64, word: &str, force_periods: u32) -> Vec<TrueStructureOrbit> {
    let model = LoadedStructure::new(Arc::new(structure.modal().unwrap()), omega).unwrap();
    let orbits = model.orbits(&word.parse().unwrap(), force_periods).unwrap().orbits;
    orbits.iter().filter_map(|orbit| TrueStructureOrbit::refine(structure, orbit, BITS).ok()).collect()
}

fn square(n: usize, entries: &[f64]) -> DMatrix<f64> {
    DMatrix::from_row_slice(n, n, entries)
}

fn polar(sizes: &[f64], phases: &[f64]) -> Vec<(u32, DVector<C<f64>>)> {
    let load = sizes.iter().zip(phases).map(|(size, phase)| C::from_polar(*size, *phase));
    vec![(1, DVector::from_iterator(sizes.len(), load))]
}

fn unit(n: usize, at: usize) -> DVector<f64> {
    DVector::from_fn(n, |i, _| f64::from(u8::from(i == at)))
}

/// A mass of 1e-6 beside one of 0.83, three impacts in two periods of the load.
#[test]
fn a_nearly_massless_coordinate() {
    let structure = Structure {
        mass: square(2, &[0.8321261042548943, 0.0, 0.0, 1.0207179965074112e-06]),
        damping: square(2, &[0.0019192542466609707, 0.0012563601665956737, 0.0012563601665956737, 0.00565162585570932]),
        stiffness: square(2, &[0.15077203872810108, 0.17664671411875127, 0.17664671411875127, 0.986281286800948]),
        contacts: vec![
            (
                unit(2, 0),
                Contact {
                    lower: Some(-0.649040490613557),
                    upper: Some(0.2753112024200735),
                    restitution: 0.16202134304064453,
                },
            ),
            (unit(2, 1), Contact { lower: None, upper: Some(0.37764722132939804), restitution: 0.33828137733638153 }),
        ],
        loads: polar(&[1.7124338212490717, 1.1730233649986392], &[1.8510029711260978, -1.1434885841752636]),
        ..Structure::default()
    };
    let orbits = refined(&structure, 1.1309569481324517, "0+,1+,1+", 2);
    let hits = |orbit: &&TrueStructureOrbit| {
        orbit.impacts().iter().any(|impact| (&impact.impulse + 2.25925482891254).log10_abs() < -13.9)
    };
    let radius = orbits.iter().find(hits).unwrap().spectral_radius();
    assert!((&radius - 2.15440327127944).log10_abs() < -13.9, "{radius}");
}

/// Plastic impacts, and multipliers of which the program loses digits.
#[test]
fn a_radius_that_is_hard_to_know() {
    let structure = Structure {
        mass: square(
            3,
            &[
                0.7747588184686635,
                -0.08410625672023866,
                0.0062566479465599985,
                -0.08410625672023866,
                0.8253997992242467,
                -0.0008809744252752322,
                0.0062566479465599985,
                -0.0008809744252752322,
                0.7550416995885734,
            ],
        ),
        damping: square(
            3,
            &[
                0.003574147433097176,
                -0.0006621452822194712,
                -0.0001771673363534755,
                -0.0006621452822194712,
                0.00218927981725917,
                0.0004083494541556509,
                -0.0001771673363534755,
                0.0004083494541556509,
                0.003930658116018306,
            ],
        ),
        stiffness: square(
            3,
            &[
                7.571441126909749,
                1.4038426970960698,
                -0.6796936253509221,
                1.4038426970960698,
                2.8840042825456704,
                1.9543987813923267,
                -0.6796936253509221,
                1.9543987813923267,
                7.064006303021482,
            ],
        ),
        contacts: vec![(
            unit(3, 0),
            Contact { lower: Some(-0.9223257450023643), upper: Some(0.9223257450023643), restitution: 0.0 },
        )],
        loads: polar(&[2.314663847605748, 0.21996369592277187, 1.265618585808401], &[PI, 0.0, PI]),
        ..Structure::default()
    };
    let orbits = refined(&structure, 3.3029490543811995, "0-,0+", 1);
    let radii: Vec<Real> = orbits.iter().map(TrueStructureOrbit::spectral_radius).collect();
    assert!(radii.iter().any(|radius| (radius - 1.22241981490624).log10_abs() < -13.9), "{radii:?}");
}

/// Next to a resonance, without dashpots.
#[test]
fn a_radius_next_to_a_resonance() {
    let structure = Structure {
        mass: square(2, &[1.0, 0.0, 0.0, 1.0]),
        damping: DMatrix::default(),
        stiffness: square(2, &[1.1384454988354615, -0.830214191649277, -0.830214191649277, 1.7327395107432353]),
        contacts: vec![(
            unit(2, 0),
            Contact { lower: Some(-0.4889533869797575), upper: Some(0.24665042088663186), restitution: 0.9 },
        )],
        loads: polar(&[0.8960306252879023, 0.0], &[0.0, 0.0]),
        ..Structure::default()
    };
    let orbits = refined(&structure, 1.5222943904181907, "0+,0-", 1);
    let radii: Vec<Real> = orbits.iter().map(TrueStructureOrbit::spectral_radius).collect();
    assert!(radii.iter().any(|radius| (radius - 0.948728124754387).log10_abs() < -14.0), "{radii:?}");
}

/// 1e-8 from a resonance and less, where an orbit of two impacts is regular: its values go through.
#[test]
fn an_orbit_goes_through_a_resonance() {
    let contact = Contact { lower: Some(-0.6), upper: Some(0.5), restitution: 0.8 };
    let structure = Structure {
        mass: diagonal(&[1.0]),
        stiffness: diagonal(&[1.0]),
        contacts: vec![(DVector::from_element(1, 1.0), contact)],
        loads: vec![(1, DVector::from_element(1, C::new(0.6, 0.0)))],
        ..Structure::default()
    };
    let impacts = [Hit::new(0, Barrier::Upper, 0.0, -1.1182), Hit::new(0, Barrier::Lower, 4.5055, 1.3051)];
    let at = |omega: f64, psi: f64| {
        let start = StructureStart { structure: &structure, omega, force_periods: 1, psi, impacts: &impacts };
        TrueStructureOrbit::near(&start, BITS)
    };
    // The phase is not told with the case: whichever start leads there.
    let is_it = |truth: &TrueStructureOrbit| (&truth.impacts()[0].impulse + 1.11819450767043).abs() < 1e-9;
    let starts = (0..64).map(|i| f64::from(i) * std::f64::consts::TAU / 64.0);
    let truth = starts.filter_map(|psi| at(1.00000001, psi).ok()).find(is_it).unwrap();
    assert!((&truth.impacts()[0].impulse + 1.11819450767043).log10_abs() < -13.9);
    assert!((&truth.impacts()[1].impulse - 1.30505485383886).log10_abs() < -13.9);
    assert!((&truth.impacts()[1].time - 4.50549976981305).log10_abs() < -13.9);
    assert!((truth.spectral_radius() - 0.64).log10_abs() < -7.0);
    let psi = truth.psi().unwrap().to_f64();
    for omega in [1.0 - 1e-8, 1.0 - 1e-12, 1.0, 1.0 + 1e-12] {
        let other = at(omega, psi).unwrap();
        let off = (&other.impacts()[0].impulse - &truth.impacts()[0].impulse).abs().to_f64();
        assert!(off < 1e-6, "{omega} {off:e}");
    }
}

#[test]
fn impacts_that_are_none_are_refused() {
    let dense = structures().into_iter().next().unwrap();
    let (structure, hits) = of_table(&dense);
    let with = |impacts: &[Hit]| {
        let start = StructureStart { structure: &structure, omega: dense.omega, force_periods: 1, psi: 0.0, impacts };
        TrueStructureOrbit::near(&start, BITS).unwrap_err()
    };
    assert!(matches!(with(&[]), TruthError::Mismatch { .. }));
    assert!(matches!(with(&[Hit { site: 9, ..hits[0] }]), TruthError::Mismatch { .. }));
    assert!(matches!(with(&[Hit { barrier: Barrier::Lower, ..hits[0] }]), TruthError::Mismatch { .. }));
}
