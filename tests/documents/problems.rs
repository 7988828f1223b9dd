//! docs/problems.md: its numbers are those of closed forms and simulations that share no code with the library. (That commands print
//! them is for `pages` to see.)

use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::PathBuf;

use vibrochain_breather::{Orbit, OrbitList, Word, admissibility};
use vibrochain_floquet::{Tolerance, stability};
use vibrochain_lattice::{Complex, Stop};
use vibrochain_maps::structure::{Setting, StructureScene};
use vibrochain_maps::sweep::{Ended, sweep};

pub(crate) type C = Complex<f64>;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn scene(name: &str) -> StructureScene {
    StructureScene::read(&root().join("scenes/structures").join(name)).unwrap().unwrap()
}

pub(crate) fn orbits(scene: &StructureScene, word: Option<&str>) -> OrbitList {
    let word: Word = word.map_or_else(|| scene.word.clone().unwrap(), |word| word.parse().unwrap());
    scene.model().unwrap().orbits(&word, scene.force_periods).unwrap()
}

fn radius(orbit: &Orbit) -> f64 {
    stability(orbit, Tolerance::Rounding).unwrap().verdict.spectral_radius
}

fn is_physical(orbit: &Orbit) -> bool {
    admissibility(orbit).unwrap().is_physical()
}

pub(crate) fn physical(found: &OrbitList) -> Vec<&Orbit> {
    found.orbits.iter().filter(|orbit| is_physical(orbit)).collect()
}

#[track_caller]
pub(crate) fn near(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{a} {b}");
}

#[test]
fn every_scene_of_structures_is_on_the_page() {
    let page = fs::read_to_string(root().join("docs/problems.md")).unwrap();
    let mut count = 0;
    for entry in fs::read_dir(root().join("scenes/structures")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let path = root().join("scenes/structures").join(&name);
        // A map of a chain is told of elsewhere.
        let own = StructureScene::read(&path).unwrap();
        let Some(own) = own.filter(|own| own.word.is_some()) else { continue };
        assert!(!physical(&orbits(&own, None)).is_empty(), "{name}");
        assert!(name == "two-masses.toml" || page.contains(&format!("scenes/structures/{name})")), "{name}");
        count += 1;
    }
    assert!(count > 9, "{count}");
}

// Closed forms.

/// m x″ + c x′ + k x = f cos ω(t+ψ), of which a contact sees w x.
#[derive(Clone, Copy)]
pub(crate) struct Oscillator {
    pub(crate) m: f64,
    pub(crate) c: f64,
    pub(crate) k: f64,
    pub(crate) w: f64,
    pub(crate) f: f64,
}

impl Oscillator {
    pub(crate) fn rate(&self) -> C {
        let decay = 0.5 * self.c / self.m;
        C::new(-decay, (self.k / self.m - decay * decay).sqrt())
    }

    /// x and x′ at t after unit impulses that repeat after `lapse`, each `factor` times the one before.
    pub(crate) fn after(&self, t: f64, lapse: f64, factor: f64) -> [f64; 2] {
        let rate = self.rate();
        let all = (rate * t).exp() / (1.0 - (rate * lapse).exp() / factor) / factor;
        [all.im, (rate * all).im].map(|x| x / (rate.im * self.m))
    }

    /// The same just before one of them.
    pub(crate) fn before(&self, lapse: f64, factor: f64) -> [f64; 2] {
        self.after(lapse, lapse, factor)
    }

    pub(crate) fn swing(&self, omega: f64) -> C {
        C::from(self.f) / C::new(self.k - self.m * omega * omega, self.c * omega)
    }
}

/// Both pairs (P, ψ) with G cos x + K P = stop and −ωG sin x + L P = 0 at x = ωψ + arg G.
pub(crate) fn both(swing: C, omega: f64, kernel: f64, law: f64, stop: f64) -> [(f64, f64); 2] {
    let (law, size) = (law / omega, swing.norm());
    let (square, half, rest) = (law * law + kernel * kernel, -stop * kernel, stop * stop - size * size);
    let root = (half * half - square * rest).sqrt();
    [root, -root].map(|root| {
        let impulse = (root - half) / square;
        let x = (law * impulse).atan2(stop - kernel * impulse);
        (impulse, ((x - swing.arg()) / omega).rem_euclid(TAU / omega))
    })
}

