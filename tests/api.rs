//! The public names and signatures of the library are those of tests/data/api.txt: who changes one knows it, and says so in CHANGELOG.md.
//! NET_WRITE=1 writes the file anew.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn files(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => files(&path, all),
            false => all.push(path),
        }
    }
}

/// The code before tests, without documentation and attributes; what is hidden from documentation is left out.
fn code(text: &str) -> Vec<&str> {
    let (mut lines, mut hidden) = (Vec::new(), false);
    let mut all = text.split("#[cfg(test)]\nmod tests").next().unwrap().lines();
    while let Some(line) = all.next() {
        let word = line.trim_start();
        if word.starts_with("#[") {
            hidden |= word == "#[doc(hidden)]";
            let mut end = word;
            while !end.ends_with(']') {
                end = all.next().unwrap();
            }
        } else if !word.starts_with("//") && !word.is_empty() {
            lines.push(if hidden { "" } else { line });
            hidden = false;
        }
    }
    lines
}

/// Whether a piece of code is whole: a head before its braces, or all brackets closed.
fn is_whole(item: &str, with_braces: bool) -> bool {
    let head = if with_braces { item } else { item.strip_suffix('{').unwrap_or(item) };
    let count = |brackets: [char; 3]| head.matches(brackets).count();
    count(['(', '[', '{']) == count([')', ']', '}']) && item.ends_with([';', '{', '}', ','])
}

/// The public items of a file, each with what it stands in. (A lint of the workspace refuses `pub` on what no other crate can see.)
fn items(text: &str, is_root: bool, all: &mut BTreeSet<String>) {
    let lines = code(text);
    let (mut inside, mut is_listed) = ("", false);
    for (i, line) in lines.iter().enumerate() {
        let word = line.trim_start();
        // What is hidden ends nothing.
        if word.is_empty() {
            continue;
        }
        let depth = line.len() - word.len();
        if depth == 0 {
            // Variants, and what a trait asks for, need no word to be public.
            is_listed = line.starts_with("pub enum ") || line.starts_with("pub trait ");
            let holds = is_listed || line.starts_with("pub struct ") || line.starts_with("impl");
            inside = if holds { line.trim_end_matches(" {") } else { "" };
        }
        let is_item = depth == 4 && !inside.is_empty() && (is_listed || word.starts_with("pub "));
        let is_item = is_item || depth == 0 && word.starts_with("pub ");
        // What modules hand on to others is the business of the crate's root.
        if !is_item || !word.starts_with(char::is_alphabetic) || word.starts_with("pub use ") && !is_root {
            continue;
        }
        let with_braces = word.starts_with("pub use ") || is_listed && !word.starts_with("fn ");
        let mut item = word.replace("#[from] ", "");
        for more in &lines[i + 1..] {
            if is_whole(&item, with_braces) {
                break;
            }
            let more = more.trim_start();
            let is_tight = item.ends_with(['(', '{']) || more.starts_with([')', '}']);
            item = format!("{item}{}{more}", if is_tight { "" } else { " " });
        }
        let head = if with_braces { &item } else { item.split(" {").next().unwrap() };
        let is_value = head.trim_start_matches("pub ").starts_with("const ") && !head.contains("fn ");
        let head = if is_value { head.split(" = ").next().unwrap() } else { head };
        let head = head.trim_end_matches([',', ';']).replace(",)", ")").replace(",}", "}");
        let inside = inside.strip_prefix("pub ").unwrap_or(inside);
        all.insert(if depth == 0 { head } else { format!("{inside}: {head}") });
    }
}

#[test]
fn public_names_and_signatures_are_those_that_are_kept() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = String::new();
    for name in ["vibrochain", "lattice", "breather", "floquet", "eventsim", "maps"] {
        let mut all = BTreeSet::new();
        let mut sources = Vec::new();
        match name {
            "vibrochain" => sources.push(root.join("src/lib.rs")),
            // Of maps what the library hands on; the rest is what front ends share.
            "maps" => sources.extend(["cell.rs", "scene/mod.rs"].map(|file| root.join("crates/maps/src").join(file))),
            layer => files(&root.join("crates").join(layer).join("src"), &mut sources),
        }
        for source in sources {
            items(&fs::read_to_string(&source).unwrap(), source.ends_with("src/lib.rs"), &mut all);
        }
        assert!(all.len() > 10, "{name} {all:?}");
        found += &format!("[{name}]\n");
        all.iter().for_each(|item| found += &format!("{item}\n"));
    }
    let kept = root.join("tests/data/api.txt");
    if std::env::var_os("NET_WRITE").is_some() {
        fs::write(&kept, &found).unwrap();
    }
    let kept = fs::read_to_string(kept).unwrap();
    let (old, new): (BTreeSet<&str>, BTreeSet<&str>) = (kept.lines().collect(), found.lines().collect());
    let [gone, come] = [old.difference(&new), new.difference(&old)].map(|lines| lines.copied().collect::<Vec<_>>());
    assert!(kept == found, "gone: {gone:#?}\ncome: {come:#?}\nNET_WRITE=1 keeps what changes on purpose");
    assert!(
        new.contains("impl Model: pub fn omega(&self) -> f64") && new.contains("enum Family: DoubleSided"),
        "{}",
        new.len()
    );
}
