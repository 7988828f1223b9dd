//! Stability without matrices against the table of checked numbers and against the dense monodromy matrix.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::cell::Cell;

use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use vibrochain::breather::{Family, Finder, Orbit, OrbitList};
use vibrochain::floquet::{
    Analyser, Complex, Mechanism, Method, ModalShape, Secular, Tolerance, Verdict, even_monodromy, full_monodromy,
    stability,
};
use vibrochain::lattice::{Chain, ImpulseResponse, Model, Parameter, Point, Spectrum};
use vibrochain_testkit::Values::Log;
use vibrochain_testkit::{Meeting, Random, Ranges, reference};

/// The verdict of secular functions alone.
fn verdict(orbit: &Orbit, finder: &mut Finder) -> Option<Verdict> {
    let verdict = Analyser::default().verdict(orbit, finder, Tolerance::Rounding).unwrap();
    Some(verdict).filter(|verdict| verdict.method == Method::Secular)
}

#[test]
fn spectral_radii_of_the_table() {
    let mut answered = 0;
    for case in reference() {
        let (name, model, family) = (&case.name, case.model, case.family);
        let (mut finder, mut found) = (Finder::new(model.chain().sites()), OrbitList::default());
        finder.find(&model, family, &mut found).unwrap();
        let mut impulses: Vec<f64> = ["p", "p1", "p2"].iter().filter_map(|key| case.number(key)).collect();
        impulses.sort_by(f64::total_cmp);
        let orbit = found.orbits.iter().find(|orbit| {
            let mut own: Vec<f64> = orbit.impacts().iter().map(|impact| 0.5 * impact.impulse.abs()).collect();
            own.sort_by(f64::total_cmp);
            own.iter().zip(&impulses).all(|(a, b)| (a - b).abs() < 1e-9)
        });
        let Some(verdict) = verdict(orbit.unwrap(), &mut finder) else { continue };
        let radius = case.number("spectral_radius").unwrap();
        if verdict.mechanism.is_some() {
            let error = (verdict.spectral_radius / radius - 1.0).abs();
            assert!(error < if radius > 1000.0 { 1e-6 } else { 1e-9 }, "{name}: {verdict:?}, table {radius}");
            let table = &case.values["leading_multiplier"];
            let leading = Complex::new(table[0].as_f64().unwrap(), table[1].as_f64().unwrap());
            assert_eq!(Mechanism::of(verdict.leading), Mechanism::of(leading), "{name}");
        } else if verdict.undecided {
            assert!((radius - 1.0).abs() < 1e-6, "{name}: {verdict:?}, table {radius}");
        } else {
            assert!(radius < 1.0 + 1e-9, "{name}: {verdict:?}, table {radius}");
        }
        answered += 1;
    }
    assert!(answered >= 25, "{answered}");
}

/// μ and 1/μ of a root ν, by the plain quadratic formula.
fn multipliers(nu: Complex<f64>) -> [Complex<f64>; 2] {
    let root = (nu * nu - 1.0).sqrt();
    [nu + root, nu - root]
}

fn conservative() -> impl Strategy<Value = Model> {
    (1usize..24, 0.02..1.0, 1e-3..0.5, 0.3..4.0, 0.0..0.95).prop_filter_map("valid", |(sites, g1, g2, omega, a)| {
        Model::conservative(Chain::new(sites, g1, g2).ok()?, omega, a).ok()
    })
}

/// Poles 3e-5 apart, next to which others keep eight digits: the errors that go with the roots say it.
#[test]
fn roots_beside_poles_that_nearly_coincide_claim_their_errors() {
    let chain = Chain::new(7, 0.059365345946162086, 0.42239713461123557).unwrap();
    let model = Model::conservative(chain, 1.9048140666056042, 0.0).unwrap();
    let (mut finder, mut found, mut secular) = (Finder::new(7), OrbitList::default(), Secular::default());
    finder.find_symmetric(&model, Family::DoubleSided, &mut found).unwrap();
    secular.replace(finder.prepared(&found.orbits[0]).unwrap()).unwrap();
    let (roots, errors) = secular.roots().unwrap();
    let trace = even_monodromy(&found.orbits[0]).unwrap().trace();
    let sum: f64 = 2.0 + 2.0 * roots.iter().map(|nu| nu.re).sum::<f64>();
    let claimed: f64 = 2.0 * errors.iter().sum::<f64>();
    assert!((sum - trace).abs() <= claimed + 1e-12 && claimed < 1e-4, "{sum} {trace} {claimed:e}");
}

