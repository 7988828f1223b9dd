//! Lists of orbits: the same orbits in the same order, physical and stable alike.

use std::sync::Arc;

use nalgebra::DMatrix;
use vibrochain_breather::{
    Completeness, Condition, Family, Finder, LoadedStructure, Orbit, OrbitList, Scope, Word, admissibility,
};
use vibrochain_floquet::{Analyser, Tolerance, stability};
use vibrochain_lattice::{Force, Harmonic, Model, Point, Structure};
use vibrochain_testkit::{Meeting, Random, Ranges, Values};

use crate::{matrices, structure, word};

/// By what part answers may differ because the entries of matrices, sums of stiffnesses, are rounded. Next to a resonance impulses grow like the
/// inverse of its distance, and so does the response of the mode to them.
fn rounding_of_matrices(condition: &Condition) -> f64 {
    8.0 * f64::EPSILON / condition.resonance.powi(2)
}

/// A difference modulo a period.
fn apart(a: f64, b: f64, period: f64) -> f64 {
    let way = (a - b).rem_euclid(period);
    way.min(period - way)
}

/// What both have been asked, and how far their answers were apart in units of the errors told.
#[derive(Debug, Default)]
struct Tally {
    lists: usize,
    /// Lists in which common orbits have one order.
    ordered: usize,
    orbits: usize,
    physical: usize,
    stable: usize,
    unstable: usize,
    /// Lists of the chain that say less, or were refused.
    fewer: usize,
    complete: usize,
    /// Orbits whose barriers pull that a complete list of the chain does not hold.
    pulled: usize,
    /// Orbits of a chain that are not in a structure's list, which does not say that it holds them.
    missed: usize,
    worst: f64,
}

impl Tally {
    /// Whether it is the same orbit, begun at whichever impact, to within what both tell of their errors.
    fn is_same(&mut self, chain: &Orbit, finder: &mut Finder, other: &Orbit) -> bool {
        let (own, impacts, period) = (chain.impacts(), other.impacts(), chain.period());
        if own.len() != impacts.len() || chain.force_periods() != other.force_periods() {
            return false;
        }
        let Ok(condition) = finder.condition(chain) else { return false };
        let count = own.len();
        let share = |turn: usize| {
            let since = |i: usize| {
                let place = (i + count - turn) % count;
                (own[i].time - own[turn].time, impacts[place], other.contacts().unwrap().impact_errors()[place])
            };
            let mut share = 0.0f64;
            for i in 0..count {
                let (time, impact, off) = since(i);
                if impact.site != own[i].site || impact.barrier != own[i].barrier {
                    return f64::INFINITY;
                }
                let told = &condition.impacts[i];
                // Where no bound is known, they are near enough to be no other's.
                let room = |error: f64, bound: f64, size: f64| {
                    let bound = if bound.is_finite() { bound } else { 1e-6 * size };
                    error + bound + rounding_of_matrices(&condition) * size
                };
                let impulse = (impact.impulse - own[i].impulse).abs();
                share = share.max(impulse / room(told.impulse, off.impulse, impact.impulse.abs()));
                let time = apart(impact.time - impacts[0].time, time, period);
                share = share.max(time / room(told.time + condition.impacts[turn].time, off.time, period));
            }
            share
        };
        let share = (0..count).map(share).fold(f64::INFINITY, f64::min);
        if share <= 1.0 {
            self.worst = self.worst.max(share);
        }
        share <= 1.0
    }

    /// Each orbit of one list is one of the other; all of them where both lists are said to be complete.
    fn compare(&mut self, what: &str, (found, finder): (&OrbitList, &mut Finder), other: &OrbitList) {
        self.lists += 1;
        let (mut taken, mut places) = (vec![false; other.orbits.len()], Vec::new());
        for orbit in &found.orbits {
            let same = (0..taken.len()).find(|&k| !taken[k] && self.is_same(orbit, finder, &other.orbits[k]));
            let Some(same) = same else {
                // Impacts on one barrier closer than this are left out of what a structure's list is said to hold.
                let is_crowded = orbit.impacts().iter().all(|impact| impact.barrier == orbit.impacts()[0].barrier)
                    && orbit.phi().is_some_and(|phi| apart(phi, 0.0, orbit.period()) < 1e-4 * orbit.period());
                let known = other.completeness;
                assert!(!known.is_established() || is_crowded, "{what}: {known:?} but {:?}", orbit.impacts());
                self.missed += 1;
                continue;
            };
            taken[same] = true;
            places.push(same);
            self.compare_orbits(what, (orbit, finder), &other.orbits[same]);
        }
        // A doubled orbit may begin with either of its impacts: a chain's has the longer time after it.
        let is_turned = found.orbits.iter().any(|orbit| orbit.family() == Family::PeriodDoubled);
        self.ordered += usize::from(is_turned || places.is_sorted());
        let is_complete = matches!(found.completeness, Completeness::All(_) | Completeness::None { by: Some(_), .. });
        if is_complete {
            self.complete += usize::from(other.completeness.is_established());
            let pushes =
                |orbit: &Orbit| orbit.impacts().iter().all(|impact| impact.barrier.sign() * impact.impulse < 0.0);
            let lacking = || other.orbits.iter().zip(&taken).filter(|(_, taken)| !**taken).map(|(orbit, _)| orbit);
            assert!(!lacking().any(pushes), "{what}: {:?} but {:?}", found.completeness, other.orbits);
            self.pulled += lacking().count();
        } else {
            self.fewer += usize::from(taken.iter().any(|taken| !taken));
        }
    }

