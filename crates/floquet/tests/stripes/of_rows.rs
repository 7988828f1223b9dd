//! Which modes collide on rows with ends and in layers: Krein's form on eigenvectors of the whole monodromy matrix against what the
//! frequencies of the modes say.

use std::f64::consts::{PI, TAU};

use faer::MatRef;
use vibrochain_breather::{Finder, Orbit, OrbitList, Scope};
use vibrochain_floquet::{Complex, DressedModes, Secular, Signature, full_monodromy, participating_modes};
use vibrochain_lattice::{Chain, Ends, Model};
use vibrochain_testkit::{Random, Ranges, Values};

use super::krein::{Krein, apart, excess};

/// Those of perturbations that reach the site that is hit.
fn dense(orbit: &Orbit) -> Vec<Krein> {
    let matrix = full_monodromy(orbit).unwrap();
    let (size, half, site) = (matrix.nrows(), matrix.nrows() / 2, orbit.impact_site().unwrap());
    let eigen = MatRef::from_column_major_slice(matrix.as_slice(), size, size).eigen().unwrap();
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    let all = (0..size).filter_map(|i| {
        let entry = |row: usize| Complex::new(vectors[(row, i)].re, vectors[(row, i)].im);
        let felt = entry(site).norm_sqr() + entry(site + half).norm_sqr() > 1e-18;
        let form = |n: usize| (entry(n).conj() * entry(n + half)).im / orbit.frequency();
        felt.then(|| (Complex::new(values[i].re, values[i].im), (0..half).map(form).sum()))
    });
    all.collect()
}

/// Distance of a phase from the nearest one with this sign of the form, the trivial pair aside.
fn nearest(values: &[Krein], phase: f64, positive: bool) -> f64 {
    let alike = values.iter().filter(|(z, form)| (*form > 0.0) == positive && (z - 1.0).norm() > 1e-4);
    alike.map(|(z, _)| apart(z.arg(), phase)).fold(PI, f64::min)
}

struct Bench {
    finder: Finder,
    found: OrbitList,
    modes: DressedModes,
}

impl Bench {
    fn new() -> Self {
        Self { finder: Finder::new(21), found: OrbitList::default(), modes: DressedModes::default() }
    }

    /// The orbit of one site, hit once a period or twice, and its modes.
    fn orbit(&mut self, chain: Chain, site: usize, double: bool, (omega, a): (f64, f64)) -> Option<Orbit> {
        let model = Model::conservative(chain, omega, a).unwrap();
        let (n, layer) = chain.layout().place(site);
        let word = if double { format!("{n}:{layer}+,{n}:{layer}-") } else { format!("{n}:{layer}-") };
        self.finder.find_word(&model, &word.parse().unwrap(), Scope::All, &mut self.found).ok()?;
        let orbit = self.found.orbits.pop()?;
        self.modes.replace(self.finder.prepared(&orbit).unwrap()).ok()?;
        Some(orbit)
    }
}

fn lattice(random: &mut Random, gamma2: Values) -> (Chain, usize, f64) {
    loop {
        let ranges = Ranges { sites: [2, 14], gamma1: Values::Is(0.2), gamma2, ..Ranges::CONSERVATIVE };
        let chain = random.lattice(&ranges);
        if chain.is_ring() || chain.is_uncoupled() {
            continue;
        }
        let site = random.below(chain.sites());
        let frequencies = participating_modes(&chain, site);
        // Apart from what symmetry makes of it all are different.
        if frequencies.windows(2).all(|pair| pair[1].1 - pair[0].1 > 1e-4) {
            return (chain, site, frequencies.last().unwrap().1);
        }
    }
}