/// Power sums of the multipliers from the roots, the trivial pair added, against traces of the dense matrix's powers.
#[test]
fn roots_have_the_power_sums_of_the_monodromy_matrix() {
    let checked = Cell::new(0);
    let config = ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() };
    let checks = |model: Model| {
        let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
        let mut secular = Secular::default();
        for family in [Family::SingleSided, Family::DoubleSided] {
            let response = ImpulseResponse::new(&Spectrum::new(*model.chain()), model.omega());
            if response.is_err() || response.is_ok_and(|response| response.condition() > 1e3) {
                continue;
            }
            if finder.find_symmetric(&model, family, &mut found).is_err() {
                continue;
            }
            for orbit in &found.orbits {
                if secular.replace(finder.prepared(orbit).unwrap()).is_err() {
                    continue;
                }
                let Ok((roots, errors)) = secular.roots() else { continue };
                // Between poles that nearly coincide roots have fewer digits, and say so.
                let claimed: f64 = errors.iter().sum();
                let all: Vec<_> =
                    roots.iter().flat_map(|nu| multipliers(*nu)).chain([Complex::new(1.0, 0.0); 2]).collect();
                let matrix = even_monodromy(orbit).unwrap();
                prop_assert_eq!(all.len(), matrix.nrows());
                let scale = matrix.norm();
                let square = &matrix * &matrix;
                let cube = &square * &matrix;
                for (power, trace) in [(1, matrix.trace()), (2, square.trace()), (3, cube.trace())] {
                    let sum: Complex<f64> = all.iter().map(|mu| mu.powi(power)).sum();
                    let error = (sum - trace).norm();
                    // μ^p + μ^−p = 2T_p(ν) changes with ν by 2p² at most on the circle.
                    let allowed = 1e-10 * (1.0 + scale) + 2.0 * f64::from(power * power) * claimed;
                    prop_assert!(error < allowed * scale.powi(power), "{family:?} {power}: {sum} {trace}");
                }
                checked.set(checked.get() + 1);
            }
        }
        Ok(())
    };
    TestRunner::new(config).run(&conservative(), checks).unwrap();
    // A family has an orbit at most points, and its roots are known at nearly all.
    assert!(checked.get() > 400, "{}", checked.get());
}

#[test]
fn the_shape_of_the_unstable_perturbation_is_an_eigenvector_of_the_dense_matrix() {
    let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
    let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
    finder.find(&model, Family::DoubleSided, &mut found).unwrap();
    assert!(!found.orbits.is_empty());
    for orbit in &found.orbits {
        let leading = stability(orbit, Tolerance::Rounding).unwrap().multipliers[0];
        let (displacement, velocity) =
            ModalShape::new(&finder.at_contacts(orbit).unwrap(), leading).unwrap().at_sites(21, 0);
        // M (u, v) = μ (u, v) for the matrix of the whole ring.
        let matrix = full_monodromy(orbit).unwrap();
        let state: Vec<_> = displacement.iter().chain(&velocity).copied().collect();
        let size = state.iter().map(|z| z.norm()).fold(0.0, f64::max);
        for row in 0..42 {
            let image: Complex<f64> = (0..42).map(|column| state[column] * matrix[(row, column)]).sum();
            assert!((image - leading * state[row]).norm() < 1e-11 * size * matrix.norm());
        }
    }
}

/// Where random orbits are looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    Anywhere,
    /// Ω_k ± Ω_l = jω or Ω_k = jω up to 1e-15 … 1e-3: coincident poles, stripes of instability, resonance.
    Resonant,
    /// An impact grazes, up to 1e-10 … 0.1.
    Grazing,
}

fn model_at(random: &mut Random, place: Place, forced: bool) -> Option<Model> {
    let kind = if forced { Ranges::FORCED } else { Ranges::CONSERVATIVE };
    let model = random.model(&Ranges { sites: [1, 30], ..kind });
    let chain = model.chain();
    match place {
        Place::Anywhere => Some(model),
        Place::Resonant => {
            let meeting = random.of(&[Meeting::Sum, Meeting::Difference, Meeting::Mode]);
            let omega = random.meeting(chain, meeting, 4, Log(1e-15, 1e-3));
            model.with(Parameter::Omega, omega).ok().filter(|_| omega >= 0.2)
        }
        Place::Grazing => {
            let response = ImpulseResponse::new(&Spectrum::new(*chain), model.omega()).ok()?;
            let (chi2, chi1) = (-2.0 * response.value(0, 0.0), -2.0 * response.value(0, 0.5 * response.period()));
            // p₁ = 1/(χ₂−χ₁) − a/(χ₁+χ₂) vanishes here.
            let a = ((chi1 + chi2) / (chi2 - chi1)).abs();
            model.with(Parameter::Asymmetry, random.beside(a, Log(1e-10, 0.1))).ok()
        }
    }
}

