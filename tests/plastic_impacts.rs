//! Impacts that take all velocity: whether their contact leaves again is decided by its acceleration, against simulation and by hand.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

use vibrochain_breather::{LoadedStructure, Obstruction, admissibility};
use vibrochain_floquet::{BranchRequest, Event, Tolerance, branches};
use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape, Stop};
use vibrochain_maps::structure::along::family;
use vibrochain_maps::structure::{Setting, StructureScene};
use vibrochain_testkit::{Random, run_follows};

/// q″ + 0.1 q′ + q = cos ωt with a stop at 0.1 that takes all velocity.
const SCENE: &str = "omega = 2.325\nword = \"0+\"\n[structure]\nmasses = [1]\nstiffness = [[1]]\ndamping = [[0.1]]\n\
                     [[contact]]\nat = 0\nupper = 0.1\nrestitution = 0\n[force]\nload = [1]\n";

fn scene() -> StructureScene {
    StructureScene::of_text(SCENE, Path::new(".")).unwrap()
}

/// q and q′ a time after the impact, which leaves the mass at the stop with no velocity while the load is cos(x + ωt).
fn flight(omega: f64, x: f64, t: f64) -> [f64; 2] {
    let (decay, stop) = (0.05, 0.1);
    let rate = (1.0f64 - decay * decay).sqrt();
    let swing = Complex::new(1.0 - omega * omega, 0.1 * omega).inv();
    let steady = |t: f64| {
        let there = swing * Complex::from_polar(1.0, x + omega * t);
        [there.re, (there * Complex::new(0.0, omega)).re]
    };
    let [place, velocity] = steady(0.0);
    let (a, b) = (stop - place, (-velocity + decay * (stop - place)) / rate);
    let (sin, cos) = (rate * t).sin_cos();
    let dying = (-decay * t).exp();
    let free = dying * (a * cos + b * sin);
    let speed = dying * ((rate * b - decay * a) * cos - (rate * a + decay * b) * sin);
    let [place, velocity] = steady(t);
    [place + free, velocity + speed]
}

/// Where the acceleration after the impact turns, cos x = 0.1, and a period later the mass is at its stop again.
fn onset() -> f64 {
    let off = |omega: f64| flight(omega, 0.1f64.acos(), TAU / omega)[0] - 0.1;
    let (mut low, mut high) = (1.7, 1.95);
    assert!(off(low) * off(high) < 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if off(middle) * off(low) > 0.0 { &mut low } else { &mut high }) = middle;
    }
    low
}

#[test]
fn a_branch_tells_where_a_contact_begins_to_rest_and_no_grazing() {
    let scene = scene();
    let orbits = scene.model().unwrap().orbits(&"0+".parse().unwrap(), 1).unwrap().orbits;
    let orbit = orbits.iter().find(|orbit| admissibility(orbit).unwrap().is_physical()).unwrap();
    let course = BranchRequest {
        from: 1.5,
        to: 3.0,
        events: Event::ALL.to_vec(),
        generations: 0,
        tolerance: Tolerance::Rounding,
    };
    let family = family(&scene, &[Setting::Omega]);
    let branch = branches(orbit, &family, 2.325, &course, &Stop::default()).unwrap().branches.swap_remove(0);
    let of = |event: Event| branch.events().filter(|one| one.event == event).collect::<Vec<_>>();
    let [sticking] = of(Event::Sticking)[..] else {
        panic!("{:?}", branch.events().map(|one| one.event).collect::<Vec<_>>())
    };
    assert!(of(Event::Grazing).is_empty());
    let by_hand = onset();
    assert!((by_hand - 1.8206320992027214).abs() < 1e-13, "{by_hand}");
    assert!(sticking.error < 1e-12 && (sticking.value - by_hand).abs() <= sticking.error + 1e-14, "{sticking:?}");
    let mut counts = [0; 2];
    for point in branch.points().filter(|point| (point.value - by_hand).abs() > 1e-9) {
        assert_eq!(point.physical, Some(point.value > by_hand), "{}", point.value);
        counts[usize::from(point.value > by_hand)] += 1;
    }
    assert!(counts[0] > 10 && counts[1] > 10, "{counts:?}");
}

#[test]
fn no_cell_of_a_map_is_lost_to_rounding() {
    let mut alive = 0;
    for i in 0..151 {
        let omega = 1.5 + 0.01 * f64::from(i);
        let model = scene().model().unwrap().at(omega).unwrap();
        let found = model.orbits(&"0+".parse().unwrap(), 1).unwrap();
        let physical = found.orbits.iter().filter(|orbit| admissibility(orbit).unwrap().is_physical()).count();
        assert_eq!(physical, usize::from(omega > 1.8206320992027214), "{omega}");
        alive += physical;
    }
    assert_eq!(alive, 118);
}

/// Modes with two contacts whose impacts take all velocity.
fn structure(random: &mut Random) -> ModalStructure {
    let modes = 1 + random.below(3);
    let mut mode = || {
        let (frequency, ratio) = (random.log(0.3, 4.0), random.log(1e-2, 0.6));
        let contacts = vec![random.between(0.3, 1.0), random.between(-1.0, 1.0)];
        let shape = ModeShape { contacts, coordinates: Vec::new(), still: random.between(-0.2, 0.2) };
        let load = Complex::new(random.between(-1.0, 1.0), 0.0);
        LinearMode::oscillator(ratio * frequency, frequency * frequency * (1.0 - ratio * ratio), &shape, &[load])
    };
    let modes = (0..modes).map(|_| mode()).collect();
    let contacts = vec![
        Contact { lower: None, upper: Some(random.between(-0.3, 0.4)), restitution: 0.0 },
        Contact { lower: Some(-random.log(0.3, 3.0)), upper: None, restitution: 0.0 },
    ];
    ModalStructure::new(contacts, vec![1], modes).unwrap()
}

/// Of random structures an orbit is physical where a run goes along it for a period, and not where it rests, or meets another barrier.
#[test]
fn orbits_of_plastic_impacts_are_physical_where_runs_have_them() {
    let mut random = Random(64);
    let (mut physical, mut sticking, mut crossing) = (0, 0, 0);
    for _ in 0..400 {
        let structure = Arc::new(structure(&mut random));
        let model = LoadedStructure::new(structure, random.log(0.4, 3.0)).unwrap();
        for word in ["0+", "0+,0+", "0+,1-"] {
            let Ok(found) = model.orbits(&word.parse().unwrap(), 1) else { continue };
            for orbit in &found.orbits {
                let told = admissibility(orbit).unwrap();
                match told.obstruction {
                    Some(Obstruction::WrongSign { .. }) => continue,
                    Some(Obstruction::Sticking { .. }) => sticking += 1,
                    Some(Obstruction::Crossing { .. }) => crossing += 1,
                    None => physical += 1,
                }
                assert_eq!(told.is_physical(), run_follows(orbit), "{told:?} {orbit:?}");
            }
        }
    }
    assert!(physical > 40 && sticking > 200 && crossing > 40, "{physical} {sticking} {crossing}");
}