/// Nothing but G₀ is in a band, whatever the lattice: the frequencies are exact.
#[test]
fn above_twice_the_bands_the_dressed_modes_are_the_multipliers() {
    let (mut random, mut bench, mut checked, mut layered) = (Random(2), Bench::new(), 0, 0);
    for i in 0..400 {
        let (chain, site, top) = lattice(&mut random, Values::Even(0.01, 0.4));
        let upper = (0.2 + 4.0 * chain.gamma2() + 4.0 * chain.gamma3()).sqrt().max(top);
        let omega = upper * random.between(2.05, 6.0);
        let Some(orbit) = bench.orbit(chain, site, i % 2 == 0, (omega, random.between(0.0, 0.9))) else { continue };
        let values = dense(&orbit);
        let left = values.iter().filter(|(z, _)| z.norm() > 1.0 + 1e-5).count();
        let all: Vec<f64> = bench.modes.frequencies().flatten().collect();
        assert_eq!(bench.modes.count(), participating_modes(&chain, site).len());
        assert_eq!(all.len() + left, bench.modes.count() - 1, "{orbit:?} {all:?}");
        for dressed in all {
            let z = Complex::from_polar(1.0, dressed * TAU / omega);
            let distance =
                values.iter().filter(|(_, form)| *form > 0.0).map(|(w, _)| (w - z).norm()).fold(2.0, f64::min);
            assert!(distance < if z.re > 0.999 { 1e-6 } else { 1e-8 }, "{distance:e} {dressed} {orbit:?}");
            checked += 1;
            layered += usize::from(chain.layers() > 1);
        }
    }
    assert!(checked > 2000 && layered > 1000, "{checked} {layered}");
}

/// In the middle of where modes meet: next to each dressed mode of a stable breather is its multiplier, and the signature told is that of
/// Krein's form.
#[test]
fn dressed_modes_of_stable_breathers_have_their_multipliers_with_their_signatures() {
    let (mut random, mut bench, mut secular) = (Random(3), Bench::new(), Secular::default());
    let (mut all, mut close, mut wrong, mut told, mut near_end) = (0, 0, 0, 0, 0);
    for i in 0..2500 {
        let (chain, site, top) = lattice(&mut random, Values::Even(0.02, 0.2));
        let (omega, a) = (random.between(0.7, 2.2), random.between(0.0, 0.8));
        if omega < top || omega > 2.0 * top {
            continue;
        }
        let Some(orbit) = bench.orbit(chain, site, i % 2 == 0, (omega, a)) else { continue };
        if !bench.finder.admissibility(&orbit).unwrap().is_physical() {
            continue;
        }
        let values = dense(&orbit);
        let prepared = bench.finder.prepared(&orbit).unwrap();
        if excess(&values) > 1e-5 || secular.replace(prepared).is_err() {
            continue;
        }
        let Ok((roots, _)) = secular.roots() else { continue };
        let signatures = bench.modes.signatures(&bench.finder.at_contacts(&orbit).unwrap(), roots);
        for (k, dressed) in bench.modes.frequencies().enumerate() {
            let Some(dressed) = dressed else {
                assert_eq!(signatures[k], None);
                continue;
            };
            let phase = dressed * TAU / omega;
            let distance = nearest(&values, phase, true);
            all += 1;
            close += usize::from(distance < 0.005 * TAU);
            wrong += usize::from(nearest(&values, phase, false) < distance);
            near_end += usize::from(chain.ends() != Ends::Closed && site % chain.length() < 2);
            let Some(signature) = signatures[k] else { continue };
            let place = Complex::from_polar(1.0, phase).arg().abs();
            let upper = values.iter().filter(|(z, _)| z.im > 0.0 && (z - 1.0).norm() > 1e-4);
            let (_, form) =
                upper.min_by(|a, b| (a.0.arg() - place).abs().total_cmp(&(b.0.arg() - place).abs())).unwrap();
            let expected = if *form > 0.0 { Signature::Positive } else { Signature::Negative };
            assert_eq!(signature, expected, "mode {k} {orbit:?}");
            told += 1;
        }
    }
    assert!(all > 2000 && near_end > 300, "{all} {near_end}");
    assert!(close as f64 > 0.99 * all as f64, "{close} of {all}");
    assert!((wrong as f64) < 0.01 * all as f64, "{wrong} of {all}");
    assert!(told as f64 > 0.99 * all as f64, "{told} of {all}");
}

/// The mode that a breather has drawn out of the bands.
#[test]
fn the_internal_mode_has_its_multiplier_with_its_signature() {
    let (mut random, mut bench) = (Random(5), Bench::new());
    let (mut localised, mut physical, mut complete) = (0, 0, 0);
    for i in 0..6000 {
        let (chain, site, _) = lattice(&mut random, Values::Even(0.02, 0.3));
        let (omega, a) = (random.between(0.45, 1.4), random.between(0.0, 0.8));
        let Some(orbit) = bench.orbit(chain, site, i % 2 == 0, (omega, a)) else { continue };
        let Some(own) =
            bench.modes.internal_mode().copied().filter(|own| own.loss == 0.0 && own.frequency != 0.5 * omega)
        else {
            continue;
        };
        let values = dense(&orbit);
        if excess(&values) > 1e-5 {
            continue;
        }
        let phase = own.frequency * TAU / omega;
        let distance = nearest(&values, phase, true);
        assert!(distance < 1e-6, "{distance:e} {own:?} {orbit:?}");
        let sign = if phase < PI { Signature::Positive } else { Signature::Negative };
        assert_eq!(own.signature(omega), Some(sign));
        localised += 1;
        if bench.finder.admissibility(&orbit).unwrap().is_physical() {
            physical += 1;
            complete += usize::from(bench.modes.frequencies().flatten().count() == bench.modes.count() - 1);
        }
    }
    assert!(localised > 200 && physical > 100, "{localised} {physical}");
    assert!(complete == physical, "{complete} of {physical}");
}

