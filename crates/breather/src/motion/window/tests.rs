use vibrochain_lattice::{Barrier, Chain, Ends, Force, Harmonic};

use super::*;
use crate::orbit::{Hit, Orbit};

/// A ring in halves and whole, and a row between walls, all in waves: through blocks and from the modes.
#[test]
fn blocks_of_masses_know_their_neighbours() {
    let ring = Chain::new(2 * BLOCK + 77, 0.2, 0.1).unwrap();
    let row = ring.with_ends(Ends::Fixed);
    let lattices = [(ring, 0, Some(0)), (ring, 3, None), (row, BLOCK + 5, None)];
    let dashpots = [[0.0; 2], [0.01, 0.04]];
    for ((chain, site, mirror), [damping, between]) in lattices.into_iter().flat_map(|of| dashpots.map(|by| (of, by))) {
        let point = Model::conservative(chain, 0.6, 0.4).unwrap().point();
        let model = point.damping(damping).coupling_damping(between).model().unwrap();
        let orbit = Orbit::from_impulses(&model, 1, 0.0, &[Hit::new(site, Barrier::Lower, 0.0, 1.0)]).unwrap();
        let mut motion = Motion::of(&orbit).unwrap();
        let (mut watched, mut window) = (DistinctMasses::default(), Window::default());
        watched.reset(&chain, mirror);
        window.set_rate(motion.top_frequency());
        window.set(&watched, &mut motion, 0, 0.3);
        let blocks: Vec<_> = window.blocks(&watched).collect();
        assert_eq!(blocks.len(), if mirror.is_some() { 2 } else { 3 });
        for block in blocks {
            window.expand(&watched, &model, &[0.0; ORDER - 2], block);
            window.enclose(1.0);
        }
        motion.seek(0, 0.3 + window.unit());
        let (all, mut least) = (motion.all_sites(), f64::INFINITY);
        for (i, &site) in watched.sites().iter().enumerate() {
            let off = [
                window.ends[0].as_flattened()[i] - all[site].re,
                window.ends[1].as_flattened()[i] / window.unit() - all[site].im,
            ];
            assert!(off.iter().all(|off| off.abs() < 1e-13), "{chain} {mirror:?} {i}: {off:?}");
            least = least.min(all[site].norm());
        }
        // Dashpots let nothing come so far.
        assert!(least > 1e-6 || model.is_damped(), "{chain} {mirror:?}: a mass stands still, {least:e}");
    }
}

#[test]
fn derivatives_and_bounds_of_a_sine() {
    let mut coefficients = [0.0; ORDER];
    let mut factorial = 1.0;
    for (k, c) in coefficients.iter_mut().enumerate() {
        factorial *= k.max(1) as f64;
        *c = [0.0, 1.0, 0.0, -1.0][k % 4] / factorial;
    }
    let sine = Polynomial { coefficients };
    for s in [0.0, 0.3, 1.0_f64] {
        let [value, slope, curvature] = sine.jet(s);
        assert!((value - s.sin()).abs() < 1e-15 && (slope - s.cos()).abs() < 1e-15);
        assert!((curvature + s.sin()).abs() < 1e-14);
        assert_eq!(sine.evaluate(s), (value, slope));
    }
    assert!(sine.third_bound(1.0) >= 1.0 && sine.third_bound(1.0) <= 1.6);
    let mut window = Window { masses: 1, block: 0..1, stride: 6, unit: 1.0, ..Window::default() };
    window.ends = [vec![[0.0; LANES]], vec![[0.0; LANES]]];
    window.coefficients = coefficients.iter().flat_map(|c| [0.0, *c, 0.0, 0.0, 0.0, 0.0]).collect();
    for list in [&mut window.lows, &mut window.highs, &mut window.values, &mut window.slopes] {
        list.resize(1, [0.0; LANES]);
    }
    window.enclose(1.0);
    let (low, high) = window.range(0);
    assert!(low <= 0.0 && high >= 1f64.sin() && high <= 1.01);
    assert_eq!(window.final_displacement(0), sine.evaluate(1.0).0);
}

/// Under a force of three harmonics, on a ring, between walls and in layers: at the end of each window of a flight masses are where their
/// modes are, within a window they stay in its range and on its polynomials.
#[test]
fn windows_follow_forced_motions_of_any_lattice() {
    let harmonic = |number: u32, amplitude: f64| Harmonic { number, amplitude, phase: 0.4 * f64::from(number) };
    let force = Force::new(&[harmonic(1, 0.4), harmonic(3, -0.3), harmonic(5, 0.2)]).unwrap();
    let ring = Chain::new(7, 0.2, 0.1).unwrap();
    let torus = Chain::new(5, 0.2, 0.1).unwrap().with_layers(4, 0.07, Ends::Closed).unwrap();
    let sheet = Chain::new(4, 0.2, 0.1).unwrap().with_ends(Ends::Fixed).with_layers(3, 0.07, Ends::Free).unwrap();
    let lattices = [ring, ring.with_ends(Ends::Fixed), ring.with_ends(Ends::Free), torus, sheet];
    // Without dashpots, with few, and overdamped.
    let dashpots = [[0.0; 2], [0.02, 0.0], [0.03, 0.05], [1.1, 0.2]];
    for (chain, dashpots) in lattices.into_iter().flat_map(|chain| dashpots.map(|dashpots| (chain, dashpots))) {
        let point = Model::conservative(chain, 0.31, 0.4).unwrap().point().under(&force);
        let model = point.damping(dashpots[0]).coupling_damping(dashpots[1]).model().unwrap();
        let orbit = Orbit::from_impulses(&model, 1, 0.9, &[Hit::new(1, Barrier::Lower, 0.0, 1.0)]).unwrap();
        let mut motion = Motion::of(&orbit).unwrap();
        let (mut watched, mut window) = (DistinctMasses::default(), Window::default());
        watched.reset(&chain, None);
        window.set_rate(motion.top_frequency().max(model.force_wave().top_rate()));
        window.set(&watched, &mut motion, 0, 0.0);
        let windows = (0.9 * orbit.period() / (0.8 * window.unit())) as usize;
        for w in 0..windows {
            let step = 0.8 * window.unit();
            let elapsed = w as f64 * step;
            if w > 0 {
                window.advance(&watched, &mut motion, 0, elapsed);
            }
            let pushes = window.pushes(&model.force_wave(), motion.force_time(0, elapsed));
            for block in window.blocks(&watched) {
                window.expand(&watched, &model, &pushes, block);
                window.enclose(0.8);
            }
            for (i, &site) in watched.sites().iter().enumerate() {
                let (low, high) = window.range(i);
                for part in [0.0, 0.3, 0.7, 1.0] {
                    motion.seek(0, elapsed + part * step);
                    let now = motion.site(site);
                    let [place, speed, curve] = window.polynomial(i).jet(0.8 * part);
                    let (unit, room) = (window.unit(), 1e-13);
                    assert!((place - now.displacement).abs() < room, "{chain} {w} {site}: {place} {now:?}");
                    assert!((speed / unit - now.velocity).abs() < 10.0 * room, "{chain} {w} {site}: {speed} {now:?}");
                    assert!((curve / (unit * unit) - now.acceleration).abs() < 1e-10, "{chain} {w} {site} {now:?}");
                    assert!(low - room < now.displacement && now.displacement < high + room, "{chain} {w} {site}");
                }
                assert!((window.final_displacement(i) - motion.site(site).displacement).abs() < 1e-13);
            }
        }
        assert!(windows > REFRESH / 4, "{chain}: {windows}");
    }
}
