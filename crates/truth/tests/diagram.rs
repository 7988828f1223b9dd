//! Bifurcation diagrams against what finds the same by other ways: searches for one event each, counts of multipliers outside the
//! circle between events, orbits in many digits, and a simulated return map.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::sync::LazyLock;

use vibrochain_breather::{Family, Finder, OrbitList, Scope, breathers};
use vibrochain_floquet::{Analyser, Course, Diagram, End, Event, Evidence, FollowedBranch, Search, Tolerance};
use vibrochain_floquet::{diagram, locate};
use vibrochain_lattice::{Chain, Ends, Model, Parameter, Point};
use vibrochain_testkit::Values::{Either, Even, Is, Log};
use vibrochain_testkit::{Random, Ranges, ReturnMap};
use vibrochain_truth::{DEFAULT_BITS, TrueOrbit};

const RANGES: Ranges = Ranges {
    sites: [2, 7],
    gamma1: Log(0.05, 0.8),
    gamma2: Log(1e-2, 0.4),
    omega: Log(0.5, 2.0),
    asymmetry: Even(0.0, 0.9),
    amplitude: Either(0.3, &Is(0.0), &Log(0.05, 1.0)),
    restitution: Either(0.3, &Is(1.0), &Log(0.1, 1.0)),
};

/// Random models with their first orbit.
fn draws(seed: u64, mut take: impl FnMut(&vibrochain_breather::Orbit, Parameter) -> bool) {
    let mut random = Random(seed);
    loop {
        let mut model = random.model(&RANGES);
        if model.amplitude() == 0.0 {
            model = Model::conservative(*model.chain(), model.omega(), model.asymmetry()).unwrap();
        }
        let family = random.of(&[Family::SingleSided, Family::DoubleSided]);
        let free = random.of(&[Parameter::Gamma1, Parameter::Gamma2, Parameter::Omega, Parameter::Asymmetry]);
        let Ok(list) = breathers(&model, family) else { continue };
        if let Some(orbit) = list.orbits.first()
            && !take(orbit, free)
        {
            break;
        }
    }
}

fn course(orbit: &vibrochain_breather::Orbit, free: Parameter) -> Course {
    let start = orbit.model().unwrap().get(free);
    let narrow = Course::new(orbit, free);
    Course { from: (0.8 * start).max(narrow.from), to: (1.2 * start).min(narrow.to), ..narrow }
}

#[test]
fn one_pass_finds_what_searches_for_each_event_find() {
    finds_what_searches_find(60, 4);
}

#[test]
#[ignore = "half a minute: cargo test --workspace --test diagram -- --ignored slow"]
fn slow_one_pass_finds_what_searches_for_each_event_find() {
    finds_what_searches_find(150, 10);
}

/// Along branches of so many orbits, with so many events of each kind at least.
fn finds_what_searches_find(most: usize, least: usize) {
    let (mut found, mut orbits, mut missed) = ([0; 5], 0, Vec::new());
    draws(31, |orbit, free| {
        let course = course(orbit, free);
        let (Ok(whole), true) = (diagram(orbit, &course), course.from < course.to) else { return true };
        let branch = &whole.branches[0];
        for (kind, event) in Event::ALL.into_iter().enumerate() {
            let Ok(answer) = locate(orbit, &Search { event, free, from: course.from, to: course.to }) else { continue };
            for one in &answer.located {
                let same = |other: &&vibrochain_floquet::Located| {
                    let close = 16.0 * (one.error + other.error) + 1e-12 * one.value.abs();
                    other.event == event && (other.value - one.value).abs() <= close
                };
                found[kind] += 1;
                if !branch.events().any(|other| same(&other)) {
                    missed.push(format!(
                        "{event} at {} = {} ± {:e}, {:?} from {:?}",
                        free,
                        one.value,
                        one.error,
                        orbit.family(),
                        orbit.model()
                    ));
                }
            }
        }
        orbits += 1;
        orbits < most
    });
    assert!(missed.is_empty(), "{found:?}: {} missed: {missed:#?}", missed.len());
    assert!(found.iter().all(|count| *count >= least), "{found:?}");
}

