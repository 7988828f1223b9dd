//! Stability without matrices against the table of checked numbers and against the dense monodromy matrix.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod support;

use proptest::prelude::*;
use serde_json::Value;
use support::dense;
use vibrochain::breather::{Family, Finder, Found, Orbit};
use vibrochain::floquet::{
    Complex, ForcedSecular, Mechanism, ModalShape, Outcome, Secular, SecularMultipliers, SecularVerdict, even_monodromy,
};
use vibrochain::lattice::{Chain, Model};

fn verdict(orbit: &Orbit, finder: &mut Finder) -> Option<SecularVerdict> {
    finder.motion(orbit).unwrap();
    if orbit.is_reversible() {
        let mut secular = Secular::default();
        secular.set(orbit, finder.response()).ok()?;
        secular.verdict().ok()
    } else {
        ForcedSecular::default().verdict(orbit, finder.response()).ok()
    }
}

#[test]
fn spectral_radii_of_the_table() {
    let table: Value = serde_json::from_str(include_str!("data/reference.json")).unwrap();
    let mut answered = 0;
    for case in table["cases"].as_array().unwrap() {
        let get = |name: &str| case["parameters"][name].as_f64();
        let sites = case["parameters"]["sites"].as_u64().unwrap() as usize;
        let chain = Chain::new(sites, get("gamma1").unwrap(), get("gamma2").unwrap()).unwrap();
        let (amplitude, restitution) = (get("amplitude").unwrap_or(0.0), get("restitution").unwrap_or(1.0));
        let (omega, a) = (get("omega").unwrap(), get("asymmetry").unwrap());
        let model = Model::forced(chain, omega, a, amplitude, restitution).unwrap();
        let doubled = (case["period"].as_f64().unwrap() / model.period()).round() == 2.0;
        let family = match (case["p"].as_f64(), doubled) {
            (Some(_), _) => Family::SingleSided,
            (None, true) => Family::PeriodDoubled,
            (None, false) => Family::DoubleSided,
        };
        let (mut finder, mut found) = (Finder::new(sites), Found::default());
        finder.find(&model, family, &mut found).unwrap();
        let mut impulses: Vec<f64> = ["p", "p1", "p2"].iter().filter_map(|key| case[*key].as_f64()).collect();
        impulses.sort_by(f64::total_cmp);
        let orbit = found.orbits.iter().find(|orbit| {
            let mut own: Vec<f64> = orbit.impacts().iter().map(|impact| 0.5 * impact.impulse.abs()).collect();
            own.sort_by(f64::total_cmp);
            own.iter().zip(&impulses).all(|(a, b)| (a - b).abs() < 1e-9)
        });
        let name = case["name"].as_str().unwrap();
        let Some(verdict) = verdict(orbit.unwrap(), &mut finder) else { continue };
        let radius = case["spectral_radius"].as_f64().unwrap();
        match verdict.outcome {
            Outcome::Unstable => {
                let error = (verdict.spectral_radius() / radius - 1.0).abs();
                assert!(error < if radius > 1000.0 { 1e-6 } else { 1e-9 }, "{name}: {verdict:?}, table {radius}");
                let table = &case["leading_multiplier"];
                let leading = Complex::new(table[0].as_f64().unwrap(), table[1].as_f64().unwrap());
                assert_eq!(Mechanism::of(verdict.leading.unwrap()), Mechanism::of(leading), "{name}");
            }
            Outcome::Stable => assert!(radius < 1.0 + 1e-9, "{name}: {verdict:?}, table {radius}"),
            Outcome::Marginal => assert!((radius - 1.0).abs() < 1e-6, "{name}: {verdict:?}, table {radius}"),
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

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// Power sums of the multipliers from the roots, the trivial pair added, against traces of the dense matrix's powers.
    #[test]
    fn roots_have_the_power_sums_of_the_monodromy_matrix(model in conservative()) {
        let (mut finder, mut found) = (Finder::new(21), Found::default());
        let mut secular = Secular::default();
        for family in [Family::SingleSided, Family::DoubleSided] {
            if finder.find_symmetric(&model, family, &mut found).is_err() || finder.response().condition() > 1e3 {
                continue;
            }
            for orbit in &found.orbits {
                if secular.set(orbit, finder.response()).is_err() {
                    continue;
                }
                let Ok((roots, _)) = secular.roots() else { continue };
                let all: Vec<_> =
                    roots.iter().flat_map(|nu| multipliers(*nu)).chain([Complex::new(1.0, 0.0); 2]).collect();
                let matrix = dense(&even_monodromy(orbit).unwrap());
                prop_assert_eq!(all.len(), matrix.nrows());
                let scale = matrix.norm();
                let square = &matrix * &matrix;
                let cube = &square * &matrix;
                for (power, trace) in [(1, matrix.trace()), (2, square.trace()), (3, cube.trace())] {
                    let sum: Complex<f64> = all.iter().map(|mu| mu.powi(power)).sum();
                    let error = (sum - trace).norm();
                    prop_assert!(error < 1e-10 * scale.powi(power) * (1.0 + scale), "{family:?} {power}: {sum} {trace}");
                }
            }
        }
    }
}

#[test]
fn the_shape_of_the_unstable_perturbation_is_that_of_the_dense_solver() {
    let model = Model::forced(Chain::new(21, 0.2, 0.1).unwrap(), 1.5, 0.4, 0.1, 0.9).unwrap();
    let (mut finder, mut found) = (Finder::new(21), Found::default());
    finder.find(&model, Family::DoubleSided, &mut found).unwrap();
    for orbit in &found.orbits {
        let mut secular = SecularMultipliers::default();
        secular.set(orbit, finder.response()).unwrap();
        let (values, _) = secular.multipliers().unwrap();
        let leading = *values.iter().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap();
        let (displacement, velocity) = ModalShape::new(orbit, finder.response(), leading).unwrap().at_sites(21, 0);
        let modes = vibrochain::floquet::leading_modes(orbit, 2).unwrap();
        let mode = modes.iter().find(|mode| (mode.multiplier - leading).norm() < 1e-9).unwrap();
        let ratio = displacement[0] / mode.displacement[0];
        for n in 0..21 {
            assert!((displacement[n] - ratio * mode.displacement[n]).norm() < 1e-9 * ratio.norm());
            assert!((velocity[n] - ratio * mode.velocity[n]).norm() < 1e-9 * ratio.norm());
        }
    }
}
