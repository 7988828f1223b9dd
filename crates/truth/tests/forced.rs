//! Errors that are claimed for all multipliers of impacts at one site under a force, held against many digits.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Family, Finder, Orbit, OrbitList};
use vibrochain_floquet::{Analyser, Complex, ImpactSpectrum, Method, Tolerance};
use vibrochain_lattice::{Chain, Model, Parameter};
use vibrochain_testkit::Values::Log;
use vibrochain_testkit::{Meeting, Random, Ranges, equations_as_given};
use vibrochain_truth::{DEFAULT_BITS, Real, TrueOrbit, TrueSpectrum};

/// Where random orbits are looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    Anywhere,
    /// Ω_k ± Ω_l = jω up to 1e-14 … 1e-2: coincident poles, stripes of instability.
    Stripe,
    /// Ω_k = jω likewise.
    Resonance,
    /// The uniform motion alone just reaches, or just misses, a barrier.
    Grazing,
}

fn model_at(random: &mut Random, place: Place, largest: usize) -> Option<Model> {
    let model = random.model(&Ranges { sites: [1, largest], ..Ranges::FORCED });
    let meeting = match place {
        Place::Anywhere => return Some(model),
        Place::Grazing => {
            let reach = (1.0 - model.asymmetry()) * (model.chain().gamma1() - model.omega().powi(2)).abs();
            return model.with(Parameter::Amplitude, random.beside(reach, Log(1e-10, 0.1))).ok();
        }
        Place::Resonance => Meeting::Mode,
        Place::Stripe => random.of(&[Meeting::Sum, Meeting::Sum, Meeting::Difference]),
    };
    let omega = random.meeting(model.chain(), meeting, 4, Log(1e-14, 1e-2));
    model.with(Parameter::Omega, omega).ok().filter(|_| omega >= 0.2)
}

/// How far `z` is from the multiplier next to it; `None` where that is not to be had.
fn true_error(spectrum: &TrueSpectrum, z: Complex<f64>) -> Option<f64> {
    let (root, _) = spectrum.refine((z.re, z.im)).ok()?;
    let (re, im) = (&root.re - z.re, &root.im - z.im);
    Some((&re * &re + &im * &im).sqrt().to_f64())
}

/// What was found on the way: claimed error over true one, for each multiplier looked at.
#[derive(Default)]
struct Ratios {
    values: Vec<f64>,
    /// Multipliers of which hardly more than the size is claimed: many digits may find another one than is meant.
    vague: usize,
}

impl Ratios {
    fn add(&mut self, claimed: f64, truth: f64) {
        self.values.push(claimed / truth.max(f64::MIN_POSITIVE));
    }

    fn quantile(&mut self, part: f64) -> f64 {
        self.values.sort_by(f64::total_cmp);
        self.values.get(((self.values.len().max(1) - 1) as f64 * part) as usize).copied().unwrap_or(0.0)
    }

    fn print(&mut self, name: &str) {
        let [least, median, most, worst] = [0.0, 0.5, 0.99, 1.0].map(|part| self.quantile(part));
        println!(
            "{name}: {} multipliers, {least:.1} at least, {median:.0} median, {most:.1e} 99 %, {worst:.1e} at most, {} vague",
            self.values.len(),
            self.vague
        );
    }
}

/// The leading multiplier and a few others.
fn compare(orbit: &Orbit, ratios: &mut Ratios, every: usize) {
    let equations = equations_as_given(orbit);
    let ImpactSpectrum { multipliers: values, errors, is_certified: true } = ImpactSpectrum::new(&equations) else {
        return;
    };
    let spectrum = TrueSpectrum::as_given(orbit, 160).unwrap();
    let mut all: Vec<_> = values.iter().zip(&errors).collect();
    all.sort_by(|a, b| b.0.norm().total_cmp(&a.0.norm()));
    for (z, error) in all.iter().step_by(every) {
        if **error > 1e-3 * z.norm() {
            ratios.vague += 1;
            continue;
        }
        let Some(truth) = true_error(&spectrum, **z) else { continue };
        assert!(
            truth <= **error,
            "{z} of {:?}, {:?}: wrong by {truth:e}, claimed {error:e}",
            orbit.model(),
            orbit.family()
        );
        ratios.add(**error, truth.max(0.5 * f64::EPSILON * z.norm()));
    }
}

const FAMILIES: [Family; 3] = [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled];

