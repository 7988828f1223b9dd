//! Documents that a command prints are what it prints; the table of scene keys has those that a scene takes.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use vibrochain_maps::scene::Scene;

fn document(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(name)).unwrap()
}

/// A text cut into what is between its numbers and the numbers as written, without their signs.
fn cut(text: &str) -> (Vec<&str>, Vec<&str>) {
    let (mut words, mut numbers) = (Vec::new(), Vec::new());
    let mut rest = text;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let tail = &rest[start..];
        let digits = |text: &str| text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
        let mut end = digits(tail);
        if tail[end..].starts_with('.') && digits(&tail[end + 1..]) > 0 {
            end += 1 + digits(&tail[end + 1..]);
        }
        if let Some(exponent) = tail[end..].strip_prefix('e') {
            let unsigned = exponent.strip_prefix('-').unwrap_or(exponent);
            if digits(unsigned) > 0 {
                end += 1 + exponent.len() - unsigned.len() + digits(unsigned);
            }
        }
        words.push(&rest[..start]);
        numbers.push(&tail[..end]);
        rest = &tail[end..];
    }
    words.push(rest);
    (words, numbers)
}

/// Whether two numbers as written are one, but for what another machine's rounding may change.
fn same(a: &str, b: &str) -> bool {
    let value = |text: &str| text.parse::<f64>().unwrap();
    let mantissa = |text: &str| text.split('e').next().unwrap().len();
    let is_size = |text: &str| text.contains('e') && mantissa(text) == 1;
    if a == b {
        return true;
    }
    if is_size(a) && is_size(b) {
        // The size of an error: of rounding another machine has another, an order of magnitude it has not.
        let [a, b] = [a, b].map(|text| value(text).max(1e-16));
        return a.max(b) <= 10.0 * a.min(b);
    }
    if !a.contains('.') || !b.contains('.') {
        return false;
    }
    // Numbers in full agree to nine digits, others up to two of the last digit printed.
    let unit = |text: &str| {
        let (digits, power) = text.split_once('e').unwrap_or((text, "0"));
        let decimals = digits.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        10f64.powi(power.parse::<i32>().unwrap() - decimals as i32)
    };
    (value(a) - value(b)).abs() <= (2.0 * unit(a).max(unit(b))).max(1e-9 * value(a))
}

/// What differs first, and how many numbers were compared.
fn compare(committed: &str, printed: &str) -> Result<usize, String> {
    let ((words, numbers), (new_words, new_numbers)) = (cut(committed), cut(printed));
    for (i, (word, new)) in words.iter().zip(&new_words).enumerate() {
        let before = || format!("{} {}", numbers[i.saturating_sub(1)..i].join(" "), word.trim());
        if word != new {
            return Err(format!("committed {:?}, printed {new:?}", before()));
        }
        if let (Some(number), Some(new)) = (numbers.get(i), new_numbers.get(i))
            && !same(number, new)
        {
            return Err(format!("after {:?}: committed {number}, printed {new}", before()));
        }
    }
    if words.len() == new_words.len() { Ok(numbers.len()) } else { Err("one goes on".to_owned()) }
}

fn holds(command: &str, name: &str, least: usize) {
    let assert = vibrochain_testkit::mapgen(&[]).args(command.split_whitespace()).assert().success();
    let printed = String::from_utf8(assert.get_output().stdout.clone()).unwrap();
    match compare(&document(name), &printed) {
        Ok(numbers) => assert!(numbers > least, "{numbers} numbers in docs/{name}"),
        Err(difference) => panic!("docs/{name} is not what `mapgen {command}` prints, make it anew: {difference}"),
    }
}

#[test]
fn the_document_of_corrections_is_what_the_command_prints() {
    holds("errata", "errata.md", 300);
}

#[test]
fn the_document_of_validation_is_what_the_command_prints() {
    holds("validate", "validation.md", 250);
}

#[test]
fn documents_differ_by_a_word_a_digit_that_counts_or_another_size_of_an_error() {
    let text = "omega = 0.9304428418073263 ± 2e-15, 21 masses: -1.0016290 | 1.5e-3 | 60.28 |";
    assert_eq!(compare(text, text), Ok(6));
    for (from, to) in [
        ("0.9304428418073263", "0.930442841807"),
        ("2e-15", "9e-15"),
        ("2e-15", "4e-16"),
        ("1.0016290", "1.0016289"),
        ("60.28", "60.27"),
    ] {
        assert_eq!(compare(text, &text.replace(from, to)), Ok(6), "{from} {to}");
    }
    for (from, to) in [
        ("0.9304428418073263", "0.9304428518073263"),
        ("2e-15", "8e-11"),
        ("2e-15", "0.1"),
        ("1.0016290", "1.0016280"),
        ("-1.0016", "1.0016"),
        ("21 ", "22 "),
        ("masses", "sites"),
        ("1.5e-3", "1.5e-2"),
        ("60.28 |", "60.28 | 1"),
        ("60.28 |", ""),
    ] {
        assert!(compare(text, &text.replace(from, to)).is_err(), "{from} {to}");
    }
}

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
    let document = document("scenes.md");
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
        // "unknown field `zzz`, expected one of `sites`, `gamma1`, …" tells what is taken there.
        let message = parse(&text).unwrap_err().to_string();
        let message = message.lines().next().unwrap();
        assert!(message.contains("unknown field `zzz`"), "{heading}: {message}");
        let taken: BTreeSet<String> = quoted(message).filter(|key| key != "zzz").collect();
        let section = document.split(heading).nth(1).unwrap_or_else(|| panic!("no heading {heading}"));
        let section = section.split("\n#").next().unwrap();
        let rows = section.lines().filter(|line| line.starts_with("| `"));
        let told: BTreeSet<String> = rows.map(|row| quoted(row).next().unwrap()).collect();
        assert_eq!(told, taken, "{heading}");
        all.extend(taken);
    }
    assert!(all.len() > 25, "{all:?}");
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
