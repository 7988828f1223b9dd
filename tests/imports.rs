//! Files import downwards: no two files of a crate need each other, directly or around a corner.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A path of names, from the root of the crate: `["secular", "roots"]`.
type Names = Vec<String>;

/// The files of a crate by module, and what their parents hand on: the name of an item to the module that has it.
#[derive(Default)]
struct House {
    files: BTreeMap<Names, String>,
    handed_on: BTreeMap<Names, Names>,
}

/// All of a file before its tests, without comments.
fn product(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    text.lines().map(|line| line.split("//").next().unwrap()).collect::<Vec<_>>().join("\n")
}

fn files(folder: &Path, module: &Names, house: &mut House) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        let inner = |name: &str| module.iter().cloned().chain([name.to_owned()]).collect::<Names>();
        match stem.as_str() {
            "tests" | "main" => {}
            name if path.is_dir() => files(&path, &inner(name), house),
            "lib" | "mod" => drop(house.files.insert(module.clone(), product(&path))),
            name => drop(house.files.insert(inner(name), product(&path))),
        }
    }
}

/// The paths in a tree of imports: `a::{b, c::{d, e as f}}` has `a::b`, `a::c::d` and `a::c::e`.
fn leaves(tree: &str, before: &str, all: &mut Vec<String>) {
    let tree = tree.trim();
    let Some(open) = tree.find('{') else {
        let path = tree.split(" as ").next().unwrap().trim();
        if !path.is_empty() {
            all.push(format!("{before}{path}"));
        }
        return;
    };
    // A line of a text may begin with this word, too.
    if tree[..open].contains(['"', ' ']) {
        return;
    }
    let before = format!("{before}{}", &tree[..open]);
    let inside = &tree[open + 1..tree.rfind('}').unwrap()];
    let (mut depth, mut start) = (0, 0);
    for (i, c) in inside.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                leaves(&inside[start..i], &before, all);
                start = i + 1;
            }
            _ => {}
        }
    }
    leaves(&inside[start..], &before, all);
}

/// The paths that a file names in `use` (`handing_on`: in `pub use` alone), and in code from the crate's root.
fn named(text: &str, handing_on: bool) -> Vec<String> {
    let mut all = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find("use ") {
        let line = rest[..at].rsplit('\n').next().unwrap();
        let public = line.trim_start().starts_with("pub");
        let end = rest[at..].find(';').map_or(rest.len(), |end| at + end);
        if (line.trim().is_empty() && !handing_on) || public {
            let from = all.len();
            leaves(&rest[at + 4..end], "", &mut all);
            // What stands further in is a module of this file's own, whose parent this file is.
            for path in all[from..].iter_mut().filter(|_| !line.is_empty()) {
                if let Some(name) = path.strip_prefix("super::") {
                    *path = format!("self::{name}");
                }
            }
        }
        rest = &rest[end..];
    }
    if !handing_on {
        for piece in text.split("crate::").skip(1) {
            let path = piece.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).next().unwrap();
            all.push(format!("crate::{}", path.trim_end_matches(':')));
        }
    }
    all
}

/// A path from the crate's root, if it is one of the crate.
fn absolute(path: &str, module: &Names, house: &House) -> Option<Names> {
    let mut words = path.split("::").map(|word| word.trim().to_owned());
    let mut place: Names = match words.next()?.as_str() {
        "crate" => Vec::new(),
        "self" => module.clone(),
        "super" => module[..module.len().checked_sub(1)?].to_vec(),
        first => {
            let child: Names = module.iter().cloned().chain([first.to_owned()]).collect();
            if !house.files.contains_key(&child) {
                return None;
            }
            child
        }
    };
    for word in words {
        if word == "super" {
            place.pop();
        } else {
            place.push(word);
        }
    }
    Some(place)
}

/// The module that has what a path names, through all that hand it on.
fn home(path: Names, house: &House) -> Names {
    let mut path = path;
    for _ in 0..8 {
        match house.handed_on.get(&path) {
            Some(next) if *next != path => path = next.clone(),
            _ => break,
        }
    }
    while !house.files.contains_key(&path) {
        path.pop();
    }
    path
}