fn claims_hold(draws: usize) {
    let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
    let places = [Place::Anywhere, Place::Stripe, Place::Resonance, Place::Grazing];
    for (seed, place) in places.into_iter().enumerate() {
        let mut random = Random(71 + seed as u64);
        let mut ratios = Ratios::default();
        let mut orbits = 0;
        for _ in 0..draws {
            let Some(model) = model_at(&mut random, place, 40) else { continue };
            let family = random.of(&FAMILIES);
            if finder.find_symmetric(&model, family, &mut found).is_err() {
                continue;
            }
            for orbit in found.orbits.iter().take(2) {
                orbits += 1;
                compare(orbit, &mut ratios, 7);
            }
        }
        ratios.print(&format!("{place:?}, {orbits} orbits"));
        assert!(orbits > draws / 3 && ratios.values.len() > orbits, "{place:?}: {orbits} {}", ratios.values.len());
        assert!(50 * ratios.vague < ratios.values.len(), "{place:?}: {}", ratios.vague);
        assert!(ratios.quantile(0.5) < 100.0, "{place:?}: {}", ratios.quantile(0.5));
    }
}

#[test]
fn no_multiplier_is_farther_off_than_is_claimed() {
    claims_hold(50);
}

/// `cargo test --release -p vibrochain-truth --test forced -- --ignored --nocapture`
#[test]
#[ignore = "minutes"]
fn slow_no_multiplier_of_many_thousand_is_farther_off_than_is_claimed() {
    claims_hold(4000);
}

/// The paper's map of forced breathers for N = 20, 40 and 100: how many orbits the dense matrix has to judge, and how much
/// is claimed of errors. `cargo test --release -p vibrochain-truth --test forced -- --ignored --nocapture`
#[test]
#[ignore = "a minute"]
fn slow_the_map_of_the_paper_needs_no_dense_matrix() {
    for (sites, columns, rows) in [(21, 65, 50), (41, 65, 50), (101, 40, 30)] {
        let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
        let mut analyser = Analyser::default();
        let mut ratios = Ratios::default();
        let (mut count, mut dense, mut single, mut dense_single) = (0, 0, 0, 0);
        for i in 0..columns {
            for j in 1..rows {
                let omega = 0.4 + 2.6 * f64::from(i) / f64::from(columns - 1);
                let chain = Chain::new(sites, 0.2, 0.3 * f64::from(j) / f64::from(rows - 1)).unwrap();
                let model = chain.point().omega(omega).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
                for family in [Family::DoubleSided, Family::SingleSided] {
                    if finder.find(&model, family, &mut found).is_err() {
                        continue;
                    }
                    for orbit in &found.orbits {
                        let by_matrix = |method: Method| usize::from(method != Method::Secular);
                        count += 1;
                        let sweep = analyser.verdict(orbit, &mut finder, Tolerance::Rounding).unwrap();
                        dense += by_matrix(sweep.method);
                        if count % 7 == 0 {
                            single += 1;
                            let answer = analyser.stability(orbit, &mut finder, Tolerance::Rounding).unwrap();
                            dense_single += by_matrix(answer.verdict.method);
                        }
                        if count % 53 == 0 {
                            compare(orbit, &mut ratios, 7);
                        }
                    }
                }
            }
        }
        println!(
            "N = {}: dense for {dense} of {count} in a sweep, for {dense_single} of {single} one by one",
            sites - 1
        );
        ratios.print("  claimed over true error");
        assert!(100 * dense < count && 100 * dense_single < single);
    }
}

/// With the errors of the orbit itself: the spectral radius against that of the orbit in many digits.
#[test]
fn no_spectral_radius_is_farther_off_than_is_claimed() {
    let (mut finder, mut found, mut analyser) = (Finder::new(21), OrbitList::default(), Analyser::default());
    let mut random = Random(99);
    let mut ratios = Ratios::default();
    for draw in 0..160 {
        let place = [Place::Anywhere, Place::Stripe, Place::Resonance, Place::Grazing][draw % 4];
        let Some(model) = model_at(&mut random, place, 24) else { continue };
        let family = random.of(&FAMILIES);
        if finder.find_symmetric(&model, family, &mut found).is_err() {
            continue;
        }
        let Some(orbit) = found.orbits.first() else { continue };
        let verdict = analyser.stability(orbit, &mut finder, Tolerance::Rounding).unwrap().verdict;
        let Ok(truth) = TrueOrbit::refine(orbit, DEFAULT_BITS) else { continue };
        if verdict.method != Method::Secular || verdict.resolution == 0.0 {
            continue;
        }
        let spectrum = TrueSpectrum::new(&truth).unwrap();
        let Ok((root, _)) = spectrum.refine((verdict.leading.re, verdict.leading.im)) else { continue };
        let off = (root.abs() - Real::new(verdict.excess(), DEFAULT_BITS) - 1.0).abs().to_f64();
        assert!(off <= verdict.resolution, "{model:?} {family:?}: {verdict:?} is off by {off:e}");
        ratios.add(verdict.resolution, off.max(0.5 * f64::EPSILON * verdict.spectral_radius));
    }
    ratios.print("with the orbit's errors");
    assert!(ratios.values.len() > 60 && ratios.quantile(0.5) < 1e3, "{}", ratios.values.len());
}
