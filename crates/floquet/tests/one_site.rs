//! One site that is hit on lattices that are no rings: the secular functions of the modes that feel it against the whole monodromy matrix.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Finder, Orbit, OrbitList, Scope, Word};
use vibrochain_floquet::{
    Analyser, Complex, FloquetError, Method, ModeLabels, Stability, Tolerance, Verdict, eigenvalues, full_monodromy,
    odd_multipliers, participating_modes,
};
use vibrochain_lattice::{Chain, Ends};
use vibrochain_testkit::{Random, Ranges, Values};

/// Each of `some` has its own one of `others`, in any order: the largest distance.
fn farthest(some: &[Complex<f64>], others: &[Complex<f64>]) -> f64 {
    assert_eq!(some.len(), others.len());
    let mut open = others.to_vec();
    let mut largest = 0.0_f64;
    // Those outside the circle first: they are apart.
    let mut some = some.to_vec();
    some.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    for z in some {
        let nearest = (0..open.len()).min_by(|&i, &j| (open[i] - z).norm().total_cmp(&(open[j] - z).norm())).unwrap();
        largest = largest.max((open.swap_remove(nearest) - z).norm());
    }
    largest
}

/// The multipliers of the whole lattice, and the norm of the matrix.
fn reference(orbit: &Orbit) -> Option<(Vec<Complex<f64>>, f64)> {
    let matrix = full_monodromy(orbit).ok()?;
    let mut values = Vec::new();
    eigenvalues(&matrix, &mut values).unwrap();
    Some((values, matrix.norm()))
}

fn told(orbit: &Orbit, finder: &mut Finder) -> Option<Stability> {
    match Analyser::default().stability(orbit, finder, Tolerance::Rounding) {
        Err(FloquetError::Grazing { .. }) => None,
        answer => Some(answer.unwrap()),
    }
}

/// Modes that are spared are on the circle, of which a verdict says nothing.
fn holds(verdict: &Verdict, dense: &[Complex<f64>], spared: bool, allowed: f64, name: &str) {
    let excess = dense.iter().map(|mu| mu.norm()).fold(0.0, f64::max) - 1.0;
    let told = if spared { verdict.excess().max(0.0) } else { verdict.excess() };
    let off = (told - excess).abs();
    assert!(verdict.undecided || off <= allowed + verdict.resolution, "{name}: {verdict:?}, matrix {excess:e}");
    assert!(
        verdict.undecided || verdict.stable == (excess <= allowed) || excess.abs() <= allowed,
        "{name}: {verdict:?}"
    );
}

/// Words of the families' names, at any site.
fn word(random: &mut Random, chain: &Chain, doubled: bool) -> Word {
    let (site, layer) = chain.layout().place(random.below(chain.sites()));
    let words: &[&str] = if doubled { &["S+,S-", "S-", "S-,S-"] } else { &["S+,S-", "S-"] };
    random.of(words).replace('S', &format!("{site}:{layer}")).parse().unwrap()
}

/// Rows, layers, layers with springs like those of the rows, where modes coincide, and layers without any.
fn lattice(random: &mut Random, ranges: &Ranges) -> Chain {
    let chain = random.lattice(ranges);
    if chain.layers() == 1 {
        return chain;
    }
    let gamma3 = random.of(&[chain.gamma3(), chain.gamma3(), chain.gamma2(), 0.0]);
    chain.with_layers(chain.layers(), gamma3, chain.layer_ends()).unwrap()
}

