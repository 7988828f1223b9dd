//! Bifurcations of random models against the lists of all orbits on both sides of them: what is handed over, and the two
//! orbits that meet in a fold; and what tells that they are where they are.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Family, Motion, Orbit, breathers};
use vibrochain_floquet::{Course, Event, Evidence, Located, Search, diagram, locate};
use vibrochain_lattice::{Model, Parameter};
use vibrochain_testkit::Values::{Even, Is, Log};
use vibrochain_testkit::{Random, Ranges};

/// Models drawn for each event that is wanted, at most: one in ten or so has one.
const MOST_DRAWS: usize = 200;

/// A model with orbits of the kind that bifurcates: single-sided ones double their period, double-sided ones need a symmetry
/// to break.
fn draw(random: &mut Random, event: Event) -> Model {
    let (asymmetry, restitution) = match event {
        Event::PeriodDoubling => (Even(0.0, 0.95), Log(0.05, 1.0)),
        _ if random.chance(0.5) => (Is(0.0), Log(0.2, 1.0)),
        _ => (Even(0.0, 0.9), Is(1.0)),
    };
    random.model(&Ranges {
        sites: [1, 7],
        gamma1: Log(0.05, 0.8),
        gamma2: Log(0.01, 0.4),
        omega: Log(0.4, 2.2),
        asymmetry,
        amplitude: Log(0.05, 2.0),
        restitution,
    })
}

/// Distance of an orbit from the one that bifurcates: of its time from half its period, and of its impulses.
fn distance(orbit: &Orbit, from: &Orbit) -> f64 {
    let largest = from.impacts().iter().map(|impact| impact.impulse.abs()).fold(0.0, f64::max);
    // A doubled orbit has twice the impacts.
    let pairs = orbit.impacts().iter().zip(from.impacts().iter().cycle());
    let impulses = pairs.map(|(a, b)| (a.impulse - b.impulse).abs() / largest).fold(0.0, f64::max);
    offset(orbit) + impulses
}

/// |φ/T − ½|
fn offset(orbit: &Orbit) -> f64 {
    (orbit.phi().unwrap() / orbit.period() - 0.5).abs()
}

/// The orbits of lower symmetry that a list has at this value, with their distances; `None` where it cannot say.
fn listed(found: &Located, free: Parameter, family: Family, value: f64) -> Option<Vec<(f64, Orbit)>> {
    let model = found.orbit.model().unwrap().with(free, value).ok()?;
    let list = breathers(&model, family).ok().filter(|list| list.completeness.open() == (0, 0))?;
    let lower = list.orbits.into_iter().filter(|orbit| offset(orbit) > 1e-8);
    Some(lower.map(|orbit| (distance(&orbit, &found.orbit), orbit)).collect())
}

/// The orbits on one side that come nearer like the root of the distance `d` in the parameter, at `d`.
fn arriving(found: &Located, free: Parameter, family: Family, d: f64) -> Option<Vec<Orbit>> {
    let lists: Option<Vec<_>> =
        [1.0, 0.25, 0.0625].iter().map(|part| listed(found, free, family, found.value + part * d)).collect();
    let [far, near, nearest] = <[_; 3]>::try_from(lists?).ok()?;
    let half = |a: f64, b: f64| (0.42..0.58).contains(&(b / a));
    let arrives = |(far, orbit): &(f64, Orbit)| {
        let followed = near.iter().filter(|(there, _)| half(*far, *there));
        let mut twice = followed.filter(|(there, _)| nearest.iter().any(|(last, _)| half(*there, *last)));
        (*far < 0.1 && twice.next().is_some()).then(|| orbit.clone())
    };
    Some(far.iter().filter_map(arrives).collect())
}

/// The same orbit, as closely as rounding of the parameter allows at a distance `d` from the bifurcation.
fn same(a: &Orbit, b: &Orbit, value: f64, d: f64) -> bool {
    let pairs = a.impacts().iter().zip(b.impacts());
    let worst = pairs.map(|(a, b)| (a.impulse - b.impulse).abs().max((a.time - b.time).abs() / b.time.max(1.0)));
    worst.fold(0.0, f64::max) < 1e-7 + 1e-13 * (value / d).abs()
}

