//! Large rings: spectra that are complete by certificates which share nothing with the search, in memory that grows like
//! the ring. (Against dense matrices: `map_paths::tests` of `vibrochain-floquet`.)
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain::breather::linear::determinant;
use vibrochain::breather::{Family, Finder, OrbitList};
use vibrochain::floquet::{Analyser, Complex, FloquetError, ImpactSpectrum, ModeLabels, Residues, Secular, Tolerance};
use vibrochain::lattice::{Chain, Model, Point};

type C = Complex<f64>;

fn conservative(sites: usize, gamma2: f64, omega: f64, family: Family) -> (Finder, OrbitList) {
    let model = Model::conservative(Chain::new(sites, 0.2, gamma2).unwrap(), omega, 0.4).unwrap();
    let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
    finder.find_symmetric(&model, family, &mut found).unwrap();
    (finder, found)
}

/// Σ 1/(z−ν) over the roots must be the logarithmic derivative of Π(z−d)·F, at points next to the real axis: a root that
/// is missing, or there twice, leaves a term of about 1/|z−ν|. Returns the largest defect.
fn defect(form: &Residues, roots: &[C]) -> f64 {
    let at = |z: C| {
        let (mut f, mut slope, mut log) = (C::default(), C::default(), C::default());
        for (residue, pole) in form.residues().iter().zip(form.poles()) {
            let inverse = (z - pole).inv();
            f += inverse * residue;
            slope -= inverse * inverse * residue;
            log += inverse;
        }
        let expected = slope / f + log;
        (expected - roots.iter().map(|nu| (z - nu).inv()).sum::<C>()).norm()
    };
    (0..=20).map(|i| at(C::new(0.1 * f64::from(i) - 1.0, 0.04))).fold(0.0, f64::max)
}

fn check(sites: usize, cases: &[(f64, f64)]) {
    let mut secular = Secular::default();
    for &(omega, gamma2) in cases {
        for family in [Family::SingleSided, Family::DoubleSided] {
            let (mut finder, found) = conservative(sites, gamma2, omega, family);
            secular.replace(finder.prepared(&found.orbits[0]).unwrap()).unwrap();
            let name = format!("{family:?} {sites} {omega} {gamma2}");
            // Σ R = 1 and the trace, too.
            let size: f64 = secular.residues().residues().iter().map(|r| r.abs()).sum();
            let (sum, allowed) =
                (secular.residues().sum_defect().abs(), 1e-13 * size * size * (1.0 + 1e-5 * sites as f64));
            assert!(sum < allowed, "{name}: {sum:e} {allowed:e}");
            let roots = secular.roots().unwrap().0.to_vec();
            assert_eq!(roots.len(), sites / 2, "{name}");
            let defect = defect(secular.residues(), &roots);
            assert!(defect < 1e-3, "{name}: {defect:e}");
            // Interlacing: between neighbours of equal sign the number of roots is odd.
            let mut real: Vec<f64> = roots.iter().filter(|nu| nu.im == 0.0).map(|nu| nu.re).collect();
            real.sort_by(f64::total_cmp);
            let form = secular.residues();
            let mut checked = 0;
            for (poles, signs) in form.poles().windows(2).zip(form.residues().windows(2)) {
                // Roots so close to a pole that their sum is rounded to it are left out.
                let margin = 1e-15;
                let below = |x: f64| real.partition_point(|nu| *nu < x);
                let inside = below(poles[1] - margin) - below(poles[0] + margin);
                let around = below(poles[1] + margin) - below(poles[0] - margin);
                if inside == around {
                    assert_eq!(inside % 2 == 1, signs[0] * signs[1] > 0.0, "{name}: {poles:?}");
                    checked += 1;
                }
            }
            assert!(checked > sites * 2 / 5, "{name}: {checked}");
        }
    }
}

/// ω = 0.8: hardly any overlap; 1.5 and below: bands of opposite sign on top of each other, thousands of complex pairs;
/// 0.55 and γ₂ = 0.3: three roots between neighbours of equal sign.
#[test]
fn conservative_spectra_are_complete() {
    check(1001, &[(0.8, 0.1), (1.5, 0.1), (0.6, 0.1), (0.2, 0.1), (0.55, 0.3)]);
    check(6000, &[(0.55, 0.3), (0.27, 0.3)]);
    check(10_001, &[(0.8, 0.1), (1.5, 0.1), (0.6, 0.1), (0.35, 0.1)]);
}

