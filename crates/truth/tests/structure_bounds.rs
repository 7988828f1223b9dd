//! What is told as the error of an orbit of a structure, and of its spectral radius, is a bound: no promise is broken, where stiffness and
//! masses are many orders apart, next to resonances, through critical damping, for plastic and elastic impacts.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::sync::Arc;

use nalgebra::{Complex as C, DMatrix, DVector};
use vibrochain_breather::{LoadedStructure, Orbit};
use vibrochain_floquet::{Tolerance, stability};
use vibrochain_lattice::{Chain, Contact, Spectrum, Structure};
use vibrochain_testkit::{Random, stiffness};
use vibrochain_truth::TrueStructureOrbit;

const BITS: usize = 192;

/// What is hard about a structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Trouble {
    Stiff,
    Light,
    Resonance,
    CriticalDamping,
    Impacts,
    WeakCoupling,
}

fn symmetric(random: &mut Random, n: usize) -> DMatrix<f64> {
    let root = DMatrix::from_fn(n, n, |_, _| random.between(-1.0, 1.0));
    &root * root.transpose() + DMatrix::identity(n, n) * random.between(0.3, 1.5)
}

/// A ring of masses that hardly feel each other next to a resonance, forced or without loss, as matrices.
fn weakly_coupled(random: &mut Random) -> (Structure, f64, &'static str) {
    let n = 1 + random.below(8);
    let chain = Chain::new(n, random.between(0.05, 1.0), random.log(1e-4, 1e-2)).unwrap();
    let spectrum = Spectrum::new(chain);
    let near = random.of(spectrum.frequencies()) / (1 + random.below(3)) as f64;
    let omega = near * (1.0 + random.of(&[1.0, -1.0]) * random.log(1e-9, 1e-2));
    let (a, is_forced) = (random.between(0.0, 0.8), random.chance(0.5));
    let restitution = if is_forced { random.between(0.5, 0.99) } else { 1.0 };
    let at = |site: usize| DVector::from_fn(n, |i, _| if i == site { 1.0 } else { 0.0 });
    let contact = |site: usize| (at(site), Contact { lower: Some(a - 1.0), upper: Some(a + 1.0), restitution });
    let load = DVector::from_element(n, C::new(random.between(0.02, 0.3), 0.0));
    let structure = Structure {
        mass: DMatrix::identity(n, n),
        stiffness: stiffness(&chain),
        contacts: (0..n.min(2)).map(contact).collect(),
        loads: if is_forced { vec![(1, load)] } else { Vec::new() },
        ..Structure::default()
    };
    let words: &[&str] = if n > 1 { &["0-", "0+,0-", "0-,1-", "0-1-", "0-,1+"] } else { &["0-", "0+,0-"] };
    (structure, omega, words[random.below(words.len())])
}