/// Multipliers outside the circle, of all.
fn outside(orbit: &vibrochain_breather::Orbit, analyser: &mut Analyser, finder: &mut Finder) -> Option<usize> {
    let stability = analyser.stability(orbit, finder, Tolerance::Rounding).ok()?;
    let far = |value: f64| (1e-6..).contains(&value);
    if stability.multipliers.iter().any(|value| (1e-9..1e-6).contains(&(value.norm() - 1.0))) {
        return None;
    }
    Some(stability.multipliers.iter().filter(|value| far(value.norm() - 1.0)).count())
}

/// Between two events the number of multipliers outside the circle stays what it is, wherever one looks: a stripe that was missed would
/// show as one that comes and goes.
#[test]
fn no_stripe_of_instability_hides_between_events() {
    let ring = |gamma2: f64| Chain::new(21, 0.2, gamma2).unwrap();
    // A row with free ends, hit neither in its middle nor at its end, and two layers: thirteen and eight modes that feel it.
    let row = Chain::new(13, 0.2, 0.05).unwrap().with_ends(Ends::Free);
    let layers = Chain::new(7, 0.2, 0.05).unwrap().with_layers(2, 0.03, Ends::Free).unwrap();
    let cases = [
        (ring(0.1), "0+,0-", 1.0, 1.6, 70),
        (ring(0.02), "0+,0-", 0.9, 1.1, 40),
        (ring(0.005), "0+,0-", 0.9, 1.0, 40),
        (row, "3+,3-", 0.95, 1.3, 30),
        (layers, "0+,0-", 1.0, 1.2, 20),
        // Two sites that are mirror images, of which two kinds of multipliers pass each other, and two that are none.
        (Chain::new(10, 0.2, 0.05).unwrap(), "0+3+,0-3-", 1.0, 1.6, 30),
        (Chain::new(7, 0.2, 0.05).unwrap().with_ends(Ends::Free), "2+3+,2-3-", 1.0, 1.6, 20),
    ];
    for (chain, word, from, to, least) in cases {
        let model = Model::conservative(chain, 0.5 * (from + to), 0.4).unwrap();
        let found = |omega: f64| {
            let (mut finder, mut found) = (Finder::new(chain.sites()), OrbitList::default());
            let model = model.with(Parameter::Omega, omega).unwrap();
            finder.find_word(&model, &word.parse().unwrap(), Scope::All, &mut found).unwrap();
            found.orbits
        };
        let orbit = &found(model.omega())[0];
        let course = Course { from, to, ..Course::new(orbit, Parameter::Omega) };
        let whole = diagram(orbit, &course).unwrap();
        let branch = &whole.branches[0];
        println!(
            "{chain:?}: {} events, {} of {} steps untold",
            branch.events().count(),
            branch.untold,
            branch.points().count()
        );
        let mut borders: Vec<f64> = branch.events().map(|found| found.value).collect();
        for place in &branch.unresolved {
            borders.extend([place.from, place.to]);
        }
        borders.extend([from, to]);
        borders.sort_by(f64::total_cmp);
        assert!(borders.len() > least, "{}", borders.len());
        let (mut analyser, mut finder, mut checked, mut changes) =
            (Analyser::default(), Finder::new(chain.sites()), 0, 0);
        let (mut last, mut hidden) = (None, 0);
        for pair in borders.windows(2) {
            let mut counts = Vec::new();
            if branch.unresolved.iter().any(|place| place.from <= pair[0] && pair[1] <= place.to) {
                hidden += 1;
                continue;
            }
            for i in 1..40 {
                let omega = pair[0] + (pair[1] - pair[0]) * f64::from(i) / 40.0;
                counts.extend(found(omega).first().and_then(|orbit| outside(orbit, &mut analyser, &mut finder)));
            }
            let Some(&first) = counts.first() else { continue };
            assert!(counts.iter().all(|count| *count == first), "{pair:?} {counts:?}");
            changes += usize::from(last.is_some_and(|last| last != first));
            last = Some(first);
            checked += counts.len();
        }
        // What rounding hides is told, and is little.
        assert!(hidden <= 6, "{hidden} of {}", borders.len());
        assert!(checked > 20 * least && changes > least / 2, "{checked} {changes} of {}", borders.len());
    }
}

fn model_of_the_errata(amplitude: f64) -> Model {
    let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    ring.omega(1.07).asymmetry(0.8).amplitude(amplitude).restitution(0.25).model().unwrap()
}

