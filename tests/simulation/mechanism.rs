//! How stability is lost through +1: a pitchfork where a simulation says that the orbit's symmetry breaks, and nowhere else.

use vibrochain::breather::{Family, Finder, Orbit, breathers};
use vibrochain::floquet::{Analyser, Event, Mechanism, Search, Tolerance, Verdict, locate};
use vibrochain::lattice::{Chain, Force, Harmonic, Model, Parameter, Point};
use vibrochain_testkit::ReturnMap;

fn verdicts(orbit: &Orbit) -> [Verdict; 3] {
    let mut finder = Finder::new(orbit.model().unwrap().chain().sites());
    [
        Analyser::default().verdict(orbit, &mut finder, Tolerance::Rounding).unwrap(),
        Analyser::default().stability(orbit, &mut finder, Tolerance::Rounding).unwrap().verdict,
        Analyser::dense().verdict(orbit, &mut finder, Tolerance::Rounding).unwrap(),
    ]
}

/// Without asymmetry: conservative, forced, forced by several harmonics.
fn symmetric_models() -> Vec<Model> {
    let mut models = Vec::new();
    let square = [(1, 1.0), (3, -0.3), (5, 0.1)];
    for (sites, gamma1, gamma2) in [(1, 0.2, 0.0), (3, 0.2, 0.1), (4, 0.1, 0.05), (7, 0.0, 0.3), (8, 0.14, 0.25)] {
        let chain = Chain::new(sites, gamma1, gamma2).unwrap();
        for omega in [0.33, 0.47, 0.71, 0.93, 1.33, 1.9] {
            models.push(Model::conservative(chain, omega, 0.0).unwrap());
            for (amplitude, e) in [(0.4, 0.95), (1.5, 0.6), (1.5, 0.8), (0.9, 1.0)] {
                models.push(chain.point().omega(omega).amplitude(amplitude).restitution(e).model().unwrap());
                let terms = square.map(|(number, share)| Harmonic { number, amplitude: share * amplitude, phase: 0.0 });
                models.push(
                    chain.point().omega(omega).under(&Force::new(&terms).unwrap()).restitution(e).model().unwrap(),
                );
            }
        }
    }
    models
}

#[test]
fn a_pitchfork_is_where_a_simulated_perturbation_breaks_the_symmetry() {
    let (mut breaking, mut keeping, mut asymmetric) = (0, 0, 0);
    for model in symmetric_models() {
        let Ok(found) = breathers(&model, Family::DoubleSided) else { continue };
        for orbit in &found.orbits {
            let verdicts = verdicts(orbit);
            let through = |verdict: &Verdict| verdict.mechanism.is_some_and(Mechanism::is_through_plus_one);
            let excess = verdicts[0].excess();
            if !verdicts.iter().all(through) || !(1e-4..1e3).contains(&excess) {
                continue;
            }
            let name = || format!("{model:?} φ = {:?}: {verdicts:?}", orbit.phi());
            let said = verdicts.map(|verdict| verdict.mechanism.unwrap());
            assert!(said.iter().all(|mechanism| *mechanism == said[0]), "{}", name());
            if (orbit.phi().unwrap() / orbit.period() - 0.5).abs() > 1e-9 {
                assert_eq!(said[0], Mechanism::PlusOne, "{}", name());
                asymmetric += 1;
                continue;
            }
            // μ = ρ² of the mirrored half: it breaks the symmetry if ρ < 0.
            let map = ReturnMap::new(orbit);
            let values = map.jacobian_of(|state| map.mirrored_half(state)).complex_eigenvalues();
            let rho = *values.iter().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap();
            // Differences know large multipliers to fewer digits.
            let error = (rho * rho - verdicts[0].leading).norm() / verdicts[0].spectral_radius;
            assert!(error < 1e-4 * (1.0 + excess) && rho.im == 0.0, "{}: ρ = {rho}, {error:e}", name());
            let expected = if rho.re < 0.0 { Mechanism::Pitchfork } else { Mechanism::PlusOne };
            assert_eq!(said[0], expected, "{}: ρ = {rho}", name());
            *if rho.re < 0.0 { &mut breaking } else { &mut keeping } += 1;
        }
    }
    assert!(breaking >= 10 && keeping >= 10 && asymmetric >= 3, "{breaking} {keeping} {asymmetric}");
}

#[test]
fn verdicts_on_either_side_of_an_event_have_its_name() {
    let forced = |asymmetry: f64, restitution: f64| {
        let chain = Chain::new(21, 0.1, 0.05).unwrap();
        chain.point().omega(1.33).asymmetry(asymmetry).amplitude(1.5).restitution(restitution).model().unwrap()
    };
    // The symmetric orbit of figure 9, of which a pair branches off.
    let symmetric = |orbit: &&Orbit| (orbit.phi().unwrap() / orbit.period() - 0.5).abs() < 1e-9;
    let found = breathers(&forced(0.0, 0.5), Family::DoubleSided).unwrap();
    let start = found.orbits.iter().find(symmetric).unwrap();
    let (event, free) = (Event::Pitchfork, Parameter::Restitution);
    let answer = locate(start, &Search { event, free, from: 0.4, to: 0.7 }).unwrap();
    let pitchfork = &answer.located[0];
    assert_eq!(pitchfork.branching.as_ref().unwrap().orbits.len(), 2);
    let said: Vec<_> = pitchfork.sides.iter().map(|side| side.stability.mechanism).collect();
    assert_eq!(said, [None, Some(Mechanism::Pitchfork)]);

    // Two orbits meet in a fold where the force gets too weak for its losses: symmetric ones without asymmetry, others with it,
    // single-sided ones. No symmetry breaks in any of them.
    let single = Point::ring(21).gamma1(0.2).gamma2(0.1).omega(1.07).asymmetry(0.8).amplitude(0.165).restitution(0.25);
    let mut folds = 0;
    for (model, family) in [
        (forced(0.0, 0.6), Family::DoubleSided),
        (forced(0.02, 0.6), Family::DoubleSided),
        (single.model().unwrap(), Family::SingleSided),
    ] {
        for start in &breathers(&model, family).unwrap().orbits {
            let search = Search { from: 1e-3, to: 1.0, ..Search::new(start, Event::Fold, Parameter::Amplitude) };
            let search = Search { to: 1.1 * model.amplitude(), ..search };
            for fold in &locate(start, &search).unwrap().located {
                let said: Vec<_> = fold.sides.iter().filter_map(|side| side.stability.mechanism).collect();
                assert!(!said.contains(&Mechanism::Pitchfork), "{said:?} at {}", fold.value);
                folds += usize::from(said.contains(&Mechanism::PlusOne));
            }
        }
    }
    assert!(folds >= 2, "{folds}");
}