    fn compare_orbits(&mut self, what: &str, (chain, finder): (&Orbit, &mut Finder), other: &Orbit) {
        self.orbits += 1;
        let (one, two) = (finder.admissibility(chain).unwrap(), admissibility(other).unwrap());
        let rounded = rounding_of_matrices(&finder.condition(chain).unwrap());
        let grazes = |margin: Option<f64>| margin.is_some_and(|margin| margin.abs() < 1e-9);
        if !grazes(one.margin) && !grazes(two.margin) {
            assert_eq!(one.is_physical(), two.is_physical(), "{what}: {one:?} {two:?}");
            assert_eq!(one.margin.is_some(), two.margin.is_some(), "{what}: {one:?} {two:?}");
            if let [Some(a), Some(b)] = [one.margin, two.margin] {
                assert!((a - b).abs() < (1e-9 + 100.0 * rounded) * (1.0 + a.abs()), "{what}: {one:?} {two:?}");
            }
        }
        self.physical += usize::from(one.is_physical());
        let told = Analyser::default().stability(chain, finder, Tolerance::Rounding);
        let (Ok(one), Ok(two)) = (told, stability(other, Tolerance::Rounding)) else { return };
        let (one, two) = (one.verdict, two.verdict);
        // What a chain tells of a forced orbit is an estimate: of 3 masses at γ₃ = 1.4e-5 it is off by six times as much (many digits: 259.86246534848782).
        // A mode that its impacts do not feel and no dashpot damps is on the circle, and decides nothing; from matrices it has rounding for a dashpot.
        let on_circle = two.undecided && (two.spectral_radius - 1.0).abs() <= two.resolution;
        if on_circle && chain.model().is_some_and(Model::is_damped) && one.spectral_radius < 1.0 {
            return;
        }
        let room = 16.0 * one.resolution + 2.0 * two.resolution + rounded * one.spectral_radius;
        assert!((one.spectral_radius - two.spectral_radius).abs() <= room, "{what}: {one:?} {two:?}");
        if !one.undecided && !two.undecided {
            assert_eq!(one.stable, two.stable, "{what}: {one:?} {two:?}");
            self.stable += usize::from(one.stable);
            self.unstable += usize::from(!one.stable);
        }
    }
}

#[test]
fn families_are_words_of_a_structure() {
    let (mut random, mut tally) = (Random(5), Tally::default());
    for number in 0..1000 {
        let extreme = number % 5 == 4;
        let ranges = match (random.chance(0.5), extreme) {
            (true, false) => Ranges { sites: [1, 6], ..Ranges::FORCED },
            (false, false) => Ranges { sites: [1, 9], ..Ranges::CONSERVATIVE },
            (true, true) => Ranges {
                sites: [1, 4],
                gamma2: Values::Log(1e-9, 1e-3),
                restitution: Values::Even(0.97, 1.0),
                ..Ranges::FORCED
            },
            (false, true) => Ranges {
                sites: [1, 6],
                omega: Values::Log(0.1, 1e3),
                asymmetry: Values::Log(1e-9, 0.99),
                ..Ranges::CONSERVATIVE
            },
        };
        let chain = random.lattice(&ranges);
        let model = random.model(&ranges).point().on(&chain).model().unwrap();
        let (mut finder, mut found, other) = (Finder::new(chain.sites()), OrbitList::default(), structure(&model));
        for family in [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled] {
            if model.is_conservative() && family == Family::PeriodDoubled {
                continue;
            }
            if finder.find(&model, family, &mut found).is_err() {
                continue;
            }
            let site = found.orbits.first().and_then(Orbit::impact_site).unwrap_or(0);
            let (word, periods) = word(family, site);
            let Ok(list) = other.orbits(&word, periods) else { continue };
            if found.orbits.is_empty() && site == 0 && !chain.is_ring() {
                continue;
            }
            tally.compare(&format!("{number} {family} {model}"), (&found, &mut finder), &list);
        }
    }
    let Tally { lists, ordered, orbits, physical, stable, unstable, complete, fewer, missed, worst, .. } = tally;
    assert!(lists > 2000 && complete > 1800 && fewer < 20 && missed < 5 && worst < 1.0, "{tally:?}");
    assert!(ordered == lists && orbits > 3500 && physical > 700 && stable > 1200 && unstable > 2000, "{tally:?}");
}