/// Which file of a crate imports which.
fn arrows(crate_folder: &Path) -> BTreeMap<Names, BTreeSet<Names>> {
    let mut house = House::default();
    files(&crate_folder.join("src"), &Vec::new(), &mut house);
    let mut handed_on = BTreeMap::new();
    for (module, text) in &house.files {
        for path in named(text, true) {
            if let Some(place) = absolute(&path, module, &house) {
                let name = place.last().unwrap().clone();
                handed_on.insert(module.iter().cloned().chain([name]).collect(), place);
            }
        }
    }
    house.handed_on = handed_on;
    let mut arrows: BTreeMap<Names, BTreeSet<Names>> = BTreeMap::new();
    for (module, text) in &house.files {
        // What a file hands on of its children it does not use.
        let given: BTreeSet<String> = named(text, true).into_iter().collect();
        let used = named(text, false).into_iter().filter(|path| !given.contains(path));
        let places = used.filter_map(|path| absolute(&path, module, &house)).map(|place| home(place, &house));
        arrows.insert(module.clone(), places.filter(|place| place != module).collect());
    }
    arrows
}

/// Files that each reach all others of the set, the sets of two and more.
fn circles(arrows: &BTreeMap<Names, BTreeSet<Names>>) -> BTreeSet<Vec<Names>> {
    let reached = |from: &Names| {
        let (mut seen, mut left) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(next) = left.pop() {
            for to in arrows.get(&next).into_iter().flatten() {
                if seen.insert(to.clone()) {
                    left.push(to.clone());
                }
            }
        }
        seen
    };
    let all: BTreeMap<&Names, BTreeSet<Names>> = arrows.keys().map(|module| (module, reached(module))).collect();
    let circle = |module: &Names| -> Vec<Names> {
        all[module].iter().filter(|other| all.get(other).is_some_and(|back| back.contains(module))).cloned().collect()
    };
    arrows.keys().map(circle).filter(|circle| circle.len() > 1).collect()
}

#[test]
fn no_files_of_a_crate_import_each_other() {
    let (mut told, mut seen) = (Vec::new(), 0);
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("crates")).unwrap() {
        let folder = entry.unwrap().path();
        let arrows = arrows(&folder);
        seen += arrows.values().map(BTreeSet::len).sum::<usize>();
        for circle in circles(&arrows) {
            told.push(folder.file_name().unwrap().to_string_lossy().into_owned());
            for module in &circle {
                let inside: Vec<_> =
                    arrows[module].iter().filter(|to| circle.contains(to)).map(|to| to.join("::")).collect();
                told.push(format!("  {} imports {}", module.join("::"), inside.join(", ")));
            }
        }
    }
    assert!(told.is_empty(), "{}", told.join("\n"));
    // The reading of imports itself.
    assert!(seen > 500, "{seen}");
}

#[test]
fn a_circle_is_seen_through_those_who_hand_names_on() {
    let folder = tempfile::tempdir().unwrap();
    let src = folder.path().join("src");
    fs::create_dir_all(src.join("part")).unwrap();
    let write = |name: &str, text: &str| fs::write(src.join(name), text).unwrap();
    write("lib.rs", "mod part;\nmod other;\npub use part::{One, Two};\n");
    write("part/mod.rs", "mod one;\nmod two;\npub use one::One;\npub use self::two::Two as Second;\n");
    write("part/one.rs", "use crate::other::{\n    Other,\n};\npub struct One;\n");
    write("part/two.rs", "use super::one::One;\npub struct Two;\n");
    write("other.rs", "// use crate::part::Two;\npub struct Other;\n");
    assert!(circles(&arrows(folder.path())).is_empty());
    let two = [vec!["other".to_owned()], vec!["part".to_owned(), "one".to_owned()]];
    for text in ["use crate::part::One;", "fn f() { crate::One; }", "use crate::{part::{One}};"] {
        write("other.rs", text);
        assert_eq!(circles(&arrows(folder.path())).into_iter().collect::<Vec<_>>(), [two.to_vec()], "{text}");
    }
    write("other.rs", "#[cfg(test)]\nmod tests {\n    use crate::part::One;\n}\n");
    assert!(circles(&arrows(folder.path())).is_empty());
}
