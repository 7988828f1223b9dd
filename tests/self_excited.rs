//! Self-excited orbits, whose period is an unknown: against values in many digits, closed flights of one mass, sums of their own, and simulation.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

use vibrochain_breather::{BreatherError, LoadedStructure, Orbit, OrbitList, admissibility};
use vibrochain_eventsim::{Limits, Outcome, Simulation};
use vibrochain_floquet::{
    BranchRequest, End, Event, Located, Tolerance, Walk, Window, branches, event_curves, stability,
};
use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape, Stop};
use vibrochain_maps::grid::Grid;
use vibrochain_maps::structure::along::{family, numbers};
use vibrochain_maps::structure::{Setting, StructureClass, StructureScene};
use vibrochain_testkit::{Random, run_follows};

type C = Complex<f64>;

/// q″ − 0.2 q′ + q = 0 with stops.
fn scene(stops: &str, restitution: f64) -> StructureScene {
    damped(-0.2, stops, restitution, "")
}

/// q″ + cq′ + q = 0 with stops.
fn damped(c: f64, stops: &str, restitution: f64, map: &str) -> StructureScene {
    let text = format!(
        "word = \"0-\"\n[structure]\nmasses = [1]\nstiffness = [[1]]\ndamping = [[{c}]]\n[[contact]]\nat = 0\n{stops}\nrestitution = {restitution}\n{map}"
    );
    StructureScene::of_text(&text, Path::new(".")).unwrap()
}

fn orbits(model: &LoadedStructure, word: &str) -> OrbitList {
    model.orbits(&word.parse().unwrap(), 1).unwrap()
}

/// q and q′ of the mass alone, a time after these.
fn flight(start: [f64; 2], t: f64) -> [f64; 2] {
    flight_of(-0.2, start, t)
}

fn flight_of(c: f64, [q, v]: [f64; 2], t: f64) -> [f64; 2] {
    let (decay, rate) = (0.5 * c, (1.0 - 0.25 * c * c).sqrt());
    let (sin, cos) = (rate * t).sin_cos();
    let (b, dying) = ((v + decay * q) / rate, (-decay * t).exp());
    [dying * (q * cos + b * sin), dying * ((rate * b - decay * q) * cos - (rate * q + decay * b) * sin)]
}

/// The first time that it is at −1 on its way down.
fn until_stop(start: [f64; 2]) -> f64 {
    until_stop_of(-0.2, start)
}

fn until_stop_of(c: f64, start: [f64; 2]) -> f64 {
    let (mut low, step) = (1e-6, 1e-3);
    while flight_of(c, start, low + step)[0] > -1.0 {
        low += step;
    }
    let mut high = low + step;
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        *(if flight_of(c, start, middle)[0] > -1.0 { &mut low } else { &mut high }) = middle;
    }
    low
}