/// A structure, the frequency of its loads, and a word.
fn draw(random: &mut Random, trouble: Trouble) -> (Structure, f64, &'static str) {
    if trouble == Trouble::WeakCoupling {
        return weakly_coupled(random);
    }
    let n = 1 + random.below(3);
    let n = if matches!(trouble, Trouble::Stiff | Trouble::Light | Trouble::CriticalDamping) { n.max(2) } else { n };
    let mut mass = DMatrix::from_diagonal(&DVector::from_fn(n, |_, _| random.between(0.6, 1.4)));
    let mut stiffness = symmetric(random, n);
    let scaled =
        |matrix: &DMatrix<f64>, by: &DVector<f64>| DMatrix::from_fn(n, n, |i, j| by[i] * matrix[(i, j)] * by[j]);
    match trouble {
        Trouble::Stiff => {
            let by = DVector::from_fn(n, |i, _| if i == 0 { 1.0 } else { random.log(1e2, 1e4) });
            stiffness = scaled(&stiffness, &by);
        }
        Trouble::Light => mass[(n - 1, n - 1)] = random.log(1e-7, 1e-4),
        _ => {}
    }
    let squares = {
        let root = mass.map(|m| if m > 0.0 { m.sqrt().recip() } else { 0.0 });
        (&root * &stiffness * &root).symmetric_eigenvalues()
    };
    let frequencies: Vec<f64> = squares.iter().map(|square| square.max(0.0).sqrt()).collect();
    let slowest = frequencies.iter().copied().fold(f64::INFINITY, f64::min);
    let mut omega = slowest * random.between(0.6, 3.0);
    let mut damping = DMatrix::zeros(0, 0);
    match trouble {
        Trouble::Resonance => {
            let near = frequencies[random.below(n)] / f64::from(1 + random.below(2) as u32);
            let side = if random.chance(0.5) { 1.0 } else { -1.0 };
            omega = near * (1.0 + side * random.log(1e-9, 1e-4));
            if random.chance(0.3) {
                damping = &stiffness * random.log(1e-9, 1e-3);
            }
        }
        Trouble::CriticalDamping => {
            // ζ of one mode within 1e-9 … 0.1 of 1, of the others as it comes.
            let off = random.log(1e-9, 0.1) * if random.chance(0.5) { 1.0 } else { -1.0 };
            let fastest = frequencies.iter().copied().fold(0.0, f64::max);
            damping = &stiffness * (2.0 * (1.0 + off) / fastest);
            omega = slowest * random.between(0.3, 1.5);
            if random.chance(0.3) {
                damping[(0, 0)] *= 1.0 + random.log(1e-6, 1e-1);
            }
        }
        _ if random.chance(0.7) => {
            damping = &stiffness * random.log(1e-4, 1e-1) / slowest;
            damping[(0, 0)] *= if random.chance(0.5) { 1.3 } else { 1.0 };
        }
        _ => {}
    }
    let restitution = |random: &mut Random| match trouble {
        Trouble::Impacts => [0.0, 1.0, 1e-3, 0.999][random.below(4)],
        _ => random.between(0.1, 0.95),
    };
    let mut load = DVector::from_fn(n, |_, _| C::from_polar(random.between(0.0, 1.0), random.between(-3.0, 3.0)));
    load[0] += C::new(0.5, 0.0);
    let still = random.between(0.1, 0.8);
    let contact = |random: &mut Random, at: usize| {
        let mut weights = DVector::zeros(n);
        weights[at] = 1.0;
        if n > 1 && random.chance(0.2) {
            weights[(at + 1) % n] = -1.0;
        }
        (
            weights,
            Contact { lower: Some(-random.between(0.1, 0.8)), upper: Some(still), restitution: restitution(random) },
        )
    };
    let contacts = vec![contact(random, 0), contact(random, n - 1)];
    let structure = Structure { mass, damping, stiffness, contacts, loads: vec![(1, load)], ..Structure::default() };
    let words: &[&str] = if n > 1 { &["0+", "1-", "0+,0-", "0+,1+", "1+,1-"] } else { &["0+", "0-", "0+,0-", "0-,0-"] };
    (structure, omega, words[random.below(words.len())])
}

#[derive(Debug, Default)]
struct Tally {
    orbits: usize,
    /// Errors without a bound, of orbits and of spectral radii.
    open: usize,
    open_radii: usize,
    /// Verdicts that say something.
    decided: usize,
    broken: Vec<String>,
    /// log10 of bound over error, of impulses and radii, added up.
    room: [f64; 2],
    measured: [usize; 2],
}

impl Tally {
    fn hold(&mut self, what: &str, place: usize, off: f64, told: f64) {
        // A multiplier that structure keeps on the circle is there up to the digits of the truth.
        let off = if off < 1e-40 { 0.0 } else { off };
        if off.is_nan() || off > told {
            self.broken.push(format!("{what}: {off:e} told {told:e}"));
        }
        if off > 0.0 && told.is_finite() {
            self.room[place] += (told / off).log10();
            self.measured[place] += 1;
        }
    }

