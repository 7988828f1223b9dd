//! Documents point at what is there.

use std::fs;
use std::path::{Path, PathBuf};

/// All pages, those in the root by name.
fn documents(in_root: &[&str]) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs =
        ["docs", "docs/guide", "docs/how"].into_iter().flat_map(|folder| fs::read_dir(root.join(folder)).unwrap());
    let docs = docs.map(|entry| entry.unwrap().path());
    let pages = docs.filter(|path| path.extension().is_some_and(|end| end == "md"));
    pages.chain(in_root.iter().map(|name| root.join(name))).collect()
}

#[test]
fn every_relative_link_leads_somewhere() {
    let (mut broken, mut links) = (Vec::new(), 0);
    let pages = documents(&["README.md", "CHANGELOG.md", "ARCHITECTURE.md", "CONTRIBUTING.md"]);
    assert!(pages.len() > 30, "{pages:?}");
    for document in pages {
        let text = fs::read_to_string(&document).unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let target = link.split('#').next().unwrap_or_default();
            let outside = link.contains("://") || target.is_empty();
            links += usize::from(!outside);
            if !outside && !document.parent().unwrap().join(target).exists() {
                broken.push(format!("{}: {link}", document.display()));
            }
        }
    }
    assert!(broken.is_empty() && links > 300, "{links} {}", broken.join("\n"));
}

/// What is longer is not read: pages of the manual have at most 1500 words, one question at most 600, all together 45 000. A word has a letter,
/// numbers are none; `scripts/lines.py --words` counts alike.
#[test]
fn no_page_is_too_long() {
    // Lists to look things up in, and what the program prints.
    let lists = ["scenes.md", "names.md", "problems.md", "accuracy.md", "errata.md", "figures.md", "stripes.md"];
    let (mut all, mut long) = (0, Vec::new());
    for page in documents(&["README.md", "CHANGELOG.md", "ARCHITECTURE.md", "CONTRIBUTING.md"]) {
        let text = fs::read_to_string(&page).unwrap();
        let words = text.split_whitespace().filter(|word| word.chars().any(char::is_alphabetic)).count();
        let name = page.file_name().unwrap().to_str().unwrap();
        let most = if page.parent().unwrap().ends_with("how") { 600 } else { 1500 };
        if words > most && !lists.contains(&name) {
            long.push(format!("{}: {words} words", page.display()));
        }
        all += words;
    }
    assert!(long.is_empty() && all > 30_000 && all <= 45_000, "{all} words in all; {}", long.join("\n"));
}

/// In the guide the names right after a link to a file, as in [file](link) `one`, `another`, are names that the file has.
#[test]
fn the_guide_names_functions_where_they_are() {
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide");
    let (mut named, mut wrong) = (0, Vec::new());
    let pages = fs::read_dir(&guide).unwrap().map(|entry| entry.unwrap().path());
    // Beside its pages the guide has pictures.
    for page in pages.filter(|path| path.extension().is_some_and(|end| end == "md")) {
        let text = fs::read_to_string(&page).unwrap();
        for after in text.split("](").skip(1) {
            let (link, rest) = after.split_once(')').unwrap();
            if !link.ends_with(".rs") {
                continue;
            }
            let code = fs::read_to_string(guide.join(link)).unwrap();
            let mut rest = rest.strip_prefix(' ').unwrap_or_default();
            while let Some((name, more)) = rest.strip_prefix('`').and_then(|rest| rest.split_once('`')) {
                named += 1;
                let goes_on = |c: char| c.is_alphanumeric() || c == '_';
                let there =
                    |what: &str| code.split(&format!("{what} {name}")).skip(1).any(|after| !after.starts_with(goes_on));
                if !["fn", "struct", "enum", "trait"].into_iter().any(there) {
                    wrong.push(format!("{}: {link} has no {name}", page.display()));
                }
                rest = more.strip_prefix(", ").unwrap_or_default();
            }
        }
    }
    assert!(wrong.is_empty() && named > 200, "{named} {}", wrong.join("\n"));
}

/// What is built is what was tested: every build that a page names takes the versions of Cargo.lock.
#[test]
fn every_documented_build_is_locked() {
    let (mut builds, mut open) = (0, Vec::new());
    for document in documents(&["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"]) {
        let text = fs::read_to_string(&document).unwrap();
        for rest in text.split("cargo ").skip(1) {
            let (command, flags) = rest.split_at(rest.find(|c: char| !c.is_ascii_lowercase()).unwrap_or(rest.len()));
            if ["bench", "build", "clippy", "doc", "install", "run", "test"].contains(&command) {
                builds += 1;
                if !flags.starts_with(" --locked") {
                    open.push(format!("{}: cargo {command}", document.display()));
                }
            }
        }
    }
    assert!(open.is_empty() && builds > 30, "{builds} {}", open.join("\n"));
}

