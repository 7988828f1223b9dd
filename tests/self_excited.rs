//! Self-excited orbits, whose period is an unknown: against values in many digits, closed flights of one mass, sums of their own, and simulation.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

use vibrochain_breather::{
    StructureFound, StructureModel, StructureMotion, StructureOrbit, StructureOrbitError, structure_admissibility,
    structure_orbits,
};
use vibrochain_eventsim::{ContactEvent, EventKind, Limits, StructureOutcome, StructureSimulation};
use vibrochain_floquet::{Event, StructureCourse, Tolerance, structure_diagram, structure_stability};
use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape, Stop};
use vibrochain_maps::structure::along::family;
use vibrochain_maps::structure::{Setting, StructureScene};
use vibrochain_testkit::Random;

type C = Complex<f64>;

/// q″ − 0.2 q′ + q = 0 with stops.
fn scene(stops: &str, restitution: f64) -> StructureScene {
    let text = format!(
        "omega = 1\nword = \"0-\"\n[structure]\nmasses = [1]\nstiffness = [[1]]\ndamping = [[-0.2]]\n[[contact]]\nat = 0\n{stops}\nrestitution = {restitution}\n"
    );
    StructureScene::of_text(&text, Path::new(".")).unwrap()
}

fn orbits(model: &StructureModel, word: &str) -> StructureFound {
    structure_orbits(model, &word.parse().unwrap(), 1).unwrap()
}

/// q and q′ of the mass alone, a time after these.
fn flight([q, v]: [f64; 2], t: f64) -> [f64; 2] {
    let (decay, rate) = (-0.1, 0.99f64.sqrt());
    let (sin, cos) = (rate * t).sin_cos();
    let (b, dying) = ((v + decay * q) / rate, (-decay * t).exp());
    [dying * (q * cos + b * sin), dying * ((rate * b - decay * q) * cos - (rate * q + decay * b) * sin)]
}

/// The first time that it is at −1 on its way down.
fn until_stop(start: [f64; 2]) -> f64 {
    let (mut low, step) = (1e-6, 1e-3);
    while flight(start, low + step)[0] > -1.0 {
        low += step;
    }
    let mut high = low + step;
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        *(if flight(start, middle)[0] > -1.0 { &mut low } else { &mut high }) = middle;
    }
    low
}

#[test]
fn one_mass_has_the_cycle_of_many_digits() {
    let model = scene("lower = -1", 0.5).model().unwrap();
    let found = orbits(&model, "0-");
    assert!(
        found.search.is_complete() && found.periods.is_some_and(|[from, to]| from < 0.01 && to > 25.0),
        "{found:?}"
    );
    let [orbit] = &found.orbits[..] else { panic!("{}", found.orbits.len()) };
    assert!(orbit.is_self_excited() && !orbit.is_conservative());
    assert!((orbit.period() - 4.231628856140046).abs() <= orbit.period_error() && orbit.period_error() < 1e-13);
    let impact = &orbit.impacts()[0];
    assert!((impact.impulse - 3.568_534_193_789_094_6).abs() <= impact.impulse_error && impact.impulse_error < 1e-12);
    assert!(structure_admissibility(orbit).unwrap().is_physical());
    // One is 1; the map from impact to impact has the other as its slope.
    let stability = structure_stability(orbit, Tolerance::Rounding).unwrap();
    let [one, other] = stability.multipliers[..] else { panic!("{:?}", stability.multipliers) };
    let next = |v: f64| {
        let start = [-1.0, v];
        -0.5 * flight(start, until_stop(start))[1]
    };
    let (v, h) = (impact.velocity_after, 1e-4);
    assert!((next(v) - v).abs() < 1e-13);
    let slope = (next(v + h) - next(v - h)) / (2.0 * h);
    assert_eq!(one, C::new(1.0, 0.0));
    assert!(
        (other - slope).norm() < 1e-7 && stability.verdict.stable && !stability.verdict.undecided,
        "{other} {slope}"
    );
    // By Liouville's formula exactly.
    assert!((other.re - 0.25 * (0.2 * orbit.period()).exp()).abs() < 1e-12);
}

