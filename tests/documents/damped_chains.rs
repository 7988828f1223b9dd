//! docs/problems.md, its damped chains: closed forms of a self-excited ring and of a breather under dashpots, which share no code with the library.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use nalgebra::{Matrix4, Vector4};
use vibrochain_breather::ContactMotion;
use vibrochain_maps::structure::StructureScene;

use super::problems::{C, Oscillator, both, near, orbits, physical, same_orbits};

fn chain(sites: usize, keys: &str, contact: &str, omega: f64, load: f64, word: &str) -> StructureScene {
    let mut text = format!("omega = {omega}\nword = \"{word}\"\n[structure]\nchain = {{ sites = {sites}, {keys} }}\n");
    text += &format!("[force]\nload = {:?}\n", vec![load; sites]);
    (0..sites).for_each(|site| text += &format!("[[contact]]\nat = {site}\n{contact}\n"));
    StructureScene::of_text(&text, Path::new(".")).unwrap()
}

#[test]
fn a_self_excited_ring_mirrors_itself_every_half_period() {
    let (omega, e) = (1.6, 0.9);
    let keys = "gamma1 = 1.0, gamma2 = 0.1, damping = -0.02, coupling_damping = 0.05";
    let own = chain(5, keys, "lower = -1.0\nupper = 1.0\nrestitution = 0.9", omega, 0.2, "2+,2-");
    let mode = |k: u32| {
        let bend = 2.0 - 2.0 * (TAU * f64::from(k) / 5.0).cos();
        Oscillator { m: 5.0, c: 5.0 * (0.05 * bend - 0.02), k: 5.0 * (1.0 + 0.1 * bend), w: 1.0, f: 0.0 }
    };
    let sums = (0..5).map(|k| mode(k).before(PI / omega, -1.0)).fold([0.0; 2], |s, x| [s[0] + x[0], s[1] + x[1]]);
    let swing = Oscillator { m: 1.0, c: -0.02, k: 1.0, w: 1.0, f: 0.2 }.swing(omega);
    let found = orbits(&own, None);
    same_orbits(&found, both(swing, omega, sums[0], sums[1] + 1.0 / (1.0 + e), 1.0));
    assert_eq!(physical(&found).len(), 2);
}

const BREATHER: &str = "lower = -0.6\nupper = 1.4\nrestitution = 0.9";

fn damped(c: f64, word: &str) -> StructureScene {
    chain(21, &format!("gamma1 = 0.2, gamma2 = 0.1, damping = {c}"), BREATHER, 1.5, 0.1, word)
}

/// How far cos² + sin² of the force's phase are from 1 where the impacts of the breather, φ apart, obey all conditions: least over φ.
fn least_excess(c: f64) -> f64 {
    let (omega, period) = (1.5, TAU / 1.5);
    let mode = |k: u32| {
        let stiffness = 0.2 + 0.2 * (1.0 - (TAU * f64::from(k) / 21.0).cos());
        Oscillator { m: 21.0, c: 21.0 * c, k: 21.0 * stiffness, w: 1.0, f: 0.0 }
    };
    let kernel =
        |t: f64| (0..21).map(|k| mode(k).after(t, period, 1.0)).fold([0.0; 2], |sum, x| [sum[0] + x[0], sum[1] + x[1]]);
    let swing = Oscillator { m: 1.0, c, k: 0.2, w: 1.0, f: 0.1 }.swing(omega);
    let own = kernel(period);
    let excess = |phi: f64| {
        let (forth, back, later) = (kernel(phi), kernel(period - phi), swing * C::from_polar(1.0, omega * phi));
        let law = |kernel: [f64; 2], own: f64| own + 1.9 * kernel[1];
        let turn = C::new(0.0, 1.9 * omega);
        let (first, second) = (swing * turn, later * turn);
        let rows = Matrix4::new(
            own[0],
            back[0],
            swing.re,
            -swing.im,
            forth[0],
            own[0],
            later.re,
            -later.im,
            law(own, 1.0),
            law(back, 0.0),
            first.re,
            -first.im,
            law(forth, 0.0),
            law(own, 1.0),
            second.re,
            -second.im,
        );
        let x = rows.lu().solve(&Vector4::new(-0.6, 1.4, 0.0, 0.0)).unwrap();
        x[2] * x[2] + x[3] * x[3] - 1.0
    };
    // Three grids, each within a step of the last.
    let (mut place, mut step, mut least) = (0.45 * period, period / 4000.0, f64::MAX);
    for _ in 0..3 {
        let all = (0..400).map(|i| place + step * f64::from(i)).map(|phi| (phi, excess(phi)));
        (place, least) = all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        (place, step) = (place - step, step / 200.0);
    }
    least
}