/// What rustdoc shows of a crate has no relative links, which lead nowhere there, and names no module that is hidden.
#[test]
fn pages_of_crates_lead_somewhere_and_name_what_is_public() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut libraries = vec![root.join("src/lib.rs")];
    let crates = fs::read_dir(root.join("crates")).unwrap().map(|entry| entry.unwrap().path().join("src/lib.rs"));
    libraries.extend(crates.filter(|library| library.exists()));
    let (mut rows, mut wrong) = (0, Vec::new());
    for library in &libraries {
        let code = fs::read_to_string(library).unwrap();
        let mut page: Vec<String> =
            code.lines().filter_map(|line| line.strip_prefix("//!")).map(|line| line.trim().to_owned()).collect();
        for name in code.split("include_str!(\"").skip(1).map(|rest| rest.split('"').next().unwrap()) {
            page.extend(fs::read_to_string(library.with_file_name(name)).unwrap().lines().map(str::to_owned));
        }
        for line in page {
            let relative = line.split("](").skip(1).any(|rest| {
                let target = rest.split(')').next().unwrap();
                !target.contains("://") && (target.contains('/') || target.contains(".md"))
            });
            let hidden = |name: &str| code.lines().any(|line| line == format!("mod {name};"));
            let names = line.strip_prefix("| ").and_then(|row| row.split(" |").next()).unwrap_or_default();
            rows += usize::from(!names.is_empty());
            if relative || names.split('`').skip(1).step_by(2).any(hidden) {
                wrong.push(format!("{}: {line}", library.display()));
            }
        }
    }
    assert!(wrong.is_empty() && rows > 50 && libraries.len() > 10, "{rows} {}", wrong.join("\n"));
}

/// The page of the library shows its examples as they are: the page's are compiled and run as its documentation.
#[test]
fn the_library_s_page_shows_its_examples() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("docs/rust.md")).unwrap();
    let lines = |text: &str| -> Vec<String> {
        // One has a frame, the other is indented.
        let frame = |line: &str| ["fn main", "//!", "# ", "Ok(())"].iter().any(|begin| line.starts_with(begin));
        let own = text.lines().map(str::trim).filter(|line| !frame(line) && !["", "}"].contains(line));
        own.map(str::to_owned).collect()
    };
    let shown: Vec<_> =
        page.split("```rust\n").skip(1).map(|rest| lines(rest.split("\n```").next().unwrap())).collect();
    let programs = fs::read_dir(root.join("examples")).unwrap().map(|entry| entry.unwrap().path());
    let mut compared = 0;
    for program in programs.filter(|path| path.extension().is_some_and(|end| end == "rs")) {
        let own = lines(&fs::read_to_string(&program).unwrap());
        assert!(own.len() > 10 && shown.contains(&own), "docs/rust.md does not show {} as it is", program.display());
        compared += 1;
    }
    assert_eq!((compared, shown.len()), (4, 4));
}

/// The paper has no number of its own: each of its table's stands in the page that it names, and each of its references in its list.
#[test]
fn the_paper_s_figures_and_references_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let [paper, list] = ["paper.md", "paper.bib"].map(|name| fs::read_to_string(root.join(name)).unwrap());
    let mut figures = 0;
    for row in paper.lines().filter(|line| line.starts_with("| `")) {
        let quoted: Vec<&str> = row.split('`').skip(1).step_by(2).collect();
        let (figure, page) = (quoted[0], quoted.last().unwrap());
        assert!(fs::read_to_string(root.join(page)).unwrap().contains(figure), "{page} has no {figure}");
        figures += 1;
    }
    let cited = |key: &str| paper.contains(&format!("@{key}]")) || paper.contains(&format!("@{key};"));
    let keys = list.split("\n@").map(|entry| entry.split(['{', ',']).nth(1).unwrap());
    let (known, idle): (Vec<&str>, Vec<&str>) = keys.partition(|key| cited(key));
    let cites = paper.matches("[@").count() + paper.matches("; @").count();
    assert!(
        idle.is_empty() && figures >= 10 && known.len() >= 10 && cites >= known.len(),
        "{figures} {known:?} {idle:?} {cites}"
    );
    for key in paper.split('@').skip(1).map(|rest| rest.split([']', ';']).next().unwrap()) {
        assert!(known.contains(&key), "paper.bib has no {key}");
    }
}
