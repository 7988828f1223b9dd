//! Where stripes begin and end: at their edges a sum of two frequencies of opposite signature is a harmonic.

use vibrochain_breather::Family;
use vibrochain_floquet::Complex;

use super::krein::{Krein, excess};
use super::signatures::{Bench, dense};

/// The two multipliers in the upper half plane that are closest to each other, the trivial pair aside.
fn closest(values: &[Krein]) -> (Krein, Krein) {
    let upper: Vec<Krein> = values.iter().copied().filter(|(z, _)| z.im > 1e-9 && (z - 1.0).norm() > 1e-4).collect();
    let mut best = (f64::INFINITY, (upper[0], upper[0]));
    for (i, a) in upper.iter().enumerate() {
        for b in &upper[..i] {
            let distance = (a.0 - b.0).norm();
            if distance < best.0 {
                best = (distance, (*a, *b));
            }
        }
    }
    best.1
}

/// Edges of stripes along ω: on the stable side the pair about to collide has opposite forms, and sums to a harmonic.
#[test]
fn at_the_edge_of_a_stripe_a_sum_of_two_dressed_modes_of_opposite_signature_is_a_harmonic() {
    let mut bench = Bench::new();
    for (family, sites, from, to) in [
        (Family::DoubleSided, 6, 1.2, 1.9),
        (Family::DoubleSided, 11, 1.0, 1.9),
        (Family::DoubleSided, 16, 1.2, 1.9),
        (Family::SingleSided, 11, 0.9, 1.5),
        (Family::SingleSided, 15, 0.9, 1.5),
    ] {
        let (mut edges, mut sums) = (0, 0);
        let mut at = |omega: f64| {
            let orbit = bench.orbit(family, sites, 0.12, omega, 0.4)?;
            let values = dense(&orbit);
            let (leading, _) = *values.iter().max_by(|a, b| a.0.norm().total_cmp(&b.0.norm())).unwrap();
            Some((excess(&values) > 1e-4, leading, values))
        };
        let mut named = Vec::new();
        let steps = 700;
        for i in 0..steps {
            let value = |i: usize| from + (to - from) * i as f64 / steps as f64;
            let (mut stable, mut unstable) = (value(i), value(i + 1));
            let (Some(a), Some(b)) = (at(stable), at(unstable)) else { continue };
            if a.0 == b.0 {
                continue;
            }
            if a.0 {
                (stable, unstable) = (unstable, stable);
            }
            for _ in 0..20 {
                let middle = 0.5 * (stable + unstable);
                let Some((is, _, _)) = at(middle) else { break };
                *(if is { &mut unstable } else { &mut stable }) = middle;
            }
            let (_, leading, _) = at(unstable).unwrap();
            if leading.im.abs() < 1e-3 {
                continue;
            }
            // A little farther back the forms are beyond rounding.
            let (_, _, values) = at(stable + (stable - unstable).signum() * 1e-5).unwrap();
            let ((p, form_p), (q, form_q)) = closest(&values);
            if (p - leading).norm() > 0.05 && (p.conj() - leading).norm() > 0.05 {
                continue;
            }
            assert!(form_p * form_q < 0.0, "{family:?} {sites} {stable}: {p} {form_p}, {q} {form_q}");
            edges += 1;
            named.push((stable, leading));
        }
        for (omega, leading) in named {
            let orbit = bench.orbit(family, sites, 0.12, omega, 0.4).unwrap();
            let Some(collision) = bench.modes.collision(leading) else { continue };
            let (k, l) = collision.modes;
            assert!(k < l && collision.harmonic >= 1);
            sums += usize::from(collision.detuning.is_some_and(|d| d.abs() < 0.03 * omega));
            // Differences are within the band, which is narrower than ω: no harmonic is near.
            let frequencies = bench.response(&orbit).frequencies();
            assert!(frequencies[frequencies.len() - 1] - frequencies[0] < 0.8 * omega);
        }
        assert!(edges >= 4 && sums == edges, "{family:?} {sites}: {sums} of {edges}");
    }
}