/// Worked out once, for all tests that look at it.
static DIAGRAM_OF_THE_ERRATA: LazyLock<Diagram> = LazyLock::new(|| {
    let orbit = &breathers(&model_of_the_errata(0.165), Family::SingleSided).unwrap().orbits[0];
    let course = Course { from: 0.15, to: 0.17, generations: 4, ..Course::new(orbit, Parameter::Amplitude) };
    diagram(orbit, &course).unwrap()
});

fn has(branch: &FollowedBranch, event: Event, value: f64, digits: f64) -> bool {
    branch.events().any(|found| found.event == event && (found.value - value).abs() < digits)
}

#[test]
fn the_points_of_the_errata_in_one_run_each() {
    let whole = &*DIAGRAM_OF_THE_ERRATA;
    let own = &whole.branches[0];
    assert!(has(own, Event::PeriodDoubling, 0.158908086, 5e-10) && has(own, Event::Fold, 0.157927457267, 5e-13));
    // Round the fold the branch goes on to the end that it came from.
    assert!(own.ends.iter().all(|(value, end)| *value == 0.17 && *end == End::Range) && own.ends.len() == 2);

    let chain = Chain::new(21, 0.1, 0.05).unwrap();
    let model = chain.point().omega(1.33).amplitude(1.5).restitution(0.5).model().unwrap();
    let orbit = &breathers(&model, Family::DoubleSided).unwrap().orbits[0];
    let course = Course { from: 0.4, to: 0.7, generations: 1, ..Course::new(orbit, Parameter::Restitution) };
    let whole = diagram(orbit, &course).unwrap();
    assert!(has(&whole.branches[0], Event::Pitchfork, 0.524585314448, 5e-13));
    // The asymmetric pair, of which one stands for both.
    let pair: Vec<_> = whole.branches.iter().filter(|branch| branch.generation == 1).collect();
    assert!(pair.len() == 1 && pair[0].points().skip(1).all(|point| point.value > 0.5245));

    let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    let model = ring.omega(0.94).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
    let grazing = 0.9304428418073;
    for family in [Family::SingleSided, Family::DoubleSided] {
        let near = breathers(&model, family).unwrap().orbits.iter().any(|orbit| {
            let course = Course { from: 0.925, to: 0.95, ..Course::new(orbit, Parameter::Omega) };
            has(&diagram(orbit, &course).unwrap().branches[0], Event::Grazing, grazing, 1e-12)
        });
        let single = breathers(&model.with(Parameter::Omega, 0.928).unwrap(), family).unwrap().orbits;
        let below = || {
            single.iter().any(|orbit| {
                let course = Course { from: 0.925, to: 0.95, ..Course::new(orbit, Parameter::Omega) };
                has(&diagram(orbit, &course).unwrap().branches[0], Event::Grazing, grazing, 1e-12)
            })
        };
        assert!(near || below(), "{family:?}");
    }
}

/// Orbits of branches that were taken up on the way have more impacts and longer periods than any family: they hold in many digits,
/// and a simulated period leads back to its start.
#[test]
fn what_branches_off_is_made_of_orbits() {
    let whole = &*DIAGRAM_OF_THE_ERRATA;
    let (mut held, mut closed, mut longest, mut largest) = (0, 0, 0, 0);
    for branch in whole.branches.iter().filter(|branch| branch.generation > 0) {
        for point in branch.points().skip(1).step_by(9).filter(|point| point.physical == Some(true)) {
            let orbit = &point.orbit;
            let truth = TrueOrbit::refine(orbit, DEFAULT_BITS).unwrap();
            let error = truth.error_of(orbit).unwrap();
            assert!(error.impulse < 1e-9 && error.time < 1e-9, "{error:?} at {}", point.value);
            held += 1;
            let map = ReturnMap::new(orbit);
            if map.slowest_impact() > 1e-3 {
                let start = map.fixed_point();
                assert!((map.apply(&start) - start).amax() < 1e-9, "{} {:?}", point.value, orbit.impacts().len());
                closed += 1;
            }
            longest = longest.max(orbit.force_periods());
            largest = largest.max(orbit.impacts().len());
        }
    }
    assert!(held >= 20 && closed >= 10 && longest == 2 && largest >= 6, "{held} {closed} {longest} {largest}");
}

