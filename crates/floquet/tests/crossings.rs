//! Pairs of multipliers that cross the circle along branches with losses, against scans: dense matrices of orbits that the tracer alone makes, so
//! many that next to none hides between two of them.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Branch, BranchPoint, Family, Finder, Orbit, OrbitList, Scope, breathers};
use vibrochain_floquet::{Analyser, Course, End, Event, FollowedBranch, Tolerance, diagram};
use vibrochain_lattice::{Parameter, Point};
use vibrochain_testkit::Values::{Even, Log};
use vibrochain_testkit::{Random, Ranges};

/// Points of a scan at most.
const MOST: usize = 100_000;

/// Multipliers outside the circle; `None` where one is too near to it to tell.
fn outside(orbit: &Orbit, (analyser, finder): (&mut Analyser, &mut Finder)) -> Option<usize> {
    let stability = analyser.stability(orbit, finder, Tolerance::Rounding).unwrap();
    let excess: Vec<f64> = stability.multipliers.iter().map(|mu| mu.norm() - 1.0).collect();
    // Modes that an impact does not feel are on it.
    let open = excess.iter().any(|excess| (1e-12..1e-10).contains(&excess.abs()));
    (!open).then(|| excess.iter().filter(|excess| **excess > 1e-11).count())
}

/// A point of a branch.
struct Passed {
    value: f64,
    heading: f64,
    orbit: Orbit,
}

/// Points of the branch through an orbit both ways, steps of the same length apart.
fn scan(orbit: &Orbit, (free, from, to): (Parameter, f64, f64), length: f64) -> Vec<Passed> {
    let mut branch = Branch::of_orbit(orbit, free, to - from).unwrap();
    let start = branch.start().unwrap();
    let mut way = |start: BranchPoint| {
        let mut points = vec![start];
        while let Ok(next) = branch.step(&points[points.len() - 1], length)
            && (from..=to).contains(&next.value())
            && points.len() < MOST
        {
            points.push(next);
        }
        points
    };
    let (mut points, ahead) = (way(start.reversed()), way(start));
    points.reverse();
    points.extend(ahead.into_iter().skip(1));
    let of_lattice = |point: &BranchPoint| {
        let orbit = point.orbit().to_orbit(orbit.family()).unwrap();
        Passed { value: point.value(), heading: point.heading(), orbit }
    };
    points.iter().map(of_lattice).collect()
}

/// Changes of the number outside the circle between neighbours of a scan: how many there are, and those that the branch has no event for, of pairs,
/// and of single ones, which cross at ±1.
fn held(branch: &FollowedBranch, points: &[Passed]) -> (usize, [Vec<[f64; 2]>; 2]) {
    let (mut changes, mut missed) = (0, [Vec::new(), Vec::new()]);
    let (mut analyser, mut finder) = (Analyser::dense(), Finder::new(points[0].orbit.model().unwrap().chain().sites()));
    let mut last: Option<(usize, &Passed)> = None;
    for point in points {
        let Some(count) = outside(&point.orbit, (&mut analyser, &mut finder)) else { continue };
        if let Some((before, from)) = last.filter(|(before, _)| *before != count) {
            let [low, high] = [from.value.min(point.value), from.value.max(point.value)];
            // At a fold the value goes beyond both.
            let turn = if from.heading * point.heading < 0.0 { 1e-2 * (high - low) + 1e-7 } else { 0.0 };
            let room = 1e-9 * high.abs() + turn;
            // At one value there may be two orbits of the branch.
            let apart = |one: &Orbit| {
                let pairs = one.impacts().iter().zip(point.orbit.impacts());
                pairs.map(|(a, b)| (a.impulse - b.impulse).abs()).fold(0.0, f64::max)
            };
            let reach = 3.0 * apart(&from.orbit).max(1e-6);
            let mut events = branch.events();
            changes += 1;
            if !events.any(|one| (low - room..=high + room).contains(&one.value) && apart(&one.orbit) <= reach) {
                missed[before.abs_diff(count) % 2].push([low, high]);
            }
        }
        last = Some((count, point));
    }
    (changes, missed)
}

#[test]
fn no_pair_is_lost_that_leaves_the_circle_and_comes_back() {
    let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
    let orbit = &breathers(&model, Family::DoubleSided).unwrap().orbits[0];
    let along = (Parameter::Omega, 1.3, 2.0);
    let whole = diagram(orbit, &Course { from: along.1, to: along.2, ..Course::new(orbit, along.0) }).unwrap();
    let branch = &whole.branches[0];
    assert!(branch.untold == 0 && branch.unresolved.is_empty(), "{} {:?}", branch.untold, branch.unresolved);
    // Both ways round the fold at the resonance above.
    let (changes, missed) = held(branch, &scan(orbit, along, 5e-4));
    assert!(missed.iter().all(Vec::is_empty), "{missed:?}");
    assert!(changes >= 70, "{changes}");
}