/// (P, ψ) of the orbits with one impact a period of oscillators that the contact alone couples.
fn one_impact(oscillators: &[Oscillator], omega: f64, e: f64, stop: f64) -> [(f64, f64); 2] {
    let (mut kernel, mut slope, mut mobility, mut swing) = (0.0, 0.0, 0.0, C::default());
    for one in oscillators {
        let [place, velocity] = one.before(TAU / omega, 1.0);
        kernel += one.w * one.w * place;
        slope += one.w * one.w * velocity;
        mobility += one.w * one.w / one.m;
        swing += one.swing(omega) * one.w;
    }
    // v = −ωG sin x + K′P and P = −(1+e) v/mobility.
    both(swing, omega, kernel, slope + mobility / (1.0 + e), stop)
}

/// The modulus of the larger multiplier of one mass with one impact a period: two free flights and a saltation, by hand.
fn modulus_by_hand(one: Oscillator, omega: f64, e: f64, stop: f64, (impulse, psi): (f64, f64)) -> (f64, f64) {
    let (rate, period) = (one.rate(), TAU / omega);
    let before = -impulse / (one.m * (1.0 + e));
    let acceleration = |v: f64| (one.f * (omega * psi).cos() - one.k * stop - one.c * v) / one.m;
    let corner = (acceleration(-e * before) + e * acceleration(before)) / before;
    let dying = (rate.re * period).exp();
    let (cosine, sine) = ((rate.im * period).cos(), (rate.im * period).sin() / rate.im);
    let trace = -2.0 * e * dying * cosine + corner * dying * sine;
    let determinant = (e * dying).powi(2);
    let root = C::from(0.25 * trace * trace - determinant).sqrt();
    ((C::from(0.5 * trace) + root).norm().max((C::from(0.5 * trace) - root).norm()), trace)
}

#[track_caller]
pub(crate) fn same_orbits(found: &OrbitList, told: [(f64, f64); 2]) {
    assert_eq!(found.orbits.len(), 2);
    let period = found.orbits[0].force_period();
    for (impulse, psi) in told {
        let is_it = |orbit: &&Orbit| (orbit.impacts()[0].impulse - impulse).abs() < 1e-11;
        let orbit = found.orbits.iter().find(is_it).unwrap_or_else(|| panic!("{impulse}: {found:?}"));
        let apart = (orbit.psi().unwrap() - psi).rem_euclid(period);
        assert!(apart.min(period - apart) < 1e-11, "{apart}");
    }
}

const SHAW_HOLMES: Oscillator = Oscillator { m: 1.0, c: 0.1, k: 1.0, w: 1.0, f: 1.0 };

const AT_REST: Oscillator = Oscillator { c: 0.0, ..SHAW_HOLMES };

#[test]
fn one_impact_a_period_has_a_closed_form() {
    let beam = [(3.516015, 2.0, 0.782992), (22.034492, -2.0, 0.433936)];
    let beam = beam.map(|(rate, w, f): (f64, f64, f64)| Oscillator { m: 1.0, c: 0.06 * rate, k: rate * rate, w, f });
    let houses = [(0.1, 1.0, 1.0), (0.2, 4.0, -1.0)].map(|(c, k, w)| Oscillator { m: 1.0, c, k, w, f: -1.0 });
    let cases: [(&str, &[Oscillator], f64, f64, f64); 5] = [
        ("shaw-holmes.toml", &[SHAW_HOLMES], 2.325, 0.8, 0.1),
        ("stop-at-rest.toml", &[AT_REST], 2.6, 0.8, 0.0),
        ("grazing.toml", &[SHAW_HOLMES], 1.0, 0.8, 1.0),
        ("pounding.toml", &houses, 1.8, 0.65, 0.2),
        ("cantilever.toml", &beam, 4.0, 0.7, 0.3),
    ];
    for (name, oscillators, omega, e, stop) in cases {
        let found = orbits(&scene(name), None);
        same_orbits(&found, one_impact(oscillators, omega, e, stop));
        assert_eq!(physical(&found).len(), 1, "{name}");
        if let [one] = oscillators {
            let orbit = physical(&found)[0];
            let at = (orbit.impacts()[0].impulse, orbit.psi().unwrap());
            near(radius(orbit), modulus_by_hand(*one, omega, e, stop, at).0, 1e-11);
        }
    }
}

