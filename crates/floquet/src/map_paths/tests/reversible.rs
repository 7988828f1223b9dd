//! Verdicts and roots of reversible orbits.

use vibrochain_breather::{Family, Finder, OrbitList};
use vibrochain_lattice::{Chain, ImpulseResponse, Model, Spectrum};

use super::*;
use crate::map_paths::{Reason, Secular, SecularVerdict, Standing};

#[derive(Default)]
struct Bench {
    finder: Option<Finder>,
    found: OrbitList,
    secular: Secular,
    checked: usize,
    doubts: usize,
    undecided: usize,
    rootless: usize,
    unstable: usize,
}

impl Bench {
    /// Verdict and all roots of a model's orbit against the dense block.
    fn check(&mut self, model: &Model, family: Family) {
        let finder = self.finder.get_or_insert_with(|| Finder::new(21));
        if finder.find_symmetric(model, family, &mut self.found).is_err() {
            return;
        }
        for orbit in &self.found.orbits {
            let (values, norm) = dense(orbit, finder);
            let prepared = finder.prepared(orbit).unwrap();
            let error = dense_error(norm, prepared.response().condition());
            self.checked += 1;
            let name = || format!("{family:?} {model:?}");
            if self.secular.replace(prepared).is_err() {
                self.doubts += 1;
                continue;
            }
            let leading = values.iter().copied().max_by(|a, b| excess(*a).total_cmp(&excess(*b)));
            let (radius, blur) = leading.map_or((0.0, 0.0), |nu| (excess(nu), excess_error(nu, excess(nu), error)));
            let verdict = match self.secular.verdict() {
                Ok(verdict) => verdict,
                Err(_) => {
                    self.doubts += 1;
                    continue;
                }
            };
            match verdict.outcome {
                Standing::Stable => assert!(radius <= blur, "{}: {verdict:?}, dense {radius:e} ± {blur:e}", name()),
                Standing::Undecided => {
                    self.undecided += 1;
                    assert!(radius <= verdict.excess + blur, "{}: {verdict:?}, dense {radius:e} ± {blur:e}", name());
                }
                Standing::Unstable => {
                    self.unstable += 1;
                    let difference = (verdict.excess - radius).abs();
                    // The dense solver's error where it sees no instability at all: a pair on the axis.
                    let blur = blur.max(error.sqrt() * f64::from(u8::from(radius < error.sqrt())));
                    assert!(
                        difference <= 10.0 * (blur + verdict.excess_error),
                        "{}: {verdict:?}, dense {radius:e} ± {blur:e}",
                        name()
                    );
                }
            }
            let Ok((roots, errors)) = self.secular.roots() else {
                self.rootless += 1;
                continue;
            };
            assert_eq!(roots.len(), values.len());
            let largest = errors.iter().copied().fold(0.0, f64::max);
            // Roots that meet part like a square root.
            let allowed = error.sqrt() + 10.0 * largest;
            let distance = farthest(roots, &values).max(farthest(&values, roots));
            assert!(distance <= allowed, "{}: roots off by {distance:e} where {allowed:e} is granted", name());
        }
    }
}

#[test]
fn verdicts_and_roots_are_those_of_the_dense_block() {
    let mut random = Random(1);
    let mut bench = Bench::default();
    for i in 0..12_000 {
        let sites = 1 + (random.unit() * 40.0) as usize;
        let (g1, g2) = (random.log(0.01, 1.0), random.log(1e-3, 1.0));
        let model = model(sites, g1, g2, random.between(0.3, 3.0), random.between(0.0, 0.9)).unwrap();
        bench.check(&model, BOTH[i % 2]);
    }
    assert!(bench.checked > 11_900 && bench.unstable > 2000, "{}", bench.unstable);
    assert!(
        bench.doubts < 12 && bench.undecided < 12 && bench.rootless == 0,
        "{} doubts, {} undecided",
        bench.doubts,
        bench.undecided
    );
}

#[test]
fn stripes_of_instability_and_resonances_up_close() {
    let mut random = Random(2);
    let mut bench = Bench::default();
    for i in 0..6000 {
        let sites = 3 + (random.unit() * 30.0) as usize;
        let (g1, g2) = (random.log(0.01, 1.0), random.log(1e-3, 1.0));
        let frequencies = Spectrum::new(Chain::new(sites, g1, g2).unwrap()).frequencies().to_vec();
        let mut pick = || frequencies[(random.unit() * frequencies.len() as f64) as usize];
        // Ω_k + Ω_l = jω, Ω_k − Ω_l = jω, Ω_k = jω, each to within 1e-1 … 1e-12.
        let target = match i % 3 {
            0 => pick() + pick(),
            1 => (pick() - pick()).abs().max(0.1),
            _ => pick(),
        };
        let harmonic = (1.0 + random.unit() * 4.0).floor();
        let detuning = random.log(1e-12, 0.1) * (random.unit() - 0.5).signum();
        let a = random.between(0.0, 0.9);
        for family in BOTH {
            bench.check(&model(sites, g1, g2, target / harmonic * (1.0 + detuning), a).unwrap(), family);
        }
    }
    assert!(bench.checked > 11_000 && bench.unstable > 1000 && bench.rootless < 12);
    assert!(bench.doubts < bench.checked / 2);
}