#[test]
fn a_hundred_thousand_sites() {
    check(100_001, &[(0.8, 0.1), (0.6, 0.1)]);
}

#[test]
#[ignore = "a million sites: seconds in release"]
fn slow_a_million_sites() {
    check(1_000_001, &[(0.8, 0.1)]);
    memory(1_000_001);
}

/// What a block of masses takes while it is watched, however large the ring is.
const BLOCKS: u64 = 250_000;

/// The most bytes that the whole way takes at a time, from a model to all multipliers in their order, each with its mode.
fn memory(sites: usize) {
    // Half as many poles as masses, each with its mode, take 72 of them, the fields of far poles 30; or a transform of all masses with
    // the states that it is of and for.
    let most = 140 * sites as u64 + BLOCKS;
    for family in [Family::SingleSided, Family::DoubleSided] {
        let info = allocation_counter::measure(|| {
            let (mut finder, found) = conservative(sites, 0.1, 0.8, family);
            let orbit = &found.orbits[0];
            let _ = finder.admissibility(orbit).unwrap();
            let all = Analyser::default().multipliers(orbit, &mut finder, Tolerance::Rounding).unwrap();
            let mut labels = ModeLabels::new(orbit, &mut finder).unwrap();
            finder.give_back();
            let labelled = all.sorted().filter(|z| labels.mode(*z).is_some()).count();
            assert_eq!(labelled, 2 * sites - 2, "{family:?} {sites}");
        });
        assert!(info.bytes_max < most, "{family:?} {sites}: {} bytes", info.bytes_max);
    }
}

/// The residues of this orbit do not decide its stability, so that the impacts' equations refine the multipliers that may lead. The list holds all
/// multipliers all the same, the refined one among them, and memory stays within what these equations take.
#[test]
fn a_leading_multiplier_that_is_refined_is_one_of_all() {
    let sites = 100_000;
    let info = allocation_counter::measure(|| {
        let (mut finder, found) = conservative(sites, 0.1, 1.5, Family::DoubleSided);
        let all = Analyser::default().multipliers(&found.orbits[0], &mut finder, Tolerance::Rounding).unwrap();
        let leading = all.verdict.leading;
        assert!(leading.norm() > 1.0 && all.verdict.excess() > 0.0);
        let nearest = all.sorted().map(|z| (z - leading).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-6, "{nearest:e}");
        assert_eq!(all.sorted().count(), 2 * sites);
    });
    assert!(info.bytes_max < 300 * sites as u64, "{} bytes", info.bytes_max);
}

/// The condition of an orbit takes one list of the modes that the masses which are hit feel, each with its errors.
#[test]
fn memory_of_a_condition_grows_like_the_ring() {
    for sites in [10_001, 100_001] {
        let (mut finder, found) = conservative(sites, 0.1, 0.8, Family::DoubleSided);
        let info =
            allocation_counter::measure(|| assert!(finder.condition(&found.orbits[0]).unwrap().impulse_error() < 1e-9));
        assert!(info.bytes_max < 250 * sites as u64, "{sites}: {} bytes", info.bytes_max);
    }
}

#[test]
fn memory_grows_like_the_ring() {
    memory(10_001);
    memory(100_001);
}

/// A finder that keeps nothing of a large ring says what a new one does, whatever it is asked for, and in which order.
#[test]
fn what_is_given_back_is_worked_out_again() {
    let (mut finder, found) = conservative(5001, 0.1, 0.8, Family::SingleSided);
    let orbit = &found.orbits[0];
    let condition = Finder::new(5001).condition(orbit).unwrap();
    let admissibility = Finder::new(5001).admissibility(orbit).unwrap();
    assert!(admissibility.is_physical() && condition.fold > 0.1);
    for _ in 0..2 {
        assert_eq!(finder.admissibility(orbit).unwrap(), admissibility);
        assert_eq!(finder.condition(orbit).unwrap(), condition);
        finder.give_back();
        let frequencies = finder.prepared(orbit).unwrap().response().frequencies().len();
        assert_eq!((frequencies, finder.motion(orbit).unwrap().modes().len()), (2501, 2501));
        finder.give_back();
    }
}

