//! Answers know their errors: conditions, verdicts that say undecided, and cells that are counted as such.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::path::Path;

use vibrochain_breather::{Family, Finder, Orbit, OrbitList, condition};
use vibrochain_floquet::{Analyser, FloquetError, Mechanism, Tolerance, Verdict, stability};
use vibrochain_lattice::{Chain, Model, Point};
use vibrochain_maps::cell::{Class, Status, Worker};
use vibrochain_maps::scene::Scene;

fn orbits(model: &Model, family: Family) -> Vec<Orbit> {
    let mut found = OrbitList::default();
    Finder::new(model.chain().sites()).find(model, family, &mut found).unwrap();
    found.orbits
}

/// The verdict of a sweep and that of a single orbit.
fn verdicts(orbit: &Orbit, tolerance: Tolerance) -> [Verdict; 2] {
    let mut finder = Finder::new(orbit.model().unwrap().chain().sites());
    let quick = Analyser::default().verdict(orbit, &mut finder, tolerance).unwrap();
    [quick, stability(orbit, tolerance).unwrap().verdict]
}

#[test]
fn a_threshold_next_to_the_excess_does_not_put_a_multiplier_on_the_circle() {
    let chain = Chain::new(21, 0.2, 0.1).unwrap();
    let model = chain.point().omega(0.93).asymmetry(0.4).amplitude(0.05).model().unwrap();
    let orbit = &orbits(&model, Family::SingleSided)[0];
    for verdict in verdicts(orbit, Tolerance::Excess(0.635552)) {
        assert!(!verdict.stable && (verdict.spectral_radius - 1.6355520983).abs() < 1e-9, "{verdict:?}");
    }
    for verdict in verdicts(orbit, Tolerance::Excess(0.6355525)) {
        assert!(verdict.stable && verdict.spectral_radius > 1.6, "{verdict:?}");
    }
}

#[test]
fn elastic_orbits_lie_on_the_circle_whatever_the_threshold() {
    let chain = Chain::new(21, 0.2, 0.1).unwrap();
    let models = [
        Model::conservative(chain, 1.5, 0.4).unwrap(),
        chain.point().omega(1.5).asymmetry(0.4).amplitude(0.1).model().unwrap(),
    ];
    for model in models {
        let orbit = &orbits(&model, Family::DoubleSided)[0];
        for tolerance in [Tolerance::Rounding, Tolerance::Excess(0.01)] {
            for verdict in verdicts(orbit, tolerance) {
                assert!(verdict.stable && verdict.spectral_radius == 1.0 && verdict.resolution == 0.0, "{verdict:?}");
            }
        }
    }
}

#[test]
fn an_orbit_whose_equations_are_singular_has_no_bound_on_its_errors() {
    // One mass at ω = 2√γ₁: half a period after an impact it is back, whatever the impulse.
    let model = Point::ring(1).gamma1(0.25).gamma2(0.0).omega(1.0).amplitude(0.75).model().unwrap();
    let mut singular = 0;
    for orbit in orbits(&model, Family::DoubleSided) {
        let condition = condition(&orbit).unwrap();
        if condition.fold < 1e-10 {
            singular += 1;
            assert!(condition.impulse_error().is_infinite() && condition.time_error().is_infinite());
            // An impact without speed is an error of its own.
            match stability(&orbit, Tolerance::Rounding) {
                Ok(answer) => assert!(answer.verdict.undecided),
                Err(error) => assert!(matches!(error, FloquetError::Grazing { .. }), "{error}"),
            }
        }
    }
    assert!(singular > 0);
}

