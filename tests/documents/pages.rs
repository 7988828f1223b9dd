//! Pages of the manual: every command prints what its page shows, and no page is without a command.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use vibrochain_cli::common::console::{Console, ctrl_c};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Words as a shell sees them: quotation marks hold one together.
fn words(line: &str) -> Vec<&str> {
    let parts = line.split('"').enumerate();
    parts.flat_map(|(i, part)| if i % 2 == 1 { vec![part] } else { part.split_whitespace().collect() }).collect()
}

/// What a command prints, and the table it writes. Files that are no scenes of ours lie in the folder.
fn run(line: &str, folder: &Path) -> String {
    let (line, to) = line.split_once(" > ").map_or((line, None), |(line, to)| (line, Some(folder.join(to))));
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let mut console = Console::new(&mut out, &mut err, &ctrl_c);
    let (mut arguments, mut table, mut before) = (Vec::<OsString>::new(), None, "");
    for word in words(line) {
        let is_table = before == "--out";
        before = word;
        if is_table || word.starts_with("out/") {
            let path = folder.join(word);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            arguments.push(path.clone().into());
            if is_table {
                table = Some(path);
            }
        } else {
            arguments.push(word.into());
        }
    }
    vibrochain_cli::program::run(arguments, &mut console).unwrap_or_else(|error| panic!("{line}: {error}"));
    let table = table.map_or_else(String::new, |table| fs::read_to_string(table).unwrap());
    if let Some(to) = to {
        fs::write(to, std::mem::take(&mut out)).unwrap();
    }
    [String::from_utf8(out).unwrap(), String::from_utf8(err).unwrap(), table].join("\n")
}

/// Whether a line of the page, up to its `…`, is one of the program: numbers to eleven digits.
fn shows(page: &str, line: &str) -> bool {
    let parts = |text: &str| text.split([' ', ',']).map(str::to_owned).filter(|part| !part.is_empty()).collect();
    let (page, is_cut) = page.split_once('…').map_or((page, false), |(start, _)| (start, true));
    let (shown, printed): (Vec<String>, Vec<String>) = (parts(page), parts(line));
    let number = |text: &str| text.trim_end_matches(':').parse::<f64>();
    let same = |(a, b): (&String, &String)| match (number(a), number(b)) {
        (Ok(a), Ok(b)) => (a - b).abs() <= 1e-11 * (1.0 + b.abs()) * if b.abs() > 1e3 { 100.0 } else { 1.0 },
        _ => a == b,
    };
    !shown.is_empty()
        && (shown.len() == printed.len() || is_cut && shown.len() <= printed.len())
        && shown.iter().zip(&printed).all(same)
}

/// The blocks of a page: what stands behind the three backquotes, and the text.
fn blocks(page: &str) -> impl Iterator<Item = (&str, &str)> {
    let parts = page.split("\n```").enumerate().filter(|(i, _)| i % 2 == 1);
    parts.map(|(_, part)| part.split_once('\n').unwrap_or((part, "")))
}

/// Runs a page from top to bottom; returns how many commands it has, and lines that they print.
fn check(page: &Path) -> (usize, usize) {
    let text = fs::read_to_string(page).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (mut commands, mut lines) = (0, 0);
    for (kind, block) in blocks(&text) {
        // A scene of the page's own, or one of ours as it is.
        if let Some(name) = kind.strip_prefix("toml title=\"").and_then(|rest| rest.strip_suffix('"')) {
            if name.starts_with("scenes/") {
                assert_eq!(block.trim(), fs::read_to_string(root().join(name)).unwrap().trim(), "{}", page.display());
                continue;
            }
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, block).unwrap();
        }
        if kind != "console" && !(kind == "text" && block.starts_with("$ ")) {
            continue;
        }
        let (mut printed, mut place) = (String::new(), 0);
        for line in block.replace("\\\n", " ").lines() {
            if let Some(command) = line.strip_prefix("$ ") {
                printed = run(command, folder.path());
                (commands, place) = (commands + 1, 0);
            } else {
                let found = printed.lines().skip(place).position(|own| shows(line, own));
                let found = found.unwrap_or_else(|| panic!("{}: not printed: {line}\n{printed}", page.display()));
                (lines, place) = (lines + 1, place + found + 1);
            }
        }
    }
    (commands, lines)
}

/// Every page of docs/how, and some of docs.
#[test]
fn every_command_of_the_pages_prints_what_they_show() {
    let docs = root().join("docs");
    let mut pages: Vec<PathBuf> =
        ["index.md", "start.md", "problems.md", "cluster.md", "bifurcations.md", "multibreathers.md", "fate.md"]
            .map(|name| docs.join(name))
            .into();
    pages.extend(fs::read_dir(docs.join("how")).unwrap().map(|entry| entry.unwrap().path()));
    let (mut commands, mut lines) = (0, 0);
    for page in &pages {
        let (own_commands, own_lines) = check(page);
        assert!(own_commands > 0 && own_lines > 0, "{} has no example", page.display());
        (commands, lines) = (commands + own_commands, lines + own_lines);
    }
    assert!(pages.len() > 11 && commands > 40 && lines > 120, "{} {commands} {lines}", pages.len());
}

#[test]
fn what_is_not_printed_is_found() {
    assert!(shows("  stable: spectral radius 0.5 …", "  stable: spectral radius 0.5000000000001 ± 2e-14"));
    assert!(!shows("  stable: spectral radius 0.5", "  stable: spectral radius 0.5 ± 2e-14"));
    assert!(!shows("  stable: spectral radius 0.5001 …", "  stable: spectral radius 0.5 ± 2e-14"));
    assert!(!shows("…", "anything"));
}