/// Πμ = e^{2n}, and Π(z−μ)/Π(z−p) is the determinant of the impacts' equations off the circle.
#[test]
fn forced_spectra_are_complete() {
    let cases = [
        (1401, Family::SingleSided, 0.92, 0.1, 0.9),
        (1401, Family::DoubleSided, 0.7, 0.3, 0.3),
        (1001, Family::DoubleSided, 1.5, 0.1, 0.9),
        (1001, Family::PeriodDoubled, 1.5, 0.3, 0.9),
    ];
    for (sites, family, omega, amplitude, e) in cases {
        let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1);
        let model = ring.omega(omega).asymmetry(0.4).amplitude(amplitude).restitution(e).model().unwrap();
        let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
        finder.find(&model, family, &mut found).unwrap();
        for orbit in &found.orbits {
            let (equations, _) = finder.at_contacts(orbit).unwrap().bloch_equations();
            let ImpactSpectrum { multipliers: values, is_certified, .. } = ImpactSpectrum::new(&equations);
            let name = format!("{family:?} {sites}");
            assert!(is_certified && values.len() == 2 * (sites / 2 + 1), "{name}");
            let log: f64 = values.iter().map(|z| z.norm().ln()).sum();
            let expected = 2.0 * orbit.impacts().len() as f64 * e.ln();
            assert!((log - expected).abs() < 1e-8, "{name}: {log} {expected}");
            let poles: Vec<C> = equations.kernel().modes().iter().flat_map(|mode| mode.poles()).collect();
            for i in 0..12 {
                // f(z) = Π(z−μ)/Π(z−p).
                let z = C::from_polar(if i % 2 == 0 { 0.96 } else { 1.04 }, 0.3 * f64::from(i));
                let f = determinant(&mut equations.matrix(z), equations.size()) * equations.scale();
                let known: C = values.iter().zip(&poles).map(|(mu, p)| (z - mu) / (z - p)).product();
                assert!((known / f - 1.0).norm() < 1e-7, "{name} {z}: {known} {f}");
            }
        }
    }
}

/// The whole way: an orbit checked and judged without a sum over pairs of modes or of sites.
#[test]
fn large_rings_are_judged_without_a_matrix() {
    let forced = Point::ring(4001).gamma1(0.2).gamma2(0.1).omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9);
    let cases = [
        (Model::conservative(Chain::new(20_001, 0.2, 0.1).unwrap(), 0.8, 0.4).unwrap(), Family::SingleSided),
        (forced.model().unwrap(), Family::DoubleSided),
    ];
    for (model, family) in cases {
        let sites = model.chain().sites();
        let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
        finder.find(&model, family, &mut found).unwrap();
        let orbit = &found.orbits[0];
        let admissibility = finder.admissibility(orbit).unwrap();
        let answer = Analyser::default().stability(orbit, &mut finder, Tolerance::Rounding).unwrap();
        assert_eq!((answer.multipliers.len(), answer.verdict.method.name()), (2 * sites, "secular"));
        assert!(!answer.verdict.stable && answer.verdict.resolution < 1e-2 * answer.verdict.excess());
        // The breather is local: a ring of 201 masses has the same margin.
        let small = Chain::new(201, 0.2, 0.1).unwrap();
        let small = match family {
            Family::SingleSided => Model::conservative(small, 0.8, 0.4).unwrap(),
            _ => forced.on(&small).model().unwrap(),
        };
        finder.find(&small, family, &mut found).unwrap();
        let reference = finder.admissibility(&found.orbits[0]).unwrap();
        assert!((admissibility.margin.unwrap() - reference.margin.unwrap()).abs() < 1e-11);
    }
}

/// Where no fast sums are, a bound says how many masses there may be.
#[test]
fn forced_orbits_of_too_many_masses_are_refused() {
    let ring = Point::ring(5001).gamma1(0.2).gamma2(0.1);
    let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
    let (mut finder, mut found) = (Finder::new(5001), OrbitList::default());
    finder.find(&model, Family::DoubleSided, &mut found).unwrap();
    let error = Analyser::default().verdict(&found.orbits[0], &mut finder, Tolerance::Rounding).unwrap_err();
    assert_eq!(error, FloquetError::TooManyModes { masses: 5001, impacts: 2, limit: 4999 });
}
