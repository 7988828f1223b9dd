//! Branches: the same events at the same places, and the same ends.

use std::sync::Arc;

use vibrochain_breather::{Family, Finder, ModelFamily, Orbit, OrbitList};
use vibrochain_floquet::{BranchRequest, Course, Diagram, Event, Located, Tolerance, branches, diagram};
use vibrochain_lattice::{Chain, Model, Parameter, Stop};
use vibrochain_testkit::{Random, Ranges, Values};

use crate::{structure, word};

fn events(diagram: &Diagram) -> Vec<(Event, f64, f64)> {
    let place = |located: &Located| (located.event, located.value, located.error);
    let mut events: Vec<_> = diagram.branches[0].events().map(place).collect();
    events.sort_by(|a, b| a.1.total_cmp(&b.1));
    events
}

/// The branch of the chain's first physical orbit, and that of the same orbit of the structure; the events of both.
fn both(model: &Model, family: Family, free: Parameter, [from, to]: [f64; 2]) -> Option<[Vec<(Event, f64, f64)>; 2]> {
    let (mut finder, mut found) = (Finder::new(model.chain().sites()), OrbitList::default());
    finder.find(model, family, &mut found).ok()?;
    let (word, periods) = word(family, 0);
    let list = structure(model).orbits(&word, periods).ok()?;
    let is_physical = |finder: &mut Finder, orbit| finder.admissibility(orbit).unwrap().is_physical();
    let orbit = found.orbits.iter().find(|orbit| is_physical(&mut finder, orbit))?;
    let alike = |other: &&Orbit| {
        (other.psi().unwrap_or(0.0) - orbit.psi().unwrap_or(0.0)).abs() < 1e-9
            && (other.impulses()[0] - orbit.impulses()[0]).abs() < 1e-8
    };
    let other = list.orbits.iter().find(alike)?;
    let course = Course { from, to, ..Course::new(orbit, free) };
    let one = diagram(orbit, &course).ok()?;
    let base = *model;
    let of_value: ModelFamily =
        Arc::new(move |values: &[f64]| Ok(structure(&base.with(free, values[0]).map_err(|error| error.to_string())?)));
    let course =
        BranchRequest { from, to, events: Event::ALL.to_vec(), generations: 0, tolerance: Tolerance::Rounding };
    let two = branches(other, &of_value, model.get(free), &course, &Stop::default()).unwrap();
    Some([events(&one), events(&two)])
}

fn are_alike([one, two]: &[Vec<(Event, f64, f64)>; 2], scale: f64) -> bool {
    let alike =
        |(a, b): (&(Event, f64, f64), &(Event, f64, f64))| a.0 == b.0 && (a.1 - b.1).abs() <= a.2 + b.2 + 1e-13 * scale;
    one.len() == two.len() && one.iter().zip(two).all(alike)
}

#[test]
fn branches_of_a_chain_are_those_of_a_structure() {
    let mut random = Random(13);
    let (mut branches, mut compared) = (0, 0);
    while branches < 20 {
        let model = random.model(&Ranges { sites: [1, 5], ..Ranges::FORCED });
        let family = if branches % 2 == 0 { Family::DoubleSided } else { Family::SingleSided };
        let value = model.amplitude();
        let Some(found) = both(&model, family, Parameter::Amplitude, [0.5 * value, 2.0 * value]) else { continue };
        assert!(are_alike(&found, value), "{model} {family}\n{found:?}");
        branches += 1;
        compared += found[0].len();
    }
    assert!(compared > 20, "{compared}");
}

/// Without losses pairs collide on the circle, and part, within stripes of any width: signatures tell of them.
#[test]
fn branches_of_a_conservative_chain_are_those_of_a_structure() {
    let mut random = Random(14);
    let (mut branches, mut collisions) = (0, 0);
    while branches < 60 {
        let ranges = Ranges {
            sites: [3, 14],
            gamma1: Values::Even(0.15, 0.3),
            gamma2: Values::Even(0.05, 0.15),
            omega: Values::Even(1.0, 1.7),
            asymmetry: Values::Either(0.25, &Values::Is(0.0), &Values::Even(0.05, 0.8)),
            ..Ranges::CONSERVATIVE
        };
        let model = random.model(&ranges);
        let family = if branches % 4 == 0 { Family::SingleSided } else { Family::DoubleSided };
        let (free, value) = if branches % 2 == 0 {
            (Parameter::Omega, model.omega())
        } else {
            (Parameter::Gamma2, model.chain().gamma2())
        };
        let Some(found) = both(&model, family, free, [0.93 * value, 1.07 * value]) else { continue };
        assert!(are_alike(&found, value), "{model} {family} {free:?}\n{found:?}");
        branches += 1;
        collisions += found[0].iter().filter(|event| event.0 == Event::NeimarkSacker).count();
    }
    assert!(collisions > 20, "{collisions}");
}

/// A pair that leaves the circle and comes back within 6 % of a step.
#[test]
fn a_thin_stripe_is_found_by_both() {
    let model = Model::conservative(Chain::new(10, 0.2, 0.12).unwrap(), 1.5, 0.4).unwrap();
    let found = both(&model, Family::DoubleSided, Parameter::Gamma2, [0.11, 0.13]).unwrap();
    for events in &found {
        for value in [0.122_297_08, 0.123_070_64] {
            assert!(events.iter().any(|event| (event.1 - value).abs() < 1e-8), "{value}: {events:?}");
        }
    }
    assert!(are_alike(&found, 0.12), "{found:?}");
}