/// At a grazing the two words meet: the orbit that has one more impact begins with none of its impulse, and the event is on both.
#[test]
fn at_grazing_the_word_changes() {
    let whole = &*DIAGRAM_OF_THE_ERRATA;
    let mut met = 0;
    for branch in whole.branches.iter().filter(|branch| branch.origin.is_some()) {
        let origin = branch.origin.unwrap();
        let parent: Vec<_> = whole.branches[origin.branch].stations.iter().collect();
        let vibrochain_floquet::Station::Event(event) = parent[origin.station] else { continue };
        let Evidence::Touch(touch) = event.evidence else { continue };
        let first = branch.points().next().unwrap();
        assert!((first.value - event.value).abs() < 1e-9);
        let strengths: Vec<f64> =
            first.orbit.impacts().iter().filter(|hit| hit.site == touch.site).map(|hit| hit.impulse.abs()).collect();
        assert!(!strengths.is_empty() && strengths.iter().all(|impulse| *impulse < 1e-6), "{strengths:?}");
        // As long as it is physical, its impulse grows.
        let second = branch.points().nth(1).unwrap();
        assert!(second.physical == Some(true) && second.margin.is_some_and(|margin| margin > 0.0));
        met += 1;
    }
    assert!(met >= 2, "{met}");
}

/// The events of a branch are those of the branch, wherever on it one starts: with losses, where several pairs cross the circle within
/// one step; from masses without coupling, which have no multiplier that moves; to the end of what a parameter may be.
#[test]
fn events_do_not_depend_on_the_start() {
    let chain = Chain::new(15, 0.465, 0.048).unwrap();
    let lossy = chain.point().omega(1.662).asymmetry(0.504).amplitude(0.582).model().unwrap();
    let uncoupled = Model::conservative(Chain::new(5, 0.2, 0.0).unwrap(), 1.07, 0.3).unwrap();
    let cases = [
        (lossy, "0+,0-", Parameter::Restitution, 0.98902, (0.1, 1.0), 8),
        (uncoupled, "0+,0-", Parameter::Gamma2, 0.05, (0.0, 0.2), 8),
        (uncoupled.with(Parameter::Gamma2, 0.05).unwrap(), "0+1+,0-1-", Parameter::Gamma2, 0.01, (0.0, 0.12), 0),
    ];
    for (model, word, free, other, (from, to), least) in cases {
        let run = |model: &Model| {
            let (mut finder, mut found) = (Finder::new(model.chain().sites()), OrbitList::default());
            finder.find_word(model, &word.parse().unwrap(), Scope::All, &mut found).unwrap();
            let whole = diagram(&found.orbits[0], &Course { from, to, ..Course::new(&found.orbits[0], free) }).unwrap();
            let ends: Vec<End> = whole.branches[0].ends.iter().map(|(_, end)| end.clone()).collect();
            let mut events: Vec<(f64, Event)> =
                whole.branches[0].events().map(|found| (found.value, found.event)).collect();
            events.sort_by(|a, b| a.0.total_cmp(&b.0));
            (events, ends)
        };
        let (one, one_ends) = run(&model);
        let (two, two_ends) = run(&model.with(free, other).unwrap());
        assert_eq!((one.len(), &one_ends), (two.len(), &two_ends), "{one:?} {two:?}");
        assert!(one.len() >= least && one_ends.iter().all(|end| *end == End::Range), "{one:?} {one_ends:?}");
        for ((a, kind), (b, other)) in one.iter().zip(&two) {
            assert!((a - b).abs() < 1e-9 && kind == other, "{kind} at {a}, {other} at {b}");
        }
    }
}

/// However short the range, an event in it is found, or it is said that rounding hides it.
#[test]
fn nothing_is_left_out_in_a_short_range() {
    let place = 1.5440836283656;
    let model = Model::conservative(Chain::new(31, 0.2, 0.1).unwrap(), place + 3e-8, 0.4).unwrap();
    let orbit = &breathers(&model, Family::DoubleSided).unwrap().orbits[0];
    let mut told = [0; 2];
    for reach in [1e-4, 1e-5, 1e-6, 1e-7] {
        let (from, to) = (place - reach, place + reach);
        let search = Search { event: Event::PeriodDoubling, free: Parameter::Omega, from, to };
        let answer = locate(orbit, &search).unwrap();
        let found = answer.located.iter().any(|found| (found.value - place).abs() <= found.error + 1e-12);
        let hidden = answer.unresolved.iter().any(|range| range.from <= place + 1e-12 && place - 1e-12 <= range.to);
        assert!(found || hidden, "{reach:e}");
        told[usize::from(hidden)] += 1;
    }
    assert!(told[0] >= 2, "{told:?}");
}