/// Rings, rows and layers with dashpots, under one harmonic or several: families, and words of two masses.
#[test]
fn lattices_with_dashpots_are_structures_of_matrices() {
    let (mut random, mut tally) = (Random(23), Tally::default());
    for number in 0..400 {
        let gamma1 = if random.chance(0.1) { Values::Is(0.0) } else { Values::Even(0.05, 1.0) };
        let restitution = if random.chance(0.2) { Values::Is(1.0) } else { Values::Even(0.3, 1.0) };
        let ranges = Ranges { sites: [1, 6], gamma1, restitution, ..Ranges::FORCED };
        let chain = random.lattice(&ranges);
        // Weak ones, strong ones, and some between neighbours that feed what others lose.
        let dashpot = |random: &mut Random, none: f64| if random.chance(none) { 0.0 } else { random.log(1e-4, 0.6) };
        let (own, between) = (dashpot(&mut random, 0.2), dashpot(&mut random, 0.4));
        let between = if random.chance(0.1) { -0.1 * own } else { between };
        let point = random.model(&ranges).point().on(&chain).damping(own).coupling_damping(between);
        let point = if random.chance(0.2) && !chain.has_walls() { point.under(&force(&mut random)) } else { point };
        let Ok(model) = point.model() else { continue };
        let (mut finder, mut found, other) = (Finder::new(chain.sites()), OrbitList::default(), structure(&model));
        let site = random.below(chain.sites());
        for family in [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled] {
            let (name, periods) = word(family, if chain.is_ring() { 0 } else { site });
            let asked = match chain.is_ring() {
                true => finder.find(&model, family, &mut found),
                false => finder.find_word_over(&model, &name, periods, &mut found),
            };
            let (Ok(()), Ok(list)) = (asked, other.orbits(&name, periods)) else { continue };
            tally.compare(&format!("{number} {family} {model}"), (&found, &mut finder), &list);
        }
        if chain.sites() > 1 && chain.layers() == 1 {
            let next = (site + 1) % chain.sites();
            let sides = [(); 2].map(|()| random.of(&["+", "-"]));
            let name: Word = format!("{site}{},{next}{}", sides[0], sides[1]).parse().unwrap();
            let asked = finder.find_word(&model, &name, Scope::All, &mut found);
            let (Ok(()), Ok(list)) = (asked, other.orbits(&name, 1)) else { continue };
            tally.compare(&format!("{number} {name} {model}"), (&found, &mut finder), &list);
        }
    }
    let Tally { lists, ordered, orbits, physical, stable, unstable, complete, missed, worst, .. } = tally;
    assert!(lists > 900 && complete > 830 && missed == 0 && worst < 1.0, "{tally:?}");
    assert!(ordered == lists && orbits > 1200 && physical > 100 && stable > 100 && unstable > 100, "{tally:?}");
}

/// What dies on its way does not know how long the ring is: one of more masses than a structure may have contacts has the orbits of a short one.
#[test]
fn a_damped_ring_may_have_any_size() {
    let lists = [101, 1501].map(|sites| {
        let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1).omega(1.5).asymmetry(0.4);
        let model = ring.amplitude(0.4).restitution(0.9).damping(0.1).model().unwrap();
        let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
        finder.find(&model, Family::SingleSided, &mut found).unwrap();
        let margin = |orbit: &Orbit| admissibility(orbit).unwrap().margin;
        let radius = |orbit: &Orbit| stability(orbit, Tolerance::Rounding).unwrap().verdict.spectral_radius;
        let told = |orbit: &Orbit| (orbit.impulses(), margin(orbit), radius(orbit));
        found.orbits.iter().map(told).collect::<Vec<_>>()
    });
    assert_eq!(lists.each_ref().map(Vec::len), [2, 2]);
    for (short, long) in lists[0].iter().zip(&lists[1]) {
        assert!((short.0[0] - long.0[0]).abs() < 1e-12, "{short:?} {long:?}");
        assert_eq!(short.1.is_some(), long.1.is_some());
        assert!(short.1.zip(long.1).is_none_or(|(a, b)| (a - b).abs() < 1e-12), "{short:?} {long:?}");
        // All that leads to is felt by the mass that is hit, or dies as all do.
        assert!((short.2 - long.2).abs() < 1e-3, "{short:?} {long:?}");
    }
}