    fn take(&mut self, name: &str, structure: &Structure, orbit: &Orbit) {
        self.orbits += 1;
        let told = orbit.contacts().unwrap().impact_errors();
        let known = told.iter().all(|told| told.impulse.is_finite());
        let Ok(truth) = TrueStructureOrbit::refine(structure, orbit, BITS) else {
            if known {
                self.broken.push(format!("{name}: no orbit there"));
            }
            return;
        };
        self.open += usize::from(!known);
        let errors = truth.errors_of(orbit).unwrap();
        for (i, told) in told.iter().enumerate() {
            self.hold(&format!("{name} P{i}"), 0, errors.impulses[i], told.impulse);
            self.hold(&format!("{name} t{i}"), 0, errors.times[i], told.time);
            self.hold(&format!("{name} a{i}"), 0, errors.accelerations[i], told.acceleration);
        }
        let Ok(stability) = stability(orbit, Tolerance::Rounding) else {
            self.open_radii += 1;
            return;
        };
        let (verdict, radius) = (stability.verdict, &truth.spectral_radius());
        let beyond = (radius - 1.0).to_f64();
        // Modes without a dashpot that no impact feels stay on the circle, and decide nothing.
        let is_spared = beyond.abs() < 1e-30 && verdict.spectral_radius < 1.0;
        let off = if is_spared { 0.0 } else { (radius - verdict.spectral_radius).abs().to_f64() };
        // Where structure does not say it, the radius itself is rounded.
        let rounded =
            if verdict.resolution > 0.0 { 0.5 * f64::EPSILON * verdict.spectral_radius.max(1.0) } else { 0.0 };
        self.hold(&format!("{name} radius"), 1, off, verdict.resolution + rounded);
        self.open_radii += usize::from(!verdict.resolution.is_finite());
        self.decided += usize::from(!verdict.undecided);
        if !verdict.undecided && verdict.stable != (beyond <= 0.0) && beyond.abs() > 1e-30 {
            self.broken.push(format!("{name}: {verdict} but {beyond:e}"));
        }
    }
}

fn tally(trouble: Trouble, seed: u64, count: usize) -> Tally {
    let mut random = Random(seed);
    let mut tally = Tally::default();
    for number in 0..count {
        let (structure, omega, word) = draw(&mut random, trouble);
        let Ok(modal) = structure.modal() else { continue };
        let model = LoadedStructure::new(Arc::new(modal), omega).unwrap();
        let Ok(found) = model.orbits(&word.parse().unwrap(), 1) else { continue };
        for (k, orbit) in found.orbits.iter().take(3).enumerate() {
            tally.take(&format!("{trouble:?} {number} {word} {k}"), &structure, orbit);
        }
    }
    let mean = [0, 1].map(|k| tally.room[k] / tally.measured[k].max(1) as f64);
    println!(
        "{trouble:?}: {} orbits, open {} {}, decided {}, bound/error 1e{mean:.1?}",
        tally.orbits, tally.open, tally.open_radii, tally.decided
    );
    tally.broken.iter().take(12).for_each(|line| println!("  {line}"));
    tally
}

fn holds(trouble: Trouble, seed: u64, least: usize) {
    let tally = tally(trouble, seed, 100);
    assert!(tally.broken.is_empty(), "{} of {}: {:?}", tally.broken.len(), tally.orbits, tally.broken.first());
    assert!(tally.orbits >= least && tally.open * 4 < tally.orbits && tally.measured[0] > 60, "{tally:?}");
    assert!(tally.decided * 4 > tally.orbits * 3, "{tally:?}");
}

#[test]
fn stiff_structures() {
    holds(Trouble::Stiff, 1, 60);
}

#[test]
fn light_coordinates() {
    holds(Trouble::Light, 2, 60);
}

#[test]
fn next_to_resonances() {
    holds(Trouble::Resonance, 3, 120);
}

#[test]
fn weakly_coupled_masses_next_to_resonances() {
    are_held_next_to_resonances(25);
}

#[test]
#[ignore = "half a minute: cargo test --workspace --test structure_bounds -- --ignored slow"]
fn slow_weakly_coupled_masses_next_to_resonances() {
    are_held_next_to_resonances(60);
}

fn are_held_next_to_resonances(draws: usize) {
    let tally = tally(Trouble::WeakCoupling, 6, draws);
    assert!(tally.broken.is_empty(), "{} of {}: {:?}", tally.broken.len(), tally.orbits, tally.broken.first());
    assert!(3 * tally.orbits > 4 * draws && tally.decided * 4 > tally.orbits * 3, "{tally:?}");
}

#[test]
fn through_critical_damping() {
    holds(Trouble::CriticalDamping, 4, 40);
}

#[test]
fn plastic_and_elastic_impacts() {
    holds(Trouble::Impacts, 5, 100);
}

/// A structure by its matrices, one row after the other, with loads as sizes and phases.
fn given(matrices: [&[f64]; 3], contacts: &[(Option<f64>, f64, f64)], loads: &[(f64, f64)]) -> Structure {
    let n = loads.len();
    let [mass, damping, stiffness] = matrices
        .map(|entries| if entries.is_empty() { DMatrix::zeros(0, 0) } else { DMatrix::from_row_slice(n, n, entries) });
    let contact = |(at, &(lower, upper, restitution)): (usize, &(Option<f64>, f64, f64))| {
        let weights = DVector::from_fn(n, |i, _| if i == at { 1.0 } else { 0.0 });
        (weights, Contact { lower, upper: Some(upper), restitution })
    };
    Structure {
        mass,
        damping,
        stiffness,
        contacts: contacts.iter().enumerate().map(contact).collect(),
        loads: vec![(1, DVector::from_fn(n, |i, _| C::from_polar(loads[i].0, loads[i].1)))],
        ..Structure::default()
    }
}

