//! Crates can be published: each has what its page needs, and the files it is compiled from lie inside it.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::collections::BTreeSet;
use std::path::{Component, Path};
use std::process::Command;

use serde_json::Value;

fn cargo(arguments: &[&str]) -> String {
    let root = env!("CARGO_MANIFEST_DIR");
    let done = Command::new(env!("CARGO")).args(arguments).current_dir(root).output().unwrap();
    assert!(done.status.success(), "cargo {arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

/// All packages of the workspace that may be published, as `cargo metadata` tells them.
fn published() -> Vec<Value> {
    let metadata: Value =
        serde_json::from_str(&cargo(&["metadata", "--no-deps", "--offline", "--locked", "--format-version=1"]))
            .unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    packages.iter().filter(|package| package["publish"].is_null()).cloned().collect()
}

/// `folder/../name` as `name`, or as it is where it leaves the package.
fn inside(path: &Path) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.components() {
        match part {
            Component::ParentDir if parts.last().is_some_and(|last| *last != "..") => drop(parts.pop()),
            part => parts.push(part.as_os_str().to_str().unwrap()),
        }
    }
    parts.join("/")
}

#[test]
fn packages_say_what_they_are_and_need_nothing_that_is_not_published() {
    let packages = published();
    let names: BTreeSet<&str> = packages.iter().filter_map(|package| package["name"].as_str()).collect();
    let mut wrong = Vec::new();
    let citation = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("CITATION.cff")).unwrap();
    for package in &packages {
        let name = package["name"].as_str().unwrap();
        let mut ask = |holds: bool, what: &str| {
            if !holds {
                wrong.push(format!("{name}: {what}"));
            }
        };
        for key in ["description", "license", "readme", "rust_version"] {
            ask(package[key].as_str().is_some_and(|text| !text.is_empty()), key);
        }
        let version = package["version"].as_str().unwrap();
        ask(
            citation.lines().any(|line| line.strip_prefix("version: ") == Some(version)),
            "CITATION.cff has another version",
        );
        // A registry takes five at most.
        ask((1..=5).contains(&package["keywords"].as_array().unwrap().len()), "keywords");
        ask(!package["categories"].as_array().unwrap().is_empty(), "categories");
        for dependency in package["dependencies"].as_array().unwrap() {
            // Those of tests alone are left out of a package where they have no version.
            if dependency["path"].is_string() && dependency["kind"] != "dev" {
                let of = dependency["name"].as_str().unwrap();
                ask(
                    dependency["req"] != "*" && names.contains(of),
                    &format!("depends on {of}, which is not published"),
                );
            }
        }
    }
    assert!(wrong.is_empty() && names.len() == 11, "{names:?} {wrong:?}");
}

#[test]
fn files_that_a_crate_is_compiled_from_lie_inside_it() {
    let (mut included, mut wrong) = (0, Vec::new());
    for package in published() {
        let name = package["name"].as_str().unwrap();
        let folder = Path::new(package["manifest_path"].as_str().unwrap()).parent().unwrap();
        let listing = cargo(&["package", "-p", name, "--list", "--allow-dirty", "--offline", "--locked"]);
        let listed: BTreeSet<&str> = listing.lines().collect();
        let readme = Path::new(package["readme"].as_str().unwrap());
        // One from outside is copied to the package's root.
        let readme = if readme.starts_with("..") { Path::new(readme.file_name().unwrap()) } else { readme };
        for file in ["LICENSE-MIT", "LICENSE-APACHE", readme.to_str().unwrap()] {
            if !listed.contains(file) {
                wrong.push(format!("{name} has no {file}"));
            }
        }
        wrong.extend(listed.iter().filter(|file| file.starts_with("tests/")).map(|file| format!("{name} has {file}")));
        for code in listed.iter().filter(|file| file.ends_with(".rs")) {
            let text = std::fs::read_to_string(folder.join(code)).unwrap();
            let texts = text.split("include_str!(").skip(1).chain(text.split("include_bytes!(").skip(1));
            // A name in quotes, or the folder of many: `concat!("folder/", …)`.
            for file in texts.filter_map(|rest| rest.split('"').nth(1)) {
                included += 1;
                let wanted = inside(&Path::new(code).parent().unwrap().join(file));
                let there = |listed: &&str| **listed == *wanted || file.ends_with('/') && listed.starts_with(&wanted);
                if !listed.iter().any(there) {
                    wrong.push(format!("{name}: {code} takes {wanted}, which the package does not have"));
                }
            }
        }
    }
    assert!(wrong.is_empty() && included > 20, "{included} {wrong:#?}");
}