#[test]
fn next_to_a_fold_errors_grow_as_the_inverse_root_of_the_distance() {
    // The single-sided branch of `errata` folds at A = 0.157927457267….
    let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    let model = |amplitude| ring.omega(1.07).asymmetry(0.8).amplitude(amplitude).restitution(0.25).model().unwrap();
    let (mut previous, mut before) = (1.0, None);
    for distance in [1e-2, 1e-4, 1e-6, 1e-8] {
        let orbit = &orbits(&model(0.157927457267 * (1.0 + distance)), Family::SingleSided)[0];
        let condition = condition(orbit).unwrap();
        let fold = condition.fold;
        // Two orbits part like the root of the distance.
        assert!(fold < 0.2 * previous && fold > 1e-2 * distance.sqrt(), "{distance}: {fold}");
        let error = condition.impulse_error();
        assert!(error < 1e-12 / distance.sqrt());
        // A hundred times nearer they are ten times as large.
        assert!(before.is_none_or(|before| (5.0..20.0).contains(&(error / before))), "{distance}: {before:?} {error}");
        (previous, before) = (fold, Some(error));
    }
}

#[test]
fn sweeps_and_single_orbits_agree_next_to_bifurcations() {
    // Neimark–Sacker at γ₂ = 0.088347387971, of `errata`: unstable on one side, stable on the other.
    let gamma2 = 0.088347387971;
    let at = |gamma2: f64| {
        let ring = Point::ring(21).gamma1(0.2).gamma2(gamma2);
        let model = ring.omega(0.92).asymmetry(0.7).amplitude(0.05).restitution(0.9).model().unwrap();
        let candidates = orbits(&model, Family::SingleSided);
        let near =
            |orbit: &&Orbit| (stability(orbit, Tolerance::Rounding).unwrap().verdict.spectral_radius - 1.0).abs();
        candidates.iter().min_by(|a, b| near(a).total_cmp(&near(b))).unwrap().clone()
    };
    let kind = |verdict: &Verdict| (verdict.stable, verdict.undecided, verdict.mechanism);
    let mut kinds = Vec::new();
    for offset in [-1e-6, -1e-9, 1e-9, 1e-6] {
        let [quick, thorough] = verdicts(&at(gamma2 + offset), Tolerance::Rounding);
        assert_eq!(kind(&quick), kind(&thorough), "{offset}");
        kinds.push(quick.mechanism);
    }
    assert!(kinds[0] == kinds[1] && kinds[2] == kinds[3] && kinds[1] != kinds[2], "{kinds:?}");
    kinds.sort_by_key(Option::is_some);
    assert_eq!(kinds, [None, None, Some(Mechanism::NeimarkSacker), Some(Mechanism::NeimarkSacker)]);
}

#[test]
fn an_undecided_cell_has_no_class_and_is_counted() {
    // Next to elastic: multipliers leave the circle by less than rounding.
    let text = r#"
        [model]
        sites = 21
        gamma1 = 0.2
        asymmetry = 0.4
        forcing = { amplitude = 0.1, restitution = 0.999999999999999 }
        [sweep]
        x = { parameter = "omega",  from = 1.5, to = 1.6, points = 2 }
        y = { parameter = "gamma2", from = 0.1, to = 0.11, points = 2 }
        [compute]
        families = ["double-sided"]
        stability = true
    "#;
    let scene = Scene::parse(Path::new("undecided.toml"), text).unwrap();
    let mut worker = Worker::new(21);
    let cell = worker.cell(&scene.point(0).model().unwrap(), &scene.task);
    assert_eq!((cell.class, cell.status, cell.mechanism), (None, Status::Undecided, None));
    // Tables of an earlier state have the word it had then.
    assert_eq!((Status::from_name("marginal"), Status::Undecided.name()), (Some(Status::Undecided), "undecided"));
    assert!((cell.spectral_radius.unwrap() - 1.0).abs() < 1e-12 && cell.margin.is_some() && cell.solutions == 2);
    // With a threshold there is nothing to be undecided about.
    let task = vibrochain_maps::cell::Task { tolerance: Tolerance::Excess(1e-3), ..scene.task.clone() };
    let cell = worker.cell(&scene.point(0).model().unwrap(), &task);
    assert_eq!((cell.class, cell.status), (Some(Class::StableDouble), Status::Ok));
}
