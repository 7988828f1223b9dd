//! Words whose impacts at one instant a symmetry of the lattice makes alike: their lists under a force are proved, and their orbits return in a
//! simulated map.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Finder, OrbitList, Scope, Word};
use vibrochain_lattice::{Chain, Ends, Model};
use vibrochain_testkit::{Random, ReturnMap};

/// A ring, or a row of free ends, under a force whose swing without impacts is about as wide as the gap.
fn random_model(random: &mut Random) -> Option<Model> {
    let chain = Chain::new(3 + random.below(4), random.between(0.05, 1.0), random.log(0.003, 0.1)).unwrap();
    let chain = if random.chance(0.3) { chain.with_ends(Ends::Free) } else { chain };
    let omega = random.between(0.5, 2.5);
    let swing = (chain.gamma1() - omega * omega).abs();
    let point = chain.point().omega(omega).asymmetry(random.between(0.3, 0.9));
    point.amplitude(swing * random.log(0.1, 1.0)).restitution(random.between(0.3, 0.9)).model().ok()
}

/// Up to three instants at which all masses of a ring hit, or a mass and its mirror image, or in place of these one on the mirror. Two of them hit
/// together at least.
fn random_word(random: &mut Random, model: &Model) -> Word {
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
    (0..count).map(instant).collect::<Vec<_>>().join(",").parse().unwrap()
}

#[test]
fn lists_are_proved_and_their_orbits_return() {
    let (mut random, mut found) = (Random(23), OrbitList::default());
    let (mut asked, mut complete, mut orbits, mut physical) = (0, 0, 0, 0);
    while asked < 200 {
        let Some(model) = random_model(&mut random) else { continue };
        let word = random_word(&mut random, &model);
        if word.instants().iter().all(|letters| letters.len() == 1) {
            continue;
        }
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
            let is_physical = finder.admissibility(orbit).unwrap().is_physical();
            physical += usize::from(is_physical);
        }
    }
    let counts = (asked, complete, orbits, physical);
    println!("asked, complete, orbits, physical: {counts:?}");
    assert!(complete >= 198 && orbits > 150 && physical > 20, "{counts:?}");
}