#[test]
fn a_breather_dies_of_damping_where_its_two_solutions_meet() {
    let (mut low, mut high) = (0.01, 0.03);
    assert!(least_excess(low) < 0.0 && least_excess(high) > 0.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if least_excess(middle) < 0.0 { low = middle } else { high = middle }
    }
    near(low, 0.0239521, 1e-7);
    // Solutions that are near to each other are found, whichever impact is the first one.
    for word in ["10-,10+", "10+,10-"] {
        for c in [0.0185, 0.019, 0.0195, 0.02, 0.021, 0.0225, 0.0235, low - 1e-6] {
            let found = orbits(&damped(c, word), None);
            assert_eq!(physical(&found).len(), 2, "{word} {c}");
        }
        assert!(orbits(&damped(low + 1e-6, word), None).orbits.is_empty());
    }
}

/// The breather of 21 masses under dashpots, integrated by the method of Runge and Kutta over a period.
#[test]
fn the_damped_breather_is_one_in_a_simulation() {
    let (own, c) = (damped(0.01, "10-,10+"), 0.01);
    let found = orbits(&own, None);
    assert_eq!(physical(&found).len(), 2);
    for orbit in &found.orbits {
        let motion = ContactMotion::new(orbit.contacts().unwrap()).unwrap();
        let start: Vec<f64> = motion.coordinates(0, 0.0).unwrap().iter().flatten().copied().collect();
        let rates = |t: f64, state: &[f64]| -> Vec<f64> {
            let x = |i: usize| state[2 * (i % 21)];
            let force = 0.1 * (1.5 * (t + orbit.psi().unwrap())).cos();
            (0..21)
                .flat_map(|i| {
                    let springs = 0.2 * x(i) + 0.1 * (2.0 * x(i) - x(i + 1) - x(i + 20));
                    [state[2 * i + 1], force - springs - c * state[2 * i + 1]]
                })
                .collect()
        };
        let add = |state: &[f64], rate: &[f64], h: f64| -> Vec<f64> {
            state.iter().zip(rate).map(|(x, v)| x + h * v).collect()
        };
        let (mut state, steps) = (start.clone(), 800);
        for i in 0..2 {
            let (begins, h) = (orbit.impacts()[i].time, motion.until_next(i) / f64::from(steps));
            for step in 0..steps {
                let t = begins + h * f64::from(step);
                let a = rates(t, &state);
                let b = rates(t + 0.5 * h, &add(&state, &a, 0.5 * h));
                let c = rates(t + 0.5 * h, &add(&state, &b, 0.5 * h));
                let d = rates(t + h, &add(&state, &c, h));
                let mean: Vec<f64> = (0..42).map(|i| (a[i] + 2.0 * (b[i] + c[i]) + d[i]) / 6.0).collect();
                state = add(&state, &mean, h);
                assert!((0..21).all(|i| (-0.6 - 1e-9..1.4 + 1e-9).contains(&state[2 * i])));
            }
            let next = orbit.impacts()[(i + 1) % 2];
            near(state[20], if i == 0 { 1.4 } else { -0.6 }, 1e-10);
            near(state[21], next.velocity_before, 1e-10);
            near(-1.9 * state[21], next.impulse, 1e-10);
            state[21] *= -0.9;
        }
        state.iter().zip(&start).for_each(|(ends, began)| near(*ends, *began, 1e-10));
    }
}
