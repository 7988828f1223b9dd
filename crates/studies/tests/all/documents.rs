//! Documents that a study prints are what it prints.

use std::fs;
use std::path::Path;

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
    let assert = vibrochain_testkit::studies(&[]).args(command.split_whitespace()).assert().success();
    let printed = String::from_utf8(assert.get_output().stdout.clone()).unwrap();
    match compare(&document(name), &printed) {
        Ok(numbers) => assert!(numbers > least, "{numbers} numbers in docs/{name}"),
        Err(difference) => panic!("docs/{name} is not what `studies {command}` prints, make it anew: {difference}"),
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

/// Maps take seconds each; what a run that has left its breather comes to is for rounding to say.
#[test]
fn the_document_of_figures_is_what_the_command_writes() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("figures.md");
    let mut studies = vibrochain_testkit::studies(&[]);
    studies.args(["figures", "--only", "1,2,3,4,5,6,7,8,9,11,12,13", "--out"]).arg(folder.path().join("figures"));
    studies.arg("--document").arg(&page).assert().success();
    let (committed, printed) = (document("figures.md"), fs::read_to_string(page).unwrap());
    let mut compared = 0;
    for section in printed.split("\n## Figure ").skip(1) {
        let heading = section.lines().next().unwrap();
        let other = committed.split("\n## Figure ").find(|other| other.lines().next() == Some(heading));
        let told = |section: &str| section.split(" periods the largest distance").next().unwrap().trim_end().to_owned();
        match compare(&told(other.unwrap_or_else(|| panic!("no {heading}"))), &told(section)) {
            Ok(numbers) => compared += numbers,
            Err(difference) => {
                panic!("docs/figures.md, figure {heading}: make it anew by `studies figures`: {difference}")
            }
        }
    }
    assert!(compared > 200, "{compared}");
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
