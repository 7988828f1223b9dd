//! Words of two and three impacts under a force: their lists are proved, and their orbits return in a simulated map. Of longer words lists hold no
//! orbit of a shorter one.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Finder, OrbitList, Scope, Word};
use vibrochain_lattice::{Chain, Ends, Model};
use vibrochain_testkit::{Random, ReturnMap};

/// A few masses under a force whose swing without impacts is about as wide as the gap.
fn random_model(random: &mut Random, sites: [usize; 2]) -> Option<Model> {
    let sites = sites[0] + random.below(sites[1] - sites[0] + 1);
    let chain = Chain::new(sites, random.between(0.05, 1.0), random.log(0.003, 0.1)).unwrap();
    forced(random, chain)
}

fn forced(random: &mut Random, chain: Chain) -> Option<Model> {
    let omega = random.between(0.5, 2.5);
    let swing = (chain.gamma1() - omega * omega).abs();
    let point = chain.point().omega(omega).asymmetry(random.between(0.3, 0.9));
    point.amplitude(swing * random.log(0.1, 1.0)).restitution(random.between(0.3, 0.9)).model().ok()
}

/// Two or three impacts at one mass or several, not all alike where that could repeat sooner.
fn random_word(random: &mut Random, sites: usize) -> Option<Word> {
    let impacts = 2 + random.below(2);
    // On the nearer barrier most of the time.
    let letters: Vec<(usize, char)> =
        (0..impacts).map(|i| ((i + random.below(2)) % sites, if random.chance(0.2) { '+' } else { '-' })).collect();
    let several = letters.iter().any(|(site, _)| *site != letters[0].0);
    let text: Vec<String> = letters.iter().map(|(site, side)| format!("{site}{side}")).collect();
    (several || impacts == 3).then(|| text.join(",").parse().unwrap())
}

/// How many of so many lists are proved, and their orbits, each of which returns.
fn lists(count: usize, seed: u64, draw: impl Fn(&mut Random) -> Option<(Model, Word)>) -> (usize, usize, usize, usize) {
    let (mut random, mut found) = (Random(seed), OrbitList::default());
    let (mut asked, mut complete, mut orbits, mut physical) = (0, 0, 0, 0);
    while asked < count {
        let Some((model, word)) = draw(&mut random) else { continue };
        let mut finder = Finder::new(model.chain().sites());
        if finder.find_word(&model, &word, Scope::All, &mut found).is_err() {
            continue;
        }
        asked += 1;
        complete += usize::from(found.completeness.is_established());
        for orbit in &found.orbits {
            orbits += 1;
            assert!(orbit.residual() < 1e-11, "{word} {model}: {:e}", orbit.residual());
            let map = ReturnMap::new(orbit);
            let (point, scale) = (map.fixed_point(), 1.0 + orbit.strength());
            let off = (map.apply(&point) - &point).amax();
            assert!(off < 1e-9 * scale, "{word} {model}: {off:e}");
            physical += usize::from(finder.admissibility(orbit).unwrap().is_physical());
        }
    }
    (asked, complete, orbits, physical)
}

fn in_sequence(random: &mut Random) -> Option<(Model, Word)> {
    let model = random_model(random, [2, 5])?;
    Some((model, random_word(random, model.chain().sites())?))
}

fn at_once(random: &mut Random) -> Option<(Model, Word)> {
    let model = symmetric_model(random)?;
    Some((model, word_at_once(random, &model)?))
}

/// A ring, or a row of free ends, under a force whose swing without impacts is about as wide as the gap.
fn symmetric_model(random: &mut Random) -> Option<Model> {
    let chain = Chain::new(3 + random.below(4), random.between(0.05, 1.0), random.log(0.003, 0.1)).unwrap();
    let chain = if random.chance(0.3) { chain.with_ends(Ends::Free) } else { chain };
    forced(random, chain)
}

