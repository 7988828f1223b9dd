//! Every number of a structure that can be varied: setting it is as writing it in the scene.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use vibrochain_maps::structure::{Setting, StructureScene};

/// Two masses with a spring, a dashpot and a stop each, under two harmonics of which each coordinate has phases of its own. In place of a name in
/// braces stands its number.
const SCENE: &str = "omega = {omega}
[structure]
mass = [[{masses.0}, {mass.0.1}], [{mass.0.1}, {mass.1.1}]]
stiffness = [[{stiffness.0.0}, {stiffness.1.0}], [{stiffness.1.0}, {stiffness.1.1}]]
damping = [[{damping.0.0}, {damping.0.1}], [{damping.0.1}, {damping.1.1}]]
[[contact]]
at = 0
lower = {contact.0.lower}
upper = {contact.0.upper}
restitution = {contact.0.restitution}
[[contact]]
between = [0, 1]
upper = {contact.1.upper}
restitution = {contact.1.restitution}
[force]
load = [{load.0}, {load.1}]
phases = [0.0, -2.1]
static = [{static.0}, {static.1}]
terms = [{ harmonic = 3, load = [0.3, -0.2], phases = [0.4, 1.0] }]
";

const NUMBERS: [(&str, f64, f64); 20] = [
    ("omega", 1.3, 1.7),
    ("masses.0", 1.0, 1.4),
    ("mass.0.1", 0.1, -0.2),
    ("mass.1.1", 0.7, 0.5),
    ("stiffness.0.0", 2.0, 1.1),
    ("stiffness.1.0", -0.6, 0.3),
    ("stiffness.1.1", 1.5, 2.5),
    ("damping.0.0", 0.2, 0.0),
    ("damping.0.1", -0.05, 0.07),
    ("damping.1.1", 0.1, 0.3),
    ("contact.0.lower", -0.8, -0.3),
    ("contact.0.upper", 0.5, 0.9),
    ("contact.0.restitution", 0.7, 0.2),
    ("contact.1.upper", 0.4, 0.1),
    ("contact.1.restitution", 0.9, 1.0),
    ("load.0", 0.6, -0.4),
    ("load.1", 0.5, 0.9),
    ("static.0", 0.02, -0.05),
    ("static.1", 0.0, 0.04),
    ("damping.1.0", -0.05, 0.02),
];

/// The scene with another value of one of its numbers.
fn scene(changed: Option<(&str, f64)>) -> StructureScene {
    let mut text = SCENE.to_owned();
    for (name, value, _) in NUMBERS {
        let name_in_text = if name == "damping.1.0" { "damping.0.1" } else { name };
        let value = changed.filter(|(other, _)| *other == name).map_or(value, |(_, value)| value);
        if changed.is_some_and(|(other, _)| other == "damping.1.0") && name == "damping.0.1" {
            continue;
        }
        text = text.replace(&format!("{{{name_in_text}}}"), &format!("{value:?}"));
    }
    StructureScene::of_text(&text, std::path::Path::new(".")).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// What contacts do under each harmonic and the static load, complex, with their barriers and the poles: all that decides a motion.
fn motion(scene: &StructureScene) -> Vec<f64> {
    let model = scene.model().unwrap();
    let structure = model.structure();
    let mut numbers = vec![model.omega()];
    for place in 0..structure.harmonics().len() {
        let swings = structure.steady_at(place, model.omega()).unwrap();
        numbers.extend(swings.iter().flat_map(|swing| [swing.re, swing.im]));
    }
    for contact in 0..2 {
        let still = structure.modes().iter().zip(structure.still());
        numbers.push(still.map(|(mode, xi)| mode.rows[contact][0] * xi[0] + mode.rows[contact][1] * xi[1]).sum());
        numbers.push(structure.mobility(contact, contact));
        let stops = structure.contacts()[contact];
        numbers.extend([stops.lower.unwrap_or(9.0), stops.upper.unwrap_or(9.0), stops.restitution]);
    }
    let mut poles: Vec<[f64; 2]> =
        structure.modes().iter().flat_map(|mode| mode.rates()).map(|rate| [rate.im, rate.re]).collect();
    poles.sort_by(|a, b| a.partial_cmp(b).unwrap());
    numbers.extend(poles.into_iter().flatten());
    numbers
}

fn distance(one: &[f64], other: &[f64]) -> f64 {
    assert_eq!(one.len(), other.len());
    one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_number_that_is_set_is_as_one_that_was_written() {
    let before = motion(&scene(None));
    for (name, value, other) in NUMBERS {
        let setting: Setting = name.parse().unwrap();
        let mut set = scene(None);
        assert_eq!(set.get(setting), Some(value), "{name}");
        set.set(setting, other).unwrap();
        // A load with a phase is told by its size.
        let told = set.get(setting).unwrap();
        assert!((told - other).abs() < 1e-15, "{name}: {told}");
        let written = motion(&scene(Some((name, other))));
        let off = distance(&motion(&set), &written);
        assert!(off < 1e-12, "{name}: {off:e}");
        assert!(distance(&before, &written) > 1e-3, "{name} decides nothing");
        // There and back again.
        set.set(setting, value).unwrap();
        assert!(distance(&motion(&set), &before) < 1e-12, "{name}");
    }
}

/// A number of all, its value, and the numbers of each that are the same.
type Settings<'a> = (&'a str, f64, &'a [(&'a str, f64)]);

/// What all loads, static loads and dashpots are multiplied by, and the middle of gaps.
#[test]
fn numbers_of_all_at_once_are_as_each_by_itself() {
    let with = |changes: &[(&str, f64)]| {
        let mut scene = scene(None);
        changes.iter().for_each(|(name, value)| scene.set(name.parse().unwrap(), *value).unwrap());
        motion(&scene)
    };
    let cases: [Settings<'_>; 4] = [
        ("static", 3.0, &[("static.0", 0.06), ("static.1", 0.0)]),
        ("damping", 2.0, &[("damping.0.0", 0.4), ("damping.0.1", -0.1), ("damping.1.1", 0.2)]),
        ("asymmetry", 0.1, &[("contact.0.lower", -0.55), ("contact.0.upper", 0.75)]),
        ("restitution", 0.3, &[("contact.0.restitution", 0.3), ("contact.1.restitution", 0.3)]),
    ];
    for (name, value, each) in cases {
        let off = distance(&with(&[(name, value)]), &with(each));
        assert!(off < 1e-12, "{name}: {off:e}");
    }
    // Of both harmonics.
    let (one, half) = (motion(&scene(None)), with(&[("load", 0.5)]));
    for place in 1..9 {
        assert!((half[place] - 0.5 * one[place]).abs() < 1e-12 && one[place].abs() > 1e-4, "{place}");
    }
}

#[test]
fn numbers_that_are_not_there_are_refused() {
    let mut scene = scene(None);
    for (name, said) in [
        ("load.2", "coordinates 0 to 1"),
        ("stiffness.0.2", "coordinates 0 to 1"),
        ("static.7", "coordinates 0 to 1"),
        ("contact.2.upper", "contacts 0 to 1"),
        ("gamma1", "is of chains"),
    ] {
        let setting: Setting = name.parse().unwrap();
        assert_eq!(scene.get(setting), None, "{name}");
        let error = scene.set(setting, 1.0).unwrap_err();
        assert!(error.contains(said), "{name}: {error}");
    }
    assert!(scene.set(Setting::Omega, -1.0).is_err() && scene.set(Setting::Load, f64::NAN).is_err());
}