/// The first harmonic and some of the next odd ones, whose phases are at times alike.
fn force(random: &mut Random) -> Force {
    let in_phase = random.chance(0.3);
    let mut harmonics = Vec::new();
    for number in [1, 3, 5, 7] {
        if number == 1 || random.chance(0.5) {
            let phase = if in_phase { 0.0 } else { random.between(-3.2, 3.2) };
            let amplitude = random.between(-1.0, 1.0) / f64::from(number).sqrt();
            harmonics.push(Harmonic { number, amplitude, phase });
        }
    }
    Force::new(&harmonics).unwrap()
}

#[test]
fn families_under_several_harmonics_are_words_of_a_structure() {
    let (mut random, mut tally) = (Random(13), Tally::default());
    for number in 0..120 {
        // Nothing holds a chain of free masses as a whole.
        let gamma1 = if random.chance(0.2) { Values::Is(0.0) } else { Values::Even(0.05, 1.0) };
        let restitution = if random.chance(0.2) { Values::Is(1.0) } else { Values::Even(0.2, 1.0) };
        let ranges = Ranges { sites: [1, 6], gamma1, restitution, ..Ranges::FORCED };
        let model = random.model(&ranges).point().under(&force(&mut random)).model().unwrap();
        let (mut finder, mut found) = (Finder::new(model.chain().sites()), OrbitList::default());
        for family in [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled] {
            if finder.find(&model, family, &mut found).is_err() {
                continue;
            }
            let (word, periods) = word(family, 0);
            let Ok(list) = structure(&model).orbits(&word, periods) else { continue };
            tally.compare(&format!("{number} {family} {model}"), (&found, &mut finder), &list);
        }
    }
    let Tally { lists, ordered, orbits, physical, stable, unstable, complete, fewer, missed, worst, .. } = tally;
    assert!(lists > 350 && complete > 330 && fewer == 0 && missed == 0 && worst < 1.0, "{tally:?}");
    assert!(ordered == lists && orbits > 650 && physical > 120 && stable > 180 && unstable > 450, "{tally:?}");
}

#[test]
fn next_to_resonances_what_both_find_is_the_same() {
    let (mut random, mut tally) = (Random(11), Tally::default());
    for number in 0..300 {
        let ranges = if number % 2 == 0 { Ranges::FORCED } else { Ranges::CONSERVATIVE };
        let ranges = Ranges { sites: [1, 6], ..ranges };
        let model = random.model(&ranges);
        let omega = random.meeting(model.chain(), Meeting::Mode, 3, Values::Log(1e-5, 1e-2));
        let Ok(model) = model.point().omega(omega).model() else { continue };
        let (mut finder, mut found) = (Finder::new(model.chain().sites()), OrbitList::default());
        for family in [Family::DoubleSided, Family::SingleSided] {
            if finder.find(&model, family, &mut found).is_err() {
                continue;
            }
            let (word, periods) = word(family, 0);
            let Ok(list) = structure(&model).orbits(&word, periods) else { continue };
            tally.compare(&format!("{number} {family} {model}"), (&found, &mut finder), &list);
        }
    }
    let Tally { lists, ordered, orbits, physical, stable, unstable, complete, fewer, missed, worst, .. } = tally;
    assert!(lists > 580 && complete > 590 && fewer < 4 && missed == 0 && worst < 1.0, "{tally:?}");
    assert!(ordered + 1 >= lists && orbits > 2300 && physical > 20 && stable > 1000 && unstable > 900, "{tally:?}");
}

/// Times between impacts that lists have in common, as parts of the period: those of two lists, one in the other's place.
fn have_common_times(lists: [&[f64]; 2]) -> bool {
    let [one, other] = lists.map(|list| {
        let mut list = list.to_vec();
        list.sort_by(f64::total_cmp);
        list
    });
    one.len() == other.len() && one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-6)
}