const RANGES: Ranges = Ranges {
    sites: [5, 41],
    gamma1: Log(0.05, 0.8),
    gamma2: Log(0.02, 0.3),
    omega: Log(0.6, 2.2),
    asymmetry: Even(0.0, 0.8),
    amplitude: Log(0.05, 0.5),
    restitution: Even(0.7, 0.99),
};

/// Two neighbours that hit together under a force: where they begin to hit apart the branch goes on with both together, and one multiplier, as a
/// dense matrix has it, crosses +1.
#[test]
fn a_pair_goes_on_together_where_it_parts() {
    let ring = Point::ring(10).gamma1(0.7098234875118328).gamma2(0.13329510600162323).omega(1.0846358015620017);
    let ring = ring.asymmetry(0.08491087757357713).amplitude(0.2981479009458731).restitution(0.5894820808347125);
    let (mut finder, mut found) = (Finder::new(10), OrbitList::default());
    finder.find_word(&ring.model().unwrap(), &"0-1-".parse().unwrap(), Scope::All, &mut found).unwrap();
    let orbit = &found.orbits[0];
    let (from, to) = (0.64, 0.78);
    let course = Course { from, to, events: vec![Event::Pitchfork], ..Course::new(orbit, Parameter::Gamma1) };
    let whole = diagram(orbit, &Course { generations: 0, ..course }).unwrap();
    let branch = &whole.branches[0];
    assert!(branch.ends.iter().all(|(_, end)| *end == End::Range), "{:?}", branch.ends);
    let parted: Vec<f64> = branch.events().map(|event| event.value).collect();
    assert_eq!(parted.len(), 2, "{parted:?}");
    let mut analyser = Analyser::dense();
    let mut beyond_one = |orbit: &Orbit| {
        let stability = analyser.stability(orbit, &mut finder, Tolerance::Rounding).unwrap();
        stability.multipliers.iter().filter(|mu| mu.im == 0.0 && mu.re > 1.0).count()
    };
    let points: Vec<_> = branch.points().collect();
    let mut crossed = 0;
    for pair in points.windows(2) {
        let [one, other] = [pair[0], pair[1]].map(|point| {
            let [a, b] = point.orbit.impacts() else { panic!("{:?}", point.orbit) };
            assert!(a.time == b.time && (a.impulse - b.impulse).abs() < 1e-12 * a.impulse.abs(), "{a:?} {b:?}");
            beyond_one(&point.orbit)
        });
        let (low, high) = (pair[0].value.min(pair[1].value), pair[0].value.max(pair[1].value));
        // At folds another one crosses.
        if parted.iter().any(|value| (low..=high).contains(value)) && one.abs_diff(other) == 1 {
            crossed += 1;
        }
    }
    assert_eq!(crossed, 2);
}

/// Of 40 random lattices with a few events each, scanned at 20 000 points. Of 24 of them three pairs of 1 500 changes were missed, all on one branch
/// (20 masses, single-sided, ω from 0.6286 to 0.6384).
#[test]
#[ignore = "slow, ten minutes: cargo test --workspace --test crossings -- --ignored slow"]
fn slow_hardly_a_pair_is_lost_on_random_lattices() {
    let (mut random, mut lattices, mut all, mut missed, mut hidden, mut untold) = (Random(53), 0, 0, 0, 0, 0);
    while lattices < 40 {
        let model = random.model(&RANGES);
        let family = random.of(&[Family::SingleSided, Family::DoubleSided]);
        let free = random.of(&[Parameter::Omega, Parameter::Omega, Parameter::Gamma2]);
        let Ok(list) = breathers(&model, family) else { continue };
        let Some(orbit) = list.orbits.first() else { continue };
        let (from, to) = (0.8 * model.get(free), 1.25 * model.get(free));
        let whole = diagram(orbit, &Course { from, to, ..Course::new(orbit, free) }).unwrap();
        let branch = &whole.branches[0];
        // A scan may leap over a resonance that ends a branch.
        let is_whole = branch.ends.iter().all(|(_, end)| matches!(end, End::Range | End::Closed));
        let coarse = scan(orbit, (free, from, to), COARSE);
        if !is_whole || branch.events().count() < 4 || !(50..MOST).contains(&coarse.len()) {
            continue;
        }
        let points = scan(orbit, (free, from, to), COARSE * coarse.len() as f64 / 20_000.0);
        let (changes, [pairs, single]) = held(branch, &points);
        let events = branch.events().count();
        println!(
            "{model:?} {family} {free}: {changes} changes, {events} events, untold {}, {pairs:?} {single:?}",
            branch.untold
        );
        // Two zeros of det J(−1) may be closer than its parabola sees.
        missed += pairs.len();
        (hidden, untold) = (hidden + single.len(), untold + branch.untold);
        (lattices, all) = (lattices + 1, all + changes);
    }
    println!("{all} changes, {missed} of pairs missed, {hidden} of single multipliers; {untold} steps untold");
    assert!(all > 1000 && 200 * missed < all && 50 * untold < all, "{all} {missed} {untold}");
}

/// The length of a step by which the length of a branch is found.
const COARSE: f64 = 4e-3;