/// Verdicts of sweeps and of single orbits against the dense path, whose thorough verdict knows its own error. Returns how
/// many were compared, fell back, and were unstable.
fn against_dense(seed: u64, draws: usize, place: Place, forced: bool) -> [usize; 3] {
    let mut random = Random(seed);
    let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
    let (mut analyser, mut dense) = (Analyser::default(), Analyser::dense());
    let (mut compared, mut fallen, mut unstable) = (0, 0, 0);
    for _ in 0..draws {
        let Some(model) = model_at(&mut random, place, forced) else { continue };
        for family in [Family::DoubleSided, Family::SingleSided] {
            if finder.find_symmetric(&model, family, &mut found).is_err() {
                continue;
            }
            // Hundreds of forced solutions at one point are alike.
            for orbit in found.orbits.iter().take(4) {
                let Ok(reference) = dense.stability(orbit, &mut finder, Tolerance::Rounding) else { continue };
                let reference = reference.verdict;
                let sweep = analyser.verdict(orbit, &mut finder, Tolerance::Rounding).unwrap();
                let thorough = analyser.stability(orbit, &mut finder, Tolerance::Rounding).unwrap();
                assert_eq!(thorough.multipliers.len(), 2 * model.chain().sites());
                compared += 1;
                fallen += usize::from(sweep.method == Method::Dense);
                for own in [sweep, thorough.verdict] {
                    if own.method != Method::Secular {
                        continue;
                    }
                    let name = || format!("{model:?} {family:?}: {own:?}, dense {reference:?}");
                    let certain = !own.undecided && !reference.undecided;
                    // A dense verdict next to the circle is right up to its resolution; below it the excess is the form's own.
                    let hidden = own.excess() <= reference.resolution.max(1e-7 * reference.spectral_radius);
                    if certain && own.stable != reference.stable {
                        assert!(own.mechanism.is_some() && reference.stable && hidden, "{}", name());
                        continue;
                    }
                    let difference = (own.spectral_radius - reference.spectral_radius).abs();
                    let allowed = 1e-9 * reference.spectral_radius + 10.0 * (own.resolution + reference.resolution);
                    assert!(difference <= allowed, "{}: {difference:e}", name());
                    if certain && own.excess() > 1e-5 {
                        unstable += 1;
                        assert_eq!(own.mechanism, reference.mechanism, "{}", name());
                    }
                }
            }
        }
    }
    [compared, fallen, unstable]
}

fn against_dense_everywhere(draws: usize) {
    for (forced, places) in
        [(false, &[Place::Anywhere, Place::Resonant, Place::Grazing][..]), (true, &[Place::Anywhere, Place::Resonant])]
    {
        for (seed, &place) in places.iter().enumerate() {
            let draws = if forced { draws / 4 } else { draws };
            let [compared, fallen, unstable] = against_dense(seed as u64, draws, place, forced);
            println!("{place:?}, forced {forced}: {compared} compared, {fallen} fell back, {unstable} unstable");
            assert!(compared > draws / 4 && unstable > compared / 20, "{place:?} {compared} {unstable}");
            if place == Place::Anywhere {
                assert!(fallen < compared / 10, "{fallen} of {compared}");
            }
        }
    }
}

#[test]
fn no_verdict_differs_from_the_dense_one_beyond_its_error() {
    against_dense_everywhere(2000);
}

/// Poles that coincide to 14 digits, residues of 10¹⁸ that cancel: signs at ±1 were noise, and "all roots" were none.
#[test]
fn residues_that_cancel_prove_nothing() {
    let chain = Chain::new(18, 0.11539980741875569, 0.40144460760567563).unwrap();
    let model = Model::conservative(chain, 0.47770963682116213, 0.6273051865440096).unwrap();
    let (mut finder, mut found) = (Finder::new(18), OrbitList::default());
    finder.find_symmetric(&model, Family::DoubleSided, &mut found).unwrap();
    let mut analyser = Analyser::default();
    let sweep = analyser.verdict(&found.orbits[0], &mut finder, Tolerance::Rounding).unwrap();
    let thorough = analyser.stability(&found.orbits[0], &mut finder, Tolerance::Rounding).unwrap().verdict;
    for verdict in [sweep, thorough] {
        // To 57 digits |μ| = 1.26131997404794727….
        assert!((verdict.spectral_radius - 1.2613199740479473).abs() < 1e-12, "{verdict:?}");
        assert_eq!(verdict.mechanism, Some(Mechanism::NeimarkSacker));
    }
}

/// The same for 10⁵ orbits and more: `cargo test --release --test secular -- --ignored --nocapture`.
#[test]
#[ignore = "minutes"]
fn slow_no_verdict_of_a_hundred_thousand_differs_from_the_dense_one() {
    against_dense_everywhere(40_000);
}
