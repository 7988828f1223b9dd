//! Damage to files and command lines, repeatable by its seed.

use std::ffi::OsString;

use fastrand::Rng;

/// What stands where a number or a word should.
const EXTREMES: [&str; 56] = [
    "1e308",
    "-1e308",
    "1e309",
    "-0",
    "-0.0",
    "0",
    "1",
    "-1",
    "2",
    "0.5",
    "1.5",
    "nan",
    "NaN",
    "-nan",
    "inf",
    "-inf",
    "1e-320",
    "5e-324",
    "2.2250738585072014e-308",
    "99999999999999999999",
    "-99999999999999999999",
    "9223372036854775807",
    "9223372036854775808",
    "-9223372036854775808",
    "18446744073709551615",
    "4294967296",
    "10000000",
    "10000001",
    "1e100",
    "1e-100",
    "1.0000000000000002",
    "0.9999999999999999",
    "1e50",
    "1e-50",
    "1e16",
    "1e-9",
    "1e154",
    "1e-154",
    "",
    " ",
    "0x10",
    "1_000",
    "1e",
    "+",
    "true",
    "\"\"",
    "\"0.4\"",
    "[]",
    "{}",
    "[1, 2]",
    "1979-05-27",
    "null",
    "γ₁",
    "\u{202e}٣",
    "\u{0}",
    "\u{1b}[31m",
];

/// Letters and marks that mean something to a parser, or nothing to anybody.
const MARKS: [&str; 16] =
    ["=", "[", "]", "{", "}", "\"", "'", ",", "#", "\n", "\r\n", "\u{feff}", "é", "🜁", "\\", "--"];

/// Is this part of a word or number?
fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || b"._+-".contains(&byte)
}

/// The words and numbers of a text, as ranges.
fn words(text: &[u8]) -> Vec<std::ops::Range<usize>> {
    let mut found = Vec::new();
    let mut start = None;
    for i in 0..=text.len() {
        let inside = text.get(i).is_some_and(|&byte| is_word(byte));
        match (start, inside) {
            (None, true) => start = Some(i),
            (Some(from), false) => {
                found.push(from..i);
                start = None;
            }
            _ => {}
        }
    }
    found
}

pub(crate) struct Mutator {
    pub(crate) rng: Rng,
}

impl Mutator {
    pub(crate) fn new(seed: u64) -> Self {
        Self { rng: Rng::with_seed(seed) }
    }