fn every_handover_is_in_the_lists(event: Event, family: Family, branched: Family, seed: u64, wanted: usize) {
    let mut random = Random(seed);
    let (mut handed, mut none, mut undecided) = (0, 0, 0);
    for _ in 0..MOST_DRAWS * wanted {
        if handed >= wanted {
            break;
        }
        let model = draw(&mut random, event);
        let free = random.of(Parameter::of(1));
        let Ok(list) = breathers(&model, family) else { continue };
        if list.orbits.is_empty() {
            continue;
        }
        let orbit = &list.orbits[random.below(list.orbits.len())];
        // A symmetry that the parameter breaks is none.
        let broken = [(Parameter::Asymmetry, 0.0), (Parameter::Restitution, 1.0)];
        if event == Event::Pitchfork && (broken.contains(&(free, model.get(free))) || offset(orbit) > 1e-9) {
            continue;
        }
        let Ok(answer) = locate(orbit, &Search::new(orbit, event, free)) else { continue };
        for found in &answer.located {
            let Some(branching) = &found.branching else {
                none += 1;
                let d = 1e-4 * found.value.abs();
                for d in [d, -d] {
                    let there = arriving(found, free, branched, d);
                    assert!(
                        there.is_none_or(|there| there.is_empty()),
                        "nothing handed over: {model:?} {free:?} {found:?}"
                    );
                }
                continue;
            };
            let d = branching.value - found.value;
            assert_eq!(branching.above, d > 0.0);
            assert!(!branching.orbits.is_empty());
            let Some(here) = listed(found, free, branched, branching.value) else {
                undecided += 1;
                continue;
            };
            for given in &branching.orbits {
                let listed = here.iter().any(|(_, orbit)| same(orbit, &given.orbit, found.value, d));
                assert!(listed, "not in the list: {model:?} {free:?} {} {given:?}", found.value);
            }
            let (Some(there), Some(beyond)) = (arriving(found, free, branched, d), arriving(found, free, branched, -d))
            else {
                undecided += 1;
                continue;
            };
            // All that arrive are handed over, and none arrives from the other side.
            for orbit in &there {
                let given = branching.orbits.iter().any(|given| same(orbit, &given.orbit, found.value, d));
                assert!(given, "left out: {model:?} {free:?} {} {orbit:?}", found.value);
            }
            assert!(beyond.is_empty(), "on the other side, too: {model:?} {free:?} {} {beyond:?}", found.value);
            handed += 1;
        }
    }
    println!("{handed} handed over, {none} without, {undecided} undecided");
    assert!(handed >= wanted, "{handed} of {wanted}");
    assert!(undecided + none <= wanted / 10, "{none} without, {undecided} undecided");
}

#[test]
fn at_period_doublings() {
    every_handover_is_in_the_lists(Event::PeriodDoubling, Family::SingleSided, Family::PeriodDoubled, 24, 300);
}

#[test]
fn at_pitchforks() {
    every_handover_is_in_the_lists(Event::Pitchfork, Family::DoubleSided, Family::DoubleSided, 25, 40);
}

#[test]
#[ignore = "half a minute: cargo test --workspace --test branching -- --ignored slow"]
fn slow_at_pitchforks() {
    every_handover_is_in_the_lists(Event::Pitchfork, Family::DoubleSided, Family::DoubleSided, 25, 100);
}

/// How many orbits a list has; `None` where it may not be all.
fn count(found: &Located, free: Parameter, value: f64) -> Option<usize> {
    let model = found.orbit.model().unwrap().with(free, value).ok()?;
    let list = breathers(&model, found.orbit.family()).ok()?;
    (list.completeness.open() == (0, 0)).then_some(list.orbits.len())
}