/// Of three structures whose errors were told too small, by Newton's method in 60 digits and saltations of the state matrix (mpmath): a mass
/// of 1e-6, loads next to a resonance.
#[test]
fn structures_whose_errors_were_told_too_small() {
    let (k, d) = (0.17664671411875127, 0.0012563601665956737);
    let light = given(
        [
            &[0.8321261042548943, 0.0, 0.0, 1.0207179965074112e-06],
            &[0.0019192542466609707, d, d, 0.00565162585570932],
            &[0.15077203872810108, k, k, 0.986281286800948],
        ],
        &[
            (Some(-0.649040490613557), 0.2753112024200735, 0.16202134304064453),
            (None, 0.37764722132939804, 0.33828137733638153),
        ],
        &[(1.7124338212490717, 1.8510029711260978), (1.1730233649986392, -1.1434885841752636)],
    );
    let k = -0.830214191649277;
    let resonant = given(
        [&[1.0, 0.0, 0.0, 1.0], &[], &[1.1384454988354615, k, k, 1.7327395107432353]],
        &[(Some(-0.4889533869797575), 0.24665042088663186, 0.9)],
        &[(0.8960306252879023, 0.0), (0.0, 0.0)],
    );
    let [a, b, c] = [-0.08410625672023866, 0.0062566479465599985, -0.0008809744252752322];
    let [e, f, g] = [-0.0006621452822194712, -0.0001771673363534755, 0.0004083494541556509];
    let [h, i, j] = [1.4038426970960698, -0.6796936253509221, 1.9543987813923267];
    let plastic = given(
        [
            &[0.7747588184686635, a, b, a, 0.8253997992242467, c, b, c, 0.7550416995885734],
            &[0.003574147433097176, e, f, e, 0.00218927981725917, g, f, g, 0.003930658116018306],
            &[7.571441126909749, h, i, h, 2.8840042825456704, j, i, j, 7.064006303021482],
        ],
        &[(Some(-0.9223257450023643), 0.9223257450023643, 0.0)],
        &[
            (2.314663847605748, std::f64::consts::PI),
            (0.21996369592277187, 0.0),
            (1.265618585808401, std::f64::consts::PI),
        ],
    );
    let cases = [
        (&light, 1.1309569481324517, "0+,1+,1+", 2, -2.25925482891254, 2.15440327127944),
        (&resonant, 1.5222943904181907, "0+,0-", 1, -1.186834044833647, 0.948728124754387),
        (&plastic, 3.3029490543811995, "0-,0+", 1, -1.056646728942418, 1.22241981490624),
    ];
    for (structure, omega, word, periods, impulse, radius) in cases {
        let model = LoadedStructure::new(Arc::new(structure.modal().unwrap()), omega).unwrap();
        let mut found = model.orbits(&word.parse().unwrap(), periods).unwrap().orbits;
        // A list may begin an orbit at either impact.
        let away = |orbit: &Orbit| {
            let off = orbit.impacts().iter().map(|impact| (impact.impulse - impulse).abs());
            off.fold(f64::INFINITY, f64::min)
        };
        found.sort_by(|a, b| away(a).total_cmp(&away(b)));
        let orbit = found.first().unwrap();
        let told = orbit.contacts().unwrap().impact_errors().iter().map(|error| error.impulse).fold(0.0, f64::max);
        assert!(away(orbit) <= told + 1e-14 && away(orbit) < 1e-8, "{word}: {:e} {told:e}", away(orbit));
        // Of the third one a multiplier is 0, from which refinement once led to another one.
        let verdict = stability(orbit, Tolerance::Rounding).unwrap().verdict;
        assert!((verdict.spectral_radius - radius).abs() <= verdict.resolution + 1e-14, "{word}: {verdict:?}");
        assert!((verdict.spectral_radius - radius).abs() < 1e-7, "{word}: {verdict:?}");
        assert!(verdict.undecided || verdict.stable == (radius < 1.0), "{word}: {verdict:?}");
    }
}