/// Edges of stripes along ω, found by dense multipliers: the two that are about to collide have opposite forms, and the pair of modes that
/// is named sums to a harmonic there.
#[test]
fn at_the_edge_of_a_stripe_a_sum_of_two_dressed_modes_of_opposite_signature_is_a_harmonic() {
    let mut bench = Bench::new();
    let chain = |length: usize| Chain::new(length, 0.2, 0.12).unwrap();
    let free = chain(7).with_ends(Ends::Free);
    let fixed = chain(8).with_ends(Ends::Fixed);
    let layers = |length: usize, ends: Ends| chain(length).with_ends(ends).with_layers(2, 0.05, Ends::Free).unwrap();
    let (mut every, mut named_right) = (0, 0);
    for (chain, site, double, from, to) in [
        (free, 0, true, 1.1, 1.9),
        (free, 2, true, 1.1, 1.9),
        (free, 0, false, 0.9, 1.5),
        (fixed, 1, true, 1.1, 1.9),
        (layers(8, Ends::Closed), 0, true, 1.1, 2.0),
        (layers(5, Ends::Free), 0, true, 1.1, 2.0),
        (layers(5, Ends::Free), 6, false, 1.0, 1.5),
    ] {
        let name = format!("{:?} {site} {double}", chain.layout());
        let at = |bench: &mut Bench, omega: f64| {
            let orbit = bench.orbit(chain, site, double, (omega, 0.4))?;
            let values = dense(&orbit);
            let (leading, _) = *values.iter().max_by(|a, b| a.0.norm().total_cmp(&b.0.norm())).unwrap();
            let named = bench.modes.collision(leading);
            Some((excess(&values) > 1e-4, leading, values, named))
        };
        let (mut edges, mut sums) = (0, 0);
        let steps = 700;
        let value = |i: usize| from + (to - from) * i as f64 / steps as f64;
        for i in 0..steps {
            let (mut stable, mut unstable) = (value(i), value(i + 1));
            let (Some(a), Some(b)) = (at(&mut bench, stable), at(&mut bench, unstable)) else { continue };
            if a.0 == b.0 {
                continue;
            }
            if a.0 {
                (stable, unstable) = (unstable, stable);
            }
            for _ in 0..20 {
                let middle = 0.5 * (stable + unstable);
                let Some((is, ..)) = at(&mut bench, middle) else { break };
                *(if is { &mut unstable } else { &mut stable }) = middle;
            }
            let (_, leading, _, named) = at(&mut bench, unstable).unwrap();
            if leading.im.abs() < 1e-3 {
                continue;
            }
            // A little farther back the forms are beyond rounding.
            let (_, _, values, _) = at(&mut bench, stable + (stable - unstable).signum() * 1e-5).unwrap();
            let mut upper: Vec<Krein> = values.into_iter().filter(|(z, _)| z.im > 1e-9).collect();
            let place = leading.arg().abs();
            upper.sort_by(|a, b| (a.0.arg() - place).abs().total_cmp(&(b.0.arg() - place).abs()));
            assert!(upper[0].1 * upper[1].1 < 0.0, "{name} {stable}: {:?}", &upper[..2]);
            edges += 1;
            let Some(collision) = named else {
                continue;
            };
            assert!(collision.modes.0 < collision.modes.1 && collision.harmonic >= 1);
            sums += usize::from(collision.detuning.is_some_and(|d| d.abs() < 0.03 * unstable));
        }
        assert!(edges >= 15 && sums + 1 >= edges, "{name}: {sums} of {edges}");
        (every, named_right) = (every + edges, named_right + sums);
    }
    // Pushed over the last mode, one is next to no two.
    assert!(every > 200 && 100 * named_right >= 99 * every, "{named_right} of {every}");
}