#[test]
fn every_fold_ends_two_orbits() {
    let mut random = Random(26);
    let (mut checked, mut undecided) = (0, 0);
    for _ in 0..60 * MOST_DRAWS {
        if checked >= 60 {
            break;
        }
        let model = draw(&mut random, Event::PeriodDoubling);
        let free = random.of(Parameter::of(1));
        let family = random.of(&[Family::SingleSided, Family::DoubleSided, Family::PeriodDoubled]);
        let Ok(list) = breathers(&model, family) else { continue };
        if list.orbits.is_empty() {
            continue;
        }
        let orbit = &list.orbits[random.below(list.orbits.len())];
        let Ok(answer) = locate(orbit, &Search::new(orbit, Event::Fold, free)) else { continue };
        for found in &answer.located {
            // A doubled orbit that meets itself, begun at the other impact, is one orbit.
            let (phi, period) = (found.orbit.phi().unwrap_or(0.0), found.orbit.period());
            if family == Family::PeriodDoubled && (phi - 0.5 * period).abs() < 0.05 * period {
                continue;
            }
            // With a dashpot no list tells impacts apart that are as close as that.
            if found.orbit.model().unwrap().is_damped() && (period - phi).min(phi) < 3e-4 * period && phi > 0.0 {
                continue;
            }
            // Nearer lists cannot tell the two apart, farther something else may happen.
            let counts = [1e-6, 1e-7, 1e-5].map(|part| {
                let d = part * found.value.abs();
                let (low, high) = (count(found, free, found.value - d)?, count(found, free, found.value + d)?);
                Some(low.abs_diff(high))
            });
            if counts.iter().all(Option::is_none) {
                undecided += 1;
                continue;
            }
            assert!(counts.contains(&Some(2)), "{model:?} {free:?} {} ± {:e}: {counts:?}", found.value, found.error);
            checked += 1;
        }
    }
    println!("{checked} checked, {undecided} undecided");
    assert!(checked >= 60 && undecided <= 6, "{checked} {undecided}");
}

/// Along branches of doubled orbits the longer flight comes first, whichever that is: evidence names the impact, or the time, of the orbit as it is told.
#[test]
fn evidence_is_of_the_orbit_that_is_told() {
    let mut random = Random(67);
    let (mut vanishing, mut touching, mut doubled) = (0, 0, 0);
    for _ in 0..60 {
        let model = random.model(&Ranges { sites: [1, 5], gamma2: Log(1e-3, 0.2), ..Ranges::FORCED });
        let Ok(found) = breathers(&model, Family::PeriodDoubled) else { continue };
        for orbit in &found.orbits {
            let Ok(diagram) = diagram(orbit, &Course::new(orbit, Parameter::Amplitude)) else { continue };
            for located in diagram.branches[0].events() {
                let impacts = located.orbit.impacts();
                let fastest = impacts.iter().map(|impact| impact.velocity_before.abs()).fold(0.0, f64::max);
                match located.evidence {
                    Evidence::Impact(i) => {
                        assert!(impacts[i].velocity_before.abs() < 1e-7 * fastest, "{model} {i} {impacts:?}");
                        vanishing += 1;
                    }
                    Evidence::Touch(touch) => {
                        let mass = Motion::of(&located.orbit).unwrap().at(touch.site, touch.time);
                        let wall = located.orbit.model().unwrap().barrier(touch.barrier);
                        let apart = (mass.displacement - wall).abs();
                        assert!(apart < 1e-7 && mass.velocity.abs() < 1e-3 * fastest, "{model} {touch:?} {apart:e}");
                        touching += 1;
                    }
                    Evidence::Multiplier(_) => continue,
                }
                let [first, second] = impacts else { continue };
                assert!(second.time - first.time >= 0.5 * located.orbit.period() * (1.0 - 1e-9), "{model} {impacts:?}");
                doubled += 1;
            }
        }
    }
    assert!(vanishing > 5 && touching > 2 && doubled > 5, "{vanishing} {touching} {doubled}");
}
