//! The table of scene keys has those that a scene takes.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use vibrochain_maps::scene::Scene;

const SCENE: &str = "
[model]
sites = 6
omega = 1.5
gamma1 = 0.2
asymmetry = 0.4
MODEL
[sweep]
x = { parameter = 'gamma2', values = [0.1] AXIS }
SWEEP
[compute]
families = ['double-sided']
COMPUTE
";

/// A scene with `key = 1` at one of the places.
fn scene_with(place: &str, key: &str) -> String {
    let filled = SCENE.replace(place, key);
    ["MODEL", "AXIS", "SWEEP", "COMPUTE"].iter().fold(filled, |text, place| text.replace(place, ""))
}

/// What is between backquotes.
fn quoted(text: &str) -> impl Iterator<Item = String> + '_ {
    text.split('`').skip(1).step_by(2).map(str::to_owned)
}

#[test]
fn the_table_of_scene_keys_has_those_that_a_scene_takes() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scenes.md");
    let document = fs::read_to_string(path).unwrap();
    let parse = |text: &str| Scene::parse(Path::new("scene.toml"), text);
    parse(&scene_with("MODEL", "")).unwrap();
    let mut all = BTreeSet::new();
    for (heading, text) in [
        ("## The file\n", format!("zzz = 1\n{}", scene_with("MODEL", ""))),
        ("## `[model]`\n", scene_with("MODEL", "zzz = 1")),
        ("### `forcing`\n", scene_with("MODEL", "forcing = { zzz = 1 }")),
        ("### `force`\n", scene_with("MODEL", "force = [{ zzz = 1 }]")),
        ("## `[sweep]`\n", scene_with("SWEEP", "zzz = 1")),
        ("### An axis\n", scene_with("AXIS", ", zzz = 1")),
        ("## `[compute]`\n", scene_with("COMPUTE", "zzz = 1")),
    ] {
        // "unknown key `zzz`, expected one of `sites`, `gamma1`, …" tells what is taken there.
        let message = parse(&text).unwrap_err().to_string();
        let message = message.lines().next().unwrap();
        assert!(message.contains("unknown key `zzz`"), "{heading}: {message}");
        let taken: BTreeSet<String> = quoted(message).filter(|key| key != "zzz").collect();
        let section = document.split(heading).nth(1).unwrap_or_else(|| panic!("no heading {heading}"));
        let section = section.split("\n#").next().unwrap();
        let rows = section.lines().filter(|line| line.starts_with("| `"));
        let told: BTreeSet<String> = rows.map(|row| quoted(row).next().unwrap()).collect();
        assert_eq!(told, taken, "{heading}");
        all.extend(taken);
    }
    assert!(all.len() > 25, "{all:?}");
    // So is what may be swept.
    let refused = parse(&scene_with("MODEL", "").replace("gamma2", "zzz")).unwrap_err().to_string();
    let (_, known) = refused.split_once("give one of ").unwrap();
    let known: Vec<String> = known.lines().next().unwrap().split(", ").map(|name| format!("\"{name}\"")).collect();
    let row = document.lines().find(|line| line.starts_with("| `parameter` |")).unwrap();
    assert_eq!(quoted(row).skip(1).collect::<Vec<_>>(), known);
    // Its examples are scenes, and use all keys between them.
    let examples: Vec<&str> =
        document.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert!(examples.len() >= 4);
    examples.iter().for_each(|text| drop(parse(text).unwrap()));
    let used = |key: &String| {
        let uses = [format!("{key} ="), format!("[{key}]"), format!("{key} = {{")];
        examples.iter().any(|text| uses.iter().any(|form| text.contains(form)))
    };
    let unused: Vec<&String> = all.iter().filter(|key| !used(key)).collect();
    assert!(unused.is_empty(), "{unused:?} are in no example");
}