/// Short rings, single-sided, a harmonic of ω in the band: the stripes are of a mode and the internal mode.
#[test]
fn at_the_edge_of_a_stripe_a_mode_and_the_breathers_own_of_opposite_signature_sum_to_a_harmonic() {
    let mut bench = Bench::new();
    let mut edges = 0;
    for (sites, g2, from, to, pair) in [
        (6, 0.2, 0.655, 0.7, (2, 3)),
        (6, 0.25, 0.685, 0.74, (2, 3)),
        (6, 0.28, 0.73, 0.765, (2, 3)),
        (11, 0.25, 0.715, 0.74, (4, 5)),
    ] {
        let at = |bench: &mut Bench, omega: f64| {
            let values = dense(&bench.orbit(Family::SingleSided, sites, g2, omega, 0.4).unwrap());
            let (leading, _) = *values.iter().max_by(|a, b| a.0.norm().total_cmp(&b.0.norm())).unwrap();
            (excess(&values) > 1e-4 && leading.im.abs() > 1e-3, leading, values)
        };
        let steps = 200;
        let value = |i: usize| from + (to - from) * i as f64 / steps as f64;
        for i in 0..steps {
            let (mut stable, mut unstable) = (value(i), value(i + 1));
            let (a, b) = (at(&mut bench, stable), at(&mut bench, unstable));
            if a.0 == b.0 || excess(&a.2).min(excess(&b.2)) > 1e-4 {
                continue;
            }
            if a.0 {
                (stable, unstable) = (unstable, stable);
            }
            for _ in 0..20 {
                let middle = 0.5 * (stable + unstable);
                *(if at(&mut bench, middle).0 { &mut unstable } else { &mut stable }) = middle;
            }
            let (_, _, values) = at(&mut bench, stable + (stable - unstable).signum() * 1e-5);
            let ((p, form_p), (q, form_q)) = closest(&values);
            assert!(form_p * form_q < 0.0, "{sites} {stable}: {p} {form_p}, {q} {form_q}");
            let (_, leading, _) = at(&mut bench, unstable);
            let collision = bench.modes.collision(leading).unwrap();
            assert_eq!((collision.modes, collision.harmonic), (pair, 2), "{sites} {g2} {stable}");
            assert!(collision.detuning.unwrap().abs() < 0.03 * unstable, "{collision:?}");
            edges += 1;
        }
    }
    assert!(edges >= 6, "{edges}");
}

/// Growth of the most unstable multiplier with that phase, dense.
fn most_unstable(bench: &mut Bench, sites: usize, g2: f64, omega: f64, a: f64) -> f64 {
    bench.orbit(Family::DoubleSided, sites, g2, omega, a).map_or(0.0, |orbit| excess(&dense(&orbit)))
}

/// ω at which a sum of two dressed modes of the double-sided orbit is jω.
fn meeting(bench: &mut Bench, sites: usize, g2: f64, a: f64, (k, l, j): (usize, usize, f64), range: (f64, f64)) -> f64 {
    let (mut low, mut high) = range;
    for _ in 0..60 {
        let omega = 0.5 * (low + high);
        bench.orbit(Family::DoubleSided, sites, g2, omega, a).unwrap();
        // Next to the band a mode may be missing.
        let sum = bench.modes.frequency(k).zip(bench.modes.frequency(l)).map_or(f64::INFINITY, |(a, b)| a + b);
        *(if sum > j * omega { &mut low } else { &mut high }) = omega;
    }
    0.5 * (low + high)
}

#[test]
fn half_period_symmetry_spares_odd_harmonics() {
    let mut bench = Bench::new();
    let (sites, g2) = (6, 0.15);
    for (k, l) in [(0, 1), (0, 2), (1, 2), (1, 1), (2, 2)] {
        let centre = |bench: &mut Bench, a: f64| meeting(bench, sites, g2, a, (k, l, 1.0), (1.15, 2.2));
        for (a, stripe) in [(0.0, false), (0.4, true)] {
            let omega = centre(&mut bench, a);
            let largest = (-200..=200)
                .map(|i| most_unstable(&mut bench, sites, g2, omega + 1e-4 * f64::from(i), a))
                .fold(0.0, f64::max);
            assert_eq!(largest > 1e-4, stripe, "{k} {l} a = {a}: {largest:e} about {omega}");
        }
    }
}

#[test]
fn an_even_harmonic_makes_stripes_with_half_period_symmetry_too() {
    let mut bench = Bench::new();
    let mut stripes = 0;
    // Ω̃_k + Ω̃_l = 2ω, within the band.
    for i in 0..800 {
        let omega = 0.6 + 0.0004 * f64::from(i);
        let Some(orbit) = bench.orbit(Family::DoubleSided, 6, 0.15, omega, 0.0) else { continue };
        let values = dense(&orbit);
        let (leading, _) = *values.iter().max_by(|a, b| a.0.norm().total_cmp(&b.0.norm())).unwrap();
        if excess(&values) > 1e-3
            && leading.im.abs() > 1e-6
            && let Some(collision) = bench.modes.collision(leading)
        {
            assert_eq!(collision.harmonic % 2, 0);
            stripes += 1;
        }
    }
    assert!(stripes > 0);
}

#[test]
fn a_mode_against_itself_doubles_the_period_at_odd_harmonics() {
    let mut bench = Bench::new();
    for k in [1, 2] {
        let omega = meeting(&mut bench, 6, 0.15, 0.4, (k, k, 1.0), (1.3, 2.2));
        let mut doubled = 0;
        for i in -300..=300 {
            let orbit = bench.orbit(Family::DoubleSided, 6, 0.15, omega + 5e-5 * f64::from(i), 0.4).unwrap();
            let values = dense(&orbit);
            let (leading, _) = *values.iter().max_by(|a, b| a.0.norm().total_cmp(&b.0.norm())).unwrap();
            if excess(&values) > 1e-4 {
                assert!(leading.im == 0.0 && leading.re < -1.0, "{leading}");
                let collision = bench.modes.collision(leading).unwrap();
                assert_eq!((collision.modes, collision.harmonic), ((k, k), 1));
                doubled += 1;
            }
        }
        assert!(doubled > 0, "{k} at {omega}");
    }
    // Through +1 no mode need have been met.
    assert_eq!(bench.modes.collision(Complex::new(1.5, 0.0)), None);
}