#[test]
fn one_mass_has_the_cycle_of_many_digits() {
    let model = scene("lower = -1", 0.5).model().unwrap();
    let found = orbits(&model, "0-");
    assert!(
        found.completeness.is_established() && found.periods.is_some_and(|[from, to]| from < 0.01 && to > 25.0),
        "{found:?}"
    );
    let [orbit] = &found.orbits[..] else { panic!("{}", found.orbits.len()) };
    assert!(orbit.is_self_excited() && !orbit.is_conservative());
    assert!((orbit.period() - 4.231628856140046).abs() <= orbit.period_error() && orbit.period_error() < 1e-13);
    let impact = &orbit.impacts()[0];
    let error = orbit.contacts().unwrap().impact_errors()[0].impulse;
    assert!((impact.impulse - 3.568_534_193_789_094_6).abs() <= error && error < 1e-12);
    assert!(admissibility(orbit).unwrap().is_physical());
    // One is 1; the map from impact to impact has the other as its slope.
    let stability = stability(orbit, Tolerance::Rounding).unwrap();
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
        let mut simulation = Simulation::of_modes(structure, 1.0, 0.0, &[xi]).unwrap();
        let until = simulation.time_of(40, 0.0);
        let (report, events) = simulation.collect(&Limits { until: Some(until), ..Limits::default() });
        assert_eq!(report.outcome, Outcome::TimeReached);
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
    assert!(!found.completeness.is_established());
    let physical: Vec<_> = found.orbits.iter().filter(|orbit| admissibility(orbit).unwrap().is_physical()).collect();
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
    let stability = stability(orbit, Tolerance::Rounding).unwrap();
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

#[test]
fn lists_of_one_impact_have_all_periods_and_runs_follow_what_is_physical() {
    let mut random = Random(77);
    let (mut listed, mut physical, mut other, mut two) = (0, 0, 0, 0);
    for _ in 0..40 {
        let structure = structure(&mut random);
        let model = LoadedStructure::new(Arc::new(structure.clone()), 1.0).unwrap();
        let found = orbits(&model, "0+");
        let [from, to] = found.periods.unwrap();
        assert!(found.completeness.is_established(), "{:?}", found.completeness);
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
            let told = admissibility(orbit).unwrap();
            assert_eq!(told.is_physical(), run_follows(orbit), "{told:?} {orbit:?}");
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
    let course = |from, to| BranchRequest {
        from,
        to,
        events: Event::ALL.to_vec(),
        generations: 0,
        tolerance: Tolerance::Rounding,
    };
    let family_of = |setting| family(&scene, &[setting]);
    let restitution = Setting::Restitution(0);
    let diagram = branches(orbit, &family_of(restitution), 0.5, &course(0.2, 0.7), &Stop::default()).unwrap();
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
    let refused = branches(orbit, &family_of(Setting::Omega), 1.0, &course(0.5, 2.0), &Stop::default());
    assert!(refused.is_err_and(|error| error.to_string().contains("changes nothing")));
}

/// The two orbits that pull meet where F and its derivative vanish, by Newton's method in 30 digits.
#[test]
fn a_fold_is_told_where_it_is() {
    let scene = damped(-0.154, "lower = -1", 0.5, "");
    let found = orbits(&scene.model().unwrap(), "0-").orbits;
    assert_eq!(found.len(), 3);
    let course = |events| BranchRequest { from: 0.99, to: 1.5, events, generations: 0, tolerance: Tolerance::Rounding };
    let family = family(&scene, &[Setting::Damping]);
    for (solution, events) in [(1, Event::ALL.to_vec()), (2, Event::ALL.to_vec()), (1, vec![Event::Fold])] {
        let orbit = &found[solution];
        let diagram = branches(orbit, &family, 1.0, &course(events), &Stop::default()).unwrap();
        let branch = &diagram.branches[0];
        assert!(branch.unresolved.is_empty(), "{:?}", branch.unresolved);
        let folds: Vec<_> = branch.events().collect();
        let [fold] = folds[..] else { panic!("{}", folds.len()) };
        assert!(fold.event == Event::Fold && fold.error < 1e-9, "{:?} {}", fold.event, fold.error);
        assert!((fold.value - 1.000_670_062_414_756_5).abs() <= fold.error, "{} {}", fold.value, fold.error);
        assert!((fold.orbit.period() - 8.995_883_632_334_53).abs() < 1e-6, "{}", fold.orbit.period());
        assert!((fold.orbit.impacts()[0].impulse + 9.733_737_528_586_73).abs() < 1e-5);
    }
}

/// Along the curve of this fold the law and its derivative vanish, and nothing else happens: of two multipliers one is 1 by itself.
#[test]
fn a_curve_of_folds_has_no_second_multiplier() {
    let scene = damped(-0.154, "lower = -1", 0.5, "");
    let orbit = &orbits(&scene.model().unwrap(), "0-").orbits[1];
    let settings = [Setting::Damping, Setting::Restitution(0)];
    let fold = branches(
        orbit,
        &family(&scene, &settings[..1]),
        1.0,
        &BranchRequest {
            from: 0.99,
            to: 1.5,
            events: vec![Event::Fold],
            generations: 0,
            tolerance: Tolerance::Rounding,
        },
        &Stop::default(),
    );
    let fold = fold.unwrap();
    let fold = fold.branches[0].events().next().unwrap();
    let window = Window { from: [0.9, 0.45], to: [1.1, 0.55] };
    let numbers = numbers(&scene, &settings).unwrap();
    let curve = event_curves([fold], &numbers, &Walk::new(window, 1e-3)).unwrap().remove(0);
    assert!(curve.special.is_empty(), "{:?}", curve.special);
    let mut checked = 0;
    for point in &curve.points {
        let [factor, e] = point.values;
        let law = |period: f64| {
            let pole = C::new(0.077 * factor, (1.0 - (0.077 * factor).powi(2)).sqrt());
            let grown = (pole * period).exp();
            1.0 + (1.0 + e) * (pole * grown / (C::new(1.0, 0.0) - grown)).im / pole.im
        };
        let (period, h) = (point.orbit.period(), 1e-4);
        let slope = (law(period + h) - law(period - h)) / (2.0 * h);
        assert!(law(period).abs() < 1e-10 && slope.abs() < 1e-7, "{factor} {e}: {} {slope}", law(period));
        checked += 1;
    }
    assert!(checked > 20, "{checked}");
}

/// Two masses, the dashpot of one of which is negative: complex modes. Newton's method in 30 digits on the matrix exponential has the place where
/// the period doubles; the doubled orbits leave there, come back there, and runs follow them.
#[test]
fn doubled_orbits_leave_and_come_back_where_the_period_doubles() {
    let text = "omega = 1\nword = \"0-\"\n[structure]\nmasses = [1, 2]\nstiffness = [[2, -1], [-1, 1.7]]\n\
                damping = [[-0.14, 0], [0, 0.015]]\n[[contact]]\nat = 0\nlower = -1\nrestitution = 0.64\n";
    let scene = StructureScene::of_text(text, Path::new(".")).unwrap();
    let free = family(&scene, &[Setting::Restitution(0)]);
    let course = |from, to, generations| BranchRequest {
        from,
        to,
        events: Event::ALL.to_vec(),
        generations,
        tolerance: Tolerance::Rounding,
    };
    let (e, period) = (0.630_452_109_815_442_7, 3.111_806_665_081_936);
    let is_there = |event: &Located, periods: f64| {
        assert!(event.event == Event::PeriodDoubling && event.error < 1e-11, "{:?} {}", event.event, event.error);
        assert!((event.value - e).abs() <= event.error, "{} {}", event.value, event.error);
        assert!((event.orbit.period() - periods * period).abs() < 1e-9, "{}", event.orbit.period());
    };
    let found = orbits(&scene.model().unwrap(), "0-").orbits;
    let mut followed = 0;
    for orbit in &found {
        let told = admissibility(orbit).unwrap();
        assert_eq!(told.is_physical(), run_follows(orbit), "{told:?}");
        followed += usize::from(told.is_physical());
    }
    assert_eq!((found.len(), followed), (3, 2));
    let simple = found.iter().find(|orbit| admissibility(orbit).unwrap().is_physical()).unwrap();
    let diagram = branches(simple, &free, 0.64, &course(0.6, 0.66, 1), &Stop::default()).unwrap();
    let [own, doubled] = &diagram.branches[..] else { panic!("{}", diagram.branches.len()) };
    let events: Vec<_> = own.events().collect();
    let [event] = events[..] else { panic!("{}", events.len()) };
    is_there(event, 1.0);
    let mut runs = 0;
    // Where they leave the equations are singular, and bound no error.
    for point in doubled.points().skip(1) {
        assert_eq!((point.orbit.impacts().len(), point.physical), (2, Some(true)), "{}", point.value);
        assert!(run_follows(&point.orbit), "{}", point.value);
        assert!(point.orbit.is_self_excited() && point.verdict.is_some_and(|verdict| !verdict.stable));
        runs += 1;
    }
    assert!(runs > 10, "{runs}");
    // From one of them back to where they began.
    let last = doubled.points().last().unwrap();
    let back = branches(&last.orbit, &free, last.value, &course(0.6, last.value, 0), &Stop::default()).unwrap();
    let events: Vec<_> = back.branches[0].events().collect();
    let [event] = events[..] else { panic!("{}", events.len()) };
    is_there(event, 1.0);
    let ended = |end: &(f64, End)| end.1 == End::PeriodDoubling && (end.0 - e).abs() <= event.error;
    assert!(back.branches[0].ends.iter().any(ended), "{:?}", back.branches[0].ends);
}

/// A map has the orbit of each point: by the flight of the mass alone, and Liouville's formula.
#[test]
fn a_map_has_the_cycle_of_each_point() {
    let map = "[sweep]\nx = { parameter = \"damping\", from = 0.25, to = 0.75, points = 7 }\n\
               y = { parameter = \"contact.0.restitution\", values = [0.4, 0.7] }\n[compute]\nfamilies = [\"0-\"]\n";
    let scene = damped(-0.2, "lower = -1", 0.5, map);
    let (mut worker, mut cells) = (scene.worker(&Stop::default()), Vec::new());
    scene.compute(&mut worker, 0..14, &Stop::default(), &mut cells).unwrap();
    let mut stable = 0;
    for (number, cell) in (0..).zip(&cells) {
        let [(_, factor), (_, e)] = scene.point(number)[..] else { panic!() };
        let c = -0.2 * factor;
        // The velocity after an impact, as each takes the last one, from 1 on.
        let next = |v: f64| -e * flight_of(c, [-1.0, v], until_stop_of(c, [-1.0, v]))[1];
        let v = (0..400).fold(1.0, |v, _| next(v));
        let told = (cell.found.solutions, cell.found.spectral_radius, cell.found.margin);
        assert!((next(v) - v).abs() < 1e-12 && told.0 == 1, "{factor} {e} {told:?}");
        let period = until_stop_of(c, [-1.0, v]);
        let multiplier = e * e * (-c * period).exp();
        assert!((told.1.unwrap() - multiplier).abs() < 1e-9, "{factor} {e} {told:?} {multiplier}");
        assert_eq!(cell.class, StructureClass::Stable);
        stable += 1;
    }
    assert_eq!(stable, 14);
}

fn scene_at(restitution: f64) -> Vec<Orbit> {
    orbits(&scene("lower = -1", restitution).model().unwrap(), "0-").orbits
}

#[test]
fn what_feeds_on_nothing_is_refused() {
    let word = "0-".parse().unwrap();
    let model = scene("lower = -1", 0.5).model().unwrap();
    assert!(matches!(model.orbits(&word, 2), Err(BreatherError::OwnPeriod { force_periods: 2 })));
    let shape = ModeShape { contacts: vec![1.0], coordinates: Vec::new(), still: 0.0 };
    let stop = Contact { lower: Some(-1.0), upper: None, restitution: 0.5 };
    for decay in [0.0, 0.1] {
        let mode = LinearMode::oscillator(decay, 1.0 - decay * decay, &shape, &[]);
        let structure = ModalStructure::new(vec![stop], Vec::new(), vec![mode]).unwrap();
        let model = LoadedStructure::new(Arc::new(structure), TAU / 3.0).unwrap();
        assert_eq!(model.orbits(&word, 1), Err(BreatherError::LossWithoutLoad), "{decay}");
    }
}
