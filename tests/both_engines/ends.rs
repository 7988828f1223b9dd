//! Where branches end, and orbits of several masses.

use std::sync::Arc;

use vibrochain_breather::{Finder, Hit, ModelFamily, Orbit, OrbitList, Scope};
use vibrochain_floquet::{BranchRequest, Course, Diagram, Event, Tolerance, branches, diagram};
use vibrochain_lattice::{Chain, Model, Parameter, Point, Stop};
use vibrochain_testkit::Values::Log;
use vibrochain_testkit::{Random, Ranges};

use crate::structure;

/// What happens on a branch of both engines: events, then ends, each with its place, from below.
type Passed = Vec<(String, f64)>;

fn passed(diagram: &Diagram) -> Passed {
    let branch = &diagram.branches[0];
    let mut all: Passed = branch.events().map(|one| (one.event.to_string(), one.value)).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    all.extend(branch.ends.iter().map(|(value, end)| (end.name().to_owned(), *value)));
    all
}

/// The branch of an orbit of the chain, and that of the same orbit of the structure with a contact at each mass.
fn both(orbit: &Orbit, free: Parameter, [from, to]: [f64; 2], events: &[Event]) -> [Passed; 2] {
    let model = *orbit.model().unwrap();
    let course = Course { from, to, events: events.to_vec(), ..Course::new(orbit, free) };
    let one = diagram(orbit, &course).unwrap();
    let family: ModelFamily =
        Arc::new(move |values: &[f64]| Ok(structure(&model.with(free, values[0]).map_err(|error| error.to_string())?)));
    let hits: Vec<Hit> = orbit.impacts().iter().map(Hit::from).collect();
    let start = structure(&model).orbit_near(orbit.force_periods(), orbit.psi().unwrap_or(0.0), &hits).unwrap();
    let course = BranchRequest { from, to, events: events.to_vec(), generations: 0, tolerance: Tolerance::Rounding };
    let two = branches(&start, &family, model.get(free), &course, &Stop::default()).unwrap();
    [passed(&one), passed(&two)]
}

fn assert_alike([one, two]: &[Passed; 2], room: f64, about: &str) {
    // Where all impulses of a doubled orbit vanish they become alike, too: rounding decides which of the two is told.
    let is_both = |a: &(String, f64), b: &(String, f64)| {
        let ends = ["impulses-vanish", "period-doubling"];
        [a, b].iter().all(|end| ends.contains(&end.0.as_str())) && (a.1 - b.1).abs() < 1e-8
    };
    let alike = one.len() == two.len()
        && one
            .iter()
            .zip(two)
            .all(|(a, b)| (a.0 == b.0 || is_both(a, b)) && (a.1 - b.1).abs() <= room * (1.0 + a.1.abs()));
    assert!(alike, "{about}\n{one:?}\n{two:?}");
}

/// Doubled orbits lose both impulses where the motion that the force drives alone touches the barrier; towards the frequency of a mode all grow
/// without bound.
#[test]
fn doubled_orbits_end_alike() {
    let ranges = Ranges {
        sites: [2, 5],
        gamma1: Log(0.05, 0.8),
        gamma2: Log(1e-3, 0.4),
        omega: Log(0.7, 2.0),
        asymmetry: Log(0.01, 0.9),
        restitution: Log(0.05, 1.0),
        ..Ranges::FORCED
    };
    let (mut random, mut ends) = (Random(27), Vec::new());
    for _ in 0..150 {
        let model = random.model(&ranges);
        let free = random.of(&[Parameter::Asymmetry, Parameter::Amplitude, Parameter::Omega]);
        let Ok(list) = vibrochain_breather::breathers(&model, vibrochain_breather::Family::PeriodDoubled) else {
            continue;
        };
        let Some(orbit) = list.orbits.last() else { continue };
        let Course { from, to, .. } = Course::new(orbit, free);
        let found = both(orbit, free, [from, to], &[Event::Fold]);
        // Where the chain's branch turns back is known to the square of a step.
        assert_alike(&found, 1e-5, &format!("{model} {free}"));
        ends.extend(found[1].iter().map(|one| one.0.clone()));
    }
    let count = |name: &str| ends.iter().filter(|end| *end == name).count();
    assert!(count("impulses-vanish") >= 5 && count("resonance") >= 5, "{ends:?}");
}

/// A branch begins within a thousandth of a resonance, where rows are known worse than their terms: Newton's method must not ask more of them.
#[test]
fn a_branch_begins_next_to_a_resonance() {
    let chain = Chain::new(9, 0.6732154424472294, 0.0414386387586702).unwrap();
    let model = Model::conservative(chain, 0.8613007462308684, 0.2996970688012291).unwrap();
    let list = vibrochain_breather::breathers(&model, vibrochain_breather::Family::SingleSided).unwrap();
    let found = both(&list.orbits[0], Parameter::Gamma2, [0.0331509, 0.0497264], &[Event::Pitchfork]);
    assert_alike(&found, 1e-9, "next to a resonance");
    let names: Vec<&str> = found[1].iter().map(|one| one.0.as_str()).collect();
    assert_eq!(names, ["pitchfork", "range", "resonance"]);
}

/// Elastic impacts under a force: symmetric in time, so that asymmetric pairs branch off although a ≠ 0.
#[test]
fn pitchforks_of_mirror_images_in_time_are_alike() {
    let ring = Point::ring(8).gamma1(0.1).gamma2(0.05);
    let model = ring.omega(2.053).asymmetry(0.1).amplitude(1.476).model().unwrap();
    let orbits = vibrochain_breather::breathers(&model, vibrochain_breather::Family::DoubleSided).unwrap().orbits;
    let half = |orbit: &Orbit| (orbit.phi().unwrap() / orbit.period() - 0.5).abs();
    let mut pitchforks = 0;
    for orbit in orbits.iter().filter(|orbit| half(orbit) < 1e-12) {
        let found = both(orbit, Parameter::Omega, [1.2, 2.5], &[Event::Pitchfork]);
        assert_alike(&found, 1e-11, "");
        pitchforks += found[1].iter().filter(|one| one.0 == "pitchfork").count();
    }
    assert!(pitchforks >= 1, "{pitchforks}");
}

/// Rounding lets masses that hit at one instant overtake each other; where coupling vanishes only a mirror holds them together.
#[test]
fn words_of_two_masses_at_one_instant_are_alike() {
    let mut events = 0;
    for (sites, word) in [(5, "0+1+,0-1-"), (6, "0+3+,0-3-"), (6, "0+2-,0-2+")] {
        let model = Model::conservative(Chain::new(sites, 0.2, 0.05).unwrap(), 1.5, 0.2).unwrap();
        let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
        finder.find_word(&model, &word.parse().unwrap(), Scope::All, &mut found).unwrap();
        let both = both(&found.orbits[0], Parameter::Gamma2, [1e-9, 0.12], &Event::ALL);
        assert_alike(&both, 1e-10, word);
        events += both[1].len() - 2;
    }
    assert!(events > 2, "{events}");
}