/// What runs settle on, from a push as from far out.
#[test]
fn runs_settle_on_it() {
    let model = scene("lower = -1", 0.5).model().unwrap();
    let found = orbits(&model, "0-");
    let orbit = &found.orbits[0];
    for start in [[0.1, 0.0], [3.0, 1.0], [-0.9, -2.0]] {
        let structure = (**model.structure()).clone();
        let mode = &structure.modes()[0];
        // ξ of the mode, whose coordinates are q and (q′ + δq)/κ.
        let shape = mode.coordinates[0][0];
        let xi = [start[0] / shape, (start[1] + mode.decay * start[0]) / mode.rate / shape];
        let mut simulation = StructureSimulation::new(structure, 1.0, 0.0, &[xi]).unwrap();
        let until = simulation.time_of(40, 0.0);
        let (report, events) = simulation.collect(&Limits { until: Some(until), ..Limits::default() });
        assert_eq!(report.outcome, StructureOutcome::TimeReached);
        let [.., before, last] = &events[..] else { panic!("{events:?}") };
        let lapse = last.time.to_f64() - before.time.to_f64();
        assert!((lapse - orbit.period()).abs() < 1e-8, "{start:?} {lapse}");
        assert!((last.impulse - orbit.impacts()[0].impulse).abs() < 1e-8, "{}", last.impulse);
    }
}

/// Between two stops the mass goes to and fro: from one with v to the other, where −v/e is taken to v.
#[test]
fn two_stops_have_the_cycle_that_is_its_own_mirror_image() {
    let model = scene("lower = -1\nupper = 1", 0.5).model().unwrap();
    let found = orbits(&model, "0+,0-");
    assert!(!found.search.is_complete());
    let physical: Vec<_> =
        found.orbits.iter().filter(|orbit| structure_admissibility(orbit).unwrap().is_physical()).collect();
    let [orbit] = physical[..] else { panic!("{}", physical.len()) };
    let next = |v: f64| {
        let start = [1.0, -v];
        let t = until_stop(start);
        (-0.5 * flight(start, t)[1], t)
    };
    let v = orbit.impacts()[1].velocity_after;
    let (again, half) = next(v);
    assert!((again - v).abs() < 1e-12 && (orbit.period() - 2.0 * half).abs() < 1e-12, "{again} {v} {half}");
    let h = 1e-4;
    let slope = (next(v + h).0 - next(v - h).0) / (2.0 * h);
    let stability = structure_stability(orbit, Tolerance::Rounding).unwrap();
    assert!((stability.verdict.spectral_radius - slope * slope).abs() < 1e-6 && stability.verdict.stable, "{slope}");
}

fn structure(random: &mut Random) -> ModalStructure {
    let modes = 1 + random.below(3);
    let mode = |k: usize| {
        let (frequency, ratio) = (random.log(0.4, 4.0), random.log(2e-2, 0.3));
        let ratio = if k == 0 { -ratio } else { ratio };
        let contacts = vec![random.between(0.3, 1.0), random.between(-1.0, 1.0)];
        let shape = ModeShape { contacts, coordinates: Vec::new(), still: random.between(-0.1, 0.1) };
        LinearMode::oscillator(ratio * frequency, frequency * frequency * (1.0 - ratio * ratio), &shape, &[])
    };
    let modes = (0..modes).map(mode).collect();
    let contacts = vec![
        Contact { lower: None, upper: Some(random.between(0.1, 1.0)), restitution: random.between(0.2, 0.9) },
        Contact { lower: Some(-random.log(0.5, 3.0)), upper: None, restitution: random.between(0.2, 0.9) },
    ];
    ModalStructure::new(contacts, Vec::new(), modes).unwrap()
}

/// 1/m + (1+e)K′(T) by the two poles of each mode.
fn law(structure: &ModalStructure, period: f64) -> f64 {
    let contact = &structure.contacts()[0];
    let terms = structure.modes().iter().map(|mode| {
        let (pole, square) = (C::new(-mode.decay, mode.rate), mode.rows[0][0] * mode.columns[0][1] * mode.rate);
        let grown = (pole * period).exp();
        square * (1.0 + (1.0 + contact.restitution) * (pole * grown / (C::new(1.0, 0.0) - grown)).im / mode.rate)
    });
    terms.sum()
}

/// Whether a run from the middle of the first flight has the orbit's impacts for a period, and nothing else.
fn runs_as_told(orbit: &StructureOrbit) -> bool {
    let (model, motion) = (orbit.model(), StructureMotion::new(orbit).unwrap());
    let s = 0.5 * motion.until_next(0);
    let xi = motion.modes(0, s).unwrap();
    let structure = (**model.structure()).clone();
    let Ok(mut simulation) = StructureSimulation::new(structure, model.omega(), 0.0, &xi) else { return false };
    let until = simulation.time_of(1, 0.0);
    let (report, events) = simulation.collect(&Limits { until: Some(until), ..Limits::default() });
    let impacts = orbit.impacts();
    let alike = |(i, event): (usize, &ContactEvent)| {
        let impact = &impacts[(i + 1) % impacts.len()];
        let time = impact.time - s + if i + 1 >= impacts.len() { orbit.period() } else { 0.0 };
        event.kind == EventKind::Impact
            && event.contact == impact.contact
            && (event.time.to_f64() - time).abs() < 1e-7 * orbit.period()
            && (event.impulse - impact.impulse).abs() < 1e-6 * impact.impulse.abs()
    };
    report.outcome == StructureOutcome::TimeReached
        && events.len() == impacts.len()
        && events.iter().enumerate().all(alike)
}