#[test]
fn forced_orbits_have_the_multipliers_of_the_whole_matrix() {
    let mut random = Random(1503);
    let ranges = Ranges { sites: [1, 9], gamma2: Values::Log(1e-3, 0.4), ..Ranges::FORCED };
    let (mut finder, mut found) = (Finder::new(7), OrbitList::default());
    let (mut checked, mut secular, mut outside, mut spared, mut coincident, mut elastic) = (0, 0, 0, 0, 0, 0);
    for _ in 0..700 {
        let chain = lattice(&mut random, &ranges);
        if chain.is_ring() || chain.is_uncoupled() {
            continue;
        }
        let model = random.model(&ranges);
        let e = if random.chance(0.15) { 1.0 } else { model.restitution() };
        let model = model.point().on(&chain).restitution(e).model().unwrap();
        let word = word(&mut random, &chain, true);
        if finder.find_word(&model, &word, Scope::All, &mut found).is_err() {
            continue;
        }
        for orbit in found.orbits.iter().take(3) {
            let name = format!("{word} {model}");
            let Some((dense, norm)) = reference(orbit) else { continue };
            let Some(Stability { verdict, multipliers }) = told(orbit, &mut finder) else { continue };
            let condition = finder.prepared(orbit).unwrap().response().condition();
            // Two that meet are split by the root.
            let sharp = 1e-12 * norm * (norm + condition);
            let odd = odd_multipliers(orbit).unwrap();
            holds(&verdict, &dense, !odd.is_empty(), sharp.sqrt().min(1e-5), &name);
            let distance = farthest(&multipliers, &dense);
            assert!(distance < (3.0 * sharp.sqrt()).max(1e-5), "{name}: {distance:e} {verdict:?}");
            checked += 1;
            secular += usize::from(verdict.method == Method::Secular);
            outside += usize::from(verdict.excess() > 1e-6);
            elastic += usize::from(e == 1.0);
            spared += odd.len();
            coincident +=
                usize::from(chain.layers() > 1 && (chain.gamma3() == chain.gamma2() || chain.gamma3() == 0.0));
        }
    }
    let counts = [checked, secular, outside, spared, coincident, elastic];
    assert!(checked > 400 && 20 * secular > 19 * checked, "{counts:?}");
    assert!(outside > 100 && spared > 1000 && coincident > 80 && elastic > 20, "{counts:?}");
}

/// In the middle of a row every second mode has a node; modes of equal frequency leave one combination that is felt.
#[test]
fn spared_modes_keep_their_multipliers_and_their_names() {
    let row = Chain::new(5, 0.2, 0.1).unwrap().with_ends(Ends::Free);
    let square = row.with_layers(5, 0.1, Ends::Free).unwrap();
    // Of 15 sums of two of a row's five numbers two are equal: 0.382 + 3.618 = 1.382 + 2.618.
    let frequency = |k: usize| 2.0 * 0.1_f64.sqrt() * (std::f64::consts::PI * k as f64 / 10.0).sin();
    for (chain, word, spared) in [(row, "2-", 2), (square, "0:0-", 11), (square, "2:2-", 25 - 6)] {
        let model = chain.point().omega(0.92).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
        let (mut finder, mut found) = (Finder::new(1), OrbitList::default());
        finder.find_word(&model, &word.parse().unwrap(), Scope::All, &mut found).unwrap();
        let orbit = &found.orbits[0];
        let multipliers = told(orbit, &mut finder).unwrap().multipliers;
        let mut labels = ModeLabels::new(orbit, &mut finder).unwrap();
        let modes: Vec<Option<usize>> = multipliers.iter().map(|z| labels.mode(*z)).collect();
        let on_circle = multipliers.iter().zip(&modes).filter(|(z, _)| (z.norm() - 1.0).abs() < 1e-14);
        let mut count = 0;
        for (z, mode) in on_circle {
            let (k, l) = (mode.unwrap() % 5, mode.unwrap() / 5);
            let turn = (0.2 + frequency(k).powi(2) + frequency(l).powi(2)).sqrt() * orbit.period();
            assert!(
                (z.re - turn.cos()).abs() < 1e-12 && (z.im.abs() - turn.sin().abs()).abs() < 1e-12,
                "{word} {k} {l}"
            );
            count += 1;
        }
        assert_eq!((count, odd_multipliers(orbit).unwrap().len()), (2 * spared, 2 * spared), "{word}");
        assert_eq!(
            participating_modes(&chain, orbit.impact_site().unwrap()).len(),
            if word == "2-" {
                3
            } else if word == "0:0-" {
                25
            } else {
                9
            }
        );
    }
}