/// Where the first answer of the closed form doubles its period, between two frequencies.
fn doubling(one: Oscillator, stop: f64, mut low: f64, mut high: f64) -> f64 {
    let condition = |omega: f64| {
        let pushed = one_impact(&[one], omega, 0.8, stop).into_iter().find(|(impulse, _)| *impulse < 0.0).unwrap();
        let determinant = 0.64 * (-one.c * TAU / omega).exp();
        1.0 + determinant + modulus_by_hand(one, omega, 0.8, stop, pushed).1
    };
    assert!(condition(low) * condition(high) < 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if condition(middle) * condition(low) > 0.0 { low = middle } else { high = middle }
    }
    low
}

#[test]
fn the_oscillator_of_shaw_and_holmes_doubles_its_period_where_its_trace_says() {
    let (swept, mut own) = (scene("shaw-holmes.toml"), scene("shaw-holmes.toml"));
    let (pool, mut cells) = (rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap(), Vec::new());
    let ended = sweep(
        &swept,
        &pool,
        &Stop::default(),
        |_| {},
        |_, some| {
            cells.extend_from_slice(some);
            Ok::<(), ()>(())
        },
    );
    assert!(matches!(ended, Ended::Complete(_)));
    let class = |omega: f64| {
        let cell = &cells[((omega - 0.5) / 0.01).round() as usize];
        format!("{} {}", cell.class, cell.word.as_deref().unwrap_or_default())
    };
    for (told, stable, unstable) in [(1.04824, 1.04, 1.05), (1.18169, 1.19, 1.18), (2.45672, 2.45, 2.46)] {
        let exact = doubling(SHAW_HOLMES, 0.1, f64::min(stable, unstable), f64::max(stable, unstable));
        near(exact, told, 3e-6);
        assert_eq!(class(stable), "stable 0+", "{stable}");
        assert_ne!(class(unstable), "stable 0+", "{unstable}");
        for (sign, limit) in [(1.0, true), (-1.0, false)] {
            let inside = exact + sign * 1e-7 * f64::signum(stable - unstable);
            own.set(Setting::Omega, inside).unwrap();
            let found = orbits(&own, None);
            assert_eq!(radius(physical(&found)[0]) < 1.0, limit, "{inside}");
        }
    }
}

/// x″ + x = cos ωt, x ≤ 0, from x = −½ at rest: velocities before the impacts of the last two periods, flights exact.
fn settles(omega: f64, e: f64) -> Vec<f64> {
    let swing = 1.0 / (1.0 - omega * omega);
    let (mut t, mut x, mut v, mut hits) = (0.0, -0.5, 0.0, Vec::new());
    let end = 400.0 * TAU / omega;
    while t < end {
        let (a, b) = (x - swing * f64::cos(omega * t), v + swing * omega * f64::sin(omega * t));
        let at = |s: f64| {
            let (sine, cosine) = s.sin_cos();
            let (load_sine, load_cosine) = (omega * (t + s)).sin_cos();
            (a * cosine + b * sine + swing * load_cosine, b * cosine - a * sine - swing * omega * load_sine)
        };
        let mut s = 1e-6;
        while at(s + 0.01).0 <= 0.0 {
            s += 0.01;
        }
        let (mut low, mut high) = (s, s + 0.01);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if at(middle).0 <= 0.0 { low = middle } else { high = middle }
        }
        let before = at(low).1;
        hits.push((t + low, before));
        (t, x, v) = (t + low, 0.0, -e * before);
    }
    hits.iter().filter(|hit| hit.0 > end - 2.0 * TAU / omega).map(|hit| hit.1).collect()
}

