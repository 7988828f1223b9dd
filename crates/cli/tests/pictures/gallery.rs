//! The pictures of the documents are those that the program draws: each command of docs/gallery.md is run and its picture compared.

use std::fs;
use std::path::{Path, PathBuf};

use vibrochain_testkit::{Picture, TestDir};

/// A picture of the documents and the words of its command.
struct Entry {
    file: PathBuf,
    command: Vec<String>,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Words as a shell sees them: quotation marks hold one together.
fn words(line: &str) -> Vec<String> {
    let parts = line.split('"').enumerate();
    let word = |(i, part): (usize, &str)| -> Vec<String> {
        if i % 2 == 1 { vec![part.to_owned()] } else { part.split_whitespace().map(str::to_owned).collect() }
    };
    parts.flat_map(word).collect()
}

fn entries() -> Vec<Entry> {
    let text = fs::read_to_string(root().join("docs/gallery.md")).unwrap();
    let commands = text.lines().filter(|line| line.starts_with("mapgen "));
    let pictures = text.lines().filter(|line| line.starts_with("![")).map(|line| line.split('(').nth(1).unwrap());
    let files = pictures.map(|name| PathBuf::from("docs").join(name.trim_end_matches(')')));
    let all: Vec<Entry> =
        files.zip(commands).map(|(file, line)| Entry { file, command: words(line)[1..].to_vec() }).collect();
    assert_eq!(text.matches("```sh").count(), all.len());
    for Entry { file, command } in &all {
        assert!(command.iter().any(|word| Path::new(word) == file), "{command:?} does not write {}", file.display());
    }
    all
}

/// The share of pixels that differ, by more than an eye sees. Both must be of one size.
fn different(one: &[u8], other: &[u8]) -> f64 {
    let [one, other] = [one, other].map(Picture::of);
    assert_eq!(one.size, other.size);
    let pairs = one.pixels.iter().zip(&other.pixels);
    let far = pairs.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 40));
    far.count() as f64 / one.pixels.len() as f64
}

/// Runs a command of the gallery with its files in a folder, and compares.
fn check(entry: &Entry) {
    let dir = TestDir::new();
    let place = |word: &String| {
        if Path::new(word) == entry.file {
            let ending = entry.file.extension().unwrap().to_str().unwrap();
            dir.path(&format!("drawn.{ending}")).display().to_string()
        } else if let Some(name) = word.strip_prefix("out/") {
            dir.path(name).display().to_string()
        } else if word.starts_with("scenes/") {
            root().join(word).display().to_string()
        } else {
            word.clone()
        }
    };
    let words: Vec<String> = entry.command.iter().map(place).collect();
    let mut command = assert_cmd::Command::cargo_bin("mapgen").unwrap();
    command.args(&words).arg("--quiet").assert().success();
    let name = entry.file.display();
    let committed = fs::read(root().join(&entry.file)).unwrap();
    let drawn = dir.read(if entry.file.extension().unwrap() == "gif" { "drawn.gif" } else { "drawn.png" });
    if entry.file.extension().unwrap() == "gif" {
        assert!(committed == drawn, "{name}");
        return;
    }
    // A cell next to a border may be on its other side where rounding is another.
    let share = different(&committed, &drawn);
    assert!(share < 2e-3, "{name}: {share} of it differs; draw it again as docs/gallery.md says, and look at it");
}

#[test]
fn every_picture_of_the_documents_is_in_the_gallery() {
    let all = entries();
    assert!(all.len() > 30);
    let listed: Vec<&Path> = all.iter().map(|entry| entry.file.as_path()).collect();
    let mut missing = Vec::new();
    for folder in ["docs", "docs/guide", "docs/bifurcations", "docs/gallery", "docs/problems"] {
        for file in fs::read_dir(root().join(folder)).unwrap() {
            let file = Path::new(folder).join(file.unwrap().file_name());
            let is_picture = file.extension().is_some_and(|end| end == "png" || end == "gif");
            // The window of a browser.
            let is_window = file == Path::new("docs/explore.png");
            if is_picture && !listed.contains(&file.as_path()) && !is_window {
                missing.push(file);
            }
        }
    }
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn pictures_of_the_documents_are_drawn_as_they_stand() {
    let quick = [
        "conservative-n20.png",
        "guide/frequency-n20.png",
        "gallery/orbit.png",
        "gallery/breather.gif",
        "problems/energy-sink.png",
        "problems/pounding.png",
    ];
    let all = entries();
    let chosen: Vec<&Entry> = all.iter().filter(|entry| quick.iter().any(|name| entry.file.ends_with(name))).collect();
    assert_eq!(chosen.len(), quick.len());
    chosen.into_iter().for_each(check);
}

#[test]
#[ignore = "minutes: cargo test --release --workspace --test pictures -- --ignored gallery::slow"]
fn slow_all_pictures_of_the_documents_are_drawn_as_they_stand() {
    entries().iter().for_each(check);
}