/// Layers without springs between them are rings that do not feel each other.
#[test]
fn one_of_several_loose_rings_is_a_ring() {
    let (mut finder, mut found, mut alone) = (Finder::new(8), OrbitList::default(), OrbitList::default());
    let mut checked = 0;
    for (word, omega, amplitude, e) in
        [("2:1-", 0.92, 0.1, 0.9), ("2:1+,2:1-", 1.5, 0.1, 0.9), ("2:1-,2:1-", 1.5, 0.3, 0.9), ("2:1-", 0.93, 0.0, 1.0)]
    {
        let ring = Chain::new(8, 0.2, 0.1).unwrap();
        let layers = ring.with_layers(3, 0.0, Ends::Free).unwrap();
        let model = |chain: Chain| {
            chain.point().omega(omega).asymmetry(0.4).amplitude(amplitude).restitution(e).model().unwrap()
        };
        finder.find_word(&model(layers), &word.parse().unwrap(), Scope::All, &mut found).unwrap();
        finder.find_word(&model(ring), &word.replace(":1", "").parse().unwrap(), Scope::All, &mut alone).unwrap();
        assert_eq!(found.orbits.len(), alone.orbits.len());
        for (orbit, other) in found.orbits.iter().zip(&alone.orbits) {
            let (answer, expected) = (told(orbit, &mut finder).unwrap(), told(other, &mut finder).unwrap());
            assert_eq!((answer.verdict.method, expected.verdict.method), (Method::Secular, Method::Secular));
            let mut all = expected.multipliers.clone();
            for k in 0..8_u32 {
                let s = (std::f64::consts::PI * f64::from(k) / 8.0).sin();
                let turn = (0.2 + 0.4 * s * s).sqrt() * orbit.period();
                all.extend([1.0, 1.0, -1.0, -1.0].map(|sign| Complex::from_polar(1.0, sign * turn)));
            }
            let distance = farthest(&answer.multipliers, &all);
            assert!(distance < 1e-9, "{word}: {distance:e}");
            assert!((answer.verdict.spectral_radius - expected.verdict.spectral_radius).abs() < 1e-11, "{word}");
            checked += 1;
        }
    }
    assert!(checked >= 5, "{checked}");
}

/// As many modes as take Cauchy sums without losses.
#[test]
fn long_rows_and_wide_layers_need_no_matrix() {
    let (mut checked, mut secularly) = (0, 0);
    let row = Chain::new(230, 0.2, 0.1).unwrap();
    let layers = Chain::new(80, 0.2, 0.1).unwrap().with_ends(Ends::Free).with_layers(3, 0.04, Ends::Free).unwrap();
    for (chain, site) in [
        (row.with_ends(Ends::Free), 0),
        (row.with_ends(Ends::Free), 97),
        (row.with_ends(Ends::Fixed), 30),
        (layers, 80 + 30),
    ] {
        for (family, omega, amplitude, e) in
            [("S-", 0.92, 0.1, 0.9), ("S+,S-", 1.5, 0.1, 0.9), ("S-,S-", 1.5, 0.3, 0.99), ("S-", 0.97, 0.1, 1.0)]
        {
            let (mut finder, mut found) = (Finder::new(1), OrbitList::default());
            let (n, layer) = chain.layout().place(site);
            let word: Word = family.replace('S', &format!("{n}:{layer}")).parse().unwrap();
            let model = chain.point().omega(omega).asymmetry(0.4).amplitude(amplitude).restitution(e).model().unwrap();
            finder.find_word(&model, &word, Scope::All, &mut found).unwrap();
            let Some(orbit) = found.orbits.first() else { continue };
            let name = format!("{word} {model}");
            let answer = told(orbit, &mut finder).unwrap();
            secularly += usize::from(answer.verdict.method == Method::Secular);
            let (dense, norm) = reference(orbit).unwrap();
            let spared = !odd_multipliers(orbit).unwrap().is_empty();
            holds(&answer.verdict, &dense, spared, 1e-9 * norm, &name);
            let distance = farthest(&answer.multipliers, &dense);
            assert!(distance < 1e-7 * norm, "{name}: {distance:e}");
            if e < 1.0 {
                let alone = Analyser::default().verdict(orbit, &mut finder, Tolerance::Rounding).unwrap();
                assert_eq!((alone.method, alone.stable), (Method::Secular, answer.verdict.excess() < 0.0), "{name}");
            }
            checked += 1;
        }
    }
    assert!(checked >= 12 && secularly >= checked - 1, "{secularly} of {checked}");
}