#[test]
fn at_the_rest_position_low_frequencies_have_several_impacts_a_period() {
    let mut own = scene("stop-at-rest.toml");
    for (omega, word, count) in [(0.55, "0+,0+,0+", 3), (0.9, "0+,0+", 2), (0.7, "0+,0+", 2)] {
        own.set(Setting::Omega, omega).unwrap();
        let found = orbits(&own, Some(word));
        let stable: Vec<_> = physical(&found).into_iter().filter(|orbit| radius(orbit) < 1.0).collect();
        assert_eq!(stable.len(), 1, "{omega}: {found:?}");
        let settled = settles(omega, 0.8);
        assert!(settled.len() >= 2 * count - 1, "{settled:?}");
        for orbit in stable {
            for impact in orbit.impacts() {
                let off = settled.iter().map(|v| (v - impact.velocity_before).abs()).fold(f64::MAX, f64::min);
                assert!(off < 1e-9, "{omega}: {} {settled:?}", impact.velocity_before);
            }
        }
    }
    // Next to the rest position nothing else happens.
    own.set(Setting::Omega, 0.9).unwrap();
    own.set(Setting::Upper(0), 1e-7).unwrap();
    let shifted = orbits(&own, Some("0+,0+"));
    assert_eq!(physical(&shifted).len(), 1);
    // An undamped mode whose period fits into that of the impacts has no periodic answer.
    for omega in [0.5, 1.0 / 3.0] {
        own.set(Setting::Omega, omega).unwrap();
        for word in ["0+", "0+,0+", "0+,0+,0+"] {
            let error = own.model().unwrap().orbits(&word.parse().unwrap(), 1).unwrap_err();
            assert!(error.to_string().starts_with("resonance: harmonic"), "{error}");
        }
    }
    let (e, omega) = (0.8_f64, 2.6_f64);
    let psi = PI / omega - ((1.0 - e) * (PI / omega).tan() / (omega * (1.0 + e))).atan() / omega;
    let velocity = 2.0 * omega * (omega * psi).sin() / ((omega * omega - 1.0) * (1.0 - e));
    own = scene("stop-at-rest.toml");
    let found = orbits(&own, None);
    near(physical(&found)[0].psi().unwrap(), psi, 1e-12);
    near(physical(&found)[0].impacts()[0].velocity_before, velocity, 1e-12);
    near(radius(physical(&found)[0]), e, 1e-12);
}

#[test]
fn impacts_begin_at_the_grazing_amplitude() {
    for omega in [1.1_f64, 1.2, 1.5] {
        let amplitude = ((1.0 - omega * omega).powi(2) + 0.01 * omega * omega).sqrt();
        let at = |part: f64| {
            let mut own = scene("grazing.toml");
            own.set(Setting::Omega, omega).unwrap();
            own.set(Setting::Load, amplitude * (1.0 + part)).unwrap();
            orbits(&own, None)
        };
        let (below, above) = (at(-1e-5), at(1e-5));
        let slowest = |found: &OrbitList| {
            let speed = |orbit: &Orbit| orbit.impacts()[0].velocity_before;
            let least = found.orbits.iter().min_by(|a, b| speed(a).abs().total_cmp(&speed(b).abs()));
            (speed(least.unwrap()), radius(least.unwrap()))
        };
        let ((speed, multiplier), (gone, _)) = (slowest(&below), slowest(&above));
        assert!(speed * gone < 0.0 && speed.abs() < 1e-3, "{omega}: {speed} {gone}");
        let rate = SHAW_HOLMES.rate();
        let period = TAU / omega;
        let law = 1.8 * omega * omega * (rate.re * period).exp() * (rate.im * period).sin().abs() / rate.im;
        near(multiplier * speed.abs(), law, 1e-3);
    }
}

#[test]
fn free_balls_obey_the_balance_of_momentum() {
    let found = orbits(&scene("impact-pair.toml"), None);
    let even = found.orbits.iter().find(|orbit| (orbit.impacts()[1].time - PI).abs() < 1e-9).unwrap();
    let psi = 2.0 * (1.0 / TAU).atan();
    near(even.psi().unwrap(), psi, 1e-11);
    near(even.impacts()[0].velocity_before, 2.0 * psi.sin() / 0.4, 1e-11);

    // Seen from a table at rest a bounce ends at the height it has begun at, and is as fast: that leaves the table's own velocity.
    let (e, mut ball) = (0.8_f64, scene("bouncing-ball.toml"));
    let begins = PI * (1.0 - e) / (1.0 + e);
    let doubles = begins.hypot(2.0 * (1.0 + e * e) / (1.0 + e).powi(2));
    let at = |ball: &mut StructureScene, table: f64| {
        ball.set(Setting::Load, table / 0.9).unwrap();
        orbits(ball, None)
    };
    assert!(physical(&at(&mut ball, begins * (1.0 - 1e-9))).is_empty());
    assert_eq!(physical(&at(&mut ball, begins * (1.0 + 1e-9))).len(), 2);
    let radii = |found: &OrbitList| {
        found.orbits.iter().for_each(|orbit| near(orbit.impacts()[0].impulse, TAU, 1e-12));
        let radii = physical(found).into_iter().map(radius);
        radii.fold(f64::INFINITY, f64::min)
    };
    near(radii(&at(&mut ball, doubles)), 1.0, 1e-9);
    near(radii(&at(&mut ball, 0.5 * (begins + doubles))), e, 1e-12);

    let mut gear = scene("gear-rattle.toml");
    let found = orbits(&gear, None);
    assert_eq!(physical(&found).len(), 2);
    found.orbits.iter().for_each(|orbit| near(orbit.impacts()[0].impulse, 0.15 * TAU, 1e-12));
    gear.set(Setting::Load, 1.5).unwrap();
    gear.set(Setting::Static, 0.4).unwrap();
    let found = orbits(&gear, Some("0+,0-"));
    assert_eq!(physical(&found).len(), 2);
    for orbit in physical(&found) {
        near(orbit.impacts().iter().map(|impact| impact.impulse).sum(), 0.06 * TAU, 1e-12);
    }
}