/// From 1e-5 of a resonance down to 1e-13 of it a structure's lists are complete and those of the chain, and dashpots far too weak to damp it change
/// none.
#[test]
fn lists_stay_as_a_resonance_comes_close_whatever_the_dashpots() {
    let (mut lists, mut orbits, mut chains) = (0, 0, 0);
    for (sites, harmonic, coupling) in [(1, 1.0, 0.0), (1, 2.0, 0.0), (3, 1.0, 0.07), (3, 2.0, 0.07)] {
        for number in 5..14 {
            let off = 10f64.powi(-number) * if number % 2 == 0 { 1.0 } else { -1.0 };
            let chain = Point::ring(sites).gamma1(0.3).gamma2(coupling).asymmetry(0.2).amplitude(0.4).restitution(0.7);
            let model = chain.omega(0.3f64.sqrt() / harmonic * (1.0 + off)).model().unwrap();
            let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
            for family in [Family::DoubleSided, Family::SingleSided] {
                let what = format!("{off:e} {family} {model}");
                let (word, periods) = word(family, 0);
                let times = |list: &OrbitList| -> Vec<f64> {
                    let phi = |orbit: &Orbit| orbit.phi().unwrap_or(orbit.psi().unwrap()) / orbit.period();
                    list.orbits.iter().map(phi).collect()
                };
                let list = structure(&model).orbits(&word, periods).unwrap();
                let damping = 1e-9 * DMatrix::identity(sites, sites);
                let damped = Structure { damping, ..matrices(&model) }.modal().unwrap();
                let damped = LoadedStructure::new(Arc::new(damped), model.omega()).unwrap();
                let damped = damped.orbits(&word, periods).unwrap();
                let [own, other] = [&list, &damped].map(times);
                assert!(
                    list.completeness.is_established() && damped.completeness.is_established(),
                    "{what}: {list:?} {damped:?}"
                );
                // One impact alone moves with the dashpot, as its impulse goes to 0 with 1 − R.
                let stays = family == Family::SingleSided || have_common_times([&own, &other]);
                assert!(own.len() == other.len() && stays, "{what}: {own:?} {other:?}");
                (lists, orbits) = (lists + 1, orbits + own.len());
                if finder.find(&model, family, &mut found).is_ok() {
                    let phi = |orbit: &Orbit| orbit.phi().unwrap_or(orbit.psi().unwrap()) / orbit.period();
                    let known: Vec<f64> = found.orbits.iter().map(phi).collect();
                    if matches!(found.completeness, Completeness::All(_)) {
                        assert!(have_common_times([&own, &known]), "{what}: {own:?} {known:?}");
                        chains += 1;
                    }
                }
            }
        }
    }
    assert!(lists == 72 && orbits > 300 && chains >= 70, "{lists} {orbits} {chains}");
}

#[test]
fn words_of_a_chain_are_words_of_a_structure() {
    let (mut random, mut tally) = (Random(7), Tally::default());
    for number in 0..400 {
        let forced = number % 2 == 0;
        let gamma2 = Values::Log(1e-3, 0.1);
        let ranges = match forced {
            true => Ranges { sites: [2, 4], gamma2, ..Ranges::FORCED },
            false => Ranges { sites: [2, 6], gamma2, ..Ranges::CONSERVATIVE },
        };
        let chain = random.chain(&ranges);
        let model = random.model(&ranges).point().on(&chain).model().unwrap();
        let first = random.below(chain.sites());
        let sites = [first, (first + 1 + random.below(chain.sites() - 1)) % chain.sites()];
        let sides = [(); 2].map(|()| random.of(&["+", "-"]));
        let word: Word = format!("{}{},{}{}", sites[0], sides[0], sites[1], sides[1]).parse().unwrap();
        let (mut finder, mut found) = (Finder::new(chain.sites()), OrbitList::default());
        if finder.find_word(&model, &word, Scope::All, &mut found).is_err() {
            continue;
        }
        let Ok(list) = structure(&model).orbits(&word, 1) else { continue };
        tally.compare(&format!("{number} {word} {model}"), (&found, &mut finder), &list);
    }
    let Tally { lists, ordered, orbits, physical, stable, unstable, complete, fewer, pulled, missed, worst } = tally;
    assert!(lists > 380 && complete > 360 && fewer + pulled + missed == 0 && worst < 1.0, "{tally:?}");
    assert!(ordered == lists && orbits > 600 && physical > 0 && stable > 140 && unstable > 400, "{tally:?}");
}