/// Up to three instants at which all masses of a ring hit, or a mass and its mirror image, or in place of these one on the mirror. Two of them hit
/// together at least.
fn word_at_once(random: &mut Random, model: &Model) -> Option<Word> {
    let (sites, is_ring) = (model.chain().sites(), model.chain().is_ring());
    let first = random.below(sites);
    let mirror = if is_ring { random.below(sites) } else { sites - 1 };
    let image = |site: usize| (mirror + sites - site) % sites;
    let is_whole = is_ring && random.chance(0.15);
    let mut together = if is_whole { (0..sites).collect() } else { vec![first, image(first)] };
    together.sort_unstable();
    together.dedup();
    let middle = (0..sites).find(|site| image(*site) == *site).filter(|_| !is_whole);
    let count = 1 + random.below(3);
    let instant = |_| {
        let masses = middle.filter(|_| random.chance(0.25)).map_or_else(|| together.clone(), |middle| vec![middle]);
        let side = if random.chance(0.3) { '+' } else { '-' };
        masses.iter().map(|mass| format!("{mass}{side}")).collect::<String>()
    };
    let word: Word = (0..count).map(instant).collect::<Vec<_>>().join(",").parse().unwrap();
    word.instants().iter().any(|letters| letters.len() > 1).then_some(word)
}

#[test]
fn lists_are_proved_and_their_orbits_return() {
    let counts = lists(100, 17, in_sequence);
    println!("asked, complete, orbits, physical: {counts:?}");
    let (asked, complete, orbits, physical) = counts;
    assert!(asked == 100 && complete >= 98 && orbits > 60 && physical > 5, "{counts:?}");
}

/// The same of impacts at one instant that a symmetry of the lattice makes alike.
#[test]
fn lists_of_masses_that_hit_together_are_proved_and_their_orbits_return() {
    let counts = lists(200, 23, at_once);
    println!("asked, complete, orbits, physical: {counts:?}");
    let (asked, complete, orbits, physical) = counts;
    assert!(asked == 200 && complete >= 198 && orbits > 150 && physical > 20, "{counts:?}");
}

/// Two instants that are one to rounding, or a word gone through twice, would be the orbit of a shorter word.
#[test]
fn no_orbit_of_a_shorter_word_is_listed() {
    let (mut random, mut found) = (Random(41), OrbitList::default());
    let (mut orbits, mut physical) = (0, 0);
    for round in 0..120 {
        let Some(model) = random_model(&mut random, [2, 5]) else { continue };
        let sites = model.chain().sites();
        let model = match round % 2 {
            0 => model,
            _ => Model::conservative(*model.chain(), model.omega(), model.asymmetry()).unwrap(),
        };
        let letters: Vec<String> = (0..4)
            .map(|i| format!("{}{}", (i + random.below(2)) % sites, if random.chance(0.4) { '+' } else { '-' }))
            .collect();
        let word: Word = letters.join(",").parse().unwrap();
        let mut finder = Finder::new(sites);
        if finder.find_word(&model, &word, Scope::All, &mut found).is_err() {
            continue;
        }
        for orbit in &found.orbits {
            let (period, impacts) = (orbit.period(), orbit.impacts());
            let ends = impacts[1..].iter().map(|impact| impact.time).chain([period]);
            let least = impacts.iter().zip(ends).map(|(impact, end)| end - impact.time).fold(period, f64::min);
            assert!(least > 1e-9 * period, "{word} {model}: {least:e}");
            let alike = |i: usize, j: usize| {
                (impacts[i].site, impacts[i].barrier) == (impacts[j].site, impacts[j].barrier)
                    && (impacts[i].impulse - impacts[j].impulse).abs() < 1e-9
                    && (impacts[j].time - impacts[i].time - 0.5 * period).abs() < 1e-9 * period
            };
            assert!(!(alike(0, 2) && alike(1, 3)), "{word} {model}");
            orbits += 1;
            physical += usize::from(finder.admissibility(orbit).unwrap().is_physical());
        }
    }
    println!("{orbits} orbits, {physical} physical");
    assert!(orbits >= 15, "{orbits}");
}

#[test]
#[ignore = "ten seconds"]
fn slow_lists_at_a_thousand_points_are_proved() {
    let counts = lists(1000, 53, in_sequence);
    println!("asked, complete, orbits, physical: {counts:?}");
    assert!(counts.1 >= 990 && counts.3 >= 90, "{counts:?}");
}