    pub(crate) fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.rng.usize(..from.len())]
    }

    /// A number: an extreme one, or one of any size that might well be valid.
    pub(crate) fn number(&mut self) -> String {
        let unit = self.rng.f64();
        match self.rng.u8(..8) {
            0..3 => (*self.pick(&EXTREMES)).to_owned(),
            3 => format!("{:e}", 10f64.powf(200.0 * unit - 100.0)),
            4 => format!("{:e}", 10f64.powf(12.0 * unit - 6.0)),
            5 => format!("{}", self.rng.u32(..12)),
            _ => format!("{:.3}", 2.0 * unit),
        }
    }

    /// A value of a parameter that is in its range, if barely.
    pub(crate) fn valid(&mut self, parameter: &str) -> Option<String> {
        let unit = self.rng.f64();
        let edge = self.rng.u8(..4) == 0;
        Some(match parameter {
            "sites" => self.rng.u32(1..9).to_string(),
            "asymmetry" if edge => (*self.pick(&["0", "-0", "1e-320", "1e-17", "0.9999999999999999"])).to_owned(),
            "restitution" if edge => (*self.pick(&["1", "5e-324", "1e-100", "0.9999999999999999", "1e-16"])).to_owned(),
            "asymmetry" | "restitution" => unit.to_string(),
            "omega" if edge => (*self.pick(&["1e100", "1e-100", "1e50", "1e20", "1e8", "1e-8"])).to_owned(),
            "gamma1" | "gamma2" | "amplitude" if edge => {
                (*self.pick(&["0", "-0", "1e100", "1e-100", "5e-324", "1e-320", "1e30", "1e-30", "1e-16"])).to_owned()
            }
            "omega" | "gamma1" | "gamma2" | "amplitude" => match self.rng.u8(..6) {
                0 => format!("{:e}", 10f64.powf(200.0 * unit - 100.0)),
                1 => format!("{:e}", 10f64.powf(20.0 * unit - 10.0)),
                2 => format!("{:e}", 10f64.powf(4.0 * unit - 2.0)),
                _ => format!("{:.3}", 2.0 * unit + 0.001),
            },
            _ => return None,
        })
    }

    /// A command line whose parameters are in range, and anywhere in it.
    pub(crate) fn valid_line(&mut self, arguments: &[&str]) -> Vec<OsString> {
        let mut line: Vec<OsString> = arguments.iter().map(OsString::from).collect();
        for i in 1..arguments.len() {
            if let Some(name) = arguments[i - 1].strip_prefix("--")
                && self.rng.bool()
                && let Some(value) = self.valid(name)
            {
                line[i] = value.into();
            }
        }
        line
    }

    /// A scene with all parameters in range, and anywhere in it.
    pub(crate) fn valid_scene(&mut self) -> String {
        let mut names = ["gamma1", "gamma2", "omega", "asymmetry", "amplitude", "restitution"];
        self.rng.shuffle(&mut names);
        let mut value = |name: &str| self.valid(name).unwrap_or_default();
        let (sites, mut model, mut forcing) = (value("sites"), String::new(), String::new());
        for name in &names[2..] {
            let table = if ["amplitude", "restitution"].contains(name) { &mut forcing } else { &mut model };
            table.push_str(&format!("{name} = {}\n", value(name)));
        }
        let mut axis = |name: &str| {
            let (mut from, mut to) = (value(name), value(name));
            if from.parse::<f64>().ok() > to.parse().ok() {
                std::mem::swap(&mut from, &mut to);
            }
            format!("{{ parameter = \"{name}\", from = {from}, to = {to}, points = 2 }}")
        };
        let (x, y) = (axis(names[0]), axis(names[1]));
        let stability = self.rng.bool();
        format!(
            "[model]\nsites = {sites}\n{model}[model.forcing]\n{forcing}[sweep]\nx = {x}\ny = {y}\n[compute]\n\
             families = [\"double-sided\", \"single-sided\"]\nstability = {stability}\n"
        )
    }

    /// One to three damages to a file.
    pub(crate) fn file(&mut self, text: &str) -> Vec<u8> {
        self.bytes(text.as_bytes())
    }

    /// The same, to a file that need not be text.
    pub(crate) fn bytes(&mut self, content: &[u8]) -> Vec<u8> {
        let mut bytes = content.to_vec();
        for _ in 0..self.rng.usize(1..=3) {
            self.damage(&mut bytes);
        }
        bytes
    }

    fn damage(&mut self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        let at = self.rng.usize(..bytes.len());
        let mut lines: Vec<Vec<u8>> = bytes.split_inclusive(|&byte| byte == b'\n').map(<[u8]>::to_vec).collect();
        let line = self.rng.usize(..lines.len());
        match self.rng.u8(..20) {
            0 => bytes[at] ^= 1 << self.rng.u8(..8),
            1 => bytes[at] = self.rng.u8(..),
            2 => drop(bytes.remove(at)),
            3 => bytes.truncate(at),
            4 => drop(bytes.splice(at..at, self.pick(&MARKS).bytes())),
            5 => {
                // Nested deeper than any stack allows.
                let bracket = *self.pick(&["[", "{\"a\":", "{a=", "("]);
                bytes.splice(at..at, bracket.repeat(self.rng.usize(1..3000)).bytes());
            }
            6 => {
                let copy = lines[line].clone();
                lines.insert(self.rng.usize(..=lines.len()), copy);
                *bytes = lines.concat();
            }
            7 => {
                lines.remove(line);
                *bytes = lines.concat();
            }
            8 => {
                let other = self.rng.usize(..lines.len());
                lines.swap(line, other);
                *bytes = lines.concat();
            }
            _ => {
                let words = words(bytes);
                let numbers: Vec<_> = words.iter().filter(|word| bytes[word.start].is_ascii_digit()).collect();
                // Numbers are what reaches the computation: they are met most.
                let among = if numbers.is_empty() || self.rng.u8(..4) == 0 { words.iter().collect() } else { numbers };
                if let Some(word) = among.get(self.rng.usize(..among.len().max(1))) {
                    let range = (*word).clone();
                    bytes.splice(range, self.number().bytes());
                }
            }
        }
    }

    /// Up to three damages to a command line: flags doubled, misspelt, without value, out of place; values of any kind.
    /// Paths stay in the present folder, and the program keeps its name.
    pub(crate) fn line(&mut self, arguments: &[&str]) -> Vec<OsString> {
        let mut line: Vec<Vec<u8>> = arguments.iter().skip(1).map(|argument| argument.as_bytes().to_vec()).collect();
        for _ in 0..self.rng.usize(..=3) {
            if line.is_empty() {
                break;
            }
            let at = self.rng.usize(..line.len());
            match self.rng.u8(..16) {
                0 => drop(line.remove(at)),
                1 => {
                    let copy = line[at].clone();
                    line.insert(self.rng.usize(..=line.len()), copy);
                }
                2 => {
                    let pair = line[at..(at + 2).min(line.len())].to_vec();
                    line.extend(pair);
                }
                3 => {
                    let other = self.rng.usize(..line.len());
                    line.swap(at, other);
                }
                4 => self.damage(&mut line[at]),
                5 => line.insert(at, self.number().into_bytes()),
                6 => {
                    let flags = [
                        "--json",
                        "--help",
                        "--quiet",
                        "-q",
                        "-V",
                        "--",
                        "--seed",
                        "--plot",
                        "--sites=3",
                        "--e",
                        "-x",
                        "--resume",
                        "--shard=0/2",
                    ];
                    line.insert(at, self.pick(&flags).as_bytes().to_vec());
                }
                7 if at + 1 < line.len() => {
                    let value = line.remove(at + 1);
                    line[at].push(b'=');
                    line[at].extend(value);
                }
                _ => {
                    let values: Vec<usize> = (0..line.len())
                        .filter(|&i| line[i].first().is_some_and(|&byte| byte == b'.' || byte.is_ascii_digit()))
                        .collect();
                    if !values.is_empty() {
                        let value = *self.pick(&values);
                        line[value] = self.number().into_bytes();
                    }
                }
            }
        }
        arguments.iter().take(1).map(OsString::from).chain(line.into_iter().map(local)).collect()
    }
}

/// An argument that names no folder, so that no damaged path leads out of the test's own.
fn local(mut argument: Vec<u8>) -> OsString {
    argument.iter_mut().filter(|byte| **byte == b'/' || **byte == b'\\').for_each(|byte| *byte = b'_');
    // A folder's own name, `..`, is the one way out without a stroke.
    if argument.ends_with(b"..") {
        argument.push(b'_');
    }
    #[cfg(unix)]
    return std::os::unix::ffi::OsStringExt::from_vec(argument);
    #[cfg(not(unix))]
    String::from_utf8_lossy(&argument).into_owned().into()
}
