//! Branches: the same events at the same places, and the same ends.

use std::sync::Arc;

use vibrochain_breather::{Family, Finder, OrbitList, StructureFamily};
use vibrochain_floquet::{Course, Event, Located, StructureCourse, Tolerance, diagram, structure_diagram};
use vibrochain_lattice::{Parameter, Stop};
use vibrochain_testkit::{Random, Ranges};

use crate::{structure, word};

fn events<O>(diagram: &vibrochain_floquet::Diagram<O>) -> Vec<(Event, f64, f64)> {
    let place = |located: &Located<O>| (located.event, located.value, located.error);
    let mut events: Vec<_> = diagram.branches[0].events().map(place).collect();
    events.sort_by(|a, b| a.1.total_cmp(&b.1));
    events
}

#[test]
fn branches_of_a_chain_are_those_of_a_structure() {
    let mut random = Random(13);
    let (mut branches, mut compared) = (0, 0);
    while branches < 20 {
        let ranges = Ranges { sites: [1, 5], ..Ranges::FORCED };
        let model = random.model(&ranges);
        let family = if branches % 2 == 0 { Family::DoubleSided } else { Family::SingleSided };
        let (mut finder, mut found) = (Finder::new(model.chain().sites()), OrbitList::default());
        if finder.find(&model, family, &mut found).is_err() {
            continue;
        }
        let (word, periods) = word(family, 0);
        let Ok(list) = structure(&model).orbits(&word, periods) else { continue };
        let is_physical = |finder: &mut Finder, orbit| finder.admissibility(orbit).unwrap().is_physical();
        let Some(place) = found.orbits.iter().position(|orbit| is_physical(&mut finder, orbit)) else { continue };
        let orbit = &found.orbits[place];
        let alike = |other: &&vibrochain_breather::StructureOrbit| {
            (other.psi().unwrap() - orbit.psi().unwrap()).abs() < 1e-9
                && (other.impulses()[0] - orbit.impulses()[0]).abs() < 1e-8
        };
        let Some(other) = list.orbits.iter().find(alike) else { continue };
        let (free, value) = (Parameter::Amplitude, model.amplitude());
        let [from, to] = [0.5 * value, 2.0 * value];
        let course = Course { from, to, ..Course::new(orbit, free) };
        let Ok(one) = diagram(orbit, &course) else { continue };
        let base = model;
        let of_value: StructureFamily = Arc::new(move |values: &[f64]| {
            Ok(structure(&base.with(free, values[0]).map_err(|error| error.to_string())?))
        });
        let course =
            StructureCourse { from, to, events: Event::ALL.to_vec(), generations: 0, tolerance: Tolerance::Rounding };
        let two = structure_diagram(other, &of_value, value, &course, &Stop::default()).unwrap();
        let (one, two) = (events(&one), events(&two));
        let alike = |(a, b): (&(Event, f64, f64), &(Event, f64, f64))| {
            a.0 == b.0 && (a.1 - b.1).abs() <= a.2 + b.2 + 1e-13 * value
        };
        assert!(one.len() == two.len() && one.iter().zip(&two).all(alike), "{model} {family}\n{one:?}\n{two:?}");
        branches += 1;
        compared += one.len();
    }
    assert!(compared > 20, "{compared}");
}