#[test]
fn the_ball_of_an_energy_sink_flies_from_wall_to_wall() {
    let (m, e, gap, half) = (0.1, 0.65, 0.8, PI);
    let cart = Oscillator { m: 1.0, c: 0.05, k: 1.0, w: 1.0, f: 0.1 };
    // The ball is at −uT/4 when it is hit and leaves at u = P/2m, where it came at −u; the cart feels −P, alternating.
    let [place, velocity] = cart.before(half, -1.0);
    let kernel = -0.25 * TAU / (2.0 * m) + place;
    // Before the impact the cart has x′ = u(1−e)/(1+e) + P/(1+e), of which its impulses are −P·`velocity`.
    let speed = ((1.0 - e) / (2.0 * m) + 1.0) / (1.0 + e) + velocity;
    // G cos x = −gap + kernel·P, −ωG sin x = speed·P.
    let told = both(cart.swing(1.0), 1.0, -kernel, -speed, -gap);
    let found = orbits(&scene("energy-sink.toml"), None);
    same_orbits(&found, told);
    near(radius(physical(&found)[0]), 0.8150542047748107, 1e-10);
}

#[test]
fn nonsmooth_modes_of_two_masses_have_golden_frequencies() {
    let root = 5.0_f64.sqrt();
    let mut own = scene("clamped-chain.toml");
    for omega in [0.65, 0.7, 0.9, 1.0, 1.65] {
        let term = |rate: f64, share: f64| share / (2.0 * rate * (PI * rate / omega).tan());
        let kernel = term(0.5 * (root - 1.0), 0.1 * (5.0 + root)) + term(0.5 * (root + 1.0), 0.1 * (5.0 - root));
        own.set(Setting::Omega, omega).unwrap();
        let found = orbits(&own, None);
        assert!(physical(&found).len() == 1 && found.orbits[0].psi().is_none(), "{omega}");
        near(found.orbits[0].impacts()[0].impulse, 1.0 / kernel, 1e-11);
    }
}

#[test]
fn a_heavy_mass_is_an_impurity_of_the_ring() {
    let omega = 1.5;
    let receptance = |s: f64| {
        let ring = |k: u32| 1.0 / (0.2 + 0.2 * (1.0 - (TAU * f64::from(k) / 7.0).cos()) - s);
        let even = (0..7).map(ring).sum::<f64>() / 7.0;
        1.0 / (1.0 / even - 0.3 * s)
    };
    // Sums over even and odd harmonics; what is left of each falls like 1/k⁴.
    let tail = |k: f64| 1.0 / (1.3 * k * k * omega * omega);
    let sum = |first: u32| -> f64 {
        (first..40_000).step_by(2).map(f64::from).map(|k| 2.0 * (receptance((k * omega).powi(2)) + tail(k))).sum()
    };
    let even = receptance(0.0) + sum(2) - 2.0 * tail(1.0) * PI * PI / 24.0;
    let odd = sum(1) - 2.0 * tail(1.0) * PI * PI / 8.0;
    let (mean, half) = (0.3 * TAU / (omega * even), TAU / (omega * odd));
    let found = orbits(&scene("heavy-mass.toml"), None);
    let orbit = physical(&found)[0];
    near(orbit.impacts()[0].impulse, 0.5 * (mean + half), 1e-10);
    near(orbit.impacts()[1].impulse, 0.5 * (mean - half), 1e-10);
}
