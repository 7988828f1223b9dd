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

/// One mass, with these dashpots, stops and loads; and axes.
fn one(damping: f64, stop: &str, force: &str, axes: &str) -> Result<StructureScene, String> {
    let text = format!(
        "omega = 1\n[structure]\nmasses = [1]\nstiffness = [[1]]\ndamping = [[{damping}]]\n[[contact]]\nat = 0\n{stop}\n{force}{axes}"
    );
    StructureScene::of_text(&text, std::path::Path::new(".")).map_err(|error| error.to_string())
}

/// A number that changes nothing is refused, on an axis, too, and one that does is not: by what it does to the structure and to its orbits.
#[test]
fn a_number_that_changes_nothing_is_refused() {
    let (inelastic, both, elastic) =
        ("upper = 1\nrestitution = 0.5", "lower = -1\nupper = 1\nrestitution = 0.5", "upper = 1");
    let (load, still) = ("[force]\nload = [0.5]\n", "[force]\nstatic = [0.1]\n");
    let cases = [
        (-0.2, inelastic, "", vec!["omega", "load", "static", "asymmetry"]),
        (0.2, both, "", vec!["omega", "load", "static"]),
        (0.0, elastic, "", vec!["load", "static", "damping", "asymmetry"]),
        (0.0, both, still, vec!["omega", "load", "damping"]),
        (-0.2, both, load, vec!["static"]),
        (0.0, inelastic, load, vec!["static", "damping", "asymmetry"]),
    ];
    let mut refused = 0;
    for (damping, stop, force, idle) in cases {
        let plain = one(damping, stop, force, "").unwrap();
        for name in ["omega", "load", "static", "damping", "asymmetry", "contact.0.restitution"] {
            let setting: Setting = name.parse().unwrap();
            let is_idle = idle.contains(&name);
            let axis = format!("[sweep]\nx = {{ parameter = \"{name}\", from = 0.3, to = 0.6, points = 4 }}\n");
            let swept = one(damping, stop, force, &axis);
            for answer in [plain.has_effect(setting), swept.map(|_| ())] {
                let told = answer.err();
                assert_eq!(told.is_some(), is_idle, "{name}: {told:?}");
                if let Some(told) = told {
                    assert!(told.contains(&format!("{name} changes nothing here")) && told.contains("vary"), "{told}");
                    refused += 1;
                }
            }
            // By itself: the structure is another one at another value, or the orbits that it gives a period to.
            let mut moved = plain.clone();
            moved.set(setting, 0.45).unwrap();
            let (before, after) = (plain.structure().unwrap(), moved.structure().unwrap());
            if name != "omega" {
                assert_eq!(before == after, is_idle, "{name}");
            }
        }
    }
    assert_eq!(refused, 2 * 18);
    // With another axis that gives a load, or takes the losses, at one of its ends, ω has its effect there.
    let with = |damping, stop, force: &str, other: &str| {
        let omega = "{ parameter = \"omega\", from = 0.3, to = 0.6, points = 4 }";
        one(damping, stop, force, &format!("[sweep]\nx = {omega}\ny = {{ parameter = {other}, points = 2 }}\n"))
    };
    let no_load = "[force]\nload = [0]\n";
    for (damping, stop, force, other, is_refused) in [
        (-0.2, inelastic, no_load, "\"load.0\", from = 0, to = 1", false),
        (-0.2, inelastic, no_load, "\"contact.0.upper\", from = 0.5, to = 1", true),
        (0.0, inelastic, "", "\"contact.0.restitution\", from = 0.5, to = 1", false),
        (0.0, inelastic, "", "\"contact.0.restitution\", from = 0.5, to = 0.9", true),
    ] {
        let told = with(damping, stop, force, other);
        assert_eq!(told.is_err(), is_refused, "{other}: {:?}", told.err());
    }
}