#[test]
fn next_to_grazing() {
    let mut random = Random(3);
    let mut bench = Bench::default();
    for _ in 0..2000 {
        let sites = 2 + (random.unit() * 30.0) as usize;
        let (g1, g2, omega) = (random.log(0.01, 1.0), random.log(1e-3, 1.0), random.between(0.3, 3.0));
        let chain = Chain::new(sites, g1, g2).unwrap();
        let response = ImpulseResponse::new(&Spectrum::new(chain), omega).unwrap();
        let (chi2, chi1) = (-2.0 * response.value(0, 0.0), -2.0 * response.value(0, 0.5 * response.period()));
        // p₁ = 1/(χ₂−χ₁) − a/(χ₁+χ₂) vanishes here.
        let grazing = ((chi1 + chi2) / (chi2 - chi1)).abs();
        let a = grazing * (1.0 + random.log(1e-8, 0.1) * (random.unit() - 0.5).signum());
        if a < 1.0 {
            bench.check(&model(sites, g1, g2, omega, a).unwrap(), Family::DoubleSided);
        }
    }
    assert!(bench.checked > 400 && bench.unstable > 300 && bench.doubts < bench.checked / 3);
}

#[test]
fn rings_that_hardly_anything_holds() {
    let mut random = Random(8);
    let mut bench = Bench::default();
    for i in 0..1500 {
        let sites = 2 + (random.unit() * 30.0) as usize;
        let g1 = if i % 3 == 0 { 0.0 } else { random.log(1e-14, 1e-3) };
        let (g2, omega) = (random.log(1e-3, 1.0), random.between(0.3, 3.0));
        // (Single-sided, the dense block is the one in error: the orbit's acceleration is all cancellation.)
        bench.check(&model(sites, g1, g2, omega, random.between(0.0, 0.9)).unwrap(), Family::DoubleSided);
    }
    assert!(bench.checked > 1400 && bench.unstable > 100 && bench.doubts < 50);
}

#[test]
fn hardly_coupled_masses_are_stable_beyond_doubt() {
    let mut random = Random(4);
    let (mut finder, mut found, mut secular) = (Finder::new(21), OrbitList::default(), Secular::default());
    let mut checked = 0;
    for i in 0..2000 {
        let sites = 2 + (random.unit() * 40.0) as usize;
        let g1 = random.log(0.01, 1.0);
        let g2 = if i % 10 == 0 { 0.0 } else { g1 * random.log(1e-20, 1e-8) };
        let model = model(sites, g1, g2, random.between(0.3, 3.0), random.between(0.0, 0.9)).unwrap();
        for family in BOTH {
            let response = ImpulseResponse::new(&Spectrum::new(*model.chain()), model.omega());
            if response.is_err() || response.is_ok_and(|response| response.condition() > 1e4) {
                continue;
            }
            if finder.find_symmetric(&model, family, &mut found).is_err() {
                continue;
            }
            for orbit in &found.orbits {
                secular.replace(finder.prepared(orbit).unwrap()).unwrap();
                let verdict = secular.verdict().unwrap();
                assert_eq!(verdict.outcome, Standing::Stable, "{family:?} {model:?}");
                assert_eq!(secular.roots().unwrap().0.len(), sites / 2);
                checked += 1;
            }
        }
    }
    assert!(checked > 3500, "{checked}");
}

/// Beyond a collision the excess is proportional to the square root of the distance from it. An excess of 1e-9 must obey this law; a dense
/// solver obeys it down to 1e-7 only.
#[test]
fn excess_far_below_the_resolution_of_dense_solvers() {
    let (mut finder, mut found, mut secular) = (Finder::new(21), OrbitList::default(), Secular::default());
    let mut at = |omega: f64| {
        let model = model(21, 0.2, 0.1, omega, 0.4).unwrap();
        finder.find_symmetric(&model, Family::SingleSided, &mut found).unwrap();
        secular.replace(finder.prepared(&found.orbits[0]).unwrap()).unwrap();
        secular.verdict().ok()
    };
    let (mut edges, mut smallest) = (0, 1.0_f64);
    for i in 0..400 {
        let (mut low, mut high) = (0.7 + 0.0005 * f64::from(i), 0.7 + 0.0005 * f64::from(i + 1));
        let (a, b) = (at(low), at(high));
        let pair = |v: &SecularVerdict| v.reason == Reason::ComplexPair;
        let (Some(a), Some(b)) = (a, b) else { continue };
        if pair(&a) == pair(&b) || (a.outcome == Standing::Unstable) == (b.outcome == Standing::Unstable) {
            continue;
        }
        let rising = pair(&b);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if at(middle).is_some_and(|v| pair(&v)) == rising { &mut high } else { &mut low }) = middle;
        }
        let (edge, direction) = if rising { (high, 1.0) } else { (low, -1.0) };
        let Some(coarse) = at(edge + direction * 1e-9) else { continue };
        for h in [1e-10, 1e-11, 1e-12, 1e-13] {
            let Some(verdict) = at(edge + direction * h) else { continue };
            if verdict.excess_error > 0.02 * verdict.excess {
                continue;
            }
            assert_eq!(verdict.outcome, Standing::Unstable, "{edge} {h:e} {verdict:?}");
            let law = (verdict.excess / coarse.excess).powi(2) / (h / 1e-9);
            assert!((law - 1.0).abs() < 0.2, "{edge} {h:e}: {law} {verdict:?}");
            smallest = smallest.min(verdict.excess);
        }
        edges += 1;
    }
    assert!(edges >= 3 && smallest < 1e-5, "{edges} {smallest:e}");
}