#[test]
fn lists_of_one_impact_have_all_periods_and_runs_follow_what_is_physical() {
    let mut random = Random(77);
    let (mut listed, mut physical, mut other, mut two) = (0, 0, 0, 0);
    for _ in 0..40 {
        let structure = structure(&mut random);
        let model = StructureModel::new(Arc::new(structure.clone()), 1.0).unwrap();
        let found = orbits(&model, "0+");
        let [from, to] = found.periods.unwrap();
        assert!(found.search.is_complete(), "{:?}", found.search);
        let at = |i: u32| law(&structure, from + (to - from) * f64::from(i) / 10_000.0);
        let crossings = (0..10_000).filter(|&i| at(i) * at(i + 1) < 0.0).count();
        // Between two places there may be two more.
        assert!(found.orbits.len() >= crossings && (found.orbits.len() - crossings).is_multiple_of(2), "{crossings}");
        for orbit in &found.orbits {
            let scale = law(&structure, orbit.period() * (1.0 + 1e-7)) - law(&structure, orbit.period() * (1.0 - 1e-7));
            assert!(law(&structure, orbit.period()).abs() <= 1e-12 + 1e-4 * scale.abs());
            listed += 1;
        }
        for orbit in found.orbits.iter().chain(&orbits(&model, "0+,1-").orbits) {
            let told = structure_admissibility(orbit).unwrap();
            assert_eq!(told.is_physical(), runs_as_told(orbit), "{told:?} {orbit:?}");
            *(if told.is_physical() { &mut physical } else { &mut other }) += 1;
            two += usize::from(told.is_physical() && orbit.impacts().len() == 2);
        }
    }
    assert!(listed > 20 && physical > 6 && other > 20 && two > 1, "{listed} {physical} {other} {two}");
}

#[test]
fn a_branch_keeps_to_the_cycle_and_has_no_event_of_its_own_derivative() {
    let scene = scene("lower = -1", 0.5);
    let orbit = &orbits(&scene.model().unwrap(), "0-").orbits[0];
    let course = |from, to| StructureCourse {
        from,
        to,
        events: Event::ALL.to_vec(),
        generations: 0,
        tolerance: Tolerance::Rounding,
    };
    let family_of = |setting| family(&scene, &[setting]);
    let restitution = Setting::Restitution(0);
    let diagram = structure_diagram(orbit, &family_of(restitution), 0.5, &course(0.2, 0.7), &Stop::default()).unwrap();
    let branch = &diagram.branches[0];
    assert_eq!(branch.events().count(), 0);
    let mut checked = 0;
    for point in branch.points() {
        let alone = scene_at(point.value);
        let same = alone.iter().any(|other| {
            (other.period() - point.orbit.period()).abs() < 1e-10
                && (other.impacts()[0].impulse - point.orbit.impacts()[0].impulse).abs() < 1e-9
        });
        assert!(same, "{}", point.value);
        assert_eq!(point.verdict.map(|verdict| verdict.stable), Some(true), "{}", point.value);
        checked += 1;
    }
    assert!(checked > 10, "{checked}");
    let refused = structure_diagram(orbit, &family_of(Setting::Omega), 1.0, &course(0.5, 2.0), &Stop::default());
    assert!(refused.is_err_and(|error| error.to_string().contains("omega does not act")));
}

fn scene_at(restitution: f64) -> Vec<StructureOrbit> {
    orbits(&scene("lower = -1", restitution).model().unwrap(), "0-").orbits
}

#[test]
fn what_feeds_on_nothing_is_refused() {
    let word = "0-".parse().unwrap();
    let model = scene("lower = -1", 0.5).model().unwrap();
    assert!(matches!(structure_orbits(&model, &word, 2), Err(StructureOrbitError::OwnPeriod { force_periods: 2 })));
    let shape = ModeShape { contacts: vec![1.0], coordinates: Vec::new(), still: 0.0 };
    let stop = Contact { lower: Some(-1.0), upper: None, restitution: 0.5 };
    for decay in [0.0, 0.1] {
        let mode = LinearMode::oscillator(decay, 1.0 - decay * decay, &shape, &[]);
        let structure = ModalStructure::new(vec![stop], Vec::new(), vec![mode]).unwrap();
        let model = StructureModel::new(Arc::new(structure), TAU / 3.0).unwrap();
        assert_eq!(structure_orbits(&model, &word, 1), Err(StructureOrbitError::LossWithoutLoad), "{decay}");
    }
}
